"""Every answer that is one edit away from a right one, and what becomes of it.

``python -m tests.survey [EXERCISE ...]`` prints a table: how many such answers there are, how many
of them answer as the solution does, which others lose nothing, and what a sample of the wrong ones
loses when it is judged behind the walls, slips included. Without a name that is of the solutions;
of an exercise that is named, of every right answer.
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

from grader.course.kept_answers import answers_to, fill_in
from grader.course.lessons import Lesson, lesson_of, load_reference
from grader.intake.submission import SubmittedFiles
from grader.judging.judge import program_for
from grader.judging.program_run import Setting, ask
from grader.judging.repair import slips_in
from grader.judging.results import result_of
from grader.judging.runner import hidden_calls, run_checks, visible_calls
from grader.sandbox import choose_sandbox
from tests.answer_equality import alike, anything
from tests.course_lessons import COURSE
from tests.students import student_with
from tests.test_slips import solution_of
from utils.checks import checks_of
from utils.checks.assertions import call_each, observe, timed
from utils.checks.run_cache import one_run
from utils.notebooks import slicing
from utils.notebooks.edits import edits_of
from utils.remote_objects import Remote

SEED, OTHER_SEEDS = 7, (11, 12, 13)  # for the checks, and for calls that tell two answers apart
CALLS = 1000
SECONDS = 0.5  # of the processor for a question, beside four times what right answers take
AGES = 600  # seconds that a right answer has
SAMPLE = 6  # wrong answers of each exercise that are judged behind the walls
MOST = 0.6  # of an exercise's points, for one edit
EXERCISES = [exercise.name for lesson in COURSE for exercise in lesson.machine_graded]
SOLUTION = "the solution"
ANSWER = "<answer>"  # the file that tracebacks name
NO_FUNCTION, NEVER_ENDS = "no function", "never ends"
MEMORY = 4 * 2**30
FORK = multiprocessing.get_context("fork")


# ---- answers, and what one edit makes of them ---------------------------------------------------


@dataclass(frozen=True)
class Answer:
    """A right answer: a notebook, and the statements in it that belong to the exercise alone."""

    lesson: Lesson
    exercise: str
    name: str
    cells: tuple[str, ...]
    theirs: tuple[slicing.Statement, ...]

    def code(self, edit=None):
        """These statements, one of them with an edit."""
        texts = [
            edit.statement if edit and holds(statement, edit) else ast.unparse(statement.node)
            for statement in self.theirs
        ]
        return compile("\n".join(texts), ANSWER, "exec")

    def function(self, code):
        """What some code defines in a notebook that has everything else."""
        space = dict(getattr(load_reference(self.lesson.name), self.exercise).__globals__)
        exec(code, space)
        return space[self.exercise]


def holds(statement, edit):
    return statement.cell == edit.cell and (
        statement.node.lineno <= edit.last and edit.first <= statement.node.end_lineno
    )


@dataclass(frozen=True)
class Mutant:
    """What one edit makes of a right answer."""

    answer: Answer
    edit: object
    code: types.CodeType

    @property
    def before(self):
        """The lines that the edit changes."""
        lines = self.answer.cells[self.edit.cell - 1].split("\n")
        return "\n".join(lines[self.edit.first - 1 : self.edit.last]).strip()

    @property
    def after(self):
        """What they become."""
        return self.edit.text.strip()


def answers_in_notebooks(exercise):
    """The solution, and the right answers of the variants, in notebooks that are right else."""
    lesson = lesson_of(exercise)
    yield answer_in(lesson, exercise, SOLUTION, lesson.solved.read_bytes())
    right = {one.name: solution_of(one.name) for one in lesson.machine_graded}
    for variant in right_functions(exercise):
        text = fill_in(lesson, right | {exercise: variant.source})
        own = [ast.unparse(statement.node) for statement in statements_of(variant)]
        yield answer_in(lesson, exercise, variant.name, text.encode(), own)


def right_functions(exercise):
    """Right answers that are functions: who writes a class is asked in the sandbox alone."""
    for variant in answers_to(exercise):
        if variant.right and any(
            exercise in statement.binds for statement in statements_of(variant)
        ):
            yield variant


def statements_of(variant):
    return slicing.parse_notebook([variant.source])[0]


def answer_in(lesson, exercise, name, content, own=()):
    """The answer that a notebook holds, with what it says itself of other exercises.

    A function for planes may need those through three points as arrays, which it defines so.
    """
    cells = SubmittedFiles(f"{lesson.name}.ipynb", content).notebook().code
    statements, _ = slicing.parse_notebook(cells)
    others = frozenset(lesson.names) - {exercise}
    needed = slicing.slice_for((exercise,), statements)
    theirs = tuple(one for one in needed if not one.binds & others or ast.unparse(one.node) in own)
    return Answer(lesson, exercise, name, tuple(cells), theirs)


def mutants_of(answer):
    """All that one edit makes of an answer, but for what Python reads as the same."""
    kinds = (ast.FunctionDef, ast.ClassDef)
    seen = {key_of(answer.code())}
    definitions = [one for one in answer.theirs if isinstance(one.node, kinds)]
    for edit in edits_of(list(answer.cells), definitions):
        with contextlib.suppress(SyntaxError, ValueError):
            code = answer.code(edit)
            if key_of(code) not in seen:
                seen.add(key_of(code))
                yield Mutant(answer, edit, code)


def key_of(code):
    """Equal for texts that Python reads as the same."""
    inner = [
        key_of(value) if isinstance(value, types.CodeType) else repr(value)
        for value in code.co_consts
    ]
    return code.co_code, code.co_names, code.co_varnames, code.co_exceptiontable, *inner


# ---- asked here, and not in the sandbox, which takes too long for so many -----------------------


class TakesTooLong(BaseException):
    """No right answer takes so long."""


@contextlib.contextmanager
def within(seconds):
    """Raise `TakesTooLong` after some seconds of the processor."""

    def stop(*about):
        raise TakesTooLong

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds, 0.1)  # again, for code that catches everything
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


class Beyond(Remote):
    """A function as the judge meets it: it gets copies, and is looked at where it is."""

    def __init__(self, function):
        self.function, self.__name__ = function, getattr(function, "__name__", "")

    def __call__(self, *arguments, **keywords):
        given, named = copy.deepcopy((arguments, keywords))
        return self.function(*given, **named)

    def observe(self, *arguments):
        return observe(self.function, *arguments)

    def timed(self, *arguments):
        return timed(self.function, *arguments)

    def each(self, calls):
        return call_each(self.function, calls)


def is_ours(failure):
    """Whether something failed that no answer may make fail: no check said so, and no answer did.

    The judge calls that a fault of its own, and so nobody loses a point by it.
    """
    if isinstance(failure, (AssertionError, TakesTooLong)):
        return False
    frames = [frame.f_code.co_filename for frame, _ in traceback.walk_tb(failure.__traceback__)]
    return ANSWER not in frames


class Recorder:
    """A right function, and what it was called with."""

    def __init__(self, function):
        self.function, self.calls = function, []

    def __call__(self, *arguments, **keywords):
        self.calls.append(copy.deepcopy((arguments, keywords)))
        return self.function(*arguments, **keywords)


@contextlib.contextmanager
def quiet():
    """Let nobody print, as answers do by the thousand."""
    with open(os.devnull, "w") as nowhere, contextlib.redirect_stdout(nowhere):
        yield


class Asker:
    """Asks functions in the place of an exercise; those that lose something lose it early."""

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
        """How the checks of the exercise end."""
        student = student_with(self.lesson, {**self.right, self.exercise: function})
        mine = self.exercise
        return run_checks(self.lesson, student, seed, lambda check: check.exercise == mine)

    def questions(self):
        """Those that students see, and those that they do not see."""
        return [*visible_calls(self.student, checks_of(self.exercise)), *self.hidden]

    def questions_to(self, function):
        """The same, asked of a function."""
        answers = {**self.right, self.exercise: function}
        vars(self.student).update(vars(student_with(self.lesson, answers)))
        setattr(self.student, self.exercise, Beyond(function))
        return self.questions()

    def believe(self, function):
        """Ask a right function, which loses nothing; others have four times its time."""
        for number, question in enumerate(self.questions_to(function)):
            begin = time.process_time()
            with one_run():
                question()
            self.cost[number] = max(self.cost[number], time.process_time() - begin)

    def loses_at(self, function):
        """The number of a question at which a function loses; None where it loses nothing."""
        questions = self.questions_to(function)
        # What is cheap, or tells many apart, comes first.
        for number in sorted(self.cost, key=lambda k: (0.002 + self.cost[k]) / (1 + self.lost[k])):
            try:
                with one_run(), within(SECONDS + 4 * self.cost[number]):
                    questions[number]()
            except BaseException as failure:
                if is_ours(failure):
                    raise
                return number
        return None

    def calls(self):
        """What the checks call the function with on other streets, and in other draws."""
        recorder = Recorder(self.right[self.exercise])
        for seed in OTHER_SEEDS:
            self.run(recorder, seed)
        random.Random(1).shuffle(recorder.calls)
        return recorder.calls[:CALLS]


def outcome_of(function, call, seconds):
    """What a call returns, or the type of what it raises; and what it makes of its arguments."""
    arguments, keywords = copy.deepcopy(call)
    try:
        with within(seconds):
            answer = function(*arguments, **keywords)
    except (Exception, TakesTooLong) as error:
        answer = type(error)
    return answer, list(arguments)


class Oracle:
    """Knows whether a function that loses nothing answers as a right answer does.

    As the solution, or as the answer that it was made of: both are right, and may differ where the
    docstring lets them.
    """

    def __init__(self, asker, answer):
        self.asker, self.exercise = asker, asker.exercise
        self.answer = answer.function(answer.code())
        self.right = asker.right[self.exercise]
        self.calls = asker.calls()
        self.expected, self.answered, self.seconds = [], [], []
        for call in self.calls:
            begin = time.process_time()
            self.expected.append(outcome_of(self.right, call, AGES))
            self.answered.append(outcome_of(self.answer, call, AGES))
            self.seconds.append(time.process_time() - begin)
        self.cost = sum(self.seconds)

    def tells(self, function):
        """A call to which the function answers otherwise, and is wrong; None where there is none.

        There is no one right detector: one that earns everything on other streets is right.
        """
        if self.exercise == "detect_obstacles":
            for seed in OTHER_SEEDS:
                failed = [one for one in self.asker.run(function, seed) if one.failure]
                if failed:
                    return failed[0].check.name
            return None
        answers = zip(self.calls, self.seconds, self.expected, self.answered, strict=True)
        for call, seconds, *right in answers:
            outcome = outcome_of(function, call, 10 * SECONDS + 4 * seconds)
            if not any(self.agree(call, outcome, one) for one in right):
                return call
        return None

    def agree(self, call, outcome, right):
        """Whether what was returned is as good, and what was given is left the same."""
        (answer, left), (expected, as_it_should_be) = outcome, right
        return alike(self.exercise, call, answer, expected) and all(
            map(anything, left, as_it_should_be)
        )


# ---- the table ----------------------------------------------------------------------------------


@dataclass
class Surveyed:
    """What came of the mutants of some answers to an exercise."""

    exercise: str
    mutants: int = 0
    alike: int = 0
    escaped: list = field(default_factory=list)
    wrong: list = field(default_factory=list)


def survey(exercise, answers, share=1):
    """Ask all mutants of some answers; or a fixed draw of them, one in so many."""
    asker = Asker(exercise)
    found = Surveyed(exercise)
    with np.errstate(all="ignore"), quiet():
        for answer in answers:
            oracle = None
            asker.believe(answer.function(answer.code()))
            mutants = list(mutants_of(answer))
            for mutant in random.Random(answer.name).sample(mutants, len(mutants) // share):
                lost = apart(functools.partial(lost_by, asker, mutant), sum(asker.cost.values()))
                if lost == NO_FUNCTION:
                    continue
                found.mutants += 1
                if lost is not None:
                    asker.lost[lost] += 1
                    found.wrong.append(mutant)
                    continue
                oracle = oracle or Oracle(asker, answer)
                call = apart(functools.partial(told_by, oracle, mutant), oracle.cost)
                if call is None:
                    found.alike += 1
                else:
                    found.escaped.append((mutant, call))
    return found


def lost_by(asker, mutant):
    """The question at which a mutant loses; None where it loses nothing."""
    try:
        with within(SECONDS):
            function = mutant.answer.function(mutant.code)
    except BaseException:  # what stands outside of a function may fail here
        return NO_FUNCTION
    return asker.loses_at(function)


def told_by(oracle, mutant):
    """A call to which a mutant answers otherwise, in short; None where there is none."""
    call = oracle.tells(mutant.answer.function(mutant.code))
    return None if call is None else reprlib.repr(call)


def apart(work, usual):
    """What comes of some work in a process of its own; `NEVER_ENDS` where it does not end.

    A mutant may change what a process shares, ask for more memory than there is, or send LAPACK
    into a loop that no signal of Python's reaches.

    Parameters
    ----------
    work : callable
    usual : float
        Seconds of the processor that it takes with a right answer.
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


