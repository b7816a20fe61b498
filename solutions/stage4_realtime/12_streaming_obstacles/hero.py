"""The film at the top of the README: a drive through the city, with the detected obstacles.

Run this file, or `make pictures`, to record the film again.
"""

from grader.course.lessons import find_lesson, load_reference
from utils import scenes
from utils.films import DetectedFrame, Film
from utils.films.film import record
from utils.scene3d import Scene

LESSON = "12_streaming_obstacles"
PATH = find_lesson(LESSON).folder / "hero.gif"
FRAMES, EVERY = 64, 2  # recorded at 10 Hz; every second frame makes a smaller film


def film() -> Film:
    """Record the film and return it."""
    return record(
        scenes.city_block(frames=FRAMES)[::EVERY],
        PATH,
        load_reference(LESSON).detect_obstacles,
        compose=compose,
        size=(800, 420),
    )


def compose(frame: DetectedFrame) -> Scene:
    """Compose a scene of the cloud and the boxes, without timing, so that it is reproducible."""
    return (
        Scene()
        .add_cloud(frame.cloud)
        .add_oriented_boxes(frame.boxes, name="obstacles found")
        .add_ego_car()
    )


if __name__ == "__main__":
    print(f"recorded {film().path.name}")
