"""Deny system calls that exercises do not need.

The main reasons are:

- System V segments, message queues and `memfd_create` allocate memory that does not belong to a
  process, so process limits do not count it.
- A user namespace gives ordinary users root's view of the kernel.
- Keyrings are inherited from the instructor's session.
- Virtual sockets (AF_VSOCK) reach the host even from a namespace.
- All notebooks see the same files. Notebooks could exchange messages through locks, watches, hints
  and futexes on these files, or by choosing which pages of the files are in memory.

A seccomp filter makes these calls fail with "no such system call", in this process and in all
processes that it starts. Two kinds of calls return without doing anything instead:

- Calls that wait for a shared futex, or wake processes that wait for it.
- Calls that change the action for SIGCHLD. By ignoring this signal, student code could hide
  processor time, because the kernel adds a child's time only when its parent waits for it.

The filter is a BPF program; see seccomp(2) and ``linux/filter.h``.
"""

import ctypes
import errno
import os
import sys
from collections.abc import Iterator

# For each architecture, its AUDIT_ARCH number in linux/audit.h and its system call numbers.
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
            "flock": 73,
            "inotify_init": 253,
            "inotify_init1": 294,
            "inotify_add_watch": 254,
            "fanotify_init": 300,
            "fadvise64": 221,
            "readahead": 187,
            "mincore": 27,
            "cachestat": 451,
            "preadv2": 327,
            "pwritev2": 328,
            "io_setup": 206,
            "io_submit": 209,
            "openat2": 437,
            "process_madvise": 440,
            "mbind": 237,
            "migrate_pages": 256,
            "move_pages": 279,
            "syslog": 103,
            "futex_waitv": 449,
            "futex_wake": 454,
            "futex_wait": 455,
            "futex_requeue": 456,
            "clone": 56,
            "socket": 41,
            "fcntl": 72,
            "ioctl": 16,
            "madvise": 28,
            "prctl": 157,
            "futex": 202,
            "rt_sigaction": 13,
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
            "flock": 32,
            "inotify_init1": 26,
            "inotify_add_watch": 27,
            "fanotify_init": 262,
            "fadvise64": 223,
            "readahead": 213,
            "mincore": 232,
            "cachestat": 451,
            "preadv2": 286,
            "pwritev2": 287,
            "io_setup": 0,
            "io_submit": 2,
            "openat2": 437,
            "process_madvise": 440,
            "mbind": 235,
            "migrate_pages": 238,
            "move_pages": 239,
            "syslog": 116,
            "futex_waitv": 449,
            "futex_wake": 454,
            "futex_wait": 455,
            "futex_requeue": 456,
            "clone": 220,
            "socket": 198,
            "fcntl": 25,
            "ioctl": 29,
            "madvise": 233,
            "prctl": 167,
            "futex": 98,
            "rt_sigaction": 134,
        },
    ),
}
# These calls are allowed only with some values of an argument.
LIMITED_CALLS = ("clone", "socket", "fcntl", "ioctl", "madvise", "prctl", "futex", "rt_sigaction")
CLONE_NEWUSER = 0x10000000
# These sockets are harmless in a sandbox without a network.
AF_UNIX, AF_INET, AF_INET6 = 1, 2, 10
# Commands of fcntl for descriptors and their flags, but not for locks, leases, watches or hints.
F_DUPFD, F_GETFD, F_SETFD, F_GETFL, F_SETFL, F_DUPFD_CLOEXEC = 0, 1, 2, 3, 4, 1030
# Requests of ioctl with the letter "T" are for terminals, pipes and sockets. Requests for file
# systems are denied, because notebooks could exchange messages through a file system's settings.
IOCTL_TYPE_MASK, TERMINAL_IOCTLS = 0xFF00, ord("T") << 8
# Values of madvise that merge equal pages, remove pages from memory, or build huge pages.
MADV_MERGEABLE, MADV_COLD, MADV_PAGEOUT, MADV_COLLAPSE = 12, 20, 21, 25
PR_SET_MEMORY_MERGE = 67
# A futex without this flag may be on a page of a shared file.
FUTEX_PRIVATE_FLAG, FUTEX_CMD_MASK = 128, 127
FUTEX_WAIT, FUTEX_WAIT_BITSET, FUTEX_WAKE, FUTEX_WAKE_BITSET = 0, 9, 1, 10
# If a parent ignores this signal, the kernel discards the processor time of its children.
SIGCHLD = 17

# Operations of BPF, without the prefix BPF_: LD|W|ABS, ALU|AND|K, RET|K.
_LOAD, _AND, _RETURN = 0x20, 0x54, 0x06
# Jumps of BPF: JMP|JEQ|K, JMP|JGE|K, JMP|JSET|K.
_IF_EQUAL, _IF_AT_LEAST, _IF_ANY_BIT = 0x15, 0x35, 0x45
# Offsets of `nr`, `arch` and `args` in the kernel's struct seccomp_data, and sizes, in bytes.
_NUMBER, _ARCHITECTURE, _FIRST_ARGUMENT, _SIZE_OF_ARGUMENT, _SIZE_OF_HALF = 0, 4, 16, 8, 4
X32_SYSCALL_BIT = 0x40000000  # marks the calls of another set of numbers on x86_64
PR_SET_SECCOMP, PR_SET_NO_NEW_PRIVS, SECCOMP_MODE_FILTER = 22, 38, 2
SECCOMP_RET_ALLOW = 0x7FFF0000
SECCOMP_RET_ERRNO = 0x00050000  # combined with an error number, or with 0 for success
_ALLOW = (_RETURN, 0, 0, SECCOMP_RET_ALLOW)
# "No such system call". Libraries have a fallback for this error, because old kernels return it.
_DENY = (_RETURN, 0, 0, SECCOMP_RET_ERRNO | errno.ENOSYS)
# A wait returns at once, which callers must always expect. A wake-up does not wake any process.
_AGAIN = (_RETURN, 0, 0, SECCOMP_RET_ERRNO | errno.EAGAIN)
_DONE = (_RETURN, 0, 0, SECCOMP_RET_ERRNO)


