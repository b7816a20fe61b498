"""Compare the speed of the judge with nbgrader's own autograde on the same submissions.

Both programs grade copies of each lesson's solved notebook. They run in turn from the command line,
each in its own copy of the course. The benchmark stops if either awards less than full marks.
nbgrader executes one notebook after another in a kernel. Its time per notebook is the difference
between a class of two and a class of one, which excludes start-up. The judge is timed on a whole
class, including start-up, sandbox, report and gradebook. ROUNDS is the number of repetitions.

The time for a class of 200 in all lessons is extrapolated from a run inside this process, which
can observe each verdict as it arrives.

A table compares right notebooks of each lesson with notebooks in which one exercise is wrong. A
wrong notebook takes longer, because the judge looks for a mistake that explains it and for an edit
that repairs it.

Run the benchmark on an otherwise idle machine. nbgrader uses one hardware thread, and gets a whole
core while the core's other thread is idle. The judge uses all threads anyway. Other work on
the machine may therefore slow nbgrader more than the judge.

    python tests/benchmarks/bench_judge.py [STAGE ...]

The script adds its results to `.bench/measured.json`, under "judge".
"""

import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from nbgrader.api import Gradebook

from grader.classroom.executors import EXECUTORS
from grader.classroom.grade import judge_class
from grader.classroom.submissions import Submission
from grader.course.kept_answers import answers_to
from grader.course.lessons import all_lessons, stages
from grader.course.paths import PROJECT, Course
from grader.intake.submission import SubmittedFiles
from grader.judging.judge import judge_files
from grader.lms.gradebook import open_gradebook
from grader.lms.gradebook_writer import enter_verdicts
from grader.lms.registration import register_stages
from grader.sandbox import choose_sandbox
from tests.benchmarks.racing import save_results

STUDENTS = 20
ROUNDS = int(os.environ.get("ROUNDS", 3))
# Seconds that nbgrader took for one of the shorter notebooks in the course's first edition.
FIRST_EDITION = 4.0
# Configuration of plain nbgrader, which runs notebooks and counts the visible checks that pass.
PLAIN = """\
c = get_config()
c.CourseDirectory.source_directory = "solutions"
c.CourseDirectory.release_directory = "notebooks"
"""
CLASS = 200
SEED = 1
WRONG_ANSWERS = 4  # kept answers to each exercise in the table of wrong notebooks


@dataclass(frozen=True)
class Times:
    """Seconds for a stage, and the peak memory of this process in megabytes.

    `further` maps each lesson to the seconds for each further notebook.
    """

    first: float
    further: dict
    judging: float
    entering: float
    notebooks: int
    memory: tuple


def make_course(root, students, lessons):
    """Return a course with `students` copies of the solved notebooks."""
    course = Course(root)
    for folder in ("solutions", "notebooks"):
        shutil.copytree(
            PROJECT / folder,
            root / folder,
            ignore=shutil.ignore_patterns("*.py", "*.md", "*.png", "*.gif"),
        )
    # nbgrader runs each notebook in its own folder. The notebook finds these in a parent folder.
    for name in ("utils", "data"):
        shutil.copytree(PROJECT / name, root / name)
    for number in range(students):
        for lesson in lessons:
            path = course.submitted / f"student{number}" / lesson.stage / f"{lesson.name}.ipynb"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(json.dumps(_as_written_by(number, lesson)), "utf-8")
    return course


def _as_written_by(number, lesson):
    """Return the solved notebook with a student's comment in each answer.

    Without these comments, the notebooks would be identical, and the judge would reuse its first
    verdict for all of them.
    """
    notebook = json.loads(lesson.solved.read_text("utf-8"))
    for cell in notebook["cells"]:
        if cell["metadata"].get("nbgrader", {}).get("solution") and cell["cell_type"] == "code":
            cell["source"] = ["".join(cell["source"]) + f"\n# Student {number}"]
    return notebook


