"""Turn the bytes of a file into the text of a notebook, or say which other kind of file it is.

The file is untrusted, so the size of unpacked content is limited.
"""

from __future__ import annotations

import codecs
import io
import zipfile
import zlib

LARGEST_UNPACKED = 64 * 2**20
_GZIP, _ZIP = b"\x1f\x8b", b"PK\x03\x04"
_LFS_POINTER = b"version https://git-lfs.github.com/spec/"
# First bytes of files that students submit instead of a notebook, and a message for each kind.
_OTHER_KINDS = (
    (
        b"\x00\x05\x16\x07",
        "contains only the attributes of a file on a Mac (AppleDouble). Submit the file whose name "
        "does not begin with `._`.",
    ),
    (b"%PDF-", "is a PDF and not a notebook. Submit the .ipynb file that Jupyter saves."),
    (
        b"<",
        "is a web page and not a notebook. A browser may have saved a preview or a sign-in page. "
        "Download the .ipynb file itself, and submit it.",
    ),
    (
        _LFS_POINTER,
        "is a Git LFS pointer: Git has not downloaded the notebook itself. Run `git lfs pull` in "
        "the checkout, and collect the file again.",
    ),
)


class UnreadableNotebook(Exception):
    """The file is not a notebook; `str()` is the message to show."""


def is_lfs_pointer(data: bytes) -> bool:
    """Return whether Git wrote these bytes in place of a file that it has not downloaded."""
    return data.startswith(_LFS_POINTER)


def notebook_text(data: bytes, name: str) -> tuple[str, str]:
    """Return the text of a notebook file, and a sentence about its repair.

    Parameters
    ----------
    data : bytes
    name : str
        Name of the file in messages.

    Returns
    -------
    text : str
    sentence : str
        Empty if nothing had to be repaired, or if the repair is certain.

    Raises
    ------
    UnreadableNotebook
        If the file is of another kind.
    """
    data, unpacked = _unpack(data, name)
    start = data.removeprefix(codecs.BOM_UTF8).lstrip()
    for first_bytes, message in _OTHER_KINDS:
        # A merge conflict in the first line of a notebook also begins with `<`.
        if start.startswith(first_bytes) and not start.startswith(b"<" * 7):
            raise UnreadableNotebook(f"{name} {message}")
    text, encoding = _decode(data, name)
    if not text.strip(" \t\r\n\0"):
        raise UnreadableNotebook(
            f"{name} is empty. Save the notebook again in Jupyter and submit it."
        )
    return text, " ".join(filter(None, (unpacked, encoding)))


def replace_surrogates(text: str) -> str:
    r"""Replace each surrogate, which is half of a character, with the replacement character.

    JSON may contain half an emoji, such as ``\ud83d``. Python reads it, but cannot write it to any
    file or database.
    """
    try:
        text.encode()
    except UnicodeEncodeError:
        return text.encode("utf-16-le", "surrogatepass").decode("utf-16-le", "replace")
    return text


def _unpack(data: bytes, name: str) -> tuple[bytes, str]:
    """Return the only notebook in a packed file, or the file itself."""
    if data.startswith(_GZIP):
        kind, unpack = "gzip", _unpack_gzip
    elif data.startswith(_ZIP):
        kind, unpack = "zip", _unpack_zip
    else:
        return data, ""
    try:
        content = unpack(data)
    except UnreadableNotebook as error:
        raise UnreadableNotebook(f"{name} {error}") from None
    except Exception:  # the modules raise many kinds of errors for damaged or encrypted files
        raise UnreadableNotebook(
            f"{name} is a {kind} file that cannot be unpacked. Submit the .ipynb file itself."
        ) from None
    return content, (
        f"{name} is a {kind} file. The notebook in it was judged. Submit the .ipynb file itself."
    )


def _unpack_gzip(data: bytes) -> bytes:
    content = zlib.decompressobj(31).decompress(data, LARGEST_UNPACKED + 1)  # 31 stands for gzip
    return _read_limited(content)


def _unpack_zip(data: bytes) -> bytes:
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        names = [
            name
            for name in archive.namelist()
            if name.endswith(".ipynb") and not name.split("/")[-1].startswith(".")
        ]
        if len(names) != 1:
            found = "no notebook" if not names else f"{len(names)} notebooks"
            raise UnreadableNotebook(
                f"is a zip file with {found} in it. Submit the .ipynb file itself."
            )
        with archive.open(names[0]) as file:
            return _read_limited(file.read(LARGEST_UNPACKED + 1))


def _read_limited(content: bytes) -> bytes:
    if len(content) > LARGEST_UNPACKED:
        raise UnreadableNotebook(
            f"unpacks to more than {LARGEST_UNPACKED // 2**20} MB. Clear its outputs (in "
            "JupyterLab: Edit, Clear Outputs of All Cells), save, and submit it again."
        )
    return content


def _decode(data: bytes, name: str) -> tuple[str, str]:
    """Decode bytes as UTF-8, or as one of the encodings that Windows programs save."""
    if encoding := _utf_16_variant(data):
        return data.decode(encoding, "replace"), ""
    for errors in ("strict", "surrogatepass"):
        try:
            return replace_surrogates(data.decode("utf-8-sig", errors)), ""
        except UnicodeDecodeError:
            pass
    if data.removeprefix(codecs.BOM_UTF8).lstrip()[:1] not in (b"{", b"[", b'"', b"<"):
        raise UnreadableNotebook(
            f"{name} is not a notebook, because it is not text. Save it again in "
            "Jupyter and submit the .ipynb file."
        )
    return data.decode("latin-1"), (
        f"{name} is not encoded in UTF-8, so letters with accents may be wrong. "
        "Save it again in Jupyter."
    )


def _utf_16_variant(data: bytes) -> str:
    """Return the name of the UTF-16 encoding of the data; empty for any other encoding."""
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    # JSON begins with two characters of ASCII, and each has one byte that is zero.
    zeros = [byte == 0 for byte in data[:4]]
    if zeros == [False, True, False, True]:
        return "utf-16-le"
    return "utf-16-be" if zeros == [True, False, True, False] else ""
