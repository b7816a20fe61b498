"""Attempts to see tests, solutions, other submissions or other sandboxes."""

import glob
import os
import re
import secrets
import socket
import subprocess
import sys
from pathlib import Path

import pytest
from nbgrader.exchange.default import ExchangeSubmit

from grader.course.paths import PROJECT
from grader.sandbox import Limits, bubblewrap, users
from grader.sandbox.boundary import HIDDEN_SYSTEM_FOLDERS, SHOWN_PATHS
from grader.sandbox.failures import StudentError
from grader.sandbox.program import INSTALLED_PACKAGES
from grader.sandbox.usage import process_tree
from tests.attacks.attack import (
    SANDBOX,
    attack,
    function,
    needs_namespaces,
    outcome_of,
    with_attacks,
)

LIST_FILES = """
import os
def f(paths, installed):
    found = []
    for path in paths:
        for folder, folders, files in os.walk(path):
            folders[:] = [name for name in folders if os.path.join(folder, name) not in installed]
            for name in files:
                try:
                    with open(os.path.join(folder, name), "rb") as file:
                        file.read(1)
                    found.append(os.path.join(folder, name))
                except OSError:
                    pass
    return found
"""


@pytest.mark.slow
def test_no_secrets_are_in_the_project_or_home_folders():
    """Tests, solutions, the course's secret and other submissions cannot be found."""
    places = [str(PROJECT), str(Path.home()), "/home", "/root", "/srv", "/mnt", "/var", "/etc"]
    # Packages may be installed in the project, and Python itself in a home directory.
    installed = [sys.prefix, sys.base_prefix]
    seen = [Path(path) for path in outcome_of(LIST_FILES, places, installed, call_seconds=8.0)]
    ours = [path for path in seen if path.is_relative_to(PROJECT)]
    assert ours, "shown files exist"
    assert [path for path in ours if not any(map(path.is_relative_to, SHOWN_PATHS))] == []
    places = {path.relative_to(PROJECT).parts[:3] for path in SHOWN_PATHS if path.is_dir()}
    assert places == {("grader", "sandbox", "inside"), ("utils", "clouds"), ("utils", "notebooks")}
    assert {path.suffix for path in SHOWN_PATHS if path.is_relative_to(PROJECT / "data")} == {
        ".txt"
    }
    system = ("/etc/ld.so.cache", "/etc/alternatives")
    others = [path for path in seen if path not in ours]
    assert [path for path in others if not str(path).startswith(system)] == []


@with_attacks(
    "path",
    {
        "reads the hidden tests": "solutions/stage3_obstacles/06_filter_ground/hidden_tests.py",
        "reads the visible checks": "utils/checks/lesson_04/search.py",
        "reads the judge": "grader/judging/judge.py",
        "reads the sample generators": "extension/samples.py",
        "reads the simulator": "utils/simulator/scenes.py",
        "reads the box geometry": "utils/boxes/containment.py",
        "reads the plane geometry": "utils/geometry/planes.py",
        "reads the tree geometry": "utils/geometry/trees.py",
        "reads a solution": "solutions/stage2_clustering/04_kd_tree/lesson.py",
        "reads a solved notebook": "solutions/stage2_clustering/04_kd_tree.ipynb",
        "reads a released notebook": "notebooks/stage2_clustering/04_kd_tree.ipynb",
        "reads a kept answer": "solutions/stage2_clustering/04_kd_tree/answers/insert.txt",
        "reads the ground truth of the course's cloud": "data/cloud_truth.npz",
        "reads the project's Git history": ".git",
    },
)
def test_secret_files_cannot_be_opened(path):
    assert (PROJECT / path).exists()
    body = "try:\n    os.stat(path)\n    return True\nexcept OSError:\n    return False"
    source = "import os\n" + function(body, parameters="path")
    with attack(source) as student:
        assert student.f(str(PROJECT / "utils" / "clouds"))
        assert not student.f(str(PROJECT / path))


