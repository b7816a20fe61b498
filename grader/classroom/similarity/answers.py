"""The functions that students wrote, got out of what they handed in."""

from __future__ import annotations

import ast
import dataclasses
import functools
import hashlib
import json
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from grader.classroom.similarity.normal_form import NormalStatement, steps_of
from grader.course.kept_answers import ANOTHER_CELL, answers_to
from grader.course.lessons import Lesson, all_lessons
from grader.intake.preflight import prepare
from grader.intake.reader_process import apart
from grader.intake.submission import HandedIn
from utils.notebooks import slicing

# What somebody writes is far below both; what is above is no answer that a person compares.
MOST_STEPS = 1000
MOST_CHARACTERS = 50_000


@dataclass(frozen=True)
class ComparedAnswer:
    """A function as somebody wrote it, with the functions of their own that it uses.

    Attributes
    ----------
    text : str
        The source; the statements that belong together, as they stand in the notebook.
    steps : tuple of NormalStatement
        The same in words, with lines of `text`.
    code : str
        A digest of the same without comments and layout.
    """

    text: str
    steps: tuple[NormalStatement, ...]
    code: str


@dataclass(frozen=True)
class Work:
    """What is compared of a notebook.

    Attributes
    ----------
    answers : dict of str to ComparedAnswer
        By exercise; without those that nobody wrote.
    cells : str
        A digest of what stands in the cells, and of nothing else in the file; empty for a
        notebook as it was given out.
    own, all : int
        How many cells are not as they were given out, and how many there are.
    problems : tuple of str
        Why an exercise cannot be compared, one sentence each.
    """

    answers: dict[str, ComparedAnswer] = dataclasses.field(hash=False)
    cells: str
    own: int
    all: int
    problems: tuple[str, ...]


def work_in(handed_in: HandedIn, lesson: Lesson) -> Work:
    """Read what was handed in for a lesson, in a process of its own; no code of it is run.

    Raises
    ------
    utils.notebooks.reading.UnreadableNotebook
    grader.intake.reader_process.ReadingFailed
    """
    _released_statements(lesson)  # is read here, once, and not in each of the processes

    def work() -> dict:
        # The code is what is judged. The cells are as they were handed in: what is mended in the
        # one and not in the other would make them differ.
        code = prepare(handed_in, lesson).code
        cells = [(cell.kind, cell.source.rstrip()) for cell in handed_in.notebook().cells]
        own = Counter(cells) - Counter(released_cells(lesson))
        answers, problems = answers_in([*handed_in.modules.values(), *code], lesson)
        return {
            "answers": {name: dataclasses.asdict(answer) for name, answer in answers.items()},
            "cells": _digest(json.dumps(cells)) if own else "",
            "own": own.total(),
            "all": len(cells),
            "problems": problems,
        }

    read = apart(handed_in.name, work)
    answers = {name: _from_json(answer) for name, answer in read["answers"].items()}
    return Work(**{**read, "answers": answers, "problems": tuple(read["problems"])})


def _from_json(answer: dict) -> ComparedAnswer:
    steps = (
        NormalStatement(tuple(step["words"]), step["first"], step["last"])
        for step in answer["steps"]
    )
    return ComparedAnswer(answer["text"], tuple(steps), answer["code"])


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode(errors="surrogatepass")).hexdigest()


def answers_in(code: Iterable[str], lesson: Lesson) -> tuple[dict[str, ComparedAnswer], list[str]]:
    """The answers to a lesson's exercises in code cells, and why some cannot be compared."""
    given = {source for _, source in released_cells(lesson)}
    code = [source for source in code if source.rstrip() not in given]
    released, imported = _released_statements(lesson)
    own = [one for one in slicing.parse_notebook(code)[0] if _dump(one.node) not in released]
    known = {**imported, **_imported(own), **_given_names(lesson)}
    answers, problems = {}, []
    for name in (exercise.name for exercise in lesson.machine_graded):
        try:
            answer = _answer(name, own, code, known, lesson)
        except RecursionError:
            problems.append(f"{name} is nested too deeply to be compared.")
            continue
        if len(answer.steps) > MOST_STEPS or len(answer.text) > MOST_CHARACTERS:
            problems.append(f"{name} is too long to be compared.")
        elif answer.steps:
            answers[name] = answer
    return answers, problems


