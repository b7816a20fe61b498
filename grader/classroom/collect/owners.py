"""Find the owner of a file in earlier answers, on the roster or in Moodle's worksheet."""

from __future__ import annotations

import functools
import re
import shlex
import unicodedata
from collections.abc import Collection, Sequence

from grader.classroom.collect.instructor_answers import (
    NO_OWNER,
    InstructorAnswers,
    ids_in,
    normalize_label,
)
from grader.classroom.collect.models import CollectError, Owner
from grader.classroom.collect.submission_table import SubmissionRow, SubmissionTable
from grader.classroom.collect.zips import names_in_other_code_pages
from grader.course.roster import Person, Roster, has_other_lms_id, letters_and_digits

MAX_NAME_LENGTH = 80
_TEAM_HINT = "For a team, write several ids: ID,ID"
# Windows does not allow folders with these names, with or without an extension.
_RESERVED_NAME = re.compile(r"(?:con|prn|aux|nul|com\d|lpt\d)(?:\..*)?", re.IGNORECASE)


class UnknownOwner(Exception):
    """The owner is unknown; the message is a question for the instructor."""


class OwnerFinder:
    """Finds the students who own the files of an archive.

    Parameters
    ----------
    roster : grader.course.roster.Roster or None
        Without a roster, folders are named as in the archive.
    worksheet : SubmissionTable
    answers : InstructorAnswers
    """

    def __init__(
        self, roster: Roster | None, worksheet: SubmissionTable, answers: InstructorAnswers
    ) -> None:
        self._roster = roster
        self._worksheet = worksheet
        self._answers = answers
        self._folders: dict[str, str] = {}

    def ids_of(self, owner: Owner) -> tuple[str, ...]:
        """Return the IDs of a student or of a team's members; empty if no student owns the files.

        Raises
        ------
        UnknownOwner
        """
        answer = self._answers.owners_of(owner.label)
        if answer is not None:
            return answer
        if self._roster is None:
            return (self._owner_folder(owner),)
        people = self._find_people(owner)
        if len(people) == 1:
            return (people[0].id,)
        if people:
            raise UnknownOwner(_choice(owner, people))
        team = self._team_members(owner)
        if team:
            return tuple(person.id for person in team)
        guessed = self._people_by_guess(owner)
        if guessed:
            raise UnknownOwner(f"{_choice(owner, guessed)}. {_TEAM_HINT}")
        raise UnknownOwner(self._question(owner))

    def is_answered(self, owner: Owner) -> bool:
        """Return whether an answer names the owner."""
        return self._answers.owners_of(owner.label) is not None

    def is_known(self, owner: Owner) -> bool:
        """Return whether an answer or the roster names the owner."""
        return self.is_answered(owner) or (self._roster is not None and self._names_students(owner))

    def owns_whole_archive(self, owner: Owner, others: Collection[Owner]) -> bool:
        """Return whether all folders in an archive belong to this owner.

        This requires an answer about the owner, and no folder may be named after a known student.
        Without a roster, the archive must have exactly one other folder.
        """
        if not self._answers.owners_of(owner.label):
            return False
        return not any(map(self._names_students, others)) if self._roster else len(others) == 1

    def _names_students(self, owner: Owner) -> bool:
        try:
            return bool(self.ids_of(owner))
        except UnknownOwner:
            return False

    def ambiguous_files_question(self, owner: Owner) -> str:
        """Return the question about files that may belong to several students."""
        question = (
            "Their names show that they may belong to several students. Put each student's files "
            "into a folder named after the student's id, and collect the folder that contains "
            "these folders"
        )
        if self._roster is None:
            option = _owner_option(owner, safe_folder(owner.folder))
            question += f". If one student submitted all of them, add {option} instead"
        return question

    def identity_question(self, owner: Owner, ids: Sequence[str], others: Sequence[Owner]) -> str:
        """Return a question if the identity of an owner is in doubt; otherwise an empty string.

        Canvas labels a group's work with the group's name and the user ID of the member who
        submitted.

        Parameters
        ----------
        owner : Owner
        ids : sequence of str
            The assumed owners.
        others : sequence of Owner
            The other owners in the same archive with the same IDs.
        """
        if self.is_answered(owner):
            return ""
        if others:
            names = ", ".join(other.label for other in others)
            return (
                f"This name and {names} seem to belong to {' and '.join(ids)}, so the grader did "
                f"not collect them. If they do, add {_owner_option(owner, ','.join(ids))}, and the "
                "same option for each other name"
            )
        person = self._roster.person(ids[0]) if self._roster and owner.lms_id else None
        if person is None or not owner.names:
            return ""
        team = sorted(set().union(*self._answers.teams_of(person.id)))
        if team:  # another member may have submitted the team's work this time
            return (
                f"You answered that {' and '.join(team)} are a team. If the team submitted this "
                f"together, add {_owner_option(owner, ','.join(team))}. Otherwise, add "
                f"{_owner_option(owner, person.id)}"
            )
        names = [letters_and_digits(name) for name in (person.first_name, person.last_name) if name]
        if not names or any(name in letters_and_digits(owner.names[0]) for name in names):
            return ""
        return (
            f"This submission has the number of {person.id}, but a different name. If a team "
            f"submitted it, add {_owner_option(owner, f'{person.id},ID')}. Otherwise, add "
            f"{_owner_option(owner, person.id)}"
        )

    def submission_rows(self, owner: Owner, id: str) -> Sequence[SubmissionRow]:
        """Return the rows in the worksheet that state when a student submitted an owner's files.

        For a team, these are the rows of the member named in the archive, or else the student's
        own rows, or else another member's.
        """
        members = self.ids_of(owner)
        named = [person.id for person in self._find_people(owner)] if self._roster else []
        submitter = named if len(named) == 1 and named[0] in members else []
        for member in (*submitter, id, *members):
            rows = self._rows_of(owner, member)
            if any(row.when or row.time_problem for row in rows):
                return rows
        return self._rows_of(owner, id)

    def _rows_of(self, owner: Owner, id: str) -> Sequence[SubmissionRow]:
        """Return a student's rows; empty if Moodle's worksheet has several."""
        person = self._roster.person(id) if self._roster else None
        row = self._worksheet.row_of_participant(owner.participant)
        if row and (person is None or person in self._people_of(row)):
            return [row]
        rows = self._rows_by_id.get(person.id, []) if person else self._worksheet.rows_with(id)
        return [] if self._worksheet.is_from_moodle and len(rows) > 1 else rows

    @functools.cached_property
    def _rows_by_id(self) -> dict[str, list[SubmissionRow]]:
        """Return the rows that match exactly one person, by the person's ID."""
        rows_by_id: dict[str, list[SubmissionRow]] = {}
        for row in self._worksheet.rows:
            people = self._people_of(row)
            if len(people) == 1:
                rows_by_id.setdefault(people[0].id, []).append(row)
        return rows_by_id

    def check_answers(self, answers: dict[str, str]) -> None:
        """Check the IDs in new answers, as typed.

        Raises
        ------
        CollectError
            If an answer names a student who is not on the roster.
        """
        for label, answer in answers.items():
            if "/" in label and ids_in(answer):
                raise CollectError(
                    f"--who {shlex.quote(label)}=…: a single file can only be ignored, not "
                    f"assigned. Write {NO_OWNER} instead of an id."
                )
            for id in ids_in(answer):
                self._check_answer(label, id)

    def _check_answer(self, label: str, id: str) -> None:
        suggestions = ""
        if self._roster and self._roster.person(id) is None:
            reason = "no student on the roster has the id"
            suggestions = " or ".join(person.id for person in self._roster.find_people(id))
        elif self._roster is None and safe_folder(id) != id:
            reason, suggestions = "no folder can have the name", safe_folder(id)
        else:
            return
        remedy = (
            f"Write {suggestions}." if suggestions else "Correct it, or add a line to roster.csv."
        )
        raise CollectError(f"--who {shlex.quote(label)}=…: {reason} {id}. {remedy}")

    def _find_people(self, owner: Owner) -> tuple[Person, ...]:
        people = self._roster.people
        if owner.lms_id:
            found = tuple(person for person in people if person.lms_id == owner.lms_id)
            if found:
                return found
        row = self._worksheet.row_of_participant(owner.participant)
        found = self._people_of(row) if row else ()
        found = found or self._people_by_login(owner.logins) or self._people_by_names(owner.names)
        return tuple(person for person in found if not has_other_lms_id(person, owner.lms_id))

    def _people_by_names(self, names: Collection[str]) -> tuple[Person, ...]:
        """Return the people who match every name that the roster knows.

        If no person matches all of these names, return everyone who matches one of them.
        """
        found = [set(people) for name in names if (people := self._people_by_name(name))]
        people = set.intersection(*found) or set.union(*found) if found else set()
        return tuple(sorted(people, key=self._roster.people.index))

    def _people_by_name(self, name: str) -> tuple[Person, ...]:
        people = self._roster.find_people(name)
        if people:
            return people
        names = names_in_other_code_pages(name)
        return tuple({person: None for name in names for person in self._roster.find_people(name)})

    def _people_by_guess(self, owner: Owner) -> tuple[Person, ...]:
        return (
            self._people_by_login(owner.guesses)
            or self._people_by_names(owner.guesses)
            or tuple(
                person
                for name in owner.names
                for person in self._roster.people_with_leading_zeros(name)
            )
        )

    def _people_by_login(self, logins: Collection[str]) -> tuple[Person, ...]:
        wanted = {login.casefold() for login in logins}
        return tuple(
            person for person in self._roster.people if person.github.casefold() in wanted - {""}
        )

    def _people_of(self, row: SubmissionRow) -> tuple[Person, ...]:
        for text in row.identifiers:
            people = self._roster.find_people(text)
            if people:
                return people
        return ()

    def _team_members(self, owner: Owner) -> list[Person]:
        """Return the members of a team that the archive or worksheet lists, if all are known."""
        if owner.members:
            matches = [self._people_by_names(names) for names in owner.members]
            return (
                [people[0] for people in matches]
                if all(len(people) == 1 for people in matches)
                else []
            )
        # Compare only letters, because archives replace some characters with spaces.
        names = {letters_and_digits(name) for name in owner.names}
        rows = [
            row
            for row in self._worksheet.rows
            if names & set(map(letters_and_digits, row.other_cells))
        ]
        members = [self._people_of(row) for row in rows]
        return (
            [matches[0] for matches in members]
            if all(len(matches) == 1 for matches in members)
            else []
        )

    def _question(self, owner: Owner) -> str:
        if owner.label.startswith("anon_"):
            return (
                "Student names are hidden in this download. Show them in Canvas and download "
                "again, or add "
                f"{_owner_option(owner, 'ID')}"
            )
        remedy = ""
        if owner.lms_id and (
            others := [person for name in owner.names for person in self._roster.find_people(name)]
        ):
            numbers = " or ".join(f"{person.lms_id} ({person.id})" for person in others)
            return (
                f"The roster lists this name with the number {numbers}, not {owner.lms_id}. "
                f"Correct the roster, or add {_owner_option(owner, others[0].id)} (or another id)"
            )
        if owner.lms_id:
            remedy = (
                f"write {owner.lms_id} into column lms_id of the student's line in roster.csv, or "
            )
        elif owner.logins or owner.guesses:
            remedy = "write the login into column github of the student's line in roster.csv, or "
        elif owner.participant and not self._worksheet.rows:
            remedy = "add Moodle's worksheet with --timestamps FILE, or "
        return (
            f"No student on the roster has this name. To assign the files, {remedy}add "
            f"{_owner_option(owner, 'ID')}. {_TEAM_HINT}. To ignore "
            f"the files, add {_owner_option(owner, NO_OWNER)}"
        )

    def _owner_folder(self, owner: Owner) -> str:
        name = safe_folder(owner.folder)
        before = self._folders.setdefault(normalize_label(name), owner.folder)
        if before != owner.folder:
            raise UnknownOwner(
                f"The folder would have the same name as the one for {before}. Add "
                f"{_owner_option(owner, 'ID')}"
            )
        return name


def safe_folder(name: str) -> str:
    """Return the given name, changed where necessary to be a valid folder name on every system."""
    text = unicodedata.normalize("NFC", name)
    text = "".join(c if c.isalnum() or c in " _-.@+()" else "-" for c in text)
    text = " ".join(text.split())[:MAX_NAME_LENGTH].strip(" .-").lstrip("_") or "unnamed"
    return f"{text}_" if _RESERVED_NAME.fullmatch(text) else text


def _choice(owner: Owner, people: Sequence[Person]) -> str:
    ids = " or ".join(person.id for person in people)
    return (
        f"The student may be {ids}. Add {_owner_option(owner, people[0].id)}, or the same option "
        "with another id"
    )


def _owner_option(owner: Owner, ids: str) -> str:
    return f"--who {shlex.quote(f'{owner.label}={ids}')}"
