# Answers to insert of lesson 04; see grader/variants.py.

# %% right: two variables on the way down
def insert(tree, point, index):
    node = Node(point, index)
    if tree.root is None:
        tree.root = node
        return
    current, depth = tree.root, 0
    while True:
        axis = depth % len(point)
        if point[axis] < current.point[axis]:
            if current.left is None:
                current.left = node
                return
            current = current.left
        else:
            if current.right is None:
                current.right = node
                return
            current = current.right
        depth += 1

# %% right: remembers the parent and the side
def insert(tree, point, index):
    parent, side, node, depth = tree, "root", tree.root, 0
    while node is not None:
        axis = depth % np.size(point)
        parent, side = node, "right" if point[axis] >= node.point[axis] else "left"
        node, depth = getattr(node, side), depth + 1
    setattr(parent, side, Node(point, index))

# %% right: axes from itertools.cycle, points kept as tuples of floats
from itertools import cycle

def insert(tree, point, index):
    place = tuple(float(value) for value in point)
    if not tree.root:
        tree.root = Node(place, index)
    else:
        node = tree.root
        for axis in cycle(range(len(place))):
            name = ("right", "left")[place[axis] < node.point[axis]]
            if getattr(node, name) is None:
                setattr(node, name, Node(place, index))
                break
            node = getattr(node, name)

# %% right: single precision, printing and returning the node
def insert(tree, point, index):
    point = np.asarray(point, dtype=np.float32)
    new = Node(point, int(index))
    print("inserting", index, "at", point)
    if tree.root is None:
        tree.root = new
        return new
    here, axis = tree.root, 0
    while here:
        smaller = point[axis] < np.float32(here.point[axis])
        next_one = here.left if smaller else here.right
        if next_one is None:
            if smaller:
                here.left = new
            else:
                here.right = new
            return new
        here, axis = next_one, (axis + 1) % point.size

# %% right: recursion with a higher limit
import sys
sys.setrecursionlimit(20_000)

def hang(node, point, index, depth):
    if node is None:
        return Node(point, index)
    axis = depth % len(point)
    if point[axis] < node.point[axis]:
        node.left = hang(node.left, point, index, depth + 1)
    else:
        node.right = hang(node.right, point, index, depth + 1)
    return node
# ---- another cell ----
def insert(tree, point, index):
    tree.root = hang(tree.root, point, index, 0)

# %% right: a class and a node of one's own, methods written into it
class TreeNode:
    def __init__(self, point, index):
        self.point = list(point)
        self.index = index
        self.left = None
        self.right = None

class KdTree:
    def __init__(self):
        self.root = None

    def insert(self, point, index):
        depth, node, parent = 0, self.root, None
        while node is not None:
            parent = node
            went_left = point[depth % len(point)] < node.point[depth % len(point)]
            node = node.left if went_left else node.right
            depth += 1
        new = TreeNode(point, index)
        if parent is None:
            self.root = new
        elif went_left:
            parent.left = new
        else:
            parent.right = new

    def search(self, target, tolerance):
        return search(self, target, tolerance)

# %% wrong: always compares x
# loses: axes_alternate, test_plane, test_space
# says: Compare only one coordinate at each node
def insert(tree, point, index):
    node = Node(point, index)
    if tree.root is None:
        tree.root = node
        return
    here = tree.root
    while True:
        side = "left" if point[0] < here.point[0] else "right"
        if getattr(here, side) is None:
            setattr(here, side, node)
            return
        here = getattr(here, side)

# %% wrong: equal goes left
# loses: equal_goes_right, test_equal_coordinates
# says: Only strictly smaller
def insert(tree, point, index):
    node = Node(point, index)
    if tree.root is None:
        tree.root = node
        return
    here, depth = tree.root, 0
    while True:
        axis = depth % len(point)
        side = "left" if point[axis] <= here.point[axis] else "right"
        if getattr(here, side) is None:
            setattr(here, side, node)
            return
        here, depth = getattr(here, side), depth + 1

# %% wrong: greater goes left
# loses: axes_alternate, grows_the_quiz, test_plane
# says: belongs
def insert(tree, point, index):
    node = Node(point, index)
    if tree.root is None:
        tree.root = node
        return
    here, depth = tree.root, 0
    while True:
        axis = depth % len(point)
        side = "left" if point[axis] > here.point[axis] else "right"
        if getattr(here, side) is None:
            setattr(here, side, node)
            return
        here, depth = getattr(here, side), depth + 1

