"""The project files that another machine needs to judge submissions."""

from pathlib import Path

from grader.course.paths import PROJECT

FOLDERS = ("grader", "utils", "extension", "solutions", "notebooks", "data")
LESSON_FILES = ("lesson.py", "hidden_tests.py")


def files_for_judging() -> dict[str, bytes]:
    """Return the content of each file that judging may read, by path in the project, sorted."""
    files = {}
    for folder in FOLDERS:
        for path in sorted((PROJECT / folder).rglob("*")):
            name = path.relative_to(PROJECT)
            if path.is_file() and _may_be_read(name):
                files[name.as_posix()] = path.read_bytes()
    return files


def _may_be_read(name: Path) -> bool:
    if "__pycache__" in name.parts or any(part.startswith(".") for part in name.parts):
        return False
    folder, *below = name.parts
    return folder != "solutions" or len(below) < 3 or below[2] in LESSON_FILES
