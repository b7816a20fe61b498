"""`check` finds forbidden modules in the code that an answer uses, without running it."""

import builtins
import math
from types import SimpleNamespace

import numpy as np
import pytest

from utils.checks import check
from utils.checks.core import ChecksFailed
from utils.checks.static_analysis import functions_used, refused_modules

USES = {
    "import inside": "def f(x):\n    import sklearn.cluster\n    return x",
    "from inside": "def f(x):\n    from sklearn.cluster import DBSCAN\n    return DBSCAN()",
    "from a package inside": "def f(x):\n    from sklearn import cluster\n    return cluster",
    "a module": "import sklearn.cluster\ndef f(x):\n    return sklearn.cluster.DBSCAN(0.5)",
    "a module by another name": "import sklearn.cluster as c\ndef f(x):\n    return c.DBSCAN(0.5)",
    "a class": "from sklearn.cluster import DBSCAN\ndef f(x):\n    return DBSCAN(0.5)",
    "a compiled function": "from scipy.sparse.csgraph import connected_components as cc\n"
    "def f(x):\n    return cc(x)",
    "a helper": "import scipy.cluster.hierarchy as h\ndef g(x):\n    return h.fclusterdata(x, 1)\n"
    "def f(x):\n    return g(x)",
    "the student's own class": "import sklearn.cluster as c\nclass K:\n    def m(self):\n"
    "        return c.DBSCAN()\ndef f(x):\n    return K().m()",
    "a loop inside": "import sklearn.cluster as c\ndef f(x):\n    return [c.DBSCAN() for _ in x]",
}
FREE = {
    "scipy.spatial": "from scipy.spatial import cKDTree\ndef f(x):\n    return cKDTree(x)",
    "the rest of a package": "import scipy.sparse\ndef f(x):\n    return scipy.sparse.eye(3)",
    "imported and not used": "import sklearn.cluster\ndef f(x):\n    return x",
    "a word": "def f(x):\n    cluster = x\n    return cluster",
    "an attribute with the name of something imported": "from scipy.cluster import vq as tree\n"
    "def f(x):\n    return x.tree",
}


def function_in(source):
    namespace = {"__name__": "__main__"}
    exec(source, namespace)
    return namespace["f"]


@pytest.mark.parametrize("name", USES)
def test_forbidden_modules_are_found(name):
    assert refused_modules(function_in(USES[name]), "lesson_05")
    assert not refused_modules(function_in(USES[name]), "lesson_06")


@pytest.mark.parametrize("name", FREE)
def test_allowed_modules_are_accepted(name):
    assert not refused_modules(function_in(FREE[name]), "lesson_05")


def test_a_refused_module_hides_all_other_messages(capsys):
    function = function_in(USES["a class"])
    with pytest.raises(ChecksFailed):
        check(function, "euclidean_clustering")
    shown = capsys.readouterr().out
    assert "sklearn.cluster, which is not allowed" in shown and "The judge gives no points" in shown
    assert "[passed]" not in shown


def test_unusual_functions_are_searched_without_an_error():
    for odd in (len, print, np.sqrt, math.sqrt, dict, SimpleNamespace(), 7, builtins):
        assert refused_modules(odd, "lesson_05") == []
        assert functions_used(odd) == {}
