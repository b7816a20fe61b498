"""Only students on the roster are entered in the gradebook, and no submitted file is lost."""

import os
import shlex
import subprocess

import pytest

from grader.classroom.folders import misspelt_folders, unmatched_folders
from grader.classroom.submissions import find_submissions
from grader.course.roster import read_roster
from grader.lms import gradebook
from grader.lms.gradebook_writer import GradebookError, enter_verdicts
from grader.lms.instructor_notes import notes
from grader.lms.results_reader import class_results
from tests.gradebooks import (
    DISTANCE,
    EARNED,
    GROUND,
    STAGE,
    ignore_progress,
    inode,
    make_course,
    marks,
    submit,
    verdicts,
)

ROSTER = (
    "id,first_name,last_name,email,section,lms_id\n"
    "ada,Ada,Ash,ada@x.edu,A,8\n"
    "bob,Bob,Bell,,B,7\n"
    "idle,Ida,Ling,ida@x.edu,B,9\n"
    "yan,Yan,Yip,,A,126\n"
)


@pytest.fixture
def course(tmp_path):
    """Return a course with a roster; Ada and Bob have submitted."""
    course = make_course(tmp_path / "course")
    (course.root / "roster.csv").write_text(ROSTER)
    return course


def enrolled_students(course):
    with gradebook.open_gradebook(course) as book:
        return {
            student.id: (student.first_name, student.last_name, student.email, student.lms_user_id)
            for student in book.students
        }


def error_lines(course, earned=EARNED):
    with pytest.raises(GradebookError) as trouble:
        enter_verdicts(course, verdicts(course, earned), [STAGE], ignore_progress)
    return str(trouble.value).splitlines()[1:]


def test_all_students_on_the_roster_are_in_the_gradebook(course):
    enter_verdicts(course, verdicts(course), [STAGE], ignore_progress)
    assert enrolled_students(course) == {
        "ada": ("Ada", "Ash", "ada@x.edu", "8"),
        "bob": ("Bob", "Bell", None, "7"),
        "idle": ("Ida", "Ling", "ida@x.edu", "9"),
        "yan": ("Yan", "Yip", None, "126"),
    }
    assert {student for student, _ in marks(course)} == {"ada", "bob"}


def test_changes_to_the_roster_are_entered_but_blank_cells_are_ignored(course):
    enter_verdicts(course, verdicts(course), [STAGE], ignore_progress)
    with gradebook.open_gradebook(course) as book:
        book.update_or_create_student("bob", email="bob@home.edu")
    (course.root / "roster.csv").write_text(ROSTER.replace("Bell", "Bell-Ash"))
    enter_verdicts(course, verdicts(course), [STAGE], ignore_progress)
    assert enrolled_students(course)["bob"] == ("Bob", "Bell-Ash", "bob@home.edu", "7")


def test_students_not_on_the_roster_are_listed_but_not_entered(course):
    submit(course, "ghost", GROUND)
    sentences = error_lines(course, EARNED | {"ghost": {GROUND: (10.0, 20.0)}})
    assert sentences == [
        "'ghost' is not on the roster, so its scores are not entered. Either add a line for "
        "'ghost' to roster.csv, or rename the folder to the student's id."
    ]
    assert "ghost" not in enrolled_students(course) and {name for name, _ in marks(course)} == {
        "ada",
        "bob",
    }
    assert not (course.autograded / "ghost").exists()
    (course.root / "roster.csv").write_text(ROSTER + "ghost\n")
    enter_verdicts(
        course,
        verdicts(course, EARNED | {"ghost": {GROUND: (10.0, 20.0)}}),
        [STAGE],
        ignore_progress,
    )
    assert marks(course)["ghost", "test_voxel_grid"][0] == 20


def test_students_who_leave_the_roster_keep_their_marks_and_are_listed(course):
    enter_verdicts(course, verdicts(course), [STAGE], ignore_progress)
    (course.root / "roster.csv").write_text(ROSTER.replace("ada,Ada", "ida,Ada"))
    assert len(error_lines(course, EARNED | {"bob": {DISTANCE: (18.0, 1.0, 2.5)}})) == 1
    assert marks(course)["ada", "test_voxel_grid"][0] == 8.5
    assert marks(course)["bob", "test_filter_by_distance"][0] == 18, "others are still graded"
    (sentence,) = notes(course, class_results(course), None)
    assert sentence.startswith("'ada' has marks in the gradebook but is not on the roster")
    assert sentence.endswith("nbgrader db student remove ada --force")


@pytest.mark.end_to_end
@pytest.mark.parametrize("folder", ["yan ", "YAN", "  Yan"])
def test_an_id_in_another_spelling_is_matched(course, folder):
    submit(course, folder, GROUND)
    earned = EARNED | {"yan": {GROUND: (1.0, 12.5)}}
    enter_verdicts(course, verdicts(course, earned), [STAGE], ignore_progress)
    assert marks(course)["yan", "test_voxel_grid"][0] == 12.5
    assert folder not in enrolled_students(course)
    roster = read_roster(course)
    assert unmatched_folders(course, roster) == {}
    assert list(misspelt_folders(course, roster)) == [
        f"{folder!r} in submitted/ belongs to yan (Yan Yip)."
    ]


