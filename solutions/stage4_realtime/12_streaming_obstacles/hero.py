"""The film at the top of the README: a drive through the city with the obstacles found.

Run this to record the film again, as `make pictures` does.
"""

from grader.course.lessons import find_lesson, load_reference
from utils import scenes
from utils.films import DetectedFrame, Film
from utils.films.film import record
from utils.scene3d import Scene

LESSON = "12_streaming_obstacles"
PATH = find_lesson(LESSON).folder / "hero.gif"
FRAMES, EVERY = 64, 2  # at 10 Hz; using every second frame makes a smaller and faster film


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
    """Show only the cloud and the boxes, without timing, so that the file is reproducible."""
    return (
        Scene()
        .add_cloud(frame.cloud)
        .add_oriented_boxes(frame.found, name="obstacles found")
        .add_ego_car()
    )


if __name__ == "__main__":
    print(f"recorded {film().path.name}")
