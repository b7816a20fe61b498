# Answers to unite, which nothing grades; see grader/course/kept_answers.py.

# %% right: the hints followed to the letter
def unite(parent, a, b):
    a, b = root_of(parent, a), root_of(parent, b)
    parent[max(a, b)] = min(a, b)

# %% right: asks which is smaller
def unite(parent, a, b):
    root_a = root_of(parent, a)
    root_b = root_of(parent, b)
    if root_a < root_b:
        parent[root_b] = root_a
    else:
        parent[root_a] = root_b

# %% right: only where it is needed, with an answer
def unite(parent, a, b):
    root_a, root_b = root_of(parent, a), root_of(parent, b)
    if root_a == root_b:
        return False
    parent[max(root_a, root_b)] = min(root_a, root_b)
    return True

# %% right: exchanged, if need be
def unite(parent, a, b):
    a, b = root_of(parent, a), root_of(parent, b)
    if a > b:
        a, b = b, a
    parent[b] = a

# %% right: both at the smaller
def unite(parent, a, b):
    smaller = min(root_of(parent, a), root_of(parent, b))
    parent[root_of(parent, a)] = smaller
    parent[root_of(parent, b)] = smaller

# %% wrong: the cells, and not their roots
# loses: joins_the_pieces
# says: Other cells hang together
# told: The two cells are joined, and not their roots
def unite(parent, a, b):
    parent[max(a, b)] = min(a, b)

# %% wrong: the first cell under the second root
# loses: joins_the_pieces
# says: Other cells hang together
# told: The first cell, and not its root
def unite(parent, a, b):
    parent[a] = root_of(parent, b)

# %% wrong: the second cell under the first root
# loses: joins_the_pieces
# says: Other cells hang together
# told: The second cell, and not its root
def unite(parent, a, b):
    parent[b] = root_of(parent, a)

# %% wrong: the larger root above
# loses only: points_at_the_smaller
# says: under the larger root
def unite(parent, a, b):
    a, b = root_of(parent, a), root_of(parent, b)
    parent[min(a, b)] = max(a, b)

# %% wrong: the first root below, whichever it is
# loses only: points_at_the_smaller
# says: under the larger root
def unite(parent, a, b):
    parent[root_of(parent, a)] = root_of(parent, b)

# %% wrong: one parent of each
# loses: joins_the_pieces
# says: Other cells hang together
def unite(parent, a, b):
    a, b = parent[a], parent[b]
    parent[max(a, b)] = min(a, b)

# %% wrong: writes into nothing
# loses: joins_the_pieces
# says: Other cells hang together
# told: Nothing is joined
def unite(parent, a, b):
    a, b = root_of(parent, a), root_of(parent, b)
    parent = parent.copy()
    parent[max(a, b)] = min(a, b)

# %% wrong: one at the other and back
# loses: joins_the_pieces
# says: round in a circle
def unite(parent, a, b):
    root_a, root_b = root_of(parent, a), root_of(parent, b)
    parent[root_a], parent[root_b] = root_b, root_a

# %% wrong: forgets the array
# loses: joins_the_pieces
# says: missing 1 required positional
def unite(parent, a, b):
    a, b = root_of(a), root_of(b)
    parent[max(a, b)] = min(a, b)
