"""Show the results of checks: a table in a notebook, plain text elsewhere."""

import re
from collections.abc import Iterable, Sequence
from html import escape

from utils.checks.outcomes import Check, Outcome
from utils.checks.summary import Summary, failure_texts
from utils.display import shell

# White text on these colours has a contrast of at least 4.5:1. Words and symbols also name the
# state, for readers who cannot distinguish the colours.
_STATES = {
    "passed": ("#1a7f4b", "✓ passed"),
    "failed": ("#c4420b", "✗ failed"),
    "note": ("#8a5a00", "! note"),
    "waiting": ("#5f6670", "… waiting"),
    "not started": ("#5f6670", "not started"),
}
# Next to a failure, more than this many passed or waiting checks are folded into one row.
_MAX_SEPARATE_ROWS = 3


class Table:
    """A table of checks that grows while they run.

    Parameters
    ----------
    checks : sequence of utils.checks.outcomes.Check
        All checks that will run.
    """

    def __init__(self, checks: Sequence[Check]) -> None:
        self._checks, self._handle, self._in_notebook = checks, None, shell() is not None

    def show(self, outcomes: Sequence[Outcome]) -> None:
        """Display the results so far in a notebook; plain text is printed only at the end."""
        if self._in_notebook:
            rows = [_row("failed" if o.failure else "passed", o.check.title) for o in outcomes]
            if len(outcomes) < len(self._checks):
                rows.append(_row("waiting", f"{self._checks[len(outcomes)].title}: running"))
            self._display(_table(rows), "checks are running")

    def finish(self, summary: Summary) -> None:
        """Display all results, and the picture of the first failure."""
        if not self._in_notebook:
            print(as_text(summary))
            return
        self._display(as_html(summary), as_text(summary))
        if summary.first and summary.first.failure.draw:
            import matplotlib.pyplot as plt

            opened = set(plt.get_fignums())
            try:
                summary.first.failure.draw()
            except Exception:  # an answer may be too wrong to be drawn
                for figure in set(plt.get_fignums()) - opened:
                    plt.close(figure)
            plt.show()

    def _display(self, html: str, text: str) -> None:
        from IPython.display import display

        data = {"text/html": html, "text/plain": text}
        if self._handle:
            self._handle.update(data, raw=True)
        else:
            self._handle = display(data, raw=True, display_id=True)


def as_text(summary: Summary) -> str:
    """Format a summary as plain text."""
    if summary.not_started:
        return f"[not started] {summary.first.failure.message}"
    lines = []
    if summary.first:
        lines.append(f"[failed] {summary.first.check.title}")
        lines += [f"    {label}: {text}" for label, text in _all_details(summary)]
        lines += [f"    Where to look: {summary.line_hint.sentence}"] if summary.line_hint else []
    lines += [
        f"    [failed] for the same reason: {outcome.check.title}" for outcome in summary.same
    ]
    lines += [f"[failed] {o.check.title}: {o.failure.message}" for o in summary.others]
    lines += [f"[waiting] {outcome.check.title}" for outcome in summary.waiting]
    lines += [f"[passed] {outcome.check.title}" for outcome in summary.passed]
    lines += [
        f"[note] {outcome.check.title}: {outcome.failure.message} {outcome.check.why}"
        for outcome in summary.notes
    ]
    return "\n".join(lines)


def as_html(summary: Summary) -> str:
    """Format a summary as an HTML table."""
    if summary.not_started:
        return _table([_row("not started", "", _line("", summary.first.failure.message))])
    rows = []
    if summary.first:
        body = "".join(_line(label, text) for label, text in _all_details(summary))
        if summary.line_hint:
            body += (
                f"<details><summary>Where to look</summary>{_line('', summary.line_hint.sentence)}"
                "</details>"
            ).replace("<br>", "")
        if summary.same:
            body += (
                f"<details><summary>{_more_failures_text(summary.same)} for the same reason"
                "</summary>"
                f"{_titles(outcome.check for outcome in summary.same)}</details>"
            )
        rows.append(_row("failed", summary.first.check.title, body))
    rows += [
        _row("failed", outcome.check.title, _line("", outcome.failure.message))
        for outcome in summary.others
    ]
    rows += _rows("waiting", summary.waiting, summary)
    rows += _rows("passed", summary.passed, summary)
    rows += [
        _row(
            "note", outcome.check.title, _line("", f"{outcome.failure.message} {outcome.check.why}")
        )
        for outcome in summary.notes
    ]
    return _table(rows)


def _all_details(summary: Summary) -> list[tuple[str, str]]:
    """Return the details of the first failure, preceded by the function to fix first, if any."""
    lines = failure_texts(summary.first, summary.mistake)
    if summary.wrong_helper:
        sentence = f"{summary.wrong_helper}, which this function calls, fails its own checks."
        lines.insert(0, ("Fix this first", sentence))
    return lines


def _rows(state: str, outcomes: Sequence[Outcome], summary: Summary) -> list[str]:
    """Return one row per passed or waiting check; next to a failure, fold many rows into one."""
    if summary.first is None or len(outcomes) <= _MAX_SEPARATE_ROWS:
        return [_row(state, outcome.check.title) for outcome in outcomes]
    titles = _titles(outcome.check for outcome in outcomes)
    summary = f"<summary>{len(outcomes)} checks</summary>"
    return [_row(state, "", f"<details>{summary}{titles.removeprefix('<br>')}</details>")]


def _more_failures_text(outcomes: Sequence[Outcome]) -> str:
    return f"{len(outcomes)} more check{'s fail' if len(outcomes) > 1 else ' fails'}"


def _titles(checks: Iterable[Check]) -> str:
    return "".join(f"<br>{escape(check.title)}" for check in checks)


def _line(label: str, text: str) -> str:
    body = re.sub("`([^`]+)`", r"<code>\1</code>", escape(text))
    return "<br>" + (f"<i>{escape(label)}:</i> " if label else "") + body


def _row(state: str, title: str, body: str = "") -> str:
    colour, sign = _STATES[state]
    mark = (
        f"<span style='background:{colour};color:#fff;font-weight:bold;"
        f"white-space:nowrap;padding:0 0.5em;border-radius:3px'>{sign}</span>"
    )
    text = f"<b>{escape(title)}</b>{body}" if title else body.removeprefix("<br>")
    return (
        f"<tr><td style='width:7.5em;vertical-align:top;text-align:left'>{mark}</td>"
        f"<td style='text-align:left'>{text}</td></tr>"
    )


def _table(rows: list[str]) -> str:
    return (
        "<table role='table' aria-label='Checks' style='width:100%;max-width:60em'>"
        f"{''.join(rows)}</table>"
    )
