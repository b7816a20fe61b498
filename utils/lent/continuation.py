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
from utils.lent.rerun_plan import RerunPlan, free_names, key_of_cell, plan_rerun, tests_own_function
from utils.lent.stubs import is_written
from utils.notebooks import slicing
from utils.notebooks.statements import Statement

if TYPE_CHECKING:
    from IPython.core.interactiveshell import ExecutionInfo, ExecutionResult

    from utils.lent.stand_ins import Lender


@dataclass(frozen=True)
class _FailedFunction:
    """A function that failed its check, and the position of that check in the lesson."""

    function: Callable
    position: int
    hangs: bool


@dataclass
class _RunningCell:
    """The running cell, and the state before it ran."""

    source: str
    position: int | None  # position in the lesson; None for a cell that the student added
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
        self._lender, self._namespace, self._show_shell_traceback = lender, namespace, show
        self._position_of_key = {key: position for position, key in enumerate(cells)}
        self._sources_by_position: dict[int, str] = {}
        self._positions_of_failed_cells: set[int] = set()
        self._failed_functions: dict[str, _FailedFunction] = {}
        self._replaced_functions: set[str] = set()
        # Names whose values come from stored answers, and the functions that the answers replaced.
        self._functions_behind_name: dict[str, frozenset[str]] = {}
        self._cell: _RunningCell | None = None
        self._rerun_errors: list[object] | None = None  # errors in a rerun; None outside a rerun

    def before_cell(self, info: ExecutionInfo) -> None:
        """Install the functions that a cell should use."""
        if self._rerun_errors is not None:
            return
        self._lender.restore_functions()
        source = info.raw_cell
        position = self._position_of_key.get(key_of_cell(source))
        self._cell = _RunningCell(
            source, position, _generator_states(self._namespace), _open_figures()
        )
        if position is not None and not tests_own_function(source):
            self._sources_by_position[position] = source
            self._positions_of_failed_cells.add(position)  # until it succeeds
            wrong = self._wrong_functions_at(position)
            self._set_aside(wrong & self._replaced_functions)
            hanging = [
                name
                for name in wrong - self._replaced_functions
                if self._failed_functions[name].hangs
            ]
            if hanging and (found := self._plan(position, hanging)).functions:
                self._use_stored_answers(found)
        self._announce_borrowed_values(free_names(source))

    def after_cell(self, result: ExecutionResult | None) -> None:
        """Rerun a failed cell with stored answers, or show its failure."""
        if self._rerun_errors is not None:
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
                self._show_shell_traceback(*arguments, **options)
        if succeeded:
            self._positions_of_failed_cells.discard(cell.position)
            self._record_borrowed_values(cell)
        self._recompute_borrowed_values(cell)

    def show_traceback(self, *arguments: object, **options: object) -> None:
        """Replace the shell's `showtraceback`: delay a failure if the cell can be rerun."""
        error = (arguments[0] if arguments else options.get("exc_tuple")) or sys.exc_info()
        if self._rerun_errors is not None:
            self._rerun_errors.append(error)
        elif self._cell and isinstance(error[1], Exception) and self._can_rerun(self._cell):
            # Store the error, because sys.exc_info() will be empty when it is shown.
            options.pop("exc_tuple", None)
            self._cell.failure = self._cell.failure or ((error, *arguments[1:]), options)
        else:
            self._show_shell_traceback(*arguments, **options)

    def record_check(self, exercise: str, passed: bool, hangs: bool) -> None:
        """Record the result of a check."""
        if self._cell is None:
            return
        self._failed_functions.pop(exercise, None)
        function = self._lender.own_function(exercise)
        if passed:
            self._cell.passed.add(exercise)
        elif self._cell.position is not None and function is not None and is_written(function):
            self._failed_functions[exercise] = _FailedFunction(function, self._cell.position, hangs)

    def _set_aside(self, names: Collection[str]) -> None:
        self._lender.set_aside(names, set().union(*map(self._callers_of, names)))

    def _callers_of(self, name: str) -> set[str]:
        """Return the written exercises that call a function of this name."""
        written = {other: self._lender.own_function(other) for other in self._lender.exercises}
        return {
            other
            for other, function in written.items()
            if other != name and function is not None and name in functions_used(function)
        }

    def _wrong_functions_at(self, position: int) -> set[str]:
        """Return the functions that failed a check above a position and are unchanged since."""
        return {
            name
            for name, failed in self._failed_functions.items()
            if failed.position < position and failed.function is self._lender.own_function(name)
        }

    def _can_rerun(self, cell: _RunningCell) -> bool:
        if cell.position not in self._sources_by_position:
            return False
        rerun = self._plan(cell.position, include_changed=True)
        return bool(rerun.functions or rerun.argument_takers)

    def _plan(
        self, position: int, functions: Collection[str] | None = None, include_changed: bool = False
    ) -> RerunPlan:
        wrong = self._wrong_functions_at(position) if functions is None else functions
        callers = {name: {name, *self._callers_of(name)} for name in wrong}
        cells = [self._sources_by_position.get(number, "") for number in range(position + 1)]
        return plan_rerun(
            cells, callers, self._positions_of_failed_cells - {position}, include_changed
        )

    def _rerun_cell(self, cell: _RunningCell, include_changed: bool = False) -> bool:
        """Run a cell again with stored answers; return whether it succeeded."""
        rerun, before = (
            self._plan(cell.position, include_changed=include_changed),
            dict(self._namespace),
        )
        if not (rerun.functions or rerun.argument_takers) or not self._use_stored_answers(rerun):
            return False
        for generator, state in cell.generators:
            generator.bit_generator.state = state
        _close_figures_except(cell.figures)
        _clear_output()
        self._rerun_errors = []
        try:
            self._lender.announce_replaced(rerun.functions, first=True)
            self._lender.announce_recomputed(rerun.argument_takers)
            succeeded = (
                shell().run_cell(cell.source, store_history=False).success
                and not self._rerun_errors
            )
        finally:
            self._rerun_errors = None
        if not succeeded:
            _close_figures_except(cell.figures)
            _clear_output()
            self._replaced_functions -= rerun.functions
            _restore(self._namespace, before)
            self._lender.restore_functions()  # last, because `before` may contain wrappers
        return succeeded

    def _use_stored_answers(self, rerun: RerunPlan) -> bool:
        """Replace functions with stored answers, and silently rerun statements that used them."""
        self._set_aside(rerun.functions)
        if not self._rerun_statements(rerun.statements):
            self._lender.restore_functions()
            return False
        self._replaced_functions |= rerun.functions
        self._functions_behind_name |= dict.fromkeys(rerun.names, rerun.functions)
        self._lender.wrap_stubs()
        return True

    def _rerun_statements(self, statements: Sequence[Statement]) -> bool:
        """Run statements again without output; return whether all succeeded."""
        from IPython.utils.capture import capture_output

        figures, before = _open_figures(), dict(self._namespace)
        try:
            with capture_output():
                for statement in statements:
                    code = slicing.compile_statement(statement, "<the lesson>")
                    exec(code, self._namespace)
        except Exception:
            _restore(self._namespace, before)
            return False
        finally:
            _close_figures_except(figures)
        return True

    def _record_borrowed_values(self, cell: _RunningCell) -> None:
        """Record, after a cell, which names have values that come from stored answers."""
        aside = self._lender.names_set_aside
        rerun = (
            self._plan(cell.position, aside)
            if cell.position in self._sources_by_position and aside
            else None
        )
        for statement in slicing.parse_notebook([cell.source])[0]:
            sources = [
                self._functions_behind_name[name]
                for name in statement.uses & self._functions_behind_name.keys()
            ]
            if rerun and statement.binds & rerun.names:
                sources.append(rerun.functions)
            for name in statement.binds:
                if sources:
                    self._functions_behind_name[name] = frozenset().union(*sources)
                else:
                    self._functions_behind_name.pop(name, None)

    def _recompute_borrowed_values(self, cell: _RunningCell) -> None:
        """Recompute values with the student's own functions that passed their checks in a cell."""
        for exercise in cell.passed & self._replaced_functions:
            self._replaced_functions.discard(exercise)
            names = {
                name for name, sources in self._functions_behind_name.items() if exercise in sources
            }
            last = max(self._sources_by_position, default=0)
            # A dummy cell that uses these names makes the plan include their statements.
            self._sources_by_position[last + 1] = "; ".join(sorted(names))
            statements = self._plan(last + 1, [exercise]).statements
            del self._sources_by_position[last + 1]
            if self._rerun_statements(statements):
                for name in names:
                    del self._functions_behind_name[name]
            self._lender.announce_returned(exercise)

    def _announce_borrowed_values(self, names: Collection[str]) -> None:
        """Show which names in a cell have values from stored answers."""
        for name in sorted(names & self._functions_behind_name.keys()):
            if self._functions_behind_name[name] <= self._lender.names_set_aside:
                self._lender.announce_replaced(self._functions_behind_name[name])
            else:
                self._lender.announce_borrowed(name, self._functions_behind_name[name])


def _generator_states(namespace: dict) -> list[tuple[np.random.Generator, dict]]:
    found = [value for value in namespace.values() if isinstance(value, np.random.Generator)]
    return [(generator, generator.bit_generator.state) for generator in found]


def _restore(namespace: dict, before: dict) -> None:
    """Restore each name of a namespace, except IPython's own, which begin with an underscore."""
    for name in [name for name in namespace if name not in before and not name.startswith("_")]:
        del namespace[name]
    namespace.update({name: value for name, value in before.items() if not name.startswith("_")})


def _open_figures() -> set[int]:
    pyplot = sys.modules.get("matplotlib.pyplot")
    return set(pyplot.get_fignums()) if pyplot else set()


def _close_figures_except(others: set[int]) -> None:
    for figure in _open_figures() - others:
        sys.modules["matplotlib.pyplot"].close(figure)


def _clear_output() -> None:
    from IPython.display import clear_output

    with contextlib.suppress(Exception):
        sys.stdout.flush()
    clear_output(wait=True)
