"""The lessons of the course, which these tests hold to more than a lesson of an author's own."""

from grader.course.lessons import all_lessons

# Only the course's lessons have the likeliest slips; an author tries others with `grader try`.
COURSE = tuple(lesson for lesson in all_lessons() if (lesson.folder / "slips.py").is_file())
