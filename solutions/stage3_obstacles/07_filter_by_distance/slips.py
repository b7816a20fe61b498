"""Slips in lesson 07."""

from tests.slips import PARTLY, SMALL, USELESS, Slip

_BOX = "((xyz >= minimum) & (xyz <= maximum)).all(axis=1)"

SLIPS = {
    "filter_by_distance": [
        Slip("the comparison is reversed", "<= distance]", "> distance]", USELESS),
        Slip("z instead of y", "cloud[:, 1]", "cloud[:, 2]", USELESS),
        Slip("uses only x", "np.hypot(cloud[:, 0], cloud[:, 1])", "cloud[:, 0]", USELESS),
        Slip(
            "adds x and y",
            "np.hypot(cloud[:, 0], cloud[:, 1])",
            "cloud[:, 0] + cloud[:, 1]",
            USELESS,
        ),
        Slip(
            "no square root",
            "np.hypot(cloud[:, 0], cloud[:, 1])",
            "cloud[:, 0]**2 + cloud[:, 1]**2",
            USELESS,
        ),
        Slip(
            "one distance for the whole cloud",
            "np.hypot(cloud[:, 0], cloud[:, 1])",
            "np.linalg.norm(cloud[:, :2])",
            USELESS,
        ),
        Slip(
            "axis=0 instead of axis=1",
            "np.hypot(cloud[:, 0], cloud[:, 1])",
            "np.linalg.norm(cloud[:, :2], axis=0)",
            USELESS,
        ),
        Slip(
            "the norm of the whole row",
            "np.hypot(cloud[:, 0], cloud[:, 1])",
            "np.linalg.norm(cloud, axis=1)",
            PARTLY,
        ),
        Slip(
            "the 3-D distance",
            "np.hypot(cloud[:, 0], cloud[:, 1])",
            "np.linalg.norm(cloud[:, :3], axis=1)",
            PARTLY,
        ),
        Slip(
            "a square instead of a circle",
            "np.hypot(cloud[:, 0], cloud[:, 1])",
            "np.abs(cloud[:, :2]).max(axis=1)",
            PARTLY,
        ),
        Slip("a different default", "=10.0", "=12.0", SMALL),
        Slip("a fixed distance of 10", "<= distance]", "<= 10]", PARTLY),
        Slip(
            "drops the intensity",
            "cloud[along_the_road <= distance]",
            "cloud[along_the_road <= distance, :3]",
            SMALL,
        ),
        Slip(
            "`** 1 / 2` without parentheses",
            "np.hypot(cloud[:, 0], cloud[:, 1])",
            "(cloud[:, 0] ** 2 + cloud[:, 1] ** 2) ** 1 / 2",
            USELESS,
        ),
        Slip(
            "the sum of absolute values",
            "np.hypot(cloud[:, 0], cloud[:, 1])",
            "np.abs(cloud[:, 0]) + np.abs(cloud[:, 1])",
            PARTLY,
        ),
        Slip(
            "returns the mask",
            "cloud[along_the_road <= distance]",
            "along_the_road <= distance",
            USELESS,
        ),
        Slip("no return statement", "return cloud[along", "cloud = cloud[along", USELESS),
        Slip(
            "columns shifted by one",
            "np.hypot(cloud[:, 0], cloud[:, 1])",
            "np.linalg.norm(cloud[:, 1:3], axis=1)",
            USELESS,
        ),
        Slip(
            "computes a mask but does not use it",
            "return cloud[along_the_road <= distance]",
            "is_near = along_the_road <= distance\n    return cloud",
            USELESS,
        ),
        Slip(
            "math.sqrt of a column",
            "np.hypot(cloud[:, 0], cloud[:, 1])",
            "math.sqrt(cloud[:, 0] ** 2 + cloud[:, 1] ** 2)",
            USELESS,
        ),
    ],
    "crop_region": [
        Slip("any instead of all", ".all(axis=1)", ".any(axis=1)", USELESS),
        Slip("or instead of and", " & ", " | ", USELESS),
        Slip("one answer for the whole cloud", ".all(axis=1)", ".all()", USELESS),
        Slip("axis=0 instead of axis=1", ".all(axis=1)", ".all(axis=0)", USELESS),
        Slip("keeps the points outside", "cloud[inside]", "cloud[~inside]", USELESS),
        Slip(
            "swaps the corners",
            "(xyz >= minimum) & (xyz <= maximum)",
            "(xyz >= maximum) & (xyz <= minimum)",
            USELESS,
        ),
        Slip("ignores minimum", "(xyz >= minimum) & (xyz <= maximum)", "(xyz <= maximum)", PARTLY),
        Slip("ignores maximum", "(xyz >= minimum) & (xyz <= maximum)", "(xyz >= minimum)", PARTLY),
        Slip(
            "ignores the height",
            _BOX,
            "((xyz >= minimum) & (xyz <= maximum))[:, :2].all(axis=1)",
            PARTLY,
        ),
        Slip("drops the intensity", "cloud[inside]", "xyz[inside]", SMALL),
        Slip("returns the mask", "return cloud[inside]", "return inside", USELESS),
        Slip("no return statement", "return cloud[inside]", "cloud = cloud[inside]", USELESS),
        Slip("uses minimum[0] for all axes", "xyz >= minimum", "xyz >= minimum[0]", USELESS),
        Slip("compares only x", ".all(axis=1)", "[:, 0]", PARTLY),
        Slip(
            "always uses the lesson's region",
            "(xyz >= minimum) & (xyz <= maximum)",
            "(xyz >= (-10, -5, -2)) & (xyz <= (30, 6, 1))",
            PARTLY,
        ),
        Slip("columns shifted by one", "cloud[:, :3]", "cloud[:, 1:4]", USELESS),
        Slip(
            "computes a mask but does not use it", "return cloud[inside]", "return cloud", USELESS
        ),
    ],
    "remove_ego_returns": [
        Slip("keeps the points inside", "cloud[~is_ours]", "cloud[is_ours]", USELESS),
        Slip("any instead of all", ".all(axis=1)", ".any(axis=1)", USELESS),
        Slip("or instead of and", " & ", " | ", USELESS),
        Slip("one answer for the whole cloud", ".all(axis=1)", ".all()", USELESS),
        Slip("ignores minimum", "(xyz >= minimum) & (xyz <= maximum)", "(xyz <= maximum)", PARTLY),
        Slip("ignores maximum", "(xyz >= minimum) & (xyz <= maximum)", "(xyz >= minimum)", PARTLY),
        Slip(
            "keeps only points outside on every axis",
            _BOX,
            "~((xyz < minimum) | (xyz > maximum)).all(axis=1)",
            USELESS,
        ),
        Slip(
            "ignores the height",
            _BOX,
            "((xyz >= minimum) & (xyz <= maximum))[:, :2].all(axis=1)",
            PARTLY,
        ),
        Slip("drops the intensity", "cloud[~is_ours]", "xyz[~is_ours]", SMALL),
        Slip("returns the mask", "return cloud[~is_ours]", "return ~is_ours", USELESS),
        Slip("no return statement", "return cloud[~is_ours]", "cloud = cloud[~is_ours]", USELESS),
        Slip("`not` instead of `~`", "cloud[~is_ours]", "cloud[not is_ours]", USELESS),
        Slip(
            "swaps the corners",
            "(xyz >= minimum) & (xyz <= maximum)",
            "(xyz >= maximum) & (xyz <= minimum)",
            USELESS,
        ),
        Slip("uses the last three columns", "cloud[:, :3]", "cloud[:, -3:]", USELESS),
        Slip("compares only x", ".all(axis=1)", "[:, 0]", USELESS),
        Slip(
            "always uses the lesson's box",
            "(xyz >= minimum) & (xyz <= maximum)",
            "(xyz >= (-1.5, -1.7, -1.0)) & (xyz <= (2.6, 1.7, -0.4))",
            PARTLY,
        ),
        Slip("compares all four columns", "cloud[:, :3]", "cloud", USELESS),
        Slip("columns shifted by one", "cloud[:, :3]", "cloud[:, 1:4]", USELESS),
        Slip(
            "computes a mask but does not use it", "return cloud[~is_ours]", "return cloud", USELESS
        ),
    ],
}
