"""Small calls of the functions of lesson 11, for questions about students' own code."""

from utils.questions.cases import Case


def _cloud_code(*rows: str) -> str:
    body = ",\n".join(f"    [{row}]" for row in rows)
    return f"cloud = np.array([\n{body},\n])\n"


def _boxes_case(cloud: str, labels: str, asked: str) -> Case:
    return Case(
        f"{cloud}labels = np.array({labels})\n"
        f"boxes = np.asarray(get_oriented_boxes(cloud, labels))\n{asked}"
    )


LONG = _cloud_code("-4.0, 0.0, 0.0", "4.0, 0.0, 0.0", "0.0, 1.0, 0.0", "0.0, -1.0, 0.0")
FLAT = _cloud_code("0.0, 0.0, 0.0", "0.0, 6.0, 0.0", "2.0, 0.0, 1.0", "2.0, 6.0, 1.0")
MORE = _cloud_code(
    *("0.0, 0.0, 1.0", "8.0, 0.0, 1.0", "0.0, 2.0, 1.0", "8.0, 2.0, 3.0"),
    *("20.0, 0.0, 0.0", "24.0, 0.0, 0.0", "20.0, 1.0, 0.0", "24.0, 1.0, 5.0"),
)
FIRST, BOTH = "[1, 1, 1, 1, 0, 0, 0, 0]", "[2, 2, 2, 2, 1, 1, 1, 1]"
CASES = {
    "principal_axes": (
        Case(f"{LONG}np.abs(principal_axes(cloud))[:, 0]"),
        Case(
            _cloud_code("0.0, 0.0, 3.0", "0.0, 0.0, -3.0", "1.0, 0.0, 0.0", "-1.0, 0.0, 0.0")
            + "np.abs(principal_axes(cloud))[:, 0]"
        ),
        Case(
            _cloud_code("4.0, 3.0, 0.0", "-4.0, -3.0, 0.0", "0.0, 0.0, 1.0", "0.0, 0.0, -1.0")
            + "np.abs(principal_axes(cloud))[:, 0]"
        ),
        Case(f"{LONG}np.abs(principal_axes(cloud))[:, 1]"),
        Case(f"{LONG}np.linalg.det(principal_axes(cloud))"),
        Case(f"{LONG}principal_axes(cloud + [10.0, 5.0, 0.0])[2]"),
    ),
    "get_oriented_boxes": (
        _boxes_case(MORE, FIRST, "boxes.shape"),
        _boxes_case(MORE, BOTH, "boxes.max(axis=1)"),
        _boxes_case(MORE, FIRST, "boxes[0, :, 2]"),
        _boxes_case(MORE, BOTH, "boxes[0].min(axis=0)"),
        _boxes_case(FLAT, "[3, 3, 3, 3]", "boxes[0, 0]"),
        _boxes_case(FLAT, "[0, 0, 0, 0]", "boxes.shape"),
    ),
}
