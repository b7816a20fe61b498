"""Survey all answers that are one edit away from a right answer, and the points that they lose.

``python -m tests.survey [EXERCISE ...]`` prints a table. For each exercise it shows how many such
answers there are, how many are equivalent to a right answer, and which others lose no points. A
sample of the wrong answers is judged in the sandbox, including the search for slips. Without
arguments, only the solutions are edited; for named exercises, all right answers are edited.
"""

import ast
import contextlib
import copy
import functools
import math
import multiprocessing
import os
import random
import reprlib
import resource
import signal
import statistics
import sys
import time
import traceback
import types
from collections import Counter
from dataclasses import dataclass, field

import numpy as np
import sklearn.cluster  # noqa: F401 - loads OpenMP, so that `threadpool_limits` finds it
from threadpoolctl import threadpool_limits

from grader.course.kept_answers import answers_to, fill_in
from grader.course.lessons import Lesson, lesson_of, load_reference
from grader.intake.submission import SubmittedFiles
from grader.judging.judge import program_for
from grader.judging.program_run import JudgingContext, run_program
from grader.judging.repair import find_slips
from grader.judging.results import result_of
from grader.judging.runner import hidden_calls, run_checks, visible_calls
from grader.sandbox import choose_sandbox
from tests.answer_equality import compare_values, is_equivalent
from tests.course_lessons import COURSE
from tests.slip_tables import solution_of
from tests.students import student_with
from utils.checks import checks_of
from utils.checks.assertions import call_each, observe, time_call
from utils.checks.run_cache import cached_run
from utils.notebooks import slicing
from utils.notebooks.edits import edits_of
from utils.remote_objects import RemoteProxy

SEED, OTHER_SEEDS = 7, (11, 12, 13)  # for the checks, and for calls that compare answers
CALLS = 1000
SECONDS = 0.5  # processor time for a check, in addition to four times that of a right answer
HANGING_SECONDS = 600  # seconds; more than any right answer takes
SAMPLE = 6  # number of wrong answers to judge in the sandbox for each exercise
LARGEST_LOSS = 0.6  # largest share of an exercise's points that one edit should usually cost
EXERCISES = [exercise.name for lesson in COURSE for exercise in lesson.machine_graded]
SOLUTION = "the solution"
ANSWER = "<answer>"  # file name of an answer's code in tracebacks
NO_FUNCTION, NEVER_ENDS = "no function", "never ends"
MEMORY = 4 * 2**30
FORK = multiprocessing.get_context("fork")


# ---- answers and their mutants ------------------------------------------------------------------


@dataclass(frozen=True)
class Answer:
    """A right answer: a notebook, and the statements that belong only to this exercise."""

    lesson: Lesson
    exercise: str
    name: str
    cells: tuple[str, ...]
    statements: tuple[slicing.Statement, ...]

    def code(self, edit=None):
        """Compile the statements, after applying an edit if one is given."""
        texts = [
            edit.statement if edit and contains(statement, edit) else ast.unparse(statement.node)
            for statement in self.statements
        ]
        return compile("\n".join(texts), ANSWER, "exec")

    def function(self, code):
        """Run the answer's compiled code in an otherwise right notebook; return its function."""
        space = dict(getattr(load_reference(self.lesson.name), self.exercise).__globals__)
        exec(code, space)
        return space[self.exercise]


def contains(statement, edit):
    return statement.cell == edit.cell and (
        statement.node.lineno <= edit.last and edit.first <= statement.node.end_lineno
    )


@dataclass(frozen=True)
class Mutant:
    """A right answer after one edit."""

    answer: Answer
    edit: object
    code: types.CodeType

    @property
    def before(self):
        """The changed lines before the edit."""
        lines = self.answer.cells[self.edit.cell - 1].split("\n")
        return "\n".join(lines[self.edit.first - 1 : self.edit.last]).strip()

    @property
    def after(self):
        """The changed lines after the edit."""
        return self.edit.text.strip()


def answers_in_notebooks(exercise):
    """Yield the solution and the right kept answers, each in an otherwise right notebook."""
    lesson = lesson_of(exercise)
    yield answer_in(lesson, exercise, SOLUTION, lesson.solved.read_bytes())
    right = {graded.name: solution_of(graded.name) for graded in lesson.machine_graded}
    for variant in right_functions(exercise):
        text = fill_in(lesson, right | {exercise: variant.source})
        own = [ast.unparse(statement.node) for statement in statements_of(variant)]
        yield answer_in(lesson, exercise, variant.name, text.encode(), own)


def right_functions(exercise):
    """Yield the right kept answers that are functions; classes only run in the sandbox."""
    for variant in answers_to(exercise):
        if variant.right and any(
            exercise in statement.binds for statement in statements_of(variant)
        ):
            yield variant


