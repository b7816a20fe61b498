"""All figures work for clouds of any size, and refuse typical wrong arguments."""

import io
import subprocess
import sys
import warnings

import matplotlib

matplotlib.use("agg")

import matplotlib.pyplot as plt
import numpy as np
import pytest

from utils import plots
from utils.plots import arguments, style

QUIZ = np.array(
    [
        (-6.2, 7), (-6.3, 8.4), (-5.2, 7.1), (-5.7, 6.3), (7.2, 6.1), (8, 5.3), (7.2, 7.1),
        (0.2, -7.1), (1.7, -6.9), (-1.2, -7.2), (2.2, -8.9),
    ]
)  # fmt: skip
BOX = np.array([[x, y, z] for z in (-1.7, 0) for y in (1, 3) for x in (4, 8)], dtype=float)


class Node:
    def __init__(self, point, index, left=None, right=None):
        self.point, self.index, self.left, self.right = point, index, left, right


def balanced_tree(points, rows=None, depth=0):
    rows = np.arange(len(points)) if rows is None else rows
    if not len(rows):
        return None
    rows = rows[np.argsort(points[rows, depth % points.shape[1]], kind="stable")]
    middle = (len(rows) - 1) // 2
    return Node(
        points[rows[middle]],
        int(rows[middle]),
        balanced_tree(points, rows[:middle], depth + 1),
        balanced_tree(points, rows[middle + 1 :], depth + 1),
    )


def street(n, columns=4, seed=0):
    """Return a scan of a street between two walls, in the order of a scanner with 64 beams."""
    rng = np.random.default_rng(seed)
    beam = np.arange(n) % 64
    azimuth = np.linspace(-np.pi, np.pi, n)
    elevation = np.radians(-25 + 27 * beam / 63)
    ray = np.column_stack([np.cos(azimuth), np.sin(azimuth), np.tan(elevation)])
    ground = 1.73 / np.maximum(-ray[:, 2], 0.02)
    wall = np.where(ray[:, 1] > 0, 9.0, 7.0) / np.maximum(np.abs(ray[:, 1]), 0.05)
    distance = np.minimum(ground, wall) + rng.normal(0, 0.02, n)
    return np.column_stack([ray * distance[:, None], rng.random(n)])[:, :columns]


CLOUDS = {
    "none": np.empty((0, 4)),
    "one": np.array([[3.0, 1.0, -0.5]]),
    "only NaN": np.full((5, 4), np.nan),
    "some not finite": np.vstack([street(500), np.full((3, 4), np.nan), np.full((2, 4), np.inf)]),
    "a scan": street(120_000),
}


def _blocks(cloud):
    """Label each point by its 2 m cell, from 0 to 399; the pattern repeats every 40 m."""
    place = np.floor(np.nan_to_num(cloud[:, :2], posinf=0) / 2.0).astype(int) % 20
    return place @ [20, 1]


ON_CLOUDS = {
    "from_above": plots.from_above,
    "from_above, values": lambda cloud, **more: plots.from_above(
        cloud, values=cloud[:, -1], label="intensity", **more
    ),
    "from_side": lambda cloud, **more: plots.from_side(cloud, level=-1.2, **more),
    "kept_and_removed": lambda cloud, **more: plots.kept_and_removed(
        cloud, cloud[:, 2] >= -1.2, **more
    ),
    "kept_and_removed, side": lambda cloud, **more: plots.kept_and_removed(
        cloud, cloud[:, 2] >= -1.2, view="side", **more
    ),
    "clusters": lambda cloud, **more: plots.clusters(cloud, _blocks(cloud), names=True, **more),
    "clusters, side": lambda cloud, **more: plots.clusters(
        cloud, np.zeros(len(cloud)), view="side", **more
    ),
    "plane_model": lambda cloud, **more: plots.plane_model(
        cloud, (0, 0.01, 1, 1.7), cloud[:, 2] < -1.5, 0.2, **more
    ),
    "plane_model, above": lambda cloud, **more: plots.plane_model(
        cloud, (0, 2, 0, -12), None, 0.2, view="above", **more
    ),
    "boxes": lambda cloud, **more: plots.boxes([BOX, BOX + 3], cloud=cloud, names=True, **more),
    "no boxes": lambda cloud, **more: plots.boxes(np.empty((0, 8, 3)), cloud=cloud, **more),
    "difference": lambda cloud, **more: plots.difference(
        cloud, cloud[:, 2] > -1.2, cloud[:, 1] > -1.2, **more
    ),
}

