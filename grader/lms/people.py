"""Who takes the course, for the gradebook: names, e-mails, numbers in the learning platform."""

from __future__ import annotations

from nbgrader.api import Gradebook

from grader.course.roster import Person, Roster


def enrol(book: Gradebook, roster: Roster) -> None:
    """Enter everybody on the roster, and what has changed about them.

    What the roster leaves blank stays as it is in the gradebook. Nobody is taken out: with them
    would go their marks.
    """
    known = {student.id: student for student in book.students}
    for person in roster.people:
        about = {name: text for name, text in _about(person).items() if text}
        student = known.get(person.id)
        if student is None or any(getattr(student, name) != text for name, text in about.items()):
            book.update_or_create_student(person.id, **about)


def people_in(book: Gradebook) -> list[Person]:
    """Who is in a gradebook, as it describes them."""
    return [
        Person(
            student.id,
            student.first_name or "",
            student.last_name or "",
            student.email or "",
            lms_id=student.lms_user_id or "",
        )
        for student in book.students
    ]


def _about(person: Person) -> dict[str, str]:
    return {
        "first_name": person.first_name,
        "last_name": person.last_name,
        "email": person.email,
        "lms_user_id": person.lms_id,
    }