def statements_of(variant):
    return slicing.parse_notebook([variant.source])[0]


def answer_in(lesson, exercise, name, content, own=()):
    """Return the answer in a notebook, including functions of other exercises that it redefines.

    For example, an answer to `ransac_plane` may define its own `plane_through`.
    """
    cells = SubmittedFiles(f"{lesson.name}.ipynb", content).notebook().code
    statements, _ = slicing.parse_notebook(cells)
    others = frozenset(lesson.names) - {exercise}
    needed = slicing.slice_for((exercise,), statements)
    own_statements = tuple(
        statement
        for statement in needed
        if not statement.binds & others or ast.unparse(statement.node) in own
    )
    return Answer(lesson, exercise, name, tuple(cells), own_statements)


def mutants_of(answer):
    """Yield the mutants of an answer, except those that compile to the same code."""
    kinds = (ast.FunctionDef, ast.ClassDef)
    seen = {key_of(answer.code())}
    definitions = [
        statement for statement in answer.statements if isinstance(statement.node, kinds)
    ]
    for edit in edits_of(list(answer.cells), definitions):
        with contextlib.suppress(SyntaxError, ValueError):
            code = answer.code(edit)
            if key_of(code) not in seen:
                seen.add(key_of(code))
                yield Mutant(answer, edit, code)


def key_of(code):
    """Return a key that is equal for sources that compile to the same code."""
    inner = [
        key_of(value) if isinstance(value, types.CodeType) else repr(value)
        for value in code.co_consts
    ]
    return code.co_code, code.co_names, code.co_varnames, code.co_exceptiontable, *inner


# ---- checks in this process, because the sandbox is too slow for so many answers ----------------


class TakesTooLong(BaseException):
    """A function takes longer than any right answer."""


@contextlib.contextmanager
def time_limit(seconds):
    """Raise `TakesTooLong` after some seconds of processor time."""

    def stop(*about):
        raise TakesTooLong

    before = signal.signal(signal.SIGPROF, stop)
    # The signal is repeated every 0.1 s, because some code catches every exception.
    signal.setitimer(signal.ITIMER_PROF, seconds, 0.1)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


class LocalRemote(RemoteProxy):
    """A stand-in for a remote function that copies its arguments but runs in this process."""

    def __init__(self, function):
        self.function, self.__name__ = function, getattr(function, "__name__", "")

    def __call__(self, *arguments, **keywords):
        given, named = copy.deepcopy((arguments, keywords))
        return self.function(*given, **named)

    def observe(self, *arguments):
        return observe(self.function, *arguments)

    def timed(self, *arguments):
        return time_call(self.function, *arguments)

    def each(self, calls):
        return call_each(self.function, calls)


def is_graders_fault(failure):
    """Return whether the grader itself failed, so that the answer loses no points."""
    if isinstance(failure, (AssertionError, TakesTooLong)):
        return False
    frames = [frame.f_code.co_filename for frame, _ in traceback.walk_tb(failure.__traceback__)]
    return ANSWER not in frames


class Recorder:
    """Wraps a correct function and records the arguments of its calls."""

    def __init__(self, function):
        self.function, self.calls = function, []

    def __call__(self, *arguments, **keywords):
        self.calls.append(copy.deepcopy((arguments, keywords)))
        return self.function(*arguments, **keywords)


@contextlib.contextmanager
def silence():
    """Discard standard output, because thousands of answers print."""
    with open(os.devnull, "w") as nowhere, contextlib.redirect_stdout(nowhere):
        yield


@contextlib.contextmanager
def fixed_random_numbers():
    """Give each generator without a seed the same one, so that a survey can be repeated."""
    make = np.random.default_rng
    np.random.default_rng = lambda seed=None: make(SEED if seed is None else seed)
    np.random.seed(SEED)
    random.seed(SEED)
    try:
        yield
    finally:
        np.random.default_rng = make


