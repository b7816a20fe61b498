"""Folders of clouds as lazy sequences in natural order (frame2 before frame10)."""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from utils.clouds.errors import file_error
from utils.clouds.formats import SUFFIXES, read_cloud


@dataclass(frozen=True)
class CloudFolder(Sequence):
    """A lazy sequence of the clouds in some files; each access reads one file.

    Attributes
    ----------
    paths : tuple of Path
        One file per cloud, in order.
    """

    paths: tuple[Path, ...]

    def __len__(self) -> int:
        return len(self.paths)

    def __getitem__(self, index: int | slice) -> np.ndarray | CloudFolder:
        """Read cloud `index`, or return a lazy sequence for a slice."""
        if isinstance(index, slice):
            return CloudFolder(self.paths[index])
        return read_cloud(self.paths[index])


def read_sequence(folder: str | os.PathLike, suffix: str | None = None) -> CloudFolder:
    """Open a folder of clouds as a lazy sequence in natural order (frame2 before frame10).

    Parameters
    ----------
    folder : str or path
        Folder of files that `read_cloud` reads; its subfolders are not searched.
    suffix : str, optional
        Suffix of the files to read, for instance ``".pcd"``; required if there are several.

    Returns
    -------
    CloudFolder
        Each access reads a cloud of shape (n, 3) or (n, 4).

    Raises
    ------
    CloudFileError
        The folder does not exist, or contains no clouds or clouds of several kinds.
    """
    folder = Path(folder)
    if folder.is_file():
        raise file_error(
            folder,
            "",
            "found a file, expected a folder of clouds",
            "Read one cloud with read_cloud.",
        )
    if not folder.is_dir():
        raise file_error(
            folder, "", f"there is no folder {folder.absolute()}", "Check the spelling."
        )
    wanted = SUFFIXES if suffix is None else (suffix.lower(),)
    paths = sorted(
        (
            path
            for path in folder.iterdir()
            if path.suffix.lower() in wanted and not path.name.startswith(".") and path.is_file()
        ),
        key=natural_order,
    )
    kinds = Counter(path.suffix.lower() for path in paths)
    if not paths:
        raise file_error(
            folder,
            "",
            f"no {' or '.join(wanted)} file in {folder.absolute()}",
            "Pass the folder that contains the frames themselves.",
        )
    if len(kinds) > 1:
        counts = " and ".join(f"{count} {kind}" for kind, count in kinds.most_common())
        raise file_error(
            folder,
            "",
            f"the folder contains {counts} files, expected one kind",
            f'Choose one kind, for instance suffix="{kinds.most_common(1)[0][0]}".',
        )
    return CloudFolder(tuple(paths))


def natural_order(path: Path) -> tuple[list, str]:
    """Return a sort key that puts frame2 before frame10."""
    pieces = re.split(r"([0-9]+)", path.name.lower())
    numbered = [int(piece) if index % 2 else piece for index, piece in enumerate(pieces)]
    return numbered, path.name
