"""Stored results of three drivers: the true boxes, the course's detector and the naive detector.

`standards.json` contains only results, no code. `drive_standards.py` of lesson 12 writes it.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path

from utils.drive.metrics import Report

RESULTS_FILE = Path(__file__).with_name("standards.json")

DRIVERS = ("true boxes", "the course's detector", "lesson 12's naive detector")


@dataclass(frozen=True)
class DriveResult:
    """Metrics of one or more drives, which can be added up.

    Attributes
    ----------
    metres : float
        Distance driven.
    needless : int
        Number of needless braking events.
    collisions : int
    near_misses : int
    """

    metres: float = 0.0
    needless: int = 0
    collisions: int = 0
    near_misses: int = 0

    def __add__(self, other: DriveResult) -> DriveResult:
        pairs = zip(asdict(self).values(), asdict(other).values(), strict=True)
        return DriveResult(*(mine + theirs for mine, theirs in pairs))

    def __str__(self) -> str:
        return (
            f"{self.metres:5.0f} m, {_count_text(self.needless, 'needless braking event')}, "
            f"{_count_text(self.collisions, 'collision')}"
        )


def _count_text(count: int, noun: str) -> str:
    return f"{count or 'no'} {noun}{'' if count == 1 else 's'}"


def drive_result(report: Report) -> DriveResult:
    """Return those metrics of a report that can be added up."""
    return DriveResult(
        round(report.metres, 1), report.needless, int(bool(report.collision)), report.near_misses
    )


def reference_results(streets: Iterable[int]) -> dict[str, DriveResult]:
    """Return each driver's total over some streets, if all these streets are stored for the driver.

    Parameters
    ----------
    streets : iterable of int
        Street numbers, from 1.
    """
    numbers = {str(number) for number in streets}
    return {
        name: sum((DriveResult(*drives[number]) for number in numbers), start=DriveResult())
        for name, drives in _load_results().items()
        if numbers <= drives.keys()
    }


@lru_cache(maxsize=1)
def _load_results() -> dict[str, dict[str, list]]:
    return json.loads(RESULTS_FILE.read_text("utf-8")) if RESULTS_FILE.exists() else {}


def store_results(results: dict[str, dict[int, DriveResult]]) -> None:
    """Write results to `standards.json`, by driver and street number."""
    lines = [
        f" {json.dumps(name)}: {{\n"
        + ",\n".join(
            f'  "{number}": {json.dumps(list(asdict(result).values()))}'
            for number, result in drives.items()
        )
        + "\n }"
        for name, drives in results.items()
    ]
    RESULTS_FILE.write_text("{\n" + ",\n".join(lines) + "\n}\n", "utf-8")
