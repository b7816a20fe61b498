"""The player shows every scenario, with and without a simulated screen."""

import importlib.util
import subprocess
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from tests.prerequisites import FFMPEG
from utils import play, scenes
from utils.clouds import write_cloud
from utils.films import writers
from utils.scene3d import with_pyvista

SMALL = ["--size", "160x90"]
PROJECT = Path(__file__).resolve().parent.parent


@pytest.fixture(autouse=True)
def without_screen(monkeypatch, tmp_path):
    monkeypatch.setattr(play, "has_screen", lambda: False)
    monkeypatch.setenv("LIDAR_LAB_CACHE", str(tmp_path / "cache"))
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def notebook(monkeypatch):
    """Return an empty namespace in place of a notebook's functions; tests fill it."""
    functions = SimpleNamespace()
    module = ModuleType("utils.notebooks.my_functions")
    module.load_my_functions = lambda path: functions
    monkeypatch.setitem(sys.modules, "utils.notebooks.my_functions", module)
    return functions


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "frames"), [("highway", 2), ("city", 1), ("city", 2), ("cyclist", 2)]
)
def test_built_in_scenarios_are_played(name, frames, capsys):
    assert play.main([name, "--frames", str(frames), "--record", "film.gif", *SMALL]) == 0
    assert Image.open("film.gif").n_frames == frames
    output = capsys.readouterr().out
    assert "the true boxes of the simulator" in output
    assert f"{frames} frame" in output


def test_a_whole_stream_comes_from_the_cache(tmp_path):
    playback = play.open_playback("highway")
    assert len(playback.frames) == 30 and playback.is_highway
    assert list((tmp_path / "cache").rglob("*.npz"))


@pytest.mark.parametrize("suffix", [".pcd", ".txt"])
def test_folders_and_single_clouds_are_played(tmp_path, suffix, capsys):
    folder = tmp_path / "scans"
    folder.mkdir()
    for number in range(3):
        write_cloud(folder / f"{number}{suffix}", scenes.simple_highway(number).cloud)
    assert play.main([str(folder), "--record", "folder.gif", "--camera", "topdown", *SMALL]) == 0
    assert Image.open("folder.gif").n_frames == 3
    assert play.main([str(folder / f"1{suffix}"), "--record", "one.png", *SMALL]) == 0
    assert "only labelled recordings show boxes" in capsys.readouterr().out


@pytest.mark.parametrize(
    "name", ["drive.bag", "DRIVE.BAG", "DRIVE.DB3", "drive.mcap", "a.bag.active"]
)
def test_bags_are_opened_with_their_topic(monkeypatch, name):
    seen = []
    monkeypatch.setattr("utils.recordings.read_bag", lambda *given: seen.append(given) or [])
    play.open_playback(name, topic="/points")
    assert seen == [(Path(name), "/points")]


def test_folders_of_kitti_and_of_ros_are_recognised(tmp_path, monkeypatch):
    frame = scenes.simple_highway(0).cloud
    for folder in ("drive/velodyne_points/data", "sequences/00/velodyne"):
        (tmp_path / folder).mkdir(parents=True)
        write_cloud(tmp_path / folder / "0000000000.bin", frame)
    (tmp_path / "drive" / "velodyne_points" / "timestamps.txt").write_text(
        "2011-09-26 13:02:25.5\n"
    )
    (tmp_path / "sequences" / "00" / "calib.txt").write_text("P0: 1 0 0\n")
    for folder in ("drive", "drive/velodyne_points", "sequences/00"):
        assert len(play.open_playback(str(tmp_path / folder)).frames) == 1
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "run_0.mcap").touch()
    seen = []
    monkeypatch.setattr("utils.recordings.read_bag", lambda *given: seen.append(given) or [])
    play.open_playback(str(tmp_path / "run"))
    assert seen == [(tmp_path / "run", None)]


def test_a_file_that_cannot_be_played_gets_a_list_of_formats(tmp_path, capsys):
    (tmp_path / "street.e57").touch()
    assert play.main([str(tmp_path / "street.e57")]) != 0
    message = "".join(capsys.readouterr())
    assert ".ply" in message and ".mcap" in message and "folder of clouds" in message


def test_the_film_is_saved_under_the_scenarios_name_without_a_screen(tmp_path, capsys):
    pytest.importorskip("imageio_ffmpeg", reason=FFMPEG)
    assert play.main(["highway", "--frames", "2", *SMALL]) == 0
    assert (tmp_path / "highway.mp4").stat().st_size > 0
    assert "Writing the film to highway.mp4" in capsys.readouterr().out


def test_the_film_is_a_gif_without_ffmpeg(monkeypatch, tmp_path, capsys):
    # Other packages can be found, because the result of the search for PyVista is cached.
    find_spec = importlib.util.find_spec
    hidden = {"imageio_ffmpeg"}
    monkeypatch.setattr(
        writers.importlib.util,
        "find_spec",
        lambda name, *package: None if name in hidden else find_spec(name, *package),
    )
    assert play.main(["highway", "--frames", "2", *SMALL]) == 0
    assert Image.open(tmp_path / "highway.gif").n_frames == 2
    assert "Writing the film to highway.gif" in capsys.readouterr().out


def test_a_notebook_provides_the_detector(notebook, capsys):
    seen = []
    notebook.detect_obstacles = lambda cloud: seen.append(len(cloud)) or np.empty((0, 8, 3))
    arguments = ["highway", "--frames", "2", "--detector", "mine.ipynb", "--record", "film.gif"]
    assert play.main([*arguments, *SMALL]) == 0
    assert len(seen) == 3, (
        "the first frame runs twice, because loading libraries is not part of detection"
    )
    assert "0 boxes per frame; detection took" in capsys.readouterr().out


