"""A process that has imported NumPy and forks workers, which then join a sandbox.

Starting Python and importing NumPy takes ten times as long as building the sandbox, so this process
does both only once. It never sees a submission or a grade. It has already imported the worker's
code, and each request names the sandbox to join and passes the ends of three pipes. The forked
worker joins the namespaces that bubblewrap created, gives up its privileges, and runs `worker.py`.

`grader.sandbox.fork_client` runs it: ``python -I -B fork_server.py SOCKET SETTINGS``.
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

sys.path.pop(0)  # importing the worker inserted the same folder again

# The namespaces that bubblewrap creates, except the user namespace; see namespaces(7).
NAMESPACES = ("mnt", "net", "ipc", "uts", "cgroup", "pid")
NS_GET_PARENT = 0xB702  # see ioctl_ns(2)

_LIBC = ctypes.CDLL(None, use_errno=True)


def main(requests: socket.socket, preloaded: list[str], forbidden: list[str]) -> None:
    """Serve requests until the client closes the socket."""
    _import([], forbidden)
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    # A separate process serves each request, so a worker that misbehaves does not end the server.
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
                _run_in_sandbox(request, *pipes)
            finally:
                os._exit(1)
        for end in pipes:
            os.close(end)


def _import(names: list[str], forbidden: list[str]) -> None:
    """Import modules for all later workers, but not the forbidden modules that these import."""
    # A module that is already in memory could not be hidden from student code.
    sys.meta_path.insert(0, worker.importing.ForbiddenModuleFinder(forbidden))
    for name in names:
        if worker.forbidden_module_of(name, forbidden):
            continue
        with contextlib.suppress(ImportError):
            importlib.import_module(name)
    del sys.meta_path[0]
    # Without freezing, each worker's garbage collector would write to the memory of these modules.
    # The kernel would then have to copy that memory.
    gc.collect()
    gc.freeze()


def _receive(requests: socket.socket) -> tuple[bytes, list[int]]:
    """Return a request and the pipe ends that were sent with it."""
    data, ancillary, _, _ = requests.recvmsg(4096, socket.CMSG_SPACE(3 * 4))
    pipes = array.array("i")
    for _, _, content in ancillary:
        pipes.frombytes(content)
    return data, list(pipes)


def _run_in_sandbox(request: dict, read_end: int, write_end: int, status: int) -> None:
    """Join the sandbox, fork the worker there, and report its exit code.

    Joining a PID namespace affects only later children, so this process forks once more. When the
    worker ends, this process kills the sandbox, and with it everything that the worker started.
    """
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    os.setsid()
    try:
        sandbox_pidfd = os.pidfd_open(request["sandbox_pid"])
        enter(request["sandbox_pid"], request["has_user_namespace"])
        pid = os.fork()
    except OSError as error:
        os.write(status, f"cannot join the sandbox: {error}\n".encode())
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
        signal.pidfd_send_signal(sandbox_pidfd, signal.SIGKILL)
    os.write(status, f"{code}\n".encode())


def _become_worker(request: dict, read_end: int, write_end: int) -> None:
    read_end, write_end = _close_other_files(read_end, write_end)
    privileges.drop_privileges(keep_user_changes=not request["has_user_namespace"])
    os.chdir(request["home"])
    os.environ["HOME"] = os.environ["PWD"] = request["home"]
    sys.argv[:] = [str(Path(worker.__file__))]
    # Without new seeds, all workers would draw the same random numbers.
    random.seed()
    worker.np.random.seed()
    worker.serve(read_end, write_end)


def _close_other_files(*ends: int) -> list[int]:
    """Close all files except `ends` and the standard ones, and renumber `ends` from 3."""
    moved = [fcntl.fcntl(end, fcntl.F_DUPFD, 64) for end in ends]
    os.closerange(3, 64)
    os.closerange(max(moved) + 1, 2**16)
    for number, end in enumerate(moved, start=3):
        os.dup2(end, number)
        os.close(end)
    return list(range(3, 3 + len(moved)))


def enter(pid: int, has_user_namespace: bool) -> None:
    """Join all namespaces of a process.

    Parameters
    ----------
    pid : int
        The first process in the sandbox.
    has_user_namespace : bool
        Whether there is also a user namespace. Bubblewrap nests two user namespaces, so that
        student code cannot create another one. The outer one owns the other namespaces.

    Raises
    ------
    OSError
        If the kernel does not allow it.
    """
    opened = [os.open(f"/proc/{pid}/ns/{name}", os.O_RDONLY) for name in NAMESPACES]
    if has_user_namespace:
        inner = os.open(f"/proc/{pid}/ns/user", os.O_RDONLY)
        outer = fcntl.ioctl(inner, NS_GET_PARENT)
        _join_namespace(outer)
    for namespace in opened:
        _join_namespace(namespace)
    if has_user_namespace:
        _join_namespace(inner)


def _join_namespace(namespace: int) -> None:
    if _LIBC.setns(namespace, 0):
        number = ctypes.get_errno()
        raise OSError(number, f"setns: {os.strerror(number)}")


if __name__ == "__main__":
    main(socket.socket(fileno=int(sys.argv[1])), **json.loads(sys.argv[2]))
