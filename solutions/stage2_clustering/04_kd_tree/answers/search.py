# Answers to search of lesson 04; see grader/course/kept_answers.py.

# %% right: the hints followed to the letter
def search(tree, target, tolerance):
    waiting = [(tree.root, 0)]
    found = []
    while waiting:
        node, depth = waiting.pop()
        if node is None:
            continue
        if dist(node.point, target) <= tolerance:
            found.append(node.index)
        axis = depth % len(target)
        split = node.point[axis]
        if target[axis] - tolerance < split:
            waiting.append((node.left, depth + 1))
        if target[axis] + tolerance >= split:
            waiting.append((node.right, depth + 1))
    return found

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
from collections import deque

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
# loses only: reaches_the_split, test_search_split
# says: where the box ends exactly at the split
# told: `>` stands
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
# loses only: looks_on_both_sides, reaches_the_split, test_search_plane, test_search_street, test_search_crooked, test_search_split
# says: Not found
# told: Only the side on which the target itself lies
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
# loses only: looks_on_both_sides, reaches_the_split, test_search_plane, test_search_street, test_search_crooked, test_search_split
# says: Not found
# told: only the left one is searched
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
# loses only: measures_a_circle, test_search_circle
# says: Found, but farther
# told: The box decides
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
# loses only: leaves_regions_out, test_search_prunes
# says: lies entirely beyond the tolerance
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
# loses only: leaves_regions_out, test_search_prunes
# says: goes by the splits
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
# loses only: leaves_regions_out, test_search_prunes
# says: lies entirely beyond the tolerance
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
# loses only: takes_the_radius, test_search_radius
# says: farther than
# told: The square of the distance
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
# loses only: searches_space, test_search_street
# says: Not found
# told: z is never compared
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
# loses: finds_the_target, test_search_plane, test_search_street
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
# loses only: includes_the_border, reaches_the_split, test_search_border, test_search_split
# says: Not found
# told: `<` stands
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
# loses only: looks_on_both_sides, reaches_the_split, test_search_plane, test_search_street, test_search_crooked, test_search_split
# says: Not found
# told: Both sides are searched below nodes that are near
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
# loses only: takes_an_empty_tree
# says: Something in this line is None
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
# loses: finds_the_target, test_search_plane, test_search_street
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

# %% wrong: the sides are swapped
# loses: finds_the_target, looks_on_both_sides, test_search_plane
# says: Not found
# told: The sides are swapped
def search(tree, target, tolerance):
    found, stack = [], [(tree.root, 0)]
    while stack:
        node, depth = stack.pop()
        if node is None:
            continue
        axis = depth % len(target)
        if dist(node.point, target) <= tolerance:
            found.append(node.index)
        if target[axis] - tolerance < node.point[axis]:
            stack.append((node.right, depth + 1))
        if target[axis] + tolerance >= node.point[axis]:
            stack.append((node.left, depth + 1))
    return found

# %% wrong: the ends of the box are swapped
# loses: looks_on_both_sides, test_search_plane
# says: Not found
# told: The ends of the box are swapped
def search(tree, target, tolerance):
    found, stack = [], [(tree.root, 0)]
    while stack:
        node, depth = stack.pop()
        if node is None:
            continue
        axis = depth % len(target)
        if dist(node.point, target) <= tolerance:
            found.append(node.index)
        if target[axis] + tolerance < node.point[axis]:
            stack.append((node.left, depth + 1))
        if target[axis] - tolerance >= node.point[axis]:
            stack.append((node.right, depth + 1))
    return found

# %% wrong: returns at the first empty place
# loses: looks_on_both_sides, test_search_plane
# says: Not found
# told: only the right one is searched
def search(tree, target, tolerance):
    found, stack = [], [(tree.root, 0)]
    while stack:
        node, depth = stack.pop()
        if node is None:
            return found
        axis = depth % len(target)
        if dist(node.point, target) <= tolerance:
            found.append(node.index)
        if target[axis] - tolerance < node.point[axis]:
            stack.append((node.left, depth + 1))
        if target[axis] + tolerance >= node.point[axis]:
            stack.append((node.right, depth + 1))
    return found