@needs_namespaces
def test_submissions_in_the_exchange_cannot_be_listed(monkeypatch, tmp_path):
    """By default, nbgrader's exchange is in a folder of the system that the sandbox shows."""
    root = ExchangeSubmit.root.default_value
    assert any(Path(root).is_relative_to(folder) for folder in HIDDEN_SYSTEM_FOLDERS)
    source = "import os\n" + function("return os.listdir(path)", parameters="path")
    folder = "/usr/share"  # a folder that every system has stands for the exchange
    assert outcome_of(source, folder)
    link, outside = tmp_path / "link", tmp_path / "outside"
    link.symlink_to(folder)
    outside.mkdir()
    for hidden in ((folder, "/usr/share/missing", str(outside)), (str(link),)):
        monkeypatch.setattr(bubblewrap, "HIDDEN_SYSTEM_FOLDERS", hidden)
        assert outcome_of(source, folder) == []


# Code that lists everything that can be imported inside the sandbox, and where it comes from.
LIST_IMPORTS = """
import importlib, importlib.util, os, pkgutil, sys
def f():
    import utils
    found = {}
    for module in pkgutil.iter_modules(None):
        found[module.name] = getattr(module.module_finder, "path", "")
    inner = [m.name for m in pkgutil.walk_packages(utils.__path__, "utils.")]
    return found, inner
"""


def test_only_packages_for_answers_can_be_imported():
    modules, ours = outcome_of(LIST_IMPORTS, packages=INSTALLED_PACKAGES, call_seconds=8.0)
    assert {"json", "numpy", "scipy", "matplotlib", "shapely", "sklearn", "wire"} <= set(modules)
    assert {"tests", "solutions", *UNLISTED_PACKAGES} & set(modules) == set()
    assert {name.split(".")[1] for name in ours} == {"clouds", "in_sandbox", "notebooks"}
    here = {path.stem for path in SHOWN_PATHS[0].glob("*.py")}
    project = {name for name, path in modules.items() if Path(path).is_relative_to(PROJECT)}
    project -= {name for name, path in modules.items() if Path(path).is_relative_to(sys.prefix)}
    assert project == here | {"utils"}


UNLISTED_PACKAGES = (
    "vtk",
    "vtkmodules",
    "pyvista",
    "skimage",
    "pooch",
    "rosbags",
    "nbgrader",
    "pandas",
)
UNLISTED_PACKAGES += ("pytest", "grader")
IMPORTER = """
import glob, importlib, importlib.machinery, importlib.util, os, sys, sysconfig
def everywhere():
    roots = {sys.prefix, sys.base_prefix, "/usr", "/usr/local", *sys.path}
    roots |= {sysconfig.get_path("purelib"), sysconfig.get_path("platlib"), PREFIX}
    for root in list(roots):
        for pattern in ("lib*/python*/site-packages", "lib*/python*/dist-packages", "lib*/pypy*"):
            roots |= set(glob.glob(os.path.join(root, pattern)))
    return sorted(roots)
def f(names, how):
    if how == "removes the importer that refuses packages":
        # Debian's Python has modules built in that others have as files.
        machinery = importlib.machinery
        sys.meta_path[:] = [
            machinery.BuiltinImporter, machinery.FrozenImporter, machinery.PathFinder
        ]
    if how == "adds every package folder to the path":
        sys.path[:0] = everywhere()
    found = []
    for name in names:
        if how == "loads the package from its file":
            for root in everywhere():
                places = (f"{root}/{name}/__init__.py", f"{root}/{name}.py")
                for path in filter(os.path.exists, places):
                    spec = importlib.util.spec_from_file_location(name, path)
                    module = importlib.util.module_from_spec(spec)
                    sys.modules[name] = module
                    spec.loader.exec_module(module)
                    found.append(name)
            continue
        try:
            importlib.import_module(name)
            found.append(name)
        except ImportError:
            pass
    return found
"""


