"""Mutation tests: make one small change to the grader's code, and expect a test to fail.

    make mutants                              # all modules; continues where it was stopped
    .venv/bin/python tests/mutants.py points  # only modules with "points" in their path

cosmic-ray makes the changes ("mutants"). Each is applied in memory, in a fork of a process
that has collected the tests. A changed function gets new code, and only tests that enter it run,
starting with short tests that have detected many mutants. If anything else changes, all modules are
imported again, and all tests run until one fails. The outcomes are stored in ``.pytest_cache``. A
surviving mutant is tried again in the next run, because there may be new tests; delete the file to
try all mutants. ``mutants.txt`` lists mutants that no test could detect, with the reason.
"""

from __future__ import annotations

import ast
import contextlib
import difflib
import functools
import gc
import hashlib
import importlib.machinery
import importlib.util
import inspect
import json
import os
import random
import resource
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from types import CodeType, FrameType, FunctionType
from typing import ClassVar

import hypothesis
import pytest

PROJECT = Path(__file__).resolve().parents[1]
COSMIC_RAY = Path(sys.prefix, "cosmic-ray", "bin", "python")
RESULTS = PROJECT / ".pytest_cache" / "d" / "mutants.jsonl"
EQUIVALENT = PROJECT / "tests" / "mutants.txt"

# The files that test each module most directly, in this order. Slow tests are omitted. Tests that
# need a sandbox come last, because one second for each of two thousand mutants is half an hour.
TESTS = {
    "grader/judging/points.py": ("test_points.py",),
    "grader/judging/hidden_tests.py": ("test_runner.py", "test_samples.py"),
    "grader/judging/results.py": ("test_verdict_paths.py", "test_proven_slips.py"),
    "grader/judging/error_carried_forward.py": ("test_rules.py",),
    "grader/judging/collection.py": ("test_runner.py",),
    "grader/judging/runner.py": ("test_runner.py",),
    "grader/judging/repair.py": ("test_proven_slips.py",),
    "grader/judging/mistake_diagnosis.py": ("test_proven_slips.py",),
    "grader/judging/program_run.py": ("test_runner.py", "test_verdict_paths.py"),
    "grader/judging/judge.py": ("test_verdict_paths.py",),
    "grader/judging/verdict_key.py": ("test_verdict_key.py",),
    "grader/judging/verdict.py": ("test_verdict.py",),
    "grader/course/atomic_files.py": ("test_atomic_files.py",),
    "extension/samples.py": ("test_samples.py",),
    "grader/judging/messages.py": ("test_messages.py",),
    "grader/intake/reader_process.py": ("test_reader_process.py",),
    "grader/intake/submission.py": ("test_submission.py",),
    "grader/intake/notebook.py": ("test_submission.py",),
    "grader/intake/pictures.py": ("test_pictures.py",),
    "grader/intake/preflight.py": (
        "test_preflight.py",
        "test_written_answers.py",
        "test_rules.py",
    ),
    "grader/lms/autograded_folder.py": ("test_gradebook.py", "test_enrolment.py"),
    "grader/lms/differences.py": ("test_gradebook.py", "test_dates.py"),
    "grader/lms/gradebook_writer.py": (
        "test_gradebook.py",
        "test_history.py",
        "test_enrolment.py",
        "test_rules.py",
    ),
    "grader/lms/stage_entries.py": ("test_gradebook.py", "test_enrolment.py"),
    "grader/lms/gradebook.py": ("test_gradebook.py",),
    "grader/lms/penalties.py": ("test_gradebook.py", "test_dates.py", "test_term_rules.py"),
    "grader/lms/term.py": ("test_term.py",),
    "grader/lms/registration.py": ("test_gradebook.py",),
    "grader/lms/gradebook_rows.py": ("test_standings.py", "test_gradebook.py"),
    "grader/lms/withdrawal.py": ("test_gradebook.py", "test_history.py"),
    "grader/classroom/grade.py": ("test_faults.py", "test_rules.py", "test_grading_by_roster.py"),
}

# Code that reads a module from standard input and prints each changed version as a line of JSON.
# A binary operator is replaced with three of the eleven others, drawn at random.
CHANGES = """
import collections, json, random, sys
from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator, operator_names

source, lot, places = sys.stdin.read(), random.Random(1), collections.defaultdict(list)
nodes = list(ast_nodes(get_ast(source)))
for name in operator_names():
    operator = get_operator(name)
    if not operator.arguments():
        kind = name.rpartition("_")[0] if "Binary" in name else name
        found = (place for node in nodes for place in operator().mutation_positions(node))
        for occurrence, place in enumerate(found):
            places[kind, place].append((name, occurrence))
for ways in places.values():
    for name, occurrence in lot.sample(ways, min(3, len(ways))):
        print(json.dumps(mutate_code(source, get_operator(name)(), occurrence)))
"""


