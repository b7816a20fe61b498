"""Functions are loaded from notebooks without running the rest of the notebook."""

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
raise SystemExit("this line must not run")
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
def folder(tmp_path, monkeypatch):
    folder = tmp_path / "stage4_realtime"
    folder.mkdir()
    monkeypatch.chdir(folder)
    return folder


def test_functions_are_loaded_without_running_the_notebook(folder):
    write(
        folder / "a.ipynb",
        STORY,
        "LEVEL, SIZE = -1.2, 2 ** 3\nOFFSET: float = -LEVEL",
        "def lift(z, by=OFFSET):\n    return np.add(z, by) * SIZE\nprint(lift(cloud))",
        "class Tree:\n    root = None\n",
        "double = lambda x: 2 * x",
    )
    functions = load_my_functions("a.ipynb")
    assert sorted(vars(functions)) == ["Tree", "double", "lift"]
    assert functions.lift(1.0) == pytest.approx(2.2 * 8)
    assert functions.double(4) == 8
    assert functions.Tree().root is None


def test_the_last_definition_counts_for_all_callers(folder):
    write(
        folder / "a.ipynb",
        "def f():\n    return helper()\n",
        "def helper():\n    return 1\n",
        "def helper():\n    return 2\n",
    )
    assert load_my_functions("a").f() == 2


def test_magics_and_broken_cells_are_skipped(folder):
    write(
        folder / "a.ipynb",
        "%matplotlib inline\n!pip list\nx?\ndef f():\n    return 1",
        "%%time\ndef g():\n    return 2",
        "%%bash\necho hello",
        "%%html\n<b>",
        "def broken(:",
        "\0",
        "",
        "a = !ls\ndef h(): return 3",
    )
    functions = load_my_functions("a.ipynb")
    assert (functions.f(), functions.g()) == (1, 2)


def test_sliders_and_failing_lines_are_skipped(folder):
    write(
        folder / "a.ipynb",
        "import a_module_that_nobody_has\nfrom ipywidgets import interact",
        "@interact(x=3)\ndef show(x):\n    raise SystemExit",
        "near = cloud[cloud > 3]\nfigure, axes = subplots()\ncloud[0] = 1\na.b = 2",
        "def needs(x):\n    return a_module_that_nobody_has.f(x)",
        "import functools\n@functools.cache\ndef kept():\n    return 5",
    )
    functions = load_my_functions("a.ipynb")
    assert not hasattr(functions, "show")
    assert functions.kept() == 5
    with pytest.raises(NameError, match="a_module_that_nobody_has"):
        functions.needs(1)


def test_drawings_to_change_by_hand_are_left_out(folder, monkeypatch):
    shown = []
    monkeypatch.setattr("utils.by_hand.drag_points", lambda *about, **more: shown.append(about))
    write(
        folder / "a.ipynb",
        "from utils.by_hand import Drawing, drag_points",
        "def level(points):\n    return Drawing(str(f(points)))",
        "drag_points(level, [[0, 0]], limits=(0, 1, 0, 1))",
        "def f(points):\n    return len(points)",
    )
    functions = load_my_functions("a.ipynb")
    assert functions.f([1, 2]) == 2 and functions.level([1]).title == "1"
    assert not shown


def test_a_stub_raises_when_it_is_called(folder):
    write(
        folder / "a.ipynb",
        'def f(x):\n    """Do."""\n    # step\n    raise NotImplementedError',
        "def g(x):\n    raise NotImplementedError('later')",
        "def h(x):\n    if x:\n        raise NotImplementedError\n    return x",
    )
    functions = load_my_functions("a.ipynb")
    for stub in (functions.f, functions.g):
        with pytest.raises(NotImplementedError, match="in a.ipynb is still a stub"):
            stub(1)
        assert stub.is_stub
    assert functions.h(0) == 0


def test_notebooks_are_found_in_the_usual_folders(folder):
    write(folder.parent / "stage3_obstacles" / "b.ipynb", "def f():\n    return 'neighbour'")
    assert load_my_functions("b.ipynb").f() == "neighbour"
    write(folder / "b.ipynb", "def f():\n    return 'here'")
    assert load_my_functions("b.ipynb").f() == "here"
    assert load_my_functions(folder.parent / "stage3_obstacles" / "b.ipynb").f() == "neighbour"
    # The course's notebooks, which are found from any folder, contain stubs.
    with pytest.raises(NotImplementedError, match="06_filter_ground.ipynb is still a stub"):
        load_my_functions("06_filter_ground.ipynb").filter_ground(None)


