"""Scores for boxes and tracks: overlap, hits, track IDs, and a score card with standard errors."""

from utils.boxes import plane_iou, space_iou
from utils.scoring.card import (
    OVERLAPS,
    ScoreCard,
    counted,
    hidden_shares,
    score_card,
    with_error,
    within,
)
from utils.scoring.counting import (
    NameMistakes,
    Score,
    TrackedFrame,
    holders,
    match,
    name_mistakes,
    score_boxes,
    score_stream,
)

__all__ = [
    "OVERLAPS",
    "ScoreCard",
    "NameMistakes",
    "Score",
    "TrackedFrame",
    "counted",
    "hidden_shares",
    "holders",
    "match",
    "name_mistakes",
    "plane_iou",
    "score_boxes",
    "score_card",
    "score_stream",
    "space_iou",
    "with_error",
    "within",
]
