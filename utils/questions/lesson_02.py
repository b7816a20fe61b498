"""Small calls of the functions of lesson 02, for questions about students' own code."""

from utils.questions.cases import Case


def _ransac_code(points: str, max_iterations: int, tolerance: float, asked: str = "inliers") -> str:
    return (
        f"points = np.array({points})\n"
        f"line, inliers = ransac_line(points, {max_iterations}, {tolerance}, rng)\n{asked}"
    )


ROW = "[[0.0, 1.0], [1.0, 1.0], [2.0, 1.0], [3.0, 1.0], [1.0, 5.0]]"
CASES = {
    "line_through": (
        Case("line_through(np.array([0.0, 0.0]), np.array([4.0, 3.0]))"),
        Case("line_through(np.array([0.0, 1.0]), np.array([2.0, 1.0]))"),
        Case("line_through(np.array([2.0, 5.0]), np.array([2.0, 3.0]))"),
        Case("line_through(np.array([1.0, 0.0]), np.array([4.0, 4.0]))"),
        Case("line_through(np.array([3.0, 2.0]), np.array([3.0, 2.0]))"),
    ),
    "point_line_distance": (
        Case("point_line_distance(np.array([[0.0, 2.0], [3.0, 0.0]]), (0.0, 1.0, -1.0))"),
        Case("point_line_distance(np.array([[1.0, 4.0], [5.0, 0.0]]), (1.0, 0.0, -2.0))"),
        Case("point_line_distance(np.array([[5.0, 0.0], [0.0, -5.0]]), (0.6, 0.8, 0.0))"),
        Case("point_line_distance(np.array([[0.0, 0.0], [10.0, 5.0]]), (0.6, -0.8, 3.0))"),
    ),
    "ransac_line": (
        Case(_ransac_code(ROW, 100, 0.1)),
        Case(
            _ransac_code("[[0.0, 0.0], [2.0, 0.0], [0.0, 3.0], [0.0, 6.0], [0.0, 7.0]]", 100, 0.1)
        ),
        Case(
            _ransac_code("[[0.0, 0.0], [4.0, 0.0]]", 3, 0.1),
            larger=_ransac_code("[[0.0, 0.0], [4.0, 0.0]]", 6, 0.1),
        ),
        Case(_ransac_code("[[1.0, 2.0]]", 5, 0.1)),
        Case(_ransac_code("[[1.0, 2.0], [1.0, 2.0]]", 3, 0.1, "line, inliers")),
        Case(_ransac_code(ROW, 100, 0.1, "sum(inliers)")),
        Case(_ransac_code("[[0.0, 0.0], [4.0, 0.0]]", 3, 0.1, "np.abs(line)")),
    ),
}
