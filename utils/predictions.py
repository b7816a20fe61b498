"""Ask students for a prediction, and show it next to the result."""

from __future__ import annotations

import re
from collections.abc import Sequence
from html import escape

from utils.display import show

# Guesses by question, which are kept when a cell runs again.
_GUESSES: dict[str, float | str] = {}


class Prediction:
    """A question with a student's guess, created by `predict`.

    Attributes
    ----------
    suffix : str
        The unit of a number, with a space before it if it needs one.
    """

    def __init__(self, question: str, choices: tuple[str, ...], unit: str, digits: int) -> None:
        self._question, self._choices = question, choices
        self._digits = digits
        self.suffix = unit if unit in ("", "%", "°") else f" {unit}"

    @property
    def guess(self) -> float | str | None:
        """The guess; None if there is none yet."""
        return _GUESSES.get(self._question)

    def compare(self, answer: float | str, why: str) -> None:
        """Show the guess next to the answer.

        Parameters
        ----------
        answer : float or str
            One of the choices if there are any, else a number in the unit of the question.
        why : str
            An explanation, folded at first.

        Raises
        ------
        ValueError
            If the answer is not one of the choices.
        """
        if self._choices and answer not in self._choices:
            raise ValueError(f"{answer!r} is not one of the choices: {', '.join(self._choices)}.")
        guess = "none yet" if self.guess is None else self._as_text(self.guess)
        rows = {"Your guess": guess, "Answer": self._as_text(answer)}
        show(*as_html_and_text(self._question, rows, why))

    def _as_text(self, value: float | str) -> str:
        if isinstance(value, str):
            return value
        return f"{value:,.{self._digits}f}{self.suffix}".replace("-", "−")


def as_html_and_text(question: str, rows: dict[str, str], why: str) -> tuple[str, str]:
    """Format a question and its answers as HTML and as text.

    Parameters
    ----------
    question : str
    rows : dict of str to str
        Texts to show next to each other, by their labels.
    why : str
        An explanation, folded at first.
    """
    text = "\n".join([question, *(f"{row}: {value}" for row, value in rows.items()), why])
    cells = "".join(
        f"<span style='margin-right:2em'>{row}: <b>{escape(value)}</b></span>"
        for row, value in rows.items()
    )
    html = (
        "<div style='border-left:4px solid #0072B2;padding:0.3em 0.8em;line-height:1.5'>"
        f"<div>{escape(question)}</div><div>{cells}</div>"
        f"<details><summary>Why?</summary>{escape(why)}</details></div>"
    )
    return html, text


def predict(
    question: str,
    *,
    choices: Sequence[str] = (),
    between: tuple[float, float] | None = None,
    step: float = 1,
    unit: str = "",
    digits: int = 0,
) -> Prediction:
    """Ask for a guess before the answer is shown.

    Parameters
    ----------
    question : str
    choices : sequence of str, optional
        Choices to show.
    between : (float, float), optional
        Ends of a slider to show. Without a slider or choices, you type a number.
    step : float
        Step of the slider.
    unit : str
        Unit of the number, such as "%" or "m".
    digits : int
        Number of decimals.

    Returns
    -------
    Prediction
        Call its ``compare(answer, why)`` to show the guess and the answer.

    Examples
    --------
    >>> share = predict("What share of all returns is road?", between=(0, 100), unit="%")
    >>> share.compare(100 * len(road) / len(cloud), "Most beams look down.")
    """
    import ipywidgets
    from IPython.display import display

    prediction = Prediction(question, tuple(choices), unit, digits)
    if hasattr(ipywidgets, "is_still"):
        options = f" ({', '.join(choices)})" if choices else ""
        text = f"Your prediction. {question}{options} Write your answer down before you continue."
        show(escape(text), text)
        return prediction
    if choices:
        # As wide as its longest choice, because a wrapped choice would overlap the next one.
        entry = ipywidgets.RadioButtons(
            options=list(choices), value=prediction.guess, layout={"width": "max-content"}
        )
    elif between:
        low, high = between
        entry = ipywidgets.FloatSlider(
            min=low,
            max=high,
            step=step,
            value=low if prediction.guess is None else prediction.guess,
            readout_format=f",.{digits}f",
        )
    else:
        known = "" if prediction.guess is None else f"{prediction.guess:g}"
        entry = ipywidgets.Text(value=known, placeholder="a number")

    def remember(event: dict) -> None:
        guess = event["new"]
        if not choices and not between:
            found = re.search(r"-?\d+(?:\.\d+)?", guess.replace(",", "").replace("−", "-"))
            guess = float(found[0]) if found else None
        if guess is None:
            _GUESSES.pop(question, None)
        else:
            _GUESSES[question] = guess

    entry.observe(remember, names="value")
    heading = ipywidgets.HTML(f"<b>Your prediction.</b> {escape(question)}")
    suffix = [ipywidgets.Label(unit)] if unit and not choices else []
    display(ipywidgets.VBox([heading, ipywidgets.HBox([entry, *suffix])]))
    return prediction
