# Answers to insert of lesson 04; see grader/course/kept_answers.py.

# %% right: the hints followed to the letter
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
# loses only: axes_alternate, grows_the_quiz, takes_three, test_plane, test_space
# says: y is compared
# told: x is compared at every level
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
# loses only: equal_goes_right, test_equal_coordinates
# says: is not smaller than
# told: `<=` stands
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
# loses only: compares_x_first, axes_alternate, grows_the_quiz, equal_goes_right, takes_three, copes_with_depth, test_plane, test_space, test_equal_coordinates
# says: and should go left
# told: greater goes left, and smaller or equal right
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
# loses only: takes_three, test_space
# says: z is compared
# told: z is never compared
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
# loses only: copes_with_depth
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
# says: is not in the tree
# told: Each point is hung below the root
def insert(tree, point, index):
    if tree.root is None:
        tree.root = Node(point, index)
    elif point[0] < tree.root.point[0]:
        tree.root.left = Node(point, index)
    else:
        tree.root.right = Node(point, index)

# %% wrong: the local variable is set, and the tree stays empty
# loses: first_is_root, test_plane
# says: tree.root is None after
# told: it stays empty
def insert(tree, point, index):
    node, depth = tree.root, 0
    while node is not None:
        axis = depth % len(point)
        node = node.left if point[axis] < node.point[axis] else node.right
        depth += 1
    node = Node(point, index)

# %% wrong: the first axis is y
# loses: compares_x_first, axes_alternate, grows_the_quiz, test_plane
# says: x is compared
# told: The turns begin with y
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
# loses only: keeps_the_index, test_indices
# says: another index
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

# %% wrong: point and index swapped in the node
# loses: first_is_root, grows_the_quiz
# says: Point and index are swapped
def insert(tree, point, index):
    node = Node(index, point)
    if tree.root is None:
        tree.root = node
        return
    current, depth = tree.root, 0
    while True:
        side = "left" if point[depth % len(point)] < current.index[depth % len(point)] else "right"
        child = getattr(current, side)
        if child is None:
            setattr(current, side, node)
            return
        current, depth = child, depth + 1

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
# loses: keeps_trees_apart, test_two_trees
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

# %% wrong: goes on after the first point has become the root
# loses: first_is_root, compares_x_first, grows_the_quiz, test_plane
# says: and once more to the right of
def insert(tree, point, index):
    new = Node(point, index)
    if tree.root is None:
        tree.root = new
    parent, depth = tree.root, 0
    while True:
        axis = depth % len(point)
        side = "left" if point[axis] < parent.point[axis] else "right"
        child = getattr(parent, side)
        if child is None:
            setattr(parent, side, new)
            return
        parent, depth = child, depth + 1

# %% wrong: a second node below the root for the first point
# loses: first_is_root, compares_x_first, test_plane
# says: A point that has become the root is done
def insert(tree, point, index):
    if tree.root is None:
        tree.root = Node(point, index)
    parent, depth = tree.root, 0
    while True:
        axis = depth % len(point)
        side = "left" if point[axis] < parent.point[axis] else "right"
        if getattr(parent, side) is None:
            setattr(parent, side, Node(point, index))
            return
        parent, depth = getattr(parent, side), depth + 1

# %% wrong: forgets to count the depth
# loses only: axes_alternate, grows_the_quiz, takes_three, test_plane, test_space
# says: y is compared
# told: the axis does not change
def insert(tree, point, index):
    depth = 0
    if tree.root is None:
        tree.root = Node(point, index)
        return
    node = tree.root
    while True:
        axis = depth % len(point)
        if point[axis] < node.point[axis]:
            if node.left is None:
                node.left = Node(point, index)
                return
            node = node.left
        else:
            if node.right is None:
                node.right = Node(point, index)
                return
            node = node.right
        depth + 1

# %% wrong: depth counts to one and no further
# loses: grows_the_quiz, test_plane, test_space
# says: is compared
def insert(tree, point, index):
    node = Node(point, index)
    if tree.root is None:
        tree.root = node
        return
    here, axis = tree.root, 0
    while True:
        side = "left" if point[axis] < here.point[axis] else "right"
        if getattr(here, side) is None:
            setattr(here, side, node)
            return
        here, axis = getattr(here, side), 1