SMALL = {
    "graph": lambda **more: plots.graph(QUIZ, [(0, 1), (4, 5)], names=True, **more),
    "graph, no points": lambda **more: plots.graph(np.empty((0, 3)), [], **more),
    "graph, side": lambda **more: plots.graph(BOX, [(0, 1)], view="side", **more),
    "histogram": lambda **more: plots.histogram(
        street(1000)[:, 2], label="height z (m)", marks={"road": -1.73, "level": -1.2}, **more
    ),
    "histogram, nothing": lambda **more: plots.histogram([], marks={"level": 1.0}, **more),
    "histogram, NaN": lambda **more: plots.histogram([np.nan, 1.0, np.inf], bins=5, **more),
    "timing": lambda **more: plots.timing(
        {"naive": ([100, 200, 400], [0.1, 0.4, 1.6]), "one": ([100], [0.3])}, **more
    ),
    "timing, nothing": lambda **more: plots.timing({"none": ([], []), "zero": ([0], [0])}, **more),
    "curves": lambda **more: plots.curves(
        {"theory": ([1, 2], [3, 4])},
        {"theory": ([1], [3]), "other": ([2], [2])},
        across="n",
        up="p",
        **more,
    ),
    "compare": lambda **more: plots.compare({"a": 1.0, "b": np.nan}, label="time (s)", **more),
    "compare, nothing": lambda **more: plots.compare({}, **more),
    "line_model": lambda **more: plots.line_model(QUIZ, (1, 2, 3), QUIZ[:, 0] > 0, 1.0, **more),
    "line_model, None": lambda **more: plots.line_model(
        QUIZ, None, np.zeros(11, dtype=bool), 1.0, **more
    ),
    "line_model, no points": lambda **more: plots.line_model(np.empty((0, 2)), (0, 1, 0), **more),
    "plane_model, None": lambda **more: plots.plane_model(BOX, None, **more),
    "kd_splits": lambda **more: plots.kd_splits(QUIZ, balanced_tree(QUIZ), **more),
    "kd_splits, empty": lambda **more: plots.kd_splits(np.empty((0, 2)), None, **more),
    "kd_tree": lambda **more: plots.kd_tree(balanced_tree(QUIZ), **more),
    "kd_tree, large": lambda **more: plots.kd_tree(balanced_tree(street(800, 3)), **more),
    "kd_tree, empty": lambda **more: plots.kd_tree(None, **more),
    "kd_search": lambda **more: plots.kd_search(
        QUIZ, balanced_tree(QUIZ), (-6, 7), 3.0, [7, 0, 3, 9], found=[0, 3], **more
    ),
    "kd_search, plain": lambda **more: plots.kd_search(QUIZ, None, (-6, 7), 3.0, **more),
    "boxes, alone": lambda **more: plots.boxes(BOX[None], view="side", reference=True, **more),
    "boxes, flat or NaN": lambda **more: plots.boxes(
        [0 * BOX, BOX * [1, 0, 1], BOX * np.nan], **more
    ),
    "boxes, empty list": lambda **more: plots.boxes([], **more),
    "corner_numbers": lambda **more: plots.corner_numbers(BOX, **more),
    "corner_numbers, flat": lambda **more: plots.corner_numbers(0 * BOX, **more),
    "corner_numbers, NaN": lambda **more: plots.corner_numbers(BOX * np.nan, **more),
    "label_confusion": lambda **more: plots.label_confusion([1, 1, 2, 0], [2, 2, 1, -1], **more),
    "label_confusion, many": lambda **more: plots.label_confusion(
        np.arange(900) % 40, np.arange(900) % 39, **more
    ),
    "label_confusion, nothing": lambda **more: plots.label_confusion([], [], **more),
}  # fmt: skip

ROWS = {
    "growth": (lambda **more: plots.growth(QUIZ, np.eye(11, dtype=int)[:6], **more), 6),
    "growth, one": (lambda **more: plots.growth(np.empty((0, 3)), [[]], **more), 1),
    "worst": (lambda **more: plots.worst(QUIZ, [1] * 11, [2] * 4 + [0] * 7, **more), 2),
    "worst, equal": (lambda **more: plots.worst(BOX, [5] * 8, [1] * 8, view="side", **more), 2),
    "worst, nothing": (lambda **more: plots.worst(np.empty((0, 4)), [], [], **more), 2),
    "worst, NaN": (lambda **more: plots.worst(BOX * np.nan, [1] * 8, [0] * 8, **more), 2),
}


@pytest.fixture(autouse=True)
def strict_warnings():
    """Turn warnings into errors, close all figures, and fail if Matplotlib's settings change."""
    before = dict(matplotlib.rcParams)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # An earlier test of a lesson may have left a file open.
        warnings.simplefilter("ignore", ResourceWarning)
        yield
    plt.close("all")
    assert dict(matplotlib.rcParams) == before


