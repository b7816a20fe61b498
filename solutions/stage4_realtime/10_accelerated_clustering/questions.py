"""Small cases for questions about students' own code; see `grader.questions.cases`."""

from grader.questions.cases import Case


def _line(places: str, threshold: float) -> str:
    """Return a call with points on the x axis."""
    count = places.count(",") + 1
    return (
        f"cloud = np.zeros(({count}, 3))\ncloud[:, 0] = [{places}]\n"
        f"euclidean_clustering_accelerated(cloud, {threshold})"
    )


CASES = {
    "euclidean_clustering_accelerated": (
        Case(_line("0.0, 0.3, 2.0", 0.5), larger=_line("0.0, 0.3, 2.0, 2.3, 4.0, 4.3", 0.5)),
        Case(_line("0.0, 5.0, 1.0, 6.0", 2.0)),
        Case(_line("0.0, 3.0, 2.0, 1.0", 1.5)),
        Case(_line("7.0, 0.0, 1.0", 3.0)),
        Case(_line("4.0, 0.0, 5.0", 1.5)),
        Case(
            "cloud = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])\n"
            "euclidean_clustering_accelerated(cloud, 1.2)"
        ),
        Case(
            "cloud = np.array([[0.0, 0.0, 0.0, 9.0], [1.0, 0.0, 0.0, 2.0]])\n"
            "euclidean_clustering_accelerated(cloud, 2.0)"
        ),
    ),
}
