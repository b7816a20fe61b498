"""Run a worker in a chroot and end all of its processes afterwards.

This process runs as root, outside the chroot, between the judge and the worker. All processes that
the worker starts remain descendants of this process. It kills them when the worker ends or when
standard input is closed.

`grader.sandbox.chroot` runs it: ``python -I -S -B jailer.py FOLDER HOME USER COMMAND ...``.
"""

import contextlib
import ctypes
import os
import select
import signal
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent / "inside"))

import privileges  # noqa: E402

MAX_FILES = 2**16
PR_SET_CHILD_SUBREAPER = 36  # see prctl(2)


def main(folder: str, home: str, user: int, command: list[str]) -> int:
    """Run a command in a chroot; return its exit code as a shell would report it."""
    # Make orphaned processes children of this process, so that it can reap them.
    ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, ctypes.c_ulong(1), 0, 0, 0)
    woken, waker = os.pipe2(os.O_NONBLOCK | os.O_CLOEXEC)
    signal.set_wakeup_fd(waker, warn_on_full_buffer=False)
    signal.signal(signal.SIGCHLD, lambda number, frame: None)
    worker = os.fork()
    if worker == 0:
        try:
            _exec_in_chroot(folder, home, command)
        except OSError as error:
            print(error, file=sys.stderr, flush=True)
        finally:
            os._exit(1)
    # Close the worker's ends of the pipes here, so that no copy stays open when the worker ends.
    os.closerange(3, min(woken, waker))
    os.closerange(max(woken, waker) + 1, MAX_FILES)
    code = None
    while code is None:
        ready, _, _ = select.select([sys.stdin.fileno(), woken], [], [])
        if sys.stdin.fileno() in ready:
            os.kill(worker, signal.SIGKILL)  # it may still be root and survive `kill_processes_of`
        if woken in ready:
            os.read(woken, 4096)
        code = _poll_exit_code(worker, wait=sys.stdin.fileno() in ready, user=user)
    kill_processes_of(user)
    _reap_children()
    return code


def _exec_in_chroot(folder: str, home: str, command: list[str]) -> None:
    # When memory runs out, the kernel should kill the worker, not the judge. The worker cannot set
    # this itself, because its chroot has no /proc.
    with contextlib.suppress(OSError):
        Path("/proc/self/oom_score_adj").write_text("1000")
    null_device = os.open(os.devnull, os.O_RDWR)
    for standard in (0, 1):
        os.dup2(null_device, standard)
    os.close(null_device)
    os.chroot(folder)
    os.chdir(home)
    # With root's capabilities, student code could escape from the chroot.
    privileges.drop_privileges(keep_user_changes=True)
    os.execv(command[0], command)


def _poll_exit_code(worker: int, *, wait: bool, user: int) -> int | None:
    """Return the exit code of the worker, or None while it runs.

    With `wait`, first kill all processes of the user, then wait for the worker to end.
    """
    if wait:
        kill_processes_of(user)
    while True:
        try:
            pid, status = os.waitpid(worker if wait else -1, 0 if wait else os.WNOHANG)
        except ChildProcessError:
            return 1
        if pid == worker:
            code = os.waitstatus_to_exitcode(status)
            return code if code >= 0 else 128 - code
        if not pid:
            return None


def kill_processes_of(user: int) -> None:
    """Kill all processes of a user with one system call, so that none can fork in between."""
    pid = os.fork()
    if pid == 0:
        try:
            os.setgroups([])
            os.setresgid(user, user, user)
            os.setresuid(user, user, user)
            os.kill(-1, signal.SIGKILL)
        finally:
            os._exit(0)
    os.waitpid(pid, 0)


def _reap_children() -> None:
    while True:
        try:
            os.waitpid(-1, 0)
        except ChildProcessError:
            return


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:3], int(sys.argv[3]), sys.argv[4:]))