@pytest.mark.parametrize(
    "how",
    [
        "imports the package",
        "adds every package folder to the path",
        "loads the package from its file",
        "removes the importer that refuses packages",
    ],
)
def test_unlisted_packages_cannot_be_imported(how):
    source = f"PREFIX = {sys.prefix!r}\n" + IMPORTER
    with attack(source, call_seconds=8.0) as student:
        assert "scipy" in student.f(["scipy"], how if "file" not in how else "imports the package")
        assert student.f(list(UNLISTED_PACKAGES), how) == []


def test_shared_libraries_of_unlisted_packages_cannot_be_loaded():
    """Code that loads shared libraries without Python's import does not find VTK or PCL."""
    source = """
import ctypes, os
def f(roots):
    found = []
    for root in roots:
        for folder, folders, files in os.walk(root):
            found += [name for name in files
                      if ".so" in name and any(w in name.lower() for w in ("vtk", "pcl"))]
    return found
"""
    # In /usr, only Python's folders; the system's own libraries are visible on purpose.
    roots = [sys.prefix]
    for root in (sys.base_prefix, "/usr", "/usr/local"):
        roots += glob.glob(f"{root}/lib/python3*")
    assert outcome_of(source, roots, call_seconds=8.0) == []


def test_files_of_a_forbidden_library_are_not_visible():
    """Even without the importer that refuses the library, there are no files to import."""
    source = """
import glob, importlib, subprocess, sys
def f():
    sys.meta_path[:] = [finder for finder in sys.meta_path
                        if type(finder).__name__ != "Forbidden"]
    found = []
    for folder in glob.glob(f"{sys.base_prefix}/lib/python*/site-packages") + sys.path:
        found += glob.glob(folder + "/scipy/cluster/*")
    try:
        import scipy.cluster.hierarchy
        found.append("imported")
    except ImportError:
        pass
    return found
"""
    with attack(source, forbidden=("scipy.cluster",), call_seconds=5.0) as student:
        assert student.f() == []
    with attack(
        "import scipy.cluster.hierarchy as h\ndef f(): return h", forbidden=("scipy.cluster",)
    ) as student:
        with pytest.raises(StudentError, match="not allowed in this lesson"):
            student.f()
        assert any("is not allowed" in problem for problem in student.problems)


@needs_namespaces
def test_processes_descriptors_and_variables_of_the_grader_are_hidden(monkeypatch):
    monkeypatch.setenv("SECRET_TOKEN", "xyzzy")
    source = """
import os
def f():
    texts = [str(dict(os.environ))]
    for number in os.listdir("/proc"):
        if number.isdigit():
            for name in ("cmdline", "environ"):
                try:
                    texts.append(open(f"/proc/{number}/{name}").read())
                except OSError:
                    pass
    links = [os.readlink(f"/proc/self/fd/{n}") for n in os.listdir("/proc/self/fd")
             if os.path.lexists(f"/proc/self/fd/{n}")]
    return texts, links, [int(n) for n in os.listdir("/proc") if n.isdigit()]
"""
    with open(__file__):
        texts, links, processes = outcome_of(source)
    assert "xyzzy" not in "".join(texts) and "pytest" not in "".join(texts)
    assert len(processes) == 2 and 1 in processes, "only bubblewrap and the worker"
    assert all(link == "/dev/null" or link.startswith("pipe:") for link in links)
    assert len({link for link in links if link.startswith("pipe:")}) == 2


def test_open_files_of_the_grader_are_out_of_reach():
    """Code cannot reach the files through a process's root in /proc or the parent's memory."""
    source = """
import os
def f():
    reached = []
    for path in ("/proc/1/root/root", "/proc/1/cwd", "/proc/1/mem", "/proc/kcore", "/dev/mem",
                 "/proc/1/root/home", "/dev/kmsg", "/sys/kernel", "/run", "/boot"):
        try:
            os.listdir(path) if os.path.isdir(path) else open(path, "rb").read(1)
            reached.append(path)
        except OSError:
            pass
    return reached
"""
    assert outcome_of(source) == []


