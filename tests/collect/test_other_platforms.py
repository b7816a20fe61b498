"""Submissions from six other platforms, whose downloads are recognised by their names."""

from functools import partial

import pytest

from grader.classroom.collect import CollectError
from grader.classroom.collect.instructor_answers import teams_in
from tests.archives import (
    SIX,
    blackboard_files,
    brightspace_files,
    gradescope_files,
    ilias_files,
    notebook,
    prairielearn_files,
    sakai_files,
)
from tests.collecting import STAGE, archive, collect, placed_files, questions, states, write_roster

OLD, NEW = notebook(text="old"), notebook(text="new")
OTHER_PLATFORMS = {
    "Blackboard": [
        *blackboard_files("bjorn", "2026-10-12-23-59-00", [(f"{SIX}.ipynb", OLD)]),
        *blackboard_files("ada", "2026-10-12-23-10-00", [(f"{SIX}.ipynb", NEW)]),
        *blackboard_files("bjorn", "2026-10-13-09-00-00", [(f"{SIX}.ipynb", NEW)]),
    ],
    "Brightspace": [
        ("index.html", b"<html>"),
        *brightspace_files(
            "Björn Müller", 12346, "12 October, 2026 1159 PM", [(f"{SIX}.ipynb", OLD)]
        ),
        *brightspace_files(
            "Ada Lovelace", 12345, "12 October, 2026 1110 PM", [(f"{SIX}.ipynb", NEW)]
        ),
        *brightspace_files("Björn Müller", 12346, "Oct 13, 2026 900 AM", [(f"{SIX}.ipynb", NEW)]),
    ],
    "Gradescope": gradescope_files(
        [
            (
                101,
                [("Ada Lovelace", "'0012345'", "ada@x.edu")],
                "2026-10-12 21:10:00.000000000 Z",
                [(f"work/{SIX}.ipynb", NEW)],
            ),
            (
                102,
                [("Björn Müller", "", "bm@x.edu")],
                "2026-10-12 21:59:00.0 Z",
                [(f"{SIX}.ipynb", NEW)],
            ),
        ]
    ),
    "ILIAS": [
        *ilias_files(
            "Lovelace", "Ada", "ada", 4711, [(f"{SIX}.ipynb", NEW)], "Uebung_zu_Robotik_3"
        ),
        *ilias_files(
            "Mueller", "Bjoern", "bjorn", 4712, [(f"{SIX}.ipynb", NEW)], "Uebung_zu_Robotik_3"
        ),
    ],
    "PrairieLearn": [
        *prairielearn_files("ada@x.edu", 1, [(f"{SIX}.ipynb", NEW)]),
        *prairielearn_files("bm@x.edu", 1, [(f"{SIX}.ipynb", NEW)]),
    ],
    "Sakai": [
        ("Lab (week 3)/grades.csv", b"Lab,Points"),
        *sakai_files("Lovelace, Ada", "al", [(f"{SIX}.ipynb", NEW)]),
        *sakai_files("Müller, Björn", "bjorn", [(f"{SIX}.ipynb", NEW)]),
    ],
}


@pytest.mark.parametrize("platform", OTHER_PLATFORMS)
def test_other_platforms_are_recognised(course, platform):
    """The newest attempt counts. Files that the platform adds are not asked about."""
    outcome = collect(course, archive(course, OTHER_PLATFORMS[platform]))
    assert {kind for _, kind, _ in outcome.archives} == {platform}
    assert states(outcome) == {"ada": {"06": "new"}, "bjorn": {"06": "new"}}
    assert outcome.questions == []
    for student in ("ada", "bjorn"):
        assert placed_files(course, student) == {f"{SIX}.ipynb": NEW}


@pytest.mark.parametrize("platform", OTHER_PLATFORMS)
def test_other_platforms_are_recognised_without_a_roster(course_without_roster, platform):
    outcome = collect(
        course_without_roster, archive(course_without_roster, OTHER_PLATFORMS[platform])
    )
    assert len(outcome.states) == 2 and outcome.questions == []


@pytest.mark.parametrize("platform", OTHER_PLATFORMS)
def test_downloads_of_a_single_student_are_recognised(course, platform):
    files = [
        (name, data)
        for name, data in OTHER_PLATFORMS[platform]
        if not any(word in name for word in ("bj", "Bj", "Mueller", "bm@", "submission_102"))
    ]
    outcome = collect(course, archive(course, files))
    assert outcome.archives[0][1] == platform
    if platform in ("Blackboard", "ILIAS"):  # the length of the assignment's title is unknown
        assert states(outcome) == {} and len(outcome.questions) == 1
    else:
        assert states(outcome) == {"ada": {"06": "new"}}


