# Answers to match_boxes; see grader/course/kept_answers.py.

# %% right: the closest pair first
def match_boxes(previous, current, max_distance):
    table = np.linalg.norm(current.mean(axis=1)[:, None] - previous.mean(axis=1)[None], axis=2)
    partner = np.full(len(current), -1)
    while table.size and table.min() < max_distance:
        row, column = np.unravel_index(table.argmin(), table.shape)
        partner[row] = column
        table[row], table[:, column] = np.inf, np.inf
    return partner

# %% right: optimal assignment
from scipy.optimize import linear_sum_assignment
from scipy.spatial.distance import cdist

def match_boxes(previous, current, max_distance):
    partner = -np.ones(len(current))
    if len(previous) and len(current):
        cost = cdist(current.mean(axis=1), previous.mean(axis=1))
        rows, columns = linear_sum_assignment(np.where(cost > max_distance, 1e6, cost))
        good = cost[rows, columns] <= max_distance
        partner[rows[good]] = columns[good]
    return partner

# %% right: sorted pairs in plain Python, a list back
import math

def centre(box):
    return [sum(float(corner[axis]) for corner in box) / 8 for axis in range(3)]
# ---- another cell ----
def match_boxes(previous, current, max_distance):
    old, new = [centre(box) for box in previous], [centre(box) for box in current]
    pairs = sorted((math.dist(b, a), i, j) for i, b in enumerate(new) for j, a in enumerate(old))
    result, taken = [-1] * len(new), set()
    for distance, i, j in pairs:
        if distance <= max_distance and result[i] == -1 and j not in taken:
            result[i] = j
            taken.add(j)
    print(len(taken), "pairs")
    return result

# %% right: nearest to each other
from scipy.spatial import cKDTree

def match_boxes(previous, current, max_distance):
    if len(previous) == 0 or len(current) == 0:
        return np.full(len(current), -1, dtype=np.int32)
    middle = lambda boxes: (boxes.min(axis=1) + boxes.max(axis=1)) / 2
    old, new = middle(previous)[:, :2], middle(current)[:, :2]
    distance, there = cKDTree(old).query(new)
    back = cKDTree(new).query(old)[1]
    mutual = (back[there] == np.arange(len(new))) & (distance < max_distance)
    return np.where(mutual, there, -1).astype(np.int32)

# %% right: each previous box chooses among those that nobody else is closer to
class Matcher:
    def __init__(self, limit):
        self.limit = limit

    def __call__(self, old, new):
        result = np.full(len(new), -1, dtype=int)
        order = np.argsort([min((np.linalg.norm(b - a) for b in new), default=0) for a in old])
        for j in order:
            free = [i for i in range(len(new)) if result[i] < 0]
            if not free:
                break
            i = min(free, key=lambda i: np.linalg.norm(new[i] - old[j]))
            if np.linalg.norm(new[i] - old[j]) <= self.limit:
                result[i] = j
        return result

def match_boxes(previous, current, max_distance):
    return Matcher(max_distance)(np.asarray(previous).mean(axis=1), np.asarray(current).mean(axis=1))

# %% wrong: the nearest, whoever else has it
# loses only: is_one_to_one, test_one_to_one
# says: several current boxes
# told: also where that one has a nearer partner
def match_boxes(previous, current, max_distance):
    if len(previous) == 0:
        return np.full(len(current), -1)
    table = np.linalg.norm(current.mean(axis=1)[:, None] - previous.mean(axis=1)[None], axis=2)
    return np.where(table.min(axis=1) <= max_distance, table.argmin(axis=1), -1)

# %% wrong: first come, first served
# loses only: prefers_the_nearer, test_nearer
# says: closest of all pairs first
# told: Whichever current box comes first
def match_boxes(previous, current, max_distance):
    partner, taken = np.full(len(current), -1), set()
    for i, box in enumerate(current.mean(axis=1)):
        distances = [np.inf if j in taken else np.linalg.norm(box - old)
                     for j, old in enumerate(previous.mean(axis=1))]
        if distances and min(distances) <= max_distance:
            partner[i] = int(np.argmin(distances))
            taken.add(int(np.argmin(distances)))
    return partner

# %% wrong: never too far
# loses only: ends_at_the_limit, test_limit
# says: it has no partner
# told: pairs are made as long as
def match_boxes(previous, current, max_distance):
    table = np.linalg.norm(current.mean(axis=1)[:, None] - previous.mean(axis=1)[None], axis=2)
    partner = np.full(len(current), -1)
    for _ in range(min(table.shape)):
        row, column = np.unravel_index(table.argmin(), table.shape)
        partner[row] = column
        table[row], table[:, column] = np.inf, np.inf
    return partner

