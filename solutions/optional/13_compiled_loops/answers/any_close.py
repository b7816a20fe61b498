# Answers to any_close, which nothing grades; see grader/course/kept_answers.py.

# %% right: the hints followed to the letter
def any_close(points, a, a_end, b, b_end, limit):
    for i in range(a, a_end):
        for j in range(b, b_end):
            x = points[i, 0] - points[j, 0]
            y = points[i, 1] - points[j, 1]
            z = points[i, 2] - points[j, 2]
            if x * x + y * y + z * z < limit:
                return True
    return False

# %% right: a loop over axes
def any_close(points, a, a_end, b, b_end, limit):
    for i in range(a, a_end):
        for j in range(b, b_end):
            square = 0.0
            for axis in range(3):
                square += (points[i, axis] - points[j, axis]) ** 2
            if square < limit:
                return True
    return False

# %% right: rows at once
def any_close(points, a, a_end, b, b_end, limit):
    for p in points[a:a_end]:
        for q in points[b:b_end]:
            if ((p - q) ** 2).sum() < limit:
                return True
    return False

# %% right: the root, and that of the limit
def any_close(points, a, a_end, b, b_end, limit):
    threshold = np.sqrt(limit)
    i = a
    while i < a_end:
        for j in range(b, b_end):
            if np.linalg.norm(points[i] - points[j]) < threshold:
                return True
        i += 1
    return False

# %% right: the other cell outside, with a flag and two breaks
def any_close(points, a, a_end, b, b_end, limit):
    found = False
    for j in range(b, b_end):
        for i in range(a, a_end):
            x, y, z = points[i] - points[j]
            if not x**2 + y**2 + z**2 >= limit:
                found = True
                break
        if found:
            break
    return found

# %% wrong: the root against the square
# loses: compares_two
# says: that close
# told: The distance itself
def any_close(points, a, a_end, b, b_end, limit):
    for i in range(a, a_end):
        for j in range(b, b_end):
            x, y, z = points[i] - points[j]
            if np.sqrt(x * x + y * y + z * z) < limit:
                return True
    return False

# %% wrong: the limit once more squared
# loses: compares_two
# says: that close
# told: squared once more
def any_close(points, a, a_end, b, b_end, limit):
    for i in range(a, a_end):
        for j in range(b, b_end):
            x, y, z = points[i] - points[j]
            if x * x + y * y + z * z < limit**2:
                return True
    return False

# %% wrong: the first pair decides
# loses: asks_each_with_each
# says: return False after both loops
# told: The first pair decides
def any_close(points, a, a_end, b, b_end, limit):
    for i in range(a, a_end):
        for j in range(b, b_end):
            x, y, z = points[i] - points[j]
            if x * x + y * y + z * z < limit:
                return True
            return False

# %% wrong: the first row decides
# loses: asks_each_with_each
# says: return False after both loops
# told: Only the first point of the one cell
def any_close(points, a, a_end, b, b_end, limit):
    for i in range(a, a_end):
        for j in range(b, b_end):
            x, y, z = points[i] - points[j]
            if x * x + y * y + z * z < limit:
                return True
        return False

# %% wrong: all have to be close
# loses: asks_each_with_each
# says: Two points of these rows are that close
# told: All pairs have to be close
def any_close(points, a, a_end, b, b_end, limit):
    for i in range(a, a_end):
        for j in range(b, b_end):
            x, y, z = points[i] - points[j]
            if x * x + y * y + z * z >= limit:
                return False
    return True

# %% wrong: the answers exchanged
# loses: compares_two
# says: that close
# told: The answers are exchanged
def any_close(points, a, a_end, b, b_end, limit):
    for i in range(a, a_end):
        for j in range(b, b_end):
            x, y, z = points[i] - points[j]
            if x * x + y * y + z * z < limit:
                return False
    return True

# %% wrong: the ends belong to it
# loses: compares_two, keeps_to_its_rows
# says: out of bounds
# told: The row after each cell
def any_close(points, a, a_end, b, b_end, limit):
    for i in range(a, a_end + 1):
        for j in range(b, b_end + 1):
            x, y, z = points[i] - points[j]
            if x * x + y * y + z * z < limit:
                return True
    return False

