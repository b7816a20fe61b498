"""Slips in lesson 01."""

from tests.slips import PARTLY, SMALL, USELESS, Slip

_ROOT = "np.sqrt(x**2 + y**2)"
_FINITE = "np.isfinite(xyz).all(axis=1)"
_ORIGIN = "(xyz == 0).all(axis=1)"
_MASK = "is_somewhere & ~is_origin"

SLIPS = {
    "horizontal_distance": [
        Slip("no square root", _ROOT, "x**2 + y**2", USELESS),
        Slip("height included", _ROOT, "np.linalg.norm(cloud[:, :3], axis=1)", USELESS),
        Slip("norm of the whole row", _ROOT, "np.linalg.norm(cloud, axis=1)", USELESS),
        Slip("z instead of y", "cloud[:, 1]", "cloud[:, 2]", USELESS),
        Slip(
            "y and z instead of x and y",
            "cloud[:, 0], cloud[:, 1]",
            "cloud[:, 1], cloud[:, 2]",
            USELESS,
        ),
        Slip("rows instead of columns", "cloud[:, 0], cloud[:, 1]", "cloud[0], cloud[1]", USELESS),
        Slip("squares subtracted", "x**2 + y**2", "x**2 - y**2", USELESS),
        Slip("square root of each term", _ROOT, "np.sqrt(x**2) + np.sqrt(y**2)", USELESS),
        Slip("square root of the squared sum", _ROOT, "np.sqrt((x + y) ** 2)", USELESS),
        Slip("no return statement", f"return {_ROOT}", f"distance = {_ROOT}", USELESS),
        Slip("needs four columns", "cloud[:, 0], cloud[:, 1]", "cloud.T[[0, 1, 3]][:2]", SMALL),
        Slip(
            "** 1 / 2 without parentheses",
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
            "returns only the first distance",
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
        Slip(
            "prints instead of returning",
            "return np.sqrt(x**2 + y**2)",
            "print(np.sqrt(x**2 + y**2))",
            USELESS,
        ),
        Slip("no axis argument", "np.sqrt(x**2 + y**2)", "np.linalg.norm(cloud[:, :2])", USELESS),
        Slip(
            "wrong axis",
            "np.sqrt(x**2 + y**2)",
            "np.linalg.norm(cloud[:, :2], axis=0)",
            USELESS,
        ),
        Slip("math.sqrt of a column", "np.sqrt(x", "math.sqrt(x", USELESS),
    ],
    "drop_invalid": [
        Slip("| instead of &", "is_somewhere & ~", "is_somewhere | ~", USELESS),
        Slip("~ missing", "& ~is_origin", "& is_origin", USELESS),
        Slip("inverted mask", f"cloud[{_MASK}]", f"cloud[~({_MASK})]", USELESS),
        Slip("drops only (0, 0, 0)", _MASK, "~is_origin", PARTLY),
        Slip("drops only non-finite rows", _MASK, "is_somewhere", PARTLY),
        Slip("drops NaN but not infinity", "np.isfinite(xyz)", "(~np.isnan(xyz))", SMALL),
        Slip(
            "drops NaN only if all coordinates are NaN",
            _FINITE,
            "~np.isnan(xyz).all(axis=1)",
            PARTLY,
        ),
        Slip(
            "drops rows with any coordinate equal to 0", _ORIGIN, "(xyz == 0).any(axis=1)", PARTLY
        ),
        Slip(
            "keeps rows with any finite coordinate", _FINITE, "np.isfinite(xyz).any(axis=1)", PARTLY
        ),
        Slip("tests all four columns", "cloud[:, :3]", "cloud", PARTLY),
        Slip("drops rows whose sum is 0", _ORIGIN, "xyz.sum(axis=1) == 0", SMALL),
        Slip("loses the intensity", f"cloud[{_MASK}]", f"xyz[{_MASK}]", PARTLY),
        Slip("no axis argument", _FINITE, "np.isfinite(xyz).all()", PARTLY),
        Slip("returns the mask", f"cloud[{_MASK}]", _MASK, USELESS),
        Slip("drops points close to the sensor", "xyz == 0", "np.abs(xyz) < 0.3", SMALL),
        Slip(
            "compares with NaN",
            "np.isfinite(xyz).all(axis=1)",
            "(xyz != np.nan).all(axis=1)",
            PARTLY,
        ),
        Slip("and instead of &", "is_somewhere & ~", "is_somewhere and ~", USELESS),
        Slip("columns shifted by one", "cloud[:, :3]", "cloud[:, 1:4]", USELESS),
        Slip(
            "computes a mask but does not use it",
            "return cloud[is_somewhere & ~is_origin]",
            "is_kept = is_somewhere & ~is_origin\n    return cloud",
            USELESS,
        ),
    ],
}
