"""``Pack``: the data of eight lanes, and access to single lanes and the queue of members."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Integer, Pointer
from lagrange_cli.native.members import lane_places
from lagrange_cli.native.state import LANES, vectors_of
from lagrange_cli.records import dataclass


@dataclass(frozen=True)
class Pack:
    """What eight lanes work on, in vectors: places of each part and ``size``, that of all. So many of
    the rows are ``quadratures``.

    A ``section`` of a kind has more numbers of its own, so many rows of a sample behind those of the state
    that are ``sampled``, and ``scratch``.
    """

    degrees: int
    rows: int
    width: int
    span: int
    constants: int
    work: int
    quadratures: int = 0
    section: str = ""
    sampled: int = 0
    scratch: int = 0
    constrained: bool = False
    """Whether motions are moved back to constraints."""

    @property
    def places(self) -> dict[str, int]:
        """Where each part begins."""
        sizes = {
            "state": self.width,
            "low": self.width,
            "errors": self.width,
            **dict.fromkeys(lane_places(self.width, self.section), 1),
            "constants": self.constants,
            "scratch": vectors_of(self.constants),
            "trial": self.rows + self.sampled,
            "rates": self.degrees,
            "allowed": self.degrees,
            "work": self.work,
            "own": self.scratch,
            "arrays": 3 * self.width,
            "size": 0,
        }
        found, place = {}, 0
        for name, size in sizes.items():
            found[name] = place
            place += size
        return found


def spread(f: Function, origin: Pointer, to: Pointer, count: int) -> None:
    """to[8 i] = origin[i]"""
    if count:
        with f.loop(0, count, tested=False) as i:
            f.store(f.load(origin, i), to, i * LANES)


@contextmanager
def each_lane(f: Function, mask: Integer) -> Iterator[Integer]:
    """The lanes in a mask, which is not 0."""
    left = f.variable(mask)
    with f.forever() as rounds:
        lane = Integer(f, f.define(f"call i64 @llvm.cttz.i64(i64 {left.get().name}, i1 true)"), 1)
        left.set(left.get() & (left.get() - 1))
        yield lane
        rounds.repeat(~left.get().equals(0))
