"""A process that has Python and NumPy ready and, when asked, forks a worker that goes behind walls.

Starting Python and importing NumPy takes ten times as long as building the walls. Here it is done
once. This process never sees anything of a student or of a grade: it knows the worker's own code
and, for each request, which walls to go behind and three ends of pipes. The worker that it forks
enters the namespaces that bubblewrap has made, gives up every privilege, and is from there on what
`worker.py` makes of it.

Run by `grader.sandbox.fork_client`: ``python -I -B fork_server.py SOCKET SETTINGS``.
"""

import array
import contextlib
import ctypes
import fcntl
import gc
import importlib
import json
import os
import random
import signal
import socket
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent / "inside"))

import privileges  # noqa: E402
import worker  # noqa: E402

sys.path.pop(0)  # the worker has put it there, too

# What bubblewrap unshares, beside users; see namespaces(7).
NAMESPACES = ("mnt", "net", "ipc", "uts", "cgroup", "pid")
_PARENT_NAMESPACE = 0xB702  # see ioctl_ns(2)

_LIBC = ctypes.CDLL(None, use_errno=True)


def main(requests: socket.socket, preloaded: list[str], forbidden: list[str]) -> None:
    """Serve until whoever asks is gone."""
    _import([], forbidden)
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    # Whoever watches over many workers is not ended for what one of them does.
    while True:
        data, pipes = _receive(requests)
        if not data:
            return
        request = json.loads(data)
        if request["preload"] and preloaded:
            _import(preloaded, forbidden)
            preloaded = []
        if os.fork() == 0:
            requests.close()
            try:
                _shim(request, *pipes)
            finally:
                os._exit(1)
        for end in pipes:
            os.close(end)


def _import(names: list[str], forbidden: list[str]) -> None:
    """Import modules for all workers to come, and nothing along with them that is forbidden."""
    # What is in memory cannot be hidden.
    sys.meta_path.insert(0, worker.importing.Forbidden(forbidden))
    for name in names:
        if worker.forbidden_part(name, forbidden):
            continue
        with contextlib.suppress(ImportError):
            importlib.import_module(name)
    del sys.meta_path[0]
    # A worker need not look through all that for garbage, and copy the pages that it lies in.
    gc.collect()
    gc.freeze()


def _receive(requests: socket.socket) -> tuple[bytes, list[int]]:
    """A request, and the ends of pipes that come with it."""
    data, ancillary, _, _ = requests.recvmsg(4096, socket.CMSG_SPACE(3 * 4))
    pipes = array.array("i")
    for _, _, content in ancillary:
        pipes.frombytes(content)
    return data, list(pipes)


def _shim(request: dict, read_end: int, write_end: int, status: int) -> None:
    """Go behind the walls, fork the worker there, and report how it ends.

    Who enters a process table stays outside; only children are in it. With the worker ends
    whatever it has started.
    """
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    os.setsid()
    try:
        first = os.pidfd_open(request["walls"])
        enter(request["walls"], request["own_users"])
        pid = os.fork()
    except OSError as error:
        os.write(status, f"cannot go behind the walls: {error}\n".encode())
        return
    if pid == 0:
        try:
            _become_worker(request, read_end, write_end)
        finally:
            os._exit(1)
    os.close(read_end)
    os.close(write_end)
    os.write(status, f"{pid}\n".encode())
    code = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
    with contextlib.suppress(ProcessLookupError):
        signal.pidfd_send_signal(first, signal.SIGKILL)
    os.write(status, f"{code}\n".encode())


def _become_worker(request: dict, read_end: int, write_end: int) -> None:
    read_end, write_end = _alone_with(read_end, write_end)
    privileges.give_up(keep_user_changes=not request["own_users"])
    os.chdir(request["home"])
    os.environ["HOME"] = os.environ["PWD"] = request["home"]
    sys.argv[:] = [str(Path(worker.__file__))]
    # Else all workers would draw the same numbers.
    random.seed()
    worker.np.random.seed()
    worker.serve(read_end, write_end)


def _alone_with(*ends: int) -> list[int]:
    """Close all open files but some, which get the first numbers after standard error."""
    moved = [fcntl.fcntl(end, fcntl.F_DUPFD, 64) for end in ends]
    os.closerange(3, 64)
    os.closerange(max(moved) + 1, 2**16)
    for number, end in enumerate(moved, start=3):
        os.dup2(end, number)
        os.close(end)
    return list(range(3, 3 + len(moved)))


def enter(pid: int, own_users: bool) -> None:
    """Enter all namespaces of a process.

    Parameters
    ----------
    pid : int
        The first process behind the walls.
    own_users : bool
        Whether there is a user namespace, too. Bubblewrap makes two, one in the other, so that no
        further one can be made; the outer one owns the other namespaces.

    Raises
    ------
    OSError
        If the kernel does not let us.
    """
    opened = [os.open(f"/proc/{pid}/ns/{name}", os.O_RDONLY) for name in NAMESPACES]
    if own_users:
        inner = os.open(f"/proc/{pid}/ns/user", os.O_RDONLY)
        outer = fcntl.ioctl(inner, _PARENT_NAMESPACE)
        _set_namespace(outer)
    for namespace in opened:
        _set_namespace(namespace)
    if own_users:
        _set_namespace(inner)


def _set_namespace(namespace: int) -> None:
    if _LIBC.setns(namespace, 0):
        number = ctypes.get_errno()
        raise OSError(number, f"setns: {os.strerror(number)}")


if __name__ == "__main__":
    main(socket.socket(fileno=int(sys.argv[1])), **json.loads(sys.argv[2]))
