"""When a cell raises an exception, its empty figures are closed, and the others stay open."""

import matplotlib.pyplot as plt
import pytest

from utils import tracebacks


@pytest.fixture(autouse=True)
def no_figures():
    plt.close("all")
    yield
    plt.close("all")


def test_unfinished_figures_stay_only_if_they_are_not_empty():
    plt.figure()
    plt.subplots(2, 1)
    half_drawn, (_, axes) = plt.subplots(2, 1)
    axes.plot([1.0, 2.0])
    written = plt.figure()
    written.text(0.5, 0.5, "a word")
    tracebacks._close_empty_figures()
    assert plt.get_fignums() == [half_drawn.number, written.number]


def test_no_figure_is_closed_without_matplotlib(monkeypatch):
    empty = plt.figure()
    monkeypatch.delitem(tracebacks.sys.modules, "matplotlib.pyplot")
    tracebacks._close_empty_figures()
    assert plt.get_fignums() == [empty.number]
