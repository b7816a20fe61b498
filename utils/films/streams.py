"""Write streams for other viewers: .rrd files for Rerun, .mcap files for Foxglove and RViz.

Each frame has the scan, its ground and clusters, boxes with track IDs, the true boxes if they are
known, and the decision of a simulated car. https://rerun.io, https://foxglove.dev
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from utils.boxes import distance_outside
from utils.drive.steps import is_road

if TYPE_CHECKING:
    from utils.films.frames import DetectedFrame

OUTLINE = [0, 1, 2, 3, 0, 4, 5, 6, 7, 4, 5, 1, 2, 6, 7, 3]
"""A path through the corners of a box along all of its edges."""

COLOURS = {"scan": (150, 150, 150), "ground": (150, 110, 70), "clusters": None,
           "boxes": (0, 114, 178), "true_boxes": (230, 159, 0)}  # fmt: skip
"""Red, green and blue of each layer; clusters have a colour for each track ID."""


def write_stream(path: Path, frames: Iterable[DetectedFrame]) -> None:
    """Write frames to a file for other viewers, completely or not at all.

    Parameters
    ----------
    path : Path
        Ends in .rrd (Rerun) or .mcap (Foxglove and RViz, as ROS 2 messages).
    frames : iterable of utils.films.DetectedFrame

    Raises
    ------
    ValueError
        The package for Rerun is not installed.
    """
    with tempfile.TemporaryDirectory(dir=path.parent, prefix=".") as folder:
        unfinished = Path(folder) / path.name
        STREAM_WRITERS[path.suffix](unfinished, frames)
        unfinished.replace(path)


def clouds_of(frame: DetectedFrame) -> dict[str, np.ndarray]:
    """Return the finite points of a frame by layer: ``scan``, ``ground`` and ``clusters``.

    The ground is the points near a fitted plane. A cluster is the other points in a box; its last
    column is the label of the box: the track ID or, if there is none, the position from 1.
    """
    cloud = frame.cloud[np.isfinite(frame.cloud[:, :3]).all(axis=1)]
    ground, clusters = is_road(cloud[:, :3]), []
    boxes = _outlines(frame)["boxes" if frame.boxes is not None else "true_boxes"]
    for box, label in zip(*boxes, strict=True):
        above = (box[:, 2].min() <= cloud[:, 2]) & (cloud[:, 2] <= box[:, 2].max()) & ~ground
        members = cloud[above & (distance_outside(cloud[:, :2], box[:4, :2]) <= 0)]
        clusters.append(np.column_stack([members, np.full(len(members), label)]))
    empty = np.empty((0, cloud.shape[1] + 1))
    return {"scan": cloud, "ground": cloud[ground], "clusters": np.vstack([empty, *clusters])}


def _outlines(frame: DetectedFrame) -> dict[str, tuple[np.ndarray, list[int]]]:
    """Return the corners (N, 8, 3) and labels of the detected and the true boxes."""
    true = np.reshape([box.corners for box in frame.true_boxes], (-1, 8, 3))
    found = np.empty((0, 8, 3)) if frame.boxes is None else frame.boxes
    labels = frame.track_ids if frame.track_ids is not None else range(1, len(found) + 1)
    return {
        "boxes": (found, list(labels)),
        "true_boxes": (true, [box.identity for box in frame.true_boxes]),
    }


def _write_rrd(path: Path, frames: Iterable[DetectedFrame]) -> None:
    try:
        import rerun
    except ImportError:
        raise ValueError(
            "Writing .rrd files needs the package rerun-sdk. Install it with: "
            "pip install rerun-sdk. An .mcap file needs no other package."
        ) from None
    stream = rerun.RecordingStream("lidar_obstacle_lab")
    stream.set_log_time_enabled(False)  # only the time of the scanner counts
    stream.set_log_tick_enabled(False)
    stream.save(path)
    try:
        stream.log("lidar", rerun.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        for frame in frames:
            stream.set_time("time", duration=frame.time)
            for layer, cloud in clouds_of(frame).items():
                ids = cloud[:, -1].astype(np.uint16) if layer == "clusters" else None
                points = rerun.Points3D(cloud[:, :3], colors=COLOURS[layer], class_ids=ids)
                stream.log(f"lidar/{layer}", points)
            for layer, (boxes, labels) in _outlines(frame).items():
                stream.log(
                    f"lidar/{layer}",
                    rerun.LineStrips3D(
                        boxes[:, OUTLINE], colors=COLOURS[layer], labels=list(map(str, labels))
                    ),
                )
            if frame.decision:
                stream.log("decision", rerun.TextLog(frame.decision))
    finally:
        stream.disconnect()


def _write_mcap(path: Path, frames: Iterable[DetectedFrame]) -> None:
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store, connections = get_typestore(Stores.ROS2_HUMBLE), {}
    folder = path.with_suffix("")  # rosbags writes a folder with metadata, which no viewer needs
    with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        for frame in frames:
            for topic, message in _messages(frame, store.types):
                kind = message.__msgtype__
                if topic not in connections:
                    connections[topic] = writer.add_connection(topic, kind, typestore=store)
                data = store.serialize_cdr(message, kind)
                writer.write(connections[topic], round(1e9 * frame.time), data)
    next(folder.glob("*.mcap")).replace(path)


def _messages(frame: DetectedFrame, types: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yield the topics and ROS 2 messages for a frame."""
    seconds, nanoseconds = divmod(round(1e9 * frame.time), 10**9)
    stamp = types["builtin_interfaces/msg/Time"](seconds, nanoseconds)
    header = types["std_msgs/msg/Header"](stamp, "lidar")
    for layer, cloud in clouds_of(frame).items():
        names = ["x", "y", "z", "intensity"][: cloud.shape[1]]
        if layer == "clusters":
            names[cloud.shape[1] - 1 :] = ["track_id"]
        make_field = types["sensor_msgs/msg/PointField"]
        fields = [make_field(name, 4 * place, 7, 1) for place, name in enumerate(names)]
        data = np.ascontiguousarray(cloud, "<f4").view(np.uint8).ravel()
        step = 4 * len(names)
        yield (
            f"/{layer}",
            types["sensor_msgs/msg/PointCloud2"](
                header, 1, len(cloud), fields, False, step, step * len(cloud), data, True
            ),
        )
    for layer, (boxes, labels) in _outlines(frame).items():
        yield f"/{layer}", _markers(header, boxes, labels, COLOURS[layer], types)
    if frame.decision:
        yield "/decision", types["std_msgs/msg/String"](frame.decision)


