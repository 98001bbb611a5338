"""``Sink``: the file that HDF5 writes to. It hides a failed write from HDF5 and reports it to its owner.

The HDF5 library cannot handle a write that fails, as on a full disk: the file can then be neither closed nor
left open, and the process crashes when it exits. So every write appears to succeed. The first failure is
stored in ``error``, and nothing is written after it.
"""

from __future__ import annotations

import io
import os
from pathlib import Path
from typing import Any

START = 64
"""Bytes by which a piece is recognized, besides its length."""


class Sink(io.FileIO):
    """A new file for reading and writing, unbuffered; only opening it raises ``OSError``.

    ``place`` is where it is read or written next. ``found`` is the place where the piece ``awaited`` was
    written, -1 as long as it was not.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path, "x+")
        self.error: OSError | None = None
        self.place = 0
        self.awaited: memoryview | None = None
        self.found = -1

    def expect(self, piece: Any) -> None:
        """Note where ``piece`` is going to be written."""
        self.awaited, self.found = memoryview(piece).cast("B"), -1

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        self.place = super().seek(offset, whence)
        return self.place

    def write(self, content: Any) -> int:
        view = memoryview(content).cast("B")
        awaited = self.awaited
        if awaited is not None and len(view) == len(awaited) and view[:START] == awaited[:START]:
            self.found, self.awaited = self.place, None
        done = 0
        while done < len(view) and self.error is None:
            try:
                done += super().write(view[done:])
            except OSError as error:
                self.error = error
        self.seek(len(view) - done, os.SEEK_CUR)
        return len(view)

    def readinto(self, buffer: Any) -> int:
        """Fill the whole buffer; what was never written reads as zeros."""
        view = memoryview(buffer).cast("B")
        count = super().readinto(view)
        view[count:] = bytes(len(view) - count)
        return len(view)

    def truncate(self, size: int | None = None) -> int:
        size = self.tell() if size is None else size
        try:
            if self.error is None:
                super().truncate(size)
        except OSError as error:
            self.error = error
        return size

    def synchronize(self) -> None:
        """Have the operating system put everything on disk; a failure is stored in ``error``."""
        try:
            if self.error is None:
                os.fsync(self.fileno())
        except OSError as error:
            self.error = error
