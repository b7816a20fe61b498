# Answers to line_through; see grader/course/kept_answers.py.

# %% right: a quarter turn of the direction
def line_through(p, q):
    dx, dy = q[0] - p[0], q[1] - p[1]
    length = (dx ** 2 + dy ** 2) ** 0.5
    if length == 0:
        return None
    a, b = -dy / length, dx / length
    return (a, b, -a * p[0] - b * p[1])

# %% right: the cross product of homogeneous points, an array back
def line_through(p, q):
    line = np.cross([p[0], p[1], 1.0], [q[0], q[1], 1.0])
    length = np.linalg.norm(line[:2])
    return None if length == 0 else line / length

# %% right: turned the other way, a list in single precision
def line_through(p, q):
    if np.array_equal(p, q):
        return None
    d = np.float32(q) - np.float32(p)
    a, b = np.array([d[1], -d[0]]) / np.hypot(*d)
    return [np.float32(a), np.float32(b), np.float32(-(a * p[0] + b * p[1]))]

# %% right: complex numbers and a print
def line_through(p, q):
    start, end = complex(*p), complex(*q)
    print("from", start, "to", end)
    if start == end:
        return None
    normal = 1j * (end - start) / abs(end - start)
    return normal.real, normal.imag, -(normal * start.conjugate()).real

# %% right: by the angle
import math

def line_through(p, q):
    (px, py), (qx, qy) = p, q
    if px == qx and py == qy:
        return None
    turned = math.atan2(qy - py, qx - px) + math.pi / 2
    a, b = math.cos(turned), math.sin(turned)
    return a, b, -0.5 * (a * (px + qx) + b * (py + qy))

# %% right: a class, a helper in another cell
class Line:
    def __init__(self, normal, point):
        self.normal = normal / np.linalg.norm(normal)
        self.offset = -self.normal.dot(point)

# ---- another cell ----
def line_through(p, q):
    direction = np.subtract(q, p)
    if not direction.any():
        return None
    line = Line(np.array([[0, -1], [1, 0]]) @ direction, np.asarray(p))
    return np.append(line.normal, line.offset)

# %% right: the hints followed to the letter
def line_through(p, q):
    dx, dy = q[0] - p[0], q[1] - p[1]
    length = np.hypot(dx, dy)
    if length == 0:
        return None
    a = -dy / length
    b = dx / length
    c = -(a * p[0] + b * p[1])
    return a, b, c

# %% wrong: the normal has any length
# loses only: has_a_unit_normal, test_unit_normals
# says: The normal (a, b) must have length 1
# told: as long as the points are apart
def line_through(p, q):
    dx, dy = q[0] - p[0], q[1] - p[1]
    if dx == 0 and dy == 0:
        return None
    return -dy, dx, dy * p[0] - dx * p[1]

# %% wrong: slope and intercept
# loses only: takes_upright_lines, test_lines_in_special_directions, refuses_equal_points, test_equal
# says: not finite
def line_through(p, q):
    slope = (q[1] - p[1]) / (q[0] - p[0])
    length = np.hypot(slope, 1)
    return slope / length, -1 / length, (p[1] - slope * p[0]) / length

# %% wrong: the direction instead of the normal
# loses: passes_through_both, test_lines_through_pairs
# says: misses
# told: the quarter turn is missing
def line_through(p, q):
    d = q - p
    length = np.linalg.norm(d)
    if length == 0:
        return None
    a, b = d / length
    return a, b, -(a * p[0] + b * p[1])

# %% wrong: swapped without the sign
# loses: passes_through_both, test_lines_through_pairs
# says: misses
# told: that mirrors the direction
def line_through(p, q):
    dx, dy = q[0] - p[0], q[1] - p[1]
    length = np.hypot(dx, dy)
    if length == 0:
        return None
    a, b = dy / length, dx / length
    return a, b, -(a * p[0] + b * p[1])

# %% wrong: c with the wrong sign
# loses: passes_through_both, test_lines_through_pairs
# says: misses
# told: c has the wrong sign
def line_through(p, q):
    dx, dy = q[0] - p[0], q[1] - p[1]
    length = np.hypot(dx, dy)
    if length == 0:
        return None
    a, b = -dy / length, dx / length
    return a, b, a * p[0] + b * p[1]

