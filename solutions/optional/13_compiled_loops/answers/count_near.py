# Answers to count_near, which nothing grades; see grader/course/kept_answers.py.

# %% right: the hints followed to the letter
def count_near(points, plane, tolerance):
    count = 0
    for i in range(len(points)):
        distance = abs(plane[0] * points[i, 0] + plane[1] * points[i, 1]
                       + plane[2] * points[i, 2] + plane[3])
        if distance <= tolerance:
            count += 1
    return count

# %% right: a loop over rows
def count_near(points, plane, tolerance):
    a, b, c, d = plane
    count = 0
    for point in points:
        off = a * point[0] + b * point[1] + c * point[2] + d
        if -tolerance <= off <= tolerance:
            count += 1
    return count

# %% right: a loop over axes in the loop
def count_near(points, plane, tolerance):
    count = 0
    for i in range(points.shape[0]):
        off = plane[3]
        for axis in range(3):
            off += plane[axis] * points[i, axis]
        count += abs(off) <= tolerance
    return count

# %% right: those that are not, taken away
def count_near(points, plane, tolerance):
    left = len(points)
    for x, y, z in points:
        if abs(x * plane[0] + y * plane[1] + z * plane[2] + plane[3]) > tolerance:
            left -= 1
    return left

# %% right: squares on both sides
def count_near(points, plane, tolerance):
    i = count = 0
    while i < len(points):
        off = np.sum(points[i] * plane[:3]) + plane[3]
        if off**2 <= tolerance**2:
            count = count + 1
        i = i + 1
    return count

# %% right: NumPy's way, which compiles, too
def count_near(points, plane, tolerance):
    return np.count_nonzero(np.abs(points @ plane[:3] + plane[3]) <= tolerance)

# %% wrong: the sign is left in
# loses only: counts_both_sides, counts_the_edge, counts_none
# says: on both sides of the plane
# told: the sign is left in the distance
def count_near(points, plane, tolerance):
    count = 0
    for i in range(len(points)):
        distance = (plane[0] * points[i, 0] + plane[1] * points[i, 1]
                    + plane[2] * points[i, 2] + plane[3])
        if distance <= tolerance:
            count += 1
    return count

# %% wrong: less than
# loses only: counts_the_edge
# says: exactly as far away as the tolerance
def count_near(points, plane, tolerance):
    count = 0
    for i in range(len(points)):
        distance = abs(plane[0] * points[i, 0] + plane[1] * points[i, 1]
                       + plane[2] * points[i, 2] + plane[3])
        if distance < tolerance:
            count += 1
    return count

# %% wrong: without d
# loses: counts_both_sides
# says: not how many of the points
# told: d is left out
def count_near(points, plane, tolerance):
    count = 0
    for x, y, z in points:
        if abs(plane[0] * x + plane[1] * y + plane[2] * z) <= tolerance:
            count += 1
    return count

# %% wrong: d on the other side
# loses: counts_both_sides
# says: not how many of the points
# told: d is subtracted
def count_near(points, plane, tolerance):
    count = 0
    for x, y, z in points:
        if abs(plane[0] * x + plane[1] * y + plane[2] * z - plane[3]) <= tolerance:
            count += 1
    return count

# %% wrong: without z
# loses: counts_both_sides
# says: not how many of the points
# told: z is left out
def count_near(points, plane, tolerance):
    count = 0
    for point in points:
        if abs(plane[0] * point[0] + plane[1] * point[1] + plane[3]) <= tolerance:
            count += 1
    return count

# %% wrong: abs of each part
# loses: counts_both_sides
# says: not how many of the points
# told: taken of each part
def count_near(points, plane, tolerance):
    count = 0
    for x, y, z in points:
        if abs(plane[0] * x) + abs(plane[1] * y) + abs(plane[2] * z) + abs(plane[3]) <= tolerance:
            count += 1
    return count

# %% wrong: the square against the tolerance
# loses: counts_both_sides
# says: not how many of the points
# told: The square of the distance
def count_near(points, plane, tolerance):
    count = 0
    for x, y, z in points:
        off = plane[0] * x + plane[1] * y + plane[2] * z + plane[3]
        if off**2 <= tolerance:
            count += 1
    return count

# %% wrong: counts who is far
# loses: counts_both_sides
# says: not how many of the points
# told: farther away than the tolerance is counted
def count_near(points, plane, tolerance):
    count = 0
    for x, y, z in points:
        if abs(plane[0] * x + plane[1] * y + plane[2] * z + plane[3]) > tolerance:
            count += 1
    return count

# %% wrong: returns in the loop
# loses: counts_both_sides
# says: and return after the loop
# told: `return` stands inside it
def count_near(points, plane, tolerance):
    count = 0
    for x, y, z in points:
        if abs(plane[0] * x + plane[1] * y + plane[2] * z + plane[3]) <= tolerance:
            count += 1
        return count

# %% wrong: one point too few
# loses: counts_both_sides
# says: not how many of the points
# told: The last point
def count_near(points, plane, tolerance):
    count = 0
    for i in range(len(points) - 1):
        x, y, z = points[i]
        if abs(plane[0] * x + plane[1] * y + plane[2] * z + plane[3]) <= tolerance:
            count += 1
    return count

# %% wrong: begins with the second point
# loses: counts_both_sides
# says: not how many of the points
# told: The first point
def count_near(points, plane, tolerance):
    count = 0
    for i in range(1, len(points)):
        x, y, z = points[i]
        if abs(plane[0] * x + plane[1] * y + plane[2] * z + plane[3]) <= tolerance:
            count += 1
    return count

# %% wrong: three points, as there are three columns
# loses: counts_both_sides, counts_none
# says: index 0 is out of bounds
# told: As many as there are columns
def count_near(points, plane, tolerance):
    count = 0
    for i in range(3):
        x, y, z = points[i]
        if abs(plane[0] * x + plane[1] * y + plane[2] * z + plane[3]) <= tolerance:
            count += 1
    return count

# %% wrong: begins at 1
# loses: counts_both_sides, counts_none
# says: not how many of the points
# told: The count begins at 1
def count_near(points, plane, tolerance):
    count = 1
    for x, y, z in points:
        if abs(plane[0] * x + plane[1] * y + plane[2] * z + plane[3]) <= tolerance:
            count += 1
    return count

# %% wrong: counts everybody
# loses: counts_both_sides, counts_none
# says: not how many of the points
# told: Every point counts
def count_near(points, plane, tolerance):
    count = 0
    for x, y, z in points:
        count += 1
    return count

# %% wrong: a mask
# loses: counts_both_sides
# says: The answer is one number
def count_near(points, plane, tolerance):
    return np.abs(points @ plane[:3] + plane[3]) <= tolerance

# %% wrong: no return
# loses: counts_both_sides
# says: returned None
def count_near(points, plane, tolerance):
    count = 0
    for x, y, z in points:
        if abs(plane[0] * x + plane[1] * y + plane[2] * z + plane[3]) <= tolerance:
            count += 1

# %% wrong: writes the distance into the points
# loses only: leaves_the_points
# says: changed its input
def count_near(points, plane, tolerance):
    count = 0
    for i in range(len(points)):
        points[i, 0] = abs(points[i] @ plane[:3] + plane[3])
        if points[i, 0] <= tolerance:
            count += 1
    return count
