# Answers to predict_boxes, which nothing grades; see grader/course/kept_answers.py.

# %% right: the hints followed to the letter
def predict_boxes(boxes, velocities, seconds):
    return boxes + seconds * velocities[:, None]

# %% right: box by box
def predict_boxes(boxes, velocities, seconds):
    moved = boxes.copy()
    for number in range(len(boxes)):
        moved[number] += velocities[number] * seconds
    return moved

# %% right: the ways repeated for each corner
def predict_boxes(boxes, velocities, seconds):
    return boxes + np.repeat(velocities * seconds, 8, axis=0).reshape(-1, 8, 3)

# %% right: einsum, single precision
def predict_boxes(boxes, velocities, seconds):
    ways = np.einsum("nk,c->nck", velocities, np.full(8, seconds))
    return (np.asarray(boxes) + ways).astype(np.float32)

# %% right: lists in plain Python
def predict_boxes(boxes, velocities, seconds):
    return [[[x + seconds * v for x, v in zip(corner, way)] for corner in box]
            for box, way in zip(boxes, velocities)]

# %% wrong: the axis is forgotten
# loses: moves_the_boxes, takes_the_time, moves_eight_boxes
# says: could not be broadcast
# told: Row k of velocities
def predict_boxes(boxes, velocities, seconds):
    return boxes + seconds * velocities

# %% wrong: seconds are forgotten
# loses only: moves_the_boxes, takes_the_time, moves_eight_boxes
# says: is not where its velocity takes it
# told: as if a second had gone by
def predict_boxes(boxes, velocities, seconds):
    return boxes + velocities[:, None]

# %% wrong: a tenth of a second is written into the function
# loses only: takes_the_time
# says: Multiply the velocities by seconds
# told: A fixed time decides
def predict_boxes(boxes, velocities, seconds):
    return boxes + 0.1 * velocities[:, None]

# %% wrong: backwards
# loses only: moves_the_boxes, takes_the_time, moves_eight_boxes
# says: is not where its velocity takes it
# told: The boxes move backwards
def predict_boxes(boxes, velocities, seconds):
    return boxes - seconds * velocities[:, None]

# %% wrong: divided by the time
# loses only: moves_the_boxes, takes_the_time, moves_eight_boxes
# says: is not where its velocity takes it
# told: divided by the time
def predict_boxes(boxes, velocities, seconds):
    with np.errstate(all="ignore"):
        return boxes + velocities[:, None] / seconds

# %% wrong: everything moves like the first
# loses only: moves_the_boxes, takes_the_time, moves_eight_boxes
# says: is not where its velocity takes it
# told: by the velocity of the first one
def predict_boxes(boxes, velocities, seconds):
    return boxes + seconds * velocities[:1] if len(boxes) else boxes

# %% wrong: only centres
# loses only: moves_the_boxes, takes_the_time, moves_eight_boxes
# says: move all eight corners
def predict_boxes(boxes, velocities, seconds):
    return boxes.mean(axis=1) + seconds * velocities

# %% wrong: only the first corner moves
# loses: moves_the_boxes
# says: is not where its velocity takes it
def predict_boxes(boxes, velocities, seconds):
    moved = boxes.copy()
    moved[:, 0] += seconds * velocities
    return moved

# %% wrong: writes into the boxes
# loses only: leaves_what_was
# says: changed its input
def predict_boxes(boxes, velocities, seconds):
    boxes += seconds * velocities[:, None]
    return boxes

# %% wrong: nothing moves
# loses: moves_the_boxes, takes_the_time
# says: is not where its velocity takes it
# told: The boxes stay where they are
def predict_boxes(boxes, velocities, seconds):
    return boxes.copy()
