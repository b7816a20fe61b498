# Answers to filter_clusters; see grader/course/kept_answers.py.

# %% right: counts for each point
def filter_clusters(cluster_labels, min_num_points=100):
    _, which, count = np.unique(cluster_labels, return_inverse=True, return_counts=True)
    return np.where(count[which] >= min_num_points, cluster_labels, 0)

# %% right: a loop over the labels and a copy
def filter_clusters(cluster_labels, min_num_points=100):
    filtered = cluster_labels.copy()
    for label in np.unique(cluster_labels):
        if (cluster_labels == label).sum() < min_num_points:
            filtered[cluster_labels == label] = 0
    return filtered

# %% right: bincount
def filter_clusters(cluster_labels, min_num_points=100):
    labels = np.asarray(cluster_labels)
    if labels.size == 0:
        return labels.copy()
    enough = np.bincount(labels) >= min_num_points
    return labels * enough[labels]

# %% right: a Counter, a list back
from collections import Counter

def filter_clusters(cluster_labels, min_num_points=100):
    count = Counter(int(label) for label in cluster_labels)
    print(count.most_common(3))
    return [int(label) if count[int(label)] >= min_num_points else 0 for label in cluster_labels]

# %% right: sorting, labels as floats
def filter_clusters(cluster_labels, min_num_points=100):
    ordered = np.sort(cluster_labels)
    first = np.searchsorted(ordered, cluster_labels, side="left")
    last = np.searchsorted(ordered, cluster_labels, side="right")
    result = cluster_labels.astype(np.float32)
    result[last - first < min_num_points] = 0.0
    return result

# %% right: np.isin, with a helper in a cell of its own
import warnings

def too_small(labels, minimum):
    found, count = np.unique(labels, return_counts=True)
    return found[count < minimum]
# ---- another cell ----
%matplotlib inline
def filter_clusters(cluster_labels, min_num_points=100):
    warnings.warn("nearly there")
    filtered = np.array(cluster_labels, dtype=np.int32)
    filtered[np.isin(filtered, too_small(filtered, min_num_points))] = 0
    return filtered

# %% wrong: labels of eight bits
# loses only: test_labels
# says: What stays keeps its label
def filter_clusters(cluster_labels, min_num_points=100):
    names, which, counts = np.unique(cluster_labels, return_inverse=True, return_counts=True)
    return np.where(counts[which] < min_num_points, 0, cluster_labels).astype(np.uint8)

# %% wrong: its own input where nothing changes
# loses only: returns_a_new_array
# says: whoever changes one changes both
def filter_clusters(cluster_labels, min_num_points=100):
    names, which, counts = np.unique(cluster_labels, return_inverse=True, return_counts=True)
    small = (counts[which] < min_num_points) & (cluster_labels != 0)
    if not small.any():
        return cluster_labels
    labels = cluster_labels.copy()
    labels[small] = 0
    return labels

# %% wrong: labels move up while the loop walks along them
# loses: removes_small_clusters, removes_neighbours, test_swarms
# says: should be gone
# told: labels move up
def filter_clusters(cluster_labels, min_num_points=100):
    labels = cluster_labels.copy()
    for label in range(1, labels.max(initial=0) + 1):
        if np.sum(labels == label) < min_num_points:
            labels[labels == label] = 0
            labels[labels > label] -= 1
    return labels

# %% wrong: renumbers what is left
# loses only: keeps_the_labels, test_labels
# says: What stays keeps its label
# told: numbered anew
def filter_clusters(cluster_labels, min_num_points=100):
    filtered = np.zeros_like(cluster_labels)
    number = 0
    for label in np.unique(cluster_labels[cluster_labels > 0]):
        if np.sum(cluster_labels == label) >= min_num_points:
            number += 1
            filtered[cluster_labels == label] = number
    return filtered

# %% wrong: changes the labels in place
# loses only: leaves_its_input, returns_a_new_array, test_input
# says: changed its input
def filter_clusters(cluster_labels, min_num_points=100):
    for label in np.unique(cluster_labels):
        if np.sum(cluster_labels == label) < min_num_points:
            cluster_labels[cluster_labels == label] = 0
    return cluster_labels

# %% wrong: at most instead of fewer than
# loses only: keeps_the_tie, test_ties
# says: fewer than
# told: `<=` stands
def filter_clusters(cluster_labels, min_num_points=100):
    _, which, count = np.unique(cluster_labels, return_inverse=True, return_counts=True)
    return np.where(count[which] <= min_num_points, 0, cluster_labels)

# %% wrong: compares the label with the minimum
# loses: removes_small_clusters, removes_neighbours, test_swarms
# says: should be
# told: The labels are compared
def filter_clusters(cluster_labels, min_num_points=100):
    return np.where(cluster_labels < min_num_points, 0, cluster_labels)

# %% wrong: deletes the points of small clusters
# loses: removes_small_clusters, test_course_cloud, test_order
# says: one label for each
# told: are deleted
def filter_clusters(cluster_labels, min_num_points=100):
    _, which, count = np.unique(cluster_labels, return_inverse=True, return_counts=True)
    return cluster_labels[count[which] >= min_num_points]

# %% wrong: the minimum is written into the function
# loses: removes_small_clusters, follows_the_minimum, test_swarms
# says: Compare with min_num_points
# told: A fixed minimum
def filter_clusters(cluster_labels, min_num_points=100):
    _, which, count = np.unique(cluster_labels, return_inverse=True, return_counts=True)
    return np.where(count[which] < 100, 0, cluster_labels)

