"""Drawings that students change by hand: what Python answers, and the figure without anywidget."""

import json
import subprocess
import sys
from importlib import util
from types import SimpleNamespace

import ipywidgets
import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.colors import to_hex

from grader.course.paths import PROJECT
from utils import by_hand
from utils.by_hand import Drawing, drag_circle, drag_points
from utils.by_hand.drawing import Board
from utils.by_hand.still import draw_still
from utils.plots.regions import pruned_regions
from utils.plots.style import BLUE, PALE, VERMILION

LIMITS = ((-4, 6), (-2, 3))
POINTS = [[0.0, 0.0], [1.0, 1.0], [2.0, -1.5]]


@pytest.fixture
def board():
    return Board(np.array(LIMITS, float), np.array(POINTS), movable=(2,))


def above_zero(points):
    """Return which points are above the line y = 0, as a student's function would."""
    above = points[:, 1] > 0
    return Drawing(f"{above.sum()} above", labels=np.where(above, 1, 2), lines={"zero": (0, 2, 0)})


# ---- shapes -------------------------------------------------------------------------------------


def test_points_are_grouped_by_label(board):
    drawing = Drawing(labels=[1, 0, 2], names={1: "near", 0: "noise"})
    groups = drawing.shapes(board)["groups"]
    assert [group["rows"] for group in groups] == [[1], [0], [2]]
    assert [group["legend"] for group in groups] == ["noise: 1", "near: 1", ""]
    assert [group["colour"] for group in groups] == [PALE, BLUE, VERMILION]
    assert len({group["marker"] for group in groups}) == 3
    assert [group["number"] for group in groups] == [""] * 3


def test_labels_without_names_are_written_at_few_points(board):
    numbers = [group["number"] for group in Drawing(labels=[3, 3, 5]).shapes(board)["groups"]]
    assert numbers == ["3", "5"]
    many = board.moved(np.zeros((41, 2)), None)
    assert Drawing(labels=np.ones(41)).shapes(many)["groups"][0]["number"] == ""


@pytest.mark.parametrize("line", [(3, -4, 5), (0, 2, -1), (1, 0, -4), (-0.1, 30, 20)])
def test_a_line_crosses_the_whole_region_and_its_band_is_as_wide_as_stated(board, line):
    shapes = Drawing(lines={"first": line, "second": (1, 1, 0)}, tolerance=0.5).shapes(board)
    a, b, c = np.array(line) / np.hypot(*line[:2])
    (start, end) = ends = np.array(shapes["lines"][0]["ends"])
    assert ends @ (a, b) + c == pytest.approx([0, 0])
    # Both ends are outside the region, on opposite sides of its middle.
    middle, along = np.mean(LIMITS, axis=1), (end - start) / np.linalg.norm(end - start)
    reach = np.linalg.norm(np.ptp(LIMITS, axis=1))
    assert (end - middle) @ along > reach / 2 and (start - middle) @ along < -reach / 2
    corners = np.array(shapes["band"]["corners"])
    assert sorted(corners @ (a, b) + c) == pytest.approx([-0.5, -0.5, 0.5, 0.5])
    assert shapes["band"]["name"] == "within 0.5 m"


def test_a_line_that_does_not_exist_is_not_drawn(board):
    shapes = Drawing(lines={"none": None}, tolerance=1.0).shapes(board)
    assert shapes["lines"] == [] and shapes["band"] is None


