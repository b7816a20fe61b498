"""Which files below `submitted/` are judged, and the reasons why others are not."""

import os

import pytest

from grader.classroom.submissions import find_submissions, unaccounted_files
from tests.archives import notebook
from tests.class_of_three import LESSON, class_of_three, grade_class


@pytest.fixture
def course(tmp_path):
    return class_of_three(tmp_path / "course")


def test_a_link_to_another_students_folder_earns_nothing(course, sandbox):
    (course.submitted / "thief").mkdir()
    (course.submitted / "thief" / LESSON.stage).symlink_to(
        course.submitted / "ada" / LESSON.stage, target_is_directory=True
    )
    (course.submitted / "twin").symlink_to(course.submitted / "ada", target_is_directory=True)
    verdicts = grade_class(course, sandbox)
    assert verdicts["ada"].score == 30
    for name in ("thief", "twin"):
        assert verdicts[name].score == 0
        assert "in a linked folder" in verdicts[name].problems[0]


def test_files_that_are_not_judged_are_listed_with_a_reason(course):
    stage = course.submitted / "ada" / LESSON.stage
    (stage / "helper.py").write_text("")
    (stage / "timestamp.txt").write_text("")
    (stage / "submission_secret.txt").write_text("")
    assert unaccounted_files(course) == []
    (stage / "08_bounding_boxes.md").write_text("")
    (stage / "06_filter_ground.py").write_text("")
    (stage / "my work.zip").write_bytes(b"")
    (stage / "01_point_clouds.ipynb").write_text("{}")
    (course.submitted / "ada" / "06_filter_ground.ipynb").write_text("{}")
    reasons = {str(path): reason for path, reason in unaccounted_files(course)}
    assert set(reasons.values()) == {
        "it is not a notebook; submit 08_bounding_boxes.ipynb as Jupyter saves it",
        "it is not a notebook; submit 06_filter_ground.ipynb as Jupyter saves it",
        "it is a zip; run python -m grader collect 'submitted/ada/stage3_obstacles/my work.zip' "
        "--stage stage3_obstacles --who 'my work=ada', and delete the zip",
        "01_point_clouds belongs to stage1_ransac; move it to ada/stage1_ransac/",
        "it is not in <student>/<stage>/; move it to ada/stage3_obstacles/",
    }
    assert len(find_submissions(course)) == 3


@pytest.mark.parametrize(
    "name",
    [
        "06_filter_ground (1).ipynb",
        "06_filter_ground-Copy1.ipynb",
        "Copy of 06_filter_ground.ipynb",
        "06_Filter_Ground.IPYNB",
        "ada_lovelace_123_456_06_filter_ground-2.ipynb",
        "homework/06_filter_ground.ipynb",
        "8 final.ipynb",  # its content identifies the lesson
        "06_filter_ground.ipynb.txt",
        "06_filter_ground.ipynb.json",
        "8.IPYNB.txt",
    ],
)
def test_a_renamed_file_is_recognised_and_noted(course, name):
    stage = course.submitted / "eve" / LESSON.stage
    (stage / name).parent.mkdir(parents=True)
    (stage / name).write_bytes(notebook(LESSON.name))
    (found,) = [
        submission for submission in find_submissions(course) if submission.student == "eve"
    ]
    notes = found.read(course).notes
    assert bool(notes) == (found.path.name != "06_filter_ground.ipynb")
    assert unaccounted_files(course) == []


def test_a_folder_with_many_files_is_listed_instead_of_the_files(course):
    stage = course.submitted / "ada" / LESSON.stage
    for number in range(30):
        (stage / f"{number}.png").write_text("")
        module = stage / f"venv/lib/python3.12/site-packages/numpy/{number}.ipynb"
        module.parent.mkdir(parents=True, exist_ok=True)
        module.write_text("")
        (stage / "venv" / "bin" / str(number)).mkdir(parents=True)
        (stage / "venv" / "bin" / str(number) / "activate").write_text("")
    (course.submitted / "eve" / LESSON.stage).mkdir(parents=True)
    (course.submitted / "eve" / LESSON.stage / "photo.png").write_text("")
    reason = "it is not a notebook from this course"
    assert {str(path): reason for path, reason in unaccounted_files(course)} == {
        f"submitted/ada/{LESSON.stage}": f"30 files: {reason}",
        f"submitted/ada/{LESSON.stage}/venv": f"30 files: {reason}",
        f"submitted/eve/{LESSON.stage}/photo.png": reason,
    }


def test_the_newest_of_several_files_counts(course):
    stage = course.submitted / "eve" / LESSON.stage
    stage.mkdir(parents=True)
    for age, name in enumerate(
        ("06_filter_ground (1)", "06_filter_ground", "06_filter_ground (2)")
    ):
        (stage / f"{name}.ipynb").write_text("{}")
        os.utime(stage / f"{name}.ipynb", (1000, 1000 + (age == 1)))
    (found,) = [
        submission for submission in find_submissions(course) if submission.student == "eve"
    ]
    assert found.path.name == "06_filter_ground.ipynb"
    assert "The newest, 06_filter_ground.ipynb, was judged" in found.read(course).notes[0]
    os.utime(stage / "06_filter_ground.ipynb", (1000, 1000))  # now the number of the copy decides
    (found,) = [item for item in find_submissions(course) if item.student == "eve"]
    assert found.path.name == "06_filter_ground (2).ipynb"
    assert unaccounted_files(course) == []