def test_no_file_is_lost_if_a_student_has_two_folders(course):
    submit(course, "yan", GROUND)
    submit(course, "yan ", DISTANCE)
    folder = course.submitted / "yan " / STAGE
    (folder / "helper.py").write_text("x = 1")
    (folder / "timestamp.txt").write_text("2026-03-01 13:00:00 UTC")
    (course.submitted / "yan" / STAGE / "timestamp.txt").write_text("2026-02-01 13:00:00 UTC")
    (course.submitted / "yan" / STAGE / "plan.txt").write_text("mine")
    earned = EARNED | {"yan": {GROUND: (1.0, 12.5), DISTANCE: (3.0, 2.0, 1.0)}}
    enter_verdicts(course, verdicts(course, earned), [STAGE], ignore_progress)
    entered = marks(course)
    assert entered["yan", "test_voxel_grid"][0] == 12.5
    assert {entered["yan", exercise.cell][0] for exercise in DISTANCE.machine_graded} == {3, 2, 1}
    copies = course.autograded / "yan" / STAGE
    assert {path.name for path in copies.iterdir()} == {
        f"{GROUND.name}.ipynb",
        f"{DISTANCE.name}.ipynb",
        "helper.py",
        "plan.txt",
        "timestamp.txt",
    }
    stage = class_results(course).stage("yan", STAGE)
    assert f"{stage.submitted_at:%Y-%m-%d}" == "2026-03-01"  # the latest submission
    (sentence,) = misspelt_folders(course, read_roster(course))
    assert sentence.endswith("belongs to yan (Yan Yip), and so does 'yan'.")
    before = inode(course, "yan")
    enter_verdicts(course, verdicts(course, earned), [STAGE], ignore_progress)
    assert inode(course, "yan") == before


def test_the_newest_of_two_folders_counts_and_the_other_is_reported(course):
    for age, folder in enumerate(("yan ", "yan")):
        submit(course, folder, GROUND, " " * age)
        path = course.submitted / folder / STAGE / f"{GROUND.name}.ipynb"
        os.utime(path, (1e9 - 1e6 * age,) * 2)
    (found,) = [
        submission for submission in find_submissions(course) if submission.student == "yan"
    ]
    assert found.path.parent.parent.name == "yan "
    (note,) = found.read(course).notes
    paths_named = [f"{folder}/{STAGE}/{GROUND.name}.ipynb" for folder in ("yan ", "yan")]
    assert (
        f"The newest, {paths_named[0]}, was judged, and these were not: {paths_named[1]}." in note
    )


def test_the_suggested_command_for_an_unmatched_folder_loses_no_file(course):
    submit(course, "Yip, Yan", GROUND)
    (sentence,) = unmatched_folders(course, read_roster(course)).values()
    command = "mv -n 'submitted/Yip, Yan' submitted/yan"
    assert (
        f"If it belongs to yan (Yan Yip), run: {command}; otherwise add a line for 'Yip, Yan' to"
        in sentence
    )
    submit(course, "yan", GROUND, " ")
    submit(course, "yan", DISTANCE)
    (course.submitted / "Yip, Yan" / "stage1_ransac").mkdir()
    (sentence,) = unmatched_folders(course, read_roster(course)).values()
    commands = sentence.partition("Yip), run: ")[2].partition("; otherwise")[0]
    assert all(shlex.split(part)[:2] == ["mv", "-n"] for part in commands.split(" && "))
    before = {path.read_bytes() for path in course.submitted.rglob("*.ipynb")}
    subprocess.run(commands, shell=True, check=True, cwd=course.root)
    assert {path.read_bytes() for path in course.submitted.rglob("*.ipynb")} == before
    assert unmatched_folders(course, read_roster(course)) == {}
    found = {
        submission.lesson: submission
        for submission in find_submissions(course)
        if submission.student == "yan"
    }
    assert len(found[GROUND].older) == 1 and found[DISTANCE].older == ()


def test_a_folder_whose_number_lost_its_leading_zeros_gets_a_suggestion(course):
    (course.root / "roster.csv").write_text("id,first_name\n0012345,Yan\n12,Zoe\n")
    submit(course, "12345", GROUND)
    sentence = unmatched_folders(course, read_roster(course))["12345"]
    assert "belongs to 0012345 (Yan), run: mv -n submitted/12345 submitted/0012345;" in sentence


def test_both_possible_owners_of_a_folder_are_listed(course):
    (course.root / "roster.csv").write_text(ROSTER + "yan2,Yan,Yip,,,\n")
    submit(course, "yanyip", GROUND)
    (sentence,) = unmatched_folders(course, read_roster(course)).values()
    assert (
        "It may belong to yan (Yan Yip) or yan2 (Yan Yip). Rename the folder to the right"
        in sentence
    )


def test_all_students_are_entered_if_there_is_no_roster(course):
    (course.root / "roster.csv").unlink()
    submit(course, "ghost", GROUND)
    enter_verdicts(
        course,
        verdicts(course, EARNED | {"ghost": {GROUND: (10.0, 20.0)}}),
        [STAGE],
        ignore_progress,
    )
    assert set(enrolled_students(course)) == {"ada", "bob", "ghost"}


def test_nbgrader_does_not_create_students_if_there_is_a_roster(course):
    from grader.course.nbgrader_settings import course_settings

    assert course_settings(course.root).Autograde.create_student is False
    (course.root / "roster.csv").unlink()
    assert course_settings(course.root).Autograde.create_student is True