def _markers(
    header: Any,
    boxes: np.ndarray,
    labels: list[int],
    colour: tuple[int, ...],
    types: dict[str, Any],
) -> Any:
    """Return a MarkerArray that deletes the previous boxes, and draws each box with its label."""
    kind, point = types["visualization_msgs/msg/Marker"], types["geometry_msgs/msg/Point"]
    turn = types["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0)
    scale = types["geometry_msgs/msg/Vector3"](0.05, 0.0, 0.8)  # width of lines, height of letters
    ink = types["std_msgs/msg/ColorRGBA"](*(value / 255 for value in colour), 1.0)
    always = types["builtin_interfaces/msg/Duration"](0, 0)
    image = types["sensor_msgs/msg/CompressedImage"](header, "", np.empty(0, np.uint8))
    mesh = types["visualization_msgs/msg/MeshFile"]("", np.empty(0, np.uint8))

    def marker(number: int, shape: int, action: int, place: list, path: list, text: str) -> Any:
        pose = types["geometry_msgs/msg/Pose"](point(*place), turn)
        return kind(
            header, "", number, shape, action, pose, scale, ink, always, False,
            [point(*corner) for corner in path], [], "", image, [], text, "", mesh, False,
        )  # fmt: skip

    origin = [0.0, 0.0, 0.0]
    made = [marker(0, kind.LINE_STRIP, kind.DELETEALL, origin, [], "")]
    for number, (box, label) in enumerate(zip(boxes, labels, strict=True)):
        above = [*box[:, :2].mean(axis=0).tolist(), float(box[:, 2].max()) + 0.5]
        edges = box[OUTLINE].tolist()
        made.append(marker(2 * number, kind.LINE_STRIP, kind.ADD, origin, edges, ""))
        made.append(marker(2 * number + 1, kind.TEXT_VIEW_FACING, kind.ADD, above, [], str(label)))
    return types["visualization_msgs/msg/MarkerArray"](made)


STREAM_WRITERS = {".rrd": _write_rrd, ".mcap": _write_mcap}
"""Functions that write a stream, by file suffix."""