# %% wrong: the best sum first, max_distance afterwards
# loses only: ends_at_the_limit, test_limit
# says: that is its partner
# told: The best sum is sought among all pairs
from scipy.optimize import linear_sum_assignment

def match_boxes(previous, current, max_distance):
    table = np.linalg.norm(current.mean(axis=1)[:, None] - previous.mean(axis=1)[None], axis=2)
    partner = np.full(len(current), -1)
    for row, column in zip(*linear_sum_assignment(table)):
        if table[row, column] <= max_distance:
            partner[row] = column
    return partner

# %% wrong: the other way round
# loses: finds_again, test_many_boxes, test_lengths
# says: was previous box
# told: wrong way round
def match_boxes(previous, current, max_distance):
    table = np.linalg.norm(current.mean(axis=1)[:, None] - previous.mean(axis=1)[None], axis=2)
    partner = np.full(len(previous), -1)
    while table.size and table.min() < max_distance:
        row, column = np.unravel_index(table.argmin(), table.shape)
        partner[column] = row
        table[row], table[:, column] = np.inf, np.inf
    return partner

# %% wrong: the first corner stands for the box
# loses only: goes_by_the_centres, test_order_of_corners
# says: mean of all eight
# told: Corners are compared
def match_boxes(previous, current, max_distance):
    table = np.linalg.norm(current[:, 0][:, None] - previous[:, 0][None], axis=2)
    partner = np.full(len(current), -1)
    while table.size and table.min() < max_distance:
        row, column = np.unravel_index(table.argmin(), table.shape)
        partner[row] = column
        table[row], table[:, column] = np.inf, np.inf
    return partner

# %% wrong: squared distance
# loses only: ends_at_the_limit, test_limit
# says: Take the root
# told: square of the distance
def match_boxes(previous, current, max_distance):
    table = ((current.mean(axis=1)[:, None] - previous.mean(axis=1)[None]) ** 2).sum(axis=2)
    partner = np.full(len(current), -1)
    while table.size and table.min() < max_distance:
        row, column = np.unravel_index(table.argmin(), table.shape)
        partner[row] = column
        table[row], table[:, column] = np.inf, np.inf
    return partner

# %% wrong: the distance is written into the function
# loses only: ends_at_the_limit, test_limit
# says: Compare with max_distance
# told: A fixed distance
def match_boxes(previous, current, max_distance):
    table = np.linalg.norm(current.mean(axis=1)[:, None] - previous.mean(axis=1)[None], axis=2)
    partner = np.full(len(current), -1)
    while table.size and table.min() < 1.5:
        row, column = np.unravel_index(table.argmin(), table.shape)
        partner[row] = column
        table[row], table[:, column] = np.inf, np.inf
    return partner

# %% wrong: box k is box k
# loses: finds_again, is_one_to_one, test_many_boxes
# says: was previous box
# told: Box k of the one
def match_boxes(previous, current, max_distance):
    index = np.arange(len(current))
    return np.where(index < len(previous), index, -1)

# %% wrong: everything is new
# loses: finds_again, is_one_to_one, test_many_boxes
# says: was previous box
# told: No box gets a partner
def match_boxes(previous, current, max_distance):
    return np.full(len(current), -1)

# %% wrong: the first frame is marked by -2
# loses only: takes_no_boxes
# says: is not marked as new
def match_boxes(previous, current, max_distance):
    if len(previous) == 0:
        return np.full(len(current), -2)
    table = np.linalg.norm(current.mean(axis=1)[:, None] - previous.mean(axis=1)[None], axis=2)
    partner = np.full(len(current), -1)
    while table.size and table.min() <= max_distance:
        i, j = np.unravel_index(table.argmin(), table.shape)
        partner[i] = j
        table[i], table[:, j] = np.inf, np.inf
    return partner

# %% wrong: no boxes, no mercy
# loses only: takes_no_boxes
# says: nothing to take the smallest
def match_boxes(previous, current, max_distance):
    table = np.linalg.norm(current.mean(axis=1)[:, None] - previous.mean(axis=1)[None], axis=2)
    partner = np.full(len(current), -1)
    while table.min() < max_distance:
        row, column = np.unravel_index(table.argmin(), table.shape)
        partner[row] = column
        table[row], table[:, column] = np.inf, np.inf
    return partner

# %% wrong: a list of pairs
# loses: finds_again, is_one_to_one, test_many_boxes
# says: If these are pairs
def match_boxes(previous, current, max_distance):
    table = np.linalg.norm(current.mean(axis=1)[:, None] - previous.mean(axis=1)[None], axis=2)
    pairs = []
    while table.size and table.min() < max_distance:
        row, column = np.unravel_index(table.argmin(), table.shape)
        pairs.append((int(row), int(column)))
        table[row], table[:, column] = np.inf, np.inf
    return pairs

