# Answers to correct_boxes, which nothing grades; see grader/course/kept_answers.py.

# %% right: the hints followed to the letter
def correct_boxes(expected, velocities, found, gain, seconds):
    off = found.mean(axis=1) - expected.mean(axis=1)
    beta = 2 * (1 - np.sqrt(1 - gain)) ** 2
    return found - (1 - gain) * off[:, None], velocities + beta * off / seconds

# %% right: the other way to write the second gain
def correct_boxes(expected, velocities, found, gain, seconds):
    off = (found - found.mean(axis=1, keepdims=True), found.mean(axis=1) - expected.mean(axis=1))
    shape, off = off
    centres = expected.mean(axis=1) + gain * off
    beta = 2 * (2 - gain) - 4 * (1 - gain) ** 0.5
    return shape + centres[:, None], velocities + off * (beta / seconds)

# %% right: box by box, lists back
def correct_boxes(expected, velocities, found, gain, seconds):
    boxes, speeds = [], []
    for was, speed, box in zip(expected, velocities, found):
        off = np.mean(box, axis=0) - np.mean(was, axis=0)
        boxes.append(box - off + gain * off)
        speeds.append(speed + 2 * (1 - (1 - gain) ** 0.5) ** 2 * off / seconds)
    return [boxes, speeds]

# %% right: the middle between the extremes
def correct_boxes(expected, velocities, found, gain, seconds):
    middle = lambda boxes: (boxes.min(axis=1) + boxes.max(axis=1)) / 2
    off = middle(found) - middle(expected)
    r = np.sqrt(1 - gain)
    return (found - r**2 * off[:, np.newaxis]).astype(np.float32), velocities + 2 * (1 - r)**2 * off / seconds

# %% wrong: metres added to metres per second
# loses only: learns_the_velocity
# says: has another velocity
# told: is not divided by the time
def correct_boxes(expected, velocities, found, gain, seconds):
    off = found.mean(axis=1) - expected.mean(axis=1)
    return found - (1 - gain) * off[:, None], velocities + 2 * (1 - np.sqrt(1 - gain)) ** 2 * off

# %% wrong: one gain for both
# loses only: learns_the_velocity
# says: has another velocity
# told: The first gain corrects the velocity, too
def correct_boxes(expected, velocities, found, gain, seconds):
    off = found.mean(axis=1) - expected.mean(axis=1)
    return found - (1 - gain) * off[:, None], velocities + gain * off / seconds

# %% wrong: off the wrong way round for the velocity
# loses only: learns_the_velocity
# says: has another velocity
# told: the wrong way round
def correct_boxes(expected, velocities, found, gain, seconds):
    off = expected.mean(axis=1) - found.mean(axis=1)
    beta = 2 * (1 - np.sqrt(1 - gain)) ** 2
    return found + (1 - gain) * off[:, None], velocities + beta * off / seconds

# %% wrong: the old velocity is forgotten
# loses only: learns_the_velocity, has_two_ends
# says: has another velocity
# told: The old velocity is forgotten
def correct_boxes(expected, velocities, found, gain, seconds):
    off = found.mean(axis=1) - expected.mean(axis=1)
    return found - (1 - gain) * off[:, None], 2 * (1 - np.sqrt(1 - gain)) ** 2 * off / seconds

# %% wrong: velocities as they were
# loses only: learns_the_velocity
# says: has another velocity
# told: come back as they went in
def correct_boxes(expected, velocities, found, gain, seconds):
    off = found.mean(axis=1) - expected.mean(axis=1)
    return found - (1 - gain) * off[:, None], velocities

# %% wrong: gain for the expectation
# loses only: lies_between, has_two_ends, keeps_the_shape
# says: is not the gain's share
# told: The gain is the share of the expectation
def correct_boxes(expected, velocities, found, gain, seconds):
    off = found.mean(axis=1) - expected.mean(axis=1)
    return found - gain * off[:, None], velocities + 2 * (1 - np.sqrt(1 - gain)) ** 2 * off / seconds

# %% wrong: boxes as they were found
# loses only: lies_between, has_two_ends, keeps_the_shape
# says: is not the gain's share
# told: The boxes are taken as they were found
def correct_boxes(expected, velocities, found, gain, seconds):
    off = found.mean(axis=1) - expected.mean(axis=1)
    return found.copy(), velocities + 2 * (1 - np.sqrt(1 - gain)) ** 2 * off / seconds

# %% wrong: mixed corner by corner
# loses only: keeps_the_shape
# says: has other corners than the box that was found
# told: mixed corner by corner
def correct_boxes(expected, velocities, found, gain, seconds):
    off = found.mean(axis=1) - expected.mean(axis=1)
    boxes = expected + gain * (found - expected)
    return boxes, velocities + 2 * (1 - np.sqrt(1 - gain)) ** 2 * off / seconds

# %% wrong: the expected box is moved
# loses only: keeps_the_shape
# says: has other corners than the box that was found
def correct_boxes(expected, velocities, found, gain, seconds):
    off = found.mean(axis=1) - expected.mean(axis=1)
    boxes = expected + gain * off[:, None]
    return boxes, velocities + 2 * (1 - np.sqrt(1 - gain)) ** 2 * off / seconds

# %% wrong: only the boxes come back
# loses: lies_between, learns_the_velocity
# says: returns two things
def correct_boxes(expected, velocities, found, gain, seconds):
    off = found.mean(axis=1) - expected.mean(axis=1)
    return found - (1 - gain) * off[:, None]

# %% wrong: only centres come back
# loses: lies_between
# says: move all eight corners
def correct_boxes(expected, velocities, found, gain, seconds):
    off = found.mean(axis=1) - expected.mean(axis=1)
    centres = expected.mean(axis=1) + gain * off
    return centres, velocities + 2 * (1 - np.sqrt(1 - gain)) ** 2 * off / seconds

# %% wrong: writes into the velocities
# loses only: leaves_what_was_given
# says: changed its input
def correct_boxes(expected, velocities, found, gain, seconds):
    off = found.mean(axis=1) - expected.mean(axis=1)
    velocities += 2 * (1 - np.sqrt(1 - gain)) ** 2 * off / seconds
    return found - (1 - gain) * off[:, None], velocities

# %% wrong: writes into the boxes that were found
# loses only: leaves_what_was_given
# says: found - ... makes new boxes
def correct_boxes(expected, velocities, found, gain, seconds):
    off = found.mean(axis=1) - expected.mean(axis=1)
    found -= (1 - gain) * off[:, None]
    return found, velocities + 2 * (1 - np.sqrt(1 - gain)) ** 2 * off / seconds

# %% wrong: the heights stay
# loses only: lies_between, has_two_ends, keeps_the_shape
# says: not the gain's share
def correct_boxes(expected, velocities, found, gain, seconds):
    off = found.mean(axis=1) - expected.mean(axis=1)
    moved = found.copy()
    moved[:, :, :2] -= (1 - gain) * off[:, None, :2]
    return moved, velocities + 2 * (1 - np.sqrt(1 - gain)) ** 2 * off / seconds

# %% wrong: velocities before boxes
# says: The two answers are exchanged
def correct_boxes(expected, velocities, found, gain, seconds):
    off = found.mean(axis=1) - expected.mean(axis=1)
    beta = 2 * (1 - np.sqrt(1 - gain)) ** 2
    return velocities + beta * off / seconds, found - (1 - gain) * off[:, None]