def _answer(
    name: str, own: list, code: list[str], known: Mapping[str, str], lesson: Lesson
) -> ComparedAnswer:
    # Who wrote a class of their own, in place of the one that is given, wrote the answer there.
    names = [name] if any(name in one.binds for one in own) else list(lesson.header.given)
    others = _exercises() - {name}
    lines, steps, nodes = [], [], []
    for statement in slicing.slice_for(names, own):
        node = statement.node
        if statement.binds & others or isinstance(node, (ast.Import, ast.ImportFrom)):
            continue
        first = min([node.lineno, *(one.lineno for one in getattr(node, "decorator_list", []))])
        moved = len(lines) + 1 - first
        lines += [*code[statement.cell - 1].split("\n")[first - 1 : node.end_lineno], ""]
        is_it = getattr(node, "name", "") == name and hasattr(node, "args")
        parameters = (
            [argument.arg for argument in node.args.posonlyargs + node.args.args] if is_it else []
        )
        steps += [
            dataclasses.replace(step, first=step.first + moved, last=step.last + moved)
            for step in steps_of(node, known, parameters)
        ]
        nodes.append(ast.dump(node))
    return ComparedAnswer("\n".join(lines).rstrip(), tuple(steps), _digest("\n".join(nodes)))


def _dump(node: ast.AST) -> str:
    try:
        return ast.dump(node)
    except RecursionError:
        return ""


def _imported(statements: Iterable[slicing.Statement]) -> dict[str, str]:
    """What names of a notebook stand for that it imports."""
    found = {}
    for statement in statements:
        for node in ast.walk(statement.node):
            if isinstance(node, ast.Import):
                for alias in node.names:
                    whole = alias.name if alias.asname else alias.name.split(".")[0]
                    found[alias.asname or whole] = whole
            elif isinstance(node, ast.ImportFrom):
                for alias in node.names:
                    found[alias.asname or alias.name] = f"{node.module or ''}.{alias.name}"
    return found


@functools.cache
def _exercises() -> frozenset[str]:
    return frozenset(exercise.name for lesson in all_lessons() for exercise in lesson.exercises)


def _given_names(lesson: Lesson) -> dict[str, str]:
    """Functions that nobody makes up: exercises, and what is given."""
    return {name: name for name in (*_exercises(), *lesson.header.given)}


@functools.cache
def released_cells(lesson: Lesson) -> tuple[tuple[str, str], ...]:
    """Kind and source of each cell as it was given out."""
    cells = json.loads(lesson.released.read_text("utf-8"))["cells"]
    return tuple((cell["cell_type"], "".join(cell["source"]).rstrip()) for cell in cells)


@functools.cache
def _released_statements(lesson: Lesson) -> tuple[frozenset[str], dict[str, str]]:
    """The statements that were given out, and what names stand for that these import."""
    code = [source for kind, source in released_cells(lesson) if kind == "code"]
    statements, _ = slicing.parse_notebook(code)
    return frozenset(_dump(statement.node) for statement in statements), _imported(statements)


@functools.cache
def kept_answers(lesson: Lesson) -> dict[str, tuple[ComparedAnswer, ...]]:
    """By exercise, the right answers that are kept with the course, each of another author."""
    return {
        exercise.name: tuple(
            answer
            for variant in answers_to(exercise.name)
            if variant.right
            for answer in [_kept(lesson, exercise.name, variant.source)]
            if answer
        )
        for exercise in lesson.machine_graded
    }


@functools.cache
def taught_answers(lesson: Lesson) -> dict[str, tuple[ComparedAnswer, ...]]:
    """By exercise, what the lesson itself leads to: its solution, and its hints to the letter."""
    solved, _ = answers_in([lesson.text], lesson)
    found = {}
    for exercise in lesson.machine_graded:
        hints = [
            _kept(lesson, exercise.name, variant.source)
            for variant in answers_to(exercise.name)
            if variant.follows_hints
        ]
        found[exercise.name] = tuple(filter(None, [solved.get(exercise.name), *hints]))
    return found


def _kept(lesson: Lesson, exercise: str, source: str) -> ComparedAnswer | None:
    answers, _ = answers_in(source.split(ANOTHER_CELL), lesson)
    return answers.get(exercise)
