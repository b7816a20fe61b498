"""KITTI labels, calibration and raw drives, read from small folders that the tests write."""

import csv
import os
from pathlib import Path

import numpy as np
import pytest

from tests.prerequisites import RECORDINGS
from utils.boxes import Box, inside
from utils.clouds import CloudFileError, read_cloud, write_cloud
from utils.recordings import (
    read_calibration,
    read_kitti_raw,
    read_object_labels,
    read_tracking_labels,
    read_tracklets,
)

REAL = Path(os.environ.get("REAL_CLOUDS", "/nowhere"))

# A camera 27 cm ahead of and 8 cm below the scanner, looking straight ahead.
# Its x axis is our -y, its y axis our -z, and its z axis our x.
MOUNTING = "0 -1 0 0 0 0 -1 -0.08 1 0 0 -0.27"
IDENTITY = "1 0 0 0 1 0 0 0 1"
P2 = "700 0 600 45 0 700 180 -0.3 0 0 1 0.005"
OBJECT_CALIBRATION = f"P2: {P2}\nR0_rect: {IDENTITY}\nTr_velo_to_cam: {MOUNTING}\n\n"
TRACKING_CALIBRATION = f"P2: {P2}\nR_rect {IDENTITY}\nTr_velo_cam {MOUNTING}\n"

# A car of 4 x 1.6 x 1.5 m, seen from behind (at KITTI's rotation -pi/2, a car points along the
# camera's z axis). The centre of its floor is 10 m ahead of the scanner, 2 m to the left and 1.73 m
# below.
CAR = "Car 0.00 0 1.9 500 150 600 250 1.5 1.6 4.0 -2.0 1.65 9.73 -1.5707963"
WALKER = "Pedestrian 0.00 0 0 500 150 600 250 1.8 0.6 0.5 3.0 1.65 19.73 0"
IGNORED = "DontCare -1 -1 -10 503 169 590 190 -1 -1 -1 -1000 -1000 -1000 -10"


@pytest.fixture
def calibration(tmp_path):
    (tmp_path / "calib.txt").write_text(OBJECT_CALIBRATION)
    return read_calibration(tmp_path / "calib.txt")


def error_message(call, *arguments):
    with pytest.raises(CloudFileError) as caught:
        call(*arguments)
    return str(caught.value)


def test_all_three_kinds_of_calibration_agree(tmp_path, calibration):
    (tmp_path / "tracking.txt").write_text(TRACKING_CALIBRATION)
    (tmp_path / "calib_cam_to_cam.txt").write_text(
        f"calib_time: 09-Jan-2012 13:57:47\nS_00: 1 2\nR_rect_00: {IDENTITY}\nP_rect_02: {P2}\n"
    )
    (tmp_path / "calib_velo_to_cam.txt").write_text(
        "calib_time: 15-Mar-2012 11:37:16\nR: 0 -1 0 0 0 -1 1 0 0\nT: 0 -0.08 -0.27\ndelta_f: 0 0\n"
    )
    for other in (read_calibration(tmp_path / "tracking.txt"), read_calibration(tmp_path)):
        np.testing.assert_array_equal(other.camera_from_sensor, calibration.camera_from_sensor)
        np.testing.assert_array_equal(other.projection, calibration.projection)
    ahead = calibration.camera_from_sensor @ (10, 2, -1, 1)
    np.testing.assert_allclose(ahead, [-2, 0.92, 9.73, 1])


def test_errors_explain_invalid_calibration(tmp_path):
    path = tmp_path / "calib.txt"
    assert "calib.txt" in error_message(read_calibration, path)
    path.write_text(TRACKING_CALIBRATION.replace("R_rect", "Q_rect"))
    assert "no line R0_rect or R_rect" in error_message(read_calibration, path)
    path.write_text(OBJECT_CALIBRATION.replace("-0.27", ""))
    assert "line 3" in error_message(read_calibration, path)
    for nonsense in ("0", "nan", "inf", "1e9991", "-1e300"):
        path.write_text(OBJECT_CALIBRATION.replace("1 0 0", f"{nonsense} 0 0", 1))
        assert "rotation" in error_message(read_calibration, path)
    assert "calib_velo_to_cam.txt" in error_message(read_calibration, tmp_path)


