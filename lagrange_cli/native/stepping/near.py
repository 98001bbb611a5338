"""Where ``%work`` tells which guards have series in a step, if others have none (``native.families.nearness``
and ``native.families.near_lists``)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager

from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Integer
from lagrange_cli.native.state import LANES, vectors_of
from lagrange_cli.records import dataclass


@dataclass(frozen=True)
class NearPlaces:
    """At ``marks`` is 1 for each guard that has series. If they are ``listed``, at ``blocks`` is 1 for each
    eight of which any has, a flag says whether the list of candidates is up to date, and nothing in ``%work``
    has to be cleared from ``kept`` on."""

    marks: int
    blocks: int = 0
    flag: int = 0
    kept: int = 0
    listed: bool = False

    def mark(self, f: Function, guards: Iterable[Integer], value: float = 1.0) -> None:
        """Mark guards that have series; or, by 0, those that have none."""
        for guard in guards:
            f.store(f.constant(value), "%work", guard + self.marks)
            f.store(f.constant(value), "%work", guard.operation("lshr", LANES.bit_length() - 1) + self.blocks)

    @contextmanager
    def eights(self, f: Function, count: int) -> Iterator[Integer]:
        """The first one of each eight of ``count`` guards of which any has series, in order."""
        with (
            f.loop(0, vectors_of(count), LANES, tested=False) as some,
            f.when(f.any(f.load_row("%work", some + self.blocks, LANES) > 0.0)),
            f.loop(0, LANES, tested=False) as one,
            f.when(f.load("%work", some + one + self.blocks) > 0.0),
        ):
            yield (some + one) * LANES

    @contextmanager
    def marked(self, f: Function, first: Integer) -> Iterator[Integer]:
        """Those of eight guards that have series."""
        with f.loop(0, LANES, tested=False) as lane, f.when(f.load("%work", first + lane + self.marks) > 0.0):
            yield first + lane

    def renew(self, f: Function, *, done: bool = False) -> None:
        """Say that modes have changed, and candidates are to be found again; or that this is ``done``."""
        f.store(f.constant(float(done)), "%work", self.flag)

    def is_stale(self, f: Function) -> Bit:
        """Whether candidates are to be found again."""
        return ~(f.load("%work", self.flag) > 0.0)
