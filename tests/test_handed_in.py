"""Whatever else was handed in has another fingerprint."""

import itertools
import os

from hypothesis import given
from hypothesis import strategies as st

from grader.intake.handed_in import HandedIn


def handed_in(**parts):
    return HandedIn(**{"name": "06_filter_ground.ipynb", "data": b"{}"} | parts)


def test_a_module_is_not_the_end_of_a_notebook():
    beside = handed_in(modules={"helper": "x = 1"})
    behind = handed_in(data=b"{}\0helper\0x = 1")
    assert beside.fingerprint() != behind.fingerprint()


# Few letters, so that two ways to part the same text are often tried.
TEXTS = st.text("a\0 1", max_size=2)
HANDED_IN = st.builds(
    HandedIn,
    TEXTS,
    TEXTS.map(str.encode),
    TEXTS,
    st.dictionaries(TEXTS, TEXTS, max_size=2),
    st.lists(TEXTS, max_size=2).map(tuple),
)


@given(HANDED_IN, HANDED_IN)
def test_other_parts_have_another_fingerprint(one, other):
    assert (one.fingerprint() == other.fingerprint()) == (one == other)


@given(TEXTS, TEXTS, TEXTS, TEXTS)
def test_no_part_can_be_taken_for_one_of_another_kind(a, b, c, d):
    ways = (
        handed_in(notes=(a, b, c, d)),
        handed_in(notes=(a, b), modules={c: d}),
        handed_in(modules={a: b, c: d}),
        handed_in(complaint=a, notes=(b, c, d)),
        handed_in(complaint=a, notes=(b,), modules={c: d}),
        handed_in(name=a, notes=(b,), modules={c: d}),
        handed_in(data=a.encode(), notes=(b,), modules={c: d}),
    )
    for one, other in itertools.combinations(ways, 2):
        assert (one.fingerprint() == other.fingerprint()) == (one == other)


def test_a_name_that_is_no_text_has_a_fingerprint():
    names = [os.fsdecode(name) for name in (b"J\xfcrgen", b"J\xe4rgen", b"J?rgen")]
    assert len({handed_in(notes=(name,)).fingerprint() for name in names}) == 3
