"""Collect archives into a course of three students, and describe the outcome."""

from grader.classroom.collect import collection
from tests.archives import EIGHT, SEVEN, SIX, make_zip, notebook

STAGE = "stage3_obstacles"
# ID, first name, last name, email address, number in the LMS and GitHub login of each student.
PEOPLE = (
    ("ada", "Ada", "Lovelace", "ada@x.edu", "4001", "ada-l"),
    ("bjorn", "Björn", "Müller", "bm@x.edu", "4002", "bmu"),
    ("cy", "Cy", "O'Neil", "cy@x.edu", "", ""),
)
MONDAY, TUESDAY = (2026, 10, 12, 9, 0, 0), (2026, 10, 13, 9, 0, 0)
LESSONS = {"6": SIX, "7": SEVEN, "8": EIGHT, "10": "10_accelerated_clustering"}


def archive(course, files, name="submissions.zip", **options):
    """Write a zip of files into the course's folder, and return its path."""
    path = course.root / name
    path.write_bytes(make_zip(files, **options))
    return path


def collect(course, *paths, stages=(STAGE,), times=None, who=None, lessons=None, level=0):
    """Collect archives without showing progress, and return the report."""
    return collection.collect(
        course, paths, stages, times, who or {}, lessons or {}, lambda *progress: None, level
    )


def states(outcome):
    """Return the state of each lesson, such as "new", by student and lesson number."""
    return {
        student: {lesson.number: state for lesson, state in found.items()}
        for student, found in outcome.states.items()
    }


def placed_files(course, student, stage=STAGE):
    """Return the names and contents of the files in a student's folder that are not hidden."""
    folder = course.submitted / student / stage
    return {path.name: path.read_bytes() for path in folder.glob("[!.]*")}


def older_files(course, student, stage=STAGE):
    """Return the contents of the files that newer work has replaced."""
    return sorted(
        path.read_bytes() for path in (course.submitted / student / stage / ".older").glob("*")
    )


def questions(outcome):
    """Return the texts of the questions about files that wait, by name."""
    return {question.name: question.text for question in outcome.questions}


def doubts(outcome):
    """Return the texts of the questions about files that were collected, by name."""
    return {question.name: question.text for question in outcome.doubts}


def archive_of(course, paths):
    """Write a zip; a path such as ``ada/6`` stands for Ada's notebook of lesson 06."""
    files = []
    for path in paths:
        folder, _, number = path.rpartition("/")
        if number in LESSONS:
            name = LESSONS[number]
            files.append((f"{folder}/{name}.ipynb", notebook(name, path)))
        else:
            files.append((path, b"x"))
    return archive(course, files)


def write_checkout(root, name, files):
    """Write a student's checkout from GitHub Classroom."""
    for path, data in {".git/HEAD": b"ref", **files}.items():
        (root / name / path).parent.mkdir(parents=True, exist_ok=True)
        (root / name / path).write_bytes(data)


def resubmission(course, first_content, second_content):
    """Write two archives with Ada's notebook of lesson 06, one made a day after the other."""
    first = archive(course, [(f"ada/{SIX}.ipynb", first_content)], "first.zip", when=MONDAY)
    second = archive(course, [(f"ada/{SIX}.ipynb", second_content)], "second.zip", when=TUESDAY)
    return first, second


def remark_texts(outcome):
    return {remark.name: remark.text for remark in outcome.remarks}


def write_roster(course, *people):
    """Replace the roster; each person is a line of comma-separated values."""
    lines = ["id,first_name,last_name,email,lms_id,github", *people]
    (course.root / "roster.csv").write_text("\n".join(lines) + "\n")