def png(axes):
    """Return the bytes of a figure as a PNG file, rendered as in a notebook."""
    file = io.BytesIO()
    axes.figure.savefig(file, format="png", bbox_inches="tight")
    return file.getvalue()


def legend(axes):
    return [text.get_text() for text in axes.get_legend().get_texts()]


def texts(axes):
    return [text.get_text() for text in axes.texts]


@pytest.mark.slow
@pytest.mark.parametrize("figure", ON_CLOUDS)
@pytest.mark.parametrize("cloud", CLOUDS)
def test_clouds_of_every_size_are_drawn(figure, cloud, capfd):
    axes = ON_CLOUDS[figure](CLOUDS[cloud], title="A title")
    assert len(png(axes)) < 150_000
    assert axes.get_title(loc="left") == "A title"
    assert "(m)" in axes.get_xlabel() and "(m)" in axes.get_ylabel()
    assert capfd.readouterr() == ("", "")


@pytest.mark.slow
@pytest.mark.parametrize("figure", [*ON_CLOUDS, *SMALL])
def test_every_figure_uses_and_returns_the_given_axes(figure, capfd):
    _, (axes, other) = plt.subplots(1, 2, figsize=(8.5, 4))
    draw = SMALL.get(figure)
    open_figures = plt.get_fignums()
    if draw:
        returned = draw(axes=axes, title="A title")
    else:
        returned = ON_CLOUDS[figure](street(300), axes=axes, title="A title")
    assert returned is axes
    assert plt.get_fignums() == open_figures
    assert not other.has_data()
    axes.figure.canvas.draw()
    assert capfd.readouterr() == ("", "")


@pytest.mark.slow
@pytest.mark.parametrize("figure", SMALL)
def test_small_figures_open_one_new_figure(figure):
    axes = SMALL[figure]()
    assert len(plt.get_fignums()) == 1
    assert len(png(axes)) < 150_000


@pytest.mark.slow
@pytest.mark.parametrize("figure", ROWS)
def test_a_row_of_panels_has_one_axes_per_panel(figure):
    draw, count = ROWS[figure]
    axes = draw(title="A title")
    assert len(axes) == count
    axes[0].figure.canvas.draw()
    _, given = plt.subplots(1, count, squeeze=False)
    assert list(draw(axes=given)) == list(given[0])
    with pytest.raises(ValueError, match="one Axes per panel"):
        draw(axes=plt.subplots(1, count + 1)[1])


def test_inputs_are_not_modified():
    cloud = street(400)
    copy = cloud.copy()
    plots.from_above(cloud)
    plots.clusters(cloud, np.ones(400))
    assert (cloud == copy).all()


WRONG = {
    "transposed": (lambda: plots.from_above(np.zeros((3, 100))), r"\(3, 100\).*cloud\.T"),
    "one row": (lambda: plots.from_side([1.0, 2.0, 3.0]), r"cloud\[None, :\]"),
    "two columns": (lambda: plots.from_above(np.zeros((5, 2))), r"\(n, 3\) or \(n, 4\)"),
    "ragged": (lambda: plots.from_above([[1, 2, 3], [1, 2]]), "one row per point"),
    "text": (lambda: plots.from_above([["a", "b", "c"]]), "array of numbers"),
    "short mask": (
        lambda: plots.kept_and_removed(np.zeros((5, 3)), [True] * 4), r"\(5,\).*\(4,\)"),
    "indices for a mask": (
        lambda: plots.kept_and_removed(np.zeros((5, 3)), [0, 1, 2, 3, 4]), "True and False"),
    "view": (
        lambda: plots.clusters(np.zeros((5, 3)), [1] * 5, view="top"),
        '"above", "side" or "side to scale"',
    ),
    "side of a plane": (lambda: plots.clusters(QUIZ, [1] * 11, view="side"), "have no height"),
    "fractions": (lambda: plots.clusters(QUIZ, [0.5] * 11), "whole numbers"),
    "NaN labels": (lambda: plots.clusters(QUIZ, [np.nan] * 11), "whole numbers"),
    "short labels": (lambda: plots.clusters(QUIZ, [1]), r"shape \(11,\)"),
    "limits": (lambda: plots.from_above(np.zeros((5, 3)), limits=(1, 2)), "limits must be"),
    "values": (lambda: plots.from_above(np.zeros((5, 3)), values=[1]), "one entry per point"),
    "edges": (lambda: plots.graph(QUIZ, [(0, 11)]), "row numbers from 0 to 10"),
    "edge shape": (lambda: plots.graph(QUIZ, [0, 1]), r"shape \(m, 2\)"),
    "point names": (lambda: plots.graph(QUIZ, names=["a", "b"]), "one name per point"),
    "line of 4": (lambda: plots.line_model(QUIZ, (1, 2, 3, 4)), r"3 numbers \(a, b, c\)"),
    "no direction": (lambda: plots.line_model(QUIZ, (0, 0, 3)), r"\(a, b\) must be finite"),
    "points": (lambda: plots.line_model(np.zeros((5, 3)), None), r"\(n, 2\)"),
    "boxes": (lambda: plots.boxes(np.zeros((8, 3))), r"\(N, 8, 3\).*\(8, 3\)"),
    "box names": (lambda: plots.boxes(BOX[None], names=["a", "b"]), "one name per box"),
    "timing": (lambda: plots.timing({"mine": ([1, 2], [1])}), r'series\["mine"\]'),
    "target": (lambda: plots.kd_search(QUIZ, None, (1, 2, 3), 1.0), "target"),
    "visited": (lambda: plots.kd_search(QUIZ, None, (1, 2), 1.0, [99]), "visited"),
    "3-D tree": (
        lambda: plots.kd_splits(QUIZ, Node([1, 2, 3], 0)), r"\(x, y\).*3 numbers"),
    "growth": (lambda: plots.growth(QUIZ, [[0] * 3]), r"frames_of_labels\[0\]"),
    "growth titles": (lambda: plots.growth(QUIZ, [[0] * 11], titles=[]), "one title per step"),
}  # fmt: skip


