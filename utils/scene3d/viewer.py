"""The interactive view: one page of HTML that holds the scene and draws it by itself.

It needs no server, no network, no graphics card and no PyVista, so it works in JupyterLab,
VS Code and Colab and in a notebook that was saved and sent on. PyVista's own export needs
trame and twenty packages with it, 1.6 MB and one of the browser's few WebGL contexts per view.
"""

from __future__ import annotations

import base64
import html
import json
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

import numpy as np

from utils.scene3d.cameras import CAMERAS, Camera
from utils.scene3d.lettering import legend_of
from utils.scene3d.parts import LAYERS, Drawable, Faces, Label, Points, Segments, dot_size

MOST_POINTS = 20_000
STEPS = 65_535  # places along each axis: 3 mm in a cloud of 200 m

OWN = "Chosen"


def frame(
    scene: Drawable, camera: Camera, size: tuple[int, int], alt: str, instead: str = ""
) -> str:
    """The view for a notebook: a page within the page, so that neither disturbs the other.

    `instead` is HTML for readers that run no scripts, such as a notebook that is not trusted or
    one shown on GitHub. Where the view runs, it hides what stands instead of it.
    """
    width, height = size
    return (
        f'<iframe srcdoc="{html.escape(page(scene, camera, alt))}" title="{html.escape(alt)}" '
        f'width="{width}" height="{height}" style="max-width:100%;border:1px solid #A8B0B8">'
        f"</iframe><div>{instead}</div>"
    )


def page(scene: Drawable, camera: Camera, alt: str) -> str:
    """The view as a page of its own."""
    content = json.dumps(_content(scene, camera, alt), separators=(",", ":"), allow_nan=False)
    # Within a page "</script>" ends the script, wherever it stands.
    return _template().replace("SCENE", content.replace("<", "\\u003c"))


@lru_cache(maxsize=1)
def _template() -> str:
    return (Path(__file__).parent / "viewer.html").read_text("utf-8")


def _content(scene: Drawable, camera: Camera, alt: str) -> dict:
    """All that the page has to know, as JSON takes it."""
    parts = scene.all_parts
    cameras = dict(CAMERAS)
    chosen = next((name for name, known in CAMERAS.items() if known == camera), OWN)
    if chosen == OWN:
        cameras[OWN] = camera
    total = sum(len(part.xyz) for part in parts if isinstance(part, Points))
    share = min(1.0, MOST_POINTS / max(total, 1))
    return {
        "title": scene.title,
        "alt": alt,
        "note": f"{total:,} points, {share:.0%} of them shown." if share < 1 else "",
        "camera": chosen,
        "cameras": {name: _camera(known) for name, known in cameras.items()},
        "layers": list(_layers(scene)),
        "points": [_points(part, share) for part in parts if isinstance(part, Points)],
        "lines": [
            {
                "layer": part.layer,
                "ends": _packed(part.ends, "<f4"),
                "colour": part.colour,
                "width": part.width,
                "opacity": part.opacity,
            }
            for part in parts
            if isinstance(part, Segments)
        ],
        "faces": [
            {
                "layer": part.layer,
                "corners": _packed(part.triangles, "<f4"),
                "colours": _packed(part.colours, "u1"),
                "opacity": part.opacity,
            }
            for part in parts
            if isinstance(part, Faces)
        ],
        "labels": [
            {"layer": part.layer, "at": part.at.tolist(), "text": part.text, "colour": part.colour}
            for part in parts
            if isinstance(part, Label) and np.isfinite(part.at).all()
        ],
    }


def _camera(camera: Camera) -> dict:
    return {
        "position": [float(x) for x in camera.position],
        "target": [float(x) for x in camera.target],
        "up": [float(x) for x in camera.up],
        "angle": float(np.radians(camera.view_angle)),
        "from": camera.seen_from,
    }


def _layers(scene: Drawable) -> Iterator[dict]:
    """The layers that hold something, with what their parts are called."""
    for name, on in scene.switches.items():
        parts = [part for part in scene.all_parts if part.layer == name]
        if not parts:
            continue
        legend = legend_of(parts)
        title = ", ".join(text for text, _, _ in legend) or LAYERS[name]
        colour = legend[0][1] if legend else "#FFFFFF"
        yield {"name": name, "title": title, "colour": colour, "on": on}


def _points(part: Points, share: float) -> dict:
    """Points as whole steps from the lowest corner, which take half the room of floats."""
    xyz, colours = part.xyz, part.colours
    if share < 1 and len(xyz):
        # At random, as every k-th would fall in step with the beams of the scan.
        count = max(int(share * len(xyz)), 1)
        rows = np.sort(np.random.default_rng(0).choice(len(xyz), count, replace=False))
        xyz, colours = xyz[rows], colours[rows]
    low = xyz.min(axis=0).astype(float) if len(xyz) else np.zeros(3)
    high = xyz.max(axis=0).astype(float) if len(xyz) else np.zeros(3)
    step = np.maximum((high - low) / STEPS, 1e-9)
    return {
        "layer": part.layer,
        "size": max(part.size, dot_size(len(xyz))),
        "low": low.tolist(),
        "step": step.tolist(),
        "xyz": _packed(np.round((xyz - low) / step).clip(0, STEPS), "<u2"),
        "colours": _packed(colours, "u1"),
    }


def _packed(array: np.ndarray, kind: str) -> str:
    return base64.b64encode(np.ascontiguousarray(array, dtype=kind).tobytes()).decode()
