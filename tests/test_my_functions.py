"""Functions fetched out of notebooks, without the story around them."""

import json
import traceback

import matplotlib.pyplot as plt
import pytest

from grader.course.lessons import find_lesson
from grader.judging.runner import run_checks
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
    for text in ("", "{", "[]", '{"cells": 7}'):
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


def test_an_error_after_magics_names_the_line_of_its_author(here):
    cell = "\n%matplotlib inline\n!echo \\\n    two lines\n\ndef f(x):\n    return x / 0  # here"
    write(here / "a.ipynb", "def before(): pass", cell)
    with pytest.raises(ZeroDivisionError) as caught:
        load_my_functions("a.ipynb").f(1)
    assert "return x / 0  # here" in "".join(traceback.format_exception(caught.value))
    assert caught.traceback[-1].lineno + 1 == 7


# Each notebook defines `f` so that f() is 42, in cells parted by ---.
@pytest.mark.parametrize(
    "text",
    [
        "import numpy as np\nAXES = np.array([40, 2])\n---\ndef f(): return AXES.sum()",
        "def make_table(): return {n: STEP * n for n in range(22)}\n---\nSTEP = int('2')\n---\n"
        "TABLE = make_table()\n---\ndef f(): return TABLE[21]",
        "TABLE = list()\n---\nTABLE.append(42)\n---\ndef f(): return TABLE[0]",
        "TABLE = dict()\n---\ndef f(): return TABLE['a']\n---\nTABLE['a'] = 42",
        "TABLE = []\nfor n in range(43):\n    print(n)\n    TABLE.append(n)\n---\n"
        "def f(): return TABLE[-1]",
        "def f(): return g()\n---\ndef g(): return h()\n---\ndef h(): return K\n---\nK = int('42')",
        "def load(): return [1, 2, 42]\n---\ncloud = load()\nhigh = cloud[-1]\n---\n"
        "def f(): return high",
        "def f(): return math.floor(42.5)\n---\nimport math",
        "def f(): return int(path.basename('a/42'))\n---\nfrom os import path",
        "def twice(function): return lambda: 2 * function()\n---\n@twice\ndef f(): return 21",
        "import functools\n---\n@functools.lru_cache(maxsize=int('1'))\ndef f(): return 42",
        "K = int('2')\nclass Table:\n    rows = [k * K for k in range(22)]\n---\n"
        "def f(): return Table.rows[21]",
        "class Tree: pass\n---\ndef size(self): return 42\nTree.size = size\n---\n"
        "def f(): return Tree().size()",
        "from __future__ import annotations\n---\nfrom dataclasses import dataclass\n---\n"
        "@dataclass\nclass Node:\n    value: int\n    left: Node = None\n---\n"
        "def f(): return Node(42).value",
        "try:\n    import a_module_that_nobody_has as fast\nexcept ImportError:\n    fast = None\n"
        "---\ndef f(): return 1 if fast else 42",
        "f = None\n---\ng = lambda: 42\n---\nf = g",
        "def f(): return 1\n---\ndef f(): return 42\n---\nprint(f())",
        "N = 42\n%time pass\n---\ndef f():\n    %matplotlib inline\n    return N",
        "import sys\nN = 42\nsys.exit()\n---\ndef f(): return N",
        "import sys\nN = 42\nM = sys.exit()\n---\ndef f(): return N if 'M' not in globals() else M",
    ],
)
def test_functions_come_with_what_they_need(here, capfd, text):
    write(here / "a.ipynb", STORY, *text.split("\n---\n"), "largest = max(tell())\nprint(largest)")
    assert load_my_functions("a.ipynb").f() == 42
    assert capfd.readouterr().out == ""


def test_a_cloud_is_loaded_only_for_a_function_that_uses_it(here):
    load = "from pathlib import Path\ndef load():\n    Path('loaded').touch()\n    return [7]"
    write(here / "a.ipynb", load, "cloud = load()", "def f(cloud):\n    return cloud")
    assert load_my_functions("a.ipynb").f(1) == 1
    assert not (here / "loaded").exists()
    write(here / "b.ipynb", load, "cloud = load()\nprint(cloud)", "def f():\n    return cloud")
    assert load_my_functions("b.ipynb").f() == [7]
    assert (here / "loaded").exists()


def test_the_story_is_not_told_for_a_function_that_needs_its_pictures(here):
    figures = plt.get_fignums()
    write(
        here / "a.ipynb",
        "from pathlib import Path",
        "import matplotlib.pyplot as plt\nfrom utils import check, scenes",
        "def measure():\n    Path('measured').touch()\n    return 3",
        "figure, axes = plt.subplots()\ntimes = measure()\nLOW = -1.2",
        "def draw(points):\n    axes.plot(points, LOW, times)",
        "def lowest(show=False):\n    return axes if show else LOW",
        "street = list(scenes.highway(frames=1))",
        "def exercise():\n    return len(street)",
        "check(exercise)",
    )
    mine = load_my_functions("a.ipynb")
    assert sorted(vars(mine)) == ["draw", "exercise", "lowest", "measure"]
    assert mine.lowest() == -1.2
    with pytest.raises(NameError, match="axes"):
        mine.lowest(show=True)
    assert plt.get_fignums() == figures and not (here / "measured").exists()
    # The judge would make the street, too.
    assert mine.exercise() == 1


