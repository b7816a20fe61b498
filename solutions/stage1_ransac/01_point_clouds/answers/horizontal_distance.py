# Answers to horizontal_distance; see grader/course/kept_answers.py.

# %% right: the hints followed to the letter
def horizontal_distance(cloud):
    return np.hypot(cloud[:, 0], cloud[:, 1])

# %% right: a loop in plain Python, a list back
import math

def horizontal_distance(cloud):
    distances = []
    for row in cloud:
        distances.append(math.sqrt(row[0] ** 2 + row[1] ** 2))
    return distances

# %% right: norm of the first two columns, single precision
def horizontal_distance(cloud):
    return np.linalg.norm(cloud[:, :2].astype(np.float32), axis=1)

# %% right: complex numbers, with a warning and a print
import warnings

def horizontal_distance(cloud):
    warnings.warn("turning points into complex numbers")
    print(cloud.shape)
    return np.abs(cloud[:, 0] + 1j * cloud[:, 1])

# %% right: a helper in another cell
def root_of_squares(a, b):
    return (a * a + b * b) ** 0.5

# ---- another cell ----
def horizontal_distance(cloud):
    x, y = cloud.T[:2]
    return root_of_squares(x, y)

# %% right: a class and einsum
class Ground:
    def __init__(self, cloud):
        self.flat = np.asarray(cloud)[:, [0, 1]]

    def distances(self):
        return np.sqrt(np.einsum("ij,ij->i", self.flat, self.flat))

def horizontal_distance(cloud):
    return Ground(cloud).distances()

# %% right: unpacks three or four columns
def horizontal_distance(cloud):
    x, y, z, *intensity = cloud.transpose()
    return np.array([float(a) for a in np.sqrt(np.square(x) + np.square(y))])

# %% wrong: length of x, y, z
# loses: ignores_height, test_distances_in_course_cloud
# says: of 5 distances are wrong
# told: the height is mixed in
def horizontal_distance(cloud):
    return np.linalg.norm(cloud[:, :3], axis=1)

# %% wrong: length of the whole row
# loses: ignores_height, ignores_intensity, test_distances_in_fresh_street
# says: of 5 distances are wrong
# told: height and intensity are mixed in
def horizontal_distance(cloud):
    return np.linalg.norm(cloud, axis=1)

# %% wrong: intensity counted by mistake
# loses only: ignores_intensity, test_distances
# says: The last column is no length
def horizontal_distance(cloud):
    return np.linalg.norm(cloud[:, [0, 1, -1]] * [1, 1, cloud.shape[1] == 4], axis=1)

# %% wrong: no square root
# loses: measures_distance, test_distances_in_course_cloud
# says: distances are wrong
# told: the square root is missing
def horizontal_distance(cloud):
    return cloud[:, 0] ** 2 + cloud[:, 1] ** 2

# %% wrong: sum of the sides
# loses: measures_distance, test_distances_in_fresh_street
# says: distances are wrong
# told: the way around the corner
def horizontal_distance(cloud):
    return np.abs(cloud[:, 0]) + np.abs(cloud[:, 1])

# %% wrong: the larger of the sides
# loses: measures_distance, test_distances_in_fresh_street
# says: distances are wrong
# told: the larger of
def horizontal_distance(cloud):
    return np.maximum(abs(cloud[:, 0]), abs(cloud[:, 1]))

# %% wrong: rows for columns
# loses: measures_distance, test_distances_in_course_cloud
# says: one distance for each of the 5 points
# told: the first two rows
def horizontal_distance(cloud):
    return np.sqrt(cloud[0] ** 2 + cloud[1] ** 2)

# %% wrong: down the columns
# loses: measures_distance, test_distances_in_course_cloud
# says: one distance for each of the 5 points
# told: taken down the columns
def horizontal_distance(cloud):
    return np.linalg.norm(cloud[:, :2], axis=0)

# %% wrong: down all columns
# loses: measures_distance, test_distances_in_course_cloud
# says: one distance for each of the 5 points
# told: taken down all columns
def horizontal_distance(cloud):
    return np.linalg.norm(cloud, axis=0)

# %% wrong: columns counted from 1
# loses: measures_distance, test_distances_in_course_cloud
# says: distances are wrong
# told: Columns are counted from 0
def horizontal_distance(cloud):
    return np.sqrt(cloud[:, 1] ** 2 + cloud[:, 2] ** 2)

# %% wrong: only forward
# loses: measures_distance, test_distances_when_turned
# says: distances are wrong
# told: a point to the side is far away
def horizontal_distance(cloud):
    return np.abs(cloud[:, 0])

# %% wrong: one number for the whole cloud
# loses: measures_distance, test_distances_in_course_cloud
# says: an axis= is missing
def horizontal_distance(cloud):
    return np.linalg.norm(cloud[:, :2])

# %% wrong: the root of a single number
# loses: measures_distance, test_distances_in_course_cloud
# says: The functions of `math` take one number
import math

def horizontal_distance(cloud):
    return math.sqrt(cloud[:, 0] ** 2 + cloud[:, 1] ** 2)

# %% wrong: a hat for a power
# loses: measures_distance, test_distances_in_course_cloud
# says: x**2 is the square
def horizontal_distance(cloud):
    return np.sqrt(cloud[:, 0] ^ 2 + cloud[:, 1] ^ 2)

# %% wrong: signed, negative behind the car
# loses: measures_distance, test_distances_in_course_cloud
# says: 2 of 5 distances are wrong
# told: behind the sensor are negative
def horizontal_distance(cloud):
    return np.where(cloud[:, 0] < 0, -1, 1) * np.hypot(cloud[:, 0], cloud[:, 1])

# %% wrong: squares in place
# loses only: leaves_its_input
# says: changed its input
def horizontal_distance(cloud):
    x, y = cloud[:, 0], cloud[:, 1]
    x *= x
    y *= y
    return np.sqrt(x + y)

# %% wrong: needs four columns
# loses only: takes_three_columns, test_distances_of_three_columns
# says: more or fewer names than
def horizontal_distance(cloud):
    x, y, z, intensity = cloud.T
    return np.sqrt(x ** 2 + y ** 2)

# %% wrong: fails for one point
# loses only: takes_few_points, test_distances_of_three_columns
# says: one distance for
def horizontal_distance(cloud):
    x, y = np.squeeze(cloud[:, :2]).T
    return np.hypot(x, y)

# %% wrong: forgets to return
# loses: measures_distance, takes_three_columns, leaves_its_input
# says: returned None
def horizontal_distance(cloud):
    distance = np.hypot(cloud[:, 0], cloud[:, 1])

# %% wrong: sorted, nearest first
# loses: measures_distance, test_distances_in_course_cloud
# says: distances are wrong
# told: The distances are sorted
def horizontal_distance(cloud):
    return np.sort(np.hypot(cloud[:, 0], cloud[:, 1]))

# %% wrong: a column instead of a flat array
# loses: measures_distance
# says: A column (n, 1) is a table
def horizontal_distance(cloud):
    return np.sqrt((cloud[:, :2] ** 2).sum(axis=1, keepdims=True))

# %% wrong: rounded to whole metres
# loses: test_distances_in_course_cloud
# says: distances are wrong
def horizontal_distance(cloud):
    return np.round(np.hypot(cloud[:, 0], cloud[:, 1]))

# %% wrong: stub left in place
# loses: measures_distance, test_distances_in_course_cloud, leaves_its_input
# says: is not started
def horizontal_distance(cloud):
    raise NotImplementedError
