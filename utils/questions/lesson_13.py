"""Small calls of the functions of lesson 13, for questions about students' own code."""

from utils.questions.cases import Case


def _unite_case(parent: str, *pairs: str, asked: str = "parent") -> Case:
    calls = "".join(f"unite(parent, {pair})\n" for pair in pairs)
    return Case(f"parent = np.array([{parent}])\n{calls}{asked}")


CASES = {
    "unite": (
        _unite_case("0, 1, 2, 3", "3, 1"),
        _unite_case("0, 1, 2, 3", "1, 2", "3, 2"),
        _unite_case("0, 0, 2, 2", "3, 1"),
        _unite_case("0, 0, 1, 3, 3", "2, 4"),
        _unite_case("0, 1, 1, 2, 4", "4, 3"),
    ),
}