def test_a_notebook_without_detector_gets_a_list_of_its_functions(notebook, capsys):
    notebook.filter_ground = len
    assert play.main(["highway", "--detector", "06_filter_ground.ipynb"]) == 2
    output = capsys.readouterr().out
    assert "no function detect_obstacles(cloud)" in output and "filter_ground" in output


def test_the_detector_takes_settings(notebook, capsys):
    seen = []

    def detect_obstacles(cloud, threshold=0.5, minimum=(0, 0, 0)):
        seen.append((threshold, minimum))
        return []

    notebook.detect_obstacles = detect_obstacles
    arguments = ["highway", "--frames", "1", "--detector", "mine.ipynb", "--record", "film.png"]
    settings = ["--set", "threshold=0.7", "minimum=(-1.5, 2, 3)"]
    assert play.main([*arguments, *settings, *SMALL]) == 0
    assert set(seen) == {(0.7, (-1.5, 2, 3))}
    assert play.main([*arguments, "--set", "tolerance=1"]) == 2
    assert (
        "no parameter tolerance. Its parameters are threshold, minimum." in capsys.readouterr().out
    )
    for wrong in ("threshold", "threshold=", "1=2", "threshold=open('x')"):
        with pytest.raises(SystemExit):
            play.main([*arguments, "--set", wrong])


def test_a_stub_is_rejected_as_detector(notebook, capsys):
    def detect_obstacles(cloud):
        raise NotImplementedError

    detect_obstacles.is_stub = True
    notebook.detect_obstacles = detect_obstacles
    assert play.main(["highway", "--detector", "12.ipynb"]) == 2
    assert "is not written yet" in capsys.readouterr().out


def test_boxes_have_the_track_ids_that_matching_assigns(notebook):
    frames = [np.full((4, 4), float(number)) for number in range(3)]
    boxes = [np.zeros((2, 8, 3)), np.zeros((1, 8, 3)), np.zeros((2, 8, 3))]
    partners = iter([[-1, -1], [1], [-1, 0]])
    notebook.detect_obstacles = lambda cloud: boxes[int(cloud[0, 0])]
    notebook.match_boxes = lambda previous, current, limit: next(partners)
    detect, tracker = play.load_detector("mine.ipynb")
    views = list(play.watch(frames, detect, tracker))
    assert [view.track_ids for view in views] == [(1, 2), (2,), (3, 2)]
    # A track without a box ends at once, because the notebook has no `coast` function.
    assert [sorted(len(trail) for trail in view.trails) for view in views] == [
        [1, 1], [2], [1, 3]
    ]  # fmt: skip


def test_missing_folders_and_bad_options_give_a_message(capsys):
    assert play.main(["no_such_folder"]) == 2
    assert "no folder" in capsys.readouterr().out
    assert play.main(["highway", "--frames", "1", "--record", "film.avi"]) == 2
    for wrong in (["--camera", "bird"], ["--frames", "0"], ["--size", "big"], ["--show", "box"]):
        with pytest.raises(SystemExit) as stopped:
            play.main(["highway", *wrong])
        assert stopped.value.code == 2


def test_layers_are_switched_from_the_command_line(monkeypatch):
    compose_functions = []
    monkeypatch.setattr(
        play,
        "record",
        lambda frames, path, detect, *, compose, **_: (
            compose_functions.append(compose) or SimpleNamespace(path=path, recap="")
        ),
    )
    arguments = ["highway", "--frames", "1", "--record", "f.gif", "--hide", "scene", "ego_car_box"]
    play.main(arguments)
    play.main([*arguments, "--show", "lidar_rays"])
    view = next(play.watch(scenes.highway(frames=1)))
    layers = [{part.layer for part in compose(view).parts} for compose in compose_functions]
    assert layers[0] == {"data_points", "oriented_boxes"}
    assert layers[1] - layers[0] == {"lidar_rays"}


class FakeWindow:
    """A stand-in for a window, which is closed after the second frame."""

    opened = []

    def __init__(self, size, camera):
        self.shown, self.is_open, self.is_paused, self.stayed = [], True, False, False
        self.opened.append(self)

    def show_scene(self, scene):
        self.shown.append(scene.caption)
        self.is_open = len(self.shown) < 2

    def refresh(self):
        pass

    def wait_until_closed(self):
        self.stayed = True

    def close(self):
        self.is_open = False


def test_frames_are_played_on_a_screen_until_the_window_is_closed(monkeypatch, tmp_path):
    monkeypatch.setattr(play, "has_screen", lambda: True)
    monkeypatch.setattr(with_pyvista, "Window", FakeWindow)
    assert play.main(["highway", "--frames", "5"]) == 0
    (window,) = FakeWindow.opened
    assert window.shown == ["frame 1 of 5 · 0.0 s", "frame 2 of 5 · 0.1 s"]
    assert window.stayed and not list(tmp_path.glob("*.mp4"))


def test_help_lists_everything_that_can_be_played():
    done = subprocess.run(
        [sys.executable, "-m", "utils.play", "--help"], cwd=PROJECT, capture_output=True, text=True,
        timeout=600,
    )  # fmt: skip
    assert done.returncode == 0 and done.stderr == ""
    for word in ("highway", "city", "cyclist", ".bag", "--detector", "--record", "TopDown"):
        assert word in done.stdout