class _FilterProgram(ctypes.Structure):
    _fields_ = [("length", ctypes.c_ushort), ("instructions", ctypes.c_char_p)]


def install_filter(*, sockets: bool = True) -> None:
    """Permanently install the filter for this process and its children.

    The filter is only an additional protection. On architectures that are not in `MACHINES`,
    nothing is installed.

    Parameters
    ----------
    sockets : bool
        Whether to allow sockets. Deny them if the sandbox shares the host's network.

    Raises
    ------
    OSError
        If the kernel refuses the filter.
    """
    machine = os.uname().machine
    if sys.platform != "linux" or machine not in MACHINES:
        return
    code = b"".join(
        operation.to_bytes(2, "little") + bytes((if_true, if_false)) + value.to_bytes(4, "little")
        for operation, if_true, if_false, value in _filter_instructions(machine, sockets)
    )
    program = _FilterProgram(len(code) // 8, code)
    prctl = ctypes.CDLL(None, use_errno=True).prctl
    nothing = ctypes.c_ulong(0)
    if prctl(PR_SET_NO_NEW_PRIVS, ctypes.c_ulong(1), nothing, nothing, nothing) or prctl(
        PR_SET_SECCOMP, ctypes.c_ulong(SECCOMP_MODE_FILTER), ctypes.byref(program), nothing, nothing
    ):
        number = ctypes.get_errno()
        raise OSError(number, f"seccomp: {os.strerror(number)}")


_Instruction = tuple[int, int, int, int]


def _filter_instructions(machine: str, sockets: bool) -> Iterator[_Instruction]:
    """Yield instructions: operation, number to skip if true, number to skip if false, value."""
    architecture, numbers = MACHINES[machine]
    yield _LOAD, 0, 0, _ARCHITECTURE
    yield _IF_EQUAL, 1, 0, architecture
    yield _DENY
    yield _LOAD, 0, 0, _NUMBER
    yield _IF_AT_LEAST, 0, 1, X32_SYSCALL_BIT
    yield _DENY
    for limited, rule in _rules(sockets).items():
        yield _IF_EQUAL, 0, len(rule), numbers[limited]
        yield from rule
    for call, number in numbers.items():
        if call not in LIMITED_CALLS:
            yield _IF_EQUAL, 0, 1, number
            yield _DENY
    yield _ALLOW


def _rules(sockets: bool) -> dict[str, list[_Instruction]]:
    """Return the instructions for each call in `LIMITED_CALLS`, the most frequent call first."""
    return {
        "futex": [
            _load_argument(1),
            *_answer_if(_ALLOW, _IF_ANY_BIT, FUTEX_PRIVATE_FLAG),
            (_AND, 0, 0, FUTEX_CMD_MASK),
            *_answer_if(_AGAIN, _IF_EQUAL, FUTEX_WAIT, FUTEX_WAIT_BITSET),
            *_answer_if(_DONE, _IF_EQUAL, FUTEX_WAKE, FUTEX_WAKE_BITSET),
            _DENY,
        ],
        "madvise": [
            _load_argument(2),
            *_answer_if(_DENY, _IF_EQUAL, MADV_MERGEABLE, MADV_COLD, MADV_PAGEOUT, MADV_COLLAPSE),
            _ALLOW,
        ],
        "fcntl": [
            _load_argument(1),
            *_answer_if(_ALLOW, _IF_EQUAL, F_DUPFD, F_GETFD, F_SETFD),
            *_answer_if(_ALLOW, _IF_EQUAL, F_GETFL, F_SETFL, F_DUPFD_CLOEXEC),
            _DENY,
        ],
        "ioctl": [
            _load_argument(1),
            (_AND, 0, 0, IOCTL_TYPE_MASK),
            *_answer_if(_ALLOW, _IF_EQUAL, TERMINAL_IOCTLS),
            _DENY,
        ],
        "clone": [_load_argument(0), *_answer_if(_DENY, _IF_ANY_BIT, CLONE_NEWUSER), _ALLOW],
        "socket": [
            _load_argument(0),
            *_answer_if(_ALLOW, _IF_EQUAL, *((AF_UNIX, AF_INET, AF_INET6) if sockets else ())),
            _DENY,
        ],
        "prctl": [_load_argument(0), *_answer_if(_DENY, _IF_EQUAL, PR_SET_MEMORY_MERGE), _ALLOW],
        "rt_sigaction": [
            _load_argument(0),
            *_answer_unless(SIGCHLD, _ALLOW),
            # With a null pointer, the call only reads the current action.
            _load_argument(1),
            *_answer_unless(0, _DONE),
            _load_argument(1, _SIZE_OF_HALF),
            *_answer_unless(0, _DONE),
            _ALLOW,
        ],
    }


def _load_argument(position: int, half: int = 0) -> _Instruction:
    """Return an instruction that loads half of an argument, by default the lower half."""
    return _LOAD, 0, 0, _FIRST_ARGUMENT + _SIZE_OF_ARGUMENT * position + half


def _answer_if(answer: _Instruction, test: int, *values: int) -> Iterator[_Instruction]:
    """Yield instructions that return an answer if the argument matches one of the values."""
    for value in values:
        yield test, 0, 1, value
        yield answer


def _answer_unless(value: int, answer: _Instruction) -> Iterator[_Instruction]:
    """Yield instructions that return an answer if the argument differs from the value."""
    yield _IF_EQUAL, 1, 0, value
    yield answer
