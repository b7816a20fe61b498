"""Small cases that lessons 05 and 10 share: the same task, solved by two functions."""

from utils.questions.cases import Case


def _code_on_x_axis(places: str, threshold: float) -> str:
    """Return the code of a call with points on the x axis."""
    count = places.count(",") + 1
    return (
        f"cloud = np.zeros(({count}, 3))\ncloud[:, 0] = [{places}]\n"
        f"euclidean_clustering(cloud, {threshold})"
    )


def clustering_cases(function: str) -> tuple[Case, ...]:
    """Return the cases of a clustering function by its name."""
    return tuple(
        Case(*(code.replace("euclidean_clustering", function) for code in codes))
        for codes in _CODES
    )


# The code of each case, and its larger version if it has one.
_CODES = (
    (_code_on_x_axis("0.0, 0.3, 2.0", 0.5), _code_on_x_axis("0.0, 0.3, 2.0, 2.3, 4.0, 4.3", 0.5)),
    (_code_on_x_axis("0.0, 5.0, 1.0, 6.0", 2.0),),
    (_code_on_x_axis("0.0, 3.0, 2.0, 1.0", 1.5),),
    (_code_on_x_axis("7.0, 0.0, 1.0", 3.0),),
    (_code_on_x_axis("4.0, 0.0, 5.0", 1.5),),
    (
        "cloud = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])\n"
        "euclidean_clustering(cloud, 1.2)",
    ),
    (
        "cloud = np.array([[0.0, 0.0, 0.0, 9.0], [1.0, 0.0, 0.0, 2.0]])\n"
        "euclidean_clustering(cloud, 2.0)",
    ),
)
