"""Write the students' zip files, one for each stage."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from pathlib import Path

from grader.course.archives import make_zip
from grader.course.atomic_files import write_atomically
from grader.course.lessons import all_lessons, stages
from grader.course.paths import PROJECT
from grader.course.standalone import check_no_leaks

TOP_FOLDER = "lidar_obstacle_lab"
"""Top folder in every zip, so that the zips of several stages can be unpacked into one course."""
README = PROJECT / "solutions" / "student_readme.md"
TOOLS = {
    "utils": (".py", ".html", ".js", ".json", ".md"),
    "data": (".md", ".txt", ".npz", ".png"),
}
PROGRAMS = ("jupyterlab", "ipykernel")  # needed to open and run a notebook


def write_zips(folder: Path, wanted: Iterable[str] = ()) -> Iterator[Path]:
    """Write a zip file for each stage, and yield its path when it is complete.

    Parameters
    ----------
    folder : pathlib.Path
        Created if it does not exist.
    wanted : iterable of str, optional
        Stages to write. Default: all.

    Raises
    ------
    grader.course.standalone.ReleaseError
        If a notebook would reveal a solution.
    """
    for stage in wanted or stages():
        path = folder / f"{stage}.zip"
        write_atomically(make_zip(student_files(stage)), path)
        yield path


def student_files(stage: str) -> dict[str, bytes]:
    """Return the content of each file that a student needs for a stage, by path in the zip."""
    files = {
        "README.md": README.read_bytes(),
        "LICENSE": (PROJECT / "LICENSE").read_bytes(),
        "requirements.txt": student_requirements().encode(),
        "constraints.txt": (PROJECT / "constraints.txt").read_bytes(),
        **course_tools(),
    }
    for lesson in all_lessons():
        if lesson.stage == stage:
            name = lesson.released.relative_to(PROJECT).as_posix()
            files[name] = lesson.released.read_bytes()
            check_no_leaks(lesson, files[name])
    return {f"{TOP_FOLDER}/{name}": content for name, content in files.items()}


def course_tools() -> dict[str, bytes]:
    """Return the content of each file of ``utils`` and ``data`` that students need, by path."""
    return {
        path.relative_to(PROJECT).as_posix(): path.read_bytes()
        for name, kinds in TOOLS.items()
        for path in (PROJECT / name).rglob("*")
        if path.is_file() and path.suffix in kinds
    }


def student_requirements() -> str:
    """Return a ``requirements.txt`` with the packages that open and run a notebook."""
    text = (PROJECT / "requirements.txt").read_text("utf-8")
    programs = re.findall(rf"^(?:{'|'.join(PROGRAMS)})==\S+\n", text, re.M)
    return f"-c constraints.txt\n\n{requirements_for('For the notebooks')}{''.join(programs)}"


def requirements_for(heading: str) -> str:
    """Return the lines of ``requirements.txt`` below one of its headings."""
    text = (PROJECT / "requirements.txt").read_text("utf-8")
    return re.search(rf"^# {re.escape(heading)}\n((?:\S.*\n)+)", text, re.M)[1]