class CheckRunner:
    """Runs an exercise's checks on functions, starting with those that are likely to fail."""

    def __init__(self, exercise):
        self.exercise, self.lesson = exercise, lesson_of(exercise)
        self.right = vars(load_reference(self.lesson.name))
        self.student = student_with(self.lesson, self.right)
        outcomes = self.run(self.right[exercise], SEED)
        assert not any(outcome.failure for outcome in outcomes)
        checks = [outcome.check for outcome in outcomes]
        self.hidden = hidden_calls(self.lesson, self.student, SEED, checks)
        self.cost, self.lost = Counter(), Counter()

    def run(self, function, seed):
        """Run the checks of the exercise on a function and return the outcomes."""
        student = student_with(self.lesson, {**self.right, self.exercise: function})
        exercise = self.exercise
        return run_checks(self.lesson, student, seed, lambda check: check.exercise == exercise)

    def check_calls(self):
        """Return the calls of the visible checks, followed by the calls of the hidden tests."""
        return [*visible_calls(self.student, checks_of(self.exercise)), *self.hidden]

    def check_calls_for(self, function):
        """Replace the exercise's function with another one, and return the check calls."""
        answers = {**self.right, self.exercise: function}
        vars(self.student).update(vars(student_with(self.lesson, answers)))
        setattr(self.student, self.exercise, LocalRemote(function))
        return self.check_calls()

    def record_times(self, function):
        """Record how long each check call takes for a correct function, to set time limits."""
        for number, check_call in enumerate(self.check_calls_for(function)):
            start = time.process_time()
            with cached_run():
                check_call()
            self.cost[number] = max(self.cost[number], time.process_time() - start)

    def first_failure(self, function):
        """Return the number of a check call that a function fails, or None if it passes all."""
        check_calls = self.check_calls_for(function)
        # Start with calls that are quick or have rejected many functions.
        for number in sorted(self.cost, key=lambda k: (0.002 + self.cost[k]) / (1 + self.lost[k])):
            try:
                with cached_run(), time_limit(SECONDS + 4 * self.cost[number]):
                    check_calls[number]()
            except BaseException as failure:
                if is_graders_fault(failure):
                    raise
                return number
        return None

    def calls(self):
        """Return a sample of the calls that the checks make with other seeds."""
        recorder = Recorder(self.right[self.exercise])
        for seed in OTHER_SEEDS:
            self.run(recorder, seed)
        random.Random(1).shuffle(recorder.calls)
        return recorder.calls[:CALLS]


def outcome_of(function, call, seconds):
    """Return a call's answer, or the type of its exception, and the arguments afterwards."""
    arguments, keywords = copy.deepcopy(call)
    try:
        with time_limit(seconds):
            answer = function(*arguments, **keywords)
    except (Exception, TakesTooLong) as error:
        answer = type(error)
    return answer, list(arguments)


class Oracle:
    """Decides whether a function that passes all checks is equivalent to a right answer.

    The right answers are the solution and the unedited answer. They may differ where the
    exercise's docstring permits it.
    """

    def __init__(self, runner, answer):
        self.runner, self.exercise = runner, runner.exercise
        self.answer = answer.function(answer.code())
        self.right = runner.right[self.exercise]
        self.calls = runner.calls()
        self.expected, self.answered, self.seconds = [], [], []
        for call in self.calls:
            start = time.process_time()
            self.expected.append(outcome_of(self.right, call, HANGING_SECONDS))
            self.answered.append(outcome_of(self.answer, call, HANGING_SECONDS))
            self.seconds.append(time.process_time() - start)
        self.cost = sum(self.seconds)

    def counterexample(self, function):
        """Return a call that the function answers wrongly, or None if there is none.

        Right detectors may return different boxes. So a detector that returns other boxes than the
        unedited answer only has to pass the checks on other streets.
        """
        is_detector = self.exercise == "detect_obstacles"
        answers = zip(self.calls, self.seconds, self.expected, self.answered, strict=True)
        for call, seconds, expected, answered in answers:
            outcome = outcome_of(function, call, 10 * SECONDS + 4 * seconds)
            right = (answered,) if is_detector else (expected, answered)
            if not any(self.agree(call, outcome, right_outcome) for right_outcome in right):
                return self.failed_check(function) if is_detector else call
        return None

    def failed_check(self, function):
        """Return the name of a check that a detector fails on other streets, or None."""
        for seed in OTHER_SEEDS:
            failed = [outcome for outcome in self.runner.run(function, seed) if outcome.failure]
            if failed:
                return failed[0].check.name
        return None

    def agree(self, call, outcome, right):
        """Return whether an outcome's answer and changed arguments agree with a right outcome."""
        (answer, left), (expected, expected_left) = outcome, right
        return is_equivalent(self.exercise, call, answer, expected) and all(
            map(compare_values, left, expected_left)
        )


# ---- the table ----------------------------------------------------------------------------------


@dataclass
class SurveyResult:
    """The outcomes for the mutants of some answers to an exercise."""

    exercise: str
    mutants: int = 0
    alike: int = 0
    escaped: list = field(default_factory=list)
    wrong: list = field(default_factory=list)