@pytest.mark.parametrize("case", WRONG)
def test_wrong_shapes_raise_an_error_with_a_sentence(case):
    call, message = WRONG[case]
    with pytest.raises(ValueError, match=message) as caught:
        call()
    assert str(caught.value).endswith(".")
    assert not plt.get_fignums(), "a wrong call leaves no empty figure behind"


def test_a_grid_of_axes_raises_an_error_with_a_sentence():
    _, grid = plt.subplots(1, 2)
    with pytest.raises(TypeError, match=r"pass panels\[0\]"):
        plots.from_above(BOX, axes=grid)


def test_legends_count_the_points_of_the_whole_cloud():
    cloud = street(90_000)
    keep = np.arange(90_000) % 9 == 0
    axes = plots.kept_and_removed(cloud, keep)
    assert legend(axes) == ["kept: 10,000", "removed: 80,000"]
    axes = plots.clusters(cloud, np.arange(90_000) % 7)
    assert legend(axes) == ["6 clusters", "12,858 noise points"]
    axes = plots.difference(BOX, BOX[:, 0] > 5, BOX[:, 1] > 2)
    assert legend(axes)[:2] == ["wrongly removed: 2", "wrongly kept: 2"]


def test_large_clouds_are_thinned_evenly_with_a_note():
    axes = plots.from_above(street(120_000), limits=(-100, 100, -100, 100))
    assert len(axes.collections[0].get_offsets()) == 30_000
    assert "1 of 4 points shown" in texts(axes)
    # Taking every fourth point in scanner order would show only 16 of the 64 beams.
    beams = np.arange(120_000) % 64
    rows, _ = arguments.drawn_rows(axes, np.zeros(120_000), np.zeros(120_000))
    assert np.bincount(beams[rows]).min() > 350
    assert not any("shown" in text for text in texts(plots.from_above(street(30_000))))


def test_a_small_region_is_not_thinned():
    cloud = street(60_000)
    axes = plots.from_above(cloud, limits=(0, 3, 0, 3))
    assert not any("1 of" in text for text in texts(axes))


def test_invalid_rows_are_counted():
    axes = plots.from_above(CLOUDS["some not finite"])
    assert "5 invalid rows not shown" in texts(axes)


def test_forty_two_labels_differ_in_colour_and_marker():
    axes = plots.clusters(np.column_stack([np.arange(42)] * 3), np.arange(1, 43))
    styles = {
        (line.get_marker(), line.get_color()) for line in axes.lines if len(line.get_xdata()) == 1
    }
    assert len(styles - {(">", style.PAPER)}) == 42


def test_only_the_twelve_largest_clusters_are_labelled():
    labels = np.repeat(np.arange(1, 21), np.arange(1, 21))
    axes = plots.clusters(street(len(labels)), labels, names=True)
    labelled = {int(text) for text in texts(axes) if text.isdigit()}
    assert labelled == set(range(9, 21))


