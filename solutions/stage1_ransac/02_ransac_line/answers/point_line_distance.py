# Answers to point_line_distance; see grader/course/kept_answers.py.

# %% right: columns
def point_line_distance(points, line):
    a, b, c = line
    return abs(a * points[:, 0] + b * points[:, 1] + c)

# %% right: a matrix product
def point_line_distance(points, line):
    return np.abs(points @ np.asarray(line[:2]) + line[2])

# %% right: a loop in plain Python
def point_line_distance(points, line):
    a, b, c = line
    distances = []
    for x, y in points:
        value = a * x + b * y + c
        distances.append(-value if value < 0 else value)
    return np.array(distances)

# %% right: divides by the length of the normal all the same, single precision
def point_line_distance(points, line):
    a, b, c = np.array(line)
    numerator = np.abs(a * points[:, 0] + b * points[:, 1] + c)
    return (numerator / np.hypot(a, b)).astype(np.float32)

# %% right: homogeneous points, with a warning
import warnings

def point_line_distance(points, line):
    warnings.warn("adding a column of ones")
    homogeneous = np.column_stack([points, np.ones(len(points))])
    return np.sqrt(np.dot(homogeneous, line) ** 2)

# %% right: the foot of the perpendicular, a helper in another cell
def foot(points, normal, c):
    return points - np.outer(points @ normal + c, normal)

# ---- another cell ----
def point_line_distance(points, line):
    normal = np.array([line[0], line[1]])
    return np.linalg.norm(points - foot(points, normal, line[2]), axis=1)

# %% right: the hints followed to the letter
def point_line_distance(points, line):
    a, b, c = line
    value = a * points[:, 0] + b * points[:, 1] + c
    return np.abs(value)

# %% wrong: a list back
# loses only: returns_an_array
# says: they are no array
def point_line_distance(points, line):
    a, b, c = line
    return [abs(a * x + b * y + c) for x, y in points]

# %% wrong: no absolute value
# loses only: takes_both_sides, test_distances_on_both_sides, test_distances_in_course_cloud
# says: distances are wrong
# told: the absolute value is missing
def point_line_distance(points, line):
    a, b, c = line
    return a * points[:, 0] + b * points[:, 1] + c

# %% wrong: negative ones become 0
# loses only: takes_both_sides, test_distances_on_both_sides, test_distances_in_course_cloud
# says: distances are wrong
# told: all get 0
def point_line_distance(points, line):
    a, b, c = line
    return np.maximum(a * points[:, 0] + b * points[:, 1] + c, 0)

# %% wrong: c forgotten
# loses only: counts_c, test_distances_from_lines_anywhere, test_distances_in_course_cloud, takes_both_sides_anywhere
# says: distances are wrong
# told: c is missing
def point_line_distance(points, line):
    return np.abs(points @ np.array(line)[:2])

# %% wrong: c subtracted
# loses only: counts_c, test_distances_from_lines_anywhere, test_distances_in_course_cloud, takes_both_sides_anywhere
# says: distances are wrong
# told: c has the wrong sign
def point_line_distance(points, line):
    a, b, c = line
    return np.abs(a * points[:, 0] + b * points[:, 1] - c)

# %% wrong: c outside the bracket
# loses only: counts_c, test_distances_from_lines_anywhere, test_distances_in_course_cloud, takes_both_sides_anywhere
# says: distances are wrong
# told: c is added after it
def point_line_distance(points, line):
    a, b, c = line
    return np.abs(a * points[:, 0] + b * points[:, 1]) + c

# %% wrong: the absolute value of each part
# loses: measures_square_to_the_line, test_distances_from_lines
# says: distances are wrong
# told: of the three parts are added
def point_line_distance(points, line):
    a, b, c = line
    return abs(a * points[:, 0]) + abs(b * points[:, 1]) + abs(c)

# %% wrong: the absolute value of the first part
# loses: test_distances_in_course_cloud
# says: distances are wrong
def point_line_distance(points, line):
    a, b, c = line
    return abs(a * points[:, 0]) + b * points[:, 1] + c

# %% wrong: straight up and down
# loses: measures_square_to_the_line, measures_from_upright_lines, test_distances_from_lines
# says: distances are wrong
# told: straight up and down
def point_line_distance(points, line):
    a, b, c = line
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.abs(points[:, 1] - (-a * points[:, 0] - c) / b)

# %% wrong: squared
# loses: measures_square_to_the_line, test_distances_from_lines
# says: distances are wrong
# told: squared distances
def point_line_distance(points, line):
    a, b, c = line
    return (a * points[:, 0] + b * points[:, 1] + c) ** 2

# %% wrong: rows for columns
# loses: measures_square_to_the_line, test_distances_in_course_cloud
# says: one distance for each of the 6 points
# told: the first two points
def point_line_distance(points, line):
    a, b, c = line
    return np.abs(a * points[0] + b * points[1] + c)

# %% wrong: one number for all points
# loses: measures_square_to_the_line, test_distances_from_lines
# says: one distance for each
def point_line_distance(points, line):
    a, b, c = line
    return np.linalg.norm(a * points[:, 0] + b * points[:, 1] + c)

# %% wrong: a line is taken for an array
# loses only: takes_any_line
# says: raised
def point_line_distance(points, line):
    return np.abs(points @ line[:2].T + line[2])

# %% wrong: distance from the origin
# loses: measures_square_to_the_line, test_distances_from_lines
# says: distances are wrong
def point_line_distance(points, line):
    return np.linalg.norm(points, axis=1)

# %% wrong: x and y swapped
# loses: measures_square_to_the_line, test_distances_from_lines
# says: distances are wrong
# told: x and y are swapped
def point_line_distance(points, line):
    a, b, c = line
    return np.abs(a * points[:, 1] + b * points[:, 0] + c)

# %% wrong: moves the points
# loses only: leaves_points_and_line
# says: changed its input
def point_line_distance(points, line):
    a, b, c = line
    points *= np.array([a, b])
    return np.abs(points.sum(axis=1) + c)

# %% wrong: fails for no points
# loses only: takes_few_points
# says: can be empty
def point_line_distance(points, line):
    a, b, c = line
    value = a * points[:, 0] + b * points[:, 1] + c
    if value.min() < 0:
        value = abs(value)
    return value

# %% wrong: a table of one column
# loses: measures_square_to_the_line, test_distances_from_lines
# says: A column (n, 1) is a table
def point_line_distance(points, line):
    a, b, c = line
    return np.abs(points @ np.array([[a], [b]]) + c)

# %% wrong: forgets to return
# loses: measures_square_to_the_line, test_distances_from_lines
# says: returned None
def point_line_distance(points, line):
    a, b, c = line
    distances = np.abs(a * points[:, 0] + b * points[:, 1] + c)

# %% wrong: always 0
# loses: measures_square_to_the_line, takes_both_sides, test_distances_from_lines
# says: distances are wrong
def point_line_distance(points, line):
    return np.zeros(len(points))

# %% wrong: stub left in place
# loses: measures_square_to_the_line, test_distances_from_lines
# says: is not started
def point_line_distance(points, line):
    raise NotImplementedError
