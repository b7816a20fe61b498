"""Write and read the students in the gradebook: names, e-mail addresses and LMS IDs."""

from __future__ import annotations

from nbgrader.api import Gradebook

from grader.course.roster import Person, Roster


def enrol(book: Gradebook, roster: Roster) -> None:
    """Enter all students on the roster, and update details that have changed.

    Fields that are blank on the roster are not changed in the gradebook. Students are never
    removed, because their marks would be removed as well.
    """
    students_by_id = {student.id: student for student in book.students}
    for person in roster.people:
        details = {name: text for name, text in _details(person).items() if text}
        student = students_by_id.get(person.id)
        if student is None or any(getattr(student, name) != text for name, text in details.items()):
            book.update_or_create_student(person.id, **details)


def students_in_gradebook(book: Gradebook) -> list[Person]:
    """Return the students in a gradebook, with the details stored there."""
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


def _details(person: Person) -> dict[str, str]:
    return {
        "first_name": person.first_name,
        "last_name": person.last_name,
        "email": person.email,
        "lms_user_id": person.lms_id,
    }
