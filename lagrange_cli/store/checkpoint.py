"""``Checkpoint``: what an unfinished output can be continued from, as bytes with a digest.

While an output is being written, its checkpoint is a file beside it. When a run is interrupted, it becomes
part of the output. Numbers that are already in the output file are not repeated: the checkpoint gives the
place of each piece and its checksum.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lagrange_cli.errors import FileError
from lagrange_cli.native.compilation.cache import digest
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from numpy.typing import NDArray

MAGIC = b"lagrange checkpoint 1\n"
DIGEST = 32
LARGEST = 2**29
"""The most bytes of a checkpoint: more than a partly filled chunk of samples of 50,000 coordinates takes."""
LARGEST_HEAD, MOST_ITEMS = 2**25, 2**21
"""The most bytes of its head, and the most values in it; each takes about 80 bytes when it has been read."""
KINDS = ("f8", "i8", "i1")
"""The types of arrays that a checkpoint may hold."""


class Unusable(FileError):
    """A checkpoint, or a file that it refers to, is damaged, or was never one."""


@dataclass(frozen=True)
class Checkpoint:
    """``head`` in terms of JSON, and arrays by name (what they may be: ``contents``)."""

    head: Mapping[str, Any]
    arrays: Mapping[str, NDArray[Any]]

    def pack(self) -> bytes:
        """All of it, behind a digest."""
        listed = [[name, one.dtype.str.lstrip("<|"), one.shape] for name, one in self.arrays.items()]
        head = json.dumps([self.head, listed], ensure_ascii=False).encode("utf-8", "surrogatepass")
        parts = (np.ascontiguousarray(one).tobytes() for one in self.arrays.values())
        rest = b"".join((len(head).to_bytes(8, "little"), head, *parts))
        return MAGIC + digest(rest) + rest

    @classmethod
    def unpack(cls, content: bytes | bytearray, shown: str) -> Checkpoint:
        """The arguments of ``pack``; raises ``Unusable`` for anything else."""
        from lagrange_cli.store.contents import sound

        start = len(MAGIC) + DIGEST
        rest = memoryview(content)[start:]
        if content[:start] != MAGIC + digest(rest):
            raise damaged(shown)
        length = int.from_bytes(rest[:8], "little")
        written = bytes(rest[8 : 8 + min(length, LARGEST_HEAD)])
        if len(written) < length or sum(map(written.count, (b",", b"[", b"{"))) > MOST_ITEMS:
            raise damaged(shown)
        try:
            head, listed = json.loads(written)
            arrays, place = {}, 8 + length
            for name, kind, shape in listed:
                if kind not in KINDS or not all(type(n) is int and 0 <= n <= LARGEST for n in shape):
                    raise ValueError
                size = int(kind[1:]) * math.prod(shape)
                part = rest[place : place + size]
                arrays[str(name)] = np.frombuffer(part, dtype=kind).reshape(shape)
                place += size
            if place != len(rest) or not sound(head):
                raise ValueError
        except (ValueError, TypeError, RecursionError) as error:
            raise damaged(shown) from error
        return cls(head, arrays)


def damaged(shown: str) -> Unusable:
    """The error of a checkpoint that cannot be used."""
    return Unusable(f"the checkpoint of {shown} is damaged: --force starts again")


def write_whole(path: Path, content: bytes) -> None:
    """Put ``content`` into the file, or leave it as it was; raises ``OSError``."""
    part = path.with_name(f"{path.name}.new")  # as in ``Target.longest``
    with suppress(OSError):  # a leftover file, or a link that was put there
        part.unlink(missing_ok=True)
    try:
        with open(part, "xb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        part.replace(path)
    except OSError:
        with suppress(OSError):
            part.unlink(missing_ok=True)
        raise
