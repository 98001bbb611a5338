"""``Sink``: the file HDF5 writes through, which keeps a failed write from HDF5 and tells it to us.

The HDF5 library does not survive a write that fails (a full disk): the file can then be neither closed nor
left open, and the process crashes when it exits. So every write seems to succeed, the first failure is kept
in ``error``, and from then on nothing more is written.
"""

from __future__ import annotations

import io
import os
from pathlib import Path
from typing import Any

START = 64
"""Bytes by which a piece is recognized, besides its length."""


class Sink(io.FileIO):
    """A new file for reading and writing, unbuffered; raises ``OSError`` only on being opened.

    ``place`` is where it is read or written next; ``found`` where the piece ``awaited`` has been written,
    -1 before.
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
        """Have the operating system put everything on disk; a failure is kept in ``error``."""
        try:
            if self.error is None:
                os.fsync(self.fileno())
        except OSError as error:
            self.error = error
