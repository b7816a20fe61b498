"""Let a student continue after a wrong answer.

If a cell of the lesson fails with a function that has not passed its check, the function is treated
as a stub. The cell runs again with the stored answers, below a notice. If it fails again, the
first failure is shown as usual.

The student's own function is always used in checks, in cells above its check and in cells that are
not part of the lesson. All cells use it again once it passes or is redefined.
"""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from utils.checks.static_analysis import functions_used
from utils.display import shell
from utils.lent.rerun import RerunPlan, free_names, key_of_cell, plan, tests_own_function
from utils.lent.stubs import is_written
from utils.notebooks import slicing
from utils.notebooks.statements import Statement

if TYPE_CHECKING:
    from IPython.core.interactiveshell import ExecutionInfo, ExecutionResult

    from utils.lent.stand_ins import Lender


@dataclass(frozen=True)
class _Failed:
    """A function that failed its check, and the position of that check in the lesson."""

    function: Callable
    place: int
    hangs: bool


@dataclass
class _Cell:
    """The running cell, and the state before it ran."""

    source: str
    place: int | None  # position in the lesson; None for a cell that the student added
    generators: list[tuple[np.random.Generator, dict]]
    figures: set[int]
    passed: set[str] = field(default_factory=set)
    failure: tuple | None = None  # arguments for a delayed call to showtraceback


