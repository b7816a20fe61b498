"""Names under which students stand on a page: the same each time, and nobody's but the course's.

Without the course's seed, nobody finds out who somebody is, not by trying all who may be.
"""

from __future__ import annotations

import hashlib
import hmac
from collections.abc import Iterable

from grader.classroom.league.streets import secret

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
    """A name for each student, such as "teal heron 417"; no two are alike.

    Parameters
    ----------
    students : iterable of str
    seed : int
        The course's secret.
    """
    key = secret(seed, "pseudonyms").to_bytes(32, "big")
    found: dict[str, str] = {}
    for student in sorted(students):
        tries = 0
        while (name := _name(key, student, tries)) in found.values():
            tries += 1
        found[student] = name
    return found


def _name(key: bytes, student: str, tries: int) -> str:
    text = f"{tries} {student}".encode(errors="surrogatepass")
    number = int.from_bytes(hmac.digest(key, text, hashlib.sha256), "big")
    number, colour = divmod(number, len(COLOURS))
    number, bird = divmod(number, len(BIRDS))
    return f"{COLOURS[colour]} {BIRDS[bird]} {number % NUMBERS:03d}"
