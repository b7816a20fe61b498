"""Timeline of a drive: speed over time, and each braking event with its reason and frame."""

from __future__ import annotations

import base64
import html
import io
import os
import zlib
from pathlib import Path

import numpy as np

from utils.boxes import footprints
from utils.drive.explanations import Braking
from utils.drive.film import latest_boxes, summary
from utils.drive.loop import Drive
from utils.drive.metrics import Report
from utils.drive.rules import BUMPER, CORRIDOR, STANDSTILL_GAP, stopping_distance
from utils.plots.style import BLUE, INK, MUTED, ORANGE, PAPER, VERMILION

WIDTH, HEIGHT = 720, 210
LEFT, RIGHT, TOP, BOTTOM = 62, 12, 34, 44
"""Margins of the timeline for its axes, in SVG units."""

VIEW = ((-6.0, 36.0), (-8.0, 8.0))

PAGE = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>{title}</title>
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<style>body {{ font: 1rem/1.5 system-ui, sans-serif; margin: 1rem auto; max-width: 46rem;
padding: 0 1rem }} h1 {{ font-size: 1.3rem }}</style></head>
<body><h1>{title}</h1>{body}</body></html>
"""


def html_fragment(drive: Drive, report: Report) -> str:
    """Return the timeline and the braking events as HTML without scripts, for a notebook."""
    rows = "".join(
        _braking_row(drive, braking, number)
        for number, braking in enumerate(report.brakings, start=1)
    )
    nothing = "<p>The car never braked.</p>" if not report.brakings else ""
    end = ""
    if report.collision:
        picture = _scan_picture(drive, len(drive.moments) - 1, None)
        end = (
            f"<div style='border:4px solid {VERMILION};padding:0.3em 0.8em'>"
            f"<b>{html.escape(report.collision)}</b><br>{picture}</div>"
        )
    return f"<div style='max-width:100%'>{_draw_speed(drive, report)}{nothing}{rows}{end}</div>"


def write_page(drive: Drive, report: Report, path: str | os.PathLike) -> Path:
    """Write the timeline as a standalone page that needs no network."""
    title = f"Street {drive.street.number} · {drive.street.title}"
    path = Path(path)
    path.write_text(
        PAGE.format(title=html.escape(title), body=html_fragment(drive, report)), "utf-8"
    )
    return path


def _id_suffix(drive: Drive) -> str:
    """Return a suffix that makes the HTML ids of this drive unique on a page with other drives."""
    positions = np.array([moment.position for moment in drive.moments])
    return f"{drive.street.number}-{zlib.crc32(positions.tobytes()):08x}"


def _braking_row(drive: Drive, braking: Braking, number: int) -> str:
    """Return a line of HTML that describes a braking event and expands to show its frame."""
    kind = "needless: " if braking.needless else ""
    mark = "✗" if braking.needless else "✓"
    time = f"{drive.moments[braking.first].time:.1f} s"
    picture = _scan_picture(drive, braking.scan, braking)
    return (
        f"<details><summary>{mark} {number} · {time} · {kind}{html.escape(str(braking))}"
        f"</summary><div id='braking-{_id_suffix(drive)}-{number}'>{picture}</div></details>"
    )


def _draw_speed(drive: Drive, report: Report) -> str:
    """Draw the speed over time, with numbered braking events; needless ones are hatched."""
    last = max(len(drive.moments) - 1, 1)
    top = max(36.0, 3.6 * max(moment.speed for moment in drive.moments) * 1.1)

    def across(number: float) -> float:
        return LEFT + (WIDTH - LEFT - RIGHT) * number / last

    def down(speed: float) -> float:
        return HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * 3.6 * speed / top

    token = _id_suffix(drive)
    parts = [
        f"<rect width='{WIDTH}' height='{HEIGHT}' fill='{PAPER}'/>",
        f"<defs><pattern id='needless-{token}' width='8' height='8' patternUnits='userSpaceOnUse' "
        f"patternTransform='rotate(45)'><rect width='3.5' height='8' fill='{VERMILION}'/>"
        "</pattern></defs>",
    ]
    for number, braking in enumerate(report.brakings, start=1):
        left, right = across(braking.first), across(max(braking.last, braking.first + 1))
        fill = f"url(#needless-{token})" if braking.needless else ORANGE
        box = (
            f"x='{left:.1f}' y='{TOP}' width='{right - left:.1f}' height='{HEIGHT - TOP - BOTTOM}'"
        )
        parts.append(
            # JupyterLab cannot draw an SVG link that has a plain `href`.
            f"<a xlink:href='#braking-{token}-{number}'><rect {box} fill='{fill}' "
            f"fill-opacity='0.55'><title>{html.escape(str(braking))}</title></rect>"
            f"<text x='{(left + right) / 2:.1f}' y='{TOP - 8}' text-anchor='middle' "
            f"font-weight='bold'>{'✗' if braking.needless else ''}{number}</text></a>"
        )
    limit = down(drive.street.limit)
    parts.append(
        f"<line x1='{LEFT}' x2='{WIDTH - RIGHT}' y1='{limit:.1f}' y2='{limit:.1f}' "
        f"stroke='{MUTED}' stroke-dasharray='6 5'/>"
    )
    for kilometres in range(0, int(top) + 1, 10):
        y = down(kilometres / 3.6)
        parts.append(f"<text x='{LEFT - 8}' y='{y + 6:.1f}' text-anchor='end'>{kilometres}</text>")
    seconds = last / 10
    for moment in np.arange(0, seconds + 0.01, 5 if seconds > 6 else 1).tolist():
        x = across(10 * moment)
        parts.append(
            f"<text x='{x:.1f}' y='{HEIGHT - BOTTOM + 20}' text-anchor='middle'>{moment:.0f}</text>"
        )
    points = " ".join(f"{across(m.number):.1f},{down(m.speed):.1f}" for m in drive.moments)
    parts += [
        f"<polyline points='{points}' fill='none' stroke='{BLUE}' stroke-width='3'/>",
        f"<text x='{LEFT - 14}' y='20' text-anchor='end'>km/h</text>",
        f"<text x='{WIDTH - RIGHT}' y='{HEIGHT - 5}' text-anchor='end'>seconds</text>",
    ]
    if report.collision:
        x, y = across(last) - 6, down(drive.moments[-1].speed) + 8
        parts.append(
            f"<text x='{x:.1f}' y='{y:.1f}' fill='{VERMILION}' font-size='26' "
            "font-weight='bold' text-anchor='middle'>✕</text>"
        )
    return (
        f"<svg viewBox='0 0 {WIDTH} {HEIGHT}' role='group' font-size='17' fill='{INK}' "
        f"font-family='system-ui, sans-serif' style='width:100%;max-width:{WIDTH}px' "
        f"aria-label='{html.escape(summary(drive, report), quote=True)}'>{''.join(parts)}</svg>"
    )


def _widen(rectangle: np.ndarray, margin: float) -> np.ndarray:
    """Return the corners (4, 2) of an anticlockwise rectangle with its sides moved outwards."""
    along = np.roll(rectangle, -1, axis=0) - rectangle
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-9)
    return rectangle + margin * (np.roll(along, 1, axis=0) - along)


def _scan_picture(drive: Drive, number: int, braking: Braking | None) -> str:
    """Draw a scan and return it as an HTML image; see `draw_scan`."""
    import matplotlib.pyplot as plt

    axes = draw_scan(drive, number, braking)
    buffer = io.BytesIO()
    axes.figure.savefig(buffer, format="png", dpi=90, bbox_inches="tight")
    plt.close(axes.figure)
    data = base64.b64encode(buffer.getvalue()).decode()
    words = f"frame {number} from above" + (f": {braking}" if braking else "")
    return (
        f"<img alt='{html.escape(words, quote=True)}' style='max-width:100%' "
        f"src='data:image/png;base64,{data}'>"
    )


def draw_scan(drive: Drive, number: int, braking: Braking | None = None) -> object:
    """Draw a scan from above with its boxes and the corridor, and return the axes.

    Parameters
    ----------
    drive : Drive
    number : int
        Index of the moment.
    braking : Braking, optional
        Braking event whose box is outlined and labelled.
    """
    import matplotlib.pyplot as plt

    from utils import plots

    moment, frame = drive.moments[number], drive.frame(number)
    boxes = moment.boxes if not moment.is_busy else latest_boxes(drive, moment)
    true = [box.corners for box in frame.boxes if box.kind in drive.street.road_users.values()]
    axes = plots.boxes(
        np.reshape(true, (-1, 8, 3)),
        cloud=frame.cloud[::2],
        limits=VIEW,
        reference=True,
        label="true",
        title=f"Frame {number}, {3.6 * moment.speed:.0f} km/h",
    )
    plots.boxes(boxes, axes=axes, label="found")
    reach = BUMPER + STANDSTILL_GAP + stopping_distance(moment.speed)
    corridor = plt.Rectangle(
        (BUMPER, -CORRIDOR), reach - BUMPER, 2 * CORRIDOR, fill=False, linestyle="--", color=INK
    )
    axes.add_patch(corridor)
    if braking is not None:
        start = drive.moments[braking.first]
        cause = start.decision.cause.corners + (start.position - moment.position, 0.0, 0.0)
        around = _widen(footprints(cause[None])[0], 0.15)
        axes.add_patch(plt.Polygon(around, fill=False, color=VERMILION, linewidth=3))
        high = around.max(axis=0)
        at = (min(high[0], VIEW[0][1] - 12), min(high[1] + 0.4, VIEW[1][1] - 1.5))
        paper = {"facecolor": "white", "edgecolor": "none", "pad": 1.0}
        words = "braked for this box"
        axes.text(*at, words, color=VERMILION, weight="bold", bbox=paper, zorder=8)
    return axes
