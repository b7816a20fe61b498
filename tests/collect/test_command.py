"""The command `collect`: options, exit status, output and errors."""

import errno
import os

import pytest

from grader import cli
from grader.classroom.collect import CollectError, collection
from tests.archives import SIX, canvas_files, notebook
from tests.collecting import STAGE, archive, collect, states


def test_the_exit_status_is_1_while_questions_are_open(course, run_command, capsys):
    path = archive(course, [(f"ada/{SIX}.ipynb", notebook()), (f"eve/{SIX}.ipynb", notebook())])
    assert run_command(path) == 1
    output = capsys.readouterr().out
    assert "until you decide" in output and "--who eve=ID" in output
    assert (
        "Students on the roster without a submission: 2 (bjorn, cy)." in output
        and "xcused" not in output
    )
    assert run_command(path, "--who", "eve=cy") == 0
    assert "waiting" not in capsys.readouterr().out


def test_a_wrong_stage_is_reported_even_if_a_question_is_open(course, run_command, capsys):
    path = archive(course, [(f"ada/{SIX}.ipynb", notebook())])
    assert run_command(path) == 0
    capsys.readouterr()
    path = archive(course, [(f"ada/{SIX}.ipynb", notebook()), ("cy/a.txt", b"a")])
    assert cli.main(["collect", "--stage", "stage2_clustering", str(path)]) == 1
    message = (
        "No notebook was collected for stage2_clustering. Decide about the files above, or corr"
    )
    assert message in capsys.readouterr().err


def test_an_open_question_about_collected_files_is_shown_as_such(course, run_command, capsys):
    files = canvas_files("Team Rot", 4001, [(1, f"{SIX}.ipynb", notebook())])
    path = archive(course, files)
    assert run_command(path) == 1
    output = capsys.readouterr().out
    assert "Collected, but the owner is uncertain:" in output and "until you decide" not in output
    assert run_command(path, "--who", "teamrot_4001=ada") == 0


def test_excused_students_are_not_reported_as_missing(course, run_command, capsys):
    (course.root / "deadlines.toml").write_text(
        f'[{STAGE}]\ndue = 2026-11-20 18:00:00\n[{STAGE}.students]\ncy = "excused"\n'
        '[stage1_ransac.students]\nbjorn = "excused"\n'
    )
    roster = "id,role\nada,\nbjorn,\ncy,\nguest,auditor\n"
    (course.root / "roster.csv").write_text(roster)
    assert run_command(archive(course, [(f"ada/{SIX}.ipynb", notebook())])) == 0
    output = " ".join(capsys.readouterr().out.split())
    assert "Students on the roster without a submission: 1 (bjorn)." in output
    assert "Excused students without a submission: cy." in output
    assert "Auditors without a submission: guest." in output


def test_students_in_an_earlier_archive_are_not_reported_as_missing(course, run_command, capsys):
    """Each section may have an archive of its own."""
    for student in ("ada", "bjorn"):
        assert run_command(archive(course, [(f"{student}/{SIX}.ipynb", notebook())])) == 0
    output = capsys.readouterr().out
    assert "without a submission: 2 (bjorn, cy)." in output
    assert "without a submission: 1 (cy)." in output


def test_the_number_of_times_in_the_table_is_reported(course, run_command, capsys):
    files = [(f"ada/{SIX}.ipynb", notebook()), (f"cy/{SIX}.ipynb", notebook())]
    path = archive(course, files)
    table = course.root / "times.csv"
    table.write_text("id,Last modified (submission)\nada,2026-10-14 14:14 UTC\n")
    run_command(path)
    assert "submission times" not in capsys.readouterr().out
    run_command(path, "--timestamps", table)
    output = " ".join(capsys.readouterr().out.split())
    assert "The table contains submission times for 1 of the 2 students with notebooks." in output


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["none.zip"], "does not exist"),
        (["damaged.zip"], "is not a complete zip"),
        (["empty"], " is empty."),
        ([".", "--who", "x=nobody"], "no student on the roster has the id nobody"),
        ([".", "--who", "x=Ada Lovelace"], "Write ada"),
        ([".", "--who", "x/report.pdf=ada"], "can only be ignored, not assigned. Write - instead"),
        ([".", "--lesson", "x=99"], "there is no lesson 99"),
        ([".", "--timestamps", "none.csv"], "cannot be read"),
    ],
)
def test_errors_explain_wrong_options(course, run_command, words, message, capsys, monkeypatch):
    monkeypatch.chdir(course.root)
    (course.root / "damaged.zip").write_bytes(b"")
    (course.root / "empty").mkdir()
    assert run_command(*words) == 2
    assert message in capsys.readouterr().err


def test_students_with_an_undecided_time_are_listed(course, run_command, capsys):
    table = course.root / "times.csv"
    table.write_text("id,Last modified (submission)\nada,10/11/2026 9:00\n")
    path = archive(course, [(f"ada/{SIX}.ipynb", notebook())])
    assert run_command(path, "--timestamps", table) == 0
    output = capsys.readouterr().out
    assert "It is unknown whether these students submitted late: ada. Reason: the" in output
    assert "has '10/11/2026 9:00', which is not a time" in output


def test_an_option_cannot_lead_to_another_folder(course_without_roster):
    path = archive(course_without_roster, [(f"ada/{SIX}.ipynb", notebook())])
    with pytest.raises(CollectError, match="no folder can have the name ../../x"):
        collect(course_without_roster, path, who={"ada": "../../x"})


def test_collecting_is_refused_while_the_course_is_graded(course, run_command, capsys):
    from grader.classroom.lock import course_lock

    with course_lock(course):
        assert run_command(archive(course, [(f"ada/{SIX}.ipynb", notebook())])) == 1
    assert "Another run is grading" in capsys.readouterr().err


def test_a_stopped_run_is_resumed(course):
    path = archive(course, [(f"{name}/{SIX}.ipynb", notebook()) for name in ("ada", "bjorn", "cy")])

    def stop(done, total, what):
        if done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        collection.collect(course, [path], [STAGE], None, {}, {}, stop)
    found = states(collect(course, path))
    assert found == {"ada": {"06": "same"}, "bjorn": {"06": "same"}, "cy": {"06": "new"}}


@pytest.mark.parametrize("number", [errno.EACCES, errno.EROFS, errno.EPERM])
def test_the_error_about_a_read_only_folder_names_the_folder(
    course, run_command, monkeypatch, capsys, number
):
    def refuse(*about, dir, **options):
        raise OSError(number, os.strerror(number), str(dir))

    monkeypatch.setattr("tempfile.mkstemp", refuse)
    assert run_command(archive(course, [(f"ada/{SIX}.ipynb", notebook())])) == 1
    errors = capsys.readouterr().err
    assert str(course.submitted / "ada" / STAGE) in errors and "same command again" in errors


def test_the_error_about_a_file_instead_of_a_folder_names_the_file(course, run_command, capsys):
    course.submitted.write_text("")
    assert run_command(archive(course, [(f"ada/{SIX}.ipynb", notebook())])) == 1
    assert str(course.submitted) in capsys.readouterr().err


def test_a_full_disk_leaves_no_partial_files(course, monkeypatch):
    monkeypatch.setattr(os, "replace", lambda *about: (_ for _ in ()).throw(OSError(28, "full")))
    path = archive(course, [(f"ada/{SIX}.ipynb", notebook())])
    with pytest.raises(OSError, match="full"):
        collect(course, path)
    assert [path.name for path in course.submitted.rglob("*") if path.is_file()] == []
