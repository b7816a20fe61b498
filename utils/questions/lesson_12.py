"""Small calls of the functions of lesson 12, for questions about students' own code."""

from utils.questions.cases import Case

CUBE = """cube = np.array([[i & 1, i >> 1 & 1, i >> 2] for i in range(8)]) - 0.5


def at(x, y=0.0):  # a cube of 1 m around (x, y, 0)
    return cube + [x, y, 0.0]


"""
# A flat road, and blocks of points that are about a metre in size.
ROAD = """def block(x, y, z, side):  # points 0.25 m apart
    steps = np.arange(0.0, side, 0.25)
    return np.stack(np.meshgrid(x + steps, y + steps, z + steps), axis=-1).reshape(-1, 3)


"""


def _match_code(previous: str, current: str, distance: float) -> str:
    return (
        f"{CUBE}previous = np.array([{previous}])\ncurrent = np.array([{current}])\n"
        f"match_boxes(previous, current, {distance})"
    )


def _detect_code(blocks: str, asked: str = "len(boxes)") -> str:
    return f"{ROAD}cloud = np.concatenate([{blocks}])\nboxes = detect_obstacles(cloud)\n{asked}"


CASES = {
    "match_boxes": (
        Case(
            _match_code("at(10.0), at(20.0)", "at(20.5), at(11.0)", 2.0),
            larger=_match_code(
                "at(10.0), at(20.0), at(30.0), at(40.0)",
                "at(20.5), at(11.0), at(31.0), at(40.5)",
                2.0,
            ),
        ),
        Case(_match_code("at(0.0)", "at(5.0), at(0.5)", 1.0)),
        Case(_match_code("at(0.0), at(3.0)", "at(9.0)", 4.0)),
        Case(_match_code("at(0.0), at(4.0)", "at(0.0, 3.0), at(4.0, 1.0)", 2.0)),
        Case(_match_code("at(1.0), at(2.0)", "at(2.25)", 3.0)),
    ),
    "detect_obstacles": (
        Case(_detect_code("block(8.0, 0.0, -0.9, 1.0), block(12.0, 2.0, -0.9, 1.0)")),
        Case(_detect_code("block(8.0, 0.0, -0.9, 1.0)", "np.min(boxes, axis=(0, 1))")),
        Case(_detect_code("block(8.0, 0.0, -0.9, 1.0), block(9.2, 0.0, -0.9, 1.0)")),
        Case(_detect_code("block(6.0, 1.0, -0.9, 1.0), block(200.0, 0.0, -0.9, 1.0)")),
        Case(_detect_code("block(6.0, 1.0, -0.9, 1.0), block(10.0, 1.0, -0.9, 0.3)")),
        Case(_detect_code("block(8.0, 0.0, -0.9, 1.0), np.zeros((50, 3))")),
        Case(_detect_code("block(8.0, 0.0, -0.9, 0.7)")),
    ),
}
