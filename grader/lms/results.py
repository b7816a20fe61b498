"""The results of a class, as the gradebook holds them: what exporters are given."""

from dataclasses import dataclass


@dataclass(frozen=True)
class NotebookResult:
    """What one notebook earned, by machine and by hand.

    Attributes
    ----------
    student, stage, lesson : str
    score, max_score : float
    waiting : bool
        True while a person has still to grade something in it.
    """

    student: str
    stage: str
    lesson: str
    score: float
    max_score: float
    waiting: bool


@dataclass(frozen=True)
class ClassResults:
    """Everything that was entered, in order of student and lesson.

    Attributes
    ----------
    notebooks : tuple of NotebookResult
    penalties : dict of (str, str) to float
        Points that nbgrader takes off for lateness, by student and stage; only where it does.
    """

    notebooks: tuple[NotebookResult, ...]
    penalties: dict[tuple[str, str], float]
