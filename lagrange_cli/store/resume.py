"""``Earlier``: what an earlier run has left of an output, and whether it can be continued."""

from __future__ import annotations

import binascii
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from lagrange_cli.errors import FileError
from lagrange_cli.records import dataclass
from lagrange_cli.store.checkpoint import LARGEST, Checkpoint, damaged
from lagrange_cli.store.output import CHECKPOINT
from lagrange_cli.store.target import PARTS, Target

Attributes = Mapping[str, Any]

DIFFERENT = {
    "generator": "made by another version of lagrange",
    "name": "of another system",
    "spec": "of another system file, or the file has changed since",
    "parameters": "of other parameters",
    "sizes": "of other sizes",
    "method": "of another --method",
    "tolerance": "of another --tolerance",
    "precision": "of another --precision",
    "sweep": "of other members",
    "run": "of another initial state, or of another --stop, --samples, --step or --outputs",
    "machine": "made on another processor, or by another LLVM, which would give other last digits",
}
"""What it means that an attribute of an earlier run is not that of this one."""


@dataclass(frozen=True)
class Earlier:
    """An earlier run that has not come to its end: its checkpoint, and the file with its numbers."""

    shown: str
    source: Path
    checkpoint: Checkpoint

    @property
    def part(self) -> int:
        """The number of the part file with the numbers; -1 if they are in the output."""
        part: int = self.checkpoint.head["part"]
        return part

    def check(self, run: Attributes) -> None:
        """Raise ``FileError`` unless it is an earlier part of ``run``."""
        head = self.checkpoint.head
        check_same(self.shown, head.get("run"), run)
        if type(head.get("reached")) not in (int, float):
            raise damaged(self.shown)

    def read(self, place: int, size: int, checksum: int | None = None) -> bytes:
        """A piece of the file; raises ``Unusable`` where it is not there, or is not what it was."""
        try:
            with open(self.source, "rb") as file:
                file.seek(place)
                piece = file.read(size)
        except (OSError, ValueError, OverflowError) as error:
            raise damaged(self.shown) from error
        if len(piece) < size or (checksum is not None and binascii.crc32(piece) != checksum):
            raise damaged(self.shown)
        return piece

    def chunks(self, rows: int, shapes: Mapping[str, tuple[int, ...]]) -> Iterator[dict[str, np.ndarray]]:
        """The samples, in chunks of ``rows`` and then the rest; ``shapes`` are those of the series'
        samples."""
        arrays = self.checkpoint.arrays
        for path, shape in shapes.items():
            places, rest = arrays.get(f"places/{path}"), arrays.get(f"rest/{path}")
            if (
                places is None or rest is None or places.shape != (len(arrays["places/t"]), 2)
                or rest.shape != (len(arrays["rest/t"]), *shape) or (places < 0).any()
            ):  # fmt: skip
                raise damaged(self.shown)
        for number in range(len(arrays["places/t"])):
            chunk = {}
            for path, shape in shapes.items():
                place, checksum = map(int, arrays[f"places/{path}"][number])
                piece = self.read(place, 8 * rows * math.prod(shape), checksum)
                chunk[path] = np.frombuffer(piece).reshape(rows, *shape)
            yield chunk
        yield {path: arrays[f"rest/{path}"] for path in shapes}


@dataclass(frozen=True)
class Finished:
    """An output that needs nothing more: the attributes of its root, and the last sample time."""

    attributes: Attributes
    t: float


def unfinished(target: Target) -> Earlier | None:
    """What a process that was killed has left beside the output, if it is enough to continue.

    Raises ``FileError`` where it cannot be read, ``Unusable`` where it is damaged.
    """
    if not target.checkpoint.is_file():
        return None
    checkpoint = Checkpoint.unpack(read_file(target.checkpoint, target.shown), target.shown)
    part = checkpoint.head.get("part")
    if type(part) is not int or not 0 <= part < PARTS:
        raise damaged(target.shown)
    source = target.part_file(part)
    return Earlier(target.shown, source, checkpoint) if source.is_file() else None


def read_file(place: Path, shown: str) -> bytes:
    """All of a file."""
    try:
        if place.stat().st_size > LARGEST:
            raise damaged(shown)
        return place.read_bytes()
    except OSError as error:
        raise FileError(
            f"what an earlier run left for {shown} could not be read: {error.strerror}"
        ) from error


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
            if beside is None or difference(beside.checkpoint.head.get("run"), run) is None:
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
        with h5py.File(path, "r") as file:
            beginning = isinstance(file.get(CHECKPOINT, getlink=True), h5py.HardLink)
            return beginning and same(file.attrs.get("status"), "interrupted")
    except (OSError, KeyError, ValueError, TypeError, AttributeError, RuntimeError):
        return False


def read_output(target: Target) -> Earlier | Finished:
    """The output that stands under the name already."""
    shown = target.shown
    try:
        with h5py.File(target.path, "r") as file:
            attributes = dict(file.attrs)
            kept = file.get(CHECKPOINT)
            if kept is not None and (kept.dtype != np.uint8 or kept.ndim != 1 or len(kept) > LARGEST):
                raise damaged(shown)
            content = None if kept is None else kept[()].tobytes()
            last = float(file["t"][-1]) if "t" in file and len(file["t"]) else math.nan
    except (OSError, KeyError, ValueError, TypeError, AttributeError, RuntimeError) as error:
        raise FileError(
            f"{shown} is damaged, or no output of lagrange: --force replaces it, --output names another"
        ) from error
    if content is not None:
        checkpoint = Checkpoint.unpack(content, shown)
        if checkpoint.head.get("part") != -1:
            raise damaged(shown)
        return Earlier(shown, target.path, checkpoint)
    return Finished(attributes, last)


def check_same(shown: str, earlier: Any, run: Attributes) -> None:
    """Raise ``FileError`` unless ``earlier`` says what ``run`` says."""
    name = difference(earlier, run)
    if name == "generator" and (not isinstance(earlier, Mapping) or name not in earlier):
        raise FileError(f"{shown} is no output of lagrange: --force replaces it, --output names another")
    if name is not None:
        what = DIFFERENT.get(name, f"of another {name}")
        raise FileError(
            f"{shown} cannot be continued: it is {what}; --force replaces it, --output names another"
        )


def difference(earlier: Any, run: Attributes) -> str | None:
    """The first attribute that only one of ``run`` and ``earlier`` has, or that they have otherwise."""
    if not isinstance(earlier, Mapping):
        return "generator"
    missing = [name for name in DIFFERENT if name in earlier and name not in run]
    differing = (name for name, value in run.items() if not same(earlier.get(name), value))
    return next(differing, None) or next(iter(missing), None)


def same(one: Any, other: Any) -> bool:
    """Whether two attributes say the same, after HDF5 or JSON."""
    return isinstance(one, (str, int, float, np.number, list)) and bool(one == other)
