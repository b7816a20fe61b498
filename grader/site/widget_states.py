"""Runs in the kernel of a solved notebook: what needs a kernel to be seen is written down as data.

A slider becomes its picture at a few of its positions, a prediction its question and its answer,
and a figure says in words what it shows. `grader.site.html_outputs` makes pages of that.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ipywidgets import Widget
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.legend import Legend

POSITION = "application/vnd.lidar-obstacle-lab.position+json"
QUESTION = "application/vnd.lidar-obstacle-lab.question+json"
ANSWER = "application/vnd.lidar-obstacle-lab.answer+json"
POSITIONS = {1: 4, 2: 3}  # beside the one that the lesson sets, of each of so many sliders
FEW_POSITIONS = 2  # of each of more
TITLES = ("left", "center", "right")  # where an axes may have one


def record() -> None:
    """From now on, write down instead of asking."""
    import ipywidgets
    from IPython import get_ipython

    from utils import predictions

    ipywidgets.interact = interact
    predictions.predict = predict
    predictions.Prediction.compare = compare
    shell = get_ipython()
    shell.run_line_magic("matplotlib", "inline")
    _describe_figures(shell)


def interact(**sliders: Widget) -> Callable[[Callable], Callable]:
    """As `ipywidgets.interact`, and shows what is drawn at each of `positions`."""

    def run(function: Callable) -> Callable:
        for about, values in positions(sliders):
            said = ", ".join(f"{name} {value:g}" for name, value in values.items())
            _display(POSITION, about, said)
            function(**values)
        return function

    return run


def positions(sliders: dict[str, Widget]) -> Iterator[tuple[dict, dict]]:
    """What each position is called, and its values: first the lesson's own, then others.

    Parameters
    ----------
    sliders : dict of str to ipywidgets.Widget
        By the name of the parameter.

    Yields
    ------
    (dict, dict)
        The first has, for a position at which one slider was moved, its title and value.
    """
    own = {name: slider.value for name, slider in sliders.items()}
    titles = {name: slider.description or name for name, slider in sliders.items()}
    yield {"all": [[titles[name], f"{own[name]:g}"] for name in sliders]}, own
    count = POSITIONS.get(len(sliders), FEW_POSITIONS)
    for name, slider in sliders.items():
        for value in _spread(slider, count):
            yield {"slider": titles[name], "value": f"{value:g}"}, own | {name: value}


def _spread(slider: Widget, count: int) -> list[float]:
    """Some values of a slider, from its first to its last, without the one it stands at."""
    if hasattr(slider, "options"):
        values = [value for value in slider.options if value != slider.value]
    else:
        steps = int(round((slider.max - slider.min) / slider.step))
        kind = type(slider.value)
        values = [kind(round(slider.min + step * slider.step, 9)) for step in range(steps + 1)]
        values = [value for value in values if abs(value - slider.value) > 1e-9]
    chosen = np.linspace(0, len(values) - 1, min(count, len(values))).round().astype(int)
    return [values[index] for index in chosen]


def predict(
    question: str,
    *,
    choices: tuple[str, ...] = (),
    between: tuple[float, float] | None = None,
    step: float = 1,
    unit: str = "",
    digits: int = 0,
) -> object:
    """As `utils.predict`, and shows the question as data."""
    from utils.predictions import Prediction

    prediction = Prediction(question, tuple(choices), unit, digits)
    about = {"question": question, "choices": list(choices), "unit": unit}
    if between:
        about |= {"between": [*between], "step": step}
    _display(QUESTION, about, f"Your guess first: {question}")
    return prediction


def compare(prediction: object, answer: float | str, why: str) -> None:
    """As `utils.predictions.Prediction.compare`, and shows the answer as data."""
    if prediction._choices and answer not in prediction._choices:
        raise ValueError(f"{answer!r} is none of the choices: {', '.join(prediction._choices)}.")
    said = prediction._said(answer)
    about = {"question": prediction._question, "answer": said, "why": why}
    _display(ANSWER, about, f"{prediction._question} Answer: {said}. {why}")


def _display(kind: str, about: dict, text: str) -> None:
    from IPython.display import display

    display({kind: about, "text/plain": text}, raw=True)


def _describe_figures(shell: object) -> None:
    from matplotlib.figure import Figure

    png = shell.display_formatter.formatters["image/png"]
    draw = png.lookup_by_type(Figure)

    def drawn(figure: Figure) -> tuple | None:
        content = draw(figure)
        if content is None:  # there is nothing in it
            return None
        data, about = content if isinstance(content, tuple) else (content, {})
        return data, {**about, "alt": described(figure)}

    png.for_type(Figure, drawn)


def described(figure: Figure) -> str:
    """What stands in a figure in words: titles, what is drawn along which axis, the legend."""
    parts = [_text(figure.get_suptitle()), *map(_described_axes, figure.axes)]
    parts += [_legend(legend) for legend in figure.legends]
    parts = [part[:1].upper() + part[1:] for part in parts if part]
    return "Figure. " + "".join(f"{part}. " for part in dict.fromkeys(parts)).strip()


def _described_axes(axes: Axes) -> str:
    title = " ".join(filter(None, (_text(axes.get_title(loc)) for loc in TITLES)))
    along, up = _text(axes.get_xlabel()), _text(axes.get_ylabel())
    if axes.get_label() == "<colorbar>":
        return f"colours: {up or along}" if up or along else ""
    plotted = f"{up or 'drawn'} over {along}" if along else up
    legends = [one for one in (axes.get_legend(), *axes.artists) if hasattr(one, "get_texts")]
    return "; ".join(filter(None, (title, plotted, *map(_legend, legends))))


def _legend(legend: Legend) -> str:
    names = [_text(text.get_text()) for text in legend.get_texts()]
    return f"shown are {', '.join(dict.fromkeys(filter(None, names)))}" if any(names) else ""


def _text(words: str) -> str:
    """Words of a figure without the signs that matplotlib reads as orders."""
    plain = words.replace("$", "").replace("\\", "").replace("\n", " ")
    return plain.strip().rstrip(".:")
