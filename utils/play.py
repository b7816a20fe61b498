"""Play a stream of scans in a window, or write a film if there is no screen.

    python -m utils.play city
    python -m utils.play cyclist --detector notebooks/stage4_realtime/12_streaming_obstacles.ipynb
    python -m utils.play highway --detector 12_streaming_obstacles.ipynb --set ground_level=-2.2
    python -m utils.play highway --camera TopDown --show lidar_rays --record highway.gif
    python -m utils.play city --frames 1 --record city.png
    python -m utils.play city --detector 12_streaming_obstacles.ipynb --record city.mcap
    python -m utils.play my_recording.bag

Without a detector, simulated streams and labelled recordings show their true boxes. If the notebook
has `match_boxes`, boxes have track IDs and trails; `--hide trails` hides the trails.
"""

from __future__ import annotations

import argparse
import ast
import functools
import inspect
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from utils.clouds.errors import CloudFileError, file_error
from utils.films.film import SIZE, DetectedFrame, record, scene_of, watch
from utils.films.writers import best_film_suffix
from utils.plots.style import BLUE, PALE
from utils.scene3d import CAMERAS, LAYERS, Scene
from utils.scene3d.opengl import has_screen
from utils.tracking import Tracker, tracker_from

DETECTOR_NAME = "detect_obstacles"
SIMULATED_SCENES = {
    "highway": "Simple highway",
    "city": "City block",
    "cyclist": "Behind a cyclist",
}
RECORDING_NAMES = ("udacity_city", "udacity_cyclist", "kitti_0002", "kitti_0005")

HIGHWAY_SENSOR = 2.6
HIGHWAY_EGO = ((-2.0, -1.0, -HIGHWAY_SENSOR), (2.0, 1.0, 1.9 - HIGHWAY_SENSOR))
"""Two opposite corners of the ego car below the highway's sensor, in metres."""

HIDDEN_LAYERS = ("lidar_rays",)
"""Layers that are off by default; a thousand rays would hide everything else."""


@dataclass(frozen=True)
class Playback:
    """A stream to play: its title, its frames, and the settings for drawing them.

    Attributes
    ----------
    title : str
        Text above the picture.
    frames : sequence
        Simulated or recorded frames, or bare clouds.
    is_highway : bool
        Whether to draw the highway's road, the ego car, and a solid model of each true car.
    layer_switches : tuple of (str, bool)
        Layers to turn on or off.
    """

    title: str
    frames: Sequence
    is_highway: bool = False
    layer_switches: tuple[tuple[str, bool], ...] = ()

    def compose(self, frame: DetectedFrame) -> Scene:
        """Return the scene of a frame: cloud, boxes, ego car and, on the highway, road and cars."""
        scene = scene_of(frame, self.title)
        scene.add_rays(frame.cloud)
        if self.is_highway:
            scene.add_road(HIGHWAY_SENSOR).add_ego_car(*HIGHWAY_EGO)
            cars = [box.corners for box in frame.true_boxes if box.kind == "car"]
            # Blue cars would hide the blue boxes that the detector finds.
            scene.add_cars(cars, colour=BLUE if frame.boxes is None else PALE)
        else:
            scene.add_ego_car()
        return scene.switch(**dict(self.layer_switches))


def open_playback(
    name: str, *, frames: int | None = None, seed: int = 0, topic: str | None = None
) -> Playback:
    """Open a simulated scene, a recording, a folder of clouds or a single cloud for playing.

    Parameters
    ----------
    name : str
        Name of a simulated scene or of a recording that can be downloaded; or the path of a ROS
        recording, a folder of clouds or one cloud.
    frames : int, optional
        Number of frames to play; by default all.
    seed : int
        Random seed for a simulated scene; each seed gives a different street.
    topic : str, optional
        Topic to read from a ROS recording with several topics of clouds.

    Raises
    ------
    CloudFileError
        The file or folder does not exist, or contains no clouds.
    """
    if name in SIMULATED_SCENES:
        return Playback(
            SIMULATED_SCENES[name], _simulated_frames(name, frames, seed), name == "highway"
        )
    return Playback(Path(name).name, _recorded_frames(name, topic)[:frames])


def _simulated_frames(name: str, frames: int | None, seed: int) -> Sequence:
    from utils import scenes
    from utils.datasets import SCENES, load_sequence

    if frames is None:
        return load_sequence(name, seed)
    # Simulating a few frames is faster than filling the cache with the whole sequence.
    return getattr(scenes, SCENES[name])(seed=seed, frames=frames)


