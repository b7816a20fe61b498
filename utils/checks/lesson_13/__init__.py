"""Visible checks of lesson 13, which is optional: its functions give no points.

Each is asked as plain Python, whether Numba is there or not; where it is, a note says what the
compiler makes of it.
"""

# In the order of the lesson.
from utils.checks.lesson_13 import count_near

# isort: split
from utils.checks.lesson_13 import union_find

# isort: split
from utils.checks.lesson_13 import any_close

# isort: split
from utils.checks.lesson_13 import snuggest_turn

__all__ = ["any_close", "count_near", "snuggest_turn", "union_find"]
