"""Change what decides a grade, one small thing at a time: the nearest tests have to notice.

    make mutants                              # everything; goes on where it was stopped
    .venv/bin/python tests/mutants.py points  # the modules with this in their path

The changes ("mutants") are cosmic-ray's. Each is made in memory, in a fork of this process, which
has run the tests before and holds all that takes long to import. What came of each is kept in
``.pytest_cache``: who survived is tried again, as tests may have come; delete that file to try all.
Survivors that change nothing anybody could notice are listed in ``mutants.txt``, with the reason.
"""

from __future__ import annotations

import ast
import contextlib
import difflib
import functools
import hashlib
import importlib.machinery
import importlib.util
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
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import hypothesis
import pytest

PROJECT = Path(__file__).resolve().parents[1]
COSMIC_RAY = Path(sys.prefix, "cosmic-ray", "bin", "python")
RESULTS = PROJECT / ".pytest_cache" / "d" / "mutants.jsonl"
EQUIVALENT = PROJECT / "tests" / "mutants.txt"

# The nearest tests of each module, nearest first. What is slow is left out, and what needs a
# sandbox stands last: a second for each of two thousand mutants is half an hour.
TESTS = {
    "grader/judging/points.py": ("test_points.py",),
    "grader/judging/marks.py": ("test_asking.py",),
    "grader/judging/results.py": ("test_verdicts_reached.py", "test_repair.py"),
    "grader/judging/followed.py": ("test_rules.py",),
    "grader/judging/asking.py": ("test_asking.py",),
    "grader/judging/repair.py": ("test_repair.py",),
    "grader/judging/explained.py": ("test_repair.py",),
    "grader/judging/trial.py": ("test_asking.py", "test_verdicts_reached.py"),
    "grader/judging/judge.py": ("test_verdicts_reached.py",),
    "grader/judging/key.py": ("test_key.py",),
    "grader/judging/verdict.py": ("test_verdict.py",),
    "grader/judging/samples.py": ("test_samples.py",),
    "grader/judging/messages.py": ("test_messages.py",),
    "grader/intake/apart.py": ("attacks/test_apart.py",),
    "grader/intake/handed_in.py": ("test_handed_in.py",),
    "grader/intake/notebook.py": ("test_handed_in.py",),
    "grader/intake/preflight.py": ("test_preflight.py", "test_rules.py"),
    "grader/lms/gradebook.py": ("test_gradebook.py",),
    "grader/classroom/grade.py": ("test_faults.py", "test_rules.py"),
}

# Prints changed versions of the module on standard input, each as a line of JSON: all that there
# are, but of the eleven other binary operators in a place three, drawn by lot.
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


DEAD = ("killed", "stopped")


@dataclass(frozen=True)
class Mutant:
    """A module with one small thing changed.

    Attributes
    ----------
    module : str
        Path of the file.
    before, after : str
        The lines that differ.
    source : str
        Of the changed module.
    """

    module: str
    before: str
    after: str
    source: str

    @property
    def digest(self) -> str:
        """By which it is known in `RESULTS`."""
        return hashlib.sha256(f"{self.module} {self.source}".encode()).hexdigest()

    def __str__(self) -> str:
        return f"{self.module}\n- {self.before}\n+ {self.after}".rstrip()


class _Bare(ast.NodeTransformer):
    """Takes annotations away: all our modules only write them down."""

    def visit_AnnAssign(self, node: ast.AnnAssign) -> ast.AST:  # noqa: N802
        node.annotation = ast.Constant(None)
        return self.generic_visit(node)

    def visit_arg(self, node: ast.arg) -> ast.AST:
        node.annotation = None
        return node

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:  # noqa: N802
        node.returns = None
        return self.generic_visit(node)


def meaning(source: str) -> str:
    """A program without what is never run."""
    return ast.dump(_Bare().visit(ast.parse(source)))


def mutants_of(module: str) -> Iterator[Mutant]:
    """The changed versions of a module that are programs, and mean something else than it does."""
    source = (PROJECT / module).read_text("utf-8")
    done = subprocess.run(
        [COSMIC_RAY, "-c", CHANGES], input=source, stdout=subprocess.PIPE, text=True, check=True
    )
    met = {meaning(source)}
    for line in done.stdout.splitlines():
        changed = json.loads(line)
        with contextlib.suppress(SyntaxError):
            means = meaning(changed)
            if means not in met:
                met.add(means)
                yield Mutant(module, *_difference(source, changed), changed)


def _difference(source: str, changed: str) -> tuple[str, str]:
    """The lines of each that the other has not."""
    lines = [text.splitlines() for text in (source, changed)]
    before, after = [], []
    for kind, a, b, c, d in difflib.SequenceMatcher(None, *lines, False).get_opcodes():
        if kind != "equal":
            before += lines[0][a:b]
            after += lines[1][c:d]
    return tuple(" ".join(" ".join(part).split()) for part in (before, after))


class _Changed(importlib.machinery.SourceFileLoader):
    """Loads a mutant in the place of its module."""

    def __init__(self, mutant: Mutant) -> None:
        self.mutant = mutant
        name = mutant.module.removesuffix(".py").replace("/", ".")
        super().__init__(name, str(PROJECT / mutant.module))

    def find_spec(
        self, name: str, path: object = None, target: object = None
    ) -> importlib.machinery.ModuleSpec | None:
        """As `sys.meta_path` asks for it."""
        if name != self.name:
            return None
        return importlib.util.spec_from_file_location(name, self.path, loader=self)

    def get_code(self, name: str) -> object:
        """Compiled anew, as what is on disk is another program."""
        return compile(self.mutant.source, self.path, "exec", dont_inherit=True)


