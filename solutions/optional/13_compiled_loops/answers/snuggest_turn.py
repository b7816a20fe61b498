# Answers to snuggest_turn, which nothing grades; see grader/course/kept_answers.py.

# %% right: the hints followed to the letter
def snuggest_turn(points):
    back, front = np.full(90, np.inf), np.full(90, -np.inf)
    right, left = np.full(90, np.inf), np.full(90, -np.inf)
    for i in range(len(points)):
        x, y = points[i, 0], points[i, 1]
        for turn in range(90):
            along = x * cosines[turn] + y * sines[turn]
            across = y * cosines[turn] - x * sines[turn]
            back[turn], front[turn] = min(back[turn], along), max(front[turn], along)
            right[turn], left[turn] = min(right[turn], across), max(left[turn], across)
    return ((front - back) * (left - right)).argmin()

# %% right: turn by turn, the least so far
def snuggest_turn(points):
    best, least = 0, np.inf
    for turn in range(90):
        back = right = np.inf
        front = left = -np.inf
        for x, y, z in points:
            along = x * cosines[turn] + y * sines[turn]
            across = y * cosines[turn] - x * sines[turn]
            back, front = min(back, along), max(front, along)
            right, left = min(right, across), max(left, across)
        area = (front - back) * (left - right)
        if area < least:
            best, least = turn, area
    return best

# %% right: begins with the first point
def snuggest_turn(points):
    area = np.zeros(90)
    for turn in range(90):
        back = front = points[0, 0] * cosines[turn] + points[0, 1] * sines[turn]
        right = left = points[0, 1] * cosines[turn] - points[0, 0] * sines[turn]
        for i in range(1, len(points)):
            along = points[i, 0] * cosines[turn] + points[i, 1] * sines[turn]
            across = points[i, 1] * cosines[turn] - points[i, 0] * sines[turn]
            if along < back:
                back = along
            if along > front:
                front = along
            if across < right:
                right = across
            if across > left:
                left = across
        area[turn] = (front - back) * (left - right)
    return np.argmin(area)

# %% right: whole columns, which compile, too
def snuggest_turn(points):
    x, y = points[:, 0].copy(), points[:, 1].copy()
    area = np.empty(90)
    for turn in range(90):
        along = x * cosines[turn] + y * sines[turn]
        across = y * cosines[turn] - x * sines[turn]
        area[turn] = (along.max() - along.min()) * (across.max() - across.min())
    return int(area.argmin())

# %% right: one table of four rows
def snuggest_turn(points):
    ends = np.full((4, 90), -np.inf)
    for i in range(len(points)):
        x, y = points[i, 0], points[i, 1]
        for turn in range(90):
            along, across = x * cosines[turn] + y * sines[turn], y * cosines[turn] - x * sines[turn]
            ends[0, turn] = max(ends[0, turn], along)
            ends[1, turn] = max(ends[1, turn], -along)
            ends[2, turn] = max(ends[2, turn], across)
            ends[3, turn] = max(ends[3, turn], -across)
    return ((ends[0] + ends[1]) * (ends[2] + ends[3])).argmin()

# %% wrong: the largest area
# loses: finds_the_lean
# says: At this turn the rectangle is not the least
# told: the largest area
def snuggest_turn(points):
    along = np.outer(cosines, points[:, 0]) + np.outer(sines, points[:, 1])
    across = np.outer(cosines, points[:, 1]) - np.outer(sines, points[:, 0])
    return (np.ptp(along, axis=1) * np.ptp(across, axis=1)).argmax()

# %% wrong: the least rim
# loses: finds_the_least
# says: At another turn the rectangle is smaller
# told: The sum of the two sides
def snuggest_turn(points):
    along = np.outer(cosines, points[:, 0]) + np.outer(sines, points[:, 1])
    across = np.outer(cosines, points[:, 1]) - np.outer(sines, points[:, 0])
    return (np.ptp(along, axis=1) + np.ptp(across, axis=1)).argmin()

# %% wrong: along alone
# loses: finds_the_lean
# says: At this turn the rectangle is not the least
# told: Only what lies along
def snuggest_turn(points):
    along = np.outer(cosines, points[:, 0]) + np.outer(sines, points[:, 1])
    return np.ptp(along, axis=1).argmin()

# %% wrong: across alone
# loses: finds_the_lean
# says: is not the least
# told: Only what lies across
def snuggest_turn(points):
    across = np.outer(cosines, points[:, 1]) - np.outer(sines, points[:, 0])
    return np.ptp(across, axis=1).argmin()

