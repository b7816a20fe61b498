"""Title, legend, labels and caption, drawn into a finished picture with Pillow."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path

import matplotlib
import numpy as np
from PIL import Image, ImageColor, ImageDraw, ImageFont

from utils.plots.style import INK, PAPER
from utils.scene3d.cameras import NEAREST, Camera
from utils.scene3d.parts import Label, Part, Points, Segments

MARGIN = 10


@lru_cache(maxsize=16)
def font(size: int, bold: bool = False) -> ImageFont.FreeTypeFont:
    """Return matplotlib's default font, which comes with every installation."""
    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return ImageFont.truetype(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / name, size)


def legend_of(parts: Iterable[Part]) -> list[tuple[str, str, str]]:
    """Return legend entries (text, "#RRGGBB", kind) for all parts that have a name.

    The kind is "dot", "line", "dashes" or "area". Each kind has its own shape in the legend, so
    that colour is not the only difference.
    """
    entries = []
    for part in parts:
        if not getattr(part, "name", ""):
            continue
        if isinstance(part, Segments):
            entries.append((part.name, part.colour, "dashes" if part.is_dashed else "line"))
            continue
        # For a part with many colours, the legend shows the colour in the middle of the array.
        colours = part.colours if len(part.colours) else [(0, 0, 0)]
        colour = "#{:02X}{:02X}{:02X}".format(*colours[len(colours) // 2])
        entries.append((part.name, colour, "dot" if isinstance(part, Points) else "area"))
    return entries


def write(
    image: np.ndarray, parts: Iterable[Part], camera: Camera, title: str = "", caption: str = ""
) -> np.ndarray:
    """Return an image (height, width, 3) with labels, title, legend and caption.

    Labels are visible even if something is in front of them. Title and legend are at the top, and
    the caption is at the bottom.
    """
    parts = list(parts)
    height, width = image.shape[:2]
    picture = Image.fromarray(image)
    draw = ImageDraw.Draw(picture, "RGBA")
    font_size = max(11, round(height / 38))
    _write_labels(draw, parts, camera, (width, height), font(font_size, bold=True))
    down = MARGIN
    if title:
        down = _write_line(draw, (MARGIN, down), title, font(font_size + 2, bold=True))
    _write_legend(draw, down, width, legend_of(parts), font(font_size))
    if caption:
        _write_line(draw, (MARGIN, height - MARGIN - font_size - 4), caption, font(font_size))
    return np.asarray(picture)


def _write_labels(
    draw: ImageDraw.ImageDraw,
    parts: Iterable[Part],
    camera: Camera,
    size: tuple[int, int],
    font: ImageFont.FreeTypeFont,
) -> None:
    """Draw the labels, the nearest first, and leave out those that would cover another label."""
    labels = [part for part in parts if isinstance(part, Label)]
    if not labels:
        return
    seen = camera.to_camera(np.array([label.at for label in labels]))
    places = camera.to_pixels(seen, size)
    occupied = np.empty((0, 4))
    for row in np.argsort(seen[:, 2], kind="stable"):
        place, text = tuple(places[row].tolist()), labels[row].text
        if seen[row, 2] <= NEAREST or not (0 <= place[0] < size[0] and 0 <= place[1] < size[1]):
            continue
        left, top, right, bottom = draw.textbbox(place, text, font=font, anchor="ms")
        area = np.array([left - 3, top - 3, right + 3, bottom + 3])
        if ((area[:2] < occupied[:, 2:]) & (occupied[:, :2] < area[2:])).all(axis=1).any():
            continue
        occupied = np.vstack([occupied, area])
        draw.rounded_rectangle(area.tolist(), 3, (255, 255, 255, 215))
        draw.text(place, text, fill=labels[row].colour, font=font, anchor="ms")


def _write_line(
    draw: ImageDraw.ImageDraw, place: tuple[float, float], text: str, font: ImageFont.FreeTypeFont
) -> float:
    """Draw a line of text on a white background; return the y coordinate of the next line."""
    left, top, right, bottom = draw.textbbox(place, text, font=font)
    draw.rectangle((left - 4, top - 3, right + 4, bottom + 3), (255, 255, 255, 215))
    draw.text(place, text, fill=INK, font=font)
    return bottom + 8


def _write_legend(
    draw: ImageDraw.ImageDraw,
    down: float,
    width: int,
    entries: Iterable[tuple[str, str, str]],
    font: ImageFont.FreeTypeFont,
) -> None:
    across = MARGIN
    for text, colour, kind in entries:
        entry_width = 24 + draw.textlength(text, font=font)
        if across > MARGIN and across + entry_width > width - MARGIN:
            across, down = MARGIN, down + font.size + 8
        middle = down + font.size * 0.6
        draw.rectangle(
            (across - 4, down - 2, across + entry_width, down + font.size + 4), (255, 255, 255, 215)
        )
        if kind in ("line", "dashes"):
            for start in (0, 11) if kind == "dashes" else (0, 5.5, 11):
                draw.line((across + start, middle, across + start + 5.5, middle), colour, 3)
        elif kind == "dot":
            draw.ellipse((across + 4, middle - 4, across + 12, middle + 4), colour, PAPER)
        else:
            pale = (*ImageColor.getrgb(colour), 90)
            draw.rectangle((across + 2, middle - 5, across + 14, middle + 5), pale, colour)
        draw.text((across + 21, down), text, fill=INK, font=font)
        across += entry_width + 16
