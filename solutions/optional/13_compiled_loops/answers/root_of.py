# Answers to root_of, which nothing grades; see grader/course/kept_answers.py.

# %% right: the hints followed to the letter
def root_of(parent, cell):
    while parent[cell] != cell:
        parent[cell] = parent[parent[cell]]
        cell = parent[cell]
    return cell

# %% right: each cell of the way at its grandparent
def root_of(parent, cell):
    while parent[cell] != cell:
        above = parent[cell]
        parent[cell] = parent[above]
        cell = above
    return cell

# %% right: all of the way at the root, in a second loop
def root_of(parent, cell):
    root = cell
    while parent[root] != root:
        root = parent[root]
    while parent[cell] != root:
        above = parent[cell]
        parent[cell] = root
        cell = above
    return root

# %% right: it calls itself
def root_of(parent, cell):
    if parent[cell] != cell:
        parent[cell] = root_of(parent, parent[cell])
    return parent[cell]

# %% right: the first cell alone at the root
def root_of(parent, cell):
    start = cell
    while cell != parent[cell]:
        cell = parent[cell]
    parent[start] = cell
    return cell

# %% right: a loop that is left in the middle
def root_of(parent, cell):
    while True:
        if parent[cell] == cell:
            return cell
        grandparent = parent[parent[cell]]
        parent[cell] = grandparent
        cell = grandparent

# %% wrong: if where while is needed
# loses only: finds_the_root, shortens_the_way
# says: so that the way is
# told: It goes one step
def root_of(parent, cell):
    if parent[cell] != cell:
        cell = parent[cell]
    return cell

# %% wrong: the parent
# loses only: finds_the_root, shortens_the_way
# says: so that the way is
# told: It goes one step
def root_of(parent, cell):
    return parent[cell]

# %% wrong: returns in the loop
# loses only: finds_the_root, shortens_the_way
# says: so that the way is
# told: It goes two steps
def root_of(parent, cell):
    while parent[cell] != cell:
        parent[cell] = parent[parent[cell]]
        cell = parent[cell]
        return cell
    return cell

# %% wrong: stops one step early
# loses only: finds_the_root, shortens_the_way
# says: This is not the root of cell
# told: one step before the root
def root_of(parent, cell):
    while parent[parent[cell]] != parent[cell]:
        cell = parent[cell]
    return cell

# %% wrong: never goes on
# loses only: finds_the_root
# says: did not come back
def root_of(parent, cell):
    while parent[cell] != cell:
        parent[cell] = parent[parent[cell]]
    return cell

# %% wrong: shortens nothing
# loses only: shortens_the_way
# says: hardly shorter
def root_of(parent, cell):
    while parent[cell] != cell:
        cell = parent[cell]
    return cell

# %% wrong: forgets where it was
# loses only: keeps_the_pieces
# says: has another root than before
def root_of(parent, cell):
    start = cell
    while parent[cell] != cell:
        cell = parent[cell]
        parent[start] = start
    return cell

# %% wrong: makes a root of what it passes
# loses: keeps_the_pieces
# says: has another root than before
def root_of(parent, cell):
    while parent[cell] != cell:
        above = parent[cell]
        parent[cell] = cell
        cell = above
    return cell

# %% wrong: a circle
# loses: keeps_the_pieces
# says: round in a circle
def root_of(parent, cell):
    start = cell
    while parent[cell] != cell:
        cell = parent[cell]
    if cell != start:
        parent[cell] = start
    return cell

# %% wrong: returns where it began
# loses: finds_the_root
# says: This is not the root of cell
# told: It returns the cell that was given
def root_of(parent, cell):
    start = cell
    while parent[cell] != cell:
        parent[cell] = parent[parent[cell]]
        cell = parent[cell]
    return start

# %% wrong: no return
# loses: finds_the_root
# says: returned None
def root_of(parent, cell):
    while parent[cell] != cell:
        parent[cell] = parent[parent[cell]]
        cell = parent[cell]
