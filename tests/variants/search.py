# Answers to search of lesson 04; see grader/variants.py.

# %% right: a stack of places
def search(tree, target, tolerance):
    found, stack = [], [(tree.root, 0)]
    while stack:
        node, depth = stack.pop()
        if node is not None:
            if np.linalg.norm(np.asarray(node.point) - target) <= tolerance:
                found.append(node.index)
            axis = depth % len(target)
            if node.point[axis] > target[axis] - tolerance:
                stack.append((node.left, depth + 1))
            if node.point[axis] <= target[axis] + tolerance:
                stack.append((node.right, depth + 1))
    return found

# %% right: a function that calls itself, a set back
def search(tree, target, tolerance):
    found = set()

    def visit(node, axis):
        if node is None:
            return
        if dist(node.point, target) <= tolerance:
            found.add(node.index)
        below, above = target[axis] - tolerance, target[axis] + tolerance
        following = (axis + 1) % len(target)
        if below <= node.point[axis]:
            visit(node.left, following)
        if above >= node.point[axis]:
            visit(node.right, following)

    import sys
    sys.setrecursionlimit(10_000)
    visit(tree.root, 0)
    return found

# %% right: the box first, then the circle; an array back
def search(tree, target, tolerance):
    target = np.asarray(target, dtype=float)
    found, queue = [], deque([(0, tree.root)])
    while queue:
        depth, node = queue.popleft()
        if node is None:
            continue
        step = np.asarray(node.point, dtype=float) - target
        if (np.abs(step) <= tolerance).all() and (step @ step) <= tolerance ** 2:
            found.append(node.index)
        along = step[depth % len(target)]
        if along > -tolerance:
            queue.append((depth + 1, node.left))
        if along <= tolerance:
            queue.append((depth + 1, node.right))
    return np.array(found, dtype=np.int32)

# %% right: by the signed distance to the cut, own side first
def search(tree, target, tolerance):
    print("searching around", target)
    result, todo = [], []
    if tree.root is not None:
        todo.append((tree.root, 0))
    while todo:
        node, depth = todo.pop(0)
        squares = sum((a - b) ** 2 for a, b in zip(node.point, target))
        if squares ** 0.5 <= tolerance:
            result.append(int(node.index))
        k = depth % len(target)
        offset = target[k] - node.point[k]
        own, other = (node.left, node.right) if offset < 0 else (node.right, node.left)
        if own is not None:
            todo.append((own, depth + 1))
        if abs(offset) <= tolerance and other is not None:
            todo.append((other, depth + 1))
    return tuple(result)

# %% right: a generator made into a list, with a helper in another cell
def within(node, target, tolerance):
    return sum((float(a) - float(b)) ** 2 for a, b in zip(node.point, target)) \
        <= tolerance * tolerance
# ---- another cell ----
def search(tree, target, tolerance):
    def walk():
        level, axis = [tree.root], 0
        while level:
            below = []
            for node in level:
                if node is None:
                    continue
                if within(node, target, tolerance):
                    yield node.index
                if target[axis] - tolerance < node.point[axis]:
                    below.append(node.left)
                if target[axis] + tolerance >= node.point[axis]:
                    below.append(node.right)
            level, axis = below, (axis + 1) % len(target)
    return list(walk())

# %% right: a class of one's own, without the lesson's plant
class KdTree:
    def __init__(self):
        self.root = None

    def insert(self, point, index):
        if self.root is None:
            self.root = Node(point, index)
            return
        node, depth = self.root, 0
        while True:
            axis = depth % len(point)
            name = "left" if point[axis] < node.point[axis] else "right"
            if getattr(node, name) is None:
                setattr(node, name, Node(point, index))
                return
            node, depth = getattr(node, name), depth + 1

    def search(self, target, tolerance):
        hits, open_nodes = [], [(self.root, 0)]
        while open_nodes:
            node, depth = open_nodes.pop()
            if node is None:
                continue
            if dist(node.point, target) <= tolerance:
                hits.append(node.index)
            axis = depth % len(target)
            if target[axis] - tolerance < node.point[axis]:
                open_nodes.append((node.left, depth + 1))
            if target[axis] + tolerance >= node.point[axis]:
                open_nodes.append((node.right, depth + 1))
        return hits

