"""Reading kept answers, including those that are stored as edits of other answers."""

import pytest

from grader.course import kept_answers
from grader.course.kept_answers import answers_to, apply_edits

SOURCE = "def f(a):\n    b = a + 1\n\n    for c in b:\n        print(c)\n    return b"


@pytest.mark.parametrize(
    ("edits", "becomes"),
    [
        ("-     b = a + 1\n+     b = a - 1", SOURCE.replace("+", "-")),
        (
            "-         print(c)\n+         print(c)\n+         a.add(c)",
            "…print(c)\n        a.add(c)",
        ),
        ("=     b = a + 1\n+     b = b", "…b = a + 1\n    b = b"),
        ("-\n", SOURCE.replace("\n\n", "\n")),
        (
            "-     b = a + 1\n+     b = a\n-     return b\n+     return a",
            SOURCE.replace("a + 1", "a").replace("return b", "return a"),
        ),
        ("-\n\n-     return b\n", SOURCE.replace("\n\n", "\n").replace("\n    return b", "")),
        ("= def f(a):\n=     b = a + 1\n+     c = 2", "…b = a + 1\n    c = 2"),
    ],
    ids=["a line", "a last line", "an insertion", "a blank line", "two", "two less", "context"],
)
def test_an_edit_changes_only_its_lines(edits, becomes):
    if becomes.startswith("…"):
        first, _, _ = becomes[1:].partition("\n")
        becomes = SOURCE.replace(first, becomes[1:])
    assert apply_edits(SOURCE, edits, "an answer") == becomes


@pytest.mark.parametrize(
    ("edits", "count"), [("-     b = a - 1\n+     b = a", 0), ("- x\n+ y", 0), ("- 1\n+ 2", 2)]
)
def test_lines_that_do_not_occur_exactly_once_are_reported(edits, count):
    with pytest.raises(ValueError, match=f"^voxels: .* {count} times"):
        apply_edits(SOURCE + "\n1\n1", edits, "voxels")


def test_an_answer_may_be_an_edit_of_a_later_one(tmp_path, monkeypatch):
    folder = tmp_path / "solutions" / "stage1" / "01_lesson" / "answers"
    folder.mkdir(parents=True)
    text = """# %% wrong: minus
# like: a sum
# loses: adds
- return a + b
+ return a - b

# %% right: a sum
return a + b
"""
    (folder / "add.txt").write_text(text, "utf-8")
    (folder / "sub.txt").write_text(text.replace("like: a sum", "like: a product"), "utf-8")
    monkeypatch.setattr(kept_answers, "PROJECT", tmp_path)
    wrong, right = answers_to("add")
    assert (wrong.source, wrong.loses, wrong.right) == ("return a - b\n", ("adds",), False)
    assert (right.source, right.right) == ("return a + b\n", True)
    with pytest.raises(ValueError, match="sub, minus: there is no answer 'a product'"):
        answers_to("sub")


def test_an_unknown_note_is_reported_but_a_comment_in_the_answer_is_kept(tmp_path, monkeypatch):
    folder = tmp_path / "solutions" / "stage1" / "01_lesson" / "answers"
    folder.mkdir(parents=True)
    monkeypatch.setattr(kept_answers, "PROJECT", tmp_path)
    text = "# %% wrong: minus\n# loses: adds\n# say: 3\nreturn a - b\n"
    (folder / "add.txt").write_text(text, "utf-8")
    with pytest.raises(kept_answers.MalformedAnswers, match="add, minus: there is no note say"):
        answers_to("add")
    (folder / "add.txt").write_text(text.replace("# say", "\n# say"), "utf-8")
    (minus,) = answers_to("add")
    assert (minus.loses, minus.source) == (("adds",), "# say: 3\nreturn a - b\n")


@pytest.mark.parametrize("heading", ["# %% Wrong: a sum", "# %%wrong: a sum", "# %% wrong a sum"])
def test_a_misspelt_heading_is_reported_with_its_line(heading, tmp_path, monkeypatch):
    folder = tmp_path / "solutions" / "stage1" / "01_lesson" / "answers"
    folder.mkdir(parents=True)
    (folder / "add.txt").write_text(
        f"# %% right: a sum\nreturn a + b\n\n{heading}\npass\n", "utf-8"
    )
    monkeypatch.setattr(kept_answers, "PROJECT", tmp_path)
    with pytest.raises(kept_answers.MalformedAnswers) as caught:
        answers_to("add")
    assert str(caught.value).startswith(f"answers/add.txt, line 4: {heading!r} is not a heading.")
