"""Questions about what a student's own code does, for a conversation and not for a mark.

The idea is from Lehtinen, Seppälä and Korhonen ("Automated questions about learners' own code help
to detect fragile prerequisite knowledge", ITiCSE 2023). Their questions are about syntax. Here, the
right answer and the wrong ones come from running the student's function and its one-edit changes on
the lesson's small cases.

``answer`` reads a student's function and runs its versions in the sandbox; `kinds` contains one
module for each kind of question; ``verification`` computes each right answer again; ``viva`` makes
the questions of a class, and ``pages`` and ``quizzes`` write them.
"""
