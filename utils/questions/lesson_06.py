"""Small calls of the functions of lesson 06, for questions about students' own code."""

from utils.questions.cases import Case


def _cloud_code(*rows: str) -> str:
    body = ",\n".join(f"    [{row}]" for row in rows)
    return f"cloud = np.array([\n{body},\n])\n"


CASES = {
    "filter_ground": (
        Case(
            _cloud_code("1.0, 2.0, -1.5", "3.0, 4.0, 0.5", "5.0, 6.0, -1.0")
            + "filter_ground(cloud)"
        ),
        Case(_cloud_code("1.0, 0.0, -0.5", "2.0, 0.0, -2.0") + "filter_ground(cloud, -1.0)"),
        Case(
            _cloud_code("0.5, 3.0, 0.0", "1.0, 1.0, 1.0", "2.0, -3.0, 2.0")
            + "filter_ground(cloud, 1.0)"
        ),
        Case(_cloud_code("-2.0, 0.0, -1.2", "0.0, -2.0, -1.3") + "filter_ground(cloud)"),
        Case(_cloud_code("1.0, 1.0, -3.0, 8.0", "2.0, 2.0, 0.0, -9.0") + "filter_ground(cloud)"),
    ),
    "voxel_grid": (
        Case(
            _cloud_code("0.2, 0.0, 0.0", "0.6, 0.0, 0.0", "1.7, 0.0, 0.0")
            + "voxel_grid(cloud, 1.0)"
        ),
        Case(_cloud_code("-0.25, 0.0, 0.0", "0.25, 0.0, 0.0") + "voxel_grid(cloud, 1.0)"),
        Case(
            _cloud_code("1.0, 1.0, 0.0", "3.0, 1.0, 0.0", "1.0, 1.0, 2.0")
            + "voxel_grid(cloud, 4.0)"
        ),
        Case(
            _cloud_code("5.0, 0.0, 0.0", "1.0, 0.0, 0.0", "5.5, 0.0, 0.0")
            + "voxel_grid(cloud, 2.0)"
        ),
        Case(
            _cloud_code("0.25, 0.25, 0.25, 2.0", "0.25, 0.25, 0.75, 4.0") + "voxel_grid(cloud, 1.0)"
        ),
    ),
}
