"""Run a detector over a stream of frames, to watch them one by one or to record a film."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from utils.clouds.errors import CloudFileError
from utils.films.frames import DetectedFrame
from utils.films.writers import Film, write_film
from utils.progress import progress
from utils.scene3d import Scene
from utils.scene3d.cameras import Camera, as_camera
from utils.scene3d.output import choose_renderer, picture_of
from utils.tracking import Tracker

SIZE = (960, 540)
ROAD_USERS = ("car", "truck", "cyclist", "pedestrian")
"""Kinds of objects whose true boxes are shown; houses and trees would hide the rest."""
SCAN_SECONDS = 0.1
"""Time between two scans if it is unknown; most scanners turn ten times a second."""
STREAMS = {".rrd": "A stream for Rerun.", ".mcap": "A stream for Foxglove and RViz."}
"""Files for other viewers by suffix; `utils.films.streams` writes them."""
TRAIL = 30
"""Number of places in a trail: three seconds of a scanner that turns ten times a second."""


def watch(
    frames: Sequence, detect: Callable | None = None, tracker: Tracker | None = None
) -> Iterator[DetectedFrame]:
    """Run a detector over frames, one at a time.

    The detector processes the first frame once before it is timed, so that loading libraries does
    not count.

    Parameters
    ----------
    frames : sequence
        Frames with `cloud` and, if known, `boxes` and `time`; or arrays of points.
    detect : callable, optional
        Takes a cloud and returns boxes (N, 8, 3).
    tracker : utils.tracking.Tracker, optional
        Assigns track IDs to the boxes.

    Raises
    ------
    Exception
        Any exception of the detector in the first frame, or a first scan that cannot be read. Later
        failures are stored in `DetectedFrame.problem`, so that one scan does not end the film.
    """
    times = getattr(frames, "times", np.arange(len(frames)) * SCAN_SECONDS)
    trail_recorder, before = _TrailRecorder(tracker) if tracker else None, None
    for number, frame in enumerate(_readable(frames), start=1):
        if isinstance(frame, CloudFileError):
            if number == 1:
                raise frame
            moment = float(times[number - 1])
            problem = f"the scan cannot be read: {frame}"
            yield DetectedFrame(number, len(frames), moment, np.empty((0, 4)), (), problem=problem)
            continue
        cloud = np.asarray(getattr(frame, "cloud", frame))
        moment = float(getattr(frame, "time", times[number - 1]))
        boxes = tuple(box for box in getattr(frame, "boxes", ()) if box.kind in ROAD_USERS)
        found, seconds, problem, track_ids, trails = None, 0.0, "", None, ()
        if detect is not None:
            try:
                if number == 1:
                    detect(cloud)
                start = time.perf_counter()
                found = detect(cloud)
                seconds = time.perf_counter() - start
                found = as_boxes(found)
                if trail_recorder:
                    # Some recordings give two scans the same time, and trackers divide by it.
                    since = moment - before if before not in (None, moment) else SCAN_SECONDS
                    track_ids, trails = trail_recorder.follow(found, since)
            except Exception as error:
                if number == 1:
                    raise
                found, problem = None, f"the detector failed: {type(error).__name__}: {error}"
        before = moment
        yield DetectedFrame(
            number, len(frames), moment, cloud, boxes, found, seconds, problem, track_ids, trails
        )


def _readable(frames: Sequence) -> Iterator[object]:
    """Iterate over frames; a frame that cannot be read becomes its CloudFileError."""
    position = 0
    while position < len(frames):
        try:
            for frame in frames[position:] if position else frames:
                position += 1
                yield frame
            return
        except CloudFileError as error:
            position += 1
            yield error


class _TrailRecorder:
    """Applies a tracker to each frame and keeps the trail of each object."""

    def __init__(self, tracker: Tracker) -> None:
        self._tracker = tracker
        self._trails: dict[int, list[np.ndarray]] = {}

    def follow(
        self, boxes: np.ndarray, seconds: float
    ) -> tuple[tuple[int, ...], tuple[np.ndarray, ...]]:
        """Return the track IDs of the next frame's boxes (N, 8, 3), and all trails."""
        track_ids = self._tracker.update(boxes, seconds)
        tracks = self._tracker.tracks
        self._trails = {
            track_id: [*self._trails.get(track_id, ()), box.mean(axis=0)][-TRAIL:]
            for track_id, box in zip(tracks.ids.tolist(), tracks.boxes, strict=True)
        }
        return tuple(track_ids.tolist()), tuple(map(np.array, self._trails.values()))


