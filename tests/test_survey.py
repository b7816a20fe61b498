"""A right answer after one edit either loses points or is still equivalent to the solution.

`python -m tests.survey` prints a table for all solutions. With the name of an exercise, it prints
the table for all right answers to that exercise.
"""

import pytest

from tests.survey import (
    EXERCISES,
    LARGEST_LOSS,
    SOLUTION,
    answers_in_notebooks,
    losses_of,
    right_functions,
    survey,
)

ANSWERS = {
    f"{exercise}: {name}": (exercise, name)
    for exercise in EXERCISES
    for name in (SOLUTION, *(function.name for function in right_functions(exercise)))
}
# Known edits that change some answers but lose no points. For each exercise, `KNOWN` has the line
# before and after each edit, and the reason why the answer may keep all points.
_LUCK = "not the plane through the sample: it finds the road by chance, as it does with this seed"
_CROSS = "normal = np.cross(q - p, r - p)"
_BETTER = "if np.count_nonzero(close) > np.count_nonzero(inliers):"
_NOT_BEST = "a plane, although not the best one: it is good enough with this seed"
_RANKS = "return np.argsort(np.argsort(start))[which]"
_ANGLE = "angle = 0.5 * math.atan2(2 * m[p][q], m[q][q] - m[p][p])"
_SMALL = "if abs(m[p][q]) < 1e-300:"
_EIG = "eig returns the axes in any order: with this seed the order is right, and right-handed"
_ORDER = "order = np.argsort(values.real)[::-1]"
_SIGN = "vectors[:, 0] *= np.linalg.det(vectors)"
_JACOBI = "the rotations end equal unless there are zeros next to the diagonal: with some seeds"
_REFIT = "normal = np.linalg.svd(near - centre, full_matrices=False)[2][2]"
_SVD = "np.linalg.svd(near - centre, full_matrices=False)[2][2]"
_REFITTED = "refitted = np.append(normal, -normal @ centre)"
_WORSE = (
    "a wrongly refitted plane has as many inliers only in tiny clouds; otherwise the first stays"
)
_HULL = "hull = points[ConvexHull(points[:, :2]).vertices, :2]"
_EDGES = "edges = np.roll(hull, -1, axis=0) - hull"
_BEST = "best = min(angles, key=lambda a: np.prod(np.ptp(turned(points, -a)[:, :2], axis=0)))"
_EDGE = "one of many edges changes: rarely the one that counts, and never with this seed"
_NEAR = "near = np.minimum(local - local.min(axis=0), local.max(axis=0) - local).min(axis=1)"
_SIDES = (
    "closeness to other sides: it finds another angle in few clusters, and in none of this seed"
)
_ABOVE_LOW = "above_low = along - along.min(axis=-1, keepdims=True)"
_CLOSENESS = "return (1 / (nearest + 0.05)).sum(axis=-1)"
_LARGER = "a worse fit: its boxes are larger, but with this seed not larger than the check permits"
_REGION = "p = p[(p > (-10, -5, -2.5)).all(axis=1) & (p < (30, 6, 1)).all(axis=1)]"
_WHOLE_SCAN = "50 samples of the whole scan may miss the road: with this seed they find it"
_THINNED = "return xyz[np.sort(np.unique(cells, axis=0, return_index=True)[1])]"
_MIRRORED = "joins mirrored cells: too few points are removed to lose a cluster, with this seed"
_NEEDED = "needed, done = max_iterations, 0"
_REFINED = "refined = _fitted(points[mask])"
_UNREFINED = f"best, best_mask = candidate, mask\n        {_REFINED}"
_NOT_KEPT = "matters only if a refitted line has fewer inliers, and with this seed none has"
_FIRST_LINE = "matters only until a sample gives a line, and with this seed an early one does"
_YAW = "yaw = max(np.radians(np.arange(90)), key=fit.closeness)"
_PAIRS = "pairs = np.reshape(pairs, (-1, 2)).astype(int, copy=False)"
_SMALLER = "smaller = point[axis] < np.float32(here.point[axis])"
_NO_COPY = "numbers from a list have no copy(): with this seed no two such points are compared"
_TARGET = "target = np.asarray(target, dtype=float)"
KNOWN = {
    "insert": {
        (_SMALLER, _SMALLER.replace("[axis])", "[axis].copy())")): _NO_COPY,
    },
    "search": {
        (_TARGET, f"tree.{_TARGET}"): "a new attribute of the tree, whose nodes stay as they are; "
        "the answer does not need the conversion",
    },
    "ransac_line": {
        (_UNREFINED, _REFINED): _NOT_KEPT,
        (_NEEDED, _NEEDED.replace("max_iterations", "(max_iterations ** 0.5)")): _FIRST_LINE,
    },
    "ransac_plane": {
        (_REFITTED, _REFITTED.replace("(normal", "((normal - 1)")): _WORSE,
        (_REFIT, _REFIT.replace(_SVD, f"({_SVD} ** 2)")): _WORSE,
        (_REFIT, _REFIT.replace(_SVD, f"({_SVD} ** 0.5)")): _WORSE,
    },
    "euclidean_clustering_accelerated": {
        (
            _PAIRS,
            f"{_PAIRS}[1:]",
        ): "the first of thousands of pairs is missing: with this seed, others join the same cells",
    },
    "get_oriented_boxes": {
        (_HULL, _HULL.replace("ConvexHull(points[:, :2])", "ConvexHull(points[:, :2][1:])")): _EDGE,
        (_HULL, _HULL.replace("ConvexHull(points[:,", "ConvexHull(points[1:,")): _EDGE,
        (_HULL, f"{_HULL}[:-1]"): _EDGE,
        (_HULL, _HULL.replace("vertices", "vertices[:-1]")): _EDGE,
        (
            _HULL,
            "hull = points[(-ConvexHull(points[:, :2]).vertices), :2]",
        ): _EDGE,
        (
            _HULL,
            "hull = points[(ConvexHull(points[:, :2]).vertices - 1), :2]",
        ): _EDGE,
        (
            _EDGES,
            "edges = (abs((np.roll(hull, -1, axis=0) - hull)))",
        ): "one of two perpendicular edges keeps its slope: other hulls are rare",
        (_BEST, _BEST.replace("(points, -a)", "(points, (abs((-a))))")): _EDGE,
        (
            _BEST,
            _BEST.replace("[:, :2]", "[:, :1]"),
        ): "the narrowest box, which is nearly always the smallest",
        (
            _BEST,
            _BEST.replace("turned(points, -a)[:, :2]", "(abs(turned(points, -a)[:, :2]))"),
        ): "other widths for clusters that cross an axis: there are none with this seed",
        (_NEAR, _NEAR.replace(".min(axis=1)", ".max(axis=1)")): _SIDES,
        (_NEAR, _NEAR.replace("np.minimum(", "np.maximum(")): _SIDES,
        (_NEAR, _NEAR.removesuffix(".min(axis=1)")): _SIDES,
        (_YAW, _YAW.replace("np.radians(np.arange(90))", "(np.arange(90))")): "ninety other "
        "angles that are about as dense",
    },
    "principal_axes": {
        (_ANGLE, _ANGLE.replace("m[p][p]", "m[p][~p]")): _JACOBI,
        (_ANGLE, _ANGLE.replace("m[p][p]", "m[~p][p]")): _JACOBI,
        (_ANGLE, _ANGLE.replace("m[p][p]", "m[p][q]")): _JACOBI,
        (_ANGLE, _ANGLE.replace("m[p][p]", "m[q][p]")): _JACOBI,
        (_SMALL, _SMALL.replace("[q]", "[-q]")): _JACOBI,
        (_SMALL, _SMALL.replace("[q]", "[~q]")): _JACOBI,
        (_ORDER, "order = np.argsort(np.floor(values.real))[::-1]"): _EIG,
        (_ORDER, "order = np.argsort((values.real ** 0.5))[::-1]"): "a variance that rounding may "
        "make negative: with some seeds",
        (
            'print("variances", values)',
            'print("variances", np.floor(values))',
        ): "raises an error if eig returns complex numbers, which it rarely does",
        (_SIGN, _SIGN.replace("[:,", "[:2,")): _EIG,
        (_SIGN, _SIGN.replace("[:,", "[:-1,")): _EIG,
    },
    "drop_invalid": {
        (
            "return cloud[~np.isnan(work[:, :3]).any(axis=1)]",
            "return work[~np.isnan(work[:, :3]).any(axis=1)]",
        ): "an infinite intensity is returned as NaN: both mean that it is missing",
    },
    "detect_obstacles": {
        (_REGION, "p = p"): _WHOLE_SCAN,
        (_THINNED, _THINNED.replace("cells", "(cells ** 2)")): _MIRRORED,
        (_ABOVE_LOW, _ABOVE_LOW.replace("min", "max")): _LARGER,
        (_CLOSENESS, _CLOSENESS.replace("+", "-")): _LARGER,
        (_CROSS, "normal = np.cross(q / p, r - p)"): _LUCK,
        (_CROSS, "normal = np.cross(q - p, r / p)"): _LUCK,
        (_BETTER, _BETTER.replace(">", "!=")): _NOT_BEST,
        (_BETTER, _BETTER.replace("(close", "(~close")): _NOT_BEST,
        (
            f"{_RANKS} + 1",
            f"{_RANKS} - 1",
        ): "the two clusters farthest behind have no box, and this seed does not test them",
    },
}