def test_errors_name_missing_and_damaged_notebooks(folder):
    write(folder / "09_filter_clusters.ipynb", "")
    with pytest.raises(FileNotFoundError, match="Did you mean 09_filter_clusters.ipynb"):
        load_my_functions("09_filter_cluster.ipynb")
    with pytest.raises(FileNotFoundError, match="give its path") as caught:
        load_my_functions("nothing.ipynb")
    assert "Did you mean" not in str(caught.value), "no name is similar"
    (folder / "README.md").write_text("# A text")
    with pytest.raises(ValueError, match=r"README\.md is not a notebook. Name a file that ends in"):
        load_my_functions("README.md")
    for text in ("", "{", "[]", '{"cells": 7}'):
        (folder / "c.ipynb").write_text(text)
        with pytest.raises(ValueError, match="cannot be read as a notebook"):
            load_my_functions("c.ipynb")


def test_notebooks_with_a_byte_order_mark_or_lists_of_lines_are_read(folder):
    path = folder / "a.ipynb"
    path.write_bytes(
        b"\xef\xbb\xbf"
        + json.dumps(
            {"cells": [{"cell_type": "code", "source": ["def f():\n", "    return 1"]}]}
        ).encode()
    )
    assert load_my_functions("a.ipynb").f() == 1


def test_functions_of_a_solved_lesson_are_loaded():
    import numpy as np

    functions = load_my_functions(find_lesson("06_filter_ground").solved)
    cloud = np.array([[1.0, 0.0, -1.5], [1.0, 0.0, 0.5]])
    assert functions.filter_ground(cloud).tolist() == [[1.0, 0.0, 0.5]]
    assert len(functions.voxel_grid(cloud)) == 2
    assert not hasattr(functions, "show_level")


def test_a_failing_function_shows_its_own_line(folder):
    write(folder / "a.ipynb", "", "%%time\n\ndef f(x):\n    return x / 0  # here")
    with pytest.raises(ZeroDivisionError) as caught:
        load_my_functions("a.ipynb").f(1)
    assert "return x / 0  # here" in "".join(traceback.format_exception(caught.value))
    assert str(caught.traceback[-1].path) == "<a.ipynb, code cell 2>"


def test_an_error_after_magics_has_the_right_line_number(folder):
    cell = "\n%matplotlib inline\n!echo \\\n    two lines\n\ndef f(x):\n    return x / 0  # here"
    write(folder / "a.ipynb", "def before(): pass", cell)
    with pytest.raises(ZeroDivisionError) as caught:
        load_my_functions("a.ipynb").f(1)
    assert "return x / 0  # here" in "".join(traceback.format_exception(caught.value))
    assert caught.traceback[-1].lineno + 1 == 7


# Notebooks in which f() returns 42. Lines of three dashes separate the cells.
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
def test_functions_are_loaded_with_their_dependencies(folder, capfd, text):
    write(
        folder / "a.ipynb", STORY, *text.split("\n---\n"), "largest = max(tell())\nprint(largest)"
    )
    assert load_my_functions("a.ipynb").f() == 42
    assert capfd.readouterr().out == ""


def test_a_cloud_is_loaded_only_for_a_function_that_uses_it(folder):
    load = "from pathlib import Path\ndef load():\n    Path('loaded').touch()\n    return [7]"
    write(folder / "a.ipynb", load, "cloud = load()", "def f(cloud):\n    return cloud")
    assert load_my_functions("a.ipynb").f(1) == 1
    assert not (folder / "loaded").exists()
    write(folder / "b.ipynb", load, "cloud = load()\nprint(cloud)", "def f():\n    return cloud")
    assert load_my_functions("b.ipynb").f() == [7]
    assert (folder / "loaded").exists()


