"""The player: a run, one step after another, with a slider; it begins where the run goes wrong."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from utils.display import show

if TYPE_CHECKING:
    from ipywidgets import Widget

STILL = 4  # pictures where nobody can move a slider


@dataclass(frozen=True)
class ReplayStep:
    """What happened at once.

    Attributes
    ----------
    says : str
        In a sentence or two.
    draw : callable
        Takes a title, and draws a figure.
    """

    says: str
    draw: Callable[[str], object]


@dataclass(frozen=True)
class Wrong:
    """A step that is certainly wrong: where a run goes wrong, as far as anybody can know.

    Attributes
    ----------
    step : int
        Its place among the steps.
    why : str
        What is wrong: nothing but facts.
    """

    step: int
    why: str


@dataclass(frozen=True)
class Replay:
    """What a function did.

    Attributes
    ----------
    steps : sequence of ReplayStep
        None where nothing could be seen.
    wrong : Wrong or None
        None where nothing is wrong, or nobody can know.
    remark : str
        On the run as a whole: what it did in the end, or why there is nothing to see.
    """

    steps: Sequence[ReplayStep] = ()
    wrong: Wrong | None = None
    remark: str = ""


def first_of(wrongs: Sequence[Wrong]) -> Wrong | None:
    """The one that comes first in the run; of those in one step, the first that is named."""
    return min(wrongs, key=lambda wrong: wrong.step, default=None)


def play(run: Replay) -> None:
    """Show a run in a notebook, step by step.

    Without ipywidgets there are a few still pictures, up to the first step that is wrong.
    """
    import ipywidgets

    if not run.steps:
        show(f"<p>{escape(run.remark)}</p>", run.remark)
        return
    count, begin = len(run.steps), run.wrong.step + 1 if run.wrong else 1

    def step(step: int) -> None:
        _show(run, step - 1)

    if hasattr(ipywidgets, "is_still"):
        last = begin if run.wrong else count
        for number in np.unique(np.linspace(1, last, STILL).round().astype(int)):
            step(int(number))
    else:
        ipywidgets.interact(step=_slider(count, begin))(step)


def _show(run: Replay, position: int) -> None:
    """One step: its picture, and what there is to say about it."""
    import matplotlib.pyplot as plt

    step, wrong = run.steps[position], run.wrong
    title = f"step {position + 1} of {len(run.steps)}"
    if wrong and wrong.step == position:
        title += ": here it is wrong"
    step.draw(title)
    plt.show()
    html, text = f"<p>{escape(step.says)}</p>", step.says
    if wrong and wrong.step == position:
        html += (
            "<div style='border-left:4px solid #D55E00;padding:0.2em 0.8em'>"
            f"✗ <b>Wrong here.</b> {escape(wrong.why)}</div>"
        )
        text += f"\n✗ Wrong here. {wrong.why}"
    if run.remark:  # with each step: what stands before a slider is not kept where it is exported
        html, text = f"{html}<p>{escape(run.remark)}</p>", f"{text}\n{run.remark}"
    show(html, text)


def _slider(count: int, begin: int) -> Widget:
    """A slider of steps, with a button on either side of it."""
    import ipywidgets
    from traitlets import Int

    class Steps(ipywidgets.HBox, ipywidgets.ValueWidget):
        """To `interact` it is one widget with a value."""

        value = Int(begin)
        description, min, max, step = "step", 1, count, 1

    narrow = {"width": "auto"}
    back = ipywidgets.Button(description="◀ back", tooltip="One step back", layout=narrow)
    forth = ipywidgets.Button(description="next ▶", tooltip="One step on", layout=narrow)
    slider = ipywidgets.IntSlider(
        value=begin, min=1, max=count, description="step", continuous_update=False
    )
    steps = Steps([slider, back, forth], layout={"flex_flow": "row wrap"})
    ipywidgets.link((slider, "value"), (steps, "value"))

    def move(by: int) -> Callable:
        def moved(_: object) -> None:
            slider.value = min(max(slider.value + by, 1), count)

        return moved

    back.on_click(move(-1))
    forth.on_click(move(1))
    return steps
