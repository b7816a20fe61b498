"""Whose row it is in a file of the learning platform.

A mark in another's row is worse than one that is asked about. So a row is somebody's only where
what it says names one person, and no other row names the same.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

from grader.course.roster import Person, Roster, folded, has_another_number

Claim = tuple[str, str]  # (attribute of a person, text of the row)


@dataclass(frozen=True)
class PersonRow:
    """What a row says about whose it is.

    Attributes
    ----------
    label : str
        What sentences call it.
    claims : tuple of tuple of (str, str)
        Attributes of a person with what the row has for them, by rank. Those of the first rank are
        sure; a number of a lower one may be anybody's, and counts where the name agrees.
    name : str
        It counts alone where nothing else names anybody; empty where the file hides it.
    lms_id : str
        The platform's number of a person, where it has one that every file has: who has another on
        the roster only bears the same name.
    """

    label: str
    claims: tuple[tuple[Claim, ...], ...]
    name: str
    lms_id: str = ""


@dataclass(frozen=True)
class Joined:
    """Rows and people.

    Attributes
    ----------
    rows : dict of str to int
        Place of the row, by id of the person.
    strangers : tuple of str
        Labels of the rows that are nobody's.
    doubts : dict of str to str
        Why a person has no row although some may be theirs, by id.
    by_name : tuple of str
        Labels of the rows that only their name gave to somebody.
    renamed : tuple of str
        Rows with another name than the roster has.
    """

    rows: dict[str, int]
    strangers: tuple[str, ...]
    doubts: dict[str, str]
    by_name: tuple[str, ...]
    renamed: tuple[str, ...]


def join(rows: Sequence[PersonRow], people: Sequence[Person]) -> Joined:
    """Find the row of each person."""
    found: dict[str, int] = {}
    doubts: dict[str, str] = {}
    settled: set[int] = set()
    by_name: list[int] = []
    for named in _passes(rows, people):
        new = {
            place: ids
            for place in range(len(rows))
            if place not in settled and (ids := named(place))
        }
        rows_of: dict[str, list[int]] = {}
        for place, ids in new.items():
            for one in ids:
                rows_of.setdefault(one, []).append(place)
        by_name = []
        for place, ids in new.items():
            rivals = sorted({other for id_ in ids for other in rows_of[id_]})
            if len(ids) > 1 or len(rivals) > 1:
                reason = f"{_or(rows[other].label for other in rivals)} may be {_or(sorted(ids))}"
                doubts |= dict.fromkeys(ids - found.keys(), reason)
                settled.add(place)
            elif not ids & (found.keys() | doubts.keys()):
                found[min(ids)] = place
                settled.add(place)
                by_name.append(place)
    for place, row in enumerate(rows):
        for person in _namesakes(row, people) if place not in settled else ():
            if person.id not in found:
                reason = f"{row.label} has the number {row.lms_id}, and not their {person.lms_id}"
                doubts.setdefault(person.id, reason)
    strangers = tuple(row.label for place, row in enumerate(rows) if place not in settled)
    renamed = tuple(
        f"{rows[found[person.id]].label} for {person.called}"
        for person in people
        if person.id in found and not _agrees(rows[found[person.id]].name, person)
    )
    by_name = [rows[place].label for place in by_name]
    return Joined(found, strangers, doubts, tuple(by_name), renamed)


def _passes(
    rows: Sequence[PersonRow], people: Sequence[Person]
) -> Iterator[Callable[[int], set[str]]]:
    """Whom the row at a place names: by each rank of its claims, and at last by its name."""
    roster = Roster(tuple(people))
    owners: dict[Claim, set[str]] = {}
    for person in people:
        for attribute in ("id", "email", "lms_id"):
            text = folded(getattr(person, attribute))
            if text:
                owners.setdefault((attribute, text), set()).add(person.id)

    for rank in range(max((len(row.claims) for row in rows), default=0)):
        yield lambda place, rank=rank: {
            id
            for attribute, text in rows[place].claims[rank]
            for id in owners.get((attribute, folded(text)), ())
            if rank == 0 or _agrees(rows[place].name, roster.person(id))
        }
    yield lambda place: {
        person.id
        for person in roster.like(rows[place].name)
        if not has_another_number(person, rows[place].lms_id)
    }


def _namesakes(row: PersonRow, people: Sequence[Person]) -> Iterator[Person]:
    """Who is called as a row says, and has another number."""
    for person in Roster(tuple(people)).like(row.name):
        if has_another_number(person, row.lms_id):
            yield person


def _agrees(name: str, person: Person) -> bool:
    """Whether a name may be somebody's; who has none here may have any."""
    return not name or person.name == person.id or bool(Roster((person,)).like(name))


def _or(words: Iterable[str]) -> str:
    return " or ".join(words)