DETECTED = ("killed", "stopped")
PATIENCE = 4  # factor by which the time limit grows for the second try
# Exit status; not 0, because a mutant may end its process with status 0.
SURVIVED = 57
DETECTED_BY = "noticed"  # file with the name of the test that detected the change


@dataclass(frozen=True)
class Mutant:
    """A module with one small change.

    Attributes
    ----------
    module : str
        Path of the module's file.
    before, after : str
        The lines that differ.
    source : str
        Source of the changed module.
    """

    module: str
    before: str
    after: str
    source: str

    @property
    def digest(self) -> str:
        """Key of the mutant in `RESULTS`."""
        return hashlib.sha256(f"{self.module} {self.source}".encode()).hexdigest()

    def __str__(self) -> str:
        return f"{self.module}\n- {self.before}\n+ {self.after}".rstrip()


class _AnnotationRemover(ast.NodeTransformer):
    """Removes annotations, which no module of the project evaluates."""

    def visit_AnnAssign(self, node: ast.AnnAssign) -> ast.AST:  # noqa: N802
        node.annotation = ast.Constant(None)
        return self.generic_visit(node)

    def visit_arg(self, node: ast.arg) -> ast.AST:
        node.annotation = None
        return node

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:  # noqa: N802
        node.returns = None
        return self.generic_visit(node)


def normalised_source(source: str) -> str:
    """Return the syntax tree of a program as text, without annotations or comments."""
    return ast.dump(_AnnotationRemover().visit(ast.parse(source)))


def mutants_of(module: str) -> Iterator[Mutant]:
    """Yield the mutants of a module that compile and differ not only in annotations."""
    source = (PROJECT / module).read_text("utf-8")
    done = subprocess.run(
        [COSMIC_RAY, "-c", CHANGES], input=source, stdout=subprocess.PIPE, text=True, check=True
    )
    seen = {normalised_source(source)}
    for line in done.stdout.splitlines():
        changed = json.loads(line)
        with contextlib.suppress(SyntaxError):
            meaning = normalised_source(changed)
            if meaning not in seen:
                seen.add(meaning)
                yield Mutant(module, *_difference(source, changed), changed)


def _difference(source: str, changed: str) -> tuple[str, str]:
    """Return the lines that differ in each of two sources, joined into one line."""
    lines = [text.splitlines() for text in (source, changed)]
    before, after = [], []
    for kind, a, b, c, d in difflib.SequenceMatcher(None, *lines, False).get_opcodes():
        if kind != "equal":
            before += lines[0][a:b]
            after += lines[1][c:d]
    return tuple(" ".join(" ".join(part).split()) for part in (before, after))


class _MutantLoader(importlib.machinery.SourceFileLoader):
    """A finder and loader that imports a mutant instead of its module."""

    def __init__(self, mutant: Mutant) -> None:
        self.mutant = mutant
        super().__init__(_module_name(mutant.module), str(PROJECT / mutant.module))

    def find_spec(
        self, name: str, path: object = None, target: object = None
    ) -> importlib.machinery.ModuleSpec | None:
        """Return the mutant's spec if `name` is the mutated module, and None otherwise."""
        if name != self.name:
            return None
        return importlib.util.spec_from_file_location(name, self.path, loader=self)

    def get_code(self, name: str) -> object:
        """Compile the mutant, because the cached bytecode belongs to the file on disk."""
        return compile(self.mutant.source, self.path, "exec", dont_inherit=True)


def _module_name(path: str) -> str:
    return path.removesuffix(".py").replace("/", ".")


def _parts(code: CodeType) -> Iterator[tuple[str, object]]:
    """Yield (name, code) for each function in a module or class, and ("", code) for the rest."""
    rest = []
    for part in code.co_consts:
        if not isinstance(part, CodeType) or "<" in part.co_name:
            rest.append(part)
        elif part.co_flags & inspect.CO_OPTIMIZED:  # a function, not a class
            yield part.co_qualname, part
        else:
            yield from _parts(part)
    yield "", (code.co_qualname, code.co_code, code.co_names, rest)


