"""The lesson of a submitted file, and the copy of a notebook that counts."""

from tests.archives import (
    EIGHT,
    NINE,
    SEVEN,
    SIX,
    STAGE3,
    canvas_files,
    make_zip,
    moodle_files,
    notebook,
    released_notebook,
)
from tests.collecting import (
    MONDAY,
    STAGE,
    archive,
    collect,
    placed_files,
    questions,
    states,
    write_checkout,
)


def test_the_lesson_follows_from_the_content_if_the_file_name_contains_no_lesson(course):
    files = [("ada/8.ipynb", notebook(EIGHT)), ("ada/x/final.ipynb", notebook(NINE))]
    assert states(collect(course, archive(course, files))) == {"ada": {"08": "new", "09": "new"}}


def test_the_lesson_follows_from_the_graded_cells_if_the_metadata_is_missing(course):
    unnamed = released_notebook(EIGHT).replace(b'"lidar_obstacle_lab"', b'"y"')
    path = archive(course, [("ada/x.ipynb", unnamed)])
    assert states(collect(course, path)) == {"ada": {"08": "new"}}


def test_name_and_content_that_disagree_become_a_question(course):
    files = [(f"ada/{SIX}.ipynb", notebook(EIGHT)), (f"ada/{SEVEN}.ipynb", notebook(SEVEN))]
    path = archive(course, files)
    outcome = collect(course, path)
    assert states(outcome)["ada"] == {"06": "?", "07": "new", "08": "?"}
    name = f"ada/{SIX}.ipynb"
    assert f"--lesson {name}=08 or --lesson {name}=06" in questions(outcome)[name]
    assert set(placed_files(course, "ada")) == {f"{SEVEN}.ipynb"}
    outcome = collect(course, path, lessons={name: "06"})
    assert states(outcome)["ada"] == {"06": "new", "07": "same"}
    assert collect(course, path).questions == [], "answered questions are not asked again"


def test_a_file_of_another_stage_is_collected_if_the_stage_is_named(course):
    files = [
        (f"ada/{SIX}.ipynb", notebook()),
        ("ada/01_point_clouds.ipynb", notebook("01_point_clouds")),
    ]
    path = archive(course, files)
    outcome = collect(course, path)
    assert "--stage stage1_ransac" in questions(outcome)["ada/01_point_clouds.ipynb"]
    outcome = collect(course, path, stages=(STAGE, "stage1_ransac"))
    assert states(outcome)["ada"] == {"01": "new", "06": "same"}
    assert set(placed_files(course, "ada", "stage1_ransac")) == {"01_point_clouds.ipynb"}
    assert collect(course, path).questions == []


def test_only_changed_notebooks_of_a_whole_course_count(course):
    """A student may submit a zip of the whole course, with many unchanged notebooks."""
    files = [
        (f"ada/lab/notebooks/{STAGE}/{SIX}.ipynb", notebook()),
        (
            "ada/lab/notebooks/stage1_ransac/01_point_clouds.ipynb",
            released_notebook("01_point_clouds"),
        ),
        ("ada/lab/utils/clouds.py", b"x = 1"),
        ("ada/lab/data/cloud.txt", b"1 2 3"),
        ("ada/__MACOSX/._06_filter_ground.ipynb", b"junk"),
        ("ada/lab/.ipynb_checkpoints/06_filter_ground-checkpoint.ipynb", notebook(text="old")),
    ]
    outcome = collect(course, archive(course, files))
    assert placed_files(course, "ada") == {f"{SIX}.ipynb": notebook()}
    assert outcome.questions == []


def test_modules_next_to_a_notebook_are_collected(course):
    files = [
        (f"ada/{SIX}.ipynb", notebook()),
        ("ada/helper.py", b"x = 1"),
        ("ada/no module.py", b"x"),
        (f"ada/{SEVEN}.py", b"exported"),
        ("ada/elsewhere/other.py", b"y = 2"),
    ]
    outcome = collect(course, archive(course, files))
    assert placed_files(course, "ada") == {f"{SIX}.ipynb": notebook(), "helper.py": b"x = 1"}
    assert questions(outcome)[f"ada/{SEVEN}.py"] == f"is not a notebook. Ask for {SEVEN}.ipynb"


def test_a_resubmitted_module_gets_its_original_name(course):
    """Canvas adds a number to the name of a resubmitted file, so `import helper` would fail."""
    files = [
        (1, "helper.py", b"x = 1"),
        (2, "helper-1.py", b"x = 2"),
        (3, f"{SIX}-1.ipynb", notebook()),
    ]
    collect(course, archive(course, canvas_files("Lovelace, Ada", 4001, files)))
    assert placed_files(course, "ada") == {f"{SIX}.ipynb": notebook(), "helper.py": b"x = 2"}


