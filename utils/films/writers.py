"""Pictures one after the other: written as MP4, GIF or a single PNG, and shown in a notebook."""

from __future__ import annotations

import base64
import html
import importlib.util
import statistics
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from utils.scene3d.output import encoded, in_few_colours

COLOURS_OF_A_GIF = 128
MOST_EMBEDDED = 30_000_000  # bytes: a notebook with more of them opens slowly


@dataclass(frozen=True)
class Film:
    """A film on disk; in a notebook it shows itself.

    Attributes
    ----------
    path : Path
    frames : int
    seconds : tuple of float
        How long the detector took for each frame; empty without one.
    boxes : tuple of int
        How many boxes it found in each frame.
    problems : tuple of str
        One sentence for each frame in which it failed.
    seen : str
        What kind of picture it is, for those who cannot see it.
    """

    path: Path
    frames: int
    seconds: tuple[float, ...] = ()
    boxes: tuple[int, ...] = ()
    problems: tuple[str, ...] = ()
    seen: str = "A film of a street, drawn from the points of a scanner."

    @property
    def recap(self) -> str:
        """The film in words."""
        words = [self.seen, f"{self.frames} frame{'' if self.frames == 1 else 's'}."]
        if self.boxes:
            low, high = min(self.boxes), max(self.boxes)
            number = f"{low}" if low == high else f"{low} to {high}"
            middle, slowest = 1000 * statistics.median(self.seconds), 1000 * max(self.seconds)
            words.append(
                f"{number} box{'' if high == 1 else 'es'} per frame; "
                f"detection took {middle:.0f} ms (median), at most {slowest:.0f} ms."
            )
        if self.problems:
            words.append(
                f"The detector failed in {len(self.problems)} of them; first: {self.problems[0]}."
            )
        return " ".join(words)

    def _repr_html_(self) -> str:
        text = html.escape(self.recap)
        if self.path.stat().st_size > MOST_EMBEDDED:
            return f"<p>{text} The film is in {html.escape(str(self.path))}.</p>"
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
    # A player on a page starts sooner when the table of contents comes first.
    options["output_params"] = ["-movflags", "+faststart"]
    writer = imageio.get_writer(path, format="FFMPEG", fps=frames_per_second, **options)
    try:
        for image in images:
            writer.append_data(image)
    finally:
        writer.close()  # after Ctrl-C, too, which `with` leaves to whenever the writer is collected


def suffix_of_films() -> str:
    """The better kind of film that can be written here: ".mp4", or ".gif"."""
    return ".mp4" if importlib.util.find_spec("imageio_ffmpeg") else ".gif"


def write_gif(path: Path, images: Iterator[np.ndarray], frames_per_second: float) -> None:
    """Write images with one palette for all: what stands still costs next to nothing then."""
    first = in_few_colours(next(images), COLOURS_OF_A_GIF)
    others = (in_few_colours(image, COLOURS_OF_A_GIF, like=first) for image in images)
    duration = 1000 / frames_per_second
    first.save(path, save_all=True, append_images=others, loop=0, optimize=False, duration=duration)


def write_png(path: Path, images: Iterator[np.ndarray], frames_per_second: float) -> None:
    """Write the last of the images."""
    for image in images:
        path.write_bytes(encoded(image, "PNG"))


WRITERS = {".mp4": write_mp4, ".gif": write_gif, ".png": write_png}
"""What writes a film, by the suffix of its file."""


def write_film(path: Path, images: Iterator[np.ndarray], frames_per_second: float) -> None:
    """Write images into a file, wholly or not at all.

    Raises
    ------
    ValueError
        The path has an ending that no writer knows.
    """
    if path.suffix not in WRITERS:
        raise ValueError(f"{path.name}: films end in {', '.join(WRITERS)}.")
    unfinished = path.with_name(f".{path.name}.part{path.suffix}")
    try:
        WRITERS[path.suffix](unfinished, images, frames_per_second)
        unfinished.replace(path)
    finally:
        unfinished.unlink(missing_ok=True)
