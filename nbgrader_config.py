"""nbgrader's settings for this course. nbgrader manages the course, and `grader` judges."""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))  # so that nbgrader's commands can import `grader`

from grader.course.nbgrader_settings import configure  # noqa: E402

configure(get_config(), HERE)  # noqa: F821 (traitlets defines get_config)