def survey(exercise, answers, share=1):
    """Check all mutants of some answers, or a fixed sample of one in every `share` mutants."""
    runner = CheckRunner(exercise)
    found = SurveyResult(exercise)
    # After OpenMP has used several threads, a forked process that uses it waits forever.
    one_thread = threadpool_limits(1)
    with one_thread, np.errstate(all="ignore"), silence(), fixed_random_numbers():
        for answer in answers:
            oracle = None
            runner.record_times(answer.function(answer.code()))
            mutants = list(mutants_of(answer))
            for mutant in random.Random(answer.name).sample(mutants, len(mutants) // share):
                lost = run_apart(
                    functools.partial(first_failure, runner, mutant), sum(runner.cost.values())
                )
                if lost == NO_FUNCTION:
                    continue
                found.mutants += 1
                if lost is not None:
                    runner.lost[lost] += 1
                    found.wrong.append(mutant)
                    continue
                oracle = oracle or Oracle(runner, answer)
                call = run_apart(
                    functools.partial(short_counterexample, oracle, mutant), oracle.cost
                )
                if call is None:
                    found.alike += 1
                else:
                    found.escaped.append((mutant, call))
    return found


def first_failure(runner, mutant):
    """Return the number of a check call that a mutant fails, or None if it passes all."""
    try:
        with time_limit(SECONDS):
            function = mutant.answer.function(mutant.code)
    except BaseException:  # the edit may move a failing statement out of the function
        return NO_FUNCTION
    return runner.first_failure(function)


def short_counterexample(oracle, mutant):
    """Return the shortened text of a call that a mutant answers wrongly, or None."""
    call = oracle.counterexample(mutant.answer.function(mutant.code))
    return None if call is None else reprlib.repr(call)


def run_apart(work, usual):
    """Do some work in a separate process, and return its result or `NEVER_ENDS`.

    A mutant may change shared state, request too much memory, or send LAPACK into a loop that
    Python's signal handlers cannot interrupt.

    Parameters
    ----------
    work : callable
    usual : float
        Seconds of processor time with a right answer.
    """
    reading, writing = FORK.Pipe(duplex=False)
    process = FORK.Process(target=_work, args=(work, writing, math.ceil(30 + 6 * usual)))
    process.start()
    writing.close()
    try:
        outcome, fault = reading.recv()
    except EOFError:
        return NEVER_ENDS
    finally:
        process.join()
        reading.close()
    assert not fault, fault
    return outcome


def _work(work, writing, seconds):
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    try:
        answer = work(), ""
    except BaseException:
        answer = None, traceback.format_exc()
    writing.send(answer)


# ---- judging in the sandbox ---------------------------------------------------------------------


def losses_of(exercise, sandbox, most=SAMPLE):
    """Judge a fixed sample of the solution's mutants; return the fractions of points they lose.

    Mutants that lose no points are omitted.
    """
    answer = next(answers_in_notebooks(exercise))
    mutants = list(mutants_of(answer))
    random.Random(exercise).shuffle(mutants)
    lost = []
    for mutant in mutants:
        if len(lost) == most:
            break
        share = share_lost(mutant, sandbox)
        if share:
            lost.append((share, mutant))
    return lost


def share_lost(mutant, sandbox):
    """Judge a mutant in an otherwise right notebook; return the fraction of points lost."""
    answer, edit = mutant.answer, mutant.edit
    program = program_for(answer.lesson, answer.cells, {})
    program = program.edited(edit.cell, edit.first, edit.last, edit.text)
    setting = JudgingContext(answer.lesson, SEED, sandbox)
    exercise = next(
        graded for graded in answer.lesson.machine_graded if graded.name == answer.exercise
    )
    results = run_program(
        setting, program, lambda check: check.exercise == exercise.name, explain=True
    )
    assert not results.fault
    slip = find_slips(setting, program, results, {}).get(exercise.name)
    return 1 - result_of(exercise, results, None, slip).score / exercise.points


def main():
    """Print the table for all solutions, or for all right answers to the named exercises."""
    sandbox = choose_sandbox()
    everything = []
    heads = ("edits", "alike", "escaped", "judged", "median", "> 60 %")
    print(f"{'exercise':34}" + "".join(f"{head:>9}" for head in heads))
    for exercise in sys.argv[1:] or EXERCISES:
        answers = list(answers_in_notebooks(exercise))
        found = survey(exercise, answers if sys.argv[1:] else answers[:1])
        lost = [share for share, _ in losses_of(exercise, sandbox)]
        everything += lost
        print(
            f"{exercise:34}{found.mutants:9}{found.alike:9}{len(found.escaped):9}{len(lost):9}"
            f"{statistics.median(lost):9.0%}{sum(share > LARGEST_LOSS for share in lost):9}",
            flush=True,
        )
        for mutant, call in found.escaped:
            change = f"{mutant.before!r} -> {mutant.after!r}"
            print(f"    {mutant.answer.name}: {change}, for example for {call}")
    severe = sum(share > LARGEST_LOSS for share in everything) / len(everything)
    middle = statistics.median(everything)
    print(
        f"The median of {len(everything)} wrong answers loses {middle:.0%}, and {severe:.0%} lose"
    )
    print(f"more than {LARGEST_LOSS:.0%} of their exercise.")


if __name__ == "__main__":
    main()
