"""Slips in lesson 02."""

from tests.slips import USELESS, Slip

SLIPS = {
    "line_through": [
        Slip(
            "c with the wrong sign", "b, -(a * p[0] + b * p[1])", "b, a * p[0] + b * p[1]", USELESS
        ),
        Slip("turned without a sign", "a, b = -dy /", "a, b = dy /", USELESS),
    ],
}