def test_level_lines_and_marks_are_labelled():
    assert "z = −1.2 m" in texts(plots.from_side(BOX, level=-1.2))
    assert "z = −5 m" in texts(plots.from_side(BOX, level=-5))
    png(plots.from_side(BOX, level=-5, limits=(0, 10, -2, 0)))
    assert "road: −1.73" in texts(plots.histogram([1, 2], marks={"road": -1.73}))


def outlines(axes, wanted):
    """Return the lower left and upper right corner of some texts of a figure, in pixels."""
    axes.figure.canvas.draw()
    boxes = [text.get_window_extent() for text in axes.texts if text.get_text() in wanted]
    assert len(boxes) == len(wanted)
    return [box.get_points() for box in boxes]


@pytest.mark.parametrize("count", [1, 3])
def test_names_in_a_histogram_are_above_its_bars(count):
    marks = {f"mark {number}": 5.0 for number in range(count)}
    axes = plots.histogram(np.repeat([0.0, 5.0, 9.0], [1, 100, 1]), marks=marks)
    tallest = max(bar.get_window_extent().y1 for bar in axes.patches)
    written = outlines(axes, [f"{name}: 5" for name in marks])
    assert min(low[1] for low, _ in written) > tallest


@pytest.mark.parametrize(
    "draw",
    [
        lambda cloud, labels: plots.clusters(cloud, labels, names=True, limits=((-3, 9), (-3, 3))),
        lambda cloud, labels: plots.boxes(
            [BOX * [0.1, 0.1, 1] + [0, 0.5 * row, 0] for row in range(4)],
            cloud=cloud,
            names=range(1, 5),
            limits=((-3, 9), (-3, 3)),
        ),
    ],
)
def test_names_cover_neither_each_other_nor_their_points(draw):
    """Draw a column of four clusters, in which a name above a cluster would cover the next one."""
    labels = np.repeat([1, 2, 3, 4], 25)
    spots = np.stack(np.meshgrid(*[np.linspace(-0.2, 0.2, 5)] * 2), axis=-1).reshape(-1, 2)
    places = np.array([(0.6, 0.2), (0.6, 0.7), (0.6, 1.2), (0.6, 1.7)])
    cloud = np.column_stack([(places[:, None] + spots).reshape(-1, 2), np.zeros(100)])
    axes = draw(cloud, labels)
    written = outlines(axes, ["1", "2", "3", "4"])
    pixels = axes.transData.transform(cloud[:, :2])
    for low, high in written:
        assert not ((pixels > low) & (pixels < high)).all(axis=1).any()
        overlaps = [(low < other[1]).all() and (high > other[0]).all() for other in written]
        assert sum(overlaps) == 1  # with itself


def test_names_of_boxes_do_not_cover_those_of_an_earlier_call():
    axes = plots.boxes(BOX[None], names=["before"], reference=True, limits=((0, 12), (-3, 6)))
    plots.boxes(BOX[None], names=["after"], axes=axes)
    (first, second) = outlines(axes, ["before", "after"])
    assert (first[0] > second[1]).any() or (first[1] < second[0]).any()


def test_names_of_boxes_outside_the_view_are_left_out():
    corners = [BOX, BOX + [100, 0, 0]]
    axes = plots.boxes(corners, names=["near", "far"], limits=((0, 10), (0, 5)))
    assert "near" in texts(axes) and "far" not in texts(axes)


def test_points_are_named_by_row_or_by_letter():
    assert {"0", "1", "2"} <= set(texts(plots.graph(QUIZ[:3], names=True)))
    assert {"a", "b", "c"} <= set(texts(plots.graph(QUIZ[:3], names="abc")))


def test_bars_have_their_numbers_with_all_digits_of_thousands():
    axes = plots.compare({"a": 7_100_000, "b": 58_658, "c": -1234.4, "d": 0.12346, "e": 1e12})
    assert texts(axes) == ["7,100,000", "58,658", "−1,234", "0.1235", "1e+12"]


def test_timing_writes_the_exponent_and_the_names():
    n = np.array([100, 1000, 10_000])
    axes = plots.timing({"naive": (n, 1e-6 * n**2.0), "cells": (n, 1e-6 * n)})
    assert legend(axes) == ["naive: n^2.0", "cells: n^1.0"]
    assert {"naive", "cells"} <= set(texts(axes))
    assert axes.get_xscale() == axes.get_yscale() == "log"
    assert legend(plots.timing({"naive": (n, n)}, fit=False)) == ["naive"]


def test_limits_may_be_four_numbers_or_two_pairs():
    for limits in ((-5, 10, -2, 3), ((-5, 10), (-2, 3)), np.array([[-5, 10], [-2, 3]])):
        axes = plots.from_above(BOX, limits=limits)
        assert (*axes.get_xlim(), *axes.get_ylim()) == (-5, 10, -2, 3)


