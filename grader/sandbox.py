"""Start the process in which a student's code runs, walled off from everything else.

Two tiers. *bubblewrap* gives it no network, a read-only system without this project, a small
private /tmp, its own process table and no privileges. *process* is an ordinary process with
resource limits: for a student's own machine and for the demo, never for strangers' code.
"""

import contextlib
import functools
import itertools
import os
import secrets
import shutil
import signal
import subprocess
import sys
import threading
import time
from dataclasses import dataclass, field
from pathlib import Path

from grader.inside import wire
from grader.paths import PROJECT

INSIDE = Path(__file__).resolve().parent / "inside"
TIERS = ("bubblewrap", "process")
MEBIBYTE = 2**20
SECONDS_BETWEEN_LOOKS = 0.2

UNPROTECTED = (
    "WARNING: no sandbox (--sandbox process). Submitted code runs as you: it can read and delete "
    "your files, use the network and look at other submissions. Only for code you trust."
)


class SandboxUnavailable(Exception):
    """This machine cannot build the sandbox that was asked for."""


@dataclass(frozen=True)
class Limits:
    """What a student's process may use.

    Seconds are of wall-clock time: for the notebook's own cells, for one call, and for
    everything together. Bytes of `memory` are for one process, of `total_memory` for it and
    all it starts. `restarts` is how often the process may die or hang before the rest
    of its tests are given up.
    """

    start_seconds: float = 30.0
    call_seconds: float = 10.0
    total_seconds: float = 180.0
    restarts: int = 3
    memory: int = 3072 * MEBIBYTE
    total_memory: int = 6144 * MEBIBYTE
    processes: int = 48
    file_size: int = 32 * MEBIBYTE
    temporary_space: int = 64 * MEBIBYTE

    def resources(self, tier):
        """Resource limits by the names of Python's `resource` module."""
        limits = {
            "RLIMIT_AS": self.memory,
            "RLIMIT_CPU": int(2 * self.total_seconds),
            "RLIMIT_FSIZE": self.file_size,
            "RLIMIT_NOFILE": 128,
            "RLIMIT_CORE": 0,
        }
        if tier == "bubblewrap":
            # Outside a sandbox this would count all the processes of whoever grades.
            limits["RLIMIT_NPROC"] = self.processes
        return limits


@dataclass
class Worker:
    """A running worker and the two ends of its pipes."""

    process: subprocess.Popen
    read_end: int
    write_end: int
    _stopped: threading.Event = field(default_factory=threading.Event)

    def stop(self):
        """Kill the worker and all it started; return its exit code."""
        self._stopped.set()
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.process.pid, signal.SIGKILL)
        code = self.process.wait()
        self.process.stderr.close()
        for end in (self.read_end, self.write_end):
            os.close(end)
        return code

    def watch_memory(self, limit):
        """Kill the worker when all its processes together take more than `limit` bytes."""
        def watch():
            while not self._stopped.wait(SECONDS_BETWEEN_LOOKS):
                if memory_of_tree(self.process.pid) > limit:
                    self.process.kill()
                    return
        threading.Thread(target=watch, daemon=True).start()


def memory_of_tree(pid):
    """Bytes that a process and its descendants have mapped.

    Mapped and not used, because used memory can hide: pages shared by two processes may be
    in the page tables of neither.

    Parameters
    ----------
    pid : int

    Returns
    -------
    int
        0 where there is no such process or no /proc.
    """
    try:
        pages = int(Path(f"/proc/{pid}/statm").read_text().split()[0])
        children = [child for path in Path(f"/proc/{pid}/task").glob("*/children")
                    for child in path.read_text().split()]
    except OSError:  # it has just ended
        return 0
    return pages * os.sysconf("SC_PAGE_SIZE") + sum(map(memory_of_tree, children))


def choose_tier(wish="auto"):
    """The tier to use.

    Parameters
    ----------
    wish : {"auto", "bubblewrap", "process"}

    Returns
    -------
    str
        "bubblewrap" or "process"; "auto" never falls back to "process".

    Raises
    ------
    SandboxUnavailable
        With the command that would mend it.
    """
    if wish == "process":
        return wish
    complaint = _bubblewrap_complaint()
    if complaint:
        raise SandboxUnavailable(
            f"{complaint} Student code is only run inside a sandbox. To grade code that you "
            "trust without one, add: --sandbox process")
    return "bubblewrap"


@functools.cache
def _bubblewrap_complaint():
    """Why bubblewrap does not work here; empty where it does."""
    if not sys.platform.startswith("linux"):
        return "The sandbox needs Linux (on Windows: WSL 2; on a Mac: a Linux container)."
    if not shutil.which("bwrap"):
        return ("bubblewrap is not installed. Install it with: "
                "sudo apt-get install bubblewrap  (Fedora: sudo dnf install bubblewrap).")
    trial = subprocess.run([*_walls(Limits()), "/bin/sh", "-c", "true"],
                           capture_output=True, text=True)
    if trial.returncode:
        return (f"bubblewrap is installed but cannot build a sandbox here: {trial.stderr.strip()}."
                " Inside a container, allow user namespaces (docker run --privileged); on "
                "Ubuntu 24.04: sudo sysctl -w kernel.apparmor_restrict_unprivileged_userns=0.")
    return ""