# The checks of these exercises are slow: running all edits of all right answers would take hours.
# All edits of the solution are tried, but only one in five edits of the other answers.
SLOW = (
    "ransac_plane",
    "euclidean_clustering",
    "euclidean_clustering_accelerated",
    "detect_obstacles",
)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("case", ANSWERS)
def test_an_edit_of_a_right_answer_loses_points_or_is_equivalent(case):
    exercise, name = ANSWERS[case]
    answer = next(notebook for notebook in answers_in_notebooks(exercise) if notebook.name == name)
    found = survey(exercise, [answer], 5 if exercise in SLOW and name != SOLUTION else 1)
    assert len(found.wrong) > 20
    escaped = [(edit.before, edit.after) for edit, _ in found.escaped]
    assert [pair for pair in escaped if pair not in KNOWN.get(exercise, {})] == []


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_few_answers_lose_more_than_three_fifths_for_one_edit(sandbox):
    """In a sample of each solution's edits, fewer than a tenth lose more than three fifths."""
    lost = [loss for exercise in EXERCISES for loss in losses_of(exercise, sandbox)]
    assert len(lost) > 5 * len(EXERCISES)
    severe = [(edit.before, edit.after) for share, edit in lost if share > LARGEST_LOSS]
    assert len(severe) < len(lost) / 10, severe