def test_no_network_is_reachable():
    """Code cannot reach a server on this machine or elsewhere, or open unusual sockets."""
    with socket.socket() as server:
        server.bind(("127.0.0.1", 0))
        server.listen()
        source = f"""
import socket
def f():
    reached = []
    for address in (("127.0.0.1", {server.getsockname()[1]}), ("1.1.1.1", 53)):
        try:
            reached.append(socket.create_connection(address, timeout=0.3) and address)
        except OSError:
            pass
    for family in (16, 38, 40):  # netlink, the kernel's ciphers, the virtual machine's host
        try:
            reached.append(socket.socket(family, socket.SOCK_STREAM) and family)
        except OSError:
            pass
    return reached
"""
        assert outcome_of(source, call_seconds=4.0) == []


# ---- Two sandboxes of one user ------------------------------------------------------------


HOST = """
import os, socket, threading
KEPT = []
def f(name):
    for folder in ("/tmp", "/dev/shm"):
        with open(f"{folder}/{name}", "w") as file:
            file.write(name)
    server = socket.socket(socket.AF_UNIX)
    server.bind("\\0" + name)
    server.listen()
    there = socket.socket()
    there.bind(("127.0.0.1", 47123))
    there.listen()
    KEPT.extend([server, there])
    return "here"
"""
GUEST = """
import os, socket
def f(name, processes):
    met = []
    for path in (f"/tmp/{name}", f"/dev/shm/{name}"):
        if os.path.exists(path):
            met.append(path)
    for family, address in ((socket.AF_UNIX, "\\0" + name), (socket.AF_INET, ("127.0.0.1", 47123))):
        try:
            socket.socket(family).connect(address)
            met.append(str(family))
        except OSError:
            pass
    for process in processes:
        if process > 2 and os.path.exists(f"/proc/{process}"):
            met.append(process)
        try:
            process > 2 and os.kill(process, 9)
            met += [process] if process > 2 else []
        except OSError:
            pass
    return met
"""


@needs_namespaces
def test_two_sandboxes_of_one_user_are_separate():
    """The sandboxes do not share files, abstract sockets, ports, process IDs or signals."""
    name = secrets.token_hex(4)
    with attack(HOST) as first, attack(GUEST) as second:
        assert first.f(name) == "here"
        numbers = [number for number in process_tree(first._worker.process.pid) if number > 2]
        assert len(numbers) >= 2
        assert second.f(name, numbers) == []
        with pytest.raises(StudentError, match="in use|OSError|exists"):
            first.f(name)  # still running and holding its port


@needs_namespaces
def test_a_submission_leaves_nothing_behind_for_the_next_submission():
    """No files, modules, variables or processes remain when the judge continues."""
    leave = """
import builtins, os, sys
def f():
    for folder in ("/tmp", "/dev/shm"):
        open(folder + "/left", "w").close()
    os.environ["LEFT"] = "1"
    sys.modules["left"] = builtins.left = os
    if os.fork() == 0:
        import time
        time.sleep(60)
    return 1
"""
    find = """
import builtins, os, sys
def f():
    found = [folder for folder in ("/tmp", "/dev/shm") if "left" in os.listdir(folder)]
    found += ["LEFT"] * ("LEFT" in os.environ) + ["module"] * ("left" in sys.modules)
    found += ["builtin"] * hasattr(builtins, "left")
    return found + [n for n in os.listdir("/proc") if n.isdigit() and int(n) > 2]
"""
    assert outcome_of(leave) == 1
    assert outcome_of(find) == []


# ---- Possible locations of the project and Python -------------------------------------------


