"""Submissions in folders, one per student, inside or around other folders."""

import re

import pytest

from grader.classroom.collect.owners import safe_folder
from tests.archives import EIGHT, SEVEN, SIX, make_zip, notebook
from tests.collecting import (
    LESSONS,
    STAGE,
    archive,
    archive_of,
    collect,
    placed_files,
    questions,
    states,
    write_roster,
)

GROUPS = (("A", "x1"), ("A", "x2"), ("B", "x3"))


def lessons_in(paths):
    """Return the numbers of the lessons in paths for `archive_of`."""
    names = {path.rpartition("/")[2] for path in paths}
    return {f"{int(name):02}" for name in names & LESSONS.keys()}


def collected_lessons(outcome):
    return {number for lessons in states(outcome).values() for number in lessons}


@pytest.mark.parametrize("layout", ["{}_{}.ipynb", "{1} {0}.ipynb", "{}.zip"])
def test_files_of_several_students_are_never_attributed_to_one(course_with_strangers, layout):
    """The platform is unknown, and its folders are not named after students."""
    course = course_with_strangers
    files = [
        (f"export/group {group}/" + layout.format(person, SIX), notebook(text=person))
        for group, person in GROUPS
    ]
    outcome = collect(course, archive(course, files))
    assert "A" not in "".join(states(outcome))
    text = questions(outcome)["group A"]
    assert "a folder named after the student" in text
    assert ("--who" in text) == (outcome.roster is None)


@pytest.mark.parametrize(
    ("layout", "levels"), [("{}/{}.ipynb", (2, 3)), ("a/{}/more/{}.ipynb", (2, 4))]
)
def test_a_question_is_asked_if_two_levels_of_folders_may_be_named_after_students(
    course_with_strangers, layout, levels
):
    course = course_with_strangers
    path = archive(
        course,
        [
            (f"export/group {group}/" + layout.format(person, SIX), notebook(text=person))
            for group, person in GROUPS
        ],
    )
    outcome = collect(course, path)
    assert questions(outcome) == {
        "submissions.zip": f"Add --folder-level {levels[0]} if the folders group A, group B are "
        f"named after students, or --folder-level {levels[1]} if the folders x1, x2, x3 are"
    }
    assert states(outcome) == {}
    for level, names in zip(levels, ({"group A", "group B"}, {"x1", "x2", "x3"}), strict=True):
        outcome = collect(course, path, level=level)
        assert names == (set(questions(outcome)) if outcome.roster else set(states(outcome)))


@pytest.mark.parametrize(
    "paths",
    [
        ("a/x1/6", "a/x2/7", "b/x3/8"),
        ("a/x1/6", "a/x2/more/7", "b/x3/8"),
        ("a/x1/6", "a/x2/6", "b/x3/8"),
        ("hw6/x1/6", "hw6/x2/6", "hw7/x1/7", "hw7/x2/7"),
        ("A/anna/6", "A/bo/6", "A/cy/6", "B/anna/6"),
        ("try/x1/6", "try/x2/6", "new/x1/6", "new/x2/6"),
        ("try/x1/6", "try/x2/6", "try/x3/6", "new/x1/6", "new/x2/6"),
        ("week1/x1/work.ipynb", "week1/x2/work.ipynb", "week2/x1/work.ipynb"),
    ],
)
def test_different_lessons_of_several_students_are_never_attributed_to_one(
    course_with_strangers, paths
):
    path = archive_of(course_with_strangers, paths)
    outcome = collect(course_with_strangers, path)
    assert states(outcome) == {} and "--folder-level 2 if" in questions(outcome)["submissions.zip"]


@pytest.mark.parametrize("names", [("x1 {}", "x2 {}"), ("{}_x1", "{}_x2"), ("x1", "x2")])
@pytest.mark.parametrize("lessons", [(SIX, SEVEN), (SIX, SIX)])
def test_files_without_folders_are_not_attributed_to_one_student(
    course_with_strangers, names, lessons
):
    """Different words in the names, or a repeated lesson, may mean several students."""
    files = [
        (f"{name.format(lesson[:2])}.ipynb", notebook(lesson, text=name))
        for name, lesson in zip(names, lessons, strict=True)
    ]
    outcome = collect(course_with_strangers, archive(course_with_strangers, files))
    text = questions(outcome)["submissions"]
    assert states(outcome) == {} and "a folder named after the student" in text
    assert ("--who" in text) == (outcome.roster is None)


