"""Draw pseudonyms for a league's page, which stay the same within a course.

Another course gives the same student another pseudonym. Without the course's seed, the student
behind a pseudonym cannot be found, not even by trying every student's name.
"""

from __future__ import annotations

import hashlib
import hmac
from collections.abc import Iterable

from extension.league.streets import derive_secret

COLOURS = (
    *("amber", "azure", "beige", "black", "blue", "bronze", "brown", "coral", "crimson", "cyan"),
    *("gold", "green", "grey", "indigo", "ivory", "jade", "lilac", "lime", "maroon", "mauve"),
    *("ochre", "olive", "orange", "pink", "plum", "purple", "red", "rose", "ruby", "silver"),
    *("teal", "white"),
)
BIRDS = (
    *("avocet", "bittern", "bunting", "bustard", "condor", "coot", "crane", "cuckoo", "curlew"),
    *("dipper", "dove", "dunlin", "eagle", "egret", "falcon", "finch", "gannet", "goose"),
    *("grebe", "heron", "hoopoe", "ibis", "jackdaw", "kestrel", "kite", "lapwing", "lark"),
    *("merlin", "nuthatch", "osprey", "puffin", "wren"),
)
NUMBERS = 1000


def pseudonyms(students: Iterable[str], seed: int) -> dict[str, str]:
    """Return a pseudonym for each student, such as "teal heron 417"; all are different.

    Parameters
    ----------
    students : iterable of str
    seed : int
        The course's secret.
    """
    key = derive_secret(seed, "pseudonyms").to_bytes(32, "big")
    names: dict[str, str] = {}
    for student in sorted(students):
        attempt = 0
        while (name := _draw_pseudonym(key, student, attempt)) in names.values():
            attempt += 1
        names[student] = name
    return names


def _draw_pseudonym(key: bytes, student: str, attempt: int) -> str:
    text = f"{attempt} {student}".encode(errors="surrogatepass")
    number = int.from_bytes(hmac.digest(key, text, hashlib.sha256), "big")
    number, colour = divmod(number, len(COLOURS))
    number, bird = divmod(number, len(BIRDS))
    return f"{COLOURS[colour]} {BIRDS[bird]} {number % NUMBERS:03d}"
