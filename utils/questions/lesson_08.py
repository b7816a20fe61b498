"""Small calls of the functions of lesson 08, for questions about students' own code."""

from utils.questions.cases import Case


def _boxes_code(labels: str, asked: str) -> str:
    return (
        "cloud = np.array([[1.0, 2.0, 0.0], [3.0, 5.0, 1.0], [9.0, 9.0, 9.0], [8.0, 9.0, 7.0]])\n"
        f"labels = np.array({labels})\n"
        f"boxes = np.asarray(get_bounding_boxes(cloud, labels))\n{asked}"
    )


CASES = {
    "get_bounding_boxes": (
        Case(
            _boxes_code("[1, 1, 2, 2]", "boxes[0, 1]"),
            larger=_boxes_code("[1, 2, 3, 4]", "boxes.shape"),
        ),
        Case(_boxes_code("[1, 1, 0, 0]", "boxes.shape")),
        Case(_boxes_code("[2, 2, 1, 1]", "boxes[0, 0]")),
        Case(_boxes_code("[3, 3, 0, 3]", "boxes.max(axis=1)")),
        Case(_boxes_code("[1, 1, 2, 2]", "boxes[1, 6]")),
        Case(_boxes_code("[5, 1, 5, 0]", "boxes.min(axis=1)")),
    ),
}