def _recorded_frames(name: str, topic: str | None) -> Sequence:
    from utils.clouds import SUFFIXES, read_cloud, read_sequence
    from utils.datasets import fetch_recording
    from utils.recordings import read_bag, read_kitti_raw, rosbag

    path = Path(name).expanduser()
    if name in RECORDING_NAMES and not path.exists():
        return fetch_recording(name)
    # read_bag knows what to do with a .bag.active, which was not closed.
    is_recording = path.suffix.lower() in (*rosbag.SUFFIXES, ".active")
    if is_recording or rosbag.is_recording_folder(path):
        return read_bag(path, topic)
    if path.name == "velodyne_points":
        path = path.parent
    if (path / "velodyne_points").is_dir():
        return read_kitti_raw(path)
    if (path / "velodyne").is_dir():  # a sequence of KITTI's odometry benchmark
        return read_sequence(path / "velodyne")
    if path.is_file() and path.suffix.lower() in SUFFIXES:
        return [read_cloud(path)]
    if path.is_file():
        raise file_error(
            path,
            "",
            f"found {path.suffix or 'no suffix'}, expected a cloud ({', '.join(SUFFIXES)}), a ROS "
            f"recording ({', '.join(rosbag.SUFFIXES)}) or a folder of clouds",
        )
    return read_sequence(path)


def load_detector(
    notebook: str, settings: dict[str, object] | None = None
) -> tuple[Callable, Tracker | None]:
    """Return the detector of a notebook and, if `match_boxes` is written there, a tracker.

    Parameters
    ----------
    notebook : str
        Path of the notebook.
    settings : dict, optional
        Values for parameters of `detect_obstacles` other than the cloud.

    Returns
    -------
    detect : callable
        Takes a cloud, with the settings already applied.
    tracker : utils.tracking.Tracker or None

    Raises
    ------
    ValueError
        The notebook has no `detect_obstacles` or only its stub, or the function has no parameter
        for one of the settings.
    """
    from utils.notebooks.my_functions import load_my_functions

    functions = load_my_functions(notebook)
    if not hasattr(functions, DETECTOR_NAME):
        names = ", ".join(sorted(vars(functions))) or "none"
        raise ValueError(
            f"{Path(notebook).name} has no function {DETECTOR_NAME}(cloud). "
            f"You write this function in lesson 12. The notebook defines: {names}."
        )
    detect = getattr(functions, DETECTOR_NAME)
    if getattr(detect, "is_stub", False):
        raise ValueError(
            f"{DETECTOR_NAME} in {Path(notebook).name} is not written yet. Write it and save the "
            "notebook, or leave out the notebook to see the true boxes."
        )
    parameters = inspect.signature(detect).parameters.values()
    known_names = [parameter.name for parameter in parameters][1:]
    unknown = [name for name in settings or {} if name not in known_names]
    takes_all = any(parameter.kind is parameter.VAR_KEYWORD for parameter in parameters)
    if unknown and not takes_all:
        raise ValueError(
            f"{DETECTOR_NAME} has no parameter {unknown[0]}. "
            + (
                f"Its parameters are {', '.join(known_names)}."
                if known_names
                else "Its only parameter is the cloud."
            )
        )
    return functools.partial(detect, **(settings or {})), tracker_from(functions)


