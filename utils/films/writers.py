"""Write images as an MP4, a GIF or a single PNG, and display the film in a notebook."""

from __future__ import annotations

import base64
import html
import importlib.util
import statistics
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from utils.scene3d.output import encode_image, reduce_colours

GIF_COLOURS = 128
MAX_EMBEDDED_BYTES = 30_000_000  # bytes; a notebook with a larger film opens slowly


@dataclass(frozen=True)
class Film:
    """A film on disk that displays itself in a notebook, or a file for other viewers.

    Attributes
    ----------
    path : Path
    frames : int
        Number of frames.
    seconds : tuple of float
        Computing time of the detector for each frame; empty without a detector.
    boxes : tuple of int
        Number of boxes found in each frame.
    problems : tuple of str
        One sentence for each frame whose scan could not be read, or in which the detector failed.
    description : str
        Description of the picture, for readers who cannot see it.
    """

    path: Path
    frames: int
    seconds: tuple[float, ...] = ()
    boxes: tuple[int, ...] = ()
    problems: tuple[str, ...] = ()
    description: str = "A film of a street, drawn from the points of a scanner."

    @property
    def recap(self) -> str:
        """Description of the film in words."""
        words = [self.description, f"{self.frames} frame{'' if self.frames == 1 else 's'}."]
        if self.boxes:
            low, high = min(self.boxes), max(self.boxes)
            number = f"{low}" if low == high else f"{low} to {high}"
            middle, slowest = 1000 * statistics.median(self.seconds), 1000 * max(self.seconds)
            words.append(
                f"{number} box{'' if high == 1 else 'es'} per frame; "
                f"detection took {middle:.0f} ms (median), at most {slowest:.0f} ms."
            )
        if self.problems:
            first = self.problems[0]
            words.append(
                f"Frames that failed: {len(self.problems)}. The first failure: "
                f"{first}{'' if first.endswith(('.', '?')) else '.'}"
            )
        return " ".join(words)

    def _repr_html_(self) -> str:
        text = html.escape(self.recap)
        if self.path.suffix not in WRITERS or self.path.stat().st_size > MAX_EMBEDDED_BYTES:
            return f"<p>{text} The file is {html.escape(str(self.path))}.</p>"
        data = base64.b64encode(self.path.read_bytes()).decode()
        if self.path.suffix == ".mp4":
            shown = (
                f'<video controls loop muted aria-label="{text}" style="max-width:100%" '
                f'src="data:video/mp4;base64,{data}"></video>'
            )
        else:
            kind = self.path.suffix[1:]
            shown = (
                f'<img alt="{text}" style="max-width:100%" src="data:image/{kind};base64,{data}">'
            )
        return f"{shown}<p>{text}</p>"


def write_mp4(path: Path, images: Iterator[np.ndarray], frames_per_second: float) -> None:
    """Write images of even width and height as H.264, which every browser plays."""
    try:
        import imageio.v2 as imageio
        import imageio_ffmpeg  # noqa: F401 (does the work)
    except ImportError:
        raise ValueError(
            "Writing MP4 needs two libraries: pip install imageio imageio-ffmpeg. "
            "A .gif needs neither."
        ) from None
    options = {"codec": "libx264", "quality": 7, "macro_block_size": 2, "ffmpeg_log_level": "error"}
    # A browser starts to play earlier if the index comes first in the file.
    options["output_params"] = ["-movflags", "+faststart"]
    writer = imageio.get_writer(path, format="FFMPEG", fps=frames_per_second, **options)
    try:
        for image in images:
            writer.append_data(image)
    finally:
        writer.close()  # also after Ctrl-C or an error, when `with` would not close the writer


def best_film_suffix() -> str:
    """Return the suffix of the best film format available here: ".mp4", or else ".gif"."""
    return ".mp4" if importlib.util.find_spec("imageio_ffmpeg") else ".gif"


def write_gif(path: Path, images: Iterator[np.ndarray], frames_per_second: float) -> None:
    """Write images with one shared palette, so that unchanged areas take almost no space."""
    first = reduce_colours(next(images), GIF_COLOURS)
    others = (reduce_colours(image, GIF_COLOURS, like=first) for image in images)
    duration = 1000 / frames_per_second
    first.save(path, save_all=True, append_images=others, loop=0, optimize=False, duration=duration)


def write_png(path: Path, images: Iterator[np.ndarray], frames_per_second: float) -> None:
    """Write the last image."""
    for image in images:
        path.write_bytes(encode_image(image, "PNG"))


WRITERS = {".mp4": write_mp4, ".gif": write_gif, ".png": write_png}
"""Functions that write a film, by file suffix."""


def write_film(path: Path, images: Iterator[np.ndarray], frames_per_second: float) -> None:
    """Write images to a file, completely or not at all.

    Raises
    ------
    ValueError
        The path has an unknown suffix.
    """
    if path.suffix not in WRITERS:
        raise ValueError(f"The name of a film must end in {', '.join(WRITERS)}, not {path.name!r}.")
    unfinished = path.with_name(f".{path.name}.part{path.suffix}")
    try:
        WRITERS[path.suffix](unfinished, images, frames_per_second)
        unfinished.replace(path)
    finally:
        unfinished.unlink(missing_ok=True)
