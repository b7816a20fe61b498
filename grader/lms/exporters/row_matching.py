"""Match the rows in an LMS file with students.

A mark in the wrong row is worse than a mark that is omitted and reported. A row is therefore
assigned to a student only if it identifies exactly one student, and no other row identifies that
student. A row may have one student's key but another student's name. The row then identifies both,
and is not assigned.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

from grader.course.roster import Person, Roster, has_other_lms_id, normalized_text

Claim = tuple[str, str]  # (attribute of a person, text in the row)


@dataclass(frozen=True)
class PersonRow:
    """The data that identifies the owner of a row.

    Attributes
    ----------
    label : str
        Name of the row in messages.
    claims : tuple of tuple of (str, str)
        Pairs of a person's attribute and the row's text for it, by rank. Claims of the first rank
        are the most reliable. Claims of lower ranks count only if the name matches.
    name : str
        Name of the owner, which is used alone if no claim matches; empty if the file hides it.
    lms_id : str
        The person's ID in the LMS, if all files from that LMS contain one. A student with another
        ID on the roster is only a namesake.
    """

    label: str
    claims: tuple[tuple[Claim, ...], ...]
    name: str
    lms_id: str = ""


@dataclass(frozen=True)
class RowMatches:
    """The result of matching rows with students.

    Attributes
    ----------
    rows : dict of str to int
        Index of the row by student ID.
    unknown_rows : tuple of str
        Labels of the rows without a matching student.
    doubts : dict of str to str
        Reason why a student has no row although some rows may match, by student ID.
    by_name : tuple of str
        Labels of the rows that were matched only by name.
    renamed : tuple of str
        Rows whose name differs from the name on the roster.
    """

    rows: dict[str, int]
    unknown_rows: tuple[str, ...]
    doubts: dict[str, str]
    by_name: tuple[str, ...]
    renamed: tuple[str, ...]


def match_rows(rows: Sequence[PersonRow], people: Sequence[Person]) -> RowMatches:
    """Find the row of each student."""
    matched: dict[str, int] = {}
    doubts: dict[str, str] = {}
    settled: set[int] = set()
    by_name: list[int] = []
    for ids_in in _passes(rows, people):
        candidates = {
            index: ids
            for index in range(len(rows))
            if index not in settled and (ids := ids_in(index))
        }
        rows_of: dict[str, list[int]] = {}
        for index, ids in candidates.items():
            for id in ids:
                rows_of.setdefault(id, []).append(index)
        by_name = []
        for index, ids in candidates.items():
            rivals = sorted({rival for id in ids for rival in rows_of[id]})
            if len(ids) > 1 or len(rivals) > 1:
                labels = _join_with_or(rows[rival].label for rival in rivals)
                reason = f"{labels} may be {_join_with_or(sorted(ids))}"
                doubts |= dict.fromkeys(ids - matched.keys(), reason)
                settled.add(index)
            elif not ids & (matched.keys() | doubts.keys()):
                matched[min(ids)] = index
                settled.add(index)
                by_name.append(index)
    for index, row in enumerate(rows):
        for person in _namesakes(row, people) if index not in settled else ():
            if person.id not in matched:
                reason = f"{row.label} has the number {row.lms_id} instead of {person.lms_id}"
                doubts.setdefault(person.id, reason)
    unknown_rows = tuple(row.label for index, row in enumerate(rows) if index not in settled)
    renamed = tuple(
        f"{rows[matched[person.id]].label} for {person.display_name}"
        for person in people
        if person.id in matched and not _name_may_match(rows[matched[person.id]].name, person)
    )
    by_name = [rows[index].label for index in by_name]
    return RowMatches(matched, unknown_rows, doubts, tuple(by_name), renamed)


def _passes(
    rows: Sequence[PersonRow], people: Sequence[Person]
) -> Iterator[Callable[[int], set[str]]]:
    """Yield functions that map a row's index to matching IDs: one per rank, then one for names."""
    roster = Roster(tuple(people))
    owners: dict[Claim, set[str]] = {}
    for person in people:
        for attribute in ("id", "email", "lms_id"):
            text = normalized_text(getattr(person, attribute))
            if text:
                owners.setdefault((attribute, text), set()).add(person.id)

    def ids_with_key(index: int, rank: int) -> set[str]:
        return {
            id
            for attribute, text in rows[index].claims[rank]
            for id in owners.get((attribute, normalized_text(text)), ())
            if rank == 0 or _name_may_match(rows[index].name, roster.person(id))
        }

    def ids_without_contradiction(index: int) -> set[str]:
        row, ids = rows[index], ids_with_key(index, 0)
        named = {person.id for person in roster.find_people(row.name)}
        if not ids or ids & named:
            return ids
        return ids.union(named, *(ids_with_key(index, rank) for rank in range(1, len(row.claims))))

    yield ids_without_contradiction
    for rank in range(1, max((len(row.claims) for row in rows), default=0)):
        yield lambda index, rank=rank: ids_with_key(index, rank)
    yield lambda index: {
        person.id
        for person in roster.find_people(rows[index].name)
        if not has_other_lms_id(person, rows[index].lms_id)
    }


def _namesakes(row: PersonRow, people: Sequence[Person]) -> Iterator[Person]:
    """Yield the students whose name matches the row but whose number differs."""
    for person in Roster(tuple(people)).find_people(row.name):
        if has_other_lms_id(person, row.lms_id):
            yield person


def _name_may_match(name: str, person: Person) -> bool:
    """Return whether a person may have a name; a person without a stored name may have any."""
    return not name or person.name == person.id or bool(Roster((person,)).find_people(name))


def _join_with_or(words: Iterable[str]) -> str:
    return " or ".join(words)
