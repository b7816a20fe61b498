"""Small calls of the functions of lesson 01, for questions about students' own code."""

from utils.questions.cases import Case


def _drop_case(*rows: str) -> Case:
    body = ",\n".join(f"    [{row}]" for row in rows)
    return Case(f"cloud = np.array([\n{body},\n])\ndrop_invalid(cloud)")


CASES = {
    "horizontal_distance": (
        Case("horizontal_distance(np.array([[3.0, 4.0, 2.0]]))"),
        Case("horizontal_distance(np.array([[0.0, 2.0, 1.0], [6.0, 8.0, 3.0]]))"),
        Case("horizontal_distance(np.array([[-3.0, 4.0, 0.0], [1.0, 0.0, 7.0]]))"),
        Case("horizontal_distance(np.array([[-6.0, -8.0, 1.0, 5.0]]))"),
        Case("horizontal_distance(np.array([[0.0, -5.0, -1.0, 9.0], [4.0, 3.0, 0.0, 2.0]]))"),
    ),
    # With as many rows as columns, a mask of the wrong shape would fit by chance.
    "drop_invalid": (
        _drop_case("1.0, 2.0, 0.0", "0.0, 0.0, 0.0", "np.nan, 1.0, 1.0", "3.0, 0.0, 1.0"),
        _drop_case("0.0, 0.0, 5.0", "np.inf, 1.0, 2.0", "4.0, 0.0, 0.0", "0.0, 0.0, 0.0"),
        _drop_case("0.0, 3.0, np.nan", "0.0, 3.0, 0.0", "2.0, -2.0, 0.0", "0.0, 0.0, 0.0"),
        _drop_case("0.0, 0.0, 0.0, 7.0", "1.0, 0.0, 2.0, 7.0", "3.0, -np.inf, 0.0, 7.0"),
        _drop_case("-1.0, 1.0, 0.0", "0.0, 0.0, 0.0"),
    ),
}
