"""Small calls of the functions of lesson 09, for questions about students' own code."""

from utils.questions.cases import Case

CASES = {
    "filter_clusters": (
        Case(
            "filter_clusters(np.array([1, 1, 2, 1]), min_num_points=2)",
            larger="filter_clusters(np.array([1, 1, 2, 1, 3, 3, 3, 4]), min_num_points=2)",
        ),
        Case("filter_clusters(np.array([3, 3, 3, 7, 7, 0]), min_num_points=3)"),
        Case("filter_clusters(np.array([0, 0, 0, 5]), min_num_points=2)"),
        Case("filter_clusters(np.array([2, 9, 2, 9]), min_num_points=2)"),
        Case("filter_clusters(np.array([4, 1, 4, 1, 1]), min_num_points=3)"),
        Case("filter_clusters(np.array([1, 2, 3]))"),
    ),
}
