"""``Arrays``: the datasets of an output file, each read when it is asked for."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from lagrange_cli.api.folder import Folder
from lagrange_cli.store.result import Result


class Arrays(Mapping[str, Any]):
    """The datasets of a file by path, each kept once it has been read; they cannot be written to. The
    ``folder`` of the file is not removed before them.

    Raises ``FileError`` where the file cannot be read, or is no output of lagrange.
    """

    def __init__(self, path: Path, folder: Folder | None = None) -> None:
        self._path, self._folder, self._kept = path, folder, dict[str, Any]()
        with Result(str(path)) as result:
            self.attributes, self._names = result.attributes, dict.fromkeys(result.held)

    def __getitem__(self, path: str) -> Any:
        if path not in self._names:
            raise KeyError(path)
        if path not in self._kept:
            with Result(str(self._path)) as result:
                found = result.read(path)
            found.flags.writeable = False
            self._kept[path] = found
        return self._kept[path]

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)