def changed_functions(mutant: Mutant) -> dict[str, CodeType] | None:
    """Return the new code of each function that a mutant changes; None if anything else changes."""
    sources = (PROJECT / mutant.module).read_text("utf-8"), mutant.source
    path = str(PROJECT / mutant.module)
    before, after = (list(_parts(compile(text, path, "exec", 0, True))) for text in sources)
    functions = {}
    if [name for name, _ in before] != [name for name, _ in after]:
        return None
    for (name, was), (_, becomes) in zip(before, after, strict=True):
        if was != becomes:
            if not name or was.co_freevars != becomes.co_freevars:
                return None
            functions[name] = becomes
    return functions


def apply_mutant(module: str, now: list[FunctionType], functions: dict[str, CodeType]) -> None:
    """Give the functions of a module the code of a mutant, and clear the module's caches."""
    for function in now:
        function.__code__ = functions.get(function.__qualname__, function.__code__)
    for known in vars(sys.modules[_module_name(module)]).values():
        if hasattr(known, "cache_clear"):
            known.cache_clear()


def functions_of(module: str) -> list[FunctionType]:
    """Return all functions of a module in memory, including decorated ones."""
    functions = (object_ for object_ in gc.get_objects() if isinstance(object_, FunctionType))
    path = str(PROJECT / module)
    return [function for function in functions if function.__code__.co_filename == path]


def forget_ours() -> None:
    """Remove the project's modules from memory, so that they are imported again."""
    for name in list(sys.modules):
        if name.partition(".")[0] in ("grader", "tests"):
            del sys.modules[name]


@dataclass(frozen=True)
class Run:
    """A run of a test with unchanged modules.

    Attributes
    ----------
    seconds, wall : float
        Processor time and elapsed time.
    entered : frozenset of (str, str)
        File and name of each of the grader's functions that ran in the test's own process.
    """

    seconds: float
    wall: float
    entered: frozenset[tuple[str, str]]


class MutantRunner:
    """A pytest plugin that collects the tests of a module once and runs them on mutants.

    Parameters
    ----------
    module : str
    mutants : list of Mutant
    folder : str
        Folder in which tests may write.
    report : callable
        Called with each mutant and its outcome.
    """

    runs: ClassVar[dict[str, Run]] = {}  # by test; shared, because modules can share tests

    def __init__(
        self, module: str, mutants: list[Mutant], folder: str, report: Callable[[Mutant, str], None]
    ) -> None:
        self.module, self.mutants, self.folder, self.report = module, mutants, folder, report
        self.functions: list[FunctionType] = []
        self.detected: Counter[str] = Counter()  # number of detected mutants by test

    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        """Run all tests in forks of this process."""
        gc.unfreeze()  # finds functions that were frozen for an earlier module
        self.functions = functions_of(self.module)
        gc.freeze()  # prevents garbage collection in forks from copying all objects
        if new := [item for item in session.items if item.nodeid not in self.runs]:
            self.runs.update(self._in_a_fork(new))
        for mutant, outcome in try_all(self.mutants, functools.partial(self._start_trial, session)):
            with contextlib.suppress(FileNotFoundError):
                self.detected[Path(self.folder, mutant.digest, DETECTED_BY).read_text("utf-8")] += 1
            self.report(mutant, outcome)
        return True

    def _in_a_fork(self, items: list[pytest.Item]) -> dict[str, Run]:
        """Run the tests on the unchanged modules; all of them must pass."""
        path = Path(self.folder, "runs")
        process = start_process(functools.partial(self._watch, items, path), 3600, self.folder)
        if os.waitstatus_to_exitcode(os.waitpid(process, 0)[1]) != SURVIVED:
            text = path.read_text("utf-8") if path.is_file() else "They were stopped."
            sys.exit(f"{self.module}: the nearest tests fail on the unchanged module.\n{text}")
        found = json.loads(path.read_text("utf-8"))
        return {
            name: Run(seconds, wall, frozenset(map(tuple, entered)))
            for name, (seconds, wall, entered) in found.items()
        }

    def _watch(self, items: list[pytest.Item], path: Path) -> int:
        ours, entered, found = str(PROJECT / "grader"), set(), {}

        def enter(frame: FrameType, event: str, argument: object) -> None:
            if (code := frame.f_code).co_filename.startswith(ours):
                entered.add((code.co_filename, code.co_qualname.partition(".<locals>")[0]))

        for item in items:
            entered.clear()
            cpu_start, wall_start = time.process_time(), time.monotonic()
            sys.settrace(enter)
            # With `nextitem=None`, shared fixtures end here, so each test pays for them.
            item.ihook.pytest_runtest_protocol(item=item, nextitem=None)
            sys.settrace(None)
            took = time.process_time() - cpu_start, time.monotonic() - wall_start
            found[item.nodeid] = (*took, sorted(entered))
            if item.session.testsfailed:
                path.write_text(item.nodeid, "utf-8")
                return 1
        path.write_text(json.dumps(found), "utf-8")
        return 0

    def _start_trial(
        self, session: pytest.Session, mutant: Mutant, patience: int
    ) -> tuple[int, float]:
        """Start a process that tries a mutant; return its process ID and its limit in seconds.

        Only tests that enter changed functions can detect the mutant. If no test is known to enter
        them, because they run in other processes, all tests run.
        """
        functions, items = changed_functions(mutant), self._most_likely_first(session.items)
        changed = {(str(PROJECT / self.module), name) for name in functions or ()}
        items = [item for item in items if self.runs[item.nodeid].entered & changed] or items
        seconds = 3 + 3 * sum(self.runs[item.nodeid].seconds for item in items)
        wall = 60 + 6 * sum(self.runs[item.nodeid].wall for item in items)
        work = functools.partial(self._run_with_new_imports, mutant)
        if functions and {*functions} <= {function.__qualname__ for function in self.functions}:
            work = functools.partial(self._run, items, functions)
        folder = f"{self.folder}/{mutant.digest}"
        return start_process(work, patience * seconds, folder), patience * wall

    def _most_likely_first(self, items: list[pytest.Item]) -> list[pytest.Item]:
        """Sort tests by time per detected mutant, but keep files together for shared fixtures."""
        takes = {
            item: self.runs[item.nodeid].seconds / (1 + self.detected[item.nodeid])
            for item in items
        }
        files = {item.path: takes[item] for item in sorted(items, key=takes.get, reverse=True)}
        return sorted(items, key=lambda item: (files[item.path], item.path, takes[item]))

    def _run(self, items: list[pytest.Item], functions: dict[str, CodeType]) -> int:
        apply_mutant(self.module, self.functions, functions)
        return first_failure(items)

    def _run_with_new_imports(self, mutant: Mutant) -> int:
        """Import the project again with the mutant and run the tests."""
        forget_ours()
        sys.meta_path.insert(0, _MutantLoader(mutant))
        run_tests(self.module, _RunAndExit(self._most_likely_first))
        return 1  # only reached if collecting fails, because the plugin ends the process


