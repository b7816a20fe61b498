"""A pytest plugin that keeps a copy of every file that the cloud readers accept during the tests.

FOLDER_OF_CLOUDS=folder pytest -p tests.recorded_clouds tests/test_clouds_pcd.py
"""

import functools
import hashlib
import os
import shutil
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np

import utils.recordings
from utils.clouds.formats import FORMATS

FOLDER = Path(os.environ["FOLDER_OF_CLOUDS"])


def saving(decode: Callable, suffix: str) -> Callable:
    """Return a decoder that also saves the bytes that it can decode."""

    @functools.wraps(decode)
    def decode_and_keep(data: bytes, name: str = f"cloud{suffix}") -> np.ndarray:
        cloud = decode(data, name)
        (FOLDER / f"{hashlib.sha1(data).hexdigest()[:12]}{suffix}").write_bytes(data)
        return cloud

    return decode_and_keep


@functools.wraps(utils.recordings.read_bag)
def read_and_keep_bag(path: str | os.PathLike, topic: str | None = None) -> utils.recordings.Bag:
    """Open a recording, and copy it if it is a single file."""
    bag = utils.recordings.rosbag.read_bag(path, topic)
    if Path(path).is_file():
        shutil.copy(path, FOLDER / f"{len(os.listdir(FOLDER))}_{Path(path).name}")
    return bag


# Replace the readers before the tests import them. If several suffixes share a reader, the loop
# ends with the first suffix, so tests that call the reader directly save files with that suffix.
for suffix, form in reversed(list(FORMATS.items())):
    kept = saving(form.decode, suffix)
    setattr(sys.modules[form.decode.__module__], kept.__name__, kept)
    FORMATS[suffix] = form._replace(decode=kept)
utils.recordings.read_bag = read_and_keep_bag