def test_modules_of_another_lesson_are_not_collected(course):
    files = [(f"ada/{lesson}/{lesson}.ipynb", notebook(lesson)) for lesson in (SIX, SEVEN)]
    files += [(f"ada/{lesson}/helper.py", lesson.encode()) for lesson in (SIX, SEVEN)]
    outcome = collect(course, archive(course, files))
    assert placed_files(course, "ada")["helper.py"] == SIX.encode()
    assert (
        "next to another of this student's notebooks"
        in questions(outcome)[f"ada/{SEVEN}/helper.py"]
    )


def test_unclear_files_are_asked_about_only_while_a_lesson_is_missing(course):
    files = [("ada/scratch.ipynb", notebook(named=False)), ("ada/report.pdf", b"%PDF")]
    first = collect(course, archive(course, files))
    assert set(questions(first)) == {"ada/scratch.ipynb", "ada/report.pdf"}
    assert "--lesson ada/scratch.ipynb=NN" in questions(first)["ada/scratch.ipynb"]
    files += [(f"ada/{lesson}.ipynb", notebook(lesson)) for lesson in STAGE3]
    outcome = collect(course, archive(course, files))
    assert outcome.questions == []
    assert {remark.name for remark in outcome.remarks} == {"ada/scratch.ipynb", "ada/report.pdf"}


def test_modules_named_like_a_lesson_are_asked_about_only_if_the_lesson_is_missing(course):
    """If the lesson's notebook was submitted too, the `.py` file is only mentioned."""
    files = [(f"ada/{lesson}.py", b"x = 1") for lesson in (SIX, SEVEN)]
    files += [(f"ada/{SIX}.ipynb", notebook())]
    outcome = collect(course, archive(course, files))
    assert set(questions(outcome)) == {f"ada/{SEVEN}.py"}
    assert [remark.name for remark in outcome.remarks] == [f"ada/{SIX}.py"]


def test_a_student_who_submitted_only_a_picture_is_reported(course):
    outcome = collect(course, archive(course, [("ada/photo.png", b"x"), ("README.md", b"x")]))
    text = "is not a notebook. The student submitted only: photo.png"
    assert questions(outcome) == {"ada/photo.png": text}


def test_two_submitters_are_one_student_only_if_an_option_says_so(course):
    """Otherwise, one student's work could be judged as another's."""
    files = [
        *canvas_files("Lovelace, Ada", 4001, [(1, f"{SIX}.ipynb", notebook(text="ada"))]),
        *canvas_files("Byron, Annabella", 77, [(2, f"{SIX}.ipynb", notebook(text="bella"))]),
    ]
    path = archive(course, files)
    who = {"byronannabella_77": "ada"}
    outcome = collect(course, path, who=who)
    assert states(outcome) == {} and not list(course.submitted.glob("*/*"))
    assert "--who lovelaceada_4001=ada" in questions(outcome)["lovelaceada_4001"]
    collect(course, path, who={**who, "lovelaceada_4001": "ada"})
    assert placed_files(course, "ada") == {f"{SIX}.ipynb": notebook(text="bella")}


def test_an_untouched_copy_is_ignored(course):
    """An untouched second download, with "(1)" in its name, does not replace the student's work."""
    files = [(f"ada/{SIX}.ipynb", notebook()), (f"ada/{SIX} (1).ipynb", released_notebook())]
    collect(course, archive(course, files))
    assert placed_files(course, "ada") == {f"{SIX}.ipynb": notebook()}


def test_an_untouched_notebook_does_not_replace_work_that_was_collected_earlier(course):
    """A student who submits again often attaches notebooks that are only in the last submission."""

    def submission(number, data):
        attachments = [(number, f"{SIX}.ipynb", data)]
        return archive(course, canvas_files("Lovelace, Ada", 4001, attachments))

    collect(course, submission(1, notebook()))
    again = submission(2, released_notebook())
    outcome = collect(course, again)
    assert states(outcome) == {"ada": {"06": "kept"}}
    assert placed_files(course, "ada") == {f"{SIX}.ipynb": notebook()}
    ((name, text),) = [(remark.name, remark.text) for remark in outcome.remarks]
    assert text.startswith("contains no work")
    collect(course, again, lessons={name: "06"})  # the instructor's answer decides
    assert placed_files(course, "ada") == {f"{SIX}.ipynb": released_notebook()}
    outcome = collect(course, submission(3, notebook(text="x = 2")))
    assert states(outcome) == {"ada": {"06": "newer"}}


