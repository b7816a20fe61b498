"""Visible checks of lesson 13, which is optional: its functions give no points.

Each function is checked as plain Python, with or without Numba. If Numba is installed, a note
appears when the function does not compile.
"""

# Import in the order of the lesson, because exercises are listed in the order of import.
from utils.checks.lesson_13 import count_near

# isort: split
from utils.checks.lesson_13 import union_find

# isort: split
from utils.checks.lesson_13 import any_close

# isort: split
from utils.checks.lesson_13 import snuggest_turn

__all__ = ["any_close", "count_near", "snuggest_turn", "union_find"]