# %% wrong: without the last rows
# loses: compares_two
# says: Two points of these rows are that close
# told: The last row
def any_close(points, a, a_end, b, b_end, limit):
    for i in range(a, a_end - 1):
        for j in range(b, b_end - 1):
            x, y, z = points[i] - points[j]
            if x * x + y * y + z * z < limit:
                return True
    return False

# %% wrong: without the first rows
# loses: compares_two
# says: Two points of these rows are that close
# told: The first row
def any_close(points, a, a_end, b, b_end, limit):
    for i in range(a + 1, a_end):
        for j in range(b + 1, b_end):
            x, y, z = points[i] - points[j]
            if x * x + y * y + z * z < limit:
                return True
    return False

# %% wrong: without x
# loses: compares_two
# says: No two are that close
# told: x is left out
def any_close(points, a, a_end, b, b_end, limit):
    for i in range(a, a_end):
        for j in range(b, b_end):
            _, y, z = points[i] - points[j]
            if y * y + z * z < limit:
                return True
    return False

# %% wrong: without y
# loses: compares_two
# says: No two are that close
# told: y is left out
def any_close(points, a, a_end, b, b_end, limit):
    for i in range(a, a_end):
        for j in range(b, b_end):
            x, _, z = points[i] - points[j]
            if x * x + z * z < limit:
                return True
    return False

# %% wrong: without z
# loses: compares_two
# says: No two are that close
# told: z is left out
def any_close(points, a, a_end, b, b_end, limit):
    for i in range(a, a_end):
        for j in range(b, b_end):
            x = points[i, 0] - points[j, 0]
            y = points[i, 1] - points[j, 1]
            if x * x + y * y < limit:
                return True
    return False

# %% wrong: False, always
# loses: compares_two, stops_at_the_first
# says: that close
# told: It says False, always
def any_close(points, a, a_end, b, b_end, limit):
    return False

# %% wrong: True, always
# loses: compares_two, is_strict
# says: No two are that close
# told: It says True, always
def any_close(points, a, a_end, b, b_end, limit):
    return True

# %% wrong: at most
# loses only: is_strict
# says: and not closer
def any_close(points, a, a_end, b, b_end, limit):
    for i in range(a, a_end):
        for j in range(b, b_end):
            x, y, z = points[i] - points[j]
            if x * x + y * y + z * z <= limit:
                return True
    return False

# %% wrong: never stops
# loses only: stops_at_the_first
# says: although the answer is known
def any_close(points, a, a_end, b, b_end, limit):
    found = False
    for i in range(a, a_end):
        for j in range(b, b_end):
            x, y, z = points[i] - points[j]
            if x * x + y * y + z * z < limit:
                found = True
    return found

# %% wrong: leaves the inner loop alone
# loses only: stops_at_the_first
# says: although the answer is known
def any_close(points, a, a_end, b, b_end, limit):
    found = False
    for i in range(a, a_end):
        for j in range(b, b_end):
            x, y, z = points[i] - points[j]
            if x * x + y * y + z * z < limit:
                found = True
                break
    return found

# %% wrong: no return at the end
# loses: compares_two
# says: returned None
def any_close(points, a, a_end, b, b_end, limit):
    for i in range(a, a_end):
        for j in range(b, b_end):
            x, y, z = points[i] - points[j]
            if x * x + y * y + z * z < limit:
                return True

# %% wrong: a table of answers
# loses: compares_two
# says: one True or False
def any_close(points, a, a_end, b, b_end, limit):
    return ((points[a:a_end, None] - points[b:b_end]) ** 2).sum(axis=-1) < limit

# %% wrong: writes differences into the points
# loses: leaves_the_rows
# says: changed its input
def any_close(points, a, a_end, b, b_end, limit):
    for i in range(a, a_end):
        for j in range(b, b_end):
            points[j] -= points[i]
            x, y, z = points[j]
            points[j] = points[j] + points[i] + 1e-9
            if x * x + y * y + z * z < limit:
                return True
    return False
