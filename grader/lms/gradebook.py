"""Find and open a course's nbgrader gradebook."""

from __future__ import annotations

import contextlib
import functools
import re
from collections.abc import Iterator
from pathlib import Path

import nbgrader.api
from alembic.config import Config as AlembicConfig
from alembic.script import ScriptDirectory
from nbgrader.api import Gradebook, InvalidEntry
from nbgrader.coursedir import CourseDirectory
from sqlalchemy import make_url
from sqlalchemy.exc import OperationalError, SQLAlchemyError

from grader.course.nbgrader_settings import course_settings
from grader.course.paths import Course
from grader.lms.results import GradebookUnavailable

# Messages of SQLite and PostgreSQL about a missing column or table.
_OUTDATED_SCHEMA = re.compile(r"no such (column|table)|(column|relation) \S+ does not exist")


@contextlib.contextmanager
def open_gradebook(course: Course) -> Iterator[Gradebook]:
    """Open the nbgrader gradebook of a course as a context manager; create it if necessary.

    Raises
    ------
    GradebookUnavailable
        If the database driver is missing, if the database cannot be opened, or if it refuses a
        query inside the context.
    """
    # For each new gradebook, nbgrader would start a program that finds the schema version, which
    # takes seconds.
    nbgrader.api.get_alembic_version = _alembic_version
    directory = CourseDirectory(config=course_settings(course.root))
    try:
        book = Gradebook(directory.db_url, directory.course_id)
    except ModuleNotFoundError as error:
        raise GradebookUnavailable(
            f"The gradebook needs the package {error.name}, which is not installed. For "
            "PostgreSQL, write c.CourseDirectory.db_url = "
            '"postgresql+pg8000://USER:PASSWORD@HOST/DATABASE" into nbgrader_config.py, and run: '
            "pip install pg8000 -c constraints.txt"
        ) from error
    except (SQLAlchemyError, InvalidEntry) as error:
        raise GradebookUnavailable(
            database_problem(error)
            or f"The gradebook cannot be opened: {_reason(error)}. Correct its address, "
            "c.CourseDirectory.db_url, in nbgrader_config.py."
        ) from error
    try:
        with book, _without_tracebacks():
            yield book
    except (SQLAlchemyError, InvalidEntry) as error:
        problem = database_problem(error)
        if not problem and not isinstance(error, OperationalError):
            raise
        raise GradebookUnavailable(
            problem or f"The gradebook cannot be read or written: {_reason(error)}."
        ) from error


@contextlib.contextmanager
def _without_tracebacks() -> Iterator[None]:
    """Suppress the tracebacks that nbgrader prints for errors that it also raises."""
    before = nbgrader.api.app_log.disabled
    nbgrader.api.app_log.disabled = True
    try:
        yield
    finally:
        nbgrader.api.app_log.disabled = before


def database_problem(error: Exception) -> str:
    """Describe a problem that affects the whole database; empty if the error is another one."""
    text = str(error)
    if "database is locked" in text:
        return (
            "The gradebook is locked, because another program is writing to it. Run the same "
            "command again in a minute."
        )
    if _OUTDATED_SCHEMA.search(text):
        return (
            f"The gradebook was created by an older version of nbgrader: {_reason(error)}. Run: "
            "nbgrader db upgrade"
        )
    return ""


def _reason(error: Exception) -> str:
    return str(error).splitlines()[0].rstrip(".")


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