# %% wrong: the tolerance is left out on the left
# loses: looks_on_both_sides, test_search_plane
# says: Not found
# told: The tolerance is left out on the left
def search(tree, target, tolerance):
    found, stack = [], [(tree.root, 0)]
    while stack:
        node, depth = stack.pop()
        if node is None:
            continue
        axis = depth % len(target)
        if dist(node.point, target) <= tolerance:
            found.append(node.index)
        if target[axis] < node.point[axis]:
            stack.append((node.left, depth + 1))
        if target[axis] + tolerance >= node.point[axis]:
            stack.append((node.right, depth + 1))
    return found

# %% wrong: the tolerance is left out on the right
# loses: looks_on_both_sides, test_search_plane
# says: Not found
# told: The tolerance is left out on the right
def search(tree, target, tolerance):
    found, stack = [], [(tree.root, 0)]
    while stack:
        node, depth = stack.pop()
        if node is None:
            continue
        axis = depth % len(target)
        if dist(node.point, target) <= tolerance:
            found.append(node.index)
        if target[axis] - tolerance < node.point[axis]:
            stack.append((node.left, depth + 1))
        if target[axis] >= node.point[axis]:
            stack.append((node.right, depth + 1))
    return found

# %% wrong: the first axis is y
# loses: finds_the_target, test_search_plane
# says: Not found
# told: The turns begin with y
def search(tree, target, tolerance):
    found, stack = [], [(tree.root, 1)]
    while stack:
        node, depth = stack.pop()
        if node is None:
            continue
        axis = depth % len(target)
        if dist(node.point, target) <= tolerance:
            found.append(node.index)
        if target[axis] - tolerance < node.point[axis]:
            stack.append((node.left, depth + 1))
        if target[axis] + tolerance >= node.point[axis]:
            stack.append((node.right, depth + 1))
    return found

# %% wrong: one coordinate decides who is near
# loses: looks_on_both_sides, measures_a_circle, test_search_plane
# says: Found, but farther
# told: One coordinate decides
def search(tree, target, tolerance):
    found, stack = [], [(tree.root, 0)]
    while stack:
        node, depth = stack.pop()
        if node is None:
            continue
        axis = depth % len(target)
        if abs(node.point[axis] - target[axis]) <= tolerance:
            found.append(node.index)
        if target[axis] - tolerance < node.point[axis]:
            stack.append((node.left, depth + 1))
        if target[axis] + tolerance >= node.point[axis]:
            stack.append((node.right, depth + 1))
    return found

# %% wrong: whoever is met is found
# loses: finds_the_target, test_search_plane
# says: Found, but farther
# told: whatever its distance
def search(tree, target, tolerance):
    found, stack = [], [(tree.root, 0)]
    while stack:
        node, depth = stack.pop()
        if node is None:
            continue
        axis = depth % len(target)
        if len(found) >= 0:
            found.append(node.index)
        if target[axis] - tolerance < node.point[axis]:
            stack.append((node.left, depth + 1))
        if target[axis] + tolerance >= node.point[axis]:
            stack.append((node.right, depth + 1))
    return found

# %% wrong: notes each index twice
# loses only: names_each_once
# says: is there 2 times
def search(tree, target, tolerance):
    found, stack = [], [(tree.root, 0)]
    while stack:
        node, depth = stack.pop()
        if node is None:
            continue
        axis = depth % len(target)
        if dist(node.point, target) <= tolerance:
            found += [node.index, node.index]
        if target[axis] - tolerance < node.point[axis]:
            stack.append((node.left, depth + 1))
        if target[axis] + tolerance >= node.point[axis]:
            stack.append((node.right, depth + 1))
    return found

# %% wrong: forgets to return
# loses: finds_the_target, takes_an_empty_tree, test_search_plane
# says: returned None
def search(tree, target, tolerance):
    found, stack = [], [(tree.root, 0)]
    while stack:
        node, depth = stack.pop()
        if node is None:
            continue
        axis = depth % len(target)
        if dist(node.point, target) <= tolerance:
            found.append(node.index)
        if target[axis] - tolerance < node.point[axis]:
            stack.append((node.left, depth + 1))
        if target[axis] + tolerance >= node.point[axis]:
            stack.append((node.right, depth + 1))

