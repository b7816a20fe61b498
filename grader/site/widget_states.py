"""A recorder that runs in the kernel of a solved notebook and stores interactive outputs as data.

For a slider, the recorder stores the output at a few positions. For a prediction, it stores the
question and the answer. It adds a description in words to each figure. `grader.site.html_outputs`
converts the data to HTML.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ipywidgets import Widget
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.legend import Legend

POSITION_TYPE = "application/vnd.lidar-obstacle-lab.position+json"
QUESTION_TYPE = "application/vnd.lidar-obstacle-lab.question+json"
ANSWER_TYPE = "application/vnd.lidar-obstacle-lab.answer+json"
POSITIONS = {1: 4, 2: 3}  # positions per slider, without the lesson's own, by number of sliders
DEFAULT_POSITIONS = 2  # positions per slider if there are more than two sliders
TITLES = ("left", "center", "right")  # places of a title above the axes
MAX_POINTS = 250_000  # in a scene; a page loads a scene separately, and a notebook contains it


def record() -> None:
    """Replace the notebook's interactive functions with functions that store data."""
    import ipywidgets
    from IPython import get_ipython

    from utils import by_hand, predictions
    from utils.questions import ask
    from utils.scene3d import viewer

    # A question about a change would show a line of the course's answer.
    ask.ask_about = functools.partial(ask.ask_about, kinds=(ask.predict, ask.predict))
    ipywidgets.interact = interact
    by_hand.can_drag = lambda: False  # a page has no kernel that could answer
    viewer.MAX_POINTS = MAX_POINTS
    predictions.predict = predict
    predictions.Prediction.compare = compare
    shell = get_ipython()
    shell.run_line_magic("matplotlib", "inline")
    _describe_figures(shell)


def interact(**sliders: Widget) -> Callable[[Callable], Callable]:
    """Replace `ipywidgets.interact`: show the output at each of the sliders' `positions`."""

    def run(function: Callable) -> Callable:
        for about, values in positions(sliders):
            if "all" in about and function.__module__ == "__main__":  # a cell defines the function
                about["call"] = {"name": function.__name__, "parameters": [*_parameters(sliders)]}
            text = ", ".join(f"{name} {value:g}" for name, value in values.items())
            _display(POSITION_TYPE, about, text)
            function(**values)
        return function

    return run


def positions(sliders: dict[str, Widget]) -> Iterator[tuple[dict, dict]]:
    """Yield the slider positions to record, beginning with the lesson's own position.

    Parameters
    ----------
    sliders : dict of str to ipywidgets.Widget
        Sliders by parameter name.

    Yields
    ------
    (dict, dict)
        Description of a position, and values by parameter name. The description contains the
        title and value of the slider that was moved. For the lesson's own position, it contains
        the titles and values of all sliders.
    """
    current = {name: slider.value for name, slider in sliders.items()}
    titles = {name: slider.description or name for name, slider in sliders.items()}
    yield {"all": [[titles[name], f"{current[name]:g}"] for name in sliders]}, current
    count = POSITIONS.get(len(sliders), DEFAULT_POSITIONS)
    for name, slider in sliders.items():
        for value in _spread(slider, count):
            yield {"slider": titles[name], "value": f"{value:g}"}, current | {name: value}


def _parameters(sliders: dict[str, Widget]) -> Iterator[dict]:
    """Yield the name, title, values as Python code, and current value's index of each slider."""
    for name, slider in sliders.items():
        values = _values(slider)
        yield {
            "name": name,
            "title": slider.description or name,
            "values": [*map(repr, values)],
            "start": int(np.argmin(np.abs(np.subtract(values, slider.value)))),
        }


def _values(slider: Widget) -> list[float]:
    if hasattr(slider, "options"):
        return [*slider.options]
    steps = int(round((slider.max - slider.min) / slider.step))
    kind = type(slider.value)
    return [kind(round(slider.min + step * slider.step, 9)) for step in range(steps + 1)]


def _spread(slider: Widget, count: int) -> list[float]:
    """Return `count` evenly spread values of a slider, without the current one."""
    values = [value for value in _values(slider) if abs(value - slider.value) > 1e-9]
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
    """Replace `utils.predict`: show the question as data."""
    from utils.predictions import Prediction

    prediction = Prediction(question, tuple(choices), unit, digits)
    about = {"question": question, "choices": list(choices), "suffix": prediction.suffix}
    if between:
        about |= {"between": [*between], "step": step}
    _display(QUESTION_TYPE, about, f"Guess first: {question}")
    return prediction


def compare(prediction: object, answer: float | str, why: str) -> None:
    """Replace `utils.predictions.Prediction.compare`: show the answer as data."""
    if prediction._choices and answer not in prediction._choices:
        raise ValueError(f"{answer!r} is not one of the choices: {', '.join(prediction._choices)}.")
    text = prediction._as_text(answer)
    about = {"question": prediction._question, "answer": text, "why": why}
    _display(ANSWER_TYPE, about, f"{prediction._question} Answer: {text}. {why}")


def _display(kind: str, content: dict, text: str) -> None:
    from IPython.display import display

    display({kind: content, "text/plain": text}, raw=True)


def _describe_figures(shell: object) -> None:
    from matplotlib.figure import Figure

    png = shell.display_formatter.formatters["image/png"]
    draw = png.lookup_by_type(Figure)

    def draw_with_description(figure: Figure) -> tuple | None:
        content = draw(figure)
        if content is None:  # the figure is empty
            return None
        data, about = content if isinstance(content, tuple) else (content, {})
        return data, {**about, "alt": describe_figure(figure)}

    png.for_type(Figure, draw_with_description)


def describe_figure(figure: Figure) -> str:
    """Return a description of a figure in words, from its titles, axis labels and legends."""
    parts = [_plain_text(figure.get_suptitle()), *map(_describe_axes, figure.axes)]
    parts += [_describe_legend(legend) for legend in figure.legends]
    parts = [part[:1].upper() + part[1:] for part in parts if part]
    return "Figure. " + "".join(f"{part}. " for part in dict.fromkeys(parts)).strip()


def _describe_axes(axes: Axes) -> str:
    title = " ".join(filter(None, (_plain_text(axes.get_title(loc)) for loc in TITLES)))
    x_label, y_label = _plain_text(axes.get_xlabel()), _plain_text(axes.get_ylabel())
    if axes.get_label() == "<colorbar>":
        return f"colours: {y_label or x_label}" if y_label or x_label else ""
    plotted = f"{y_label or 'drawn'} over {x_label}" if x_label else y_label
    legends = [
        artist for artist in (axes.get_legend(), *axes.artists) if hasattr(artist, "get_texts")
    ]
    return "; ".join(filter(None, (title, plotted, *map(_describe_legend, legends))))


def _describe_legend(legend: Legend) -> str:
    names = [_plain_text(text.get_text()) for text in legend.get_texts()]
    return f"legend: {', '.join(dict.fromkeys(filter(None, names)))}" if any(names) else ""


def _plain_text(words: str) -> str:
    """Remove the characters of a label that are markup in matplotlib."""
    plain = words.replace("$", "").replace("\\", "").replace("\n", " ")
    return plain.strip().rstrip(".:")