def test_boxes_can_be_drawn_over_another_figure():
    axes = plots.from_above(street(500), limits=(-20, 20, -10, 10), title="Scan")
    plots.boxes(BOX[None] + 50, axes=axes, label="yours")
    plots.boxes(BOX[None], axes=axes, label="true", reference=True)
    assert axes.get_xlim() == (-20, 20)
    assert axes.get_title(loc="left") == "Scan"
    assert legend(axes) == ["yours: 1", "true: 1"]


def test_a_few_distant_returns_do_not_shrink_the_rest():
    cloud = street(20_000)
    cloud[:20, :2] = 5000
    assert plots.from_above(cloud).get_xlim()[1] < 500
    assert plots.from_above(cloud[:1000]).get_xlim()[1] > 5000


@pytest.mark.parametrize("seed", range(5))
def test_boxes_in_any_order_of_corners_look_the_same(seed):
    order = np.random.default_rng(seed).permutation(8)
    outline = plots.boxes(BOX[None, order]).collections[0].get_segments()[0]
    assert {tuple(corner) for corner in outline} == {(4, 1), (8, 1), (8, 3), (4, 3)}
    assert (outline[0] == outline[-1]).all() and len(outline) == 5


def test_edges_of_a_box_are_found_in_any_order_of_corners():
    order = np.random.default_rng(3).permutation(8)
    from utils.plots.corners import _edges

    lengths = [np.abs(BOX[order][a] - BOX[order][b]) for a, b in _edges(BOX[order])]
    assert sorted(length.sum() for length in lengths) == [1.7] * 4 + [2] * 4 + [4] * 4
    assert all(np.count_nonzero(length) == 1 for length in lengths)


def test_the_line_and_its_band_agree_with_the_equation():
    axes = plots.line_model(QUIZ, (3, 4, 5), None, 0.5)
    line = next(line for line in axes.lines if line.get_label() == "line")
    across, up = line.get_data()
    assert np.allclose(3 * across + 4 * up + 5, 0)
    band = axes.patches[0].get_xy()
    assert np.allclose(np.abs(band @ [3, 4] + 5) / 5, 0.5)
    assert "within 0.5 m" in legend(axes)


def test_wrong_points_are_drawn_above_the_sensor():
    lost = np.zeros((3, 4))
    axes = plots.difference(lost, [True] * 3, [False] * 3)
    layers = {line.get_marker(): line.get_zorder() for line in axes.lines if len(line.get_xdata())}
    assert layers["^"] > layers[">"]


def test_a_plane_is_cut_through_the_sensor():
    axes = plots.plane_model(BOX, (0.1, 0.2, 1, 1.7), None, 0.1)
    across, up = next(line for line in axes.lines if line.get_label() == "plane").get_data()
    assert np.allclose(0.1 * across + up + 1.7, 0)
    assert "the plane is seen face on" in texts(plots.plane_model(BOX, (0, 1, 0, -2)))


def test_pruned_regions_are_the_largest_without_a_visited_node():
    root = balanced_tree(QUIZ)
    axes = plots.kd_search(QUIZ, root, (-6, 7), 3.0, [7, 0, 3], limits=(-10, 10, -10, 10))
    hatched = [patch for patch in axes.patches if patch.get_hatch() and patch.get_width()]
    # The pruned regions: right of the root, above node 0 in the left half, and
    # right of node 3's cut.
    lowers = np.array([patch.get_xy() for patch in hatched])
    sizes = np.array([(patch.get_width(), patch.get_height()) for patch in hatched])
    assert sizes.prod(axis=1).max() == pytest.approx(9.8 * 20)
    inside = (QUIZ[:, None] > lowers + 1e-9) & (QUIZ[:, None] < lowers + sizes - 1e-9)
    assert not inside.all(axis=2).any(axis=1)[[7, 0, 3]].any()
    assert len(hatched) == 3
    assert {"pruned: 3 branches, 8 points", "3 looked at"} <= set(legend(axes))


