"""Collect submissions from nbgrader's exchange without trusting the folders there.

Students own the folders that they submit, so they control the content: links, pipes, endless files
and the submission time.
"""

from __future__ import annotations

import contextlib
import errno
import os
import pwd
import shutil
import stat
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import BinaryIO

from nbgrader.exchange.default import ExchangeCollect
from nbgrader.utils import parse_utc

from grader.classroom.collect.zips import MAX_BYTES_PER_STUDENT
from grader.course.times import UnclearTime, read_time, to_utc
from grader.intake.submission import is_skipped_folder
from grader.untrusted_text import one_line

# Maximum number of files and folders to examine in one submission, from the top folder down.
MAX_ENTRIES = 200
# `nbgrader submit` writes the time, then copies the files, which takes only seconds.
MAX_SUBMISSION_TIME = timedelta(minutes=10)
_NO_LINK = os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK


class CannotCollect(Exception):
    """A submission cannot be collected; the message continues a sentence about its folder."""


def owner_of(status: os.stat_result) -> str:
    """Return the name of the account that owns a file or folder."""
    try:
        return pwd.getpwuid(status.st_uid).pw_name
    except KeyError:
        return f"user {status.st_uid}"


class CollectOrdinaryFiles(ExchangeCollect):
    """Collects from the exchange only ordinary files that belong to the student.

    The modules next to a notebook are collected as well. If one submission cannot be collected, the
    student's earlier submission stays in place, and the other students' submissions are still
    collected.
    """

    def _path_to_record(self, path: str) -> dict:
        """Return the student and the time in a folder's name; a name without a time sorts last."""
        name = os.path.basename(path)
        student, *rest = name.rsplit("+", 3)
        text = rest[1] if len(rest) > 1 else ""
        try:
            # Read the time as `grade` does, because nbgrader ignores a time zone such as NZ.
            stated = read_time(text)
            time = to_utc(stated, UTC).replace(tzinfo=None)
            # Without a zone, the text stays as it is, because `grade` warns about such times.
            text = f"{time:%Y-%m-%d %H:%M:%S.%f} UTC" if stated.tzinfo else text
        except UnclearTime:  # `grade` asks for the time
            try:
                time = parse_utc(text)
            except (ValueError, OverflowError):
                time = datetime.min
        return {"username": student, "filename": name, "timestamp": time, "time_text": text}

    def _sort_by_timestamp(self, records: list[dict]) -> list[dict]:
        """Sort a student's folders, newest first, without folders of another account.

        nbgrader collects only the first folder, and any account can create a folder in a student's
        name. If all folders are forged, they are kept, and `copy_files` refuses the first one.
        """
        if not self.check_owner:
            return super()._sort_by_timestamp(records)
        own = [record for record in records if self._belongs_to_student(record)]
        for record in records if own else ():
            if record not in own:
                self.log.warning(
                    "Not collected: %s is not a folder of %s's account.",
                    one_line(record["filename"]),
                    one_line(record["username"]),
                )
        return super()._sort_by_timestamp(own or records)

    def _belongs_to_student(self, record: dict) -> bool:
        try:
            status = os.lstat(Path(self.inbound_path, record["filename"]))
        except OSError:
            return False
        return stat.S_ISDIR(status.st_mode) and owner_of(status) == record["username"]

    def copy_files(self) -> None:
        """Copy the newest submission of each student; see nbgrader."""
        stage = self.coursedir.assignment_id
        if not self.src_records:
            self.log.warning("No submissions of '%s' to collect", stage)
        for record in self.src_records:
            student = record["username"]
            try:
                self._collect(student, record)
            except (CannotCollect, OSError) as reason:
                self.log.warning(
                    "Not collected: %s %s", one_line(record["filename"]), one_line(str(reason))
                )

    def _collect(self, student: str, record: dict) -> None:
        stage, time = self.coursedir.assignment_id, record["timestamp"]
        if not student or not student.isprintable():
            raise CannotCollect("has a name that does not begin with a student's name.")
        if time == datetime.min:
            raise CannotCollect("has a name without the time that `nbgrader submit` adds.")
        folder = Path(
            self.coursedir.format_path(self.coursedir.submitted_directory, student, stage)
        )
        if folder.is_dir():
            before = self.coursedir.get_existing_timestamp(str(folder))
            is_newer = self.update and (before is None or time > before)
            if not is_newer and not (self.before_duedate and before != time):
                self.log.info("No newer submission to collect: %s %s", student, stage)
                return
        files, changed = self._read(Path(self.inbound_path, record["filename"]), student)
        self._compare_times(record, changed)
        # Write the time again, because the student's own file may be missing or different.
        files["timestamp.txt"] = record["time_text"].encode()
        partial = folder.with_name(f".{stage}.partial")
        shutil.rmtree(partial, ignore_errors=True)
        for name, data in files.items():
            path = partial / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)
        if folder.is_dir():
            shutil.rmtree(folder)
        partial.rename(folder)
        self.log.info("Collected: %s %s", student, stage)

    def _read(self, folder: Path, student: str) -> tuple[dict[str, bytes], datetime]:
        """Return the files of a submission by relative path, and the time of its latest change."""
        files: dict[str, bytes] = {}
        entries, bytes_left = 0, MAX_BYTES_PER_STUDENT
        root_descriptor = os.open(folder, _NO_LINK | os.O_DIRECTORY)
        try:
            latest = self._examine(os.fstat(root_descriptor), student, "the folder")
            for place, folders, names, folder_descriptor in os.fwalk(".", dir_fd=root_descriptor):
                # Hidden files include the record of `collect`, which a student could forge.
                folders[:] = sorted(name for name in folders if not is_skipped_folder(name))
                names = [name for name in names if not name.startswith(".")]
                entries += 1 + len(names)
                if entries > MAX_ENTRIES:
                    self._leave_out(f"{folder.name}/{place}", "has too many files or folders")
                    break
                for name in sorted(names):
                    path = os.path.normpath(os.path.join(place, name))
                    with self._opened(
                        name, folder_descriptor, f"{folder.name}/{path}", bytes_left
                    ) as file:
                        if file is not None:
                            status = os.fstat(file.fileno())
                            latest = max(latest, self._examine(status, student, path))
                            files[path] = file.read(bytes_left)
                            bytes_left -= len(files[path])
        finally:
            os.close(root_descriptor)
        if not files:
            raise CannotCollect("contains no file that can be collected.")
        return files, datetime.fromtimestamp(latest, UTC).replace(tzinfo=None)

    @contextlib.contextmanager
    def _opened(
        self, name: str, folder: int, shown_path: str, max_bytes: int
    ) -> Iterator[BinaryIO | None]:
        """Open an ordinary file of at most `max_bytes` bytes; yield None for any other file."""
        try:
            descriptor = os.open(name, _NO_LINK, dir_fd=folder)
        except OSError as error:
            reason = "is a link" if error.errno == errno.ELOOP else f"cannot be read: {error}"
            self._leave_out(shown_path, reason)
            yield None
            return
        with open(descriptor, "rb") as file:
            status = os.fstat(descriptor)
            if not stat.S_ISREG(status.st_mode):
                self._leave_out(shown_path, "is not an ordinary file")
                yield None
            elif status.st_size > max_bytes:
                self._leave_out(shown_path, f"is larger than the remaining {max_bytes // 2**20} MB")
                yield None
            else:
                yield file

    def _leave_out(self, shown_path: str, reason: str) -> None:
        self.log.warning("Left out: %s %s", one_line(shown_path), one_line(reason))

    def _examine(self, status: os.stat_result, student: str, description: str) -> float:
        """Return when a file or folder was last changed; raise if another account owns it."""
        if self.check_owner:
            owner = owner_of(status)
            if owner != student:
                raise CannotCollect(
                    f"claims to be from {student}, but {description} belongs to {owner}. If "
                    "accounts and students have different names, set "
                    "`c.ExchangeCollect.check_owner = False`."
                )
        return status.st_ctime

    def _compare_times(self, record: dict, changed: datetime) -> None:
        """Report a folder that was changed long after the time in its name, which can be forged."""
        claimed = record["timestamp"]
        if changed - claimed > MAX_SUBMISSION_TIME:
            self.log.warning(
                "%s: the time in the name is %s, but the folder was changed at %s (UTC). Decide "
                "which time counts.",
                one_line(record["filename"]),
                f"{claimed:%Y-%m-%d %H:%M}",
                f"{changed:%Y-%m-%d %H:%M}",
            )
