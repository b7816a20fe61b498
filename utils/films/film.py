"""A stream of frames, seen through a detector: watched one by one, or recorded."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from utils.films.writers import Film, write_film
from utils.progress import progress
from utils.scene3d import Scene
from utils.scene3d.cameras import Camera, as_camera
from utils.scene3d.output import picture_of, renderer_for
from utils.tracking import Tracker

SIZE = (960, 540)
ROAD_USERS = ("car", "truck", "cyclist", "pedestrian")
"""Kinds whose true boxes are shown; houses and trees would hide the rest."""
TRAIL = 30
"""Places in a trail: three seconds of a scanner that turns ten times a second."""


@dataclass(frozen=True, eq=False)
class Sight:
    """One frame and what a detector made of it.

    Attributes
    ----------
    number, total : int
        Position in the stream, from 1, and length of the stream.
    time : float
        Seconds since the first frame.
    cloud : ndarray, shape (n, 3) or (n, 4)
    true_boxes : tuple of utils.boxes.Box
        Of road users; empty where nobody knows them.
    found : ndarray, shape (N, 8, 3), or None
        None without a detector, or where it failed.
    seconds : float
        How long the detector took.
    problem : str
        Why it failed, if it did.
    names : tuple of int or None
        The same for a box as long as it is followed; None where nobody follows.
    trails : tuple of ndarray, shape (m, 3)
        The latest places of all that is followed, as they were seen, oldest first; where a thing
        has no box by now, on to where it should be.
    """

    number: int
    total: int
    time: float
    cloud: np.ndarray
    true_boxes: tuple
    found: np.ndarray | None = None
    seconds: float = 0.0
    problem: str = ""
    names: tuple[int, ...] | None = None
    trails: tuple[np.ndarray, ...] = ()

    @property
    def caption(self) -> str:
        """The line below the picture: where in the stream, how long it took, how much was found."""
        words = [f"frame {self.number} of {self.total}", f"{self.time:.1f} s"]
        if self.problem:
            words.append(f"the detector failed: {self.problem}"[:90])
        elif self.found is not None:
            words.append(f"detected in {1000 * self.seconds:.0f} ms")
            words.append(f"{len(self.found)} box" + ("" if len(self.found) == 1 else "es"))
        return " · ".join(words)


def watch(
    frames: Sequence, detect: Callable | None = None, tracker: Tracker | None = None
) -> Iterator[Sight]:
    """Run a detector over frames, one at a time.

    Before the clock starts it sees the first frame once: loading libraries is not detecting.

    Parameters
    ----------
    frames : sequence
        Frames with `cloud` and, where known, `boxes` and `time`; or bare clouds.
    detect : callable, optional
        From a cloud to boxes (N, 8, 3).
    tracker : utils.tracking.Tracker, optional
        Gives the boxes their names.

    Raises
    ------
    Exception
        Whatever the detector raises in the first frame. Later failures go into `Sight.problem`:
        one odd scan should not cost the whole film.
    """
    times = getattr(frames, "times", np.arange(len(frames)) / 10)  # a bag knows, 10 Hz is usual
    follower, before = _Follower(tracker) if tracker else None, None
    for number, frame in enumerate(frames, start=1):
        cloud = np.asarray(getattr(frame, "cloud", frame))
        moment = float(getattr(frame, "time", times[number - 1]))
        boxes = tuple(box for box in getattr(frame, "boxes", ()) if box.kind in ROAD_USERS)
        found, seconds, problem, names, trails = None, 0.0, "", None, ()
        if detect is not None:
            try:
                if number == 1:
                    detect(cloud)
                start = time.perf_counter()
                found = detect(cloud)
                seconds = time.perf_counter() - start
                found = checked_boxes(found)
                if follower:
                    since = moment - before if before is not None else 0.1
                    names, trails = follower.follow(found, since)
            except Exception as error:
                if number == 1:
                    raise
                found, problem = None, f"{type(error).__name__}: {error}"
        before = moment
        yield Sight(
            number, len(frames), moment, cloud, boxes, found, seconds, problem, names, trails
        )


class _Follower:
    """What a tracker says of each frame, with the way that each thing came."""

    def __init__(self, tracker: Tracker) -> None:
        self._tracker = tracker
        self._ways: dict[int, list[np.ndarray]] = {}

    def follow(
        self, boxes: np.ndarray, seconds: float
    ) -> tuple[tuple[int, ...], tuple[np.ndarray, ...]]:
        """The names of the boxes (N, 8, 3) of the next frame, and all trails."""
        names = self._tracker.update(boxes, seconds)
        tracks = self._tracker.tracks
        self._ways = {
            name: [*self._ways.get(name, ()), box.mean(axis=0)][-TRAIL:]
            for name, box in zip(tracks.names.tolist(), tracks.boxes, strict=True)
        }
        return tuple(names.tolist()), tuple(map(np.array, self._ways.values()))


def scene_of(sight: Sight, title: str = "") -> Scene:
    """The cloud with the boxes found, and the true ones dashed; named where nothing was sought."""
    scene = Scene(title).add_cloud(sight.cloud)
    if sight.true_boxes:
        corners = np.array([box.corners for box in sight.true_boxes])
        names = None if sight.found is not None else [box.kind for box in sight.true_boxes]
        scene.add_oriented_boxes(corners, reference=True, names=names, name="true boxes")
    if sight.found is not None:
        names = True if sight.names is None else sight.names
        scene.add_oriented_boxes(sight.found, names=names, name="detected boxes")
    if sight.trails:
        scene.add_trails(sight.trails)
    scene.caption = sight.caption
    return scene


def record(
    frames: Iterable,
    path: str | os.PathLike,
    detect: Callable | None = None,
    *,
    tracker: Tracker | None = None,
    camera: str | Camera = "XY",
    compose: Callable[[Sight], Scene] = scene_of,
    size: tuple[int, int] = SIZE,
    frames_per_second: float = 10.0,
    renderer: str | None = None,
) -> Film:
    """Make a film of a stream, with a bar that shows how far it has come.

    Parameters
    ----------
    frames : iterable
        Frames with `cloud` and, where known, `boxes` and `time`; or bare clouds.
    path : str or path
        Ends in .mp4 or .gif; or in .png for a picture of the first frame.
    detect : callable, optional
        From a cloud to boxes (N, 8, 3), such as ``detect_obstacles``. It is timed.
    tracker : utils.tracking.Tracker, optional
        Gives the boxes their names, and trails.
    camera : {"XY", "TopDown", "Side", "FPS"} or Camera
    compose : callable, optional
        From a `Sight` to the `Scene` to film, for more than points and boxes.
    size : (int, int)
        Width and height in pixels; made even, as films want it.
    frames_per_second : float
    renderer : {"pyvista", "matplotlib"}, optional
        By default PyVista where it can draw, else matplotlib.

    Raises
    ------
    ValueError
        The path has another ending, or there are no frames.
    """
    path, camera = Path(path), as_camera(camera)
    frames = frames if hasattr(frames, "__len__") else list(frames)
    if path.suffix == ".png":
        frames = frames[:1]
    if not len(frames):
        raise ValueError("There are no frames to record.")
    size = tuple(int(length) // 2 * 2 for length in size)
    sights = []

    def images() -> Iterator[np.ndarray]:
        with camera_team(size, camera, renderer) as take:
            bar = progress(range(len(frames)), f"Recording {path.name}")
            for sight, _ in zip(watch(frames, detect, tracker), bar, strict=False):
                yield take(compose(sight))
                sights.append(sight)
            next(bar, None)  # lets the bar show its last step

    write_film(path, images(), frames_per_second)
    found = [sight for sight in sights if sight.found is not None]
    return Film(
        path,
        len(sights),
        tuple(sight.seconds for sight in found),
        tuple(len(sight.found) for sight in found),
        tuple(f"frame {sight.number}, {sight.problem}" for sight in sights if sight.problem),
        f"A film of a street seen {camera.seen_from}, drawn from the points of a scanner.",
    )


@contextmanager
def camera_team(
    size: tuple[int, int], camera: Camera, renderer: str | None
) -> Iterator[Callable[[Scene], np.ndarray]]:
    """A function that takes pictures; with PyVista they share what is costly to set up."""
    if renderer_for(renderer) == "matplotlib":
        yield lambda scene: picture_of(scene, camera, size, "matplotlib")
        return
    from utils.scene3d.with_pyvista import Studio

    with Studio(size) as studio:
        yield lambda scene: studio.picture(scene, camera)


def checked_boxes(found: ArrayLike) -> np.ndarray:
    """Boxes as a float array (N, 8, 3); a sentence for anything else."""
    boxes = np.asarray(found, dtype=float)
    if boxes.size == 0:
        return np.empty((0, 8, 3))
    if boxes.ndim != 3 or boxes.shape[1:] != (8, 3):
        raise ValueError(f"A detector returns boxes (N, 8, 3); yours returned {boxes.shape}.")
    return boxes
