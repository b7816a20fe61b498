"""A league: who drives farthest on their own detector. Never part of a mark.

`streets` draws where, `driving` drives one street on one detector behind walls, `season` a class
through all of them. `ranking` says what counts, and `page` shows it under `pseudonyms`.
"""
