"""A prediction is an input, and comes back beside the answer."""

import sys
from importlib import util

import ipywidgets
import pytest

import utils
from utils import predict, predictions, static_widgets


@pytest.fixture(autouse=True)
def nothing_guessed(monkeypatch):
    monkeypatch.setattr(predictions, "_GUESSES", {})


@pytest.fixture
def entry(monkeypatch):
    """The widget of the last prediction, in a list."""
    made = []
    for kind in ("RadioButtons", "FloatSlider", "Text"):
        build = getattr(ipywidgets, kind)
        monkeypatch.setattr(
            ipywidgets,
            kind,
            lambda build=build, **options: made.append(build(**options)) or made[-1],
        )
    return made


@pytest.mark.parametrize(
    ("options", "typed", "answer", "lines"),
    [
        ({}, "about 1,200", 1234, ["Your guess: 1,200", "Answer: 1,234"]),
        ({"unit": "m", "digits": 1}, "-1.5", -1.73, ["Your guess: −1.5 m", "Answer: −1.7 m"]),
        ({"between": (0, 100), "unit": "%"}, 40.0, 37.6, ["Your guess: 40%", "Answer: 38%"]),
        ({"choices": ["yes", "no"]}, "no", "yes", ["Your guess: no", "Answer: yes"]),
        ({}, "no idea", 3, ["Your guess: none yet", "Answer: 3"]),
    ],
    ids=str,
)
def test_the_guess_stands_beside_the_answer(entry, capsys, options, typed, answer, lines):
    prediction = predict("How many?", **options)
    entry[-1].value = typed
    capsys.readouterr()
    prediction.compare(answer, "Because of that.")
    assert capsys.readouterr().out.split("\n")[:-1] == ["How many?", *lines, "Because of that."]


def test_a_slider_that_was_not_moved_is_no_guess(entry):
    assert predict("How many?", between=(0, 10)).guess is None


def test_a_guess_outlives_running_the_cell_again(entry):
    predict("How many?", between=(0, 10))
    entry[-1].value = 4.0
    assert predict("How many?", between=(0, 10)).guess == 4.0
    assert entry[-1].value == 4.0
    predict("Which?", choices=["a", "b"])
    entry[-1].value = "b"
    assert predict("Which?", choices=["a", "b"]).guess == "b"
    assert entry[-1].value == "b"


def test_an_answer_that_is_no_choice_is_the_authors_mistake():
    with pytest.raises(ValueError, match="'maybe' is none of the choices: yes, no"):
        predict("Well?", choices=["yes", "no"]).compare("maybe", "")


@pytest.fixture
def no_widgets(monkeypatch):
    """As where nobody has installed ipywidgets."""
    find = util.find_spec
    monkeypatch.setattr(util, "find_spec", lambda name: name != "ipywidgets" and find(name))
    monkeypatch.setitem(sys.modules, "ipywidgets", None)
    monkeypatch.delitem(sys.modules, "ipywidgets")
    assert "Sliders stand still" in utils.health() and utils.health().startswith("Ready")
    static_widgets.stand_in()


def test_without_widgets_a_slider_stands_still_and_a_guess_is_kept_in_mind(no_widgets, capsys):
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
    said = capsys.readouterr().out
    assert "Which? (a, b)" in said and "Answer: b" in said


def test_widgets_that_are_there_are_left_alone():
    static_widgets.stand_in()
    assert sys.modules["ipywidgets"] is ipywidgets