# %% wrong: strictly greater on the right
# loses: includes_the_border, test_search_border
# says: with the equals sign
def search(tree, target, tolerance):
    found, stack = [], [(tree.root, 0)]
    while stack:
        node, depth = stack.pop()
        if node is None:
            continue
        if dist(node.point, target) <= tolerance:
            found.append(node.index)
        axis = depth % len(target)
        if target[axis] - tolerance < node.point[axis]:
            stack.append((node.left, depth + 1))
        if target[axis] + tolerance > node.point[axis]:
            stack.append((node.right, depth + 1))
    return found

# %% wrong: only the target's own side
# loses: looks_on_both_sides, test_search_plane, test_search_street
# says: two ifs, no else
def search(tree, target, tolerance):
    found, node, depth = [], tree.root, 0
    while node is not None:
        if dist(node.point, target) <= tolerance:
            found.append(node.index)
        axis = depth % len(target)
        node = node.left if target[axis] < node.point[axis] else node.right
        depth += 1
    return found

# %% wrong: else instead of a second if
# loses: looks_on_both_sides, test_search_plane
# says: two ifs, no else
def search(tree, target, tolerance):
    found, stack = [], [(tree.root, 0)]
    while stack:
        node, depth = stack.pop()
        if node is None:
            continue
        if dist(node.point, target) <= tolerance:
            found.append(node.index)
        axis = depth % len(target)
        if target[axis] - tolerance < node.point[axis]:
            stack.append((node.left, depth + 1))
        else:
            stack.append((node.right, depth + 1))
    return found

# %% wrong: the box decides
# loses: measures_a_circle, test_search_plane, test_search_street
# says: The box only decides where to look
def search(tree, target, tolerance):
    found, stack = [], [(tree.root, 0)]
    while stack:
        node, depth = stack.pop()
        if node is None:
            continue
        if all(abs(a - b) <= tolerance for a, b in zip(node.point, target)):
            found.append(node.index)
        axis = depth % len(target)
        if target[axis] - tolerance < node.point[axis]:
            stack.append((node.left, depth + 1))
        if target[axis] + tolerance >= node.point[axis]:
            stack.append((node.right, depth + 1))
    return found

# %% wrong: asks every node
# loses: leaves_regions_out, test_search_prunes
# says: beyond the tolerance
def search(tree, target, tolerance):
    found, stack = [], [tree.root]
    while stack:
        node = stack.pop()
        if node is not None:
            if dist(node.point, target) <= tolerance:
                found.append(node.index)
            stack += [node.left, node.right]
    return found

# %% wrong: asks every node but those that stand in the wrong place
# loses: leaves_regions_out, test_search_prunes
# says: on the paths that the splits leave open
def search(tree, target, tolerance):
    found = []
    stack = [(tree.root, 0, [-np.inf] * len(target), [np.inf] * len(target))]
    while stack:
        node, depth, low, high = stack.pop()
        if node is None:
            continue
        axis = depth % len(target)
        in_place = all(a <= x <= b for a, x, b in zip(low, node.point, high))
        if in_place and dist(node.point, target) <= tolerance:
            found.append(node.index)
        above, below = list(low), list(high)
        above[axis] = below[axis] = node.point[axis]
        stack += [(node.left, depth + 1, low, below), (node.right, depth + 1, above, high)]
    return found

# %% wrong: prunes on one side only
# loses: leaves_regions_out, test_search_prunes
# says: beyond the tolerance
def search(tree, target, tolerance):
    found, stack = [], [(tree.root, 0)]
    while stack:
        node, depth = stack.pop()
        if node is None:
            continue
        if dist(node.point, target) <= tolerance:
            found.append(node.index)
        axis = depth % len(target)
        stack.append((node.left, depth + 1))
        if target[axis] + tolerance >= node.point[axis]:
            stack.append((node.right, depth + 1))
    return found