@pytest.mark.parametrize("names", [("{}", "{} (1)"), ("Copy of {}", "{}-Copy2"), ("Untitled", "8")])
def test_files_of_one_student_need_no_folder(course_without_roster, names):
    """Words that a program or one student adds to the names do not name several students."""
    files = [
        (f"{name.format(lesson)}.ipynb", notebook(lesson))
        for name, lesson in zip(names, (SIX, EIGHT), strict=True)
    ]
    outcome = collect(course_without_roster, archive(course_without_roster, files))
    assert states(outcome) == {"submissions": {"06": "new", "08": "new"}}


@pytest.mark.parametrize(
    "paths",
    [
        ("ada/hw6/6", "ada/hw7/7", "bo/hw6/6", "bo/hw7/7"),
        ("ada/try/6", "ada/new/6", "bo/try/6", "bo/new/6", "cy/try/6"),
        ("ada/stage3_obstacles/6", "ada/stage4_realtime/10", "bo/stage3_obstacles/7"),
        ("ada/6", "ada/old/6", "bo/hw/7"),
        ("lab/ada/notebooks/stage3_obstacles/6", "lab/ada/data/a.txt", "lab/bo/7", "lab/index.csv"),
        ("ada/6", "bo/photo.png"),
    ],
)
def test_folders_inside_a_students_folder_need_no_question(course_without_roster, paths):
    """Such folders belong to the course, an attempt or a lesson, or recur for other students."""
    path = archive_of(course_without_roster, paths)
    outcome = collect(course_without_roster, path, stages=(STAGE, "stage4_realtime"))
    assert set(states(outcome)) == {"ada", "bo", "cy"} & set("/".join(paths).split("/"))
    assert collected_lessons(outcome) == lessons_in(paths)
    assert not re.search("several|--who|--folder", " ".join(questions(outcome).values()))


def test_an_option_confirms_one_students_folders_if_there_is_no_roster(course_without_roster):
    path = archive_of(course_without_roster, ("ada/6", "bo/mine/6", "bo/more/7"))
    outcome = collect(course_without_roster, path)
    assert states(outcome) == {"ada": {"06": "new"}}
    assert "If one student submitted all of them, add --who bo=bo" in questions(outcome)["bo"]
    outcome = collect(course_without_roster, path, who={"bo": "bo"})
    assert states(outcome)["bo"] == {"06": "new", "07": "new"} and outcome.questions == []


@pytest.mark.parametrize(
    ("ids", "found"),
    [
        (("x1", "x2", "x3"), {"x1", "x2", "x3"}),
        (("x1", "x3"), {"x1", "x3"}),
        (("x3",), set()),
        (("b", "x1", "x2", "x3"), {"b"}),
    ],
)
def test_the_roster_decides_which_folders_belong_to_students(course, ids, found):
    """A student may name a folder after another student, so one known name is not enough."""
    write_roster(course, *(f"{id},,,,," for id in ids))
    outcome = collect(course, archive_of(course, ("a/x1/6", "a/x2/7", "b/x3/8")))
    assert set(states(outcome)) == found and bool(outcome.questions) == (len(found) < 3)


def test_the_roster_decides_even_if_the_students_folders_recur(course):
    """Without the roster, the folders ada and cy look like folders of lessons."""
    paths = ("week1/ada/6", "week1/cy/7", "week2/ada/6", "week2/cy/7")
    assert set(states(collect(course, archive_of(course, paths)))) == {"ada", "cy"}


@pytest.mark.parametrize(
    "paths",
    [
        ("stage3_obstacles/x1/6", "stage3_obstacles/x2/7", "export/marks.csv"),
        ("stage3_obstacles/x1/6", "stage4_realtime/x1/10", "stage3_obstacles/x2/7"),
        ("lab/notebooks/stage3_obstacles/x1/6", "lab/stage3_obstacles/x2/7", "lab/marks.csv"),
    ],
)
def test_students_folders_are_found_inside_folders_of_the_course(course_with_strangers, paths):
    path = archive_of(course_with_strangers, paths)
    outcome = collect(course_with_strangers, path, stages=(STAGE, "stage4_realtime"))
    texts = questions(outcome)
    assert (set(texts) if outcome.roster else set(states(outcome))) == {"x1", "x2"}
    assert collected_lessons(outcome) == (set() if outcome.roster else lessons_in(paths))
    assert "several students" not in "".join(texts.values())


def test_folders_above_the_students_are_not_part_of_file_names(course):
    """An answer about a file also applies to the next archive, whose folder has another name."""
    for folder in ("monday", "tuesday"):
        paths = (f"{folder}/ada/6", f"{folder}/ada/more/essay.pdf", f"{folder}/bjorn/7")
        assert "ada/more/essay.pdf" in questions(collect(course, archive_of(course, paths)))