# %% wrong: two dimensions are written into the function
# loses: takes_three, test_space
# says: do not write 2 into the function
def insert(tree, point, index):
    node = Node(point, index)
    if tree.root is None:
        tree.root = node
        return
    here, depth = tree.root, 0
    while True:
        axis = depth % 2
        side = "left" if point[axis] < here.point[axis] else "right"
        if getattr(here, side) is None:
            setattr(here, side, node)
            return
        here, depth = getattr(here, side), depth + 1

# %% wrong: calls itself for each level
# loses: copes_with_depth
# says: No function needs to call itself
def insert(tree, point, index):
    def place(node, depth):
        if node is None:
            return Node(point, index)
        axis = depth % len(point)
        if point[axis] < node.point[axis]:
            node.left = place(node.left, depth + 1)
        else:
            node.right = place(node.right, depth + 1)
        return node
    tree.root = place(tree.root, 0)

# %% wrong: a second child replaces the first
# loses: axes_alternate, grows_the_quiz, test_plane
# says: Another point than expected
def insert(tree, point, index):
    if tree.root is None:
        tree.root = Node(point, index)
    elif point[0] < tree.root.point[0]:
        tree.root.left = Node(point, index)
    else:
        tree.root.right = Node(point, index)

# %% wrong: the local variable is set, and the tree stays empty
# loses: first_is_root, test_plane
# says: Nothing is at the root
def insert(tree, point, index):
    node, depth = tree.root, 0
    while node is not None:
        axis = depth % len(point)
        node = node.left if point[axis] < node.point[axis] else node.right
        depth += 1
    node = Node(point, index)

# %% wrong: the first axis is y
# loses: axes_alternate, grows_the_quiz, test_plane
# says: with depth 0 at the root
def insert(tree, point, index):
    node = Node(point, index)
    if tree.root is None:
        tree.root = node
        return
    here, depth = tree.root, 1
    while True:
        axis = depth % len(point)
        side = "left" if point[axis] < here.point[axis] else "right"
        if getattr(here, side) is None:
            setattr(here, side, node)
            return
        here, depth = getattr(here, side), depth + 1

# %% wrong: counts the nodes itself and forgets the index
# loses: first_is_root, takes_three, test_notations
# says: wrong index
def insert(tree, point, index):
    tree.size = getattr(tree, "size", -1) + 1
    node = Node(point, tree.size)
    if tree.root is None:
        tree.root = node
        return
    here, depth = tree.root, 0
    while True:
        axis = depth % len(point)
        side = "left" if point[axis] < here.point[axis] else "right"
        if getattr(here, side) is None:
            setattr(here, side, node)
            return
        here, depth = getattr(here, side), depth + 1

# %% wrong: hangs dictionaries into the tree
# loses: first_is_root, grows_the_quiz, test_plane
# says: hang a Node into the tree
def insert(tree, point, index):
    node = {"point": point, "index": index, "left": None, "right": None}
    if tree.root is None:
        tree.root = node
        return
    here, depth = tree.root, 0
    while True:
        axis = depth % len(point)
        side = "left" if point[axis] < here["point"][axis] else "right"
        if here[side] is None:
            here[side] = node
            return
        here, depth = here[side], depth + 1

# %% wrong: one tree for all, in a global variable
# loses: test_two_trees
# says: All that is known about a tree
OLDEST = []

def insert(tree, point, index):
    node = Node(point, index)
    if tree.root is None:
        tree.root = node
        OLDEST[:] = [node]
        return
    here, depth = OLDEST[0] if OLDEST else tree.root, 0
    while True:
        axis = depth % len(point)
        side = "left" if point[axis] < here.point[axis] else "right"
        if getattr(here, side) is None:
            setattr(here, side, node)
            return
        here, depth = getattr(here, side), depth + 1

# %% wrong: does nothing
# loses: first_is_root, grows_the_quiz, copes_with_depth, test_plane
# says: Nothing is at the root
def insert(tree, point, index):
    return None

# %% wrong: stub left in place
# loses: first_is_root, grows_the_quiz, test_plane
# says: still raises NotImplementedError
def insert(tree, point, index):
    raise NotImplementedError