# %% wrong: takes arrays only
# loses only: takes_any_target, test_search_notations
# says: raised TypeError
def search(tree, target, tolerance):
    found, stack = [], [(tree.root, 0)]
    while stack:
        node, depth = stack.pop()
        if node is None:
            continue
        axis = depth % len(target)
        if np.linalg.norm(node.point - target) <= tolerance:
            found.append(node.index)
        if target[axis] - tolerance < node.point[axis]:
            stack.append((node.left, depth + 1))
        if target[axis] + tolerance >= node.point[axis]:
            stack.append((node.right, depth + 1))
    return found

# %% wrong: wipes the target when it is done
# loses only: leaves_the_tree, test_search_leaves_the_tree
# says: changed its input
def search(tree, target, tolerance):
    found, stack = [], [(tree.root, 0)]
    while stack:
        node, depth = stack.pop()
        if node is None:
            continue
        axis = depth % len(target)
        if dist(node.point, target) <= tolerance:
            found.append(node.index)
        if target[axis] - tolerance < node.point[axis]:
            stack.append((node.left, depth + 1))
        if target[axis] + tolerance >= node.point[axis]:
            stack.append((node.right, depth + 1))
    if isinstance(target, np.ndarray):
        target[:] = 0
    return found

# %% wrong: cuts off what it has searched
# loses: leaves_the_tree, test_search_leaves_the_tree
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
        if target[axis] - tolerance < node.point[axis]:
            stack.append((node.left, depth + 1))
        if target[axis] + tolerance >= node.point[axis]:
            stack.append((node.right, depth + 1))
    if tree.root is not None:
        tree.root.left = None
    return found

# %% wrong: everybody below a far node is left out
# loses: looks_on_both_sides, finds_the_target, test_search_plane
# says: Not found
# told: The search ends at each node that is not near
def search(tree, target, tolerance):
    found, stack = [], [(tree.root, 0)]
    while stack:
        node, depth = stack.pop()
        if node is None or dist(node.point, target) > tolerance:
            continue
        found.append(node.index)
        stack += [(node.left, depth + 1), (node.right, depth + 1)]
    return found

# %% wrong: finds nobody
# loses: finds_the_target, looks_on_both_sides, leaves_regions_out, test_search_plane
# says: Not found
def search(tree, target, tolerance):
    return []

# %% wrong: stub left in place
# loses: finds_the_target, takes_an_empty_tree, test_search_plane
# says: is not started
def search(tree, target, tolerance):
    raise NotImplementedError

# %% wrong: one if under the other
# loses: finds_the_target, test_search_plane
# says: indented under the first
# told: The right side is asked only where the left one was taken
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
            if target[axis] + tolerance >= node.point[axis]:
                stack.append((node.right, depth + 1))
    return found

# %% wrong: break for continue
# loses: looks_on_both_sides, test_search_plane
# says: `break` and `return` end the whole search
# told: only the right one is searched
def search(tree, target, tolerance):
    found, stack = [], [(tree.root, 0)]
    while stack:
        node, depth = stack.pop()
        if node is None:
            break
        if dist(node.point, target) <= tolerance:
            found.append(node.index)
        axis = depth % len(target)
        if target[axis] - tolerance < node.point[axis]:
            stack.append((node.left, depth + 1))
        if target[axis] + tolerance >= node.point[axis]:
            stack.append((node.right, depth + 1))
    return found

# %% wrong: break for continue, level by level
# loses: looks_on_both_sides, test_search_plane
# says: `break` and `return` end the whole search
# told: The search ends at the first empty place
def search(tree, target, tolerance):
    found, queue = [], [(tree.root, 0)]
    while queue:
        node, depth = queue.pop(0)
        if node is None:
            break
        if dist(node.point, target) <= tolerance:
            found.append(node.index)
        axis = depth % len(target)
        if target[axis] - tolerance < node.point[axis]:
            queue.append((node.left, depth + 1))
        if target[axis] + tolerance >= node.point[axis]:
            queue.append((node.right, depth + 1))
    return found

# %% wrong: the depth does not grow on the left
# loses: finds_the_target, test_search_plane
# says: Both children wait with depth + 1
# told: on the way to a left child
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
            stack.append((node.left, depth))
        if target[axis] + tolerance >= node.point[axis]:
            stack.append((node.right, depth + 1))
    return found