# %% wrong: parameters renamed
# loses only: keeps_the_names
# says: another name
def filter_clusters(labels, minimum=100):
    _, which, count = np.unique(labels, return_inverse=True, return_counts=True)
    return np.where(count[which] < minimum, 0, labels)

# %% wrong: default changed
# loses only: keeps_the_default
# says: Without a minimum other clusters stay
def filter_clusters(cluster_labels, min_num_points=10):
    _, which, count = np.unique(cluster_labels, return_inverse=True, return_counts=True)
    return np.where(count[which] < min_num_points, 0, cluster_labels)

# %% wrong: -1 for noise
# loses only: writes_zeros
# says: not a negative one
# told: -1 is written
def filter_clusters(cluster_labels, min_num_points=100):
    _, which, count = np.unique(cluster_labels, return_inverse=True, return_counts=True)
    return np.where(count[which] < min_num_points, -1, cluster_labels)

# %% wrong: keeps the small ones
# loses: removes_small_clusters, test_course_cloud
# says: should be
# told: the large clusters that go
def filter_clusters(cluster_labels, min_num_points=100):
    _, which, count = np.unique(cluster_labels, return_inverse=True, return_counts=True)
    return np.where(count[which] < min_num_points, cluster_labels, 0)

# %% wrong: counts on labels without gaps
# loses: allows_gaps
# says: 7 may be there without 6
def filter_clusters(cluster_labels, min_num_points=100):
    filtered = cluster_labels.copy()
    found, counts = np.unique(cluster_labels[cluster_labels > 0], return_counts=True)
    for position, count in enumerate(counts):
        if count < min_num_points:
            filtered[cluster_labels == position + 1] = 0
    return filtered

# %% wrong: returns the labels that stay
# loses: removes_small_clusters, test_swarms
# says: one label for each
# told: names of the labels
def filter_clusters(cluster_labels, min_num_points=100):
    found, counts = np.unique(cluster_labels[cluster_labels > 0], return_counts=True)
    return found[counts >= min_num_points]

# %% wrong: forgets to return
# loses: removes_small_clusters, takes_the_smallest, test_swarms
# says: returned None
def filter_clusters(cluster_labels, min_num_points=100):
    filtered = cluster_labels.copy()
    for label in np.unique(cluster_labels):
        if np.sum(cluster_labels == label) < min_num_points:
            filtered[cluster_labels == label] = 0

# %% wrong: noise becomes a cluster
# loses: leaves_noise_alone, test_swarms
# says: belong to no cluster
def filter_clusters(cluster_labels, min_num_points=100):
    labels = cluster_labels + 1
    _, which, count = np.unique(labels, return_inverse=True, return_counts=True)
    return np.where(count[which] < min_num_points, 0, labels)

# %% wrong: returns the labels as they are
# loses: removes_small_clusters, removes_neighbours, test_course_cloud, test_swarms
# says: should be gone
# told: Nothing is removed
def filter_clusters(cluster_labels, min_num_points=100):
    return cluster_labels

# %% wrong: all noise
# loses: removes_small_clusters, removes_neighbours, test_course_cloud, test_swarms
# says: should be left
def filter_clusters(cluster_labels, min_num_points=100):
    return np.zeros_like(cluster_labels)

# %% wrong: max of nothing
# loses only: takes_the_smallest
# says: can be empty
def filter_clusters(cluster_labels, min_num_points=100):
    filtered = cluster_labels.copy()
    for label in range(1, np.max(cluster_labels) + 1):
        if np.sum(cluster_labels == label) < min_num_points:
            filtered[cluster_labels == label] = 0
    return filtered

# %% wrong: closes the gap in the loop, and stumbles over no labels
# loses only: removes_small_clusters, keeps_the_labels, removes_neighbours, follows_the_minimum, takes_the_smallest, test_course_cloud, test_swarms, test_labels, test_order, test_extremes, test_kinds_of_numbers
# says: should be gone
# told: labels move up
def filter_clusters(cluster_labels, min_num_points=100):
    labels = cluster_labels.copy()
    for number in range(1, labels.max() + 1):
        how_many = np.sum(labels == number)
        if 0 < how_many < min_num_points:
            labels[labels == number] = 0
            labels[labels > number] -= 1
    return labels

# %% wrong: the last label is left out
# loses only: removes_small_clusters, follows_the_minimum, allows_gaps, takes_the_smallest, test_course_cloud, test_swarms, test_extremes, test_kinds_of_numbers
# says: ends before n
# told: The last label is left out
def filter_clusters(cluster_labels, min_num_points=100):
    labels = cluster_labels.copy()
    for label in range(1, cluster_labels.max()):
        if np.sum(cluster_labels == label) < min_num_points:
            labels[cluster_labels == label] = 0
    return labels

# %% wrong: the place in the table is taken for the label
# loses: removes_small_clusters, removes_neighbours, allows_gaps, test_course_cloud
# says: should be left
# told: place in the table
def filter_clusters(cluster_labels, min_num_points=100):
    labels = cluster_labels.copy()
    _, how_many = np.unique(cluster_labels, return_counts=True)
    for label, count in enumerate(how_many):
        if count < min_num_points:
            labels[cluster_labels == label] = 0
    return labels
