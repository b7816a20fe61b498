"""Notes are remarks on deviations that do not cost points."""

import ast

import numpy as np
import pytest

from grader.course.kept_answers import answers_to
from grader.course.lessons import lesson_of, load_reference
from tests.course_lessons import COURSE
from utils.checks.core import checks_of, notes_of, run_check
from utils.notebooks import slicing


def right_answer(exercise):
    return getattr(load_reference(lesson_of(exercise).name), exercise)


def notes_on(exercise, function):
    """Return the names of the notes on a function; assert that it passes all checks."""
    function.__name__ = exercise
    assert not any(run_check(check, function).failure for check in checks_of(exercise))
    return {note.name for note in notes_of(exercise) if run_check(note, function).failure}


@pytest.mark.parametrize(
    "exercise, note",
    [
        ("euclidean_clustering", "returns_an_array"),
        ("filter_ground", "returns_an_array"),
        ("filter_by_distance", "returns_an_array"),
        ("crop_region", "gives_an_array"),
        ("remove_ego_returns", "leaves_an_array"),
    ],
)
def test_a_list_instead_of_an_array_gets_a_note(exercise, note):
    right = right_answer(exercise)
    assert notes_on(exercise, lambda *given, **named: right(*given, **named)) == set()
    assert notes_on(exercise, lambda *given, **named: list(right(*given, **named))) == {note}


def test_a_helper_that_returns_lists_loses_nothing_and_gets_a_note():
    """The judge replaces helpers with notes, so a list costs no points in the caller either."""
    noted = set()
    for lesson in COURSE:
        names = [exercise.name for exercise in lesson.machine_graded]
        for number, caller in enumerate(names):
            sources = [answer.source for answer in answers_to(caller) if answer.right]
            statements = [
                statement for source in sources for statement in slicing.parse_notebook([source])[0]
            ]
            nodes = [node for statement in statements for node in ast.walk(statement.node)]
            read = {node.id for node in nodes if isinstance(node, ast.Name)}
            noted.update(read.intersection(names[:number]))
    assert len(noted) > 3
    without_note = set()
    for exercise in noted:
        right, converted = right_answer(exercise), []

        def as_list(*given, right=right, converted=converted, **named):
            answer = right(*given, **named)
            converted.append(isinstance(answer, np.ndarray))
            return answer.tolist() if converted[-1] else answer

        if not notes_on(exercise, as_list):
            without_note.add(exercise)
            assert not any(converted), exercise
    assert without_note == {"line_through", "plane_through"}  # they return a tuple or None


def test_a_list_of_centroids_and_rounding_up_get_notes():
    right = right_answer("voxel_grid")

    def as_list(cloud, voxel_size=0.2):
        return list(right(cloud, voxel_size)) if len(cloud) else cloud

    def rounded_up(cloud, voxel_size=0.2):
        return (
            right(cloud * [-1, -1, -1, 1][: cloud.shape[1]], voxel_size)
            * ([-1, -1, -1, 1][: cloud.shape[1]])
        )

    assert notes_on("voxel_grid", as_list) == {"gives_an_array"}
    assert notes_on("voxel_grid", rounded_up) == {"rounds_down"}


def test_clusters_in_another_order_get_a_note():
    right = right_answer("euclidean_clustering")

    def backwards(cloud, threshold=0.5):
        labels = right(cloud, threshold)
        return labels.max(initial=0) + 1 - labels

    def starting_at_the_second_point(cloud, threshold=0.5):
        """Label the clusters as if the loop began at the second point."""
        order = np.roll(np.arange(len(cloud)), -1)
        labels = np.empty(len(cloud), dtype=int)
        labels[order] = right(cloud[order], threshold)
        return labels

    assert notes_on("euclidean_clustering", backwards) == {"numbers_by_appearance"}
    assert notes_on("euclidean_clustering", starting_at_the_second_point) == {
        "numbers_by_appearance"
    }
