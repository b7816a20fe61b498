"""The drawing as a widget: the browser sends positions, and Python sends back what to draw.

The browser (`by_hand.js`) sends its next message only after the answer to the previous one, so a
slow function never works through a queue of old positions.
"""

from __future__ import annotations

import base64
import html
import io
import uuid
from collections.abc import Callable
from pathlib import Path
from typing import Any

import anywidget
import traitlets
from IPython.display import display
from IPython.utils.capture import capture_output

from utils.by_hand.drawing import Board, Drawing
from utils.by_hand.still import draw_still
from utils.checks.tips import locate
from utils.display import show
from utils.plots import style

COLOURS = ("PAPER", "INK", "MUTED", "PALE", "GRID", "BLUE", "GREEN", "ORANGE")


class HandWidget(anywidget.AnyWidget):
    """A drawing whose points or circle the student drags.

    Parameters
    ----------
    draw : callable
        Takes `Board.arguments`, and returns a `Drawing`.
    board : Board
        The things to drag, at the start.
    still : str
        Class of the HTML element that the drawing replaces.

    Attributes
    ----------
    board : dict
        Everything that stays the same, for the browser.
    answer : dict
        What to draw at the positions that the browser sent last; see `answer_to`.
    """

    _esm = Path(__file__).with_name("by_hand.js").read_text("utf-8")
    board = traitlets.Dict().tag(sync=True)
    answer = traitlets.Dict().tag(sync=True)

    def __init__(self, draw: Callable[..., Drawing], board: Board, still: str = "") -> None:
        super().__init__(
            board={
                "limits": board.limits.tolist(),
                "points": board.points.tolist(),
                "circle": board.circle,
                "movable": list(board.movable),
                "canAdd": board.can_add,
                "still": still,
                "largestRadius": board.largest_radius,
                "colours": {name.lower(): getattr(style, name) for name in COLOURS},
            }
        )

        def receive(_: object, message: dict, __: object) -> None:
            self.answer = answer_to(message, draw, board)

        self.on_msg(receive)


def answer_to(message: dict, draw: Callable[..., Drawing], board: Board) -> dict[str, Any]:
    """Call the student's function at the positions that the browser sent.

    Parameters
    ----------
    message : dict
        ``request``, any value; ``points``, a list of [x, y]; and ``circle``, [x, y, radius] or
        None, all in metres.
    draw : callable
        Takes `Board.arguments`, and returns a `Drawing`.
    board : Board
        The things to drag, at the start.

    Returns
    -------
    dict
        The message with ``shapes``, from `Drawing.shapes`, and ``problem``, a sentence about an
        exception. Either is empty.
    """
    shapes, problem = {}, ""
    try:
        now = board.moved(message["points"], message["circle"])
        with capture_output():  # it belongs to no cell
            shapes = draw(*now.arguments).shapes(now)
    except KeyboardInterrupt:
        problem = "You stopped the function before it returned."
    except Exception as error:
        problem = describe_problem(error, draw)
    return {**message, "shapes": shapes, "problem": problem}


def describe_problem(error: Exception, draw: Callable[..., Drawing]) -> str:
    """Return a sentence about an exception, with its place in the student's code if it has one."""
    if isinstance(error, NotImplementedError) and str(error):
        return str(error)  # it says which function is not written yet
    name, place, _ = locate(error, draw)
    sentence = f"{name or 'The function'} raised {type(error).__name__}: {error}"
    return f"{sentence} ({place})" if place else sentence


def show_widget(draw: Callable[..., Drawing], board: Board) -> None:
    """Show the drawing as a figure, and as a widget that hides the figure once Python answers it.

    In an exported page, and in a notebook without its kernel, the figure stays.
    """
    import matplotlib.pyplot as plt

    axes = draw_still(board, draw(*board.arguments))
    buffer = io.BytesIO()
    axes.figure.savefig(buffer, format="png", dpi=90, bbox_inches="tight")
    plt.close(axes.figure)
    data, title = base64.b64encode(buffer.getvalue()).decode(), axes.get_title(loc="left")
    still = f"still-{uuid.uuid4().hex}"
    show(
        f'<div class="{still}"><img alt="{html.escape(title, quote=True)}" '
        f'style="max-width:100%" src="data:image/png;base64,{data}"></div>',
        title,
    )
    display(HandWidget(draw, board, still))