def scene_of(frame: DetectedFrame, title: str = "") -> Scene:
    """Build a scene with the cloud, the detected boxes and the true boxes, which are dashed.

    True boxes are labelled with their kind only if there are no detected boxes.
    """
    scene = Scene(title).add_cloud(frame.cloud)
    if frame.true_boxes:
        corners = np.array([box.corners for box in frame.true_boxes])
        names = None if frame.boxes is not None else [box.kind for box in frame.true_boxes]
        scene.add_oriented_boxes(corners, reference=True, names=names, name="true boxes")
    if frame.boxes is not None:
        names = True if frame.track_ids is None else frame.track_ids
        scene.add_oriented_boxes(frame.boxes, names=names, name="detected boxes")
    if frame.trails:
        scene.add_trails(frame.trails)
    scene.caption = frame.caption
    return scene


def record(
    frames: Iterable,
    path: str | os.PathLike,
    detect: Callable | None = None,
    *,
    tracker: Tracker | None = None,
    camera: str | Camera = "XY",
    compose: Callable[[DetectedFrame], Scene] = scene_of,
    size: tuple[int, int] = SIZE,
    frames_per_second: float = 10.0,
    renderer: str | None = None,
) -> Film:
    """Make a film of a stream, or a file for other viewers, and show a progress bar.

    Parameters
    ----------
    frames : iterable
        Frames with `cloud` and, if known, `boxes` and `time`; or arrays of points.
    path : str or path
        Ends in .mp4 or .gif for a film, or in .png for a picture of the first frame. A .rrd file is
        for Rerun, and an .mcap file for Foxglove and RViz; the other options do not apply to these.
    detect : callable, optional
        Takes a cloud and returns boxes (N, 8, 3), such as ``detect_obstacles``. It is timed.
    tracker : utils.tracking.Tracker, optional
        Assigns track IDs to the boxes, and adds trails.
    camera : {"XY", "TopDown", "Side", "FPS"} or Camera
    compose : callable, optional
        Takes a `DetectedFrame` and returns the `Scene` to film, to show more than points and boxes.
    size : (int, int)
        Width and height in pixels, rounded down to even numbers as films require.
    frames_per_second : float
    renderer : {"pyvista", "matplotlib"}, optional
        By default PyVista if it can draw here, else matplotlib.

    Raises
    ------
    ValueError
        The path has another suffix, or there are no frames.
    """
    path, camera = Path(path), as_camera(camera)
    frames = frames if hasattr(frames, "__len__") else list(frames)
    if path.suffix == ".png":
        frames = frames[:1]
    if not len(frames):
        raise ValueError("There are no frames to record.")
    size = tuple(int(length) // 2 * 2 for length in size)
    detected = []

    def watched() -> Iterator[DetectedFrame]:
        bar = progress(range(len(frames)), f"Recording {path.name}")
        for frame, _ in zip(watch(frames, detect, tracker), bar, strict=False):
            yield frame
            detected.append(frame)
        next(bar, None)  # complete the progress bar

    def images() -> Iterator[np.ndarray]:
        with open_renderer(size, camera, renderer) as take:
            for frame in watched():
                yield take(compose(frame))

    description = STREAMS.get(
        path.suffix,
        f"A film of a street seen {camera.seen_from}, drawn from the points of a scanner.",
    )
    if path.suffix in STREAMS:
        from utils.films.streams import write_stream

        write_stream(path, watched())
    else:
        write_film(path, images(), frames_per_second)
    found = [frame for frame in detected if frame.boxes is not None]
    return Film(
        path,
        len(detected),
        tuple(frame.seconds for frame in found),
        tuple(len(frame.boxes) for frame in found),
        tuple(f"frame {frame.number}, {frame.problem}" for frame in detected if frame.problem),
        description,
    )


@contextmanager
def open_renderer(
    size: tuple[int, int], camera: Camera, renderer: str | None
) -> Iterator[Callable[[Scene], np.ndarray]]:
    """Yield a function that draws scenes; with PyVista, all pictures share one `Studio`."""
    if choose_renderer(renderer) == "matplotlib":
        yield lambda scene: picture_of(scene, camera, size, "matplotlib")
        return
    from utils.scene3d.with_pyvista import Studio

    with Studio(size) as studio:
        yield lambda scene: studio.picture(scene, camera)


def as_boxes(found: ArrayLike) -> np.ndarray:
    """Return boxes as a float array (N, 8, 3), or raise `ValueError` for any other shape."""
    boxes = np.asarray(found, dtype=float)
    if boxes.size == 0:
        return np.empty((0, 8, 3))
    if boxes.ndim != 3 or boxes.shape[1:] != (8, 3):
        raise ValueError(
            f"A detector must return boxes of shape (N, 8, 3); your boxes have shape {boxes.shape}."
        )
    return boxes
