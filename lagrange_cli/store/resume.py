"""``Earlier``: the files of an interrupted run, and whether it can be continued."""

from __future__ import annotations

import binascii
import math
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from lagrange_cli.errors import FileError
from lagrange_cli.records import dataclass
from lagrange_cli.store.checkpoint import LARGEST, Checkpoint, damaged
from lagrange_cli.store.layout import BYTES, Series
from lagrange_cli.store.target import Target
from lagrange_cli.store.trusted import open_plain, read_exactly, read_record

Attributes = Mapping[str, Any]

DIFFERENT = {
    "generator": "by another version of lagrange",
    "name": "from another system",
    "spec": "from another system file, or the file has changed since",
    "parameters": "with other parameters",
    "sizes": "with other sizes",
    "method": "with another --method",
    "tolerance": "with another --tolerance",
    "precision": "with another --precision",
    "sweep": "with other members",
    "where": "with another surface, --where",
    "every": "with another period, --every",
    "direction": "with another --direction",
    "crossings": "with another number of --crossings",
    "run": "with another initial state, or with another --stop, --samples, --step or --outputs",
    "machine": "on another processor or with another version of LLVM, so that the last digits would differ",
}
"""The words of the message for an earlier run with another attribute."""


@dataclass(frozen=True)
class Earlier:
    """An interrupted run: its checkpoint, and the file with its numbers."""

    shown: str
    source: Path
    checkpoint: Checkpoint

    @property
    def part(self) -> int:
        """The number of the part file with the numbers; -1 if they are in the output."""
        part: int = self.checkpoint.head["part"]
        return part

    def check(self, run: Attributes) -> None:
        """Raise ``FileError`` unless ``run`` would continue it."""
        check_same(self.shown, self.checkpoint.head["run"], run)

    def read(self, place: int, size: int, checksum: int | None = None) -> bytearray:
        """A piece of the file; raises ``Unusable`` if it is missing or was changed."""
        try:
            with open_plain(self.source) as file:
                piece = read_exactly(file, place, size)
        except (OSError, ValueError, OverflowError) as error:
            raise damaged(self.shown) from error
        if checksum is not None and binascii.crc32(piece) != checksum:
            raise damaged(self.shown)
        return piece

    def chunks(self, rows: int, series: Sequence[Series], count: int) -> Iterator[dict[str, np.ndarray]]:
        """The first ``count`` rows of datasets of one length, in chunks of ``rows`` and then the rest. In an
        output that is whole, the rest is the beginning of one more chunk."""
        arrays = self.checkpoint.arrays
        apart, first = f"rest/{series[0].path}" in arrays, arrays.get(f"places/{series[0].path}")
        pieces = first.size // 2 if apart and first is not None else -(-count // rows)
        rest = count - rows * pieces
        for one in series:
            places, beside = arrays.get(f"places/{one.path}"), arrays.get(f"rest/{one.path}")
            if (
                places is None or places.dtype != "i8" or places.ndim != 2 or places.shape[1] != 2
                or not pieces <= len(places) <= pieces + (not apart)
            ):  # fmt: skip
                raise damaged(self.shown)
            if apart and (beside is None or beside.dtype != one.kind or beside.shape != (rest, *one.shape)):
                raise damaged(self.shown)
        for number in range(pieces):
            chunk, length = {}, min(rows, count - number * rows)
            for one in series:
                place, checksum = map(int, arrays[f"places/{one.path}"][number])
                piece = self.read(place, BYTES * rows * math.prod(one.shape), checksum)
                chunk[one.path] = np.frombuffer(piece, one.kind).reshape(rows, *one.shape)[:length]
            yield chunk
        if apart and rest:
            yield {one.path: arrays[f"rest/{one.path}"] for one in series}


@dataclass(frozen=True)
class Finished:
    """An output of a finished run: the attributes of its root, and the last sample time (nan: none).
    A run that ends later may go on ``further`` from it."""

    attributes: Attributes
    t: float
    further: Earlier | None = None


