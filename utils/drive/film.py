"""Films of a drive: seen from behind and above, with boxes, corridor, speed and brake."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from utils.drive.loop import Drive, Moment
from utils.drive.metrics import Report
from utils.drive.rules import BUMPER, CORRIDOR, HALF_WIDTH, STANDSTILL_GAP, TAIL, stopping_distance
from utils.films.film import SIZE, open_renderer
from utils.films.writers import Film, write_film
from utils.plots.style import GREEN, INK, PAPER, VERMILION
from utils.progress import progress
from utils.scene3d import Scene
from utils.scene3d.cameras import Camera
from utils.scene3d.lettering import font

BEHIND = Camera((-13.0, 0.0, 8.0), (9.0, 0.0, -1.5), seen_from="from behind and above")
MOMENTS_PER_PICTURE = 2
"""Number of moments from one picture to the next."""

ROAD_HEIGHT = -1.73
PICTURES_OF_COLLISION = 10
"""Number of pictures for which the film stops at a collision."""


def make_film(
    drive: Drive,
    report: Report,
    path: str | os.PathLike,
    *,
    size: tuple[int, int] = SIZE,
    renderer: str | None = None,
) -> Film:
    """Make a film of a drive and show a progress bar.

    Parameters
    ----------
    drive : Drive
    report : Report
        Report on this drive.
    path : str or path
        Ends in .mp4 or .gif for a film, or in .png for a picture of the last moment.
    size : (int, int)
        Width and height in pixels, rounded down to even numbers.
    renderer : {"pyvista", "matplotlib"}, optional
        By default PyVista if it can draw here, else matplotlib.
    """
    path = Path(path)
    size = tuple(int(length) // 2 * 2 for length in size)
    numbers = list(range(0, len(drive.moments), MOMENTS_PER_PICTURE))
    if path.suffix == ".png" or numbers[-1] != len(drive.moments) - 1:
        numbers = (numbers if path.suffix != ".png" else []) + [len(drive.moments) - 1]

    def images() -> Iterator[np.ndarray]:
        with open_renderer(size, BEHIND, renderer) as take:
            for number in progress(numbers, f"Recording {path.name}"):
                picture = draw_dashboard(
                    take(scene_of(drive, report, number)), drive.moments[number]
                )
                yield picture
            if report.collision and path.suffix != ".png":
                yield from [draw_end_frame(picture)] * PICTURES_OF_COLLISION

    write_film(path, images(), 10.0 / MOMENTS_PER_PICTURE)
    return Film(path, len(numbers), description=summary(drive, report))


def summary(drive: Drive, report: Report) -> str:
    """Describe the film in words, for readers who cannot see it."""
    words = [
        f"A drive through street {drive.street.number} ({drive.street.title[0].lower()}"
        f"{drive.street.title[1:]}), seen from behind and above: {report.metres:.0f} m."
    ]
    words += [f"The car brakes: {braking}." for braking in report.brakings]
    return " ".join([*words, report.collision]).strip()


def scene_of(drive: Drive, report: Report, number: int) -> Scene:
    """Build a scene from the scan of a moment, with boxes, corridor and the reason for braking."""
    moment, street = drive.moments[number], drive.street
    scene = Scene(f"Street {street.number} · {street.title}")
    scene.add_cloud(drive.frame(number).cloud)
    boxes = moment.boxes if not moment.is_busy else latest_boxes(drive, moment)
    scene.add_oriented_boxes(boxes, name="boxes of the detector")
    scene.add_ego_car((TAIL, -HALF_WIDTH, ROAD_HEIGHT + 0.2), (BUMPER, HALF_WIDTH, -0.3))
    reach = BUMPER + STANDSTILL_GAP + stopping_distance(moment.speed)
    colour, width = (VERMILION, 5.0) if moment.is_braking else (GREEN, 3.0)
    name = "corridor: braking" if moment.is_braking else "corridor: free"
    scene.add_lines(_corridor(reach, street.slope), colour=colour, width=width, name=name)
    scene.caption = caption(report, moment)
    return scene


def latest_boxes(drive: Drive, moment: Moment) -> np.ndarray:
    """Return the latest answer's boxes (N, 8, 3), relative to the car's current position."""
    if moment.latest_scan is None:
        return moment.boxes
    before = drive.moments[moment.latest_scan]
    return before.boxes - (moment.position - before.position, 0.0, 0.0)


def caption(report: Report, moment: Moment) -> str:
    """Return a caption with the frame, time and speed of a moment, and the reason for braking."""
    words = [f"frame {moment.number}", f"{moment.time:.1f} s", f"{3.6 * moment.speed:.0f} km/h"]
    now = [braking for braking in report.brakings if braking.first <= moment.number <= braking.last]
    words += [f"{'needless: ' if braking.needless else ''}{braking.reason}" for braking in now]
    return " · ".join(words)


def _corridor(reach: float, slope: float) -> np.ndarray:
    """Return the edges (3, 2, 3) of the corridor on the road, from the bumper to x = `reach`."""
    corners = np.array(
        [
            (x, y, ROAD_HEIGHT + slope * x + 0.05)
            for x in (BUMPER, reach)
            for y in (-CORRIDOR, CORRIDOR)
        ]
    )
    return corners[[[0, 2], [1, 3], [2, 3]]]


def draw_dashboard(image: np.ndarray, moment: Moment) -> np.ndarray:
    """Draw the speed as a bar on a picture, and a sign with the deceleration while braking."""
    height, width = image.shape[:2]
    picture = Image.fromarray(image)
    draw = ImageDraw.Draw(picture, "RGBA")
    letter = max(12, height // 26)
    write: ImageFont.FreeTypeFont = font(letter, bold=True)
    right, bottom = width - 12, height - 12
    text = f"{3.6 * moment.speed:.0f} km/h"
    draw.text((right, bottom), text, INK, write, "rs", stroke_width=3, stroke_fill=PAPER)
    top, left = bottom - 1.6 * letter, right - 8 * letter
    share = min(moment.speed / (50 / 3.6), 1.0)
    draw.rectangle((left, top - 0.5 * letter, right, top), outline=INK, fill=PAPER)
    draw.rectangle((left, top - 0.5 * letter, left + share * (right - left), top), fill=INK)
    if moment.acceleration < -1.0:
        spot = (left, top - 2.3 * letter, right, top - 0.8 * letter)
        draw.rectangle(spot, fill=VERMILION, outline=INK)
        middle = ((left + right) / 2, top - 1.55 * letter)
        words = f"BRAKE {-moment.acceleration:.0f} m/s²"
        draw.text(middle, words, PAPER, write, "mm")
    return np.asarray(picture)


def draw_end_frame(image: np.ndarray) -> np.ndarray:
    """Draw a red frame and the words "The drive ends here" on a picture."""
    picture = Image.fromarray(image)
    draw = ImageDraw.Draw(picture)
    width, height = picture.size
    draw.rectangle((0, 0, width - 1, height - 1), outline=VERMILION, width=max(6, height // 45))
    letter = height // 16
    middle = (width / 2, height / 6)
    draw.text(
        middle, "The drive ends here", VERMILION, font(letter, True), "mm",
        stroke_width=4, stroke_fill=PAPER,
    )  # fmt: skip
    return np.asarray(picture)
