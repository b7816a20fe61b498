# Answers to plane_through; see grader/course/kept_answers.py.

# %% right: the hints followed to the letter
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    normal = normal / length
    return (normal[0], normal[1], normal[2], -(normal @ p))

# %% right: cross product, a tuple back
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    a, b, c = normal / length
    return a, b, c, -(a * p[0] + b * p[1] + c * p[2])

# %% right: the cross product by hand, a list back
import math

def plane_through(p, q, r):
    print("three points")
    ux, uy, uz = (q[k] - p[k] for k in range(3))
    vx, vy, vz = (r[k] - p[k] for k in range(3))
    a, b, c = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    n = math.sqrt(a * a + b * b + c * c)
    if n < 1e-10:
        return None
    return [float(a / n), float(b / n), float(c / n), float(-(a * p[0] + b * p[1] + c * p[2]) / n)]

# %% right: single precision, the other sign
import warnings

def plane_through(p, q, r):
    warnings.warn("upside down")
    p, q, r = (np.asarray(point, dtype=float) for point in (p, q, r))
    normal = np.cross(r - p, q - p)
    if np.allclose(normal, 0):
        return None
    normal = normal / np.sqrt(normal @ normal)
    return np.append(normal, -np.dot(normal, q)).astype(np.float32)

# %% right: the null space by SVD
def plane_through(p, q, r):
    rows = np.array([q - p, r - p], dtype=float)
    _, sizes, directions = np.linalg.svd(rows)
    if sizes[1] < 1e-7:
        return None
    return tuple(directions[2]) + (-directions[2] @ p,)

# %% right: a normal that looks up, with a helper in another cell
def upwards(n):
    return -n if n[2] < 0 else n
# ---- another cell ----
def plane_through(p, q, r):
    n = upwards(np.cross(q - p, r - q))
    size = (n ** 2).sum() ** 0.5
    return None if size <= 1e-8 else np.concatenate([n, [-(n * p).sum()]]) / size

# %% wrong: forgets to normalise
# loses only: has_a_unit_normal, test_lengths
# says: has length
# told: is not divided by its length
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    if np.linalg.norm(normal) < 1e-9:
        return None
    return (*normal, -normal @ p)

# %% wrong: normalises after d
# loses only: holds_its_points, test_offsets
# says: do not lie on the plane
# told: computed with the long normal
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    d = -normal @ p
    return (*(normal / length), d)

# %% wrong: no guard against a line
# loses only: refuses_a_line, sees_through_rounding, test_lines
# says: lie on one line
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    normal = normal / np.linalg.norm(normal)
    return (*normal, -normal @ p)

# %% wrong: the sign of d
# loses only: holds_its_points, test_offsets
# says: do not lie on the plane
# told: The sign of d is wrong
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    normal = normal / length
    return (*normal, normal @ p)

# %% wrong: cross product of the points themselves
# loses: stands_upright, test_random_triangles
# says: is not perpendicular
# told: of the points p and q themselves
def plane_through(p, q, r):
    normal = np.cross(p, q)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    normal = normal / length
    return (*normal, -normal @ p)

# %% wrong: compares with exactly zero
# loses only: sees_through_rounding
# says: lie on one line
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length == 0:
        return None
    normal = normal / length
    return (*normal, -normal @ p)

# %% wrong: moves its points
# loses only: leaves_its_points
# says: changed its input
def plane_through(p, q, r):
    q -= p
    r -= p
    normal = np.cross(q, r)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    normal = normal / length
    return (*normal, -normal @ p)

# %% wrong: zeros for a line
# loses only: refuses_a_line, sees_through_rounding, test_lines
# says: infinitely many planes
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return (0.0, 0.0, 0.0, 0.0)
    normal = normal / length
    return (*normal, -normal @ p)

# %% wrong: small triangles are refused
# loses only: takes_a_small_triangle
# says: they have a plane
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 0.05:
        return None
    normal = normal / length
    return (*normal, -normal @ p)

# %% wrong: returns the normal alone
# loses: stands_upright, holds_its_points, refuses_a_line, test_random_triangles
# says: The fourth, d, is missing
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    return normal / max(np.linalg.norm(normal), 1e-9)

# %% wrong: always None
# loses: stands_upright, holds_its_points, has_a_unit_normal, refuses_a_line, takes_a_small_triangle, test_lines
# says: None for three points that have a plane
def plane_through(p, q, r):
    return None

# %% wrong: p is not subtracted from r
# loses: stands_upright, test_random_triangles
# says: is not perpendicular
# told: but not from r
def plane_through(p, q, r):
    normal = np.cross(q - p, r)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    normal = normal / length
    return (*normal, -normal @ p)

# %% wrong: d is always 0
# loses only: holds_its_points, test_offsets
# says: do not lie on the plane
# told: d is always 0
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    normal = normal / length
    return (*normal, 0.0)

# %% wrong: forgets to return
# loses: stands_upright, test_random_triangles
# says: Does every other way through the function end
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    normal = normal / length
    plane = (*normal, -normal @ p)

# %% wrong: parameters renamed
# loses only: keeps_p_q_r
# says: another name
def plane_through(a, b, c):
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    normal = normal / length
    return (*normal, -normal @ a)

# %% wrong: twice the length
# loses only: has_a_unit_normal, test_lengths
# says: has length 2, not 1
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    normal = normal / length
    return (*(2 * normal), -2 * normal @ p)