def run_tests(module: str, folder: str) -> int:
    """Run the nearest tests of a module until one fails; pytest's exit code."""
    options = ("-o", "addopts=", "--import-mode=importlib", "-x", "-q", "-p", "no:cacheprovider")
    options += ("-m", "not slow and not proof and not colab", f"--basetemp={folder}")
    for tests in TESTS[module]:
        if code := pytest.main([f"tests/{tests}", *options]):
            return int(code)
    return 0


def forget_ours() -> None:
    """Let whatever may import what is changed be imported anew."""
    for name in list(sys.modules):
        if name.partition(".")[0] in ("grader", "tests"):
            del sys.modules[name]


def begin(mutant: Mutant, seconds: float, folder: str) -> int:
    """Try a mutant in a process of its own, for so many seconds of a processor; its id."""
    if process := os.fork():
        return process
    os.setsid()
    quiet = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(quiet, stream)
    resource.setrlimit(resource.RLIMIT_CPU, (int(seconds), int(seconds)))
    sys.meta_path.insert(0, _Changed(mutant))
    code = 1
    try:
        code = run_tests(mutant.module, folder)
    finally:
        os._exit(code)


def seconds_for(module: str) -> float:
    """How long the nearest tests may take; they have to hold for the module as it is."""
    untouched = Mutant(module, "", "", (PROJECT / module).read_text("utf-8"))
    with tempfile.TemporaryDirectory() as folder:
        code = run_tests(module, f"{folder}/first")
        forget_ours()
        if not code:
            process = begin(untouched, 600, f"{folder}/second")
            _, code, usage = os.wait4(process, 0)
    if code:
        sys.exit(f"{module}: the nearest tests fail on the module as it is.")
    return 5 + 4 * (usage.ru_utime + usage.ru_stime)


def try_all(mutants: list[Mutant], seconds: float) -> Iterator[tuple[Mutant, str]]:
    """Try mutants side by side; each with what became of it, as soon as that is known."""
    waiting, running = mutants[::-1], {}
    with tempfile.TemporaryDirectory() as folder:
        while waiting or running:
            while waiting and len(running) < len(os.sched_getaffinity(0)):
                mutant = waiting.pop()
                process = begin(mutant, seconds, f"{folder}/{mutant.digest}")
                running[process] = mutant, time.monotonic() + 6 * seconds
            process, status = os.waitpid(-1, os.WNOHANG)
            if not process:
                time.sleep(0.02)
                for late in [one for one, (_, end) in running.items() if time.monotonic() > end]:
                    os.kill(late, signal.SIGKILL)
                continue
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process, signal.SIGKILL)  # whoever it started
            mutant, _ = running.pop(process)
            code = os.waitstatus_to_exitcode(status)
            yield mutant, "survived" if code == 0 else "killed" if code > 0 else "stopped"


@functools.cache
def known_results() -> dict[str, str]:
    """What became of mutants in earlier runs."""
    lines = RESULTS.read_text("utf-8").splitlines() if RESULTS.is_file() else ()
    return {found["digest"]: found["outcome"] for found in map(json.loads, lines)}


def equivalent() -> set[str]:
    """The mutants in `EQUIVALENT`, each as `str` gives it."""
    found, module, before = set(), "", ""
    for line in EQUIVALENT.read_text("utf-8").splitlines():
        if line.startswith("-"):
            before = line
        elif line.startswith("+"):
            found.add(f"{module}\n{before}\n{line}")
        elif line.startswith("grader/"):
            module = line
    return found


def try_module(module: str, forgiven: set[str]) -> Counter[str]:
    """Try the mutants of a module of which it is not known that they die; how many ended how.

    In random order: what a run has tried that was stopped is a fair sample.
    """
    mutants, known = list(mutants_of(module)), known_results()
    random.Random(1).shuffle(mutants)
    ended = Counter(known[one.digest] for one in mutants if known.get(one.digest, "") in DEAD)
    waiting = [one for one in mutants if known.get(one.digest, "") not in DEAD]
    if waiting:
        seconds = seconds_for(module)
        RESULTS.parent.mkdir(parents=True, exist_ok=True)
        with open(RESULTS, "a", encoding="utf-8") as file:
            for mutant, outcome in try_all(waiting, seconds):
                print(json.dumps({"digest": mutant.digest, "outcome": outcome}), file=file)
                file.flush()
                if outcome == "survived" and str(mutant) in forgiven:
                    outcome = "equivalent"
                elif outcome == "survived":
                    print(mutant, flush=True)
                ended[outcome] += 1
    return ended


def main(wanted: list[str]) -> int:
    """Try the mutants of some modules; say who survives without being known as equivalent."""
    os.chdir(PROJECT)
    sys.path.insert(0, str(PROJECT))
    # A fork of a process in which OpenMP had threads stands still.
    os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    hypothesis.settings.register_profile(
        "mutants", phases=[hypothesis.Phase.generate], database=None, derandomize=True
    )
    hypothesis.settings.load_profile("mutants")
    forgiven, survived = equivalent(), 0
    for module in TESTS:
        if not wanted or any(part in module for part in wanted):
            ended = try_module(module, forgiven)
            how = ", ".join(f"{ended[name]} {name}" for name in (*DEAD, "equivalent", "survived"))
            print(f"{module}: {ended.total()} mutants, {how}", flush=True)
            survived += ended["survived"]
    return min(survived, 1)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
