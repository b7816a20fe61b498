"""KITTI's labels and calibration files: boxes in the laser scanner's coordinates.

KITTI labels objects in the rectified camera frame: x right, y down, z forward, the position at
the centre of the box's bottom face, angles about the downward axis. The readers convert them to
the course's convention: x forward, y left, z up, the centre of the box, yaw about the upward axis.

Sources: the readme files of the object, tracking and raw data development kits,
https://www.cvlibs.net/datasets/kitti; Geiger et al., "Vision meets robotics: the KITTI dataset",
IJRR 2013.
"""

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from utils.boxes import Box
from utils.clouds.errors import excerpt, file_error, read_bytes

UNKNOWN = (float("nan"),) * 2  # KITTI does not label velocities


@dataclass(frozen=True, eq=False)
class Calibration:
    """Pose of the left colour camera relative to the laser scanner.

    Attributes
    ----------
    camera_from_sensor : ndarray, shape (4, 4)
        Transforms homogeneous scanner coordinates to the rectified camera frame, in metres.
    projection : ndarray, shape (3, 4)
        Maps homogeneous rectified camera coordinates to pixels of the left colour image.
    """

    camera_from_sensor: np.ndarray
    projection: np.ndarray


def read_calibration(path: str | os.PathLike) -> Calibration:
    """Read the calibration between camera and scanner.

    Parameters
    ----------
    path : str or path
        A calibration file of the object or tracking benchmark, or the folder of a day of raw data
        (with ``calib_cam_to_cam.txt`` and ``calib_velo_to_cam.txt``).

    Raises
    ------
    CloudFileError
        A file or an entry is missing or malformed.
    """
    path = Path(path)
    if path.is_dir():
        cameras = path / "calib_cam_to_cam.txt"
        scanner = path / "calib_velo_to_cam.txt"
        rotation = _matrix(scanner, ["R"], (3, 3))
        mounting = np.column_stack([rotation, _matrix(scanner, ["T"], (3,))])
        rectification = _matrix(cameras, ["R_rect_00"], (3, 3))
        projection = _matrix(cameras, ["P_rect_02"], (3, 4))
    else:
        mounting = _matrix(path, ["Tr_velo_to_cam", "Tr_velo_cam"], (3, 4))
        rectification = _matrix(path, ["R0_rect", "R_rect"], (3, 3))
        projection = _matrix(path, ["P2"], (3, 4))
    with np.errstate(all="ignore"):  # the file may contain NaN or huge numbers
        camera_from_sensor = np.vstack([rectification @ mounting, [0, 0, 0, 1]])
        turn = camera_from_sensor[:3, :3]
        turns = np.allclose(turn @ turn.T, np.eye(3), atol=0.01)
    if not turns:
        raise file_error(
            path,
            "",
            "the matrices do not describe a rotation",
            "Download the calibration file again.",
        )
    return Calibration(camera_from_sensor, projection)


def read_object_labels(path: str | os.PathLike, calibration: Calibration) -> tuple:
    """Read a label file of the object benchmark (``label_2/000008.txt``).

    Parameters
    ----------
    path : str or path
    calibration : Calibration
        Calibration of the same frame.

    Returns
    -------
    tuple of utils.boxes.Box
        Boxes in sensor coordinates. The kind is KITTI's class in lower case; the identity is the
        object's index, from 0. The velocity is NaN and the number of returns 0, because the file
        does not contain them. Regions marked DontCare are left out.

    Raises
    ------
    CloudFileError
        A line is not a label; the message names it.
    """
    rows = _label_rows(Path(path), columns=15)
    return tuple(
        _box(words[0], index, numbers, calibration) for index, (words, numbers) in enumerate(rows)
    )


def read_tracking_labels(path: str | os.PathLike, calibration: Calibration) -> dict[int, tuple]:
    """Read a label file of the tracking benchmark (``label_02/0000.txt``).

    Parameters and errors are the same as for `read_object_labels`.

    Returns
    -------
    dict of int to tuple of utils.boxes.Box
        The boxes of each frame that has any; the identity is KITTI's track ID.
    """
    frames: dict[int, tuple] = {}
    for words, numbers in _label_rows(Path(path), columns=17):
        frame, track = int(float(words[0])), int(float(words[1]))
        frames[frame] = (*frames.get(frame, ()), _box(words[2], track, numbers, calibration))
    return frames


def _label_rows(path: Path, columns: int) -> list[tuple[list[str], list[float]]]:
    """Return the words and the seven numbers h w l x y z rotation of each line of a label file.

    Benchmark results have an additional column for the score, which is ignored.
    """
    rows = []
    for line, text in enumerate(read_bytes(path, (".txt",)).decode("latin-1").splitlines(), 1):
        words = text.split()
        kind = columns - 15  # column of the class, which follows frame and track if there are any
        if len(words) not in (0, columns, columns + 1):
            raise file_error(
                path,
                f"line {line}",
                f"found {len(words)} columns, expected the {columns} of a KITTI label",
                "Use read_object_labels for object labels and read_tracking_labels for tracking "
                "labels.",
            )
        if not words or words[kind] == "DontCare":
            continue
        try:
            numbers = [float(word) for word in words[:kind] + words[kind + 1 : columns]]
        except ValueError:
            numbers = [float("nan")]
        if not np.isfinite(numbers).all():
            raise file_error(
                path,
                f"line {line}",
                f"found {excerpt(text)}, expected numbers around the class name",
                "Correct or delete the line.",
            )
        rows.append((words, numbers[-7:]))
    return rows


def _box(kind: str, identity: int, numbers: list[float], calibration: Calibration) -> Box:
    """Convert height, width, length, position and rotation in the camera frame to a box."""
    height, width, length, x, y, z, rotation = numbers
    sensor_from_camera = np.linalg.inv(calibration.camera_from_sensor)
    centre = sensor_from_camera @ (x, y - height / 2, z, 1)
    heading = sensor_from_camera[:3, :3] @ (np.cos(rotation), 0, -np.sin(rotation))
    return Box(
        centre=tuple(centre[:3].tolist()),
        size=(length, width, height),
        yaw=float(np.arctan2(heading[1], heading[0])),
        kind=kind.lower(),
        identity=identity,
        velocity=UNKNOWN,
        returns=0,
    )


def _matrix(path: Path, names: list[str], shape: tuple[int, ...]) -> np.ndarray:
    """Read the matrix in the line that begins with one of the names; a colon may follow it."""
    for line, text in enumerate(read_bytes(path, (".txt",)).decode("latin-1").splitlines(), 1):
        words = text.split()
        if words and words[0].rstrip(":") in names:
            try:
                return np.array([float(word) for word in words[1:]]).reshape(shape)
            except ValueError:
                count = int(np.prod(shape))
                raise file_error(
                    path,
                    f"line {line}",
                    f"found {excerpt(text)}, expected {count} numbers",
                    "Download the calibration file again.",
                ) from None
    raise file_error(
        path,
        "",
        f"there is no line {' or '.join(names)}, expected a KITTI calibration file",
        "Pass the calibration file that belongs to the scans.",
    )
