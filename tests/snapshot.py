"""Compare the output of two checkouts for every kept answer: verdicts, messages and hints.

    python tests/snapshot.py write before.json        # in one checkout
    python tests/snapshot.py write after.json         # in the other
    python tests/snapshot.py compare before.json after.json

Names of exercises or lessons after the file restrict the output to them. Some answers draw random
numbers, so their output differs from run to run. To exclude them, write ``before.json`` twice under
two names, and give both to `compare`. Points may differ by a rounding error.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import os
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from grader.classroom.pool import Pool  # noqa: E402
from grader.course.kept_answers import answers_to, fill_in  # noqa: E402
from grader.course.lessons import all_lessons  # noqa: E402
from grader.intake.submission import SubmittedFiles  # noqa: E402
from grader.judging.judge import judge_files  # noqa: E402
from grader.sandbox import Limits, choose_sandbox  # noqa: E402

SEED = 20_170_405
LIMITS = Limits(call_seconds=3)
SECONDS = 4  # time limit for one check in a notebook
ROUNDING = 0.02


def answers(wanted: list[str]) -> list[tuple[str, str, int]]:
    """Return every kept answer, as (lesson, exercise, number)."""
    return [
        (lesson.name, exercise.name, number)
        for lesson in all_lessons()
        for exercise in lesson.machine_graded
        if not wanted or lesson.name in wanted or exercise.name in wanted
        for number in range(len(answers_to(exercise.name)))
    ]


def output_for(lesson_name: str, exercise: str, number: int) -> dict:
    """Return the output of the judge and `check` for one answer; the other answers are right."""
    lesson = next(lesson for lesson in all_lessons() if lesson.name == lesson_name)
    chosen = {
        other.name: next(answer.source for answer in answers_to(other.name) if answer.right)
        for other in lesson.machine_graded
    } | {exercise: answers_to(exercise)[number].source}
    notebook = fill_in(lesson, chosen)
    submission = SubmittedFiles(f"{lesson.name}.ipynb", notebook.encode())
    verdict = judge_files(submission, SEED, choose_sandbox(), lesson, "", LIMITS).as_dict()
    del verdict["seconds"]
    return {"verdict": verdict, "check": notebook_output(lesson, exercise, notebook)}


def notebook_output(lesson: object, exercise: str, notebook: str) -> str:
    """Return the text that `check` prints about an exercise."""
    from tests.students import answers_in
    from utils.checks import check, core
    from utils.checks.diagnosis import object_to_diagnose

    core.SECONDS = SECONDS
    cells = json.loads(notebook)["cells"]
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    output = io.StringIO()
    with contextlib.redirect_stdout(output), contextlib.redirect_stderr(io.StringIO()):
        try:
            owner = object_to_diagnose(exercise)  # the exercise, or its class
            check(answers_in(lesson, code, owner)[owner], exercise)
        except BaseException as error:
            print(f"{type(error).__name__}: {error}")
    return output.getvalue()


def write(path: Path, wanted: list[str]) -> None:
    """Write the output for all or for the wanted kept answers to a file."""
    found, jobs = {}, answers(wanted)
    with Pool(os.cpu_count() or 1) as pool:
        futures = {job: pool.submit(output_for, *job) for job in jobs}
        for done, (job, future) in enumerate(futures.items(), start=1):
            try:
                output = future.result()
            except Exception as error:
                output = {"error": f"{type(error).__name__}: {error}"}
            lesson, exercise, number = job
            found[f"{exercise}: {answers_to(exercise)[number].name}"] = output
            print(f"\r{done}/{len(jobs)} {lesson} {exercise}".ljust(70), end="", flush=True)
    print()
    path.write_text(json.dumps(found, indent=1, ensure_ascii=False), "utf-8")


def is_same(before: object, after: object) -> bool:
    """Return whether two outputs are the same, apart from rounding of scores."""
    if isinstance(before, dict) and isinstance(after, dict):
        return before.keys() == after.keys() and all(
            is_same(before[key], after[key]) for key in before
        )
    if isinstance(before, list) and isinstance(after, list):
        return len(before) == len(after) and all(map(is_same, before, after))
    if isinstance(before, float) or isinstance(after, float):
        return abs(before - after) <= ROUNDING
    return before == after


def differences(before: object, after: object, where: str = "") -> list[str]:
    """Return a printable text for each place where two outputs differ."""
    if isinstance(before, dict) and isinstance(after, dict):
        keys = [*before, *(key for key in after if key not in before)]
        return [
            line
            for key in keys
            for line in differences(before.get(key), after.get(key), f"{where}/{key}")
        ]
    if isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        pairs = zip(before, after, strict=True)
        return [
            line for row, (a, b) in enumerate(pairs) for line in differences(a, b, f"{where}/{row}")
        ]
    return [] if is_same(before, after) else [f"{where}:\n  - {before}\n  + {after}"]


def compare(paths: list[Path]) -> int:
    """Print how the last file differs from the first; return the number of different answers."""
    *before, after = (json.loads(path.read_text("utf-8")) for path in paths)
    different = 0
    for name in sorted({*before[0], *after}):
        if any(not is_same(before[0].get(name), again.get(name)) for again in before[1:]):
            print(f"{name}: the output is different in each run")
            continue
        lines = differences(before[0].get(name), after.get(name))
        different += bool(lines)
        print(*(f"{name}{line}" for line in lines), sep="\n", end="\n" if lines else "")
    print(f"{len(before[0])} answers before, {len(after)} after; {different} differ")
    return different


def main() -> int:
    """Read the command line, run the command and return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=["write", "compare"])
    parser.add_argument(
        "files",
        nargs="+",
        help="snapshot files; for write, one file and names of exercises or lessons",
    )
    options = parser.parse_args()
    if options.what == "write":
        write(Path(options.files[0]), options.files[1:])
        return 0
    return bool(compare([Path(name) for name in options.files]))


if __name__ == "__main__":
    sys.exit(main())