# %% wrong: every previous box takes the nearest, however far
# loses only: ends_at_the_limit, test_limit, test_second_choice, test_lengths
# says: it has no partner
# told: Each previous box takes
def match_boxes(previous, current, max_distance):
    table = np.linalg.norm(current.mean(axis=1)[:, None] - previous.mean(axis=1)[None], axis=2)
    partner = np.full(len(current), -1)
    for column in range(len(previous)):
        row = table[:, column].argmin() if len(current) else 0
        if len(current):
            partner[row] = column
    return partner

# %% wrong: None for new ones
# loses: marks_new_ones, ends_at_the_limit, test_new_ones
# says: None is no index
def match_boxes(previous, current, max_distance):
    table = np.linalg.norm(current.mean(axis=1)[:, None] - previous.mean(axis=1)[None], axis=2)
    partner = [None] * len(current)
    while table.size and table.min() < max_distance:
        row, column = np.unravel_index(table.argmin(), table.shape)
        partner[row] = int(column)
        table[row], table[:, column] = np.inf, np.inf
    return partner

# %% wrong: parameters renamed
# loses only: keeps_the_names
# says: A parameter has another name
def match_boxes(old, new, limit):
    table = np.linalg.norm(new.mean(axis=1)[:, None] - old.mean(axis=1)[None], axis=2)
    partner = np.full(len(new), -1)
    while table.size and table.min() < limit:
        row, column = np.unravel_index(table.argmin(), table.shape)
        partner[row] = column
        table[row], table[:, column] = np.inf, np.inf
    return partner

# %% wrong: moves the boxes it has used out of the way
# loses only: leaves_the_boxes
# says: changed its input
def match_boxes(previous, current, max_distance):
    partner = np.full(len(current), -1)
    for _ in range(len(current)):
        table = np.linalg.norm(current.mean(axis=1)[:, None] - previous.mean(axis=1)[None], axis=2)
        if not table.size or table.min() > max_distance:
            break
        row, column = np.unravel_index(table.argmin(), table.shape)
        partner[row] = column
        previous[column] += 1e6
        current[row] -= 1e6
    return partner

# %% wrong: 0 for new ones
# loses: marks_new_ones, ends_at_the_limit, test_new_ones, test_limit
# says: -1
# told: 0 stands where
def match_boxes(previous, current, max_distance):
    table = np.linalg.norm(current.mean(axis=1)[:, None] - previous.mean(axis=1)[None], axis=2)
    partner = np.zeros(len(current), dtype=int)
    while table.size and table.min() <= max_distance:
        row, column = np.unravel_index(table.argmin(), table.shape)
        partner[row] = column
        table[row], table[:, column] = np.inf, np.inf
    return partner

# %% wrong: NaN for new ones
# loses only: marks_new_ones, test_new_ones
# says: is not marked as new
def match_boxes(previous, current, max_distance):
    table = np.linalg.norm(current.mean(axis=1)[:, None] - previous.mean(axis=1)[None], axis=2)
    partner = np.full(len(current), np.nan)
    while table.size and table.min() <= max_distance:
        row, column = np.unravel_index(table.argmin(), table.shape)
        partner[row] = column
        table[row], table[:, column] = np.inf, np.inf
    return partner

# %% wrong: strikes out the row and forgets the column
# loses only: is_one_to_one, test_one_to_one
# says: several current boxes
# told: also where that one has a nearer partner
def match_boxes(previous, current, max_distance):
    table = np.linalg.norm(current.mean(axis=1)[:, None] - previous.mean(axis=1)[None], axis=2)
    partner = np.full(len(current), -1)
    while table.size and table.min() <= max_distance:
        row, column = np.unravel_index(table.argmin(), table.shape)
        partner[row] = column
        table[row] = np.inf
    return partner

# %% wrong: strikes out the column and forgets the row
# loses only: takes_the_nearer, test_second_choice
# says: put infinity into table[row, :]
# told: gets another, farther one later
def match_boxes(previous, current, max_distance):
    table = np.linalg.norm(current.mean(axis=1)[:, None] - previous.mean(axis=1)[None], axis=2)
    partner = np.full(len(current), -1)
    while table.size and table.min() <= max_distance:
        row, column = np.unravel_index(table.argmin(), table.shape)
        partner[row] = column
        table[:, column] = np.inf
    return partner

# %% wrong: argmin of the whole table, without an axis
# loses: finds_again, is_one_to_one, test_many_boxes
# says: which is no row of previous
def match_boxes(previous, current, max_distance):
    table = np.linalg.norm(current.mean(axis=1)[:, None] - previous.mean(axis=1)[None], axis=2)
    return np.where(table.min(axis=1, initial=np.inf) <= max_distance, table.argmin(), -1)