def test_regions_that_a_search_has_not_reached_are_not_marked_as_pruned():
    root, visited = balanced_tree(QUIZ), [7, 0, 3, 9, 1, 2]
    marks = {"pruned": "//", "not yet": ".."}
    for steps, expected in (
        (0, {"not yet": "1 branch, 11 points"}),
        (1, {"pruned": "1 branch, 5 points", "not yet": "1 branch, 5 points"}),
        (6, {"pruned": "1 branch, 5 points"}),
    ):
        axes = plots.kd_search(QUIZ, root, (-6, 7), 3.0, visited, found=[0, 1], steps=steps)
        labels = legend(axes)
        for name, hatch in marks.items():
            assert (f"{name}: {expected.get(name)}" in labels) == (name in expected)
            assert (hatch in [patch.get_hatch() for patch in axes.patches]) == (name in expected)
        assert f"{steps} looked at" in labels
        assert ("2 found" in labels) == (steps == 6)
        tree = plots.kd_tree(root, visited=visited, found=[0, 1], steps=steps)
        assert ("pruned" in legend(tree)) == ("pruned" in expected)


def test_invalid_trees_are_drawn():
    loop = Node(QUIZ[0], 0)
    loop.left = Node(QUIZ[1], 1, right=loop)
    chain = None
    for index in range(3000):
        chain = Node(QUIZ[index % 11], index, right=chain)
    for root in (loop, chain):
        png(plots.kd_tree(root))
        png(plots.kd_splits(QUIZ, root))


def test_worst_ignores_the_numbering_of_clusters():
    expected = np.repeat([1, 2, 3], [4, 3, 4])
    panels = plots.worst(QUIZ, 10 - expected, expected)
    assert "differ: 0" in legend(panels[0])
    assert panels[0].get_title(loc="left") == "yours: 3 clusters"
    merged = np.where(expected == 3, 2, expected)
    panels = plots.worst(QUIZ, merged, expected)
    assert "differ: 3" in legend(panels[0])


@pytest.mark.slow
def test_dark_styles_do_not_change_figures():
    def picture(draw):
        picture = png(draw())
        plt.close("all")
        return picture

    for draw in (
        lambda: plots.from_above(street(300), title="Title"),
        lambda: plots.timing({"naive": ([100, 200, 400], [0.1, 0.4, 1.6])}, title="Title"),
        lambda: plots.label_confusion([1, 1, 2], [2, 2, 1]),
        lambda: plots.kd_search(QUIZ, balanced_tree(QUIZ), (-6, 7), 3.0, [7, 0], title="Title"),
    ):
        light = picture(draw)
        with plt.style.context("dark_background"):
            dark = picture(draw)
        assert light == dark


def test_interactive_mode_set_at_the_first_figure_is_kept(monkeypatch):
    # Jupyter turns on interactive mode at the first figure; otherwise, later figures are not shown.
    def subplots(*arguments, subplots=plt.subplots, **options):
        matplotlib.interactive(True)
        return subplots(*arguments, **options)

    monkeypatch.setattr(plt, "subplots", subplots)
    plots.histogram([1.0, 2.0])
    interactive = matplotlib.is_interactive()
    matplotlib.interactive(False)
    assert interactive


def test_figures_are_opaque():
    picture = plt.imread(io.BytesIO(png(plots.from_above(street(100)))))
    assert picture.shape[2] == 3 or (picture[..., 3] == 1).all()


def contrast(first, second):
    """Return the contrast ratio of two colours as defined in WCAG 2."""
    luminances = []
    for colour in (first, second):
        channels = np.array(matplotlib.colors.to_rgb(colour))
        linear = np.where(
            channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4
        )
        luminances.append(linear @ [0.2126, 0.7152, 0.0722])
    return (max(luminances) + 0.05) / (min(luminances) + 0.05)


def test_text_has_enough_contrast():
    from utils.plots.comparison import CELL_COLOURS

    for ink in (style.INK, style.MUTED):
        assert contrast(ink, style.PAPER) >= 4.5
    assert contrast("white", style.BLUE) >= 4.5
    assert all(contrast(style.INK, shade) >= 4.5 for shade in CELL_COLOURS.colors)


def test_hundreds_of_clusters_need_few_artists():
    labels = np.random.default_rng(0).integers(0, 800, 60_000)
    axes = plots.clusters(street(60_000), labels)
    assert len(axes.lines) < 60


def test_importing_plots_keeps_settings_and_utils_loads_no_matplotlib():
    code = """
import sys
import utils
assert "matplotlib" not in sys.modules
import matplotlib
before = dict(matplotlib.rcParams)
import utils.plots
after = dict(matplotlib.rcParams)
assert {k for k in before if before[k] != after[k]} <= {"backend"}, "settings changed"
"""
    subprocess.run([sys.executable, "-c", code], check=True)


def test_every_public_function_is_tested_and_documented():
    drawn = {name.split(",")[0] for name in [*ON_CLOUDS, *SMALL, *ROWS]} - {"no boxes"}
    assert drawn | {"ring"} == set(plots.__all__)
    for name in plots.__all__:
        assert "Parameters\n" in getattr(plots, name).__doc__