def play(
    playback: Playback,
    detect: Callable | None,
    camera: str,
    size: tuple[int, int] = SIZE,
    tracker: Tracker | None = None,
) -> None:
    """Play in a window at the speed of the recording, or more slowly on a slow machine."""
    from utils.scene3d.with_pyvista import Window

    window = Window(size, CAMERAS[camera])
    print("F1 to F4: cameras · space: pause · q: quit")
    start, paused_for = time.monotonic(), 0.0
    for frame in watch(playback.frames, detect, tracker):
        if not window.is_open:
            break
        window.show_scene(playback.compose(frame))
        while window.is_open and (
            window.is_paused or time.monotonic() - start - paused_for < frame.time
        ):
            paused_for += 0.02 if window.is_paused else 0.0
            time.sleep(0.02)
            window.refresh()
    window.wait_until_closed()
    window.close()


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code: 0, 2 after an error, 130 after Ctrl-C."""
    options = build_parser().parse_args(arguments)
    try:
        _run(options)
    except (ValueError, CloudFileError, OSError) as error:
        print(error)
        return 2
    except KeyboardInterrupt:
        print("\nStopped.")
        return 130
    return 0


def _run(options: argparse.Namespace) -> None:
    detect = tracker = None
    if options.detector:
        detect, tracker = load_detector(options.detector, dict(options.set))
    playback = open_playback(
        options.what, frames=options.frames, seed=options.seed, topic=options.topic
    )
    switches = dict.fromkeys(HIDDEN_LAYERS, False)
    switches |= dict.fromkeys(options.hide, False) | dict.fromkeys(options.show, True)
    playback = Playback(
        playback.title, playback.frames, playback.is_highway, tuple(switches.items())
    )
    if detect is None:
        print(
            "Without --detector, the boxes are the true boxes of the simulator."
            if options.what in SIMULATED_SCENES
            else "Without --detector, only labelled recordings show boxes, which are the true "
            "boxes. To see yours, add --detector 12_streaming_obstacles.ipynb"
        )
    if options.record is None and has_screen():
        play(playback, detect, options.camera, options.size, tracker)
        return
    path = options.record or Path(Path(options.what).stem + best_film_suffix())
    if options.record is None:
        print(f"No window can be opened here. Writing the film to {path}.")
    film = record(
        playback.frames,
        path,
        detect,
        tracker=tracker,
        camera=options.camera,
        compose=playback.compose,
        size=options.size,
    )
    print(f"{film.path}: {film.recap}")


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of the command line ``python -m utils.play``."""
    parser = argparse.ArgumentParser(
        prog="python -m utils.play",
        description=__doc__.split("\n\n")[0],
        epilog="Layers: " + ", ".join(LAYERS),
    )
    parser.add_argument(
        "what",
        metavar="WHAT",
        help=f"simulated stream: {', '.join(SIMULATED_SCENES)}; recording to download: "
        f"{', '.join(RECORDING_NAMES)}; or the path of a folder of clouds, a .bag, .db3 or .mcap "
        "recording, or one cloud",
    )
    parser.add_argument(
        "--detector",
        metavar="NOTEBOOK",
        help=f"notebook that defines {DETECTOR_NAME}(cloud) (default: show the true boxes)",
    )
    parser.add_argument(
        "--set",
        nargs="+",
        default=[],
        type=_setting,
        metavar="NAME=VALUE",
        help="values for parameters of the detector, such as threshold=0.7",
    )
    parser.add_argument(
        "--record",
        type=Path,
        metavar="FILE",
        help="write a film (.mp4 or .gif), a picture of the first frame (.png), or a file for "
        "Rerun (.rrd) or for Foxglove and RViz (.mcap) instead of opening a window",
    )
    parser.add_argument(
        "--camera",
        default="XY",
        type=_camera_name,
        metavar="CAMERA",
        help=f"viewpoint: {', '.join(CAMERAS)} (default: XY)",
    )
    parser.add_argument(
        "--frames", type=_count, metavar="N", help="play only the first N frames (default: all)"
    )
    parser.add_argument(
        "--size",
        type=_size,
        default=SIZE,
        metavar="WxH",
        help="width and height in pixels (default: 960x540)",
    )
    for name, verb in (("show", "on"), ("hide", "off")):
        parser.add_argument(
            f"--{name}",
            nargs="+",
            default=[],
            choices=LAYERS,
            metavar="LAYER",
            help=f"turn {verb} these layers",
        )
    parser.add_argument(
        "--seed", type=int, default=0, help="seed of a simulated stream (default: 0)"
    )
    parser.add_argument(
        "--topic", help="topic to read from a ROS recording (default: the only one with clouds)"
    )
    return parser


def _camera_name(text: str) -> str:
    for name in CAMERAS:
        if name.lower() == text.lower():
            return name
    raise argparse.ArgumentTypeError(f"{text!r} is not one of {', '.join(CAMERAS)}")


def _setting(text: str) -> tuple[str, object]:
    name, equals, value = text.partition("=")
    try:
        if equals and name.isidentifier():
            return name, ast.literal_eval(value)
    except (ValueError, SyntaxError):
        pass
    raise argparse.ArgumentTypeError(f"{text!r} is not a setting such as threshold=0.7")


def _count(text: str) -> int:
    if not text.isdigit() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"must be a whole number of at least 1, not {text!r}")
    return int(text)


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.lower().partition("x")
    if not (width.isdigit() and height.isdigit() and min(int(width), int(height)) >= 64):
        raise argparse.ArgumentTypeError(f"{text!r} is not a size such as 960x540")
    return int(width), int(height)


if __name__ == "__main__":
    sys.exit(main())
