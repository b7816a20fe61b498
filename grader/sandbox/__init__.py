"""Run student code in a sandbox and call its functions.

`boundary` lists what student code can see. `SANDBOXES` lists the ways to run it. To add another
one, write a class with the methods of `protocol.Sandbox`, whose workers have the methods of
`protocol.Worker`, and add it to `SANDBOXES`.
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
    """Return the requested sandbox, after checking that it works here.

    Parameters
    ----------
    wish : str
        A name in `SANDBOXES`, or "auto" for the one without a warning. There is no fallback to
        another one.

    Raises
    ------
    SandboxUnavailable
        If it cannot be built here; the message names the remedy.
    """
    if wish == AUTO:
        wish = next(name for name, sandbox in SANDBOXES.items() if not sandbox.warning)
    SANDBOXES[wish].available()
    return SANDBOXES[wish]
