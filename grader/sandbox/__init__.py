"""Where a student's code runs, and how the judge talks to it.

`boundary` says what that code can see. `SANDBOXES` lists the ways to run it; another one is a
module with a class that has the methods of `protocol.Sandbox`, whose workers have those of
`protocol.Worker`, and a line in the table.
"""

from grader.sandbox.bubblewrap import Bubblewrap
from grader.sandbox.chroot import Chroot
from grader.sandbox.plain_process import Unwalled
from grader.sandbox.protocol import Limits, Sandbox, SandboxUnavailable, Worker

__all__ = [
    "AUTO",
    "SANDBOXES",
    "Limits",
    "Sandbox",
    "SandboxUnavailable",
    "Worker",
    "choose_sandbox",
]

AUTO = "auto"
SANDBOXES: dict[str, Sandbox] = {
    sandbox.name: sandbox for sandbox in (Bubblewrap(), Chroot(), Unwalled())
}


def choose_sandbox(wish: str = AUTO) -> Sandbox:
    """Find the sandbox that was asked for.

    Parameters
    ----------
    wish : str
        A name in `SANDBOXES`, or "auto": the one without a warning. No other is ever fallen back
        to.

    Raises
    ------
    SandboxUnavailable
        With the command that would mend it.
    """
    if wish == AUTO:
        wish = next(name for name, sandbox in SANDBOXES.items() if not sandbox.warning)
    SANDBOXES[wish].available()
    return SANDBOXES[wish]