def megabytes():
    """Return the peak memory of this process so far, in megabytes."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def time_judge(lessons, folder):
    """Return the `Times` of the judge from a cold start."""
    course, seen, memory = make_course(folder / "ours", STUDENTS, lessons), {}, []
    sandbox = choose_sandbox()

    def progress(done, total, item):
        if isinstance(item, Submission):
            seen.setdefault(item.lesson, []).append(time.perf_counter())
        if done == total // 4:
            memory.append(megabytes())

    start = time.perf_counter()
    processes, count = EXECUTORS["processes"], os.cpu_count()
    judged = judge_class(course, (), SEED, sandbox, processes, count, progress)
    memory.append(megabytes())
    middle = time.perf_counter()
    assert all(verdict.score == verdict.max_score for _, verdict in judged)
    enter_verdicts(course, judged, stages_of(lessons), lambda *news: None)
    end = time.perf_counter()
    return Times(
        min(min(times) for times in seen.values()) - start,
        {lesson.name: seconds_between_verdicts(times) for lesson, times in seen.items()},
        middle - start,
        end - middle,
        len(judged),
        tuple(memory),
    )


def seconds_between_verdicts(times):
    """Return the mean seconds between verdicts in the middle half of a run."""
    few, most = len(times) // 4, 3 * len(times) // 4
    return (times[most] - times[few]) / (most - few)


def time_mistakes(lesson):
    """Return the seconds for right notebooks of a lesson, and for those with one wrong exercise."""
    sandbox = choose_sandbox()
    exercises = [exercise.name for exercise in lesson.machine_graded]
    wrong = {
        name: [answer.source for answer in answers_to(name) if not answer.right][:WRONG_ANSWERS]
        for name in exercises
    }

    def time_notebook(number, exercise="", answer=""):
        """Judge the solved notebook, with another answer to one exercise if there is one."""
        notebook = _as_written_by(number, lesson)
        for cell in notebook["cells"]:
            if cell["metadata"].get("nbgrader", {}).get("grade_id") == exercise:
                cell["source"] = [answer]
        files = SubmittedFiles(f"{lesson.name}.ipynb", json.dumps(notebook).encode())
        verdict = judge_files(files, SEED, sandbox, lesson)
        assert (verdict.score < verdict.max_score) == bool(exercise), (lesson, exercise, answer)
        return verdict.seconds

    time_notebook("to warm up")
    right_seconds = [time_notebook(number) for number in range(WRONG_ANSWERS)]
    wrong_seconds = [
        time_notebook(0, name, answer) for name, kept in wrong.items() for answer in kept
    ]
    return right_seconds, wrong_seconds


def print_mistakes(seconds_by_lesson):
    """Print how much longer wrong notebooks take than right ones."""
    print("lesson | right (ms) | one exercise wrong (ms): median, most | median / right")
    for name, (right, wrong) in seconds_by_lesson.items():
        usual, median, most = 1000 * np.array([np.median(right), np.median(wrong), max(wrong)])
        print(f"{name} | {usual:.0f} | {median:.0f}, {most:.0f} | {median / usual:.1f}", flush=True)


def stages_of(lessons):
    return tuple(dict.fromkeys(lesson.stage for lesson in lessons))


def command_line(root, *words):
    """Run a command in a course, as from a shell, and return the seconds that it takes."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"  # nbgrader runs alembic
    environment = {**os.environ, "PATH": path, "PYTHONPATH": str(root)}
    start = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-m", *words], cwd=root, env=environment, capture_output=True, text=True
    )
    seconds = time.perf_counter() - start
    assert done.returncode == 0, done.stdout + done.stderr
    return seconds


def assert_full_marks(root, stage, notebooks):
    """Assert that the gradebook has this many notebooks, all with full automatic marks."""
    with Gradebook(f"sqlite:///{root / 'gradebook.db'}") as book:
        graded = [
            notebook
            for submission in book.assignment_submissions(stage)
            for notebook in submission.notebooks
        ]
        assert len(graded) == notebooks, (len(graded), notebooks)
        for notebook in graded:
            marks = [grade for grade in notebook.grades if grade.cell.cell_type == "code"]
            assert marks, notebook
            assert all(mark.auto_score == mark.max_score for mark in marks), notebook


def time_nbgrader(lessons, folder, students):
    """Return the seconds that plain nbgrader takes if its gradebook already contains the stage."""
    stage, course = lessons[0].stage, make_course(folder, students, lessons)
    with open_gradebook(course) as book:
        register_stages(course, book, [stage])
    (folder / "nbgrader_config.py").write_text(PLAIN)
    seconds = command_line(folder, "nbgrader", "autograde", stage)
    assert_full_marks(folder, stage, students * len(lessons))
    return seconds