@pytest.mark.parametrize(
    ("drawing", "words"),
    [
        (Drawing(labels=[1, 2]), "one entry per point"),
        (Drawing(labels=["a", "b", "c"]), "whole numbers"),
        (Drawing(lines={"line": (1, 2)}), "line must be 3 numbers"),
        (Drawing(lines={"line": (0, 0, 1)}), "no direction"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_wrong_answer_is_explained(board, drawing, words):
    with pytest.raises(ValueError, match=words):
        drawing.shapes(board)


def test_everything_to_draw_can_be_sent_to_the_browser(board):
    drawing = Drawing(
        "all",
        labels=np.array([1, 2, 3], np.int8),
        lines={"line": np.array([1.0, 0, 0], np.float32)},
        tolerance=np.float64(1),
        edges=np.array([[0, 2]]),
        rectangles={"pruned": np.ones((2, 4))},
    )
    shapes = json.loads(json.dumps(drawing.shapes(board), allow_nan=False))
    assert shapes["edges"] == [[0, 2]]
    assert shapes["rectangles"] == [{"name": "pruned", "boxes": [[1, 1, 1, 1]] * 2}]


def test_pruned_regions_are_those_of_the_branches_that_a_search_leaves_out():
    def node(index, point, left=None, right=None):
        return SimpleNamespace(index=index, point=point, left=left, right=right)

    low, high = node(2, (2.0, -1.0)), node(3, (3.0, 2.0))
    root = node(0, (0.0, 0.0), node(1, (-2.0, 1.0)), node(4, (1.0, 0.5), low, high))
    assert sorted(pruned_regions(root, [0, 4, 3], LIMITS).tolist()) == [
        [-4, -2, 0, 3],  # to the left of the root
        [0, -2, 6, 0.5],  # to the right of the root and below node 4
    ]
    assert pruned_regions(root, [0, 1, 2, 3, 4], LIMITS).shape == (0, 4)


# ---- messages -----------------------------------------------------------------------------------


def message(points=POINTS, circle=None, request=0.5):
    return {"request": request, "points": points, "circle": circle}


@pytest.fixture
def send_to_widget(board):
    """Return a function that sends a message to a new widget, and returns the answers it sends."""
    from utils.by_hand.widget import HandWidget

    def send(draw, *messages, on=board):
        hand_widget, answers = HandWidget(draw, on), []
        hand_widget.observe(lambda change: answers.append(change["new"]), "answer")
        for content in messages:
            hand_widget._handle_custom_msg(json.loads(json.dumps(content)), [])
        return answers

    return send


def test_each_message_is_answered_once_at_its_own_positions(send_to_widget):
    moved = [*POINTS[:2], [2.0, 0.5]]
    first, second = send_to_widget(above_zero, message(request=0.25), message(moved, request=0.75))
    assert (first["request"], second["request"]) == (0.25, 0.75)
    assert (first["points"], second["points"]) == (POINTS, moved)
    assert (first["shapes"]["title"], second["shapes"]["title"]) == ("1 above", "2 above")
    assert first["problem"] == second["problem"] == ""


def test_the_browser_gets_the_board(board):
    from utils.by_hand.widget import HandWidget

    sent = json.loads(json.dumps(HandWidget(above_zero, board, "still-7").board))
    assert sent["limits"] == [list(span) for span in LIMITS]
    assert (sent["points"], sent["circle"], sent["movable"]) == (POINTS, None, [2])
    assert sent["still"] == "still-7" and sent["colours"]["blue"] == BLUE


def test_a_function_gets_the_circle(send_to_widget, board):
    seen = []
    round_board = Board(board.limits, board.points, (0.0, 0.0, 1.0))
    send_to_widget(
        lambda *circle: seen.append(circle) or Drawing(), message(circle=[1, 2, 3]), on=round_board
    )
    assert seen == [(1.0, 2.0, 3.0)]


def test_all_points_can_be_removed(send_to_widget):
    (answer,) = send_to_widget(above_zero, message([]))
    assert answer["problem"] == "" and answer["shapes"]["groups"] == []


def test_an_exception_is_described_and_later_messages_are_answered(send_to_widget):
    def draw(points):
        if points[2, 1] > 0:
            return [][len(points)]
        return above_zero(points)

    answers = send_to_widget(draw, message([*POINTS[:2], [2, 1]]), message())
    assert answers[0]["problem"].startswith("draw raised IndexError: list index out of range (line")
    assert answers[0]["shapes"] == {}
    assert (answers[1]["problem"], answers[1]["shapes"]["title"]) == ("", "1 above")


@pytest.mark.parametrize(
    ("error", "sentence"),
    [
        (NotImplementedError("f is not written yet."), "f is not written yet."),
        (KeyboardInterrupt(), "You stopped the function before it returned."),
        (RecursionError("too deep"), "draw raised RecursionError: too deep (line"),
    ],
    ids=repr,
)
def test_each_kind_of_exception_becomes_a_sentence(send_to_widget, error, sentence):
    def draw(points):
        raise error

    (answer,) = send_to_widget(draw, message())
    assert answer["problem"].startswith(sentence)


def test_a_result_that_is_not_a_drawing_or_does_not_fit_is_described(send_to_widget):
    (nothing,) = send_to_widget(lambda points: None, message())
    assert "AttributeError" in nothing["problem"]
    (short,) = send_to_widget(lambda points: Drawing(labels=[1]), message())
    assert "one entry per point" in short["problem"]


def test_a_function_cannot_move_the_points(board):
    board.arguments[0][:] = 9
    assert board.points.tolist() == POINTS


def test_printed_text_and_banners_do_not_leave_the_function(send_to_widget, capsys):
    send_to_widget(lambda points: print("hello") or Drawing(), message())
    assert capsys.readouterr().out == ""


# ---- without anywidget --------------------------------------------------------------------------


@pytest.fixture
def figures(monkeypatch):
    """Return a list that collects the titles of the figures shown."""
    shown = []

    def collect():
        shown.append(plt.gca().get_title(loc="left"))
        plt.close("all")

    monkeypatch.setattr(plt, "show", collect)
    return shown


def test_points_without_anywidget_are_a_figure(figures, capsys):
    drag_points(above_zero, POINTS, movable=[2], limits=LIMITS)
    assert figures == ["1 above"]
    assert "do not move here" in capsys.readouterr().out


def test_a_circle_without_anywidget_has_sliders(figures, monkeypatch):
    found = {}

    def interact(**sliders):
        found.update(sliders)
        return lambda show: show(**{name: slider.value for name, slider in sliders.items()}) or show

    monkeypatch.setattr(ipywidgets, "interact", interact)
    drag_circle(lambda *circle: Drawing(str(circle)), (1, 0.5, 2), POINTS, limits=LIMITS)
    assert figures == ["(1.0, 0.5, 2.0)"]
    assert {name: (slider.min, slider.max) for name, slider in found.items()} == {
        "x": (-4, 6),
        "y": (-2, 3),
        "radius": (0.2, 2.5),
    }


def test_a_circle_without_any_widgets_is_a_figure(figures, monkeypatch):
    from utils import static_widgets

    monkeypatch.setitem(sys.modules, "ipywidgets", None)
    del sys.modules["ipywidgets"]
    with monkeypatch.context() as patch:
        find = util.find_spec
        patch.setattr(util, "find_spec", lambda name: name != "ipywidgets" and find(name))
        static_widgets.install_stand_in()
    drag_circle(lambda *circle: Drawing(str(circle)), (1, 0, 2), POINTS, limits=LIMITS)
    assert figures == ["(1.0, 0.0, 2.0)"]


def test_only_a_notebook_with_the_package_can_drag(monkeypatch):
    assert not by_hand.can_drag(), "there is no kernel"
    monkeypatch.setattr(by_hand, "shell", lambda: type("Shell", (), {"kernel": True}))
    assert by_hand.can_drag()
    monkeypatch.setattr(util, "find_spec", lambda name: None)
    assert not by_hand.can_drag()


def test_a_figure_has_the_parts_of_the_drawing(board):
    drawing = Drawing(
        "title",
        labels=[1, 1, 2],
        names={1: "near", 2: "far"},
        lines={"line": (1, 1, 0), "other": (1, -1, 0)},
        tolerance=0.5,
        edges=[[0, 1]],
        rectangles={"pruned": [[0, 0, 1, 2]]},
    )
    axes = draw_still(board, drawing)
    legend = [text.get_text() for text in axes.get_legend().get_texts()]
    assert set(legend) == {"near: 2", "far: 1", "line", "other", "within 0.5 m", "pruned: 1"}
    assert (axes.get_xlim(), axes.get_ylim()) == LIMITS and axes.get_aspect() == 1
    blue = [line for line in axes.lines if line.get_marker() == "o" and line.get_color() == BLUE]
    assert np.array(blue[0].get_xydata()).tolist() == POINTS[:2]
    (ring,) = [line for line in axes.lines if line.get_fillstyle() == "none"]
    assert ring.get_xydata().tolist() == [POINTS[2]]
    plt.close(axes.figure)


def test_a_figure_has_the_circle_and_its_square(board):
    axes = draw_still(Board(board.limits, board.points, (1.0, 0.5, 1.5)), Drawing())
    patches = {(type(patch).__name__, to_hex(patch.get_facecolor()[:3])) for patch in axes.patches}
    assert {name for name, _ in patches} == {"Circle", "Rectangle"}
    square = next(patch for patch in axes.patches if type(patch).__name__ == "Rectangle")
    assert square.get_bbox().extents.tolist() == [-0.5, -1.0, 2.5, 2.0]
    plt.close(axes.figure)


@pytest.mark.slow
def test_only_a_drawing_in_a_notebook_imports_anywidget():
    program = (
        "import sys, utils; from utils import check; from utils.by_hand import drag_points\n"
        "assert not {'anywidget', 'ipywidgets', 'psygnal'} & sys.modules.keys()"
    )
    subprocess.run([sys.executable, "-c", program], cwd=PROJECT, check=True)