def test_object_labels_become_boxes_in_sensor_coordinates(tmp_path, calibration):
    path = tmp_path / "000008.txt"
    path.write_text(f"{CAR}\n{IGNORED}\n{WALKER} 0.9\n\n")
    car, walker = read_object_labels(path, calibration)
    assert (car.kind, walker.kind) == ("car", "pedestrian")
    assert (car.identity, walker.identity) == (0, 1)
    np.testing.assert_allclose(car.centre, [10, 2, -1.73 + 0.75], atol=1e-6)
    np.testing.assert_allclose(walker.centre, [20, -3, -1.73 + 0.9], atol=1e-6)
    assert car.size == (4.0, 1.6, 1.5)
    assert car.yaw == pytest.approx(0, abs=1e-6)
    assert abs(walker.yaw) == pytest.approx(np.pi / 2)
    assert np.isnan(car.velocity).all() and car.returns == 0


@pytest.mark.parametrize("rotation", [-3.0, -1.5, -0.3, 0.0, 0.7, 2.2])
def test_yaw_has_the_opposite_sign_of_kitti_rotation(tmp_path, calibration, rotation):
    path = tmp_path / "000000.txt"
    path.write_text(CAR.replace("-1.5707963", str(rotation)))
    (car,) = read_object_labels(path, calibration)
    difference = car.yaw - (-rotation - np.pi / 2)
    assert np.cos(difference) == pytest.approx(1)


def test_tracking_labels_are_grouped_by_frame_with_track_ids(tmp_path, calibration):
    path = tmp_path / "0000.txt"
    path.write_text(f"0 4 {CAR}\n0 -1 {IGNORED}\n2 4 {CAR}\n2 7 {WALKER}\n")
    frames = read_tracking_labels(path, calibration)
    assert {frame: [box.identity for box in boxes] for frame, boxes in frames.items()} == {
        0: [4],
        2: [4, 7],
    }
    np.testing.assert_allclose(frames[2][0].centre, [10, 2, -0.98], atol=1e-6)


@pytest.mark.parametrize(
    ("text", "part"),
    [
        (f"0 4 {CAR}", "17 columns"),
        (f"{CAR}\nCar 1 2", "line 2"),
        (CAR.replace("9.73", "far"), "line 1"),
        (CAR.replace("9.73", "nan"), "line 1"),
    ],
)
def test_errors_explain_invalid_labels(tmp_path, calibration, text, part):
    path = tmp_path / "000008.txt"
    path.write_text(text)
    message = error_message(read_object_labels, path, calibration)
    assert "000008.txt" in message and part in message


TRACKLETS = """<?xml version="1.0" encoding="UTF-8" standalone="yes" ?>
<!DOCTYPE boost_serialization>
<boost_serialization signature="serialization::archive" version="9">
<tracklets class_id="0" tracking_level="0" version="0">
  <count>1</count><item_version>1</item_version>
  <item class_id="1" tracking_level="0" version="1">
    <objectType>Cyclist</objectType><h>1.75</h><w>0.6</w><l>1.8</l><first_frame>1</first_frame>
    <poses class_id="2" tracking_level="0" version="0">
      <count>3</count><item_version>2</item_version>
      <item><tx>5.0</tx><ty>1</ty><tz>-1.7</tz><rx>0</rx><ry>0</ry><rz>0.25</rz></item>
      <item><tx>5.5</tx><ty>1</ty><tz>-1.7</tz><rx>0</rx><ry>0</ry><rz>0.5</rz></item>
      <item><tx>6.0</tx><ty>1</ty><tz>-1.7</tz><rx>0</rx><ry>0</ry><rz>0.75</rz></item>
    </poses><finished>1</finished>
  </item>
</tracklets></boost_serialization>
"""


@pytest.fixture
def drive(tmp_path):
    folder = tmp_path / "2011_09_26_drive_0005_sync"
    data = folder / "velodyne_points" / "data"
    data.mkdir(parents=True)
    for frame in (0, 1, 3):  # some of KITTI's drives lack scans
        points = [(5.9, 1, -1, 0.5), (5.9, 1, 0.1, 0.5), (0, 0, 0, 0)]  # inside, above, invalid
        write_cloud(data / f"{frame:010d}.bin", points)
    (folder / "velodyne_points" / "timestamps.txt").write_text(
        "".join(f"2011-09-26 13:02:{59.9 + k / 10 - 60 * (k > 0):012.9f}\n".replace(":02:", minute)
                for k, minute in enumerate([":02:", ":03:", ":03:", ":03:"]))
    )  # fmt: skip
    (folder / "tracklet_labels.xml").write_text(TRACKLETS)
    return folder