# %% wrong: the table of distances itself
# loses: finds_again, is_one_to_one, test_many_boxes
# says: a table of all pairs
def match_boxes(previous, current, max_distance):
    table = np.linalg.norm(current.mean(axis=1)[:, None] - previous.mean(axis=1)[None], axis=2)
    return np.where(table <= max_distance, table, -1)

# %% wrong: forgets to return
# loses: finds_again, is_one_to_one, test_many_boxes
# says: returned None
def match_boxes(previous, current, max_distance):
    table = np.linalg.norm(current.mean(axis=1)[:, None] - previous.mean(axis=1)[None], axis=2)
    partner = np.full(len(current), -1)
    while table.size and table.min() <= max_distance:
        row, column = np.unravel_index(table.argmin(), table.shape)
        partner[row] = column
        table[row], table[:, column] = np.inf, np.inf

# %% wrong: the nearest, however far and whoever else has it
# loses only: marks_new_ones, test_new_ones, is_one_to_one, ends_at_the_limit, test_one_to_one, test_limit
# says: it has no partner
# told: however far it is and whoever else has it
def match_boxes(previous, current, max_distance):
    if not len(previous):
        return np.full(len(current), -1)
    table = np.linalg.norm(current.mean(axis=1)[:, None] - previous.mean(axis=1)[None], axis=2)
    return table.argmin(axis=1)

# %% wrong: a distance of 1 m is written into the function
# loses: ends_at_the_limit, test_many_boxes, test_limit
# says: Compare the distance itself
def match_boxes(previous, current, max_distance):
    table = np.linalg.norm(current.mean(axis=1)[:, None] - previous.mean(axis=1)[None], axis=2)
    partner = np.full(len(current), -1)
    while table.size and table.min() < 1.0:
        row, column = np.unravel_index(table.argmin(), table.shape)
        partner[row] = column
        table[row], table[:, column] = np.inf, np.inf
    return partner

# %% wrong: corner against corner
# loses only: goes_by_the_centres, test_order_of_corners
# says: mean of all eight
# told: Corners are compared
def match_boxes(previous, current, max_distance):
    table = np.linalg.norm(current[:, None] - previous[None], axis=3).mean(axis=2)
    partner = np.full(len(current), -1)
    while table.size and table.min() <= max_distance:
        row, column = np.unravel_index(table.argmin(), table.shape)
        partner[row] = column
        table[row], table[:, column] = np.inf, np.inf
    return partner

# %% wrong: rows and columns of the table exchanged
# loses: finds_again, test_many_boxes
# says: Read the other way round, your pairs are right
def match_boxes(previous, current, max_distance):
    answer = np.full(len(current), -1)
    if len(previous) == 0 or len(current) == 0:
        return answer
    table = np.linalg.norm(current.mean(axis=1)[:, None] - previous.mean(axis=1), axis=2)
    while table.min() <= max_distance:
        row, column = np.unravel_index(table.argmin(), table.shape)
        answer[column] = row
        table[row, :] = np.inf
        table[:, column] = np.inf
    return answer

# %% wrong: the mean over the wrong axis
# loses: ends_at_the_limit, goes_by_the_centres
# says: axis=2 would mix x with y
# told: The mean is taken over x, y and z
def match_boxes(previous, current, max_distance):
    answer = np.full(len(current), -1)
    if len(previous) == 0 or len(current) == 0:
        return answer
    table = np.linalg.norm(current.mean(axis=2)[:, None] - previous.mean(axis=2), axis=2)
    while table.min() <= max_distance:
        row, column = np.unravel_index(table.argmin(), table.shape)
        answer[row] = column
        table[row, :] = np.inf
        table[:, column] = np.inf
    return answer

# %% wrong: the ways along the axes added up
# loses only: ends_at_the_limit, test_limit, test_many_boxes
# says: Compare the distance itself
def match_boxes(previous, current, max_distance):
    table = np.abs(current.mean(axis=1)[:, None] - previous.mean(axis=1)).sum(axis=2)
    answer = np.full(len(current), -1)
    while table.size and table.min() <= max_distance:
        row, column = np.unravel_index(table.argmin(), table.shape)
        answer[row] = column
        table[row, :] = table[:, column] = np.inf
    return answer

# %% wrong: one pair, and back
# loses: finds_again
# says: was previous box
# told: A single pair is made
def match_boxes(previous, current, max_distance):
    table = np.linalg.norm(current.mean(axis=1)[:, None] - previous.mean(axis=1), axis=2)
    answer = np.full(len(current), -1)
    while table.size and table.min() <= max_distance:
        row, column = np.unravel_index(table.argmin(), table.shape)
        answer[row] = column
        table[row, :] = table[:, column] = np.inf
        return answer
    return answer