def colours_of(axes):
    points = axes.collections[0]
    return points.norm.vmin, points.norm.vmax


def test_colours_cover_the_values_of_the_visible_points():
    cloud = np.column_stack([np.arange(101.0), np.zeros(101), np.linspace(-2, 8, 101)])
    for draw in (plots.from_above, plots.from_side):
        assert colours_of(draw(cloud)) == pytest.approx((-1.9, 7.9))
        assert colours_of(draw(cloud, limits=((-1, 50), (-9, 9)))) == pytest.approx((-1.95, 2.95))
        assert colours_of(draw(cloud, span=(-2, 2))) == (-2, 2)
    assert colours_of(plots.from_above(BOX, values=BOX[:, 0], span=(0, 9))) == (0, 9)
    assert colours_of(plots.from_above(BOX, limits=(50, 60, 50, 60))) == (0, 1)  # no point


def test_side_views_say_when_they_are_stretched_and_can_be_to_scale():
    assert plots.from_side(BOX).get_ylabel() == "z, up (m), stretched"
    axes = plots.from_side(BOX, to_scale=True)
    assert (axes.get_ylabel(), axes.get_aspect()) == ("z, up (m)", 1)
    assert plots.boxes(BOX[None, :8, :3], view="side to scale").get_aspect() == 1
    for view, aspect in (("side", "auto"), ("side to scale", 1)):
        assert plots.graph(BOX, [(0, 1)], view=view).get_aspect() == aspect
        panels = plots.growth(BOX, np.eye(len(BOX), dtype=int)[:2], view=view)
        assert [panel.get_aspect() for panel in panels] == [aspect] * 2


def test_clusters_keep_the_colours_of_another_figure():
    positions = np.repeat([[0.0, 0, 0], [5, 0, 0], [10, 0, 0]], 20, axis=0)
    before, after = np.repeat([1, 2, 3], 20), np.repeat([3, 1, 1], 20)
    after[-1] = 2

    def colour_at_the_origin(axes):
        lines = [line for line in axes.lines if list(line.get_xdata()) == [0.0] * 20]
        return lines[0].get_color()

    alone, other = plots.clusters(positions, before), plots.clusters(positions, after, like=before)
    assert colour_at_the_origin(alone) == colour_at_the_origin(other)


def test_a_ring_is_round_even_if_the_axes_have_different_scales():
    axes = plots.curves({"steep": ([0, 1], [0, 900])}, across="x", up="y")
    plots.ring(axes, 0.5, 450, radius=0.1, text="here")
    axes.figure.canvas.draw()
    width, height = axes.patches[-1].get_window_extent().size
    assert width == pytest.approx(height, rel=0.25)
    assert "here" in texts(axes)


def tops_of_titles(axes):
    axes[0].figure.canvas.draw()
    return [panel._left_title.get_window_extent().y0 for panel in axes]


def test_titles_in_a_row_of_panels_are_level():
    lines = {f"a long name for line {number}": ([0, 1], [0, number]) for number in range(5)}
    for first, second in ((lines, {"short": ([0, 1], [0, 1])}), ({"short": ([0], [1])}, lines)):
        _, pair = plt.subplots(1, 2, figsize=(8.5, 4), layout="compressed")
        plots.curves(first, title="left", axes=pair[0])
        plots.curves(second, title="right", axes=pair[1])
        left, right = tops_of_titles(pair)
        assert left == pytest.approx(right, abs=1)
        assert left > pair[0].get_legend().get_window_extent().y1
        assert left > pair[1].get_legend().get_window_extent().y1
    # Panels with equal scales have different heights here, but their top edges are level.
    _, pair = plt.subplots(1, 2, figsize=(8.5, 4), layout="compressed")
    plots.from_above(BOX, limits=(0, 20, 0, 10), title="wide", axes=pair[0])
    plots.from_above(BOX, limits=(0, 10, 0, 10), title="square", axes=pair[1])
    wide, square = tops_of_titles(pair)
    assert wide == pytest.approx(square, abs=1)
    # Another row, and a panel whose legend was removed, keep their distance.
    _, grid = plt.subplots(2, 2, layout="compressed")
    for axes in grid[0]:
        plots.curves({"short": ([0], [1])}, title="no legend", axes=axes)
        axes.get_legend().remove()
        axes.set_title("no legend", loc="left", pad=6)
    before = [panel.titleOffsetTrans.transform((0, 0))[1] for panel in grid[0]]
    plots.curves(lines, title="other row", axes=grid[1, 0])
    assert [panel.titleOffsetTrans.transform((0, 0))[1] for panel in grid[0]] == before
