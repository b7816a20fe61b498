"""Run a command with the restrictions of Docker's default profile.

    python3 tests/containers.py USER COMMAND...    # USER is a number, and 0 is root

The script needs root and only Python's standard library. The lists come from Docker's
default seccomp profile and capabilities.
"""

import ctypes
import os
import sys
from collections.abc import Iterable

DOCKER = (
    *("chown", "dac_override", "fsetid", "fowner", "mknod", "net_raw", "setgid", "setuid"),
    *("setfcap", "setpcap", "net_bind_service", "sys_chroot", "kill", "audit_write"),
)


# Numbers of system calls on x86_64: unshare, setns, mount, umount2, pivot_root, bpf,
# perf_event_open, keyctl, add_key, userfaultfd, open_tree, move_mount, fsopen, fsmount and
# mount_setattr.
DENIED_CALLS = (272, 308, 165, 166, 155, 321, 298, 250, 248, 323, 428, 429, 430, 432, 442)
CLONE, CLONE3 = 56, 435
NEW_NAMESPACES = 0x7E020000  # all flags of clone that create a namespace, such as CLONE_NEWUSER


def as_user(user: int, capabilities: Iterable[str] | None) -> list[str]:
    """Return a prefix that makes a command run as this user, with these capabilities."""
    words = ["setpriv", "--inh-caps=-all"]
    if user:
        words += ["--reuid", str(user), "--regid", str(user), "--clear-groups"]
    if capabilities is not None:
        words.append(",".join(["--bounding-set=-all", *(f"+{name}" for name in capabilities)]))
    return words


def deny_what_docker_denies():
    """Refuse the system calls that Docker refuses without CAP_SYS_ADMIN (x86_64 only)."""
    load = 0x20  # BPF_LD | BPF_W | BPF_ABS
    jump_if_equal, jump_if_set = 0x15, 0x45  # BPF_JMP | BPF_JEQ | BPF_K, and with BPF_JSET
    give = 0x06  # BPF_RET | BPF_K
    allow = 0x7FFF0000  # SECCOMP_RET_ALLOW
    no_permission, no_such_call = 0x00050001, 0x00050026  # SECCOMP_RET_ERRNO | EPERM, or | ENOSYS
    code = [(load, 0, 0, 0)]  # the number of the system call
    for number in DENIED_CALLS:
        code += [(jump_if_equal, 0, 1, number), (give, 0, 0, no_permission)]
    # A filter cannot read the flags of clone3. Without clone3, the C library calls clone.
    code += [(jump_if_equal, 0, 1, CLONE3), (give, 0, 0, no_such_call)]
    code += [(jump_if_equal, 0, 3, CLONE), (load, 0, 0, 16)]  # the flags, its first argument
    code += [(jump_if_set, 0, 1, NEW_NAMESPACES), (give, 0, 0, no_permission)]
    code += [(give, 0, 0, allow)]

    class Program(ctypes.Structure):
        _fields_ = [("length", ctypes.c_ushort), ("code", ctypes.c_char_p)]

    text = b"".join(
        operation.to_bytes(2, "little") + bytes((if_true, if_false)) + value.to_bytes(4, "little")
        for operation, if_true, if_false, value in code
    )
    program, libc = Program(len(code), text), ctypes.CDLL(None, use_errno=True)
    zero = ctypes.c_ulong(0)
    # PR_SET_SECCOMP with SECCOMP_MODE_FILTER
    if libc.prctl(22, ctypes.c_ulong(2), ctypes.byref(program), zero, zero):
        raise OSError(ctypes.get_errno(), "seccomp")


if __name__ == "__main__":
    deny_what_docker_denies()
    words = as_user(int(sys.argv[1]), DOCKER)
    os.execvp(words[0], [*words, *sys.argv[2:]])