def test_a_drive_has_frames_with_boxes_and_times(drive):
    recording = read_kitti_raw(drive)
    assert len(recording) == 3
    np.testing.assert_allclose(recording.times, [0, 0.1, 0.3], atol=1e-6)
    assert [len(frame.boxes) for frame in recording] == [0, 1, 1]
    frame = recording[2]
    assert frame.cloud.shape == (3, 4) and frame.time == pytest.approx(0.3)
    (box,) = frame.boxes
    assert box.kind == "cyclist" and box.size == (1.8, 0.6, 1.75) and box.yaw == 0.75
    np.testing.assert_allclose(box.centre, [6.0, 1, -1.7 + 1.75 / 2])
    assert box.returns == 1
    assert [frame.time for frame in recording[1:]] == pytest.approx([0.1, 0.3])


def test_tracklets_and_times_are_optional(drive):
    (drive / "tracklet_labels.xml").unlink()
    (drive / "velodyne_points" / "timestamps.txt").unlink()
    recording = read_kitti_raw(drive)
    assert recording[2].boxes == () and recording[2].time == pytest.approx(0.3)


def test_text_scans_and_a_byte_order_mark_before_the_times_are_read(drive):
    """KITTI's unsynchronised drives contain text, and some editors write the mark."""
    data, times = drive / "velodyne_points" / "data", drive / "velodyne_points" / "timestamps.txt"
    times.write_bytes(b"\xef\xbb\xbf" + times.read_bytes())
    expected = [frame.cloud for frame in read_kitti_raw(drive)]
    for path in data.glob("*.bin"):
        write_cloud(path.with_suffix(".txt"), read_cloud(path))
        path.unlink()
    recording = read_kitti_raw(drive)
    np.testing.assert_allclose(recording.times, [0, 0.1, 0.3], atol=1e-6)
    for frame, cloud in zip(recording, expected, strict=True):
        np.testing.assert_allclose(frame.cloud, cloud, rtol=1e-7)  # text has no float32


def test_errors_explain_invalid_drives(drive):
    assert "2011_09_26_drive_0005_sync" in error_message(read_kitti_raw, drive.parent)
    assert "no files" in error_message(read_kitti_raw, drive / "none")
    unnumbered = drive / "velodyne_points" / "data" / "first.bin"
    unnumbered.touch()
    assert "frame number" in error_message(read_kitti_raw, drive)
    unnumbered.unlink()
    times = drive / "velodyne_points" / "timestamps.txt"
    times.write_text("2011-09-26 13:02:59.9\nnoon\n")
    assert "timestamps.txt, line 2" in error_message(read_kitti_raw, drive)
    tracklets = drive / "tracklet_labels.xml"
    for text in ("", "<a>", TRACKLETS[:600], TRACKLETS.replace("5.5", "far"),
                 TRACKLETS.replace("5.5", "nan"), TRACKLETS.replace("<l>1.8</l>", ""),
                 TRACKLETS.replace("boost_serialization>", 'b [<!ENTITY a "b">]>', 1)):  # fmt: skip
        tracklets.write_text(text)
        assert "tracklet_labels.xml" in error_message(read_tracklets, tracklets)


def test_points_on_the_faces_of_a_turned_box_are_inside():
    box = Box(centre=(1, 2, 3), size=(4, 2, 1), yaw=np.pi / 2, kind="car", identity=1)
    points = np.array([[1, 2, 3], [2, 4, 3.5], [2.1, 2, 3], [1, 4.1, 3], [1, 2, 3.6]])
    assert inside(points, box).tolist() == [True, True, False, False, False]
    assert inside(np.empty((0, 4)), box).shape == (0,)


@pytest.mark.skipif(not REAL.is_dir(), reason=RECORDINGS)
def test_real_boxes_contain_as_many_points_as_their_table_states():
    frame = read_cloud(REAL / "kitti_000008.bin")
    with open(REAL / "kitti_000008_boxes.csv", newline="") as file:
        for row in csv.DictReader(file):
            value = {key: float(text) for key, text in row.items()}
            box = Box(
                centre=(value["cx"], value["cy"], value["cz"]),
                size=(value["l"], value["w"], value["h"]),
                yaw=value["yaw"], kind="car", identity=0,
            )  # fmt: skip
            # The table rounds the centre to millimetres and the yaw to milliradians.
            assert inside(frame, box).sum() == pytest.approx(value["npts"], rel=0.02, abs=2)