def unfinished(target: Target) -> Earlier | None:
    """What a process that was killed has left beside the output, if it is enough to continue.

    Raises ``FileError`` where it cannot be read, ``Unusable`` where it is damaged.
    """
    if not target.checkpoint.is_file():
        return None
    checkpoint = Checkpoint.unpack(read_file(target.checkpoint, target.shown), target.shown)
    part = checkpoint.head.get("part", -1)
    if part < 0:
        raise damaged(target.shown)
    source = target.part_file(part)
    return Earlier(target.shown, source, checkpoint) if source.is_file() else None


def read_file(place: Path, shown: str) -> bytearray:
    """All of a file."""
    try:
        with open_plain(place) as file:
            size = os.fstat(file.fileno()).st_size
            if size > LARGEST:
                raise damaged(shown)
            return read_exactly(file, 0, size)
    except ValueError as error:
        raise damaged(shown) from error
    except OSError as error:
        raise FileError(f"the checkpoint of {shown} could not be read: {error.strerror}") from error


def find_earlier(target: Target, run: Attributes) -> Earlier | Finished | None:
    """What there is of ``run`` (the attributes that say what it is, among them ``machine``): an output that
    needs nothing more, a run to continue, or nothing.

    Raises ``FileError`` where there is something else in the way, or it is damaged.
    """
    output = read_output(target) if target.path.exists() else None
    beside = unfinished(target)
    if isinstance(output, Finished):
        asked = {name: value for name, value in run.items() if name != "machine"}
        if difference(output.attributes, asked) is None:
            if beside is None or difference(beside.checkpoint.head["run"], run) is None:
                target.clear()  # a process was killed when the output had just got its name
            return output
        if beside is None:
            check_same(target.shown, output.attributes, asked)
        output = None
    earlier = beside or output
    if earlier is not None:
        earlier.check(run)
    return earlier


def interrupted(path: Path) -> bool:
    """Whether a file is the output of a run that was interrupted and can be continued."""
    try:
        return "attributes" not in read_record(path, path.name).head
    except FileError:
        return False


def read_output(target: Target) -> Earlier | Finished:
    """The output that stands under the name already, by its record alone (see ``trusted``)."""
    record = read_record(target.path, target.shown)
    if "attributes" in record.head:
        further = None
        if "further" in record.head:
            further = Earlier(target.shown, target.path, Checkpoint(record.head["further"], record.arrays))
        return Finished(record.head["attributes"], record.head["t"], further)
    if record.head["part"] != -1:
        raise damaged(target.shown)
    return Earlier(target.shown, target.path, record)


def runs_before(target: Target) -> tuple[Attributes, ...]:
    """The attributes of what earlier runs have left: unfinished ones first."""
    heads = []
    for find in (unfinished, lambda target: read_output(target) if target.path.exists() else None):
        with suppress(FileError):
            found = find(target)
            if found is not None:
                head = found.attributes if isinstance(found, Finished) else found.checkpoint.head["run"]
                heads += [head] if isinstance(head, Mapping) else []
    return tuple(heads)


def check_same(shown: str, earlier: Any, run: Attributes) -> None:
    """Raise ``FileError`` unless ``earlier`` has the attributes of ``run``."""
    name = difference(earlier, run)
    if name == "generator" and (not isinstance(earlier, Mapping) or name not in earlier):
        raise FileError(f"{shown} is not an output of lagrange: --force replaces it, --output names another")
    if name is not None:
        what = DIFFERENT.get(name, f"with another {name}")
        raise FileError(
            f"{shown} cannot be continued: it was made {what}; --force replaces it, --output names another"
        )


def difference(earlier: Any, run: Attributes) -> str | None:
    """The first attribute that only one of ``run`` and ``earlier`` has, or that differs between them: what
    says more comes first."""
    if not isinstance(earlier, Mapping):
        return "generator"
    missing = [name for name in DIFFERENT if name in earlier and name not in run]
    ordered = (*(name for name in DIFFERENT if name in run), *(name for name in run if name not in DIFFERENT))
    differing = (name for name in ordered if not same(earlier.get(name), run[name]))
    return next(differing, None) or next(iter(missing), None)


def same(one: Any, other: Any) -> bool:
    """Whether two attributes say the same, after HDF5 or JSON."""
    return isinstance(one, (str, int, float, np.number, list)) and bool(one == other)
