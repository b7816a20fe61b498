"""Slips in lesson 01."""

from tests.slips import PARTLY, SMALL, USELESS, Slip

_ROOT = "np.sqrt(x**2 + y**2)"
_FINITE = "np.isfinite(xyz).all(axis=1)"
_ORIGIN = "(xyz == 0).all(axis=1)"
_MASK = "is_somewhere & ~is_origin"

SLIPS = {
    "horizontal_distance": [
        Slip("no square root", _ROOT, "x**2 + y**2", USELESS),
        Slip("height is mixed in", _ROOT, "np.linalg.norm(cloud[:, :3], axis=1)", USELESS),
        Slip("the whole row is measured", _ROOT, "np.linalg.norm(cloud, axis=1)", USELESS),
        Slip("x and z", "cloud[:, 1]", "cloud[:, 2]", USELESS),
        Slip("y and z", "cloud[:, 0], cloud[:, 1]", "cloud[:, 1], cloud[:, 2]", USELESS),
        Slip("rows for columns", "cloud[:, 0], cloud[:, 1]", "cloud[0], cloud[1]", USELESS),
        Slip("a minus between the squares", "x**2 + y**2", "x**2 - y**2", USELESS),
        Slip("the root of each part", _ROOT, "np.sqrt(x**2) + np.sqrt(y**2)", USELESS),
        Slip("the root of the sum", _ROOT, "np.sqrt((x + y) ** 2)", USELESS),
        Slip("no return", f"return {_ROOT}", f"distance = {_ROOT}", USELESS),
        Slip("needs four columns", "cloud[:, 0], cloud[:, 1]", "cloud.T[[0, 1, 3]][:2]", SMALL),
        Slip(
            "a half for a power of a half",
            "np.sqrt(x**2 + y**2)",
            "(x**2 + y**2) ** 1 / 2",
            USELESS,
        ),
        Slip(
            "return inside the loop",
            "x, y = cloud[:, 0], cloud[:, 1]\n    return np.sqrt(x**2 + y**2)",
            "distances = np.zeros(len(cloud))\n"
            "    for row in range(len(cloud)):\n"
            "        distances[row] = np.hypot(cloud[row, 0], cloud[row, 1])\n"
            "        return distances",
            USELESS,
        ),
        Slip(
            "return one value inside the loop",
            "x, y = cloud[:, 0], cloud[:, 1]\n    return np.sqrt(x**2 + y**2)",
            "for x, y in cloud[:, :2]:\n        return np.sqrt(x**2 + y**2)",
            USELESS,
        ),
        Slip(
            "rounded to centimetres",
            "np.sqrt(x**2 + y**2)",
            "np.sqrt(x**2 + y**2).round(2)",
            PARTLY,
        ),
        Slip("prints", "return np.sqrt(x**2 + y**2)", "print(np.sqrt(x**2 + y**2))", USELESS),
        Slip("no axis", "np.sqrt(x**2 + y**2)", "np.linalg.norm(cloud[:, :2])", USELESS),
        Slip(
            "the wrong axis",
            "np.sqrt(x**2 + y**2)",
            "np.linalg.norm(cloud[:, :2], axis=0)",
            USELESS,
        ),
    ],
    "drop_invalid": [
        Slip("| for &", "is_somewhere & ~", "is_somewhere | ~", USELESS),
        Slip("no ~", "& ~is_origin", "& is_origin", USELESS),
        Slip("the mask is turned around", f"cloud[{_MASK}]", f"cloud[~({_MASK})]", USELESS),
        Slip("only (0, 0, 0)", _MASK, "~is_origin", PARTLY),
        Slip("only what is not finite", _MASK, "is_somewhere", PARTLY),
        Slip("NaN, but not infinity", "np.isfinite(xyz)", "(~np.isnan(xyz))", SMALL),
        Slip("not all for none", _FINITE, "~np.isnan(xyz).all(axis=1)", PARTLY),
        Slip("any coordinate of 0", _ORIGIN, "(xyz == 0).any(axis=1)", PARTLY),
        Slip("any finite coordinate", _FINITE, "np.isfinite(xyz).any(axis=1)", PARTLY),
        Slip("all four columns", "cloud[:, :3]", "cloud", PARTLY),
        Slip("the sum is 0", _ORIGIN, "xyz.sum(axis=1) == 0", SMALL),
        Slip("the intensity is lost", f"cloud[{_MASK}]", f"xyz[{_MASK}]", PARTLY),
        Slip("no axis", _FINITE, "np.isfinite(xyz).all()", PARTLY),
        Slip("returns the mask", f"cloud[{_MASK}]", _MASK, USELESS),
        Slip("close to 0 counts as 0", "xyz == 0", "np.abs(xyz) < 0.3", SMALL),
        Slip(
            "compares with NaN",
            "np.isfinite(xyz).all(axis=1)",
            "(xyz != np.nan).all(axis=1)",
            PARTLY,
        ),
        Slip("and for &", "is_somewhere & ~", "is_somewhere and ~", USELESS),
    ],
}
