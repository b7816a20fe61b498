"""Films: a stream of frames, seen through a detector, as MP4 or GIF.

>>> from utils import load_sequence, films
>>> film = films.record(load_sequence("city"), "city.mp4", detect_obstacles, camera="XY")
>>> film                    # in a notebook: the film, and in words what it shows
"""

from utils.films.film import SIZE, Sight, record, scene_of, watch
from utils.films.writers import WRITERS, Film

__all__ = ["SIZE", "WRITERS", "Film", "Sight", "record", "scene_of", "watch"]
