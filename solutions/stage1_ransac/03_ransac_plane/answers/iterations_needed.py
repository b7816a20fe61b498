# Answers to iterations_needed; see grader/course/kept_answers.py.

# %% right: the hints followed to the letter
import math

def iterations_needed(inlier_ratio, sample_size, confidence):
    good = inlier_ratio ** sample_size
    if good == 1:
        return 1
    if good == 0:
        return math.inf
    return max(1, math.ceil(math.log(1 - confidence) / math.log1p(-good)))

# %% right: the formula, with both ends
import math

def iterations_needed(inlier_ratio, sample_size, confidence):
    good = inlier_ratio ** sample_size
    if good == 0:
        return math.inf
    if good == 1:
        return 1
    return math.ceil(math.log(1 - confidence) / math.log(1 - good))

# %% right: NumPy, a float back
def iterations_needed(inlier_ratio, sample_size, confidence):
    with np.errstate(divide="ignore"):
        n = np.ceil(np.log(1 - confidence) / np.log1p(-np.float64(inlier_ratio) ** sample_size))
    return max(n, 1.0) if inlier_ratio > 0 else np.inf

# %% right: refuses to search without inliers
import math

def iterations_needed(inlier_ratio, sample_size, confidence):
    print("how many?")
    if inlier_ratio <= 0:
        raise ValueError("there is nothing to find")
    if inlier_ratio >= 1:
        return 1
    return int(np.ceil(math.log10(1 - confidence) / math.log10(1 - inlier_ratio ** sample_size)))

# %% right: powers tried by halving
def misses(chance, n):
    return (1 - chance) ** n
# ---- another cell ----
def iterations_needed(inlier_ratio, sample_size, confidence):
    chance = inlier_ratio ** sample_size
    if chance <= 0:
        return None
    high = 1
    while 1 - misses(chance, high) < confidence:
        high *= 2
    low = high // 2
    while high - low > 1:
        middle = (low + high) // 2
        if 1 - misses(chance, middle) < confidence:
            low = middle
        else:
            high = middle
    return high

# %% right: a very large number for never
import warnings
from sys import maxsize

def iterations_needed(inlier_ratio, sample_size, confidence):
    warnings.warn("counting")
    if inlier_ratio == 0:
        return maxsize
    if inlier_ratio == 1:
        return np.int64(1)
    return np.int64(np.ceil(np.log(1 - confidence) / np.log(1 - inlier_ratio ** sample_size)))

# %% wrong: rounded down
# loses only: smallest_that_suffices, test_rounding
# says: round up, not down
# told: It is rounded down
import math

def iterations_needed(inlier_ratio, sample_size, confidence):
    good = inlier_ratio ** sample_size
    if good == 0:
        return math.inf
    if good == 1:
        return 1
    return max(1, int(math.log(1 - confidence) / math.log(1 - good)))

# %% wrong: not rounded
# loses only: smallest_that_suffices, test_rounding
# says: Half a round cannot be played
import math

def iterations_needed(inlier_ratio, sample_size, confidence):
    good = inlier_ratio ** sample_size
    if good == 0:
        return math.inf
    if good == 1:
        return 1
    return math.log(1 - confidence) / math.log(1 - good)

# %% wrong: the ends are forgotten
# loses only: one_is_enough, none_is_enough
# says: no negative number has one
import math

def iterations_needed(inlier_ratio, sample_size, confidence):
    return math.ceil(math.log(1 - confidence) / math.log(1 - inlier_ratio ** sample_size))

# %% wrong: zero iterations without inliers
# loses only: none_is_enough
# says: no number of samples is enough
import math

def iterations_needed(inlier_ratio, sample_size, confidence):
    good = inlier_ratio ** sample_size
    if good == 0:
        return 0
    if good == 1:
        return 1
    return math.ceil(math.log(1 - confidence) / math.log(1 - good))

# %% wrong: the exponent is missing
# loses: reckons_the_number, smallest_that_suffices, follows_the_sample_size, test_iterations
# says: not the number of samples
# told: The exponent is missing
import math

def iterations_needed(inlier_ratio, sample_size, confidence):
    if inlier_ratio == 0:
        return math.inf
    if inlier_ratio == 1:
        return 1
    return math.ceil(math.log(1 - confidence) / math.log(1 - inlier_ratio))

# %% wrong: the product for the power, where a product may be above 1
# loses: reckons_the_number, follows_the_sample_size, test_iterations
# says: not the number of samples
# told: w is multiplied by s
import math

