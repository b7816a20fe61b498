"""The lessons of the course, which must pass more tests than an author's new lessons."""

from grader.course.lessons import all_lessons

# Only the course's lessons have `slips.py`; authors test new lessons with `grader try`.
COURSE = tuple(lesson for lesson in all_lessons() if (lesson.folder / "slips.py").is_file())
