"""Writing films to files, reading them again, and counting their frames."""

import gc

import numpy as np
import pytest
from PIL import Image

from tests.prerequisites import FFMPEG
from utils import progress as bar
from utils import scenes
from utils.clouds import CloudFileError, read_sequence, write_cloud
from utils.films.film import record, scene_of, watch
from utils.films.frames import DetectedFrame
from utils.films.writers import write_film
from utils.recordings import Recording
from utils.scene3d import Scene, opengl
from utils.tracking import Tracker

SIZE = (160, 90)


@pytest.fixture(scope="module")
def frames():
    return [frame for frame in scenes.highway(frames=3)]


def box_of_everything(cloud):
    low, high = cloud[:, :3].min(axis=0), cloud[:, :3].max(axis=0)
    return np.array([[np.where([k & 1, k & 2, k & 4], high, low) for k in range(8)]])


@pytest.mark.slow
@pytest.mark.parametrize("renderer", ["pyvista", "matplotlib"])
def test_an_mp4_contains_a_picture_for_each_frame(tmp_path, frames, renderer):
    pytest.importorskip("imageio_ffmpeg", reason=FFMPEG)
    if renderer == "pyvista" and opengl.problem():
        pytest.skip(opengl.problem())
    import imageio.v3 as imageio

    path = tmp_path / "film.mp4"
    film = record(frames, path, box_of_everything, size=(161, 91), renderer=renderer)
    pictures = imageio.imread(path)
    assert pictures.shape == (3, 90, 160, 3)  # players require even sizes
    assert not np.array_equal(pictures[0], pictures[2])
    assert film.frames == 3 and film.boxes == (1, 1, 1) and len(film.seconds) == 3
    assert "1 box per frame; detection took" in film.recap
    assert list(tmp_path.iterdir()) == [path]


def test_a_gif_repeats_forever_at_the_given_rate(tmp_path, frames):
    path = tmp_path / "film.gif"
    record(frames, path, camera="TopDown", size=SIZE, frames_per_second=5, renderer="matplotlib")
    image = Image.open(path)
    assert (image.n_frames, image.size, image.info["loop"]) == (3, SIZE, 0)
    assert image.info["duration"] == 200
    image.seek(1)
    assert max(image.convert("RGB").getcolors(10_000))[1] == (255, 255, 255)  # the white background


def test_a_png_is_the_first_frame(tmp_path, frames):
    film = record(frames, tmp_path / "frame.png", size=SIZE, renderer="matplotlib")
    assert film.frames == 1 and Image.open(film.path).size == SIZE


def test_bare_clouds_and_a_custom_scene_are_recorded(tmp_path, frames):
    composed = []

    def compose(frame):
        composed.append(frame.number)
        return Scene().add_rays(frame.cloud)

    clouds = (frame.cloud for frame in frames)
    record(clouds, tmp_path / "rays.gif", compose=compose, size=SIZE, renderer="matplotlib")
    assert composed == [1, 2, 3]


def test_unknown_formats_and_empty_recordings_are_refused(tmp_path, frames):
    with pytest.raises(ValueError, match=".mp4, .gif, .png"):
        record(frames, tmp_path / "film.avi")
    with pytest.raises(ValueError, match="no frames"):
        record([], tmp_path / "film.gif")


def test_a_detector_that_fails_immediately_raises_and_leaves_no_file(tmp_path, frames):
    with pytest.raises(ZeroDivisionError):
        record(frames, tmp_path / "film.gif", lambda cloud: 1 / 0, renderer="matplotlib")
    assert not list(tmp_path.iterdir())


def test_ctrl_c_leaves_neither_a_file_nor_messages(tmp_path, capfd):
    """ffmpeg, which writes the MP4, once complained that its file had been deleted."""
    pytest.importorskip("imageio_ffmpeg", reason=FFMPEG)

    def images():
        yield from np.zeros((3, 64, 64, 3), dtype=np.uint8)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt) as stopped:
        write_film(tmp_path / "film.mp4", images(), 10.0)
    del stopped
    gc.collect()
    assert not list(tmp_path.iterdir())
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("answer", [np.zeros((8, 3)), None, [[1, 2], [3]]])
def test_a_detector_that_does_not_return_boxes_raises(frames, answer):
    with pytest.raises((ValueError, TypeError), match="boxes|sequence|NoneType"):
        list(watch(frames, lambda cloud: answer))


