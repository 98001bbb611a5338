"""``Folder``: a temporary folder for one result."""

from __future__ import annotations

import shutil
import tempfile
import weakref
from pathlib import Path


class Folder:
    """A folder for one result; it is removed with this object."""

    def __init__(self) -> None:
        path = Path(tempfile.mkdtemp(prefix="lagrange-"))
        self.path = path
        self._end = weakref.finalize(self, shutil.rmtree, path, ignore_errors=True)

    def remove(self) -> None:
        """Remove it now."""
        self._end()

    @property
    def result(self) -> Path:
        """Where the result is written."""
        return self.path / "result.h5"
