"""Functions fetched out of notebooks, without the story around them."""

import json
import traceback

import pytest

from grader.course.lessons import find_lesson
from utils.notebooks.my_functions import load_my_functions

STORY = """\
from utils import plots
import numpy as np
cloud = load_the_street("cloud.txt")
raise SystemExit("a story that must not be told")
"""


def write(path, *cells):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(
        json.dumps(
            {
                "nbformat": 4,
                "nbformat_minor": 5,
                "metadata": {},
                "cells": [
                    {"cell_type": "markdown", "metadata": {}, "source": "# not code", "id": "m"},
                    *(
                        {
                            "cell_type": "code",
                            "metadata": {},
                            "source": source,
                            "outputs": [],
                            "execution_count": None,
                            "id": str(number),
                        }
                        for number, source in enumerate(cells)
                    ),
                ],
            }
        )
    )
    return path


@pytest.fixture
def here(tmp_path, monkeypatch):
    folder = tmp_path / "stage4_realtime"
    folder.mkdir()
    monkeypatch.chdir(folder)
    return folder


def test_functions_come_without_the_story(here):
    write(
        here / "a.ipynb",
        STORY,
        "LEVEL, SIZE = -1.2, 2 ** 3\nOFFSET: float = -LEVEL",
        "def lift(z, by=OFFSET):\n    return np.add(z, by) * SIZE\nprint(lift(cloud))",
        "class Tree:\n    root = None\n",
        "double = lambda x: 2 * x",
    )
    mine = load_my_functions("a.ipynb")
    assert sorted(vars(mine)) == ["Tree", "double", "lift"]
    assert mine.lift(1.0) == pytest.approx(2.2 * 8)
    assert mine.double(4) == 8
    assert mine.Tree().root is None


def test_the_last_definition_counts_and_old_ones_use_it(here):
    write(
        here / "a.ipynb",
        "def f():\n    return helper()\n",
        "def helper():\n    return 1\n",
        "def helper():\n    return 2\n",
    )
    assert load_my_functions("a").f() == 2


def test_magics_and_broken_cells_are_passed_over(here):
    write(
        here / "a.ipynb",
        "%matplotlib inline\n!pip list\nx?\ndef f():\n    return 1",
        "%%time\ndef g():\n    return 2",
        "%%bash\necho hello",
        "%%html\n<b>",
        "def broken(:",
        "\0",
        "",
        "a = !ls\ndef h(): return 3",
    )
    mine = load_my_functions("a.ipynb")
    assert (mine.f(), mine.g()) == (1, 2)


def test_sliders_and_failing_lines_are_passed_over(here):
    write(
        here / "a.ipynb",
        "import a_module_that_nobody_has\nfrom ipywidgets import interact",
        "@interact(x=3)\ndef show(x):\n    raise SystemExit",
        "near = cloud[cloud > 3]\nfigure, axes = subplots()\ncloud[0] = 1\na.b = 2",
        "def needs(x):\n    return a_module_that_nobody_has.f(x)",
        "import functools\n@functools.cache\ndef kept():\n    return 5",
    )
    mine = load_my_functions("a.ipynb")
    assert not hasattr(mine, "show")
    assert mine.kept() == 5
    with pytest.raises(NameError, match="a_module_that_nobody_has"):
        mine.needs(1)


def test_stub_says_so_when_it_is_called(here):
    write(
        here / "a.ipynb",
        'def f(x):\n    """Do."""\n    # step\n    raise NotImplementedError',
        "def g(x):\n    raise NotImplementedError('later')",
        "def h(x):\n    if x:\n        raise NotImplementedError\n    return x",
    )
    mine = load_my_functions("a.ipynb")
    for stub in (mine.f, mine.g):
        with pytest.raises(NotImplementedError, match="in a.ipynb is still a stub"):
            stub(1)
        assert stub.is_stub
    assert mine.h(0) == 0


def test_found_in_the_usual_places(here):
    write(here.parent / "stage3_obstacles" / "b.ipynb", "def f():\n    return 'beside'")
    assert load_my_functions("b.ipynb").f() == "beside"
    write(here / "b.ipynb", "def f():\n    return 'here'")
    assert load_my_functions("b.ipynb").f() == "here"
    assert load_my_functions(here.parent / "stage3_obstacles" / "b.ipynb").f() == "beside"
    # The course's own notebooks are found from anywhere; untouched, they hold stubs.
    with pytest.raises(NotImplementedError, match="06_filter_ground.ipynb is still a stub"):
        load_my_functions("06_filter_ground.ipynb").filter_ground(None)


def test_what_is_missing_or_damaged_is_named(here):
    write(here / "09_filter_clusters.ipynb", "")
    with pytest.raises(FileNotFoundError, match="Did you mean 09_filter_clusters.ipynb"):
        load_my_functions("09_filter_cluster.ipynb")
    with pytest.raises(FileNotFoundError, match="give its path"):
        load_my_functions("zzz")
    for text in ("", "{", "[]", '{"cells": 7}', '{"cells": [{"a": 1}]}'):
        (here / "c.ipynb").write_text(text)
        with pytest.raises(ValueError, match="cannot be read as a notebook"):
            load_my_functions("c.ipynb")


def test_byte_order_mark_and_lists_of_lines(here):
    path = here / "a.ipynb"
    path.write_bytes(
        b"\xef\xbb\xbf"
        + json.dumps(
            {"cells": [{"cell_type": "code", "source": ["def f():\n", "    return 1"]}]}
        ).encode()
    )
    assert load_my_functions("a.ipynb").f() == 1


def test_a_solved_lesson_gives_its_functions():
    import numpy as np

    mine = load_my_functions(find_lesson("06_filter_ground").solved)
    cloud = np.array([[1.0, 0.0, -1.5], [1.0, 0.0, 0.5]])
    assert mine.filter_ground(cloud).tolist() == [[1.0, 0.0, 0.5]]
    assert len(mine.voxel_grid(cloud)) == 2
    assert not hasattr(mine, "show_level")


def test_a_failing_function_shows_its_own_line(here):
    write(here / "a.ipynb", "", "%%time\n\ndef f(x):\n    return x / 0  # here")
    with pytest.raises(ZeroDivisionError) as caught:
        load_my_functions("a.ipynb").f(1)
    assert "return x / 0  # here" in "".join(traceback.format_exception(caught.value))
    assert str(caught.traceback[-1].path) == "<a.ipynb, code cell 2>"