def test_a_function_that_uses_figures_does_not_draw_them(folder):
    figures = plt.get_fignums()
    write(
        folder / "a.ipynb",
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
    functions = load_my_functions("a.ipynb")
    assert sorted(vars(functions)) == ["draw", "exercise", "lowest", "measure"]
    assert functions.lowest() == -1.2
    with pytest.raises(NameError, match="axes"):
        functions.lowest(show=True)
    assert plt.get_fignums() == figures and not (folder / "measured").exists()
    # The judge also runs the statements that compute the street, which this function needs.
    assert functions.exercise() == 1


def test_a_needed_line_that_fails_raises_in_the_call(folder):
    write(folder / "a.ipynb", "cloud = load_the_street()", "def f():\n    return cloud")
    with pytest.raises(NameError, match="'cloud' is not defined"):
        load_my_functions("a.ipynb").f()


def test_commands_of_the_notebook_are_not_run(folder, monkeypatch):
    calls = []
    monkeypatch.setattr("builtins.get_ipython", lambda: calls.append(1), raising=False)
    write(
        folder / "a.ipynb",
        "N = get_ipython().run_line_magic('who', '')\nget_ipython().system('ls')",
        "%matplotlib inline\nM = %who\ndef f():\n    %who\n    return N, M",
    )
    assert load_my_functions("a.ipynb").f() == (None, None)
    assert not calls


def test_annotations_are_evaluated_as_in_the_notebook(folder):
    write(folder / "a.ipynb", "def f(x: 1 + 1):\n    return x")
    assert load_my_functions("a.ipynb").f.__annotations__ == {"x": 2}


def test_notebooks_may_load_each_other(folder):
    load = "from utils import load_my_functions\nother = load_my_functions('{}.ipynb')"
    write(folder / "a.ipynb", load.format("b"), "def f():\n    return other.g()")
    write(folder / "b.ipynb", load.format("a"), "def g():\n    return 5\ndef h():\n    other.f()")
    assert load_my_functions("a.ipynb").f() == 5
    assert load_my_functions("a.ipynb").f() == 5


def test_the_old_format_is_read(folder):
    cell = {"cell_type": "code", "input": ["def f():\n", "    return 1"], "language": "python"}
    old = {"nbformat": 3, "worksheets": [{"cells": [cell]}]}
    (folder / "a.ipynb").write_text(json.dumps(old))
    assert load_my_functions("a.ipynb").f() == 1


@pytest.mark.slow
def test_exercises_of_solved_lessons_load_without_output(lesson, capfd):
    figures = plt.get_fignums()
    functions = load_my_functions(lesson.solved)
    assert set(lesson.names) <= set(vars(functions))
    assert not [name for name in lesson.names if hasattr(getattr(functions, name), "is_stub")]
    assert capfd.readouterr() == ("", "")
    assert plt.get_fignums() == figures


@pytest.mark.slow
def test_exercises_of_solved_lessons_work(lesson):
    outcomes = run_checks(lesson, load_my_functions(lesson.solved), 1)
    assert [
        (outcome.check.name, str(outcome.failure)) for outcome in outcomes if outcome.failure
    ] == []


def test_a_function_is_printed_with_everything_that_it_calls(folder, capfd):
    """The printed code runs on its own, and printing it does not run the notebook."""
    write(
        folder / "06_low.ipynb",
        STORY,
        "import sys\nfrom math import floor\nsys.path.insert(0, '..')\nLEVEL = 2  # metres",
        "def cell_of(x):\n    # downwards\n    return floor(x / LEVEL)",
        "def unused():\n    return 0",
        "from functools import cache\n\n@cache\ndef cells(*xs):\n    return list(map(cell_of, xs))",
    )
    assert load_my_functions("06_low", paste="cells") is None
    printed = capfd.readouterr().out
    namespace = {}
    exec(printed, namespace)
    assert namespace["cells"](3.0, -1.0) == [1, -1]
    assert printed.startswith(
        "from math import floor\nfrom functools import cache\n\n\n# from 06_low"
    )
    assert "    # downwards\n" in printed and "unused" not in printed and "street" not in printed


def test_a_shared_helper_is_printed_once(folder, capfd):
    write(
        folder / "a.ipynb",
        "def f():\n    return 1\ndef g():\n    return f()\ndef h():\n    return f()",
    )
    load_my_functions("a.ipynb", paste=["g", "h"])
    assert capfd.readouterr().out.count("def f():") == 1


def test_the_error_about_an_unknown_function_suggests_another(folder):
    write(folder / "a.ipynb", "def voxel_grid():\n    return 1")
    with pytest.raises(LookupError, match="a does not define voxel. Did you mean voxel_grid"):
        load_my_functions("a.ipynb", paste="voxel")


@pytest.mark.parametrize("name", ["f", "g"])
def test_a_stub_is_not_printed(folder, name):
    stub = "def f():\n    raise NotImplementedError()"
    write(folder / "a.ipynb", stub, "def g():\n    return f()")
    with pytest.raises(NotImplementedError, match="f in a is still a stub"):
        load_my_functions("a.ipynb", paste=name)
