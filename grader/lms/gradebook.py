"""Find and open a course's nbgrader gradebook."""

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
from grader.lms.results import GradebookUnavailable


def open_gradebook(course: Course) -> Gradebook:
    """Open the nbgrader gradebook of a course as a context manager; create it if necessary.

    Raises
    ------
    GradebookUnavailable
        If the database driver is missing or the database cannot be opened.
    """
    # Otherwise, nbgrader starts a program to find the schema version, which takes seconds for each
    # new gradebook.
    nbgrader.api.get_alembic_version = _alembic_version
    directory = CourseDirectory(config=course_settings(course.root))
    try:
        return Gradebook(directory.db_url, directory.course_id)
    except ModuleNotFoundError as error:
        raise GradebookUnavailable(
            f"The gradebook needs the package {error.name}, which is not installed. For PostgreSQL "
            'write c.CourseDirectory.db_url = "postgresql+pg8000://USER:PASSWORD@HOST/DATABASE" '
            "into nbgrader_config.py, and run: pip install pg8000 -c constraints.txt"
        ) from error
    except SQLAlchemyError as error:
        reason = str(error).splitlines()[0].rstrip(".")
        raise GradebookUnavailable(
            f"The gradebook cannot be opened: {reason}. Correct its address, "
            "c.CourseDirectory.db_url, in nbgrader_config.py."
        ) from error


def gradebook_exists(course: Course) -> bool:
    """Return whether a gradebook file exists; always True for a database on a server."""
    url = make_url(database_url(course))
    return url.drivername != "sqlite" or Path(url.database or "").is_file()


def gradebook_location(course: Course) -> str:
    """Return the location of the gradebook, without the password."""
    url = make_url(database_url(course))
    return url.database if url.drivername == "sqlite" else url.render_as_string(True)


def database_url(course: Course) -> str:
    """Return the URL of the gradebook, which may contain a password."""
    return CourseDirectory(config=course_settings(course.root)).db_url


@functools.cache
def _alembic_version() -> str:
    """Return the current version of nbgrader's database schema."""
    settings = AlembicConfig()
    folder = Path(nbgrader.api.__file__).parent / "alembic"
    settings.set_main_option("script_location", str(folder))
    return ScriptDirectory.from_config(settings).get_current_head()
