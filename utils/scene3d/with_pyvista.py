"""Renderer based on PyVista: pictures without a screen, and windows on a screen."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from utils.plots.style import INK, PAPER
from utils.scene3d.cameras import CAMERAS, Camera
from utils.scene3d.eye_dome import eye_dome
from utils.scene3d.lettering import write
from utils.scene3d.opengl import silence_stderr, without_screen
from utils.scene3d.parts import Drawable, Faces, Label, Part, Points, Segments

if TYPE_CHECKING:
    import pyvista

WIDENING = 2
"""Factor by which dots and lines are widened, because supersampling makes them thinner."""


class Studio:
    """An off-screen renderer for any number of pictures.

    Close it after use, or use it in a ``with`` statement.

    Parameters
    ----------
    size : (int, int)
        Width and height of the pictures in pixels.
    """

    def __init__(self, size: tuple[int, int]) -> None:
        import pyvista

        with without_screen():
            self.plotter = pyvista.Plotter(
                off_screen=True, window_size=list(size), lighting="none", notebook=False
            )
        self.plotter.set_background(PAPER)
        self.plotter.enable_anti_aliasing("ssaa")
        self.size = size

    def picture(self, scene: Drawable, camera: Camera) -> np.ndarray:
        """Draw a scene and return the picture as a uint8 array (height, width, 3)."""
        self.plotter.clear_actors()
        for part in scene.parts:
            add(self.plotter, part, WIDENING)
        aim(self.plotter, camera)
        with without_screen():
            self.plotter.render()
            image = np.array(self.plotter.screenshot(return_img=True))
            image = eye_dome(image, self._depth())
        return write(image, scene.parts, camera, scene.title, scene.caption)

    def _depth(self) -> np.ndarray:
        """Return the depth in metres (height, width) of each pixel; infinite for background."""
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkCommonCore import vtkFloatArray

        width, height = self.size
        values = vtkFloatArray()
        self.plotter.render_window.GetZbufferData(0, 0, width - 1, height - 1, values)
        fractions = vtk_to_numpy(values).reshape(height, width)[::-1]
        near, far = self.plotter.camera.clipping_range
        depth = near * far / (far - fractions * (far - near))
        return np.where(fractions < 1.0, depth, np.inf)

    def close(self) -> None:
        """Close the plotter and free its memory."""
        with silence_stderr():
            self.plotter.close()

    def __enter__(self) -> Studio:
        return self

    def __exit__(self, *problem: object) -> None:
        self.close()


class Window:
    """A window on the screen that shows a series of scenes.

    The mouse rotates and zooms. F1 to F4 choose a camera, the space bar pauses or continues, and
    q closes the window.

    Attributes
    ----------
    is_paused : bool
        Whether the user has paused.
    is_open : bool
        Whether the window is still open.
    """

    def __init__(self, size: tuple[int, int], camera: Camera) -> None:
        import pyvista

        self.plotter = pyvista.Plotter(window_size=list(size), lighting="none", notebook=False)
        self.plotter.set_background(PAPER)
        self.is_paused, self.is_open = False, True
        for number, preset in enumerate(CAMERAS.values(), start=1):
            # The digits 1 to 4 are not used, because 3 toggles VTK's red and blue stereo view.
            self.plotter.add_key_event(f"F{number}", _camera_setter(self.plotter, preset))
        self.plotter.add_key_event("space", self._toggle_pause)
        self.plotter.iren.add_observer("ExitEvent", self._mark_closed)  # q or the close button
        aim(self.plotter, camera)

    def show_scene(self, scene: Drawable) -> None:
        """Replace the scene, but keep the view that the user has chosen."""
        self.plotter.clear_actors()
        for part in scene.parts:
            add(self.plotter, part)
        _add_labels(self.plotter, scene)
        self.plotter.reset_camera_clipping_range()
        if not self.plotter.iren.initialized:
            self.plotter.show(interactive_update=True, auto_close=False)
        self.refresh()

    def refresh(self) -> None:
        """Process mouse and keyboard events."""
        if self.is_open:
            self.plotter.update()

    def wait_until_closed(self) -> None:
        """Keep the window open until the user closes it."""
        if self.is_open:
            self.plotter.iren.start()

    def close(self) -> None:
        """Close the window."""
        self.plotter.close()

    def _toggle_pause(self) -> None:
        self.is_paused = not self.is_paused

    def _mark_closed(self, *event: object) -> None:
        self.is_open = False
        self.plotter.iren.terminate_app()


def aim(plotter: pyvista.Plotter, camera: Camera) -> None:
    """Apply a camera to the plotter."""
    plotter.camera_position = [camera.position, camera.target, camera.up]
    plotter.camera.view_angle = camera.view_angle
    plotter.reset_camera_clipping_range()


def add(plotter: pyvista.Plotter, part: Part, widening: float = 1) -> None:
    """Add a part to the plotter, with dots and lines `widening` times as wide; skip labels."""
    import pyvista

    if isinstance(part, Label):
        return
    options = {"lighting": False, "reset_camera": False, "show_scalar_bar": False, "render": False}
    if isinstance(part, Points) and len(part.xyz):
        plotter.add_mesh(
            pyvista.PolyData(part.xyz),
            scalars=part.colours,
            rgb=True,
            style="points",
            point_size=widening * part.size,
            **options,
        )
    elif isinstance(part, Segments) and len(part.ends):
        ends = part.ends.reshape(-1, 3).astype(np.float32)
        pairs = np.arange(len(ends)).reshape(-1, 2)
        lines = np.column_stack([np.full(len(pairs), 2), pairs])
        plotter.add_mesh(
            pyvista.PolyData(ends, lines=lines),
            color=part.colour,
            line_width=widening * part.width,
            opacity=part.opacity,
            **options,
        )
    elif isinstance(part, Faces) and len(part.triangles):
        plotter.add_mesh(
            pyvista.PolyData.from_regular_faces(
                part.triangles.reshape(-1, 3).astype(np.float32),
                np.arange(3 * len(part.triangles)).reshape(-1, 3),
            ),
            scalars=part.colours,
            rgb=True,
            opacity=part.opacity,
            **options,
        )


def _add_labels(plotter: pyvista.Plotter, scene: Drawable) -> None:
    """Add title, caption, and labels that keep facing the camera when it rotates."""
    labels = [part for part in scene.parts if isinstance(part, Label)]
    if labels:
        plotter.add_point_labels(
            np.array([label.at for label in labels]),
            [label.text for label in labels],
            always_visible=True,
            show_points=False,
            shape_color=PAPER,
            shape_opacity=0.85,
            text_color=INK,
            font_size=14,
            reset_camera=False,
            render=False,
        )
    text = "\n".join(line for line in (scene.title, scene.caption) if line)
    if text:
        plotter.add_text(text, position="upper_left", font_size=10, color=INK, render=False)


def _camera_setter(plotter: pyvista.Plotter, camera: Camera) -> Callable[[], None]:
    return lambda: aim(plotter, camera)
