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
    load, jump, any_bit, give = 0x20, 0x15, 0x45, 0x06
    allow, no, unknown = 0x7FFF0000, 0x00050001, 0x00050026
    code = [(load, 0, 0, 0)]
    for number in (272, 308, 165, 166, 155, 321, 298, 250, 248, 323, 428, 429, 430, 432, 442):
        code += [(jump, 0, 1, number), (give, 0, 0, no)]
    code += [(jump, 0, 1, 435), (give, 0, 0, unknown)]  # clone3, whose flags a filter cannot read
    code += [(jump, 0, 3, 56), (load, 0, 0, 16), (any_bit, 0, 1, 0x7E020000), (give, 0, 0, no)]
    code += [(give, 0, 0, allow)]

    class Program(ctypes.Structure):
        _fields_ = [("length", ctypes.c_ushort), ("code", ctypes.c_char_p)]

    text = b"".join(
        operation.to_bytes(2, "little") + bytes((yes, no_)) + value.to_bytes(4, "little")
        for operation, yes, no_, value in code
    )
    program, libc = Program(len(code), text), ctypes.CDLL(None, use_errno=True)
    zero = ctypes.c_ulong(0)
    if libc.prctl(22, ctypes.c_ulong(2), ctypes.byref(program), zero, zero):
        raise OSError(ctypes.get_errno(), "seccomp")


if __name__ == "__main__":
    deny_what_docker_denies()
    words = as_user(int(sys.argv[1]), DOCKER)
    os.execvp(words[0], [*words, *sys.argv[2:]])
