"""Questions about the behaviour of a student's own function; this package contains no answers.

``lesson_NN`` contains the small cases of a lesson. ``ask`` asks two questions in a notebook, and
the grader asks more kinds of questions for an oral exam. The right choices come from running the
student's function.
"""