@pytest.mark.parametrize("folders", [True, False], ids=["folders", "flat"])
def test_downloads_without_folders_are_recognised(course, folders):
    mine = [(f"{SIX}.ipynb", notebook())]
    path = archive(course, sakai_files("Lovelace, Ada", "ada", mine, folders=folders))
    assert states(collect(course, path)) == {"ada": {"06": "new"}}
    files = brightspace_files("23 Müller", 1, "05 March 2026 612 PM", mine, folders)
    write_roster(course, "23,Björn,Müller,,,", "ada,Ada,Lovelace,,,")
    assert states(collect(course, archive(course, files))) == {"23": {"06": "new"}}


@pytest.mark.parametrize(
    ("label", "attempt", "time"),
    [
        ("LiDAR 20Lab_eve", partial(blackboard_files, "eve"), "2026-10-1{}-09-00-00"),
        ("Eve Evil_77", partial(brightspace_files, "Eve Evil", 77), "1{} October, 2026 900 AM"),
    ],
    ids=["Blackboard", "Brightspace"],
)
def test_an_answer_about_an_attempt_applies_to_the_next_attempt(course, label, attempt, time):
    """The time of the attempt is not a part of the owner's name."""
    for day, who in ((2, {label: "cy"}), (3, {})):
        content = notebook(text=f"day {day}")
        path = archive(course, attempt(time.format(day), [(f"{SIX}.ipynb", content)]))
        outcome = collect(course, path, who=who)
        assert outcome.questions == [] and placed_files(course, "cy") == {f"{SIX}.ipynb": content}


def test_all_members_of_a_team_in_gradescope_are_collected(course):
    team = [("Ada Lovelace", "", "ada@x.edu"), ("Cy ONeil", "", "cy@x.edu")]
    stranger = [("Björn Müller", "", ""), ("Eve Evil", "", "eve@x.edu")]
    time, mine = "2026-10-12 21:10:00 Z", [(f"{SIX}.ipynb", notebook())]
    outcome = collect(
        course,
        archive(course, gradescope_files([(1, team, time, mine), (2, stranger, time, mine)])),
    )
    assert states(outcome) == {"ada": {"06": "new"}, "cy": {"06": "new"}}
    assert "write several ids" in questions(outcome)["Björn Müller+eve@x.edu"]
    assert teams_in(course, STAGE) == [frozenset({"ada", "cy"})], "the archive declares the team"
    assert teams_in(course, "stage2_clustering") == []


def test_a_damaged_list_of_submitters_is_refused(course):
    files = gradescope_files([(1, [("Ada", "", "")], "", [(f"{SIX}.ipynb", notebook())])])
    files[-1] = (files[-1][0], b"submission_1: [\n")
    with pytest.raises(CollectError, match="does not list the submitters"):
        collect(course, archive(course, files))


def test_a_student_cannot_name_the_submitters(course):
    files = gradescope_files(
        [(1, [("Cy", "", "cy@x.edu")], "", [(f"{SIX}.ipynb", notebook())])], root="ada/"
    )
    files += [(f"bjorn/{SIX}.ipynb", notebook(text="bjorn"))]
    outcome = collect(course, archive(course, files))
    assert states(outcome) == {"ada": {"06": "new"}, "bjorn": {"06": "new"}}


def test_a_team_in_ilias_is_asked_about(course):
    files = [
        *ilias_files("Lovelace", "Ada", "ada", 4711, [(f"{SIX}.ipynb", notebook())], team="7"),
        *ilias_files("Mueller", "B", "bjorn", 4712, [(f"{SIX}.ipynb", notebook())], team="8"),
    ]
    path = archive(course, files)
    outcome = collect(course, path)
    assert set(questions(outcome)) == {"Team 7", "Team 8"}
    assert "may be ada" in questions(outcome)["Team 7"]
    outcome = collect(course, path, who={"Team 7": "ada,cy", "Team 8": "bjorn"})
    assert set(states(outcome)) == {"ada", "cy", "bjorn"}


def test_ids_may_look_like_folders_from_ilias(course):
    write_roster(course, "lab_ws_ada_1,Ada,Lovelace,,,", "lab_ws_bo_2,Bo,Bäcker,,,", "ada,A,B,,,")
    files = [(f"lab_ws_{name}/{SIX}.ipynb", notebook(text=name)) for name in ("bo_2", "bo_3")]
    outcome = collect(course, archive(course, files))
    assert set(states(outcome)) == {"lab_ws_bo_2"} and len(outcome.questions) == 1


def test_keys_that_contradict_each_other_become_a_question(course):
    """The login is Ada's ID, but the name is Björn's."""
    files = sakai_files("Müller, Björn", "ada", [(f"{SIX}.ipynb", notebook())])
    outcome = collect(course, archive(course, files))
    assert states(outcome) == {} and "may be ada or bjorn" in questions(outcome)["ada"]