# %% wrong: c without dividing
# loses: passes_through_both, test_lines_through_pairs
# says: misses
# told: and c is not
def line_through(p, q):
    dx, dy = q[0] - p[0], q[1] - p[1]
    length = np.hypot(dx, dy)
    if length == 0:
        return None
    return -dy / length, dx / length, dy * p[0] - dx * p[1]

# %% wrong: c forgotten
# loses: passes_through_both, test_lines_through_pairs
# says: misses
# told: c is missing
def line_through(p, q):
    dx, dy = q[0] - p[0], q[1] - p[1]
    length = np.hypot(dx, dy)
    if length == 0:
        return None
    return -dy / length, dx / length, 0

# %% wrong: c from x alone
# loses: passes_through_both, test_lines_through_pairs
# says: misses
def line_through(p, q):
    dx, dy = q[0] - p[0], q[1] - p[1]
    length = np.hypot(dx, dy)
    if length == 0:
        return None
    return -dy / length, dx / length, dy * p[0] / length

# %% wrong: equal points divide by zero
# loses only: refuses_equal_points, test_equal_points_have_no_line
# says: no answer but None
def line_through(p, q):
    dx, dy = q[0] - p[0], q[1] - p[1]
    length = np.hypot(dx, dy)
    a, b = -dy / length, dx / length
    return a, b, -(a * p[0] + b * p[1])

# %% wrong: an upright line counts as no line
# loses only: takes_upright_lines, test_lines_in_special_directions
# says: Equal x, or equal y, is no reason
def line_through(p, q):
    dx, dy = q[0] - p[0], q[1] - p[1]
    if dx == 0:
        return None
    length = np.hypot(dx, dy)
    a, b = -dy / length, dx / length
    return a, b, -(a * p[0] + b * p[1])

# %% wrong: near points count as equal
# loses only: takes_close_points, test_close_points_have_a_line
# says: The answer is None, though the points differ
def line_through(p, q):
    dx, dy = q[0] - p[0], q[1] - p[1]
    length = np.hypot(dx, dy)
    if length < 0.1:
        return None
    a, b = -dy / length, dx / length
    return a, b, -(a * p[0] + b * p[1])

# %% wrong: normalised over all three numbers
# loses only: has_a_unit_normal, test_unit_normals
# says: The normal (a, b) must have length 1
# told: all three numbers together
def line_through(p, q):
    if np.array_equal(p, q):
        return None
    line = np.cross([p[0], p[1], 1.0], [q[0], q[1], 1.0])
    return line / np.linalg.norm(line)

# %% wrong: slope and intercept returned
# loses: passes_through_both, has_a_unit_normal
# says: A line is three numbers
# told: the slope and the height
def line_through(p, q):
    if q[0] == p[0]:
        return None
    slope = (q[1] - p[1]) / (q[0] - p[0])
    return slope, p[1] - slope * p[0]

# %% wrong: writes into its arguments
# loses: leaves_the_points
# says: changed its input
def line_through(p, q):
    q -= p
    length = np.hypot(q[0], q[1])
    if length == 0:
        return None
    a, b = -q[1] / length, q[0] / length
    return a, b, -(a * p[0] + b * p[1])

# %% wrong: a hat for a power
# loses: passes_through_both, test_lines_through_pairs
# says: x**2 is the square
def line_through(p, q):
    dx, dy = q[0] - p[0], q[1] - p[1]
    length = (dx ^ 2 + dy ^ 2) ** 0.5
    return -dy / length, dx / length, (dy * p[0] - dx * p[1]) / length

# %% wrong: always None
# loses: passes_through_both, refuses_equal_points, test_equal_points_have_no_line
# says: end with `return`?
def line_through(p, q):
    return None

# %% wrong: stub left in place
# loses: passes_through_both, has_a_unit_normal, leaves_the_points
# says: is not started
def line_through(p, q):
    raise NotImplementedError
