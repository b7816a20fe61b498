"""Small calls of the functions of lesson 04, for questions about students' own code."""

from utils.questions.cases import Case

# Nodes that report when their point is read.
WATCH = """visited = []


class WatchedNode(Node):
    def __getattribute__(self, name):
        if name == "point":
            visited.append(object.__getattribute__(self, "index"))
        return object.__getattribute__(self, name)


"""


def _insert_code(points: str, asked: str = "shape(tree.root)") -> str:
    return (
        f"{SHAPE if 'shape' in asked else ''}points = {points}\ntree = KdTree()\n"
        f"for index, point in enumerate(points):\n    tree.insert(point, index)\n{asked}"
    )


SHAPE = """def shape(node):  # the index, the left branch and the right branch
    return node and [node.index, shape(node.left), shape(node.right)]


"""
SMALL = """tree = KdTree()
tree.root = Node(
    [4.0, 2.0], 0,
    left=Node([2.0, 3.0], 1),
    right=Node([6.0, 1.0], 2))
"""
LARGE = """tree = KdTree()
tree.root = Node(
    [4.0, 2.0], 0,
    left=Node(
        [2.0, 3.0], 1,
        left=Node([1.0, 1.0], 3),
        right=Node([3.0, 5.0], 4)),
    right=Node(
        [7.0, 3.0], 2,
        right=Node([6.0, 4.0], 5)))
"""


def _visits_case(tree: str, search: str) -> Case:
    return Case(
        f"{tree}tree.search({search})",
        asked="Which nodes does the search visit, in order? Write their indices. A node is "
        "visited when its `point` is read for the first time.",
        run=f"{WATCH}{tree.replace('Node(', 'WatchedNode(')}tree.search({search})\n"
        "list(dict.fromkeys(visited))",
    )


CASES = {
    "insert": (
        Case(
            _insert_code("[[4.0, 2.0], [2.0, 3.0], [6.0, 1.0]]"),
            larger=_insert_code(
                "[[4.0, 2.0], [2.0, 3.0], [6.0, 1.0], [1.0, 5.0], [0.0, 1.0], [8.0, 0.0]]",
                "tree.root.index",
            ),
        ),
        Case(_insert_code("[[4.0, 2.0], [2.0, 3.0], [3.0, 1.0]]")),
        Case(_insert_code("[[4.0, 2.0], [4.0, 1.0], [4.0, 3.0]]")),
        Case(_insert_code("[[5.0, 5.0], [2.0, 6.0], [1.0, 7.0]]")),
        Case(_insert_code("[[3.0, 1.0], [1.0, 2.0], [2.0, 2.0]]")),
    ),
    "search": (
        Case(
            f"{SMALL}list(tree.search([3.0, 3.0], 1.5))",
            larger=f"{LARGE}list(tree.search([3.0, 3.0], 9.0))",
        ),
        Case(f"{LARGE}list(tree.search([3.0, 4.0], 1.5))"),
        Case(f"{LARGE}list(tree.search([5.0, 3.0], 2.5))"),
        Case(f"{SMALL}list(tree.search([4.0, 5.0], 1.0))"),
        _visits_case(SMALL, "[3.0, 3.0], 1.5"),
        _visits_case(LARGE, "[2.0, 1.0], 1.5"),
        _visits_case(LARGE, "[5.0, 2.0], 1.5"),
    ),
    "median_order": (
        Case("list(median_order(np.array([[3.0, 1.0], [1.0, 2.0], [2.0, 3.0]])))"),
        Case(
            "list(median_order(np.array([[4.0, 1.0], [3.0, 2.0], [2.0, 3.0], [1.0, 4.0]])))",
            larger="points = np.array([[6.0, 1.0], [5.0, 2.0], [4.0, 3.0], [3.0, 4.0],\n"
            "                   [2.0, 5.0], [1.0, 6.0], [7.0, 7.0], [8.0, 8.0]])\n"
            "list(median_order(points))",
        ),
        Case("list(median_order(np.array([[1.0, 5.0], [2.0, 4.0]])))"),
        Case(
            "points = np.array([[5.0, 1.0], [1.0, 3.0], [2.0, 0.0], [4.0, 4.0], [3.0, 2.0]])\n"
            "list(median_order(points))"
        ),
        Case("list(median_order(np.array([[2.0, 2.0]])))"),
    ),
}
