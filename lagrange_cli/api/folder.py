"""``Folder``: a temporary folder for one result."""

from __future__ import annotations

import os
import shutil
import tempfile
import weakref
from pathlib import Path


class Folder:
    """A folder for one result; it is removed with this object.

    A copy, also in another process, has a folder of its own with the same result.
    """

    def __init__(self, content: bytes | None = None) -> None:
        path = Path(tempfile.mkdtemp(prefix="lagrange-"))
        self.path = path
        self._end = weakref.finalize(self, remove, path, os.getpid())
        if content is not None:
            self.result.write_bytes(content)

    def __reduce__(self) -> tuple[type[Folder], tuple[bytes]]:
        return Folder, (self.result.read_bytes(),)

    def remove(self) -> None:
        """Remove it now."""
        self._end()

    @property
    def result(self) -> Path:
        """Where the result is written."""
        return self.path / "result.h5"


def remove(path: Path, process: int) -> None:
    """Remove a folder of a process, unless this is another one, forked from it."""
    if os.getpid() != process:
        return
    try:
        shutil.rmtree(path, ignore_errors=True)
    finally:
        if path.exists():  # by Ctrl-C
            shutil.rmtree(path, ignore_errors=True)
