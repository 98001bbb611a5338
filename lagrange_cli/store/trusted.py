"""Reading an existing output of unknown origin: only the record that this program has written is trusted.

The file may come from anyone, and the HDF5 library is not safe for such files: links may lead to other files
or to pipes, a chunk may ask for any amount of memory, and damaged structures can make it hang. So a run never
opens an existing output with that library, and what draws outputs only if they have a record (``result``).
The *record* is a ``Checkpoint`` with a digest, followed by its place and its length. If the run has ended,
the record says how. It is then stored after the end of the HDF5 data, where other programs do not look. If
the run was interrupted, the record is what the run can be continued from, in the dataset ``/checkpoint``.
``read_record`` finds either from the last bytes of the file:

    record = read_record(target.path, target.shown)  # FileError where it is no output of this program
    record.head["attributes"]["status"]              # all attributes of the root, where the run has ended
    "attributes" in record.head                      # False: interrupted, --resume can go on with it
"""

from __future__ import annotations

import errno
import io
import os
import stat
from collections.abc import Iterator
from pathlib import Path

from lagrange_cli.errors import FileError
from lagrange_cli.store.checkpoint import LARGEST, Checkpoint, Unusable

HDF5 = b"\x89HDF\r\n\x1a\n"
END = b"\nend of lagrange record 1\n"
NUMBER = 8
"""Bytes of the place and of the length."""
REACH, PIECE = 2**24, 2**20
"""The record is searched for in this many bytes at the end of the file, in pieces of the second size. Only
the descriptions of datasets, and what another program has added, can follow it."""
TRIES = 8
"""The number of possible ends of a record that are tried; a text in the file may look like one."""
PLAIN = ("O_NONBLOCK", "O_NOFOLLOW", "O_CLOEXEC", "O_BINARY")


def sealed(packed: bytes, place: int) -> bytes:
    """A packed record with what follows it, to be stored at ``place``."""
    return packed + place.to_bytes(NUMBER, "little") + len(packed).to_bytes(NUMBER, "little") + END


def open_plain(path: Path) -> io.FileIO:
    """Open a regular file for reading, without following links or waiting for pipes.

    Raises ``OSError``.
    """
    flags = os.O_RDONLY
    for name in PLAIN:
        flags |= getattr(os, name, 0)
    file = io.FileIO(os.open(path, flags))
    if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
        file.close()
        raise OSError(0, "not a regular file")
    return file


def check_readable(path: Path, shown: str) -> None:
    """Raise ``FileError`` if the user may not read the file, or it is a directory."""
    if path.is_dir():
        raise FileError(f"{shown} is a directory, not an output")
    if path.exists() and not os.access(path, os.R_OK):
        raise FileError(f"{shown} could not be read: {os.strerror(errno.EACCES)}")


def read_exactly(file: io.FileIO, place: int, size: int) -> bytearray:
    """``size`` bytes of a file; raises ``ValueError`` if it ends before."""
    file.seek(place)
    piece = bytearray(size)
    view, done = memoryview(piece), 0
    while done < size:
        count = file.readinto(view[done:])
        if not count:
            raise ValueError("the file ends before")
        done += count
    return piece


def read_record(path: Path, shown: str) -> Checkpoint:
    """The record of the output at ``path``, which has no links left.

    If the run has ended, its head has the keys ``attributes``, those of the root, and ``t``, the last sample
    time; otherwise it is what the run is continued from. Memory and time are bounded whatever the file holds.
    Raises ``FileError`` if the file is not an output of this program or cannot be read.
    """
    check_readable(path, shown)
    try:
        with open_plain(path) as file:
            size = os.fstat(file.fileno()).st_size
            if read_exactly(file, 0, min(size, len(HDF5))) != HDF5:
                raise foreign(shown)
            for end in ends(file, size):
                record = record_before(file, end, shown)
                if record is not None and ("attributes" not in record.head or end + len(END) == size):
                    return record
    except (OSError, ValueError, OverflowError) as error:
        raise foreign(shown) from error
    raise foreign(shown)


def ends(file: io.FileIO, size: int) -> Iterator[int]:
    """The places where a record may end, where its ``END`` begins, from the last one on."""
    found, least = 0, max(0, size - REACH)
    stop = size
    while stop > least and found < TRIES:
        start = max(least, stop - PIECE)
        piece = read_exactly(file, start, min(size, stop + len(END) - 1) - start)
        at = piece.rfind(END)
        while at >= 0 and found < TRIES:
            yield start + at
            found += 1
            at = piece.rfind(END, 0, at + len(END) - 1)
        stop = start


def record_before(file: io.FileIO, end: int, shown: str) -> Checkpoint | None:
    """The record that ends there, if there is one."""
    if end < 2 * NUMBER:
        return None
    numbers = read_exactly(file, end - 2 * NUMBER, 2 * NUMBER)
    place, length = (int.from_bytes(numbers[i : i + NUMBER], "little") for i in (0, NUMBER))
    if length > LARGEST or place + length != end - 2 * NUMBER:
        return None
    try:
        return Checkpoint.unpack(read_exactly(file, place, length), shown)
    except Unusable:
        return None


def foreign(shown: str) -> FileError:
    """The error of a file that is none of this program's."""
    return FileError(
        f"{shown} is damaged, was changed by another program, or is not an output of lagrange: "
        "--force replaces it, --output names another"
    )
