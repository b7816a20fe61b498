"""Write files atomically: a reader never sees an incomplete file, even after a power cut."""

import os
import tempfile
from pathlib import Path

# Read only once: the umask can be read only by setting it, which briefly affects all threads.
_UMASK = os.umask(0o022)
os.umask(_UMASK)


def write_atomically(content: str | bytes, path: Path) -> None:
    """Write a file atomically, and create its folder if necessary.

    The file's mode follows the umask, so that other graders may read the file.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    descriptor, draft = tempfile.mkstemp(dir=path.parent, prefix=".", suffix=".part")
    try:
        with open(descriptor, "wb") as file:
            file.write(content if isinstance(content, bytes) else content.encode(errors="replace"))
            file.flush()
            os.fsync(file.fileno())  # otherwise a power cut may leave an empty file
        os.chmod(draft, 0o666 & ~_UMASK)
        os.replace(draft, path)
    except BaseException:  # also after Ctrl-C
        os.unlink(draft)
        raise
