"""Give up root's privileges permanently, before student code is read.

See prctl(2), capabilities(7) and linux/capability.h.
"""

import ctypes
import os

_DROP_FROM_BOUNDING_SET, _SET_DUMPABLE, _SET_NO_NEW_PRIVILEGES = 24, 4, 38
_CAPABILITIES_VERSION = 0x20080522
_SETGID, _SETUID = 6, 7

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
    kept = (1 << _SETGID | 1 << _SETUID) if keep_user_changes else 0
    for capability in range(64):
        # The kernel rejects numbers beyond its last capability, which is harmless.
        if not kept >> capability & 1:
            _LIBC.prctl(_DROP_FROM_BOUNDING_SET, ctypes.c_ulong(capability), 0, 0, 0)
    header = (ctypes.c_uint32 * 2)(_CAPABILITIES_VERSION, 0)
    # Effective, permitted and inheritable sets: for the first 32 capabilities, then for the others.
    sets = (ctypes.c_uint32 * 6)(kept, kept, 0, 0, 0, 0)
    if _LIBC.capset(header, sets):
        number = ctypes.get_errno()
        raise OSError(number, f"capset: {os.strerror(number)}")
    _LIBC.prctl(_SET_NO_NEW_PRIVILEGES, ctypes.c_ulong(1), 0, 0, 0)
    # After a process joins a user namespace, even its own user cannot read parts of its /proc
    # folder. The judge needs these parts to measure the files that the process writes.
    _LIBC.prctl(_SET_DUMPABLE, ctypes.c_ulong(1), 0, 0, 0)
