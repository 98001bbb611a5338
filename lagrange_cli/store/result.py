"""``Result``: a finished output of ``solve``, ``sweep`` or ``section``, read in parts.

Only a file that holds a record of this program (see ``trusted``) is opened with the HDF5 library, and of what
it holds only plain datasets of numbers and texts are read: no links to elsewhere, no virtual or external
storage, no chunk that takes more memory than this program ever gives one.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from lagrange_cli.errors import FileError
from lagrange_cli.records import dataclass
from lagrange_cli.store.trusted import check_readable, read_record

MOST_NAMES = 100_000
LARGEST_CHUNK = 2**28
"""Bounds on what is read: datasets, and bytes of a chunk."""
KINDS = "fiuSOU"
HIDDEN = ("checkpoint",)
"""Datasets that are not for readers."""


@dataclass(frozen=True)
class Held:
    """What a file holds under a path: its shape, the names of its axes, its unit and what it is."""

    shape: tuple[int, ...]
    axes: tuple[str, ...]
    unit: str
    meaning: str
    chunk: int


class Result:
    """The datasets of an output by path, of which parts are read; close it, or use it in ``with``.

    Raises ``FileError`` where the file cannot be read or is no output of this program.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.solved_for_this = False
        """Whether all that is wanted of it was asked for when it was made: what it lacks does not exist."""
        self._links: dict[str, str] = {}
        path = Path(os.path.realpath(name))
        if not path.exists():
            raise FileError(f"{name}: no such file")
        check_readable(path, name)
        try:
            read_record(path, name)
            self._file = h5py.File(path, "r")
        except BlockingIOError as error:  # HDF5 locks what it writes to
            raise FileError(f"{name} is open for writing in another program: close it there") from error
        except (OSError, RuntimeError, FileError) as error:
            raise foreign(name) from error
        try:
            self.attributes = {key: plain(value) for key, value in self._file.attrs.items()}
            self.held: Mapping[str, Held] = dict(self._walk(self._file, ""))
        except (OSError, RuntimeError, KeyError, TypeError, ValueError) as error:
            self.close()
            raise foreign(name) from error

    def __enter__(self) -> Result:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Nothing more is read."""
        self._file.close()

    def _walk(self, group: Any, above: str) -> list[tuple[str, Held]]:
        """Everything that is a plain dataset, in the order of the file."""
        found: list[tuple[str, Held]] = []
        for name in group:
            link = group.get(name, getlink=True)
            if isinstance(link, h5py.SoftLink):
                self._links[f"{above}{name}"] = str(link.path).lstrip("/")
            if not isinstance(link, h5py.HardLink) or name in HIDDEN:
                continue
            item, path = group[name], f"{above}{name}"
            if isinstance(item, h5py.Group) and path.count("/") < 8:
                found += self._walk(item, f"{path}/")
            elif isinstance(item, h5py.Dataset) and readable(item):
                found.append((path, described(item)))
            if len(found) > MOST_NAMES:
                raise foreign(self.name)
        return found

    @property
    def title(self) -> str:
        """The name of the system."""
        return str(self.attributes.get("name", ""))

    @property
    def kind(self) -> str:
        """``motion``, ``sweep`` or ``section``."""
        if "where" in self.attributes or "every" in self.attributes:
            return "section"
        return "sweep" if "sweep" in self.attributes else "motion"

    def within(self, folder: str) -> dict[str, str]:
        """The paths in a folder by what follows it."""
        return {path[len(folder) :]: path for path in self.held if path.startswith(folder)}

    def linked(self, folder: str) -> dict[str, str]:
        """Likewise of the links in a folder, which lead to plain datasets: the paths of these."""
        return {
            path[len(folder) :]: at
            for path, at in self._links.items()
            if path.startswith(folder) and at in self.held
        }

    def read(self, path: str, part: Any = ...) -> np.ndarray:
        """A part of a dataset, all of it by default; raises ``FileError`` where it cannot be read."""
        try:
            found = np.asarray(self._file[path][part])
        except (OSError, RuntimeError, ValueError) as error:
            raise FileError(f"{self.name}: {path} could not be read: {error}") from error
        if found.dtype.kind == "O":
            texts = [one.decode() if isinstance(one, bytes) else str(one) for one in found.flat]
            return np.array(texts, dtype=np.str_).reshape(found.shape)
        return np.char.decode(found, "utf-8") if found.dtype.kind == "S" else found


def plain(value: Any) -> Any:
    """An attribute as Python has it."""
    return value.item() if isinstance(value, np.generic) else value


def foreign(name: str) -> FileError:
    """The error of a file that cannot be read as an output."""
    return FileError(f"{name} is not an output of lagrange, is damaged, or was changed by another program")


def readable(dataset: Any) -> bool:
    """Whether a dataset is a plain one, whose parts take bounded memory."""
    if dataset.is_virtual or dataset.external or dataset.dtype.kind not in KINDS:
        return False
    size = dataset.dtype.itemsize * math.prod(dataset.chunks or dataset.shape)
    return bool(dataset.chunks is None or size <= LARGEST_CHUNK)


def described(dataset: Any) -> Held:
    """What a dataset is, by its attributes; an axis is called by the scale that is attached to it."""
    axes = []
    for axis in dataset.dims:
        scales = list(axis.values())
        axes.append(str(scales[0].name).lstrip("/") if scales else "")
    if "CLASS" in dataset.attrs:  # an axis itself
        axes = [str(dataset.name).lstrip("/")]
    told = [str(dataset.attrs.get(name, "")) for name in ("unit", "long_name")]
    chunk = dataset.chunks[0] if dataset.chunks else 0
    return Held(tuple(dataset.shape), tuple(axes), told[0], told[1], chunk)
