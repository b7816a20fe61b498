"""Small calls of the functions of lesson 03, for questions about students' own code."""

from utils.questions.cases import Case


def _case_with_points(function: str, *points: str) -> Case:
    names = "pqr"[: len(points)]
    lines = [f"{name} = np.array([{point}])" for name, point in zip(names, points, strict=True)]
    return Case("\n".join([*lines, f"{function}({', '.join(names)})"]))


def _cloud_code(*rows: str) -> str:
    body = ",\n".join(f"    [{row}]" for row in rows)
    return f"points = np.array([\n{body},\n])\n"


def _ransac_code(cloud: str, max_iterations: int, asked: str = "inliers") -> str:
    return f"{cloud}plane, inliers = ransac_plane(points, {max_iterations}, 0.1, rng)\n{asked}"


FLOOR = ("0.0, 0.0, 1.0", "2.0, 0.0, 1.0", "0.0, 2.0, 1.0", "3.0, 3.0, 1.0")
TRIANGLE = _cloud_code("0.0, 0.0, 0.0", "2.0, 0.0, 0.0", "0.0, 2.0, 0.0")
CASES = {
    "plane_through": (
        _case_with_points("plane_through", "0.0, 0.0, 0.0", "1.0, 0.0, 0.0", "0.0, 1.0, 0.0"),
        _case_with_points("plane_through", "0.0, 0.0, 2.0", "2.0, 0.0, 2.0", "0.0, 3.0, 2.0"),
        _case_with_points("plane_through", "1.0, 0.0, 0.0", "1.0, 2.0, 0.0", "1.0, 0.0, 2.0"),
        _case_with_points("plane_through", "0.0, 0.0, 0.0", "0.0, 1.0, 0.0", "4.0, 0.0, 3.0"),
        _case_with_points("plane_through", "0.0, 0.0, 1.0", "1.0, 1.0, 1.0", "2.0, 2.0, 1.0"),
    ),
    "point_plane_distance": (
        Case("point_plane_distance(np.array([[1.0, 2.0, 5.0]]), (0.0, 0.0, 1.0, -2.0))"),
        Case(
            "points = np.array([[0.0, 0.0, 0.0], [3.0, 7.0, 0.0]])\n"
            "point_plane_distance(points, (1.0, 0.0, 0.0, -2.0))"
        ),
        Case(
            "points = np.array([[5.0, 0.0, 0.0], [0.0, 1.0, -5.0]])\n"
            "point_plane_distance(points, (0.6, 0.0, 0.8, 0.0))"
        ),
        Case(
            "points = np.array([[0.0, 5.0, 0.0], [0.0, 0.0, 10.0]])\n"
            "point_plane_distance(points, (0.0, 0.8, -0.6, 1.0))"
        ),
    ),
    "ransac_plane": (
        Case(_ransac_code(_cloud_code(*FLOOR, "1.0, 1.0, 5.0"), 100)),
        Case(_ransac_code(_cloud_code("0.0, 0.0, 9.0", *FLOOR), 100, "sum(inliers)")),
        Case(_ransac_code(TRIANGLE, 3), larger=_ransac_code(TRIANGLE, 6)),
        Case(_ransac_code(TRIANGLE, 3, "np.abs(plane)")),
        Case(_ransac_code(_cloud_code("0.0, 0.0, 1.0", "1.0, 0.0, 1.0"), 5)),
        Case(_ransac_code(_cloud_code("0.0, 0.0, 1.0", "1.0, 0.0, 1.0", "2.0, 0.0, 1.0"), 3)),
    ),
    "fit_plane": (
        Case(_cloud_code(*FLOOR[:3]) + "fit_plane(points)"),
        Case(_cloud_code("2.0, 0.0, 0.0", "2.0, 4.0, 0.0", "2.0, 0.0, 2.0") + "fit_plane(points)"),
        Case(_cloud_code("0.0, 0.0, 0.0", "4.0, 0.0, 3.0", "0.0, 2.0, 0.0") + "fit_plane(points)"),
        Case(
            _cloud_code("0.0, 3.0, 0.0", "2.0, 3.0, 0.0", "0.0, 3.0, 4.0")
            + "np.abs(fit_plane(points))"
        ),
    ),
    "iterations_needed": (
        Case("iterations_needed(0.5, 1, 0.9)"),
        Case("iterations_needed(0.5, 2, 0.5)"),
        Case("iterations_needed(0.5, 1, 0.7)"),
        Case("iterations_needed(1.0, 3, 0.99)"),
        Case("iterations_needed(0.0, 2, 0.99)"),
        Case("iterations_needed(0.9, 1, 0.8)"),
    ),
}
