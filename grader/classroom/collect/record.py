"""What was collected into a student's folder, and from where; and who is late without a time.

It is kept beside the work, as ``.collected.json``, so that it goes when the student's folder does.
"""

from __future__ import annotations

import contextlib
import dataclasses
import json
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path

from grader.course.atomic_files import write_atomically

NAME = ".collected.json"


@dataclass(frozen=True)
class FileOrigin:
    """Where a file came from.

    Attributes
    ----------
    digest : str
        SHA-256 of what was placed.
    archive : str
        Name of the archive, and of the file in it.
    moment : str
        What the archive has for its time, in ISO 8601.
    order : int
        Higher is newer, in every archive of this kind; 0 where nothing is known.
    late : bool
        That the learning platform marked it so.
    participant : str
        Moodle's number of whose it is, a person or a team.
    beaten : tuple of str
        SHA-256 of other files for the same, which somebody said do not count.
    when : str
        When it was handed in, in ISO 8601; empty where that is not known.
    undecided : str
        Why nobody knows when; empty where somebody does, or was not asked.
    """

    digest: str
    archive: str
    moment: str
    order: int = 0
    late: bool = False
    participant: str = ""
    beaten: tuple[str, ...] = ()
    when: str = ""
    undecided: str = ""

    def newer_than(self, other: FileOrigin) -> bool | None:
        """Whether it was handed in after another; None where nothing tells."""
        mine, others = (self.order, self.moment), (other.order, other.moment)
        if not (self.order and other.order):
            mine, others = mine[1:], others[1:]
        return None if mine == others else mine > others


@dataclass(frozen=True)
class Record:
    """What was collected into one folder.

    Attributes
    ----------
    files : dict of str to FileOrigin
        By the name under which each lies there.
    undecided : str
        Why nobody knows when the work was handed in; empty where somebody does, or was not asked.
    others : str
        When what was not collected was handed in, in ISO 8601, where a ``timestamp.txt`` said so.
    written : str
        What collecting wrote last into ``timestamp.txt``, in ISO 8601: another time is a person's.
    """

    files: dict[str, FileOrigin] = field(default_factory=dict)
    undecided: str = ""
    others: str = ""
    written: str = ""

    def time(self, folder: Path) -> tuple[datetime | None, str]:
        """When all that lies in the folder was handed in; and why that is not known."""
        lying = {name: one for name, one in self.files.items() if (folder / name).is_file()}
        for one in lying.values():
            if one.undecided:
                return None, one.undecided
        said = [when for when in (self.others, *(one.when for one in lying.values())) if when]
        without = [name for name, one in lying.items() if not one.when]
        if said and without:
            return None, f"no time is known of {min(without)}"
        return max(map(datetime.fromisoformat, said), default=None), ""


def read_record(folder: Path) -> Record:
    """What was collected into a folder; nothing where that is not known."""
    with contextlib.suppress(OSError, ValueError, TypeError, KeyError, AttributeError):
        content = json.loads((folder / NAME).read_text("utf-8"))
        files = {name: FileOrigin(**source) for name, source in content["files"].items()}
        return Record(**(content | {"files": files}))
    return Record()


def write_record(record: Record, folder: Path) -> None:
    """Keep what was collected into a folder."""
    write_atomically(json.dumps(dataclasses.asdict(record), indent=1), folder / NAME)


def why_untimed(folder: Path) -> str:
    """Why nobody knows when what was collected into a folder was handed in.

    Empty where a ``timestamp.txt`` says it, and where the learning platform had nothing against it
    and no table of times was given.
    """
    if (folder / "timestamp.txt").is_file():
        return ""
    record = read_record(folder)
    late = any(source.late and (folder / name).is_file() for name, source in record.files.items())
    marked = "the learning platform marks it late, and gives no time"
    return record.undecided or (marked if late else "")