class Continuation:
    """Reruns a cell with stored answers if it fails because of a wrong function.

    Parameters
    ----------
    lender : Lender
    namespace : dict
        The notebook's namespace.
    cells : sequence of str
        Keys of the lesson's code cells from `key_of_cell`, in order.
    show : callable
        The shell's own `showtraceback`.
    """

    def __init__(
        self, lender: Lender, namespace: dict, cells: Sequence[str], show: Callable
    ) -> None:
        self._lender, self._namespace, self._show = lender, namespace, show
        self._places = {key: place for place, key in enumerate(cells)}
        self._ran: dict[int, str] = {}
        self._broken: set[int] = set()
        self._failed: dict[str, _Failed] = {}
        self._switched: set[str] = set()
        # Names whose values come from stored answers, and the functions that the answers replaced.
        self._borrowed: dict[str, frozenset[str]] = {}
        self._cell: _Cell | None = None
        self._trial: list[object] | None = None  # errors in a rerun; None outside a rerun

    def before_cell(self, info: ExecutionInfo) -> None:
        """Install the functions that a cell should use."""
        if self._trial is not None:
            return
        self._lender.give_back()
        source = info.raw_cell
        place = self._places.get(key_of_cell(source))
        self._cell = _Cell(source, place, _generators(self._namespace), _figures())
        if place is not None and not tests_own_function(source):
            self._ran[place] = source
            self._broken.add(place)  # until it succeeds
            wrong = self._wrong_at(place)
            self._set_aside(wrong & self._switched)
            hanging = [name for name in wrong - self._switched if self._failed[name].hangs]
            if hanging and (found := self._plan(place, hanging)).functions:
                self._substitute(found)
        self._announce(free_names(source))

    def after_cell(self, result: ExecutionResult | None) -> None:
        """Rerun a failed cell with stored answers, or show its failure."""
        if self._trial is not None:
            return
        cell, self._cell = self._cell, None
        if cell is None:
            return
        succeeded = result is not None and result.success
        if cell.failure:
            with contextlib.suppress(Exception):  # a fault in the rerun must not hide the failure
                succeeded = self._rerun_cell(cell) or self._rerun_cell(cell, include_changed=True)
            if succeeded and result is not None:
                result.error_in_exec = None
            elif not succeeded:
                arguments, options = cell.failure
                self._show(*arguments, **options)
        if succeeded:
            self._broken.discard(cell.place)
            self._update_borrowed(cell)
        self._return_passed(cell)

    def show_traceback(self, *arguments: object, **options: object) -> None:
        """Replace the shell's `showtraceback`: delay a failure if the cell can be rerun."""
        error = (arguments[0] if arguments else options.get("exc_tuple")) or sys.exc_info()
        if self._trial is not None:
            self._trial.append(error)
        elif self._cell and isinstance(error[1], Exception) and self._can_rerun(self._cell):
            # Store the error, because sys.exc_info() will be empty when it is shown.
            options.pop("exc_tuple", None)
            self._cell.failure = self._cell.failure or ((error, *arguments[1:]), options)
        else:
            self._show(*arguments, **options)

    def record_check(self, exercise: str, passed: bool, hangs: bool) -> None:
        """Record the result of a check."""
        if self._cell is None:
            return
        self._failed.pop(exercise, None)
        function = self._lender.mine(exercise)
        if passed:
            self._cell.passed.add(exercise)
        elif self._cell.place is not None and function is not None and is_written(function):
            self._failed[exercise] = _Failed(function, self._cell.place, hangs)

    def _set_aside(self, names: Collection[str]) -> None:
        self._lender.set_aside(names, set().union(*map(self._callers_of, names)))

    def _callers_of(self, name: str) -> set[str]:
        """Return the written exercises that call a function of this name."""
        written = {other: self._lender.mine(other) for other in self._lender.exercises}
        return {
            other
            for other, function in written.items()
            if other != name and function is not None and name in functions_used(function)
        }

    def _wrong_at(self, place: int) -> set[str]:
        """Return the functions that failed a check above a position and are unchanged since."""
        return {
            name
            for name, failed in self._failed.items()
            if failed.place < place and failed.function is self._lender.mine(name)
        }

    def _can_rerun(self, cell: _Cell) -> bool:
        if cell.place not in self._ran:
            return False
        found = self._plan(cell.place, include_changed=True)
        return bool(found.functions or found.given)

    def _plan(
        self, place: int, functions: Collection[str] | None = None, include_changed: bool = False
    ) -> RerunPlan:
        wrong = self._wrong_at(place) if functions is None else functions
        callers = {name: {name, *self._callers_of(name)} for name in wrong}
        cells = [self._ran.get(number, "") for number in range(place + 1)]
        return plan(cells, callers, self._broken - {place}, include_changed)

    def _rerun_cell(self, cell: _Cell, include_changed: bool = False) -> bool:
        """Run a cell again with stored answers; return whether it succeeded."""
        found, before = (
            self._plan(cell.place, include_changed=include_changed),
            dict(self._namespace),
        )
        if not (found.functions or found.given) or not self._substitute(found):
            return False
        for generator, state in cell.generators:
            generator.bit_generator.state = state
        _close_figures(cell.figures)
        _clear_output()
        self._trial = []
        try:
            self._lender.announce_replaced(found.functions, first=True)
            self._lender.announce_recomputed(found.given)
            ran = shell().run_cell(cell.source, store_history=False).success and not self._trial
        finally:
            self._trial = None
        if not ran:
            _close_figures(cell.figures)
            _clear_output()
            self._switched -= found.functions
            _restore(self._namespace, before)
            self._lender.give_back()  # last, because `before` may contain wrappers
        return ran

    def _substitute(self, found: RerunPlan) -> bool:
        """Replace functions with stored answers, and silently rerun statements that used them."""
        self._set_aside(found.functions)
        if not self._rerun_statements(found.statements):
            self._lender.give_back()
            return False
        self._switched |= found.functions
        self._borrowed |= dict.fromkeys(found.names, found.functions)
        self._lender.wrap_stubs()
        return True

    def _rerun_statements(self, statements: Sequence[Statement]) -> bool:
        """Run statements again without output; return whether all succeeded."""
        from IPython.utils.capture import capture_output

        figures, before = _figures(), dict(self._namespace)
        try:
            with capture_output():
                for statement in statements:
                    code = slicing.compile_statement(statement, "<the lesson>")
                    exec(code, self._namespace)
        except Exception:
            _restore(self._namespace, before)
            return False
        finally:
            _close_figures(figures)
        return True

    def _update_borrowed(self, cell: _Cell) -> None:
        """Record, after a cell, which names have values that come from stored answers."""
        aside = self._lender.aside
        found = self._plan(cell.place, aside) if cell.place in self._ran and aside else None
        for statement in slicing.parse_notebook([cell.source])[0]:
            sources = [self._borrowed[name] for name in statement.uses & self._borrowed.keys()]
            if found and statement.binds & found.names:
                sources.append(found.functions)
            for name in statement.binds:
                if sources:
                    self._borrowed[name] = frozenset().union(*sources)
                else:
                    self._borrowed.pop(name, None)

    def _return_passed(self, cell: _Cell) -> None:
        """Recompute values with the student's own functions that passed their checks in a cell."""
        for exercise in cell.passed & self._switched:
            self._switched.discard(exercise)
            made = {name for name, sources in self._borrowed.items() if exercise in sources}
            last = max(self._ran, default=0)
            # A dummy cell that uses these names makes the plan include their statements.
            self._ran[last + 1] = "; ".join(sorted(made))
            statements = self._plan(last + 1, [exercise]).statements
            del self._ran[last + 1]
            if self._rerun_statements(statements):
                for name in made:
                    del self._borrowed[name]
            self._lender.announce_returned(exercise)

    def _announce(self, names: Collection[str]) -> None:
        """Show which names in a cell have values from stored answers."""
        for name in sorted(names & self._borrowed.keys()):
            if self._borrowed[name] <= self._lender.aside:
                self._lender.announce_replaced(self._borrowed[name])
            else:
                self._lender.announce_borrowed(name, self._borrowed[name])


def _generators(namespace: dict) -> list[tuple[np.random.Generator, dict]]:
    found = [value for value in namespace.values() if isinstance(value, np.random.Generator)]
    return [(generator, generator.bit_generator.state) for generator in found]


def _restore(namespace: dict, before: dict) -> None:
    """Restore each name of a namespace, except IPython's own, which begin with an underscore."""
    for name in [name for name in namespace if name not in before and not name.startswith("_")]:
        del namespace[name]
    namespace.update({name: value for name, value in before.items() if not name.startswith("_")})


def _figures() -> set[int]:
    pyplot = sys.modules.get("matplotlib.pyplot")
    return set(pyplot.get_fignums()) if pyplot else set()


def _close_figures(others: set[int]) -> None:
    for figure in _figures() - others:
        sys.modules["matplotlib.pyplot"].close(figure)


def _clear_output() -> None:
    from IPython.display import clear_output

    with contextlib.suppress(Exception):
        sys.stdout.flush()
    clear_output(wait=True)
