"""Run a whole lesson as a student would, cell by cell despite failures, and record the results."""

import contextlib
import io
import json
import os
import pickle
import re
import signal
import sys
import traceback
from dataclasses import dataclass, field

from grader.course.kept_answers import ANOTHER_CELL, answers_to, fill_in

LONGEST = 300  # maximum seconds until the next result of a run


@dataclass
class Cell:
    """A code cell and the results of running it."""

    source: str
    grade_id: str = ""
    errors: list = field(default_factory=list)
    tracebacks: list = field(default_factory=list)
    displayed: list = field(default_factory=list)
    printed: str = ""
    succeeded: bool = False

    @property
    def checks(self):
        """Whether the cell calls `check`."""
        return self.source.startswith("check(")

    @property
    def banners(self):
        """Messages that say which answer the lesson uses: the course's or the student's own."""
        return [text for text in self.displayed if re.search("course's answer|yours again", text)]


def right_answers(lesson):
    """Return a right answer to each exercise of a lesson."""
    found = {}
    for exercise in lesson.machine_graded:
        rights = [answer for answer in answers_to(exercise.name) if answer.right]
        found[exercise.name] = next(
            (right for right in rights if right.follows_hints), rights[0]
        ).source
    return found


def runs_with_answers(lesson, exercise, sources):
    """Run a notebook once for each answer to an exercise, with right answers elsewhere.

    Yields
    ------
    list of Cell
        The cells from the answer's cell onwards. The cells above run only once, and each answer
        runs in a copy of that process.
    """
    return map(pickle.loads, _in_fork(_run_each, lesson, exercise, list(sources)))


def _run_each(lesson, exercise, sources):
    shell = _shell(lesson.released.parent)
    for cell in _cells(lesson, exercise, "")[0]:
        _run(shell, cell)
        assert cell.succeeded or cell.checks, cell  # optional exercises have no answer to check
    for source in sources:
        yield from _in_fork(_run_cells, shell, _cells(lesson, exercise, source)[1])


def run_cells(sources, prepare):
    """Run some cells in a new notebook and return them as `Cell` objects with their results.

    Parameters
    ----------
    sources : list of str
    prepare : callable
        Called with the shell before the cells run.
    """

    def work():
        shell = _shell(os.getcwd())
        prepare(shell)
        yield from _run_cells(shell, [Cell(source) for source in sources])

    return pickle.loads(next(_in_fork(work)))


def _run_cells(shell, cells):
    for cell in cells:
        _run(shell, cell)
    yield pickle.dumps(cells)


def _in_fork(work, *arguments):
    """Run a generator of bytes in a fork of this process, and yield its items here."""
    read_end, write_end = os.pipe()
    child = os.fork()
    if child == 0:
        status = 1
        try:
            os.close(read_end)
            signal.alarm(LONGEST)
            with os.fdopen(write_end, "wb") as pipe:
                for text in work(*arguments):
                    pipe.write(len(text).to_bytes(8, "big") + text)
                    pipe.flush()
                    signal.alarm(LONGEST)
            status = 0
        except BaseException:
            traceback.print_exc(file=sys.__stderr__)
        finally:
            os._exit(status)
    os.close(write_end)
    with os.fdopen(read_end, "rb") as pipe:
        while size := pipe.read(8):
            yield pipe.read(int.from_bytes(size, "big"))
    assert os.waitpid(child, 0)[1] == 0


def _cells(lesson, exercise, source):
    """Return the code cells above an answer, and the code cells from the answer onwards."""
    answers = right_answers(lesson) | ({exercise: source} if source else {})
    cells = [
        Cell("".join(cell["source"]), cell["metadata"].get("nbgrader", {}).get("grade_id", ""))
        for cell in json.loads(fill_in(lesson, answers))["cells"]
        if cell["cell_type"] == "code"
    ]
    place = next(n for n, cell in enumerate(cells) if cell.grade_id == exercise)
    place -= answers[exercise].count(ANOTHER_CELL)
    return cells[:place], cells[place:]


def _shell(folder):
    import matplotlib

    matplotlib.use("agg")
    import matplotlib.pyplot as plt
    from IPython.core.displaypub import CapturingDisplayPublisher
    from IPython.core.interactiveshell import InteractiveShell

    os.chdir(folder)
    InteractiveShell.history_length = 0
    shell = InteractiveShell.instance()
    shell.history_manager.enabled = False
    shell.display_pub = CapturingDisplayPublisher()
    # Like a notebook, close a cell's figures when the cell ends.
    shell.events.register("post_execute", lambda: plt.close("all"))
    plt.show = lambda *about, **more: plt.close("all")
    return shell


def _run(shell, cell):
    shell.display_pub.outputs.clear()
    printed = io.StringIO()

    def keep(kind, error, lines):
        cell.errors.append(f"{kind.__name__}: {error}")
        cell.tracebacks.append(re.sub(r"\x1b\[[0-9;]*m", "", "\n".join(lines)))

    shell._showtraceback = keep

    def clear(wait=False):
        shell.display_pub.outputs.clear()
        printed.seek(0)
        printed.truncate()

    shell.display_pub.clear_output = clear
    with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(io.StringIO()):
        cell.succeeded = shell.run_cell(cell.source, store_history=False).success
    cell.displayed = [
        str(output["data"].get("text/plain", "")) for output in shell.display_pub.outputs
    ]
    cell.printed = printed.getvalue()