def time_grade(lessons, folder):
    """Return the seconds that `python -m grader grade` takes in a copy of the project."""
    stage, _ = lessons[0].stage, make_course(folder, STUDENTS, lessons)
    shutil.copytree(PROJECT / "grader", folder / "grader")
    shutil.copytree(PROJECT / "extension", folder / "extension")
    shutil.copytree(PROJECT / "solutions", folder / "solutions", dirs_exist_ok=True)
    for name in ("nbgrader_config.py", "pyproject.toml"):
        shutil.copy(PROJECT / name, folder)
    seconds = command_line(folder, "grader", "grade", stage)
    assert_full_marks(folder, stage, STUDENTS * len(lessons))
    return seconds


def race(lessons):
    """Time nbgrader and the judge in turn.

    Returns
    -------
    seconds : ndarray, shape (rounds, 2)
        Seconds per notebook of nbgrader and of the judge.
    starts : ndarray, shape (rounds,)
        Seconds that nbgrader takes to start.
    """
    found, starts = [], []
    for _ in range(ROUNDS):
        with tempfile.TemporaryDirectory() as place:
            place = Path(place).resolve()
            class_of_one = time_nbgrader(lessons, place / "one", 1)
            ours = time_grade(lessons, place / "ours")
            class_of_two = time_nbgrader(lessons, place / "two", 2)
        found.append(
            ((class_of_two - class_of_one) / len(lessons), ours / (STUDENTS * len(lessons)))
        )
        starts.append(2 * class_of_one - class_of_two)
    return np.array(found), np.array(starts)


def main(wanted):
    """Measure, print and record the results."""
    if os.getloadavg()[0] > 0.5:
        print("Other work on this machine may make the judge look better.")
    record, estimate, count = {}, 0.0, 0
    for stage in wanted or stages():
        lessons = [lesson for lesson in all_lessons() if lesson.stage == stage]
        seconds, starts = race(lessons)
        ratios = seconds[:, 0] / seconds[:, 1]
        theirs, mine = np.median(seconds, axis=0)
        print(
            f"{stage}: nbgrader autograde takes {theirs:.2f} s per notebook, after "
            f"{np.median(starts):.1f} s to start. The judge takes {mine:.2f} s, including start-up "
            f"and gradebook, and is {np.median(ratios):.1f} times as fast ({min(ratios):.1f} to "
            f"{max(ratios):.1f} in {ROUNDS} rounds). A notebook of the first edition took nbgrader "
            f"{FIRST_EDITION:.0f} s, {FIRST_EDITION / mine:.1f} times as long."
        )
        with tempfile.TemporaryDirectory() as folder:
            ours = time_judge(lessons, Path(folder).resolve())
        print(
            f"  {ours.notebooks} notebooks: the first judged after {ours.first:.1f} s, all after "
            f"{ours.judging:.1f} s, entered in {ours.entering:.1f} s; memory "
            f"{ours.memory[0]:.0f} MB after a quarter of them, {ours.memory[-1]:.0f} MB at the end"
        )
        print(
            "  each further notebook, in ms: "
            + ", ".join(f"{name} {1000 * s:.0f}" for name, s in ours.further.items()),
            flush=True,
        )
        mistakes = {lesson.name: time_mistakes(lesson) for lesson in lessons}
        print_mistakes(mistakes)
        each = sum(ours.further.values()) + ours.entering / STUDENTS
        estimate += ours.judging + ours.entering + (CLASS - STUDENTS) * each
        count += len(lessons)
        record[stage] = {
            "seconds per notebook": {
                "nbgrader": seconds[:, 0].tolist(),
                "ours": seconds[:, 1].tolist(),
            },
            "seconds to start nbgrader": starts.tolist(),
            "times as fast": ratios.tolist(),
            "seconds per further student": each,
            "seconds per further notebook": ours.further,
            "seconds for right and for wrong notebooks": mistakes,
        }
    print(f"{CLASS} students x {count} lessons, at this rate: {estimate / 60:.0f} min")
    save_results("judge", record)


if __name__ == "__main__":
    main(sys.argv[1:])