# %% wrong: begins at zero
# loses only: finds_it_anywhere, finds_the_least
# says: The same away from the sensor
# told: The sensor counts as a point
def snuggest_turn(points):
    back, front, right, left = np.zeros(90), np.zeros(90), np.zeros(90), np.zeros(90)
    for i in range(len(points)):
        x, y = points[i, 0], points[i, 1]
        for turn in range(90):
            along = x * cosines[turn] + y * sines[turn]
            across = y * cosines[turn] - x * sines[turn]
            back[turn], front[turn] = min(back[turn], along), max(front[turn], along)
            right[turn], left[turn] = min(right[turn], across), max(left[turn], across)
    return ((front - back) * (left - right)).argmin()

# %% wrong: plus where minus belongs
# loses: finds_the_lean
# says: At this turn the rectangle is not the least
def snuggest_turn(points):
    along = np.outer(cosines, points[:, 0]) + np.outer(sines, points[:, 1])
    across = np.outer(cosines, points[:, 1]) + np.outer(sines, points[:, 0])
    return (np.ptp(along, axis=1) * np.ptp(across, axis=1)).argmin()

# %% wrong: turns the other way
# loses: finds_the_lean
# says: At this turn the rectangle is not the least
# told: It turns the other way
def snuggest_turn(points):
    along = np.outer(cosines, points[:, 0]) - np.outer(sines, points[:, 1])
    across = np.outer(cosines, points[:, 1]) + np.outer(sines, points[:, 0])
    return (np.ptp(along, axis=1) * np.ptp(across, axis=1)).argmin()

# %% wrong: from the side
# loses: finds_the_lean
# says: At this turn the rectangle is not the least
# told: z is taken for y
def snuggest_turn(points):
    x, y = points[:, 0], points[:, 2]
    along = np.outer(cosines, x) + np.outer(sines, y)
    across = np.outer(cosines, y) - np.outer(sines, x)
    return (np.ptp(along, axis=1) * np.ptp(across, axis=1)).argmin()

# %% wrong: the area
# loses: finds_the_lean
# says: no number of a turn
# told: It returns the area
def snuggest_turn(points):
    along = np.outer(cosines, points[:, 0]) + np.outer(sines, points[:, 1])
    across = np.outer(cosines, points[:, 1]) - np.outer(sines, points[:, 0])
    return (np.ptp(along, axis=1) * np.ptp(across, axis=1)).min()

# %% wrong: radians
# loses: finds_the_lean
# says: no number of a turn
# told: The turn is returned in radians
def snuggest_turn(points):
    along = np.outer(cosines, points[:, 0]) + np.outer(sines, points[:, 1])
    across = np.outer(cosines, points[:, 1]) - np.outer(sines, points[:, 0])
    return np.radians((np.ptp(along, axis=1) * np.ptp(across, axis=1)).argmin())

# %% wrong: one point too few
# loses: finds_the_least
# says: is smaller
# told: The last point
def snuggest_turn(points):
    x, y = points[:-1, 0], points[:-1, 1]
    if not len(x):
        return 0
    along = np.outer(cosines, x) + np.outer(sines, y)
    across = np.outer(cosines, y) - np.outer(sines, x)
    return (np.ptp(along, axis=1) * np.ptp(across, axis=1)).argmin()

# %% wrong: all areas
# loses: finds_the_lean
# says: The answer is one number
def snuggest_turn(points):
    along = np.outer(cosines, points[:, 0]) + np.outer(sines, points[:, 1])
    across = np.outer(cosines, points[:, 1]) - np.outer(sines, points[:, 0])
    return np.ptp(along, axis=1) * np.ptp(across, axis=1)

# %% wrong: needs two points
# loses only: takes_one_point
# says: zero-size array
def snuggest_turn(points):
    x, y = points[:, 0] - points[0, 0], points[:, 1] - points[0, 1]
    x, y = x[1:], y[1:]
    along = np.outer(cosines, x) + np.outer(sines, y)
    across = np.outer(cosines, y) - np.outer(sines, x)
    length = np.maximum(along.max(axis=1), 0) - np.minimum(along.min(axis=1), 0)
    width = np.maximum(across.max(axis=1), 0) - np.minimum(across.min(axis=1), 0)
    return (length * width).argmin()

# %% wrong: centres the points in place
# loses only: leaves_the_cluster
# says: changed its input
def snuggest_turn(points):
    points -= points.mean(axis=0)
    along = np.outer(cosines, points[:, 0]) + np.outer(sines, points[:, 1])
    across = np.outer(cosines, points[:, 1]) - np.outer(sines, points[:, 0])
    return (np.ptp(along, axis=1) * np.ptp(across, axis=1)).argmin()
