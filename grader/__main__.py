"""``python -m grader``: every command of the course's own tools."""

import sys

from grader.cli import main

sys.exit(main())
