"""Courses whose submissions are judged, and the scores that reach their gradebooks."""

import json
import shutil
import subprocess
import sys

from grader.classroom import grade
from grader.classroom.executors import EXECUTORS
from grader.classroom.rehearsals import record_of
from grader.course.atomic_files import write_atomically
from grader.course.kept_answers import answers_to, fill_in
from grader.course.lessons import find_lesson
from grader.course.paths import PROJECT, Course
from grader.lms import gradebook
from grader.lms.results_reader import class_results
from tests.gradebooks import ignore_progress

LESSON = find_lesson("06_filter_ground")
SEED = 2**64 + 31
CONFIGURATION = """\
import sys
from pathlib import Path
sys.path.insert(0, {project!r})
from grader.course.nbgrader_settings import configure
configure(get_config(), Path({root!r}))
c = get_config()
c.Judge.seed = {seed}
c.Judge.sandbox = {sandbox!r}
"""


def answered_notebook(*wrong):
    """Return a notebook of lesson 06 with wrong answers to the exercises in `wrong`."""
    return fill_in(
        LESSON,
        {
            exercise: next(
                variant.source
                for variant in answers_to(exercise)
                if variant.right == (exercise not in wrong)
            )
            for exercise in ("filter_ground", "voxel_grid")
        },
    )


def record_rehearsal(course, lesson, seed=SEED):
    """Store a record that a lesson's solution has been judged, because judging it is slow."""
    path, key = record_of(course, lesson, seed)
    write_atomically(json.dumps(key), path)


def make_course(root, lesson, texts, sandbox):
    """Return a rehearsed course of one lesson; `texts` maps students to their notebooks."""
    course = Course(root)
    record_rehearsal(course, lesson)
    for folder in ("solutions", "notebooks"):
        shutil.copytree(
            PROJECT / folder / lesson.stage,
            course.root / folder / lesson.stage,
            ignore=lambda folder, names: [name for name in names if not name.endswith(".ipynb")],
        )
        for path in (course.root / folder / lesson.stage).glob("*.ipynb"):
            if path.stem != lesson.name:
                path.unlink()
    (course.root / "nbgrader_config.py").write_text(
        CONFIGURATION.format(
            project=str(PROJECT), root=str(course.root), seed=SEED, sandbox=sandbox.name
        )
    )
    for student, text in texts.items():
        path = course.submitted / student / lesson.stage / f"{lesson.name}.ipynb"
        path.parent.mkdir(parents=True)
        path.write_text(text, "utf-8")
    return course


def entered_scores(course):
    """Return the score of each student, stage and notebook in the gradebook."""
    results = class_results(course).notebooks
    return {
        (result.student, result.stage, result.lesson): result.score
        for result in results
        if result.score is not None
    }


def judge_course(course, sandbox, workers=2):
    return grade.judge_class(
        course, (), SEED, sandbox, EXECUTORS["processes"], workers, ignore_progress
    )


def run_nbgrader(course, *words):
    return subprocess.run(
        [sys.executable, "-m", "nbgrader", *words],
        cwd=course.root,
        capture_output=True,
        text=True,
        timeout=600,
    )


WRITTEN_LESSON = find_lesson("12_streaming_obstacles")

REPORT = "I widened the region to 18.5 m, because of the lorry."


def right_match_boxes():
    return next(variant.source for variant in answers_to("match_boxes") if variant.right)


def with_report(text):
    return fill_in(WRITTEN_LESSON, {"match_boxes": right_match_boxes(), "write_up": text})


def gradebook_of(course):
    return gradebook.open_gradebook(course)


def enter_manual_mark(course, student, score):
    """Enter a manual mark as Formgrader does."""
    with gradebook_of(course) as book:
        grade = book.find_grade("write_up", WRITTEN_LESSON.name, WRITTEN_LESSON.stage, student)
        grade.manual_score, grade.needs_manual_grade = score, False
        book.db.commit()
