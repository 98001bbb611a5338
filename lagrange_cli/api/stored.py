"""``Stored``: results in a temporary file, which exists until they are saved or the object is deleted."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable, Iterator, Mapping
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lagrange_cli.api.folder import Folder
from lagrange_cli.api.given import flag_of
from lagrange_cli.api.group import Group, is_group
from lagrange_cli.api.pictures import Pictured
from lagrange_cli.api.words import in_python, python_words
from lagrange_cli.errors import FileError, MissingPackage, UsageError
from lagrange_cli.outputs.catalog import OUTPUTS
from lagrange_cli.run.request import HDF5, format_of
from lagrange_cli.store.find_target import find_target
from lagrange_cli.store.result import Result
from lagrange_cli.store.target import Target

if TYPE_CHECKING:
    from contextlib import ExitStack

    import xarray
    from numpy.typing import NDArray

    from lagrange_cli.api.view import Page


class Arrays(Mapping[str, Any]):
    """The datasets of a file by path, each kept once it has been read; they cannot be written to. A folder
    is not removed before them; copies in other processes read the file again.

    Raises ``FileError`` where the file cannot be read, or is no output of lagrange.
    """

    def __init__(self, place: Path | Folder) -> None:
        self._place, self._kept = place, dict[str, Any]()
        self._version = version(self.path)
        with Result(str(self.path)) as result:
            self.attributes, self._names = result.attributes, dict.fromkeys(result.held)

    def __reduce__(self) -> tuple[type[Arrays], tuple[Path | Folder]]:
        return Arrays, (self._place,)

    @property
    def path(self) -> Path:
        """The file."""
        return self._place.result if isinstance(self._place, Folder) else self._place

    def file(self) -> Path:
        """The file; raises ``FileError`` where it is gone, or another one has taken its place."""
        now = version(self.path)
        if now is None:
            raise FileError(f"{self.path}: no such file")
        if now != self._version:
            raise FileError(f"{self.path} has changed since it was opened: load it again")
        return self.path

    def __getitem__(self, path: str) -> Any:
        if path not in self._names:
            raise KeyError(path)
        if path not in self._kept:
            with Result(str(self.file())) as result:
                found = result.read(path)
            found.flags.writeable = False
            self._kept[path] = found
        return self._kept[path]

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)


def version(path: Path) -> tuple[int, ...] | None:
    """What tells a file from one that takes its place; None where there is none."""
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns


PARSED = ("parameters", "sizes", "run", "p_drift", "events", "sweep")


class Stored(Pictured):
    """The file of a command: a motion, many motions, or the crossings of a surface.

    Arrays are read when they are asked for, and cannot be written to.

    Attributes
    ----------
    q, v, p : Group
        Coordinates, velocities and momenta by name.
    h : ndarray
        The energy function.
    status, message : str
        How it ended, as the command says it.
    notes : tuple of str
        The other messages of the command.
    """

    def __init__(self, place: Path | Folder, notes: tuple[str, ...] = ()) -> None:
        self.notes = notes
        self._arrays: Arrays = Arrays(place)

    @property
    def path(self) -> Path:
        """The file, which may be read for as long as this object, or a group of its arrays, is there."""
        return self._arrays.path

    @property
    def attributes(self) -> dict[str, Any]:
        """The attributes of the file."""
        said = self._arrays.attributes
        return {name: json.loads(x) if name in PARSED else x for name, x in said.items()}

    @property
    def name(self) -> str:
        """The name of the system."""
        return str(self._arrays.attributes["name"])

    @property
    def status(self) -> str:
        """The status of its end, in a word."""
        return str(self._arrays.attributes["status"])

    @property
    def message(self) -> str:
        """How it ended, in a sentence."""
        return python_words(str(self._arrays.attributes["message"]))

    def __repr__(self) -> str:
        return f"<output {self.path}: {self.name}, {self.message}>"

    @property
    def datasets(self) -> Group:
        """Everything by the paths of the file."""
        return Group("", self._arrays)

    def __getitem__(self, path: str) -> NDArray[np.float64]:
        found: NDArray[np.float64] = self.datasets[path]
        return found

    @property
    def t(self) -> NDArray[np.float64]:
        """The times of the samples, or of the crossings."""
        if "t" not in self._arrays:
            raise AttributeError("there are no samples: name outputs, as in outputs=['q']")
        return self["t"]

    @property
    def events(self) -> Group:
        """The crossings of events by their names."""
        return Group("events/", self._arrays)

    def __getattr__(self, name: str) -> Any:
        if name not in OUTPUTS:
            raise AttributeError(f"there is no {name!r}")
        return self._quantity(name)

    def _quantity(self, name: str) -> Any:
        """An output as an array, or as a group of them."""
        if is_group(name):
            return self._group(name)
        path = OUTPUTS[name].datasets.strip("/")
        if path not in self._arrays:
            raise self._missing(name)
        return self._arrays[path]

    @in_python
    def save(self, path: str | os.PathLike[str], *, force: bool = False) -> None:
        """Write the file that the command writes: the same bytes.

        Parameters
        ----------
        path : str or path
            The name of an HDF5 file.
        force : bool
            Whether an existing file may be replaced.

        Raises
        ------
        FileError
            The file exists, or cannot be written.
        UsageError
            The name is that of another kind of file.
        """
        name = os.fspath(path)
        if format_of(name) != HDF5:
            raise UsageError("many motions are written as HDF5: give a name that ends in .h5")
        with find_target(name, force=flag_of("force", force)).filled() as place:
            shutil.copyfile(self._arrays.file(), place)

    def _output(self, held: ExitStack) -> Path:
        """See ``plot.Drawable``."""
        return self._arrays.file()

    def view(self) -> Page:
        """A web page that replays the motion; that of a sweep has a slider for the members.

        Returns
        -------
        Page
            A notebook shows it; ``save`` writes it to a file.

        Raises
        ------
        UsageError
            There is no such page of this output.
        """
        from lagrange_cli.api.view import page_of_output

        return page_of_output(self._arrays.file())

    def to_xarray(self) -> xarray.DataTree:
        """A tree of xarray's datasets with all dimensions, in memory. It needs the extra ``xarray``.

        Raises
        ------
        MissingPackage
            There is no xarray.
        """
        try:
            import_module("h5netcdf")
            import xarray
        except ImportError as error:
            raise MissingPackage("to_xarray", "xarray", "xarray") from error
        with xarray.open_datatree(self._arrays.file(), engine="h5netcdf") as tree:
            loaded: xarray.DataTree = tree.load()
        return loaded


def stored(write: Callable[[Target], Any]) -> tuple[Folder, Any]:
    """A new folder, and what ``write`` returns once it has written a result there.

    Raises ``FileError`` where there is no place for it.
    """
    try:
        folder = Folder()
    except OSError as error:
        raise FileError(f"no temporary folder can be made: {error.strerror or error}") from error
    return folder, write(find_target(str(folder.result), force=True))