@pytest.fixture
def list_files_of(tmp_path, monkeypatch):
    """Return a function that creates a project and Python and lists the visible files."""

    def list_files(project, prefix, base, system=()):
        project, prefix, base = (tmp_path / place for place in (project, prefix, base))
        for path in (
            "solutions/stage1/01_secret/hidden_tests.py",
            "grader/sandbox/inside/worker.py",
            ".course_seed",
        ):
            (project / path).parent.mkdir(parents=True, exist_ok=True)
            (project / path).write_text("")
        installed = prefix / "lib" / "python3.11" / "site-packages"
        for package in ("wanted", "unwanted"):
            (installed / package).mkdir(parents=True)
            (installed / package / "module.py").write_text("")
        (base / "lib" / "standard.py").parent.mkdir(parents=True, exist_ok=True)
        (base / "lib" / "standard.py").write_text("")
        for name, value in {
            "PROJECT": project,
            "SHOWN_PATHS": (project / "grader" / "sandbox" / "inside",),
            "PREFIX": str(prefix),
            "BASE_PREFIX": str(base),
            "SYSTEM_FOLDERS": (
                *bubblewrap.SYSTEM_FOLDERS,
                *(str(tmp_path / place) for place in system),
            ),
            "PYTHON": str(base / "lib" / "standard.py"),
            "files_of_packages": lambda names: (installed / "wanted",),
            "folders_of_packages": lambda: (installed,),
        }.items():
            monkeypatch.setattr(bubblewrap, name, value)
        options = bubblewrap._options_for_files((), ())
        ran = subprocess.run(
            [
                *bubblewrap._sandbox_command(Limits()),
                *options,
                "--",
                "/usr/bin/find",
                str(tmp_path),
            ],
            capture_output=True,
            text=True,
        )
        return {path for path in ran.stdout.split("\n") if path.endswith((".py", "seed"))}, ran

    return list_files


@with_attacks(
    "project, prefix, base, system",
    {
        "an environment in the project's root folder": ("course", "course", "python", ()),
        "an environment in a project subfolder": ("course", "course/.venv", "python", ()),
        "a project inside Python's folder": ("python/course", "venv", "python", ()),
        "a project in a system folder": ("usr/src/course", "venv", "python", ("usr",)),
        "packages in a system folder": ("course", "usr", "usr", ("usr",)),
        "a project inside the environment": ("venv/course", "venv", "python", ()),
    },
)
def test_the_location_of_project_and_python_does_not_matter(
    project, prefix, base, system, list_files_of, tmp_path
):
    seen, ran = list_files_of(project, prefix, base, system)
    assert str(tmp_path / project / "grader" / "sandbox" / "inside" / "worker.py") in seen, ran
    assert any(re.search(r"/wanted/module.py", path) for path in seen), ran
    assert [path for path in seen if path.endswith(("secret.py", "seed"))] == []
    assert [path for path in seen if "unwanted" in path] == []


def test_the_sandbox_of_an_ordinary_user_also_confines_root(monkeypatch):
    """Root cannot leave the sandbox either, if it is treated as an ordinary user."""
    monkeypatch.setattr(users, "is_root", lambda: False)
    identity = {"user": 65534, "group": 65534, "extra_groups": []} if os.geteuid() == 0 else {}
    script = (
        "cd /tmp && echo x > y && cat y; grep CapEff /proc/self/status; "
        "unshare --user true && echo gained; echo x > /usr/x && echo gained; "
        f"test -e '{PROJECT}/grader' && echo gained; ls -A / /root /home; true"
    )
    ran = subprocess.run(
        [
            *bubblewrap._sandbox_command(Limits()),
            "--remount-ro",
            "/",
            "--",
            "/bin/sh",
            "-c",
            script,
        ],
        capture_output=True,
        text=True,
        cwd="/",
        **identity,
    )
    assert ran.stdout.startswith("x\nCapEff:\t0000000000000000\n"), ran.stderr
    assert "gained" not in ran.stdout
    assert "No such file" in ran.stderr


def test_a_worker_can_start_in_the_attacked_sandbox():
    """The worker starts; if no code ran, the tests above would pass for the wrong reason."""
    worker = SANDBOX.start(Limits())
    assert worker.stop() in (-9, 137)
