"""Tools for hidden tests: a decorator, cached oracles, and random generators."""

import dataclasses
import functools
import hashlib
from collections.abc import Callable

import numpy as np
import pytest

from utils.checks import Check
from utils.checks.assertions import frozen

MAX_CACHED_ANSWERS = 256


def hidden(exercise: str, *, title: str, hint: str, weight: float = 1.0) -> pytest.MarkDecorator:
    """Mark a test in a lesson's ``hidden_tests.py``, which students do not see.

    Parameters
    ----------
    exercise : str
    title, hint : str
        Texts that students see. They may say what the function must do, but not how it is tested.
        In the title of a parametrized test, ``{}`` is replaced by the ID of the parameters.
    weight : float
        Share of the exercise's points, relative to its other checks.
    """
    return pytest.mark.judged(Check("", exercise, title, hint, weight))


def check_of(item: pytest.Item) -> Check:
    """Return the check that a hidden test represents."""
    check = item.get_closest_marker("judged").args[0]
    title = check.title.format(item.callspec.id) if hasattr(item, "callspec") else check.title
    return dataclasses.replace(check, name=item.name, title=title)


def cached_by_content(oracle: Callable[..., np.ndarray]) -> Callable[..., np.ndarray]:
    """Cache the answers of a slow oracle by the content of its array.

    The answers are read-only. All arguments after the array must be hashable.
    """
    cache = {}

    @functools.wraps(oracle)
    def cached_oracle(array: np.ndarray, *settings: object) -> np.ndarray:
        array = np.ascontiguousarray(array)
        key = hashlib.blake2b(array).digest(), array.dtype.str, array.shape, settings
        if key not in cache:
            if len(cache) >= MAX_CACHED_ANSWERS:
                cache.pop(next(iter(cache)))
            cache[key] = frozen(oracle(array, *settings))
        return cache[key]

    return cached_oracle


def generator_for_students(seed: int, purpose: str) -> np.random.Generator:
    """Return a random generator that may be passed to a student's function.

    NumPy's seeding can be reversed, so the state of a generator reveals its seed. This generator
    is seeded with a digest of the secret, which does not reveal the secret itself.

    Parameters
    ----------
    seed : int
        The secret.
    purpose : str
        Purpose of the generator. Each purpose results in a different digest.
    """
    digest = hashlib.sha256(f"for students: {seed} {purpose}".encode()).digest()
    return np.random.default_rng(int.from_bytes(digest, "big"))
