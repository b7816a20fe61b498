"""Gradescope's `run_autograder`: judge one submission, or say why nobody may.

Whatever goes wrong with us leaves no results, and Gradescope says that the autograder failed: that
is nobody's 0. What is printed only instructors see.
"""

import json
import sys
import traceback
from pathlib import Path

from grader.judging.verdict import write_atomically
from grader.lms.autograder import jails
from grader.lms.autograder.isolation import NotClosed, close, walls_here
from grader.lms.autograder.judging import JudgeFailed, judge_submission
from grader.lms.autograder.results import results_of
from grader.sandbox import SandboxUnavailable


def main(root: Path) -> int:
    """Judge what lies in ``submission``, and write ``results/results.json``."""
    results = root / "results" / "results.json"
    results.unlink(missing_ok=True)
    try:
        close(root)
        jails.offer(root / "source")
        sandbox = walls_here()
        print(f"Walls: {sandbox.name}: {sandbox.walls()}. Built by {sandbox.label()}.")
        judged = judge_submission(root / "submission", root / "source", sandbox)
        write_atomically(json.dumps(results_of(judged), indent=1), results)
    except (NotClosed, SandboxUnavailable, JudgeFailed) as error:
        print(f"Nothing was judged, and nobody has a mark by it.\n{error}")
        return 1
    except Exception:
        print(f"Nothing was judged, and nobody has a mark by it.\n{traceback.format_exc()}")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