def test_a_detector_that_fails_later_loses_one_frame(tmp_path, frames):
    calls = []

    def detect(cloud):
        calls.append(len(cloud))
        if len(calls) == 3:  # the detector ran twice on the first frame
            raise IndexError("too far")
        return box_of_everything(cloud)

    film = record(frames, tmp_path / "f.gif", detect, size=SIZE, renderer="matplotlib")
    assert film.problems == ("frame 2, the detector failed: IndexError: too far",)
    assert film.boxes == (1, 1)
    assert "failed: 1. The first failure: frame 2, the detector failed: Index" in film.recap


def test_a_scan_that_cannot_be_read_loses_one_frame(tmp_path):
    for number in range(4):
        write_cloud(tmp_path / f"{number}.bin", scenes.simple_highway(number).cloud)
    with (tmp_path / "2.bin").open("ab") as file:
        file.write(b"cut")
    seen = list(watch(read_sequence(tmp_path), box_of_everything))
    assert [frame.number for frame in seen] == [1, 2, 3, 4]
    assert [bool(frame.problem) for frame in seen] == [False, False, True, False]
    assert seen[2].problem.startswith("the scan cannot be read: 2.bin") and seen[2].cloud.shape == (
        0,
        4,
    )
    (tmp_path / "0.bin").write_bytes(b"cut")
    with pytest.raises(CloudFileError, match=r"0\.bin"):
        list(watch(read_sequence(tmp_path), box_of_everything))


def test_the_time_between_two_scans_is_never_zero(frames):
    seconds = []

    class SpyingTracker(Tracker):
        def update(self, boxes, elapsed):
            seconds.append(elapsed)
            return super().update(boxes, elapsed)

    clouds = [frame.cloud for frame in [*frames, *frames]][:4]
    recording = Recording(clouds, np.array([0, 0.2, 0.2, 0.5]))
    tracker = SpyingTracker(lambda previous, current, max_distance: np.array([len(previous) - 1]))
    list(watch(recording, box_of_everything, tracker))
    np.testing.assert_allclose(seconds, [0.1, 0.2, 0.1, 0.3])


def test_the_caption_contains_time_and_number(frames):
    sights = list(watch(frames, box_of_everything))
    assert sights[1].caption.startswith("frame 2 of 3 · 0.1 s · detected in ")
    assert sights[1].caption.endswith(" ms · 1 box")
    assert next(watch(frames)).caption == "frame 1 of 3 · 0.0 s"


def test_true_boxes_are_named_only_without_a_detector(frames):
    plain, detected = (scene_of(next(watch(frames, how))) for how in (None, box_of_everything))
    assert "3 true boxes" in plain.describe() and "detected" not in plain.describe()
    assert "1 detected boxes" in detected.describe()
    kinds = [part.text for part in plain.parts if hasattr(part, "text")]
    assert kinds == ["car"] * 3
    assert [part.text for part in detected.parts if hasattr(part, "text")] == ["0"]


def test_houses_are_not_among_the_true_boxes():
    frame = next(watch(scenes.city_block(frames=1)))
    assert isinstance(frame, DetectedFrame) and frame.true_boxes
    assert {box.kind for box in frame.true_boxes} <= {"car", "truck", "cyclist", "pedestrian"}


def test_progress_goes_to_standard_output(tmp_path, frames, monkeypatch, capsys):
    monkeypatch.setattr(bar.sys.stdout, "isatty", lambda: True, raising=False)
    record(frames, tmp_path / "film.gif", size=SIZE, renderer="matplotlib")
    written = capsys.readouterr()
    assert "Recording film.gif" in written.out and "3/3" in written.out
    assert written.err == ""


@pytest.mark.parametrize(("suffix", "tag"), [(".gif", "<img alt="), (".mp4", "<video controls")])
def test_a_film_in_a_notebook_has_a_description(tmp_path, frames, suffix, tag):
    if suffix == ".mp4":
        pytest.importorskip("imageio_ffmpeg", reason=FFMPEG)
    film = record(frames, tmp_path / f"f{suffix}", size=SIZE, renderer="matplotlib")
    page = film._repr_html_()
    assert page.startswith(tag) and "base64," in page
    assert "seen from behind, right and above" in page and "3 frames." in page
