"""Show the outcome of checks: a table in a notebook, plain text elsewhere."""

from collections.abc import Iterator
from html import escape

from utils.checks.core import Outcome

# White on these holds 4.5:1 whatever the page behind; the word says the same as the colour.
_PASSED, _FAILED = "#1a7f4b", "#c4420b"


def show(outcomes: list[Outcome]) -> None:
    """Display outcomes, and the pictures of what failed.

    Parameters
    ----------
    outcomes : list of utils.checks.core.Outcome
    """
    try:
        from IPython import get_ipython
        from IPython.display import display

        in_notebook = get_ipython() is not None
    except ImportError:
        in_notebook = False
    if not in_notebook:
        print(as_text(outcomes))
        return
    display({"text/html": as_html(outcomes), "text/plain": as_text(outcomes)}, raw=True)
    # One picture is a help, five are a wall.
    drawn = next(
        (outcome.failure.draw for outcome in outcomes if outcome.failure and outcome.failure.draw),
        None,
    )
    if drawn:
        import matplotlib.pyplot as plt

        drawn()
        plt.show()


def as_text(outcomes: list[Outcome]) -> str:
    """Outcomes as plain text.

    Parameters
    ----------
    outcomes : list of utils.checks.core.Outcome

    Returns
    -------
    str
    """
    lines = []
    for outcome in outcomes:
        failure = outcome.failure
        lines.append(f"[{'failed' if failure else 'passed'}] {outcome.check.title}")
        if failure:
            lines += [f"    {label}: {text}" for label, text in _details(outcome)]
    return "\n".join(lines)


def as_html(outcomes: list[Outcome]) -> str:
    """Outcomes as an HTML table.

    Parameters
    ----------
    outcomes : list of utils.checks.core.Outcome

    Returns
    -------
    str
    """
    rows = []
    for outcome in outcomes:
        good = outcome.failure is None
        mark = (
            f"<span style='background:{_PASSED if good else _FAILED};color:#fff;"
            "font-weight:bold;white-space:nowrap;padding:0 0.5em;border-radius:3px'>"
            f"{'✓ passed' if good else '✗ failed'}</span>"
        )
        body = f"<b>{escape(outcome.check.title)}</b>"
        body += "".join(
            f"<br><i>{escape(label)}:</i> {escape(text)}"
            for label, text in ([] if good else _details(outcome))
        )
        rows.append(
            f"<tr><td style='width:6em;vertical-align:top;text-align:left'>"
            f"{mark}</td>"
            f"<td style='text-align:left'>{body}</td></tr>"
        )
    return (
        "<table role='table' aria-label='Checks' style='width:100%;max-width:60em'>"
        f"{''.join(rows)}</table>"
    )


def _details(outcome: Outcome) -> Iterator[tuple[str, str]]:
    """What there is to say about a failure, each as (label, text)."""
    failure = outcome.failure
    yield "What happened", failure.message
    if failure.tip:
        yield "In plain words", failure.tip
    if failure.yours is not None:
        yield "Yours", failure.yours
    if failure.expected is not None:
        yield "Expected", failure.expected
    yield "Why it matters", outcome.check.why
    yield "Hint", outcome.check.hint
