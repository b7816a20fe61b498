"""Give up what root may do, for good: before a line of the student is read.

See prctl(2), capabilities(7) and linux/capability.h.
"""

import ctypes
import os

_DROP_FROM_BOUNDING_SET, _SET_DUMPABLE, _SET_NO_NEW_PRIVILEGES = 24, 4, 38
_CAPABILITIES_VERSION = 0x20080522
_SETGID, _SETUID = 6, 7

_LIBC = ctypes.CDLL(None, use_errno=True)


def give_up(*, keep_user_changes: bool) -> None:
    """Give up all capabilities, for good and for all children.

    Parameters
    ----------
    keep_user_changes : bool
        But for those to become another user: a worker of root's does that next.

    Raises
    ------
    OSError
        If the kernel does not let us.
    """
    kept = (1 << _SETGID | 1 << _SETUID) if keep_user_changes else 0
    for capability in range(64):
        # Beyond the last one that this kernel knows it says so.
        if not kept >> capability & 1:
            _LIBC.prctl(_DROP_FROM_BOUNDING_SET, ctypes.c_ulong(capability), 0, 0, 0)
    header = (ctypes.c_uint32 * 2)(_CAPABILITIES_VERSION, 0)
    # Effective, permitted, inheritable; of the first 32 capabilities and of the rest.
    sets = (ctypes.c_uint32 * 6)(kept, kept, 0, 0, 0, 0)
    if _LIBC.capset(header, sets):
        number = ctypes.get_errno()
        raise OSError(number, f"capset: {os.strerror(number)}")
    _LIBC.prctl(_SET_NO_NEW_PRIVILEGES, ctypes.c_ulong(1), 0, 0, 0)
    # Entering a user namespace hides a process from its own user, who is to count its files.
    _LIBC.prctl(_SET_DUMPABLE, ctypes.c_ulong(1), 0, 0, 0)