# %% wrong: not smaller goes left
# loses: compares_x_first, axes_alternate, grows_the_quiz, test_plane
# says: and should go right
# told: greater or equal goes left
def insert(tree, point, index):
    node = Node(point, index)
    if tree.root is None:
        tree.root = node
        return
    here, depth = tree.root, 0
    while True:
        axis = depth % len(point)
        side = "right" if point[axis] < here.point[axis] else "left"
        if getattr(here, side) is None:
            setattr(here, side, node)
            return
        here, depth = getattr(here, side), depth + 1

# %% wrong: takes arrays only
# loses only: takes_any_notation, test_notations
# says: This is a list, not an array
def insert(tree, point, index):
    node = Node(point, index)
    if tree.root is None:
        tree.root = node
        return
    here, depth = tree.root, 0
    while True:
        axis = depth % point.shape[0]
        side = "left" if point[axis] < here.point[axis] else "right"
        if getattr(here, side) is None:
            setattr(here, side, node)
            return
        here, depth = getattr(here, side), depth + 1

# %% wrong: wipes the point that it was given
# loses only: leaves_the_point, test_point
# says: changed its input
def insert(tree, point, index):
    node = Node([float(value) for value in point], index)
    if isinstance(point, np.ndarray):
        point[:] = 0
    if tree.root is None:
        tree.root = node
        return
    here, depth = tree.root, 0
    while True:
        axis = depth % len(node.point)
        side = "left" if node.point[axis] < here.point[axis] else "right"
        if getattr(here, side) is None:
            setattr(here, side, node)
            return
        here, depth = getattr(here, side), depth + 1

# %% wrong: never goes down
# loses: axes_alternate, grows_the_quiz, test_plane
# says: is there a loop that never ends
def insert(tree, point, index):
    node = Node(point, index)
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
        depth += 1

# %% wrong: walks past the last node
# loses: compares_x_first, test_plane
# says: Something in this line is None
def insert(tree, point, index):
    node = Node(point, index)
    if tree.root is None:
        tree.root = node
        return
    here, depth = tree.root, 0
    while here.point is not None:
        axis = depth % len(point)
        here = here.left if point[axis] < here.point[axis] else here.right
        depth += 1

# %% wrong: does nothing
# loses: first_is_root, grows_the_quiz, copes_with_depth, test_plane
# says: The tree is empty
# told: it stays empty
def insert(tree, point, index):
    return None

# %% wrong: stub left in place
# loses: first_is_root, grows_the_quiz, test_plane
# says: is not started
def insert(tree, point, index):
    raise NotImplementedError

# %% wrong: the right child is hung on the left
# loses: compares_x_first, test_plane
# says: does each branch hang the new node on its own side
def insert(tree, point, index):
    new = Node(point, index)
    if tree.root is None:
        tree.root = new
        return
    node, depth = tree.root, 0
    while True:
        axis = depth % len(point)
        if point[axis] < node.point[axis]:
            if node.left is None:
                node.left = new
                return
            node = node.left
        else:
            if node.right is None:
                node.left = new
                return
            node = node.right
        depth += 1

# %% wrong: no return after a left child
# loses: compares_x_first, test_plane
# says: A point that has been hung into the tree is done
def insert(tree, point, index):
    new = Node(point, index)
    if tree.root is None:
        tree.root = new
        return
    node, depth = tree.root, 0
    while True:
        axis = depth % len(point)
        if point[axis] < node.point[axis]:
            if node.left is None:
                node.left = new
            node = node.left
        else:
            if node.right is None:
                node.right = new
                return
            node = node.right
        depth += 1

# %% wrong: no return after a right child
# loses: compares_x_first, test_plane
# says: does the walk end once the point is hung into the tree?
def insert(tree, point, index):
    new = Node(point, index)
    if tree.root is None:
        tree.root = new
        return
    node, depth = tree.root, 0
    while True:
        axis = depth % len(point)
        if point[axis] < node.point[axis]:
            if node.left is None:
                node.left = new
                return
            node = node.left
        else:
            if node.right is None:
                node.right = new
            node = node.right
        depth += 1
