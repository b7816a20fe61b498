"""What a student handed in for a lesson, read once: what is judged is what was fingerprinted."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from pathlib import Path

from grader.intake.notebook import read_file
from utils.notebooks.reading import Notebook, UnreadableNotebook, decode_notebook

MOST_MODULES = 20
LARGEST_MODULE = 2**20


@dataclass(frozen=True)
class HandedIn:
    """A notebook and the modules beside it.

    Attributes
    ----------
    name : str
        Of the file.
    data : bytes
        Its content; empty where it could not be read.
    complaint : str
        Why it could not be read.
    modules : dict of str to str
        Source of each ``.py`` file beside it, by the name it is imported under.
    notes : tuple of str
        What was noticed about the file itself, one sentence each.
    """

    name: str
    data: bytes
    complaint: str = ""
    modules: dict[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def notebook(self) -> Notebook:
        """The code in it.

        Raises
        ------
        utils.notebooks.reading.UnreadableNotebook
        """
        if self.complaint:
            raise UnreadableNotebook(self.complaint)
        return decode_notebook(self.data, self.name)

    def fingerprint(self) -> str:
        """A digest of all that was handed in.

        Before each part stands its length, so that none can be taken for a piece of another.
        """
        modules = [text for module in sorted(self.modules.items()) for text in module]
        texts = (self.name, self.complaint, *self.notes, *modules)
        # The name of a file may hold what is no text.
        parts = (self.data, *(text.encode(errors="surrogatepass") for text in texts))
        digest = hashlib.sha256(b"%d notes, %d modules: " % (len(self.notes), len(self.modules)))
        for part in parts:
            digest.update(b"%d " % len(part))
            digest.update(part)
        return digest.hexdigest()


def read_handed_in(path: Path) -> HandedIn:
    """Read a notebook, and the modules in its folder; never fails."""
    try:
        data, complaint = read_file(path), ""
    except UnreadableNotebook as error:
        data, complaint = b"", str(error)
    return HandedIn(path.name, data, complaint, _modules_beside(path))


def _modules_beside(path: Path) -> dict[str, str]:
    modules = {}
    for file in sorted(path.parent.glob("*.py"))[:MOST_MODULES]:
        if not file.stem.isidentifier():
            continue  # nobody can import it
        try:
            source = read_file(file)
        except UnreadableNotebook:
            continue
        if len(source) <= LARGEST_MODULE:
            modules[file.stem] = source.decode("utf-8", "replace")
    return modules
