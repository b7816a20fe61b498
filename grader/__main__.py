"""``python -m grader``: every command of the course's own tools."""

import sys

from grader.cli import main

if __name__ == "__main__":  # the judge's processes import this file, too
    sys.exit(main())
