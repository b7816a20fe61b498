"""Slips in lesson 07."""

from tests.slips import PARTLY, SMALL, USELESS, Slip

_BOX = "((xyz >= minimum) & (xyz <= maximum)).all(axis=1)"

SLIPS = {
    "filter_by_distance": [
        Slip("the other way round", "<= distance]", "> distance]", USELESS),
        Slip("z for y", "cloud[:, 1]", "cloud[:, 2]", USELESS),
        Slip("x alone", "np.hypot(cloud[:, 0], cloud[:, 1])", "cloud[:, 0]", USELESS),
        Slip(
            "x and y added",
            "np.hypot(cloud[:, 0], cloud[:, 1])",
            "cloud[:, 0] + cloud[:, 1]",
            USELESS,
        ),
        Slip(
            "no root",
            "np.hypot(cloud[:, 0], cloud[:, 1])",
            "cloud[:, 0]**2 + cloud[:, 1]**2",
            USELESS,
        ),
        Slip(
            "one length for all",
            "np.hypot(cloud[:, 0], cloud[:, 1])",
            "np.linalg.norm(cloud[:, :2])",
            USELESS,
        ),
        Slip(
            "along the columns",
            "np.hypot(cloud[:, 0], cloud[:, 1])",
            "np.linalg.norm(cloud[:, :2], axis=0)",
            USELESS,
        ),
        Slip(
            "the whole row",
            "np.hypot(cloud[:, 0], cloud[:, 1])",
            "np.linalg.norm(cloud, axis=1)",
            PARTLY,
        ),
        Slip(
            "through the air",
            "np.hypot(cloud[:, 0], cloud[:, 1])",
            "np.linalg.norm(cloud[:, :3], axis=1)",
            PARTLY,
        ),
        Slip(
            "a square",
            "np.hypot(cloud[:, 0], cloud[:, 1])",
            "np.abs(cloud[:, :2]).max(axis=1)",
            PARTLY,
        ),
        Slip("another default", "=10.0", "=12.0", SMALL),
        Slip("a fixed distance", "<= distance]", "<= 10]", PARTLY),
        Slip(
            "places alone",
            "cloud[along_the_road <= distance]",
            "cloud[along_the_road <= distance, :3]",
            SMALL,
        ),
        Slip(
            "a half for a power of a half",
            "np.hypot(cloud[:, 0], cloud[:, 1])",
            "(cloud[:, 0] ** 2 + cloud[:, 1] ** 2) ** 1 / 2",
            USELESS,
        ),
        Slip(
            "sides added",
            "np.hypot(cloud[:, 0], cloud[:, 1])",
            "np.abs(cloud[:, 0]) + np.abs(cloud[:, 1])",
            PARTLY,
        ),
        Slip(
            "the mask", "cloud[along_the_road <= distance]", "along_the_road <= distance", USELESS
        ),
        Slip("no return", "return cloud[along", "cloud = cloud[along", USELESS),
    ],
    "crop_region": [
        Slip("one is enough", ".all(axis=1)", ".any(axis=1)", USELESS),
        Slip("or", " & ", " | ", USELESS),
        Slip("one answer for all", ".all(axis=1)", ".all()", USELESS),
        Slip("along the columns", ".all(axis=1)", ".all(axis=0)", USELESS),
        Slip("the outside", "cloud[inside]", "cloud[~inside]", USELESS),
        Slip(
            "corners exchanged",
            "(xyz >= minimum) & (xyz <= maximum)",
            "(xyz >= maximum) & (xyz <= minimum)",
            USELESS,
        ),
        Slip("no lower corner", "(xyz >= minimum) & (xyz <= maximum)", "(xyz <= maximum)", PARTLY),
        Slip("no upper corner", "(xyz >= minimum) & (xyz <= maximum)", "(xyz >= minimum)", PARTLY),
        Slip("no height", _BOX, "((xyz >= minimum) & (xyz <= maximum))[:, :2].all(axis=1)", PARTLY),
        Slip("places alone", "cloud[inside]", "xyz[inside]", SMALL),
        Slip("the mask", "return cloud[inside]", "return inside", USELESS),
        Slip("no return", "return cloud[inside]", "cloud = cloud[inside]", USELESS),
        Slip("the first corner for all axes", "xyz >= minimum", "xyz >= minimum[0]", USELESS),
        Slip("x alone", ".all(axis=1)", "[:, 0]", PARTLY),
        Slip(
            "the lesson's own region",
            "(xyz >= minimum) & (xyz <= maximum)",
            "(xyz >= (-10, -5, -2)) & (xyz <= (30, 6, 1))",
            PARTLY,
        ),
    ],
    "remove_ego_returns": [
        Slip("the inside", "cloud[~is_ours]", "cloud[is_ours]", USELESS),
        Slip("what shares one", ".all(axis=1)", ".any(axis=1)", USELESS),
        Slip("or", " & ", " | ", USELESS),
        Slip("one answer for all", ".all(axis=1)", ".all()", USELESS),
        Slip("no lower corner", "(xyz >= minimum) & (xyz <= maximum)", "(xyz <= maximum)", PARTLY),
        Slip("no upper corner", "(xyz >= minimum) & (xyz <= maximum)", "(xyz >= minimum)", PARTLY),
        Slip(
            "turned round one by one",
            _BOX,
            "~((xyz < minimum) | (xyz > maximum)).all(axis=1)",
            USELESS,
        ),
        Slip("no height", _BOX, "((xyz >= minimum) & (xyz <= maximum))[:, :2].all(axis=1)", PARTLY),
        Slip("places alone", "cloud[~is_ours]", "xyz[~is_ours]", SMALL),
        Slip("the mask", "return cloud[~is_ours]", "return ~is_ours", USELESS),
        Slip("no return", "return cloud[~is_ours]", "cloud = cloud[~is_ours]", USELESS),
        Slip("not for ~", "cloud[~is_ours]", "cloud[not is_ours]", USELESS),
        Slip("x alone", ".all(axis=1)", "[:, 0]", USELESS),
        Slip(
            "the lesson's own box",
            "(xyz >= minimum) & (xyz <= maximum)",
            "(xyz >= (-1.5, -1.7, -1.0)) & (xyz <= (2.6, 1.7, -0.4))",
            PARTLY,
        ),
        Slip("all four columns", "cloud[:, :3]", "cloud", USELESS),
    ],
}
