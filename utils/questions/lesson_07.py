"""Small calls of the functions of lesson 07, for questions about students' own code."""

from utils.questions.cases import Case


def _cloud_code(*rows: str) -> str:
    body = ",\n".join(f"    [{row}]" for row in rows)
    return f"cloud = np.array([\n{body},\n])\n"


A = _cloud_code("0.0, 0.0, 0.0", "2.0, 1.0, 1.0", "4.0, -3.0, 0.0")
B = _cloud_code("1.0, 1.0, 5.0", "-1.0, 2.0, 0.0")
C = _cloud_code("3.0, 0.0, 0.0, 9.0", "0.0, 0.0, -2.0, 1.0", "1.0, 1.0, 1.0, 1.0")
D = _cloud_code("2.0, 0.0, 0.0", "2.5, 0.0, 0.0", "1.0, -1.0, 1.0")
BOXES = (
    (A, "(-1.0, -1.0, -1.0), (3.0, 2.0, 2.0)"),
    (B, "(0.0, 0.0, 0.0), (2.0, 2.0, 2.0)"),
    (C, "(0.0, 0.0, -3.0), (2.0, 2.0, 2.0)"),
    (D, "(0.0, -1.0, 0.0), (2.0, 1.0, 1.0)"),
)
CASES = {
    "filter_by_distance": (
        Case(
            _cloud_code("3.0, 4.0, 0.0", "6.0, 8.0, 0.0", "0.0, 1.0, 9.0")
            + "filter_by_distance(cloud, 6.0)"
        ),
        Case(_cloud_code("0.0, 9.0, 5.0", "8.0, 8.0, 0.0") + "filter_by_distance(cloud)"),
        Case(_cloud_code("-3.0, 4.0, 1.0", "0.0, -2.0, 0.0") + "filter_by_distance(cloud, 4.0)"),
        Case(_cloud_code("3.0, 4.0, 0.0", "4.0, 4.0, 0.0") + "filter_by_distance(cloud, 5.0)"),
        Case(
            _cloud_code("1.0, 0.0, 0.0, 50.0", "0.0, 30.0, 0.0, 1.0")
            + "filter_by_distance(cloud, 20.0)"
        ),
    ),
    "crop_region": tuple(Case(f"{cloud}crop_region(cloud, {box})") for cloud, box in BOXES),
    "remove_ego_returns": tuple(
        Case(f"{cloud}remove_ego_returns(cloud, {box})") for cloud, box in BOXES
    ),
}
