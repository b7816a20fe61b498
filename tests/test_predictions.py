"""A prediction asks for a guess and shows it next to the answer."""

import sys
from importlib import util

import ipywidgets
import pytest

import utils
from utils import predict, predictions, static_widgets


@pytest.fixture(autouse=True)
def no_stored_guesses(monkeypatch):
    monkeypatch.setattr(predictions, "_GUESSES", {})


@pytest.fixture
def widgets(monkeypatch):
    """Return a list that collects the widgets that predictions create."""
    widgets = []
    for kind in ("RadioButtons", "FloatSlider", "Text"):
        build = getattr(ipywidgets, kind)
        monkeypatch.setattr(
            ipywidgets,
            kind,
            lambda build=build, **options: widgets.append(build(**options)) or widgets[-1],
        )
    return widgets


@pytest.mark.parametrize(
    ("options", "typed", "answer", "lines"),
    [
        ({}, "about 1,200", 1234, ["Your guess: 1,200", "Answer: 1,234"]),
        ({"unit": "m", "digits": 1}, "-1.5", -1.73, ["Your guess: −1.5 m", "Answer: −1.7 m"]),
        ({"between": (0, 100), "unit": "%"}, 40.0, 37.6, ["Your guess: 40%", "Answer: 38%"]),
        ({"between": (0, 90), "unit": "°"}, 40.0, 45.0, ["Your guess: 40°", "Answer: 45°"]),
        ({"choices": ["yes", "no"]}, "no", "yes", ["Your guess: no", "Answer: yes"]),
        ({}, "no idea", 3, ["Your guess: none yet", "Answer: 3"]),
    ],
    ids=str,
)
def test_the_guess_is_shown_with_the_answer(widgets, capsys, options, typed, answer, lines):
    prediction = predict("How many?", **options)
    widgets[-1].value = typed
    capsys.readouterr()
    prediction.compare(answer, "Because of that.")
    assert capsys.readouterr().out.split("\n")[:-1] == ["How many?", *lines, "Because of that."]


def test_an_untouched_slider_does_not_count_as_a_guess(widgets):
    assert predict("How many?", between=(0, 10)).guess is None


def test_a_guess_is_kept_when_the_cell_runs_again(widgets):
    predict("How many?", between=(0, 10))
    widgets[-1].value = 4.0
    assert predict("How many?", between=(0, 10)).guess == 4.0
    assert widgets[-1].value == 4.0
    predict("Which?", choices=["a", "b"])
    widgets[-1].value = "b"
    assert predict("Which?", choices=["a", "b"]).guess == "b"
    assert widgets[-1].value == "b"


def test_an_answer_must_be_one_of_the_choices():
    with pytest.raises(ValueError, match="'maybe' is not one of the choices: yes, no"):
        predict("Well?", choices=["yes", "no"]).compare("maybe", "")


@pytest.fixture
def no_widgets(monkeypatch):
    """Hide ipywidgets, as on a machine without it, and install the static replacement."""
    find = util.find_spec
    monkeypatch.setattr(util, "find_spec", lambda name: name != "ipywidgets" and find(name))
    monkeypatch.setitem(sys.modules, "ipywidgets", None)
    monkeypatch.delitem(sys.modules, "ipywidgets")
    assert "To make sliders move" in utils.health() and utils.health().startswith("Ready")
    static_widgets.install_stand_in()


def test_sliders_are_static_and_no_guess_is_requested_without_widgets(no_widgets, capsys):
    from ipywidgets import IntSlider, SelectionSlider, interact

    seen = []

    @interact(
        n=IntSlider(value=3, min=0, description="n"), m=SelectionSlider(options=[1, 2], value=2)
    )
    def show(n, m):
        seen.append((n, m))

    assert seen == [(3, 2)]
    prediction = predict("Which?", choices=["a", "b"])
    assert prediction.guess is None
    prediction.compare("b", "Because.")
    output = capsys.readouterr().out
    assert "Which? (a, b)" in output and "Answer: b" in output


def test_the_replacement_of_widgets_has_no_file_for_tracebacks_to_read(no_widgets):
    assert not hasattr(sys.modules["ipywidgets"], "__file__")


def test_installed_widgets_are_not_replaced():
    static_widgets.install_stand_in()
    assert sys.modules["ipywidgets"] is ipywidgets