# ---- judged behind the walls --------------------------------------------------------------------


def losses_of(exercise, sandbox, most=SAMPLE):
    """What mutants of the solution lose, as shares of the exercise: a fixed draw of them.

    Those that lose nothing are left out, and so are those that are no functions.
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
    """What a mutant loses of its exercise, judged as in a class, where all else is right."""
    answer, edit = mutant.answer, mutant.edit
    program = program_for(answer.lesson, answer.cells, {})
    program = program.edited(edit.cell, edit.first, edit.last, edit.text)
    setting = Setting(answer.lesson, SEED, sandbox)
    exercise = next(one for one in answer.lesson.machine_graded if one.name == answer.exercise)
    asked = ask(setting, program, lambda check: check.exercise == exercise.name, explain=True)
    assert not asked.fault
    slip = slips_in(setting, program, asked, {}).get(exercise.name)
    return 1 - result_of(exercise, asked, None, slip).score / exercise.points


def main():
    """Print the table: of all exercises their solutions, of those that are named all answers."""
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
            f"{statistics.median(lost):9.0%}{sum(share > MOST for share in lost):9}",
            flush=True,
        )
        for mutant, call in found.escaped:
            print(f"    {mutant.answer.name}: {mutant.before!r} -> {mutant.after!r}, as for {call}")
    severe = sum(share > MOST for share in everything) / len(everything)
    middle = statistics.median(everything)
    print(
        f"Of {len(everything)} wrong answers the median loses {middle:.0%}, and {severe:.0%} lose"
    )
    print(f"more than {MOST:.0%} of their exercise.")


if __name__ == "__main__":
    main()
