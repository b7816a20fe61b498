"""Common checks for the clustering functions from lessons 05 and 10; see `common_checks`."""

from collections.abc import Callable

import numpy as np

from utils.checks import common_checks
from utils.checks.assertions import CheckFailed, as_labels, brief_text, frozen
from utils.checks.clusters import (
    GROUPS,
    LABELS,
    assert_clusters,
    cluster_count_text,
    renumber_by_appearance,
    require_simplest_clusters,
)
from utils.checks.common_checks import Case, promise
from utils.checks.failures import fixed


def case_of(lesson: str, exercise: str) -> Case:
    """Return a case with three groups that are far apart, for the promises of an exercise.

    Parameters
    ----------
    lesson : str
        The `__name__` of the module that declares the promises.
    exercise : str
    """
    return Case(
        lesson,
        exercise,
        {"cloud": GROUPS, "threshold": 1.0},
        expected=LABELS,
        compare=lambda answer, cloud, limit, labels: assert_clusters(answer, labels, cloud, limit),
        precondition=require_simplest_clusters,
    )


def promise_default(case: Case, name: str, *, why: str) -> None:
    """Check that omitting the threshold gives the same clusters as 0.5 m, right or wrong."""

    def check(euclidean_clustering: Callable) -> None:
        gaps = np.array([0.05, 0.3, 0.12, 0.65, 0.2, 1.2, 0.4, 0.9, 0.56, 0.48, 0.75, 0.35])
        cloud = np.outer(2.0 + np.cumsum(gaps), [1.0, 0.0, 0.0])
        explicit_labels = as_labels(euclidean_clustering(cloud.copy(), 0.5), len(cloud))
        omitted = as_labels(euclidean_clustering(cloud.copy()), len(cloud))
        if not np.array_equal(
            renumber_by_appearance(explicit_labels), renumber_by_appearance(omitted)
        ):
            raise CheckFailed(
                fixed("If you leave out the threshold, the clusters differ from those at 0.5 m."),
                input_text="twelve points in a row",
                yours=cluster_count_text(omitted),
                expected=f"{cluster_count_text(explicit_labels)}, as with threshold=0.5",
            )

    check.__name__ = name
    title = "Uses a threshold of 0.5 m by default"
    common_checks.promise_default(case, "threshold=0.5", title=title, why=why)(check)


def promise_few_points(case: Case, name: str, *, why: str, hint: str, weight: float = 1) -> None:
    """Check the labels of an empty cloud and of a single point, with and without intensity."""
    title = "Works on an empty cloud and on a single point"

    @promise("few_points", case, name, title=title, why=why, hint=hint, weight=weight)
    def check(euclidean_clustering: Callable) -> None:
        case.precondition(euclidean_clustering)
        for columns in (3, 4):
            for n in (0, 1):
                labels = as_labels(euclidean_clustering(np.full((n, columns), 2.0), 0.8), n)
                if not (labels == 1).all():
                    raise CheckFailed(
                        fixed("A single point is a cluster, so it must get the label 1."),
                        input_text="a cloud of one point",
                        yours=brief_text(labels),
                        expected="[1]",
                        hint="Begin a new cluster even if the point has no neighbours.",
                    )


_EQUAL = frozen(np.array([[1.0, 2, 3], [5, 0, 0], [1, 2, 3], [5, 9, 0], [1, 2, 3]]))


def promise_equal_points(case: Case, name: str, *, hint: str, weight: float = 1) -> None:
    """Check that identical points share a label."""
    words = {
        "why": "A recording may contain the same point twice, and both copies belong to the "
        "same obstacle.",
        "hint": hint,
        "weight": weight,
    }

    @promise("equal_points", case, name, title="Gives equal points the same label", **words)
    def check(euclidean_clustering: Callable) -> None:
        case.precondition(euclidean_clustering)
        answer = euclidean_clustering(_EQUAL.copy(), 0.8)
        assert_clusters(answer, np.array([1, 2, 1, 3, 1]), _EQUAL, 0.8)


def promise_intensity_ignored(case: Case, name: str, *, why: str, weight: float = 1) -> None:
    """Check that only x, y and z decide whether points are close."""
    common_checks.promise_fourth_column(
        case,
        name,
        np.tile([7.0, 200.0], len(GROUPS) // 2),
        title="Ignores intensity in a fourth column",
        why=why,
        hint="Use only cloud[:, :3], the coordinates. A fourth column contains intensity.",
        weight=weight,
    )


def promise_untouched(case: Case, name: str) -> None:
    """Check that the function does not change the cloud."""
    common_checks.promise_untouched(
        case,
        name,
        why="The next step still needs the original cloud.",
        hint="Store the labels in a new array; do not write into cloud.",
    )
