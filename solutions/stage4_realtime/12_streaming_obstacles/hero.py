"""The film at the head of the README: a drive through the city, and the obstacles found.

Run it to record the film again, as `make pictures` does.
"""

from grader.course.lessons import find_lesson, load_reference
from utils import scenes
from utils.films import Film, Sight
from utils.films.film import record
from utils.scene3d import Scene

LESSON = "12_streaming_obstacles"
PATH = find_lesson(LESSON).folder / "hero.gif"
FRAMES, EVERY = 64, 2  # at 10 Hz; every second one makes a smaller film of a quicker drive


def film() -> Film:
    """Record the film; returns `utils.films.writers.Film`."""
    return record(
        scenes.city_block(frames=FRAMES)[::EVERY],
        PATH,
        load_reference(LESSON).detect_obstacles,
        compose=compose,
        size=(800, 420),
    )


def compose(sight: Sight) -> Scene:
    """Only what the detector saw: no timing, so that the same film is the same file."""
    return (
        Scene()
        .add_cloud(sight.cloud)
        .add_oriented_boxes(sight.found, name="obstacles found")
        .add_ego_car()
    )


if __name__ == "__main__":
    print(f"recorded {film().path.name}")