def test_a_needed_line_that_fails_is_told_by_the_call(here):
    write(here / "a.ipynb", "cloud = load_the_street()", "def f():\n    return cloud")
    with pytest.raises(NameError, match="'cloud' is not defined"):
        load_my_functions("a.ipynb").f()


def test_commands_to_the_notebook_are_not_given_again(here, monkeypatch):
    asked = []
    monkeypatch.setattr("builtins.get_ipython", lambda: asked.append(1), raising=False)
    write(
        here / "a.ipynb",
        "N = get_ipython().run_line_magic('who', '')\nget_ipython().system('ls')",
        "%matplotlib inline\nM = %who\ndef f():\n    %who\n    return N, M",
    )
    assert load_my_functions("a.ipynb").f() == (None, None)
    assert not asked


def test_annotations_are_what_their_notebook_makes_of_them(here):
    write(here / "a.ipynb", "def f(x: 1 + 1):\n    return x")
    assert load_my_functions("a.ipynb").f.__annotations__ == {"x": 2}


def test_notebooks_may_load_each_other(here):
    load = "from utils import load_my_functions\nother = load_my_functions('{}.ipynb')"
    write(here / "a.ipynb", load.format("b"), "def f():\n    return other.g()")
    write(here / "b.ipynb", load.format("a"), "def g():\n    return 5\ndef h():\n    other.f()")
    assert load_my_functions("a.ipynb").f() == 5
    assert load_my_functions("a.ipynb").f() == 5


def test_the_old_format_is_read(here):
    cell = {"cell_type": "code", "input": ["def f():\n", "    return 1"], "language": "python"}
    old = {"nbformat": 3, "worksheets": [{"cells": [cell]}]}
    (here / "a.ipynb").write_text(json.dumps(old))
    assert load_my_functions("a.ipynb").f() == 1


@pytest.mark.slow
def test_solved_lessons_give_their_exercises_in_silence(lesson, capfd):
    figures = plt.get_fignums()
    mine = load_my_functions(lesson.solved)
    assert set(lesson.names) <= set(vars(mine))
    assert not [name for name in lesson.names if hasattr(getattr(mine, name), "is_stub")]
    assert capfd.readouterr() == ("", "")
    assert plt.get_fignums() == figures


@pytest.mark.slow
def test_exercises_of_solved_lessons_work(lesson):
    outcomes = run_checks(lesson, load_my_functions(lesson.solved), 1)
    assert [
        (outcome.check.name, str(outcome.failure)) for outcome in outcomes if outcome.failure
    ] == []


def test_a_function_is_printed_with_all_that_it_calls(here, capfd):
    """What is printed runs by itself, and nothing runs before."""
    write(
        here / "06_low.ipynb",
        STORY,
        "from math import floor\nLEVEL = 2  # metres",
        "def cell_of(x):\n    # downwards\n    return floor(x / LEVEL)",
        "def unused():\n    return 0",
        "from functools import cache\n\n@cache\ndef cells(*xs):\n    return list(map(cell_of, xs))",
    )
    assert load_my_functions("06_low", paste="cells") is None
    printed = capfd.readouterr().out
    space = {}
    exec(printed, space)
    assert space["cells"](3.0, -1.0) == [1, -1]
    assert printed.startswith(
        "from math import floor\nfrom functools import cache\n\n\n# from 06_low"
    )
    assert "    # downwards\n" in printed and "unused" not in printed and "street" not in printed


def test_of_several_functions_what_they_share_is_printed_once(here, capfd):
    write(
        here / "a.ipynb",
        "def f():\n    return 1\ndef g():\n    return f()\ndef h():\n    return f()",
    )
    load_my_functions("a.ipynb", paste=["g", "h"])
    assert capfd.readouterr().out.count("def f():") == 1


def test_who_asks_to_print_what_is_not_there_is_told_what_is(here):
    write(here / "a.ipynb", "def voxel_grid():\n    return 1")
    with pytest.raises(LookupError, match="a does not define voxel. Did you mean voxel_grid"):
        load_my_functions("a.ipynb", paste="voxel")


@pytest.mark.parametrize("name", ["f", "g"])
def test_a_stub_is_not_printed(here, name):
    stub = "def f():\n    raise NotImplementedError()"
    write(here / "a.ipynb", stub, "def g():\n    return f()")
    with pytest.raises(NotImplementedError, match="f in a is still a stub"):
        load_my_functions("a.ipynb", paste=name)
