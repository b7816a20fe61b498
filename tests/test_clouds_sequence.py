"""Folders of clouds: natural order, lazy reading, and errors about unsuitable folders."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from utils.clouds import CloudFileError, read_sequence, write_cloud
from utils.clouds.sequence import natural_order


def fill(folder: Path, names) -> Path:
    for value, name in enumerate(names):
        write_cloud(folder / name, np.full((value + 1, 3), value, float))
    return folder


def test_frames_are_in_natural_order(tmp_path):
    fill(tmp_path, ["frame10.txt", "frame2.txt", "Frame1.txt", "._frame1.txt"])
    (tmp_path / "readme.md").write_text("hello")
    (tmp_path / "frame3.txt").mkdir()
    frames = read_sequence(tmp_path)
    assert isinstance(frames, Sequence)
    assert [path.name for path in frames.paths] == ["Frame1.txt", "frame2.txt", "frame10.txt"]
    assert [cloud[0, 0] for cloud in frames] == [2, 1, 0]
    assert frames[-1].shape == (1, 3)
    assert [len(cloud) for cloud in frames[1:]] == [2, 1]
    with pytest.raises(IndexError):
        frames[3]


def test_mixed_names_are_in_natural_order():
    names = ["b1", "a10", "a9", "a09", "10", "9", "a", "a1b2", "a1b10"]
    ordered = sorted(map(Path, names), key=natural_order)
    assert [path.name for path in ordered] == [
        "9", "10", "a", "a1b2", "a1b10", "a09", "a9", "a10", "b1"
    ]  # fmt: skip


def test_files_are_read_only_when_indexed(tmp_path):
    fill(tmp_path, ["1.txt", "2.txt"])
    (tmp_path / "2.txt").write_text("broken")
    frames = read_sequence(tmp_path)
    assert len(frames) == 2 and frames[0].shape == (1, 3)
    with pytest.raises(CloudFileError, match=r"2\.txt"):
        frames[1]


def test_errors_explain_unsuitable_folders(tmp_path):
    def message(*arguments, **options):
        with pytest.raises(CloudFileError) as caught:
            read_sequence(*arguments, **options)
        return str(caught.value)

    assert "no .txt or" in message(tmp_path)
    assert "there is no folder" in message(tmp_path / "none")
    fill(tmp_path, ["1.txt", "2.txt", "1.pcd"])
    assert "2 .txt and 1 .pcd" in message(tmp_path) and 'suffix=".txt"' in message(tmp_path)
    assert len(read_sequence(tmp_path, suffix=".PCD")) == 1
    assert "no .bin file" in message(tmp_path, suffix=".bin")
    assert "read_cloud" in message(tmp_path / "1.txt")