class _RunAndExit:
    """A pytest plugin that runs tests in a given order and then ends the process."""

    def __init__(self, order: Callable[[list[pytest.Item]], list[pytest.Item]]) -> None:
        self.order = order

    def pytest_runtestloop(self, session: pytest.Session) -> None:
        """Run the tests and end the process without pytest's clean-up, which is slow."""
        os._exit(first_failure(self.order(session.items)) or SURVIVED)


def first_failure(items: list[pytest.Item]) -> int:
    """Run tests until one fails; write its name to a file and return the number of failures."""
    for item, after in zip(items, [*items[1:], None], strict=True):
        item.ihook.pytest_runtest_protocol(item=item, nextitem=after)
        if failed := item.session.testsfailed:
            Path(os.environ["PYTEST_DEBUG_TEMPROOT"], DETECTED_BY).write_text(item.nodeid, "utf-8")
            return failed
    return 0


def run_tests(module: str, plugin: object) -> int:
    """Run pytest on the nearest tests of a module with a plugin, and return the exit code."""
    options = ("-o", "addopts=", "--import-mode=importlib", "-p", "no:cacheprovider")
    options += ("-p", "no:terminal", "-m", "not slow and not proof and not colab")
    return pytest.main([*(f"tests/{name}" for name in TESTS[module]), *options], [plugin])


def start_process(work: Callable[[], int], seconds: float, folder: str) -> int:
    """Run `work` in a new process with a limit on processor time; return the process ID.

    The process ends with `SURVIVED` if the work returns 0.
    """
    if process := os.fork():
        return process
    os.setsid()
    quiet = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(quiet, stream)
    resource.setrlimit(resource.RLIMIT_CPU, (int(seconds), int(seconds)))
    os.makedirs(folder, exist_ok=True)
    os.environ["PYTEST_DEBUG_TEMPROOT"] = folder
    code = 1
    try:
        code = work() or SURVIVED
    finally:
        os._exit(code)


