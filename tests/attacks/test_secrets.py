"""Check that no input in the sandbox reveals the seed of other inputs.

NumPy's seeding can be inverted, so the state of a generator reveals its seed. The constants below
come from `numpy.random.SeedSequence` and PCG64.
"""

import copy
import hashlib

import numpy as np
import pytest
import sklearn.cluster  # noqa: F401  (imported now, because SciPy draws numbers on import)

from extension import samples
from grader import cli, commands
from grader.course.lessons import load_reference
from grader.course.paths import Course
from grader.course.seed import SeedTooSmall, course_seed
from grader.judging.hidden_tests import generator_for_students
from grader.judging.runner import run_checks
from tests.students import student_with

WORD, PCG = 2**32, 2**128
PCG_MULTIPLIER = 0x2360ED051FC65DA44385DF649FCCF645
INIT_A, MULT_A, INIT_B, MULT_B = 0x43B0D7E5, 0x931E8875, 0x8B51F9DD, 0x58F38DED
MIX_L, MIX_R = 0xCA01F9DD, 0x4973F715
PUBLIC = 100_000  # smaller numbers are sizes and counts, which are public anyway
SEED = 0xC0FFEE_5EED_0F_A_C0FFEE_5EED


def unshift(word):
    """Return the inverse of ``word ^ word >> 16`` for a 32-bit word."""
    return word ^ word >> 16


def hash_constants(first, factor, count):
    found = [first]
    for _ in range(count):
        found.append(found[-1] * factor % WORD)
    return found


def seed_behind(generator):
    """Return the seed of a NumPy generator, if the seed has at most 128 bits."""
    state = generator.bit_generator.state["state"]
    backwards = (state["state"] - state["inc"]) * pow(PCG_MULTIPLIER, -1, PCG) - state["inc"]
    high, low = backwards % PCG >> 64, backwards % 2**64
    words = [high % WORD, high >> 32, low % WORD, low >> 32]
    hashes = hash_constants(INIT_B, MULT_B, 4)
    pool = [
        unshift(word) * pow(hashes[n + 1], -1, WORD) % WORD ^ hashes[n]
        for n, word in enumerate(words)
    ]
    # Seeding first hashes four words, and then mixes each word into the three others.
    hashes = hash_constants(INIT_A, MULT_A, 16)
    step = 16
    for source in (3, 2, 1, 0):
        for target in (3, 2, 1, 0):
            if source == target:
                continue
            step -= 1
            mixed = (pool[source] ^ hashes[step]) * hashes[step + 1] % WORD
            mixed ^= mixed >> 16
            pool[target] = (unshift(pool[target]) + MIX_R * mixed) * pow(MIX_L, -1, WORD) % WORD
    entropy = [
        unshift(word) * pow(hashes[n + 1], -1, WORD) % WORD ^ hashes[n]
        for n, word in enumerate(pool)
    ]
    return sum(word << 32 * n for n, word in enumerate(entropy))


@pytest.mark.parametrize("seed", [0, 7, 2026, 2**32 + 5, 29034951985294, 2**127 + 12345])
def test_seeding_can_be_inverted(seed):
    """`seed_behind` returns the seed; otherwise, the tests below could not fail."""
    generator = np.random.default_rng(seed)
    assert seed_behind(generator) == seed


def test_a_generator_for_students_does_not_reveal_the_seed():
    found = seed_behind(generator_for_students(SEED, "a test"))
    assert found != SEED and found > 2**64
    other = seed_behind(generator_for_students(SEED, "another test"))
    assert other != found
    again = generator_for_students(SEED, "a test")
    assert again.random() == generator_for_students(SEED, "a test").random()


def generators_and_numbers_in(value):
    """Yield the generators and whole numbers among the arguments of a call."""
    if isinstance(value, (list, tuple)):
        for item in value:
            yield from generators_and_numbers_in(item)
    elif isinstance(value, dict):
        yield from generators_and_numbers_in(list(value.values()))
    elif isinstance(value, (np.random.Generator, int, np.integer)):
        yield value


@pytest.mark.slow
def test_hidden_input_does_not_reveal_a_seed(lesson, monkeypatch):
    """No generator or whole number among the arguments reveals a seed."""
    received, drawn_from = [], set()
    make = np.random.default_rng

    def record_seed(seed=None):
        drawn_from.add(seed if isinstance(seed, int) else None)
        return make(seed)

    def recording_arguments(function):
        def ask(*arguments, **keywords):
            for value in generators_and_numbers_in([arguments, keywords]):
                received.append(copy.deepcopy(value))  # copied before a draw changes the state
            return function(*arguments, **keywords)

        return ask

    monkeypatch.setattr(np.random, "default_rng", record_seed)
    for remembered in vars(samples).values():
        if hasattr(remembered, "cache_clear"):
            remembered.cache_clear()
    reference = load_reference(lesson.name)
    answers = {
        exercise.name: recording_arguments(getattr(reference, exercise.name))
        for exercise in lesson.machine_graded
    }
    run_checks(lesson, student_with(lesson, answers), SEED, lambda check: not check.is_shown)
    text = f"{SEED} test_{lesson.name}.py"
    secret = int.from_bytes(hashlib.sha256(text.encode()).digest()[:15], "big")
    secrets = {seed for seed in drawn_from if seed is not None and seed >= PUBLIC}
    assert any(abs(seed - secret) < 1000 for seed in secrets) or not secrets
    # With a GPU and a digest of the seed, an attacker can try 2**33 seeds per second.
    assert all(seed > 2**100 for seed in secrets)
    for value in received:
        found = seed_behind(value) if isinstance(value, np.random.Generator) else int(value)
        assert found < PUBLIC or isinstance(value, np.random.Generator), (lesson.name, value)
        assert found not in secrets and found != SEED
        assert abs(found - secret) > 1000


@pytest.mark.parametrize("seed", [0, -(2**70), 2026, 2**64 - 1])
def test_a_short_seed_is_refused(seed, tmp_path, monkeypatch, capsys):
    course = Course(tmp_path)
    monkeypatch.setattr(commands, "Course", lambda: course)
    assert cli.main(["grade", f"--seed={seed}", "--sandbox", "process"]) == commands.USAGE_ERROR
    assert "Leave --seed out" in (message := capsys.readouterr().err)
    offered = int(message.split()[-1])
    assert course_seed(course, offered) == offered
    course.seed_file.write_text(f"{seed}\n")
    with pytest.raises(SeedTooSmall, match="Remove .course_seed"):
        course_seed(course)


def test_generated_seeds_are_accepted_and_distinct(tmp_path):
    seeds = set()
    for number in range(200):
        (folder := tmp_path / str(number)).mkdir()
        seeds.add(course_seed(Course(folder)))
    assert len(seeds) == 200
