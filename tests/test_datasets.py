"""Named samples of recordings: finding files, the cache, and interrupted downloads.

The only server in these tests listens on the loopback address.
"""

import errno
import hashlib
import io
import pickle
import shutil
import ssl
import struct
import sys
import threading
import urllib.error
import zipfile
from dataclasses import replace
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import numpy as np
import pytest

from utils import datasets, scenes
from utils.checks import lesson_11
from utils.checks.lesson_10 import accelerated
from utils.clouds import CloudFileError, write_cloud
from utils.clouds.pcd import encode_pcd
from utils.recordings import sources
from utils.recordings.download import DownloadError, download


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("LIDAR_LAB_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("no_proxy", "*")
    return tmp_path / "cache"


@pytest.mark.parametrize("is_replaced", [False, True])
def test_a_street_and_its_truth_belong_together(tmp_path, monkeypatch, capsys, is_replaced):
    own, folder = datasets.load_cloud(), tmp_path / "data"
    shutil.copytree(datasets.DATA, folder, ignore=shutil.ignore_patterns("pictures"))
    if is_replaced:
        write_cloud(folder / "cloud.txt", own[::2])
    monkeypatch.setattr(datasets, "DATA", folder)
    cloud, truth = datasets.load_street()
    np.testing.assert_array_equal(cloud, own)
    assert {len(truth[name]) for name in ("classes", "objects", "beams")} == {len(own)}
    assert ("not the course's scan" in capsys.readouterr().out) == is_replaced


@pytest.mark.parametrize("place", ["data", "work"])
@pytest.mark.parametrize("points", [accelerated._end_of_the_street, lesson_11._vehicles])
def test_checks_use_the_courses_scan_whatever_replaces_it(tmp_path, monkeypatch, place, points):
    expected = points()
    shutil.copytree(datasets.DATA, tmp_path / "data", ignore=shutil.ignore_patterns("pictures"))
    (tmp_path / "work").mkdir()
    write_cloud(tmp_path / place / "cloud.txt", datasets.load_cloud()[::2] + 1)
    monkeypatch.setattr(datasets, "DATA", tmp_path / "data")
    monkeypatch.chdir(tmp_path / "work")
    assert pickle.dumps(points.__wrapped__()) == pickle.dumps(expected)


class TestLoadCloud:
    def test_the_working_folder_takes_precedence_over_the_project(
        self, tmp_path, monkeypatch, capsys
    ):
        project = tmp_path / "project" / "data"
        work = tmp_path / "work"
        project.mkdir(parents=True)
        work.mkdir()
        monkeypatch.setattr(datasets, "DATA", project)
        monkeypatch.chdir(work)
        write_cloud(project / "cloud.txt", [[1, 1, 1]])
        write_cloud(project / "other.pcd", [[3, 3, 3]])
        assert datasets.load_cloud()[0, 0] == 1
        assert capsys.readouterr().out == ""
        write_cloud(work / "cloud.txt", [[2, 2, 2, 2]])
        assert datasets.load_cloud()[0, 0] == 2
        assert f"Reading {work / 'cloud.txt'}, not the course's file" in capsys.readouterr().out
        assert datasets.load_cloud("cloud.txt").shape == (1, 4)
        assert datasets.load_cloud(project / "cloud.txt")[0, 0] == 1
        assert datasets.load_cloud("other.pcd")[0, 0] == 3
        capsys.readouterr()
        monkeypatch.chdir(project)
        assert datasets.load_cloud()[0, 0] == 1
        assert capsys.readouterr().out == ""

    def test_the_error_about_a_missing_file_names_both_folders(self, tmp_path, monkeypatch):
        (tmp_path / "data").mkdir()
        monkeypatch.setattr(datasets, "DATA", tmp_path / "data")
        monkeypatch.chdir(tmp_path)
        write_cloud(tmp_path / "data" / "cloud.txt", [[1, 1, 1]])
        with pytest.raises(CloudFileError) as caught:
            datasets.load_cloud("claud.txt")
        message = str(caught.value)
        assert f"no such file in {tmp_path} or {tmp_path / 'data'}" in message
        assert "cloud.txt" in message


class TestLoadSequence:
    def assert_same(self, first, second):
        for name in ("cloud", "classes", "objects", "beams", "times"):
            left, right = getattr(first.scan, name), getattr(second.scan, name)
            assert left.dtype == right.dtype
            np.testing.assert_array_equal(left, right)
        assert first.boxes == second.boxes and first.time == second.time

    def test_frames_equal_the_scene_and_come_from_the_cache(self, cache, monkeypatch):
        expected = scenes.highway(seed=3)
        frames = datasets.load_sequence("highway", seed=3)
        assert len(frames) == len(expected)
        assert len(list(cache.rglob("*.npz"))) == len(expected)
        monkeypatch.setattr(scenes, "highway", lambda seed: [None] * len(expected))
        frames = datasets.load_sequence("highway", seed=3)
        self.assert_same(frames[-1], expected[-1])
        late = frames[5:9]
        assert len(late) == 4
        self.assert_same(late[1], expected[6])
        with pytest.raises(IndexError):
            frames[len(expected)]

    @pytest.mark.parametrize("damage", ["cut", "empty", "text", "other arrays", "missing"])
    def test_a_damaged_cache_is_rebuilt(self, cache, damage):
        frames = datasets.load_sequence("highway")
        path = frames.path(2)
        whole = path.read_bytes()
        if damage == "missing":
            path.unlink()
        elif damage == "other arrays":
            np.savez(path, cloud=np.zeros((1, 4)))
        else:
            path.write_bytes({"cut": whole[:-99], "empty": b"", "text": b"hello"}[damage])
        self.assert_same(frames[2], scenes.highway()[2])
        assert path.read_bytes() == whole
        assert not [file for file in path.parent.iterdir() if file.suffix != ".npz"]

    def test_frames_are_computed_without_a_writable_cache(self, cache):
        cache.write_text("a file instead of the folder")
        self.assert_same(datasets.load_sequence("highway")[1], scenes.highway()[1])

    def test_progress_is_printed_only_in_notebooks(self, capfd):
        datasets.load_sequence("highway")
        printed, errors = capfd.readouterr()
        in_notebook = "ipykernel" in sys.modules
        assert errors == "" and ("Simulating" in printed) == in_notebook

    def test_the_error_about_an_unknown_name_lists_known_names(self):
        with pytest.raises(ValueError, match="highway, city, cyclist"):
            datasets.load_sequence("motorway")


class Server:
    """HTTP server on the loopback address.

    Each number in `breaks` truncates one response after that many bytes.
    """

    def __init__(self):
        self.files, self.breaks, self.requests, self.ranges = {}, [], [], True
        outer = self

        class Handler(BaseHTTPRequestHandler):
            def do_GET(self):
                outer.answer(self)

            def log_message(self, *_):
                pass

        self.server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.address = f"http://127.0.0.1:{self.server.server_port}"
        threading.Thread(target=self.server.serve_forever, args=[0.02], daemon=True).start()

    def answer(self, handler):
        wanted = handler.headers.get("Range") if self.ranges else None
        self.requests.append((handler.path, wanted))
        data = self.files.get(handler.path)
        if data is None:
            return handler.send_error(404)
        first = int(wanted.removeprefix("bytes=").removesuffix("-")) if wanted else 0
        if first and first >= len(data):
            handler.send_response(416)
            handler.send_header("Content-Range", f"bytes */{len(data)}")
            handler.send_header("Content-Length", "0")
            return handler.end_headers()
        handler.send_response(206 if wanted else 200)
        handler.send_header("Content-Length", str(len(data) - first))
        handler.end_headers()
        last = first + self.breaks.pop(0) if self.breaks else len(data)
        handler.wfile.write(data[first:last])


@pytest.fixture
def server():
    server = Server()
    yield server
    server.server.shutdown()
    server.server.server_close()


class TestDownload:
    data = np.random.default_rng(0).bytes(100_000)

    def test_an_interrupted_download_is_resumed(self, server, tmp_path):
        server.files["/a.bin"] = self.data
        server.breaks = [30_000, 50_000]
        checksum = hashlib.sha256(self.data).hexdigest()
        download(f"{server.address}/a.bin", tmp_path / "a.bin", checksum)
        assert (tmp_path / "a.bin").read_bytes() == self.data
        assert [wanted for _, wanted in server.requests] == [None, "bytes=30000-", "bytes=80000-"]
        download(f"{server.address}/a.bin", tmp_path / "a.bin", checksum)
        assert len(server.requests) == 3
        assert [path.name for path in tmp_path.iterdir()] == ["a.bin"]

    def test_the_next_session_resumes_a_download(self, server, tmp_path):
        server.files["/a.bin"] = self.data
        server.breaks = [30_000, 0]
        with pytest.raises(DownloadError, match="continues where it stopped"):
            download(f"{server.address}/a.bin", tmp_path / "a.bin")
        assert (tmp_path / "a.bin.part").stat().st_size == 30_000
        download(f"{server.address}/a.bin", tmp_path / "a.bin")
        assert (tmp_path / "a.bin").read_bytes() == self.data
        assert server.requests[-1] == ("/a.bin", "bytes=30000-")

    def test_a_download_without_ranges_starts_again(self, server, tmp_path):
        server.files["/a.bin"], server.ranges = self.data, False
        (tmp_path / "a.bin.part").write_bytes(b"x" * 500)
        download(f"{server.address}/a.bin", tmp_path / "a.bin")
        assert (tmp_path / "a.bin").read_bytes() == self.data

    @pytest.mark.parametrize("length", [100_000, 100_001])
    def test_a_partial_file_may_be_complete_or_too_long(self, server, tmp_path, length):
        server.files["/a.bin"] = self.data
        (tmp_path / "a.bin.part").write_bytes((self.data + b"x")[:length])
        download(f"{server.address}/a.bin", tmp_path / "a.bin")
        assert (tmp_path / "a.bin").read_bytes() == self.data

    @pytest.mark.parametrize(
        ("error", "advice"),
        [
            (
                ssl.SSLCertVerificationError("unable to get local issuer certificate"),
                "certificates",
            ),
            (urllib.error.URLError(ssl.SSLError("bad handshake")), "certificates"),
            (OSError(errno.ENOSPC, "No space left on device"), "Free some space"),
            (PermissionError(errno.EACCES, "Permission denied", "/cache"), "LIDAR_LAB_CACHE"),
            (urllib.error.URLError("Name or service not known"), "Connect to the internet"),
        ],
    )
    def test_the_advice_fits_the_cause_of_a_failure(self, tmp_path, monkeypatch, error, advice):
        def fail(*_arguments, **_options):
            raise error

        monkeypatch.setattr("urllib.request.urlopen", fail)
        with pytest.raises(DownloadError, match=advice):
            download("https://localhost/a.bin", tmp_path / "a.bin")

    def test_the_error_explains_why_a_cache_cannot_be_created(self, tmp_path, monkeypatch):
        (tmp_path / "file").touch()
        monkeypatch.setenv("LIDAR_LAB_CACHE", str(tmp_path / "file" / "cache"))
        with pytest.raises(DownloadError, match="LIDAR_LAB_CACHE"):
            datasets.fetch_recording("kitti_0002")

    def test_download_errors_are_single_sentences(self, server, tmp_path):
        server.files["/a.bin"] = self.data
        with pytest.raises(DownloadError, match="404"):
            download(f"{server.address}/b.bin", tmp_path / "b.bin")
        with pytest.raises(DownloadError, match="checksum is wrong"):
            download(f"{server.address}/a.bin", tmp_path / "a.bin", "0" * 64)
        server.server.shutdown()
        server.server.server_close()
        with pytest.raises(DownloadError, match="Connect to the internet") as caught:
            download(f"{server.address}/a.bin", tmp_path / "a.bin")
        assert str(caught.value).count("\n") == 0 and caught.value.__suppress_context__
        assert list(tmp_path.glob("*.bin")) == []


def kitti_archives():
    """Yield the address and content of each of the three zip archives of a two-frame drive."""
    scan = struct.pack("<4f", 5, 0, -1, 0.5)
    sync = "2011_09_26/2011_09_26_drive_0005_sync"
    files = {
        "calib": {"2011_09_26/calib_velo_to_cam.txt": b"R: 1\n"},
        "tracklets": {f"{sync}/tracklet_labels.xml": b"<a><tracklets></tracklets></a>"},
        "sync": {
            f"{sync}/velodyne_points/data/0000000000.bin": scan,
            f"{sync}/velodyne_points/data/0000000001.bin": scan * 2,
            f"{sync}/image_02/data/0000000000.png": b"a picture",
            "../outside.txt": b"not here",
        },
    }
    for name, members in files.items():
        buffer = io.BytesIO()
        with zipfile.ZipFile(buffer, "w") as archive:
            for path, data in members.items():
                archive.writestr(path, data)
        prefix = "" if name == "calib" else "/2011_09_26_drive_0005"
        day = "2011_09_26" if name == "calib" else "2011_09_26_drive_0005"
        yield f"{prefix}/{day}_{name}.zip", buffer.getvalue()


class TestFetchRecording:
    @pytest.fixture
    def city(self, server, monkeypatch):
        """Replace udacity_city with a small recording on the loopback server."""
        clouds = [np.full((2, 4), number, np.float32) for number in range(12)]
        names = {f"{number}.pcd": None for number in range(12)}
        for name, cloud in zip(names, clouds, strict=True):
            server.files[f"/{name}"] = encode_pcd(cloud)
        names["3.pcd"] = hashlib.sha256(server.files["/3.pcd"]).hexdigest()
        source = replace(sources.SOURCES["udacity_city"], address=server.address, files=names)
        monkeypatch.setitem(sources.SOURCES, "udacity_city", source)
        return server

    def test_a_recording_is_fetched_once_and_its_licence_is_printed(self, city, cache, capfd):
        recording = datasets.fetch_recording("udacity_city")
        printed, errors = capfd.readouterr()
        assert "CC BY-NC-SA 3.0" in printed and errors == ""
        assert [frame.cloud[0, 0] for frame in recording] == list(range(12))
        assert recording[3].time == pytest.approx(0.3) and recording[3].boxes == ()
        requests = len(city.requests)
        recording_again = datasets.fetch_recording("udacity_city")
        assert len(recording_again) == 12 and len(city.requests) == requests
        assert capfd.readouterr().out == ""

    def test_an_interrupted_recording_is_resumed(self, city, cache):
        missing = city.files.pop("/7.pcd")
        with pytest.raises(DownloadError, match=r"7\.pcd"):
            datasets.fetch_recording("udacity_city")
        city.files["/7.pcd"] = missing
        city.requests.clear()
        assert len(datasets.fetch_recording("udacity_city")) == 12
        assert [path for path, _ in city.requests] == [f"/{number}.pcd" for number in range(7, 12)]

    def test_a_drive_is_unpacked_without_pictures(self, server, cache, monkeypatch):
        server.files.update(kitti_archives())
        source = replace(sources.SOURCES["kitti_0005"], address=server.address)
        monkeypatch.setitem(sources.SOURCES, "kitti_0005", source)
        broken = server.files["/2011_09_26_drive_0005/2011_09_26_drive_0005_sync.zip"]
        server.files["/2011_09_26_drive_0005/2011_09_26_drive_0005_sync.zip"] = broken[:-30]
        with pytest.raises(DownloadError, match="not an intact archive"):
            datasets.fetch_recording("kitti_0005")
        server.files["/2011_09_26_drive_0005/2011_09_26_drive_0005_sync.zip"] = broken
        recording = datasets.fetch_recording("kitti_0005")
        assert [len(frame.cloud) for frame in recording] == [1, 2]
        names = {path.name for path in cache.rglob("*") if path.is_file()}
        assert "calib_velo_to_cam.txt" in names
        assert not [name for name in names if name.endswith((".png", ".zip", ".part"))]
        assert not list(cache.parent.rglob("outside.txt"))

    def test_the_error_about_an_unknown_name_lists_known_names(self):
        with pytest.raises(ValueError, match="udacity_city.*kitti_0005"):
            datasets.fetch_recording("waymo")

    def test_every_file_of_a_recording_has_an_https_address(self):
        urls = [
            f"{source.address}/{name}"
            for source in sources.SOURCES.values()
            for name in source.files
        ]
        assert len(urls) == 22 + 154 + 3 + 3
        assert len(set(urls)) == len(urls) - 1  # the two drives of one day share its calibration
        assert urls[0].endswith("/src/sensors/data/pcd/data_1/0000000000.pcd")
        assert all(url.startswith("https://") for url in urls)
