"""The points that likely slips keep agree with `docs/prices.md` and fit the slips' harm."""

from types import SimpleNamespace

import pytest

from tests import prices
from tests.prices import PAGE, all_slips, page, price_of, read_page
from tests.slips import MISSING, NAIVE, SMALL

CASES = {f"{exercise}: {slip.title}": (exercise, slip) for exercise, slip in all_slips()}
PRICES = read_page()
TOLERANCE = 0.006  # the page rounds to whole percents


def test_the_page_has_every_slip_of_every_exercise():
    listed = {f"{exercise}: {title}" for exercise, row in PRICES.items() for title in row}
    assert listed == CASES.keys()
    assert min(map(len, PRICES.values())) >= 15


def test_the_page_agrees_with_its_generator():
    assert PAGE.read_text("utf-8") == page(PRICES)


@pytest.mark.parametrize("case", CASES)
def test_the_share_that_each_slip_keeps_fits_its_harm(case):
    exercise, slip = CASES[case]
    price = PRICES[exercise][slip.title]
    assert price.checks <= price.kept < 1
    if slip.harm is NAIVE:
        assert price.kept <= 0.1
    elif slip.harm is MISSING:
        assert price.kept <= 0.5
    elif slip.harm is SMALL:
        assert price.kept >= 0.6


def test_a_verdict_on_a_machine_that_is_too_busy_is_not_a_price(monkeypatch):
    monkeypatch.setattr(prices, "judge", lambda *about, **more: SimpleNamespace(starved=True))
    monkeypatch.setattr(prices, "choose_sandbox", lambda: None)  # there may be none
    with pytest.raises(TimeoutError, match="rows instead of columns: .* machine was busy"):
        price_of(CASES["horizontal_distance: rows instead of columns"])


@pytest.mark.proof
@pytest.mark.parametrize("case", CASES)
def test_the_page_has_the_points_that_the_judge_gives(case):
    exercise, slip = CASES[case]
    price, on_page = price_of((exercise, slip)), PRICES[exercise][slip.title]
    assert price.kept == pytest.approx(on_page.kept, abs=TOLERANCE)
