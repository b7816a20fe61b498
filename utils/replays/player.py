"""Player that shows a run step by step with a slider, starting where the run goes wrong."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from utils.display import show

if TYPE_CHECKING:
    from ipywidgets import Widget

STILL_PICTURES = 4  # number of pictures if there are no sliders


@dataclass(frozen=True)
class ReplayStep:
    """One step of a run.

    Attributes
    ----------
    description : str
        Description of the step in a sentence or two.
    draw : callable
        Takes a title and draws a figure.
    """

    description: str
    draw: Callable[[str], object]


@dataclass(frozen=True)
class Fault:
    """A step that is certainly wrong.

    Attributes
    ----------
    step : int
        Index of the step, from 0.
    reason : str
        Description of the mistake, with facts only.
    """

    step: int
    reason: str


@dataclass(frozen=True)
class Replay:
    """The recorded run of a function.

    Attributes
    ----------
    steps : sequence of ReplayStep
        Steps in order; empty if nothing could be observed.
    fault : Fault or None
        First mistake; None if no mistake is certain.
    remark : str
        Remark on the whole run, or the reason why there is nothing to show.
    """

    steps: Sequence[ReplayStep] = ()
    fault: Fault | None = None
    remark: str = ""


def earliest_fault(faults: Sequence[Fault]) -> Fault | None:
    """Return the earliest mistake of a run; if several share a step, the first in the list."""
    return min(faults, key=lambda fault: fault.step, default=None)


def play(run: Replay) -> None:
    """Show a run in a notebook, step by step.

    Without ipywidgets it shows a few still pictures, up to the first step that is wrong.
    """
    import ipywidgets

    if not run.steps:
        show(f"<p>{escape(run.remark)}</p>", run.remark)
        return
    count, first_shown = len(run.steps), run.fault.step + 1 if run.fault else 1

    def show_step(step: int) -> None:
        _show(run, step - 1)

    if hasattr(ipywidgets, "is_still"):
        last = first_shown if run.fault else count
        for number in np.unique(np.linspace(1, last, STILL_PICTURES).round().astype(int)):
            show_step(int(number))
    else:
        ipywidgets.interact(step=_slider(count, first_shown))(show_step)


def _show(run: Replay, position: int) -> None:
    """Show one step with its picture, its description and the remark on the run."""
    import matplotlib.pyplot as plt

    step, fault = run.steps[position], run.fault
    title = f"step {position + 1} of {len(run.steps)}"
    if fault and fault.step == position:
        title += ": the first mistake"
    step.draw(title)
    plt.show()
    html, text = f"<p>{escape(step.description)}</p>", step.description
    if fault and fault.step == position:
        html += (
            "<div style='border-left:4px solid #D55E00;padding:0.2em 0.8em'>"
            f"✗ <b>Wrong here.</b> {escape(fault.reason)}</div>"
        )
        text += f"\n✗ Wrong here. {fault.reason}"
    if run.remark:  # repeated with each step, because an export drops output before a slider
        html, text = f"{html}<p>{escape(run.remark)}</p>", f"{text}\n{run.remark}"
    show(html, text)


def _slider(count: int, initial: int) -> Widget:
    """Build a slider for the steps, with buttons for the previous and the next step."""
    import ipywidgets
    from traitlets import Int

    class Steps(ipywidgets.HBox, ipywidgets.ValueWidget):
        """Slider and buttons, combined into one widget with a value for `interact`."""

        value = Int(initial)
        description, min, max, step = "step", 1, count, 1

    narrow = {"width": "auto"}
    back = ipywidgets.Button(description="◀ back", tooltip="One step back", layout=narrow)
    forth = ipywidgets.Button(description="next ▶", tooltip="One step forward", layout=narrow)
    slider = ipywidgets.IntSlider(
        value=initial, min=1, max=count, description="step", continuous_update=False
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
