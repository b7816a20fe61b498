# Answers to coast, which nothing grades; see grader/course/kept_answers.py.

# %% right: the hints followed to the letter
def coast(missed, partners, patience):
    seen = np.isin(np.arange(len(missed)), partners)
    missed = np.where(seen, 0, missed + 1)
    return missed, missed <= patience

# %% right: only the rows that there are
def coast(missed, partners, patience):
    counted = missed + 1
    counted[partners[partners >= 0]] = 0
    return counted, counted <= patience

# %% right: plain Python, lists back
def coast(missed, partners, patience):
    counted = []
    for row in range(len(missed)):
        counted.append(0 if row in list(partners) else int(missed[row]) + 1)
    return counted, [not count > patience for count in counted]

# %% right: one more, times whether it is alone
def coast(missed, partners, patience):
    alone = np.ones(len(missed), dtype=int)
    for partner in partners:
        if partner != -1:
            alone[partner] = 0
    return (missed + 1) * alone, (missed + 1) * alone < patience + 1

# %% right: places instead of a mask, turned into one
def coast(missed, partners, patience):
    having = set(int(one) for one in partners) - {-1}
    counted = np.array([(count + 1) * (row not in having) for row, count in enumerate(missed)])
    return counted, np.array([count <= patience for count in counted], dtype=bool)

# %% wrong: -1 reaches the last track
# loses only: counts_what_is_missed, waits_for_patience
# says: and its count is wrong
# told: The last track counts as seen
def coast(missed, partners, patience):
    missed = missed + 1
    if len(missed):
        missed[partners] = 0
    return missed, missed <= patience

# %% wrong: one frame too early
# loses only: waits_for_patience
# says: should be kept
# told: one frame too early
def coast(missed, partners, patience):
    seen = np.isin(np.arange(len(missed)), partners)
    missed = np.where(seen, 0, missed + 1)
    return missed, missed < patience

# %% wrong: compares the old counts
# loses only: waits_for_patience
# says: should be dropped
# told: The old counts are compared
def coast(missed, partners, patience):
    seen = np.isin(np.arange(len(missed)), partners)
    return np.where(seen, 0, missed + 1), (missed <= patience) | seen

# %% wrong: never starts again
# loses only: counts_what_is_missed, waits_for_patience
# says: and its count is wrong
# told: never starts again
def coast(missed, partners, patience):
    seen = np.isin(np.arange(len(missed)), partners)
    missed = missed + ~seen
    return missed, missed <= patience

# %% wrong: everybody counts on
# loses only: counts_what_is_missed, waits_for_patience
# says: has a box, and its count is wrong
# told: Every track counts one more
def coast(missed, partners, patience):
    return missed + 1, missed + 1 <= patience

# %% wrong: has no memory
# loses only: counts_what_is_missed, waits_for_patience, takes_empty_frames
# says: has no box, and its count is wrong
# told: starts again at 1
def coast(missed, partners, patience):
    missed = (~np.isin(np.arange(len(missed)), partners)).astype(int)
    return missed, missed <= patience

# %% wrong: the seen and the others exchanged
# loses: counts_what_is_missed
# says: and its count is wrong
# told: are exchanged
def coast(missed, partners, patience):
    seen = np.isin(np.arange(len(missed)), partners)
    missed = np.where(seen, missed + 1, 0)
    return missed, missed <= patience

# %% wrong: keeps only what is seen
# loses only: waits_for_patience, takes_empty_frames
# says: should be kept
# told: nothing coasts
def coast(missed, partners, patience):
    seen = np.isin(np.arange(len(missed)), partners)
    return np.where(seen, 0, missed + 1), seen

# %% wrong: says who is dropped
# loses only: waits_for_patience, takes_empty_frames
# says: should be
# told: who is dropped
def coast(missed, partners, patience):
    seen = np.isin(np.arange(len(missed)), partners)
    missed = np.where(seen, 0, missed + 1)
    return missed, missed > patience

# %% wrong: the rows of those that are kept
# loses: waits_for_patience
# says: one entry of kept for each
def coast(missed, partners, patience):
    seen = np.isin(np.arange(len(missed)), partners)
    missed = np.where(seen, 0, missed + 1)
    return missed, np.flatnonzero(missed <= patience)

# %% wrong: one entry for each box
# loses: counts_what_is_missed
# says: one entry of missed for each
def coast(missed, partners, patience):
    missed = np.where(partners >= 0, 0, 1)
    return missed, missed <= patience

# %% wrong: writes into the counts
# loses only: leaves_the_counts
# says: changed its input
def coast(missed, partners, patience):
    seen = np.isin(np.arange(len(missed)), partners)
    missed += 1
    missed[seen] = 0
    return missed, missed <= patience

# %% wrong: who is kept before the counts
# says: The two answers are exchanged
def coast(missed, partners, patience):
    seen = np.isin(np.arange(len(missed)), partners)
    missed = np.where(seen, 0, missed + 1)
    return missed <= patience, missed

# %% wrong: a mask over the boxes, where one over the tracks is needed
# says: boolean index did not match
def coast(missed, partners, patience):
    missed = missed + 1
    missed[partners >= 0] = 0
    return missed, missed <= patience