def test_a_damaged_file_is_placed_if_there_is_no_other(course):
    broken = notebook()[:60]
    files = moodle_files("Ada Lovelace", 1, [(f"{SIX}.ipynb", broken)])
    outcome = collect(course, archive(course, files))
    assert states(outcome) == {"ada": {"06": "new"}}
    assert placed_files(course, "ada") == {f"{SIX}.ipynb": broken}
    (remark,) = outcome.remarks
    assert remark.text.startswith("is not a notebook, because it is not valid JSON. It was ")


def test_a_file_that_git_has_not_downloaded_is_not_placed(course, tmp_path):
    pointer = b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a21\nsize 9\n"
    write_checkout(
        tmp_path / "hw", "hw-3-ada-l", {f"{SIX}.ipynb": pointer, f"{SEVEN}.ipynb": pointer}
    )
    write_checkout(tmp_path / "hw", "hw-3-bmu", {f"{SIX}.ipynb": notebook()})
    outcome = collect(course, tmp_path / "hw")
    assert placed_files(course, "ada") == {}
    assert {name.rpartition("/")[2] for name in questions(outcome)} == {
        f"{SIX}.ipynb",
        f"{SEVEN}.ipynb",
    }
    assert "Run `git lfs pull` in the checkout" in " ".join(questions(outcome).values())


def test_a_copy_that_counts_only_because_of_its_number_is_reported(course):
    """The copy may be a backup, so the instructor can choose the other file afterwards."""
    names = (SIX, f"{SIX}-Copy1")
    pair = [(f"{name}.ipynb", notebook(text=name)) for name in names]
    path = archive(course, moodle_files("Ada Lovelace", 1, pair), when=MONDAY)
    for _ in range(2):
        (remark,) = collect(course, path).remarks
        assert remark.name == f"Ada Lovelace_1/{SIX}-Copy1.ipynb"
        assert f"instead of Ada Lovelace_1/{SIX}.ipynb, because the number" in remark.text
    answer = {f"Ada Lovelace_1/{SIX}.ipynb": "06"}
    outcome = collect(course, path, lessons=answer)
    assert states(outcome) == {"ada": {"06": "newer"}} and not outcome.remarks
    assert placed_files(course, "ada")[f"{SIX}.ipynb"] == notebook(text=SIX)
    outcome = collect(course, path)
    assert states(outcome) == {"ada": {"06": "same"}} and not outcome.remarks, "remembered"


def test_the_copy_with_the_highest_number_or_latest_time_counts(course):
    moodle = moodle_files(
        "Ada Lovelace",
        1,
        [(f"{SIX} ({n}).ipynb", notebook(text=f"copy {n}")) for n in (2, 10, 9)],
    )
    inner = make_zip(
        [
            (f"a/{SEVEN}.ipynb", notebook(SEVEN, "new"), (2026, 10, 2, 8, 0, 0)),
            (f"b/{SEVEN}.ipynb", notebook(SEVEN, "old"), (2026, 10, 1, 8, 0, 0)),
        ]
    )
    moodle += moodle_files("Ada Lovelace", 1, [("homework.zip", inner)])
    collect(course, archive(course, moodle))
    assert placed_files(course, "ada") == {
        f"{SIX}.ipynb": notebook(text="copy 10"),
        f"{SEVEN}.ipynb": notebook(SEVEN, "new"),
    }


def test_copies_without_an_order_become_a_question(course):
    """Times in Moodle's zips do not decide, because they are only the times of the download."""
    names = (f"a/{SIX}.ipynb", f"b/{SIX}.ipynb")
    files = moodle_files("Ada Lovelace", 1, [(name, notebook(text=name)) for name in names])
    files[1] = (*files[1], (2027, 1, 1, 0, 0, 0))
    path = archive(course, files)
    outcome = collect(course, path)
    assert states(outcome) == {"ada": {"06": "?"}}
    collect(course, path, lessons={f"Ada Lovelace_1/b/{SIX}.ipynb": "06"})
    assert placed_files(course, "ada") == {f"{SIX}.ipynb": notebook(text=names[1])}


def test_a_virtual_environment_is_not_collected(course):
    files = [
        (f"ada/{SIX}.ipynb", notebook()),
        (f"ada/venv/lib/python3.12/site-packages/{SEVEN}.ipynb", notebook(SEVEN)),
        ("ada/venv/pyvenv.cfg", b"home = /usr/bin"),
    ]
    assert states(collect(course, archive(course, files))) == {"ada": {"06": "new"}}
    packed = archive(course, [("cy/h.zip", make_zip([(name[4:], data) for name, data in files]))])
    assert states(collect(course, packed)) == {"cy": {"06": "new"}}