def start_worker(tier, limits, forbidden=()):
    """Start a worker; nothing of the student is in it yet.

    Parameters
    ----------
    tier : {"bubblewrap", "process"}
    limits : Limits
    forbidden : iterable of str
        Dotted names of modules that shall not exist inside.

    Returns
    -------
    Worker

    Raises
    ------
    SandboxUnavailable
        If the worker does not report: the fault is then ours, not the student's.
    """
    their_read, our_write = os.pipe()
    our_read, their_write = os.pipe()
    for end in (our_read, our_write):
        os.set_blocking(end, False)
    python = [sys.executable, "-I", "-B", str(INSIDE / "worker.py"),
              str(their_read), str(their_write)]
    if tier == "bubblewrap":
        command = [*_walls(limits), *_windows(forbidden), "--remount-ro", "/", "--", *python]
    else:
        command = python
    try:
        process = subprocess.Popen(
            command, pass_fds=(their_read, their_write), env=_environment(tier),
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
            start_new_session=True)
    finally:
        os.close(their_read)
        os.close(their_write)
    worker = Worker(process, our_read, our_write)
    rules = {"user": _unused_user() if tier == "bubblewrap" and _is_root() else None,
             "limits": limits.resources(tier), "forbidden": list(forbidden),
             "search_path": [str(PROJECT)]}
    try:
        deadline = time.monotonic() + 60
        wire.send(our_write, rules, deadline)
        wire.receive(our_read, deadline)
    except (wire.WireClosed, wire.WireTimeout):
        process.kill()
        complaint = process.stderr.read().decode(errors="replace").strip()[-500:]
        worker.stop()
        raise SandboxUnavailable(f"The sandbox could not start Python: {complaint}") from None
    worker.watch_memory(limits.total_memory)
    return worker


def _is_root():
    """True for a root who can become other users; in some containers it is the only one."""
    return os.geteuid() == 0 and _number_of_users() >= 2**16


def _unused_user():
    """A user of its own for each worker: limits are counted by user and do not bind root."""
    count = _number_of_users()
    return count // 2 + secrets.randbelow(count // 2 - 2)


def _number_of_users():
    first, _, count = map(int, Path("/proc/self/uid_map").read_text().splitlines()[0].split())
    return count if first == 0 else 0


def _walls(limits):
    """The bubblewrap command up to what is seen through it."""
    options = ["--unshare-net", "--unshare-pid", "--unshare-ipc", "--unshare-uts",
               "--unshare-cgroup-try", "--die-with-parent", "--new-session"]
    if _is_root():
        # Real root in a user namespace stays real root for resource limits; so no namespace,
        # and the worker leaves root for an unused user before it reads a line of the student.
        options += ["--cap-drop", "ALL", "--cap-add", "CAP_SETUID", "--cap-add", "CAP_SETGID"]
    else:
        options += ["--unshare-user", "--disable-userns"]
    system = [("--ro-bind-try", path, path) for path in
              ("/usr", "/etc/ld.so.cache", "/etc/alternatives")]
    system += [("--symlink", os.readlink(path), path) if os.path.islink(path)
               else ("--ro-bind-try", path, path)
               for path in ("/bin", "/lib", "/lib32", "/lib64") if os.path.lexists(path)]
    return ["bwrap", *options, *itertools.chain(*system),
            "--proc", "/proc", "--dev", "/dev",
            "--perms", "1777", "--size", str(limits.temporary_space), "--tmpfs", "/dev/shm",
            "--remount-ro", "/dev",
            "--perms", "1777", "--size", str(limits.temporary_space), "--tmpfs", "/tmp",
            "--chdir", "/tmp"]


def _windows(forbidden):
    """Options that show Python, the worker and the students' library, less what is forbidden."""
    shown = [sys.base_prefix, sys.prefix, str(INSIDE), str(PROJECT / "utils"),
             *map(str, sorted((PROJECT / "data").glob("*.txt")))]
    parents = {str(parent) for path in shown for parent in Path(path).parents}
    # Folders that bubblewrap makes by itself are closed to all but their owner.
    options = list(itertools.chain(*(("--perms", "0755", "--dir", path)
                                     for path in sorted(parents, key=len))))
    options += itertools.chain(*(("--ro-bind", path, path) for path in dict.fromkeys(shown)))
    for module in forbidden:
        for folder in _folders_of(module):
            options += ["--tmpfs", folder, "--remount-ro", folder]
    return options


@functools.cache
def _folders_of(module):
    """Every folder of a module that can be seen inside; the system's Python may have it too."""
    libraries = [Path(root, name) for root in (sys.prefix, sys.base_prefix, "/usr", "/usr/local")
                 for name in ("lib", "lib64")]
    pattern = f"python*/*-packages/{module.replace('.', '/')}"
    return tuple(dict.fromkeys(
        str(folder) for library in libraries if not library.is_symlink()
        for folder in library.glob(pattern) if folder.is_dir()))


def _environment(tier):
    home = "/tmp" if tier == "bubblewrap" else os.environ.get("HOME", "/tmp")
    return {"HOME": home, "PATH": "/usr/bin:/bin", "LANG": "C.UTF-8", "MPLBACKEND": "Agg",
            # One thread each: classes are graded many notebooks at a time.
            "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
