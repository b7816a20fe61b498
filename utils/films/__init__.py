"""Films of a stream of frames with the boxes of a detector, as MP4 or GIF.

>>> from utils import load_sequence, films
>>> film = films.record(load_sequence("city"), "city.mp4", detect_obstacles, camera="XY")
>>> film                    # a notebook shows the film and describes it in words
"""

from utils.films.film import SIZE, record, scene_of, watch
from utils.films.frames import DetectedFrame
from utils.films.writers import WRITERS, Film

__all__ = ["SIZE", "WRITERS", "Film", "DetectedFrame", "record", "scene_of", "watch"]
