"""Judge a class: every submission, in parallel.

A verdict is a file that names all it depends on. Whoever needs one looks there first, so a run
that was broken off goes on where it stopped, and `nbgrader autograde` finds what `grade` judged.
"""

from collections.abc import Callable, Iterable
from concurrent.futures import Executor, Future, as_completed
from dataclasses import dataclass
from pathlib import Path

from grader.course.lessons import Lesson, all_lessons
from grader.course.paths import Course
from grader.judging.judge import judge, verdict_key
from grader.judging.verdict import ExerciseResult, Verdict, read_verdict, write_verdict
from grader.sandbox import Sandbox, SandboxUnavailable


@dataclass(frozen=True)
class Submission:
    """One notebook that a student handed in."""

    student: str
    lesson: Lesson
    path: Path

    def verdict_path(self, course: Course) -> Path:
        """Where its verdict is kept."""
        return course.verdicts / self.student / self.lesson.stage / f"{self.lesson.name}.json"


def find_submissions(course: Course, stages: Iterable[str] = ()) -> list[Submission]:
    """Everything under ``submitted/<student>/<stage>/`` that is a lesson of the course.

    Parameters
    ----------
    course : grader.course.paths.Course
    stages : iterable of str, optional
        Only these stages; by default all.

    Returns
    -------
    list of Submission
        In order of student and lesson.
    """
    found = [
        Submission(path.parent.parent.name, lesson, path)
        for lesson in all_lessons()
        if not stages or lesson.stage in stages
        for path in course.submitted.glob(f"*/{lesson.stage}/{lesson.name}.ipynb")
    ]
    return sorted(found, key=lambda submission: (submission.student, submission.lesson.name))


def stored_verdict(course: Course, submission: Submission, seed: int) -> Verdict | None:
    """The verdict on disk, if it is about this very file, these tests and this seed."""
    verdict = read_verdict(submission.verdict_path(course))
    key = verdict_key(submission.path, submission.lesson, seed, submission.student)
    return verdict if verdict and verdict.key == key else None


def judge_and_store(course: Course, submission: Submission, seed: int, sandbox: Sandbox) -> Verdict:
    """Judge one submission and keep the verdict."""
    verdict = judge(submission.path, seed, sandbox, submission.lesson, submission.student)
    write_verdict(verdict, submission.verdict_path(course))
    return verdict


def current_verdict(course: Course, submission: Submission, seed: int, sandbox: Sandbox) -> Verdict:
    """The verdict on disk, or a fresh one."""
    return stored_verdict(course, submission, seed) or judge_and_store(
        course, submission, seed, sandbox
    )


def _result(future: Future, course: Course, submission: Submission, seed: int) -> Verdict:
    """The verdict of a finished future; one that says so where the judge itself failed."""
    try:
        return future.result()
    except SandboxUnavailable:
        raise
    except Exception as error:  # one submission must not stop the others
        verdict = failed_verdict(submission, seed, error)
        write_verdict(verdict, submission.verdict_path(course))
        return verdict


def failed_verdict(submission: Submission, seed: int, error: Exception) -> Verdict:
    """A verdict without points for a notebook on which the judge itself failed.

    Its key fits nothing, so the next run tries again.
    """
    exercises = tuple(
        ExerciseResult(exercise.name, 0.0, exercise.points, ())
        for exercise in submission.lesson.machine_graded
    )
    sentence = (
        "The judge failed on this notebook; this is not the student's fault. Judge it "
        f"by hand to see why: python -m grader judge {submission.path} "
        f"({type(error).__name__}: {str(error)[:200]})"
    )
    return Verdict(
        submission.lesson.name,
        submission.student,
        0.0,
        sum(exercise.max_score for exercise in exercises),
        exercises,
        (sentence,),
        0.0,
        f"failed with seed {seed}",
    )


def judge_class(
    course: Course,
    stages: Iterable[str],
    seed: int,
    sandbox: Sandbox,
    executor: Executor,
    progress: Callable[[int, int, object], None],
) -> list[tuple[Submission, Verdict]]:
    """Judge what has no verdict yet.

    Parameters
    ----------
    course : grader.course.paths.Course
    stages : iterable of str
    seed : int
    sandbox : grader.sandbox.Sandbox
    executor : concurrent.futures.Executor
        Runs the judging, as one of `grader.classroom.executors` does; it is not closed, unless
        judging is broken off.
    progress : callable
        Called with (done, total, submission) after each notebook.

    Returns
    -------
    list of (Submission, grader.judging.verdict.Verdict)
    """
    submissions = find_submissions(course, stages)
    verdicts = {submission: stored_verdict(course, submission, seed) for submission in submissions}
    open_ones = [submission for submission, verdict in verdicts.items() if verdict is None]
    done = len(submissions) - len(open_ones)
    progress(done, len(submissions), None)
    running = {
        executor.submit(judge_and_store, course, submission, seed, sandbox): submission
        for submission in open_ones
    }
    try:
        for future in as_completed(running):
            submission = running[future]
            verdicts[submission] = _result(future, course, submission, seed)
            done += 1
            progress(done, len(submissions), submission)
    except BaseException:
        executor.shutdown(wait=True, cancel_futures=True)
        raise
    return [(submission, verdicts[submission]) for submission in submissions]
