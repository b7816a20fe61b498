"""Decide whether a time in the table of submission times replaces an earlier time."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from datetime import datetime

from grader.classroom.collect.record import FileOrigin
from grader.classroom.timestamp_file import format_timestamp
from grader.course.times import quote_beginning


@dataclass(frozen=True)
class StatedTime:
    """The submission time of a student's files in the table of submission times.

    Attributes
    ----------
    when : datetime or None
        In UTC.
    text : str
        The time as written in the table.
    undecided : str
        Why the time is unknown; empty if it is known or no table was given.
    """

    when: datetime | None = None
    text: str = ""
    undecided: str = ""

    def corrects(self, known: FileOrigin) -> bool:
        """Return whether this time replaces the known time of an unchanged file.

        An earlier time replaces it, because the same work already existed then. The same text in
        another time zone also replaces it. A later time may belong to another attempt. A time that
        a person entered is never replaced.
        """
        if not (known.when_text and self.when):
            return False
        return self.text == known.when_text or self.when < datetime.fromisoformat(known.when)

    def apply_to(self, origin: FileOrigin, reason: str) -> FileOrigin:
        """Return an origin with this time or, without one, with the reason why it is unknown."""
        if not self.when:
            return dataclasses.replace(origin, when="", when_text="", undecided=reason)
        return dataclasses.replace(
            origin, when=self.when.isoformat(), when_text=self.text, undecided=""
        )

    def remark(
        self, earlier_time: datetime | None, current_time: datetime, file: str, is_by_hand: bool
    ) -> str:
        """Explain which submission time counts for files that have not changed.

        Parameters
        ----------
        earlier_time, current_time : datetime
            The times in ``timestamp.txt`` before and after collecting.
        file : str
            Path of ``timestamp.txt``.
        is_by_hand : bool
            Whether a person wrote the time there.

        Returns
        -------
        str
            A sentence without a full stop; empty if the times agree.
        """
        shown_time = format_timestamp(current_time)
        if not self.when:
            reason = self.undecided[:1].upper() + self.undecided[1:]
            return f"{reason}, so the earlier time, {shown_time}, still counts" if self.text else ""
        if earlier_time and format_timestamp(earlier_time) != shown_time:
            return (
                f"The submission time was {format_timestamp(earlier_time)} and is now "
                f"{shown_time}, because the table of submission times has "
                f"{quote_beginning(self.text)}"
            )
        stated_time = format_timestamp(self.when)
        if shown_time == stated_time or (self.when < current_time and not is_by_hand):
            return ""
        return (
            f"The table of submission times has {quote_beginning(self.text)}, but {file} has "
            f"{shown_time} for the same files. The time in {file} counts. To change it, write "
            f"{stated_time} there"
        )


NOTHING_STATED = StatedTime()
