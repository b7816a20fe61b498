# Answers to points_in_cells, which nothing grades; see grader/course/kept_answers.py.

# %% right: the hints followed to the letter
def points_in_cells(points, threshold):
    side = threshold / np.sqrt(3)
    rows = np.floor(points / side)
    _, first, cell_of_point = np.unique(as_numbers(rows), return_index=True, return_inverse=True)
    return rows[first], first, cell_of_point

# %% right: in the order of the points, with a dictionary
def points_in_cells(points, threshold):
    seen, first, which = {}, [], []
    for row, cell in enumerate(np.floor(points * np.sqrt(3) / threshold).astype(int).tolist()):
        if tuple(cell) not in seen:
            seen[tuple(cell)] = len(seen)
            first.append(row)
        which.append(seen[tuple(cell)])
    return list(seen), first, which

# %% wrong: the threshold as side
# loses: finds_the_cells
# says: here 1 m
def points_in_cells(points, threshold):
    rows = np.floor(points / threshold)
    _, first, cell_of_point = np.unique(as_numbers(rows), return_index=True, return_inverse=True)
    return rows[first], first, cell_of_point

# %% wrong: rounded towards 0
# loses: finds_the_cells
# says: below zero
def points_in_cells(points, threshold):
    rows = (points / (threshold / np.sqrt(3))).astype(int)
    _, first, cell_of_point = np.unique(as_numbers(rows), return_index=True, return_inverse=True)
    return rows[first], first, cell_of_point

# %% wrong: the cell of each point, not the different ones
# loses: finds_the_cells
# says: rows[first] are the different cells
def points_in_cells(points, threshold):
    rows = np.floor(points / (threshold / np.sqrt(3)))
    _, first, cell_of_point = np.unique(as_numbers(rows), return_index=True, return_inverse=True)
    return rows, first, cell_of_point

# %% wrong: two results exchanged
# loses: finds_the_cells, follows_the_side
# says: one number in cell_of_point for each of the 7 points
def points_in_cells(points, threshold):
    rows = np.floor(points / (threshold / np.sqrt(3)))
    _, first, cell_of_point = np.unique(as_numbers(rows), return_index=True, return_inverse=True)
    return rows[first], cell_of_point, first

# %% wrong: the numbers of the cells for the cells
# loses: finds_the_cells, follows_the_side
# says: one row per cell.
def points_in_cells(points, threshold):
    rows = np.floor(points / (threshold / np.sqrt(3)))
    cells, first, which = np.unique(as_numbers(rows), return_index=True, return_inverse=True)
    return cells, first, which

# %% wrong: the points divided where they are
# loses only: leaves_the_points
# says: points /= side
def points_in_cells(points, threshold):
    points /= threshold / np.sqrt(3)
    rows = np.floor(points)
    _, first, cell_of_point = np.unique(as_numbers(rows), return_index=True, return_inverse=True)
    return rows[first], first, cell_of_point