def try_all(
    mutants: list[Mutant], start_trial: Callable[[Mutant, int], tuple[int, float]]
) -> Iterator[tuple[Mutant, str]]:
    """Try mutants in parallel; yield each with its outcome as soon as it is known.

    A stopped mutant is tried again with a longer limit, because other work may have slowed it.
    """
    waiting, running = [(mutant, 1) for mutant in mutants[::-1]], {}
    while waiting or running:
        while waiting and len(running) < len(os.sched_getaffinity(0)):
            mutant, patience = waiting.pop()
            process, wall = start_trial(mutant, patience)
            running[process] = mutant, patience, time.monotonic() + wall
        process, status = os.waitpid(-1, os.WNOHANG)
        if not process:
            time.sleep(0.02)
            for late in [pid for pid, (*_, end) in running.items() if time.monotonic() > end]:
                os.kill(late, signal.SIGKILL)
            continue
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process, signal.SIGKILL)  # also ends the processes that the mutant started
        mutant, patience, _ = running.pop(process)
        code = os.waitstatus_to_exitcode(status)
        if code < 0 and patience < PATIENCE:
            waiting.insert(0, (mutant, PATIENCE))
            continue
        yield mutant, {SURVIVED: "survived"}.get(code, "killed" if code >= 0 else "stopped")


@functools.cache
def known_results() -> dict[str, str]:
    """Return the outcomes of earlier runs, by the digest of the mutant."""
    lines = RESULTS.read_text("utf-8").splitlines() if RESULTS.is_file() else ()
    return {found["digest"]: found["outcome"] for found in map(json.loads, lines)}


def equivalent_mutants() -> set[str]:
    """Return the mutants listed in `EQUIVALENT`, each in the form of `str(mutant)`."""
    found, module, before = set(), "", ""
    for line in EQUIVALENT.read_text("utf-8").splitlines():
        if line.startswith("-"):
            before = line
        elif line.startswith("+"):
            found.add(f"{module}\n{before}\n{line}")
        elif line.endswith(".py"):
            module = line
    return found


def try_module(module: str, forgiven: set[str]) -> dict[Mutant, str]:
    """Try the mutants of a module that were not detected before; return all outcomes.

    The order is random, so an interrupted run has tried a fair sample of the mutants.
    """
    mutants, known = list(mutants_of(module)), known_results()
    random.Random(1).shuffle(mutants)
    ended = {
        mutant: known[mutant.digest]
        for mutant in mutants
        if known.get(mutant.digest, "") in DETECTED
    }
    waiting = [mutant for mutant in mutants if mutant not in ended]
    if waiting:
        RESULTS.parent.mkdir(parents=True, exist_ok=True)
        with open(RESULTS, "a", encoding="utf-8") as file, tempfile.TemporaryDirectory() as folder:

            def report(mutant: Mutant, outcome: str) -> None:
                print(json.dumps({"digest": mutant.digest, "outcome": outcome}), file=file)
                file.flush()
                if outcome == "survived" and str(mutant) in forgiven:
                    outcome = "equivalent"
                elif outcome == "survived":
                    print(mutant, flush=True)
                ended[mutant] = outcome

            if code := run_tests(module, MutantRunner(module, waiting, folder, report)):
                sys.exit(int(code))
    return ended


def main(wanted: list[str]) -> int:
    """Try the mutants of some modules, and print the survivors that are not listed as equivalent.

    Stopped mutants are also printed, because the cause may be the mutant or a busy machine.
    """
    os.chdir(PROJECT)
    sys.path.insert(0, str(PROJECT))
    # A fork of a process with OpenMP threads hangs.
    os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    hypothesis.settings.register_profile(
        "mutants",
        deadline=None,
        phases=[hypothesis.Phase.generate],
        database=None,
        derandomize=True,
    )
    hypothesis.settings.load_profile("mutants")
    forgiven, survived, stopped = equivalent_mutants(), 0, []
    for module in TESTS:
        if not wanted or any(part in module for part in wanted):
            outcomes = try_module(module, forgiven)
            ended = Counter(outcomes.values())
            summary = ", ".join(
                f"{ended[name]} {name}" for name in (*DETECTED, "equivalent", "survived")
            )
            print(f"{module}: {ended.total()} mutants, {summary}", flush=True)
            survived += ended["survived"]
            stopped += [mutant for mutant, outcome in outcomes.items() if outcome == "stopped"]
    if stopped:
        print("\nTheir tests reached the time limit twice:", *stopped, sep="\n")
    return min(survived, 1)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