# %% wrong: squared distance against plain tolerance
# loses: measures_a_circle, test_search_plane
# says: the square root of the sum of squares
def search(tree, target, tolerance):
    found, stack = [], [(tree.root, 0)]
    while stack:
        node, depth = stack.pop()
        if node is None:
            continue
        if sum((a - b) ** 2 for a, b in zip(node.point, target)) <= tolerance:
            found.append(node.index)
        axis = depth % len(target)
        if target[axis] - tolerance < node.point[axis]:
            stack.append((node.left, depth + 1))
        if target[axis] + tolerance >= node.point[axis]:
            stack.append((node.right, depth + 1))
    return found

# %% wrong: two dimensions are written into the function
# loses: searches_space, test_search_street
# says: Not found
def search(tree, target, tolerance):
    found, stack = [], [(tree.root, 0)]
    while stack:
        node, depth = stack.pop()
        if node is None:
            continue
        if dist(node.point, target) <= tolerance:
            found.append(node.index)
        axis = depth % 2
        if target[axis] - tolerance < node.point[axis]:
            stack.append((node.left, depth + 1))
        if target[axis] + tolerance >= node.point[axis]:
            stack.append((node.right, depth + 1))
    return found

# %% wrong: returns the points
# loses: finds_the_quiz, test_search_plane, test_search_street
# says: returns the indices
def search(tree, target, tolerance):
    found, stack = [], [(tree.root, 0)]
    while stack:
        node, depth = stack.pop()
        if node is None:
            continue
        if dist(node.point, target) <= tolerance:
            found.append(node.point)
        axis = depth % len(target)
        if target[axis] - tolerance < node.point[axis]:
            stack.append((node.left, depth + 1))
        if target[axis] + tolerance >= node.point[axis]:
            stack.append((node.right, depth + 1))
    return found

# %% wrong: strictly closer than the tolerance
# loses: includes_the_border, test_search_border
# says: compare the distance with <=
def search(tree, target, tolerance):
    found, stack = [], [(tree.root, 0)]
    while stack:
        node, depth = stack.pop()
        if node is None:
            continue
        if dist(node.point, target) < tolerance:
            found.append(node.index)
        axis = depth % len(target)
        if target[axis] - tolerance < node.point[axis]:
            stack.append((node.left, depth + 1))
        if target[axis] + tolerance >= node.point[axis]:
            stack.append((node.right, depth + 1))
    return found

# %% wrong: the circle prunes instead of the cut
# loses: measures_a_circle, test_search_plane, test_search_street
# says: Not found
def search(tree, target, tolerance):
    found, stack = [], [(tree.root, 0)]
    while stack:
        node, depth = stack.pop()
        if node is None:
            continue
        axis = depth % len(target)
        if dist(node.point, target) <= tolerance:
            found.append(node.index)
            stack += [(node.left, depth + 1), (node.right, depth + 1)]
        elif target[axis] < node.point[axis]:
            stack.append((node.left, depth + 1))
        else:
            stack.append((node.right, depth + 1))
    return found

# %% wrong: fails on an empty tree
# loses: takes_an_empty_tree
# says: With root None
def search(tree, target, tolerance):
    found, stack = [], [(tree.root, 0)]
    while stack:
        node, depth = stack.pop()
        if dist(node.point, target) <= tolerance:
            found.append(node.index)
        axis = depth % len(target)
        if node.left is not None and target[axis] - tolerance < node.point[axis]:
            stack.append((node.left, depth + 1))
        if node.right is not None and target[axis] + tolerance >= node.point[axis]:
            stack.append((node.right, depth + 1))
    return found

# %% wrong: SciPy does the search
# loses: finds_the_quiz, test_search_plane, test_search_street
# says: not allowed in this lesson
from scipy.spatial import cKDTree

def search(tree, target, tolerance):
    nodes = [tree.root] if tree.root is not None else []
    for node in nodes:
        nodes += [child for child in (node.left, node.right) if child is not None]
    if not nodes:
        return []
    rows = cKDTree([node.point for node in nodes]).query_ball_point(target, tolerance)
    return [nodes[row].index for row in rows]

# %% wrong: finds nobody
# loses: finds_the_quiz, looks_on_both_sides, leaves_regions_out, test_search_plane
# says: Not found
def search(tree, target, tolerance):
    return []

# %% wrong: stub left in place
# loses: finds_the_quiz, takes_an_empty_tree, test_search_plane
# says: still raises NotImplementedError
def search(tree, target, tolerance):
    raise NotImplementedError