def iterations_needed(inlier_ratio, sample_size, confidence):
    if inlier_ratio == 0:
        return math.inf
    good_sample = inlier_ratio * sample_size
    if good_sample >= 1:
        return 1
    return math.ceil(math.log(1 - confidence) / math.log(1 - good_sample))

# %% wrong: the product for the power
# loses: reckons_the_number, follows_the_sample_size, test_iterations
# says: w**s is a power, w*s a product
import math

def iterations_needed(inlier_ratio, sample_size, confidence):
    if inlier_ratio == 0:
        return math.inf
    if inlier_ratio == 1:
        return 1
    return math.ceil(math.log(1 - confidence) / math.log(1 - inlier_ratio * sample_size))

# %% wrong: always a plane
# loses only: follows_the_sample_size, test_sizes
# says: not the number of samples
# told: The exponent is always 3
import math

def iterations_needed(inlier_ratio, sample_size, confidence):
    good = inlier_ratio ** 3
    if good == 0:
        return math.inf
    if good == 1:
        return 1
    return math.ceil(math.log(1 - confidence) / math.log(1 - good))

# %% wrong: log of the confidence
# loses: reckons_the_number, smallest_that_suffices, test_iterations
# says: not the number of samples
# told: that of the confidence
import math

def iterations_needed(inlier_ratio, sample_size, confidence):
    good = inlier_ratio ** sample_size
    if good == 0:
        return math.inf
    if good == 1:
        return 1
    return math.ceil(math.log(confidence) / math.log(1 - good))

# %% wrong: inliers and outliers swapped
# loses: reckons_the_number, one_is_enough, test_iterations
# says: not the number of samples
# told: are swapped
import math

def iterations_needed(inlier_ratio, sample_size, confidence):
    good = (1 - inlier_ratio) ** sample_size
    if good == 0:
        return 1
    if good == 1:
        return math.inf
    return math.ceil(math.log(1 - confidence) / math.log(1 - good))

# %% wrong: the expected number of samples
# loses: reckons_the_number, smallest_that_suffices, test_iterations
# says: not the number of samples
# told: on average
import math

def iterations_needed(inlier_ratio, sample_size, confidence):
    if inlier_ratio == 0:
        return math.inf
    return math.ceil(1 / inlier_ratio ** sample_size)

# %% wrong: parameters renamed
# loses only: keeps_the_names_of_the_parameters
# says: another name
import math

def iterations_needed(w, s, p):
    good = w ** s
    if good == 0:
        return math.inf
    if good == 1:
        return 1
    return math.ceil(math.log(1 - p) / math.log(1 - good))

# %% wrong: a hundred for everybody
# loses: reckons_the_number, smallest_that_suffices, one_is_enough, none_is_enough, test_iterations
# says: not the number of samples
def iterations_needed(inlier_ratio, sample_size, confidence):
    return 100

# %% wrong: rounded to the nearest
# loses only: smallest_that_suffices, test_rounding
# says: round up, not down
import math

def iterations_needed(inlier_ratio, sample_size, confidence):
    good = inlier_ratio ** sample_size
    if good == 0:
        return math.inf
    if good == 1:
        return 1
    return max(1, round(math.log(1 - confidence) / math.log(1 - good)))

# %% wrong: one more to be sure
# loses only: smallest_that_suffices, test_rounding
# says: One sample fewer would be enough
import math

def iterations_needed(inlier_ratio, sample_size, confidence):
    good = inlier_ratio ** sample_size
    if good == 0:
        return math.inf
    if good == 1:
        return 1
    return math.ceil(math.log(1 - confidence) / math.log(1 - good)) + 1

# %% wrong: always a line
# loses: reckons_the_number, test_iterations
# says: not the number of samples
# told: The exponent is always 2
import math

def iterations_needed(inlier_ratio, sample_size, confidence):
    good = inlier_ratio ** 2
    if good == 0:
        return math.inf
    if good == 1:
        return 1
    return math.ceil(math.log(1 - confidence) / math.log(1 - good))

# %% wrong: always 99 per cent
# loses only: follows_the_confidence, test_iterations, test_sizes, test_rounding
# says: not the number of samples
import math

def iterations_needed(inlier_ratio, sample_size, confidence):
    good = inlier_ratio ** sample_size
    if good == 0:
        return math.inf
    if good == 1:
        return 1
    return math.ceil(math.log(0.01) / math.log(1 - good))

# %% wrong: infinity at both ends
# loses only: one_is_enough
# says: there must be one
import math

def iterations_needed(inlier_ratio, sample_size, confidence):
    good = inlier_ratio ** sample_size
    if good in (0, 1):
        return math.inf
    return math.ceil(math.log(1 - confidence) / math.log(1 - good))
