"""Run student code in a sandbox and call its functions.

`boundary` lists the files that student code can see. `SANDBOXES` lists the sandboxes. To add
another one, write a class with the methods of `protocol.Sandbox` and add an instance to
`SANDBOXES`. Its `start` must return an object with the methods of `protocol.Worker`.
"""

from grader.sandbox.bubblewrap import Bubblewrap
from grader.sandbox.chroot import Chroot
from grader.sandbox.plain_process import PlainProcess
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
    sandbox.name: sandbox for sandbox in (Bubblewrap(), Chroot(), PlainProcess())
}


def choose_sandbox(name: str = AUTO) -> Sandbox:
    """Return the requested sandbox, after checking that it works on this machine.

    Parameters
    ----------
    name : str
        A name in `SANDBOXES`, or "auto" for the first sandbox without a warning. If that sandbox
        does not work, the others are not tried.

    Raises
    ------
    SandboxUnavailable
        If the sandbox cannot be built. The message says how to fix that.
    """
    if name == AUTO:
        name = next(name for name, sandbox in SANDBOXES.items() if not sandbox.warning)
    SANDBOXES[name].check_available()
    return SANDBOXES[name]
