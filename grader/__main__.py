"""The command line of the grader: ``python -m grader``."""

import sys

from grader.cli import main

if __name__ == "__main__":  # worker processes also import this file
    sys.exit(main())
