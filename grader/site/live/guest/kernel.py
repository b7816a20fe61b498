"""The kernel of a lesson in the browser: run cells with IPython, and send outputs to the page.

Each output is one line of JSON, written to the file descriptor that the page opened.
"""

import json
import os
import sys
import types

# The guest's files have no permissions, which Python would report as "not writable".
os.access = lambda path, *_, **__: os.path.exists(path)
for absent in ("pexpect", "psutil"):  # IPython imports these modules only to run system commands
    sys.modules.setdefault(absent, types.ModuleType(absent))

from IPython.core.displayhook import DisplayHook  # noqa: E402
from IPython.core.displaypub import DisplayPublisher  # noqa: E402
from IPython.core.interactiveshell import InteractiveShell  # noqa: E402
from traitlets.config import Config  # noqa: E402

CHANNEL = int(os.environ["CHANNEL"])
SHOWN_TYPES = ("text/html", "image/png", "image/gif", "text/plain")
"""MIME types that the page shows, best first."""


def send(kind: str, **content: object) -> None:
    """Send a message to the page."""
    data = (json.dumps({"kind": kind, **content}) + "\n").encode()
    while data:
        data = data[os.write(CHANNEL, data) :]


def best_representation(data: dict) -> dict:
    """Return the first representation of an output that is in `SHOWN_TYPES`, if any."""
    kind = next((kind for kind in SHOWN_TYPES if kind in data), None)
    return {"type": kind, "data": data[kind]} if kind else {}


class Stream:
    """Standard output or standard error of the cells."""

    encoding, errors = "utf-8", "replace"

    def __init__(self, name: str) -> None:
        self.name = name

    def write(self, text: str) -> int:
        """Send text to the page."""
        if text:
            send("stream", name=self.name, text=str(text))
        return len(text)

    def flush(self) -> None:
        """Do nothing, because each text is sent at once."""

    def isatty(self) -> bool:
        """Return False, because the page does not understand colours of terminals."""
        return False


class Publisher(DisplayPublisher):
    """Sends displayed objects to the page."""

    def publish(
        self,
        data: dict,
        metadata: dict | None = None,
        *,
        transient: dict | None = None,
        update: bool = False,
        **_: object,
    ) -> None:
        """Send the best representation of an object."""
        if shown := best_representation(data):
            send("display", id=(transient or {}).get("display_id"), update=update, **shown)

    def clear_output(self, wait: bool = False) -> None:
        """Remove the outputs of the cell from the page."""
        send("clear")


class ResultPublisher(DisplayHook):
    """Sends the value of a cell's last line to the page."""

    def write_output_prompt(self) -> None:
        """Do nothing, because the page shows outputs without a prompt."""

    def write_format_data(self, format_dict: dict, md_dict: dict | None = None) -> None:
        """Send the best representation of the value."""
        if shown := best_representation(format_dict):
            send("display", id=None, update=False, **shown)

    def finish_displayhook(self) -> None:
        """Do nothing, because the page separates outputs without an empty line."""


class Shell(InteractiveShell):
    """An interactive shell that counts as a notebook's kernel."""

    kernel = True
    colors = "nocolor"

    def _showtraceback(self, etype: type, evalue: BaseException, stb: list[str]) -> None:
        send("error", name=etype.__name__, text="\n".join(stb))


def start() -> Shell:
    """Start the shell, and connect its outputs with the page."""
    settings = Config()
    settings.HistoryManager.enabled = False  # a history would be a file
    sys.stdout, sys.stderr = Stream("stdout"), Stream("stderr")
    return Shell.instance(
        config=settings, display_pub_class=Publisher, displayhook_class=ResultPublisher
    )


def run(source: str, quietly: bool = False) -> None:
    """Run a cell; with `quietly`, send only text, so that no figure is drawn."""
    shell.display_formatter.active_types = ["text/plain"] if quietly else ALL_TYPES
    send("done", ok=bool(shell.run_cell(source, store_history=True).success))


shell = start()
ALL_TYPES = shell.display_formatter.active_types