def test_no_owner_is_suggested_for_a_folder_with_a_repeated_lesson(course):
    files = [
        (f"a/{SIX}.ipynb", notebook()),
        (f"a/{SIX} (1).ipynb", notebook(text="other")),
        (f"b/x3/{EIGHT}.ipynb", notebook(EIGHT)),
    ]
    texts = questions(collect(course, archive(course, files)))
    assert "--who" not in texts["a"] and "a folder named after the student" in texts["a"]
    assert "--who b=ID" in texts["b"], "one folder may be one student's"


@pytest.mark.parametrize("inside", ["{}.ipynb", "{0}/{0}.ipynb", "old/{}.ipynb"])
def test_one_owner_is_suggested_for_one_students_folders(course, inside):
    files = [
        (f"eve/{SIX}.ipynb", notebook()),
        ("eve/" + inside.format(SEVEN), notebook(SEVEN)),
        (f"ada/{SIX}.ipynb", notebook(text="ada")),
    ]
    assert "--who eve=ID" in questions(collect(course, archive(course, files)))["eve"]


@pytest.mark.parametrize("wrapper", ["export", STAGE, f"export/{STAGE}"])
@pytest.mark.parametrize("loose", ["", "readme.txt", "{}/marks.csv"])
def test_students_folders_are_found_below_other_folders(course_without_roster, wrapper, loose):
    """Neither the name of the folder above nor a file next to the folders prevents this."""
    files = [
        (f"{wrapper}/x1/{SIX}.ipynb", notebook()),
        (f"{wrapper}/x2/{SEVEN}.ipynb", notebook(SEVEN)),
        *([(loose.format(wrapper), b"x")] if loose else []),
    ]
    outcome = collect(course_without_roster, archive(course_without_roster, files))
    assert states(outcome) == {"x1": {"06": "new"}, "x2": {"07": "new"}}


@pytest.mark.parametrize(
    "layout",
    [
        "{}/06_filter_ground.ipynb",
        "{}/stage3_obstacles/06_filter_ground.ipynb",
        "class/{}/notebooks/stage3_obstacles/06_filter_ground.ipynb",
        "{}_06_filter_ground.ipynb",
        "06_filter_ground_{}.ipynb",
        "{}/Copy of 06_Filter_Ground (2).IPYNB",
        "{}/8.ipynb",
        "{}/06_filter_ground.ipynb.txt",
        "{}/06_filter_ground.json",
    ],
)
def test_one_folder_for_each_student_is_collected(course, layout):
    files = [(layout.format(name), notebook()) for name in ("Ada ", "BJORN")]
    outcome = collect(course, archive(course, files))
    assert states(outcome) == {"ada": {"06": "new"}, "bjorn": {"06": "new"}}
    assert set(placed_files(course, "ada")) == {f"{SIX}.ipynb"}


def test_a_folder_of_zips_and_a_single_file_are_collected(course, tmp_path):
    folder = tmp_path / "downloads"
    folder.mkdir()
    (folder / "ada.zip").write_bytes(make_zip([(f"{SIX}.ipynb", notebook())]))
    (folder / "bjorn.zip").write_bytes(make_zip([(f"w/{SIX}.ipynb", notebook(text="b"))]))
    assert states(collect(course, folder)) == {"ada": {"06": "new"}, "bjorn": {"06": "new"}}
    single = tmp_path / "8.ipynb"
    single.write_bytes(notebook(EIGHT))
    assert "--who 8=ID" in questions(collect(course, single))["8"]
    assert states(collect(course, single, who={"8": "cy"})) == {"cy": {"08": "new"}}


def test_folders_have_the_names_in_the_archive_if_there_is_no_roster(course_without_roster):
    path = archive(
        course_without_roster,
        [(f"{name}/{SIX}.ipynb", notebook()) for name in ("mary jane", "aux", "Ærø: Ö")],
    )
    outcome = collect(course_without_roster, path)
    assert set(outcome.states) == {"mary jane", "aux_", "Ærø- Ö"}
    assert outcome.roster is None and outcome.questions == []


@pytest.mark.parametrize(
    ("name", "folder"),
    [
        ("", "unnamed"),
        ("..", "unnamed"),
        ("CON", "CON_"),
        ("nul.txt", "nul.txt_"),
        ("a/b", "a-b"),
        ("a\0b", "a-b"),
        ("C:x", "C-x"),
        (" yan ", "yan"),
        ("dot.", "dot"),
        ("__x", "x"),
        ("o\u0308", "ö"),
        ("x" * 300, "x" * 80),
    ],
)
def test_folder_names_are_safe_on_every_system(name, folder):
    assert safe_folder(name) == folder
