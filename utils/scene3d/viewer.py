"""The interactive view: one HTML page that contains the scene and the code to draw it.

The page needs no server, network, graphics card or PyVista. It therefore works in JupyterLab, VS
Code and Colab, and in a notebook that was saved and sent to another reader. PyVista's own export
needs trame and twenty further packages, and each exported view takes 1.6 MB and one of the
browser's few WebGL contexts.
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

MAX_POINTS = 20_000
STEPS = 65_535  # per axis, the most that 16 bits allow; 3 mm in a cloud of 200 m

OWN = "Chosen"


def frame(
    scene: Drawable, camera: Camera, size: tuple[int, int], alt: str, instead: str = ""
) -> str:
    """Return the view for a notebook as an iframe, so that view and notebook are isolated.

    `instead` is HTML for places without scripts, such as GitHub or a notebook that is not trusted.
    When the view runs, it hides this HTML.
    """
    width, height = size
    return (
        f'<iframe srcdoc="{html.escape(page(scene, camera, alt))}" title="{html.escape(alt)}" '
        f'width="{width}" height="{height}" style="max-width:100%;border:1px solid #A8B0B8">'
        f"</iframe><div>{instead}</div>"
    )


def page(scene: Drawable, camera: Camera, alt: str) -> str:
    """Return the view as a complete HTML page."""
    content = json.dumps(_content(scene, camera, alt), separators=(",", ":"), allow_nan=False)
    # The text "</script>" ends a script even inside a string.
    return _template().replace("SCENE", content.replace("<", "\\u003c"))


@lru_cache(maxsize=1)
def _template() -> str:
    return (Path(__file__).parent / "viewer.html").read_text("utf-8")


def _content(scene: Drawable, camera: Camera, alt: str) -> dict:
    """Return the data of the page as values that JSON can represent."""
    parts = scene.all_parts
    cameras = dict(CAMERAS)
    chosen = next((name for name, preset in CAMERAS.items() if preset == camera), OWN)
    if chosen == OWN:
        cameras[OWN] = camera
    total = sum(len(part.xyz) for part in parts if isinstance(part, Points))
    share = min(1.0, MAX_POINTS / max(total, 1))
    return {
        "title": scene.title,
        "alt": alt,
        "note": f"{share:.0%} of {total:,} points shown." if share < 1 else "",
        "camera": chosen,
        "cameras": {name: _camera(preset) for name, preset in cameras.items()},
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
    """Yield the layers that have parts, with the names of the parts as title."""
    for name, on in scene.switches.items():
        parts = [part for part in scene.all_parts if part.layer == name]
        if not parts:
            continue
        legend = legend_of(parts)
        title = ", ".join(text for text, _, _ in legend) or LAYERS[name]
        colour = legend[0][1] if legend else "#FFFFFF"
        yield {"name": name, "title": title, "colour": colour, "on": on}


def _points(part: Points, share: float) -> dict:
    """Return points as 16-bit steps from the lowest corner, which take half the space of floats.

    `share` is the proportion of the points to include, from 0 to 1.
    """
    xyz, colours, size = part.xyz, part.colours, part.size
    if share < 1 and len(xyz):
        # A random choice, because every k-th point could coincide with the order of the beams.
        count = max(int(share * len(xyz)), 1)
        rows = np.sort(np.random.default_rng(0).choice(len(xyz), count, replace=False))
        xyz, colours, size = xyz[rows], colours[rows], max(size, dot_size(count))
    low = xyz.min(axis=0).astype(float) if len(xyz) else np.zeros(3)
    high = xyz.max(axis=0).astype(float) if len(xyz) else np.zeros(3)
    step = np.maximum((high - low) / STEPS, 1e-9)
    return {
        "layer": part.layer,
        "size": size,
        "low": low.tolist(),
        "step": step.tolist(),
        "xyz": _packed(np.round((xyz - low) / step).clip(0, STEPS), "<u2"),
        "colours": _packed(colours, "u1"),
    }


def _packed(array: np.ndarray, kind: str) -> str:
    return base64.b64encode(np.ascontiguousarray(array, dtype=kind).tobytes()).decode()
