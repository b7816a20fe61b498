"""Gradescope's `run_autograder`: judge one submission, or report why that is not possible.

After an error in the grader, no results are written. Gradescope then reports that the autograder
failed, and the student does not get a 0. Only instructors can see the printed output.
"""

import json
import sys
import traceback
from pathlib import Path

from grader.judging.verdict import write_atomically
from grader.lms.autograder import jails
from grader.lms.autograder.isolation import IsolationFailed, restrict_access, strongest_sandbox
from grader.lms.autograder.judging import JudgeFailed, judge_submission
from grader.lms.autograder.results import build_results
from grader.sandbox import SandboxUnavailable


def main(root: Path) -> int:
    """Judge the files in ``submission``, and write ``results/results.json``."""
    results = root / "results" / "results.json"
    results.unlink(missing_ok=True)
    try:
        restrict_access(root)
        jails.register_jails(root / "source")
        sandbox = strongest_sandbox()
        print(f"Sandbox: {sandbox.name}: {sandbox.protections()}. Built by {sandbox.label()}.")
        judged = judge_submission(root / "submission", root / "source", sandbox)
        write_atomically(json.dumps(build_results(judged), indent=1), results)
    except (IsolationFailed, SandboxUnavailable, JudgeFailed) as error:
        print(f"Nothing was judged, and no student gets a mark from this run.\n{error}")
        return 1
    except Exception:
        print(
            "Nothing was judged, and no student gets a mark from this run.\n"
            f"{traceback.format_exc()}"
        )
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
