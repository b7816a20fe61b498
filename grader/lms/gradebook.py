"""nbgrader's gradebook of a course: where it is, and how it opens."""

from __future__ import annotations

import functools
from pathlib import Path

import nbgrader.api
from alembic.config import Config as AlembicConfig
from alembic.script import ScriptDirectory
from nbgrader.api import Gradebook
from nbgrader.coursedir import CourseDirectory
from sqlalchemy import make_url
from sqlalchemy.exc import SQLAlchemyError

from grader.course.nbgrader_settings import course_settings
from grader.course.paths import Course
from grader.lms.results import GradebookUnreachable


def open_gradebook(course: Course) -> Gradebook:
    """Open nbgrader's gradebook of a course, made where there is none; a context manager.

    Raises
    ------
    GradebookUnreachable
    """
    # nbgrader starts a program for this, which takes seconds for each new gradebook.
    nbgrader.api.get_alembic_version = _alembic_version
    directory = CourseDirectory(config=course_settings(course.root))
    try:
        return Gradebook(directory.db_url, directory.course_id)
    except ModuleNotFoundError as error:
        raise GradebookUnreachable(
            f"The gradebook needs the package {error.name}, which is not installed. For PostgreSQL "
            'write c.CourseDirectory.db_url = "postgresql+pg8000://USER:PASSWORD@HOST/DATABASE" '
            "into nbgrader_config.py, and run: pip install pg8000 -c constraints.txt"
        ) from error
    except SQLAlchemyError as error:
        reason = str(error).splitlines()[0].rstrip(".")
        raise GradebookUnreachable(
            f"The gradebook cannot be opened: {reason}. c.CourseDirectory.db_url in "
            "nbgrader_config.py says where it is."
        ) from error


def is_there(course: Course) -> bool:
    """Whether there is a gradebook to open; on a server, whether there is one it tells itself."""
    url = make_url(database_url(course))
    return url.drivername != "sqlite" or Path(url.database or "").is_file()


def address(course: Course) -> str:
    """Where the gradebook is, without a password."""
    url = make_url(database_url(course))
    return url.database if url.drivername == "sqlite" else url.render_as_string(True)


def database_url(course: Course) -> str:
    """Where the gradebook is, for whoever connects to it."""
    return CourseDirectory(config=course_settings(course.root)).db_url


@functools.cache
def _alembic_version() -> str:
    """The version of nbgrader's tables."""
    settings = AlembicConfig()
    folder = Path(nbgrader.api.__file__).parent / "alembic"
    settings.set_main_option("script_location", str(folder))
    return ScriptDirectory.from_config(settings).get_current_head()
