"""Give up root's privileges permanently, before student code is read.

See prctl(2), capabilities(7) and linux/capability.h.
"""

import ctypes
import os

PR_SET_DUMPABLE, PR_CAPBSET_DROP, PR_SET_NO_NEW_PRIVS = 4, 24, 38
LINUX_CAPABILITY_VERSION_3 = 0x20080522
CAP_SETGID, CAP_SETUID = 6, 7

_LIBC = ctypes.CDLL(None, use_errno=True)


def drop_privileges(*, keep_user_changes: bool) -> None:
    """Permanently give up all capabilities, for this process and its children.

    Parameters
    ----------
    keep_user_changes : bool
        Whether to keep the capabilities to change user and group. A worker that root started needs
        them for its next step.

    Raises
    ------
    OSError
        If the kernel refuses to change the capabilities.
    """
    kept = (1 << CAP_SETGID | 1 << CAP_SETUID) if keep_user_changes else 0
    for capability in range(64):
        # The kernel rejects numbers beyond its last capability, which is harmless.
        if not kept >> capability & 1:
            _LIBC.prctl(PR_CAPBSET_DROP, ctypes.c_ulong(capability), 0, 0, 0)
    header = (ctypes.c_uint32 * 2)(LINUX_CAPABILITY_VERSION_3, 0)
    # Effective, permitted and inheritable sets: for the first 32 capabilities, then for the others.
    sets = (ctypes.c_uint32 * 6)(kept, kept, 0, 0, 0, 0)
    if _LIBC.capset(header, sets):
        number = ctypes.get_errno()
        raise OSError(number, f"capset: {os.strerror(number)}")
    _LIBC.prctl(PR_SET_NO_NEW_PRIVS, ctypes.c_ulong(1), 0, 0, 0)
    # After a process joins a user namespace, even its own user cannot read parts of its /proc
    # folder. The judge needs these parts to measure the files that the process writes.
    _LIBC.prctl(PR_SET_DUMPABLE, ctypes.c_ulong(1), 0, 0, 0)
