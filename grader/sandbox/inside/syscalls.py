"""Take away the system calls that no exercise needs.

Some memory belongs to no process and so to no limit (System V segments, queues, `memfd_create`); a
user namespace gives everybody a root's view of the kernel; keyrings are inherited from whoever
grades; virtual sockets reach through a namespace to the host. A seccomp filter answers all of
them, for this process and all it will ever start, with "no such call".

The filter is a program for the kernel's packet filter: see seccomp(2) and
``linux/filter.h``.
"""

import ctypes
import errno
import os
import sys
from collections.abc import Iterator

# By machine: what the kernel calls it (linux/audit.h), and its numbers of system calls.
MACHINES = {
    "x86_64": (
        0xC000003E,
        {
            "shmget": 29,
            "semget": 64,
            "msgget": 68,
            "mq_open": 240,
            "memfd_create": 319,
            "memfd_secret": 447,
            "ptrace": 101,
            "process_vm_readv": 310,
            "process_vm_writev": 311,
            "pidfd_getfd": 438,
            "add_key": 248,
            "request_key": 249,
            "keyctl": 250,
            "bpf": 321,
            "perf_event_open": 298,
            "userfaultfd": 323,
            "io_uring_setup": 425,
            "unshare": 272,
            "setns": 308,
            "clone3": 435,
            "clone": 56,
            "socket": 41,
        },
    ),
    "aarch64": (
        0xC00000B7,
        {
            "shmget": 194,
            "semget": 190,
            "msgget": 186,
            "mq_open": 180,
            "memfd_create": 279,
            "memfd_secret": 447,
            "ptrace": 117,
            "process_vm_readv": 270,
            "process_vm_writev": 271,
            "pidfd_getfd": 438,
            "add_key": 217,
            "request_key": 218,
            "keyctl": 219,
            "bpf": 280,
            "perf_event_open": 241,
            "userfaultfd": 282,
            "io_uring_setup": 425,
            "unshare": 97,
            "setns": 268,
            "clone3": 435,
            "clone": 220,
            "socket": 198,
        },
    ),
}
# These two stay, with limits on their first argument.
NEW_USER_NAMESPACE = 0x10000000
ORDINARY_SOCKETS = (1, 2, 10)  # unix, IPv4, IPv6: the sandbox has no network to reach

_LOAD, _IF_EQUAL, _IF_AT_LEAST, _IF_ANY_BIT, _RETURN = 0x20, 0x15, 0x35, 0x45, 0x06
_NUMBER, _MACHINE, _FIRST_ARGUMENT = 0, 4, 16
_FOREIGN_NUMBERS = 0x40000000  # the x32 calls of x86_64
_SET_NO_NEW_PRIVILEGES, _SET_SECCOMP, _FILTER = 38, 22, 2
_ALLOW = (_RETURN, 0, 0, 0x7FFF0000)
# "No such call": libraries know it from old kernels and take another way.
_DENY = (_RETURN, 0, 0, 0x00050000 | errno.ENOSYS)


class _Program(ctypes.Structure):
    _fields_ = [("length", ctypes.c_ushort), ("instructions", ctypes.c_char_p)]


def deny() -> None:
    """Deny them to this process and its children, for good.

    Other processors than those of `MACHINES` go without: this wall stands behind others.

    Raises
    ------
    OSError
        If the kernel does not take the filter.
    """
    machine = os.uname().machine
    if sys.platform != "linux" or machine not in MACHINES:
        return
    code = b"".join(
        operation.to_bytes(2, "little") + bytes((if_true, if_false)) + value.to_bytes(4, "little")
        for operation, if_true, if_false, value in _filter(machine)
    )
    program = _Program(len(code) // 8, code)
    prctl = ctypes.CDLL(None, use_errno=True).prctl
    nothing = ctypes.c_ulong(0)
    if prctl(_SET_NO_NEW_PRIVILEGES, ctypes.c_ulong(1), nothing, nothing, nothing) or prctl(
        _SET_SECCOMP, ctypes.c_ulong(_FILTER), ctypes.byref(program), nothing, nothing
    ):
        number = ctypes.get_errno()
        raise OSError(number, f"seccomp: {os.strerror(number)}")


def _filter(machine: str) -> Iterator[tuple[int, int, int, int]]:
    """Instructions (operation, how many to skip if true, if false, value)."""
    name, numbers = MACHINES[machine]
    numbers = dict(numbers)
    clone, socket = numbers.pop("clone"), numbers.pop("socket")
    yield _LOAD, 0, 0, _MACHINE
    yield _IF_EQUAL, 1, 0, name
    yield _DENY
    yield _LOAD, 0, 0, _NUMBER
    for test, number in [
        (_IF_AT_LEAST, _FOREIGN_NUMBERS),
        *((_IF_EQUAL, number) for number in numbers.values()),
    ]:
        yield test, 0, 1, number
        yield _DENY
    yield _IF_EQUAL, 0, 4, clone
    yield _LOAD, 0, 0, _FIRST_ARGUMENT
    yield _IF_ANY_BIT, 0, 1, NEW_USER_NAMESPACE
    yield _DENY
    yield _ALLOW
    yield _IF_EQUAL, 0, 2 + 2 * len(ORDINARY_SOCKETS), socket
    yield _LOAD, 0, 0, _FIRST_ARGUMENT
    for family in ORDINARY_SOCKETS:
        yield _IF_EQUAL, 0, 1, family
        yield _ALLOW
    yield _DENY
    yield _ALLOW
