"""The film at the head of the README: a drive through the city, and the obstacles found."""

from grader.lessons import load_reference
from grader.paths import PROJECT
from utils import scenes
from utils.recording import record
from utils.scene3d import Scene

PATH = PROJECT / "solutions" / "pictures" / "hero.gif"
FRAMES, EVERY = 64, 2  # at 10 Hz; every second one makes a smaller film of a quicker drive


def film():
    """Record the film; returns `utils.scene3d.films.Film`."""
    PATH.parent.mkdir(exist_ok=True)
    return record(scenes.city_block(frames=FRAMES)[::EVERY], PATH,
                  load_reference("12_streaming_obstacles").detect_obstacles, compose=compose,
                  size=(800, 420))


def compose(sight):
    """Only what the detector saw: no timing, so that the same film is the same file."""
    return (Scene().add_cloud(sight.cloud).add_oriented_boxes(sight.found, name="obstacles found")
            .add_ego_car())
