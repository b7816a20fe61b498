"""The nbgrader settings of this course."""

from __future__ import annotations

import logging
import os
import sys
import warnings
from pathlib import Path
from typing import TYPE_CHECKING

from traitlets.config import Config
from traitlets.config.loader import PyFileConfigLoader

if TYPE_CHECKING:
    from nbgrader.converters.base import BaseConverter

COURSE_ID = "lidar_obstacle_lab"
STUB = "raise NotImplementedError"
# Files next to a notebook that nbgrader must not copy into the release.
IGNORED_PATTERNS = [".ipynb_checkpoints", "*.pyc", "__pycache__", "feedback", "*.py"]
# nbgrader's steps that turn the instructor's notebook into the student's, in default order.
RELEASE_STEPS = (
    "IncludeHeaderFooter",
    "InstantiateTests",
    "LockCells",
    "ClearSolutions",
    "ClearOutput",
    "CheckCellMetadata",
    "ComputeChecksums",
    "SaveCells",
    "ClearHiddenTests",
    "ClearMarkScheme",
    "ComputeChecksums",
    "CheckCellMetadata",
)


def configure(config: Config, root: Path) -> Config:
    """Set the course's defaults in a traitlets configuration.

    Parameters
    ----------
    config : traitlets.config.Config
    root : pathlib.Path
        The folder of the course, with ``submitted/`` and ``gradebook.db``.

    Returns
    -------
    traitlets.config.Config
        The object `config`.
    """
    config.CourseDirectory.root = str(root)
    config.CourseDirectory.course_id = COURSE_ID
    config.CourseDirectory.source_directory = "solutions"
    config.CourseDirectory.release_directory = "notebooks"
    # nbgrader must not release the folders of lessons, which are next to the solved notebooks.
    folders = (root / "solutions").glob("*/[0-9][0-9]_*/")
    config.CourseDirectory.ignore = [*IGNORED_PATTERNS, *sorted(folder.name for folder in folders)]
    config.ClearSolutions.code_stub = {"python": STUB}

    config.GenerateAssignment.preprocessors = [
        "grader.lms.nbgrader_plugin.ClearEarlierFunctions",
        *(f"nbgrader.preprocessors.{step}" for step in RELEASE_STEPS),
    ]

    # Students fetch notebooks alone, without `utils`, so these have to be standalone.
    config.ExchangeFactory.release_assignment = "grader.lms.exchange.ReleaseStandalone"
    config.ExchangeFactory.collect = "grader.lms.exchange_collection.CollectOrdinaryFiles"
    config.ExchangeFactory.release_feedback = "grader.lms.exchange.ReleaseFeedbackPerStudent"

    # If there is a roster, nbgrader must not create a student for each folder of submissions.
    config.Autograde.create_student = not (root / "roster.csv").is_file()
    # By default, nbgrader rejects a whole submission if one of its files is damaged.
    config.Autograde.exporter_class = "grader.lms.nbgrader_plugin.CopyExporter"
    config.Autograde.autograde_preprocessors = [
        "grader.lms.nbgrader_plugin.Judge",  # runs the notebook only in the sandbox
        "nbgrader.preprocessors.LimitOutput",
        "grader.lms.nbgrader_plugin.SaveGrades",
        "grader.lms.nbgrader_plugin.LatePenalties",
        "nbgrader.preprocessors.CheckCellMetadata",
    ]
    config.GenerateFeedback.exporter_class = "grader.lms.nbgrader_feedback.FeedbackExporter"
    make_alembic_reachable()
    # SQLAlchemy's warning about the order in which nbgrader adds rows is harmless.
    warnings.filterwarnings("ignore", message="Object of type <Submitted", module="nbgrader")
    return config


def make_alembic_reachable() -> None:
    """Add the directory of the Python executable to PATH; nbgrader starts ``alembic`` by name."""
    programs = str(Path(sys.executable).parent)
    if programs not in os.environ.get("PATH", "").split(os.pathsep):
        os.environ["PATH"] = programs + os.pathsep + os.environ.get("PATH", "")


def course_settings(root: Path) -> Config:
    """Return the settings of a course: the defaults, overridden by its ``nbgrader_config.py``.

    Parameters
    ----------
    root : pathlib.Path
        The folder of the course.
    """
    settings = configure(Config(), root)
    path = root / "nbgrader_config.py"
    if path.is_file():
        settings.merge(PyFileConfigLoader(path.name, path=str(root)).load_config())
    return settings


def make_converter(
    converter_class: type[BaseConverter], root: Path, stage: str, **settings: dict
) -> BaseConverter:
    """Create one of nbgrader's converters for a stage of a course.

    Parameters
    ----------
    converter_class : type
        Class of the converter, such as `nbgrader.converters.Autograde`.
    root : pathlib.Path
        The folder of the course.
    stage : str
        The stage, which nbgrader calls an assignment.
    **settings : dict
        Traits to configure, by class name.
    """
    from nbgrader.coursedir import CourseDirectory

    config = configure(Config(), root)
    config[converter_class.__name__].force = True
    for name, traits in settings.items():
        config[name].update(traits)
    instance = converter_class(coursedir=CourseDirectory(config=config), config=config)
    instance.coursedir.assignment_id = stage
    instance.log = logging.getLogger("grader.nbgrader")
    instance.log.setLevel(logging.CRITICAL)
    return instance
