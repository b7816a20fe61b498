"""The one line that must never blur: what a student's code can see.

Python itself, and of this project what `SHOWN` lists. No test, no solution, no grade, no other
submission. `grader.sandbox.bubblewrap` builds the walls from this list and shows nothing else.
"""

from pathlib import Path

from grader.course.paths import PROJECT

INSIDE = Path(__file__).resolve().parent / "inside"
WORKER = INSIDE / "worker.py"
SHOWN = (INSIDE, PROJECT / "utils", *sorted((PROJECT / "data").glob("*.txt")))
