"""``section``: where motions cross a surface, or are after multiples of a period, from the system to the
output."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import nullcontext
from functools import partial
from typing import TYPE_CHECKING, BinaryIO

from lagrange_cli.errors import SpecError, UsageError
from lagrange_cli.native.members import SECTION, STROBE
from lagrange_cli.records import dataclass, replace
from lagrange_cli.run.ensembles.contents import how_they_ended, made_by
from lagrange_cli.run.ensembles.ensemble import Ensemble, prepare_ensemble
from lagrange_cli.run.ensembles.files import EnsembleFile, MembersFile
from lagrange_cli.run.ensembles.follow import Group, follow_and_write
from lagrange_cli.run.monitor import SILENT, Monitor
from lagrange_cli.run.request import CSV
from lagrange_cli.run.resume import Start, begun
from lagrange_cli.run.singular import in_words
from lagrange_cli.spec.spec import SURFACE

if TYPE_CHECKING:
    from lagrange_cli.integrate.ensemble.outcome import EnsembleOutcome
    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.run.request import Request
    from lagrange_cli.store.target import Target

LARGEST = 2**28
"""Bytes of one motion's crossings, which are kept in memory until it has ended."""


@dataclass(frozen=True)
class Crossed:
    """A section that was taken: how the run started and how the motions ended; the number of ``crossings``
    found, and of motions that have ``fewer`` than asked for.

    ``start`` has the target that was written. ``outcome`` is None where an earlier run had ``finished`` (see
    ``start``)."""

    ensemble: Ensemble
    start: Start
    outcome: EnsembleOutcome | None = None
    crossings: int = 0
    fewer: int = 0
    cached: bool = False

    @property
    def message(self) -> str:
        """How it ended."""
        assert self.outcome is not None
        return sentence(self.ensemble, self.outcome, self.crossings, self.fewer)


def take_section(
    ensemble: Ensemble,
    target: Target,
    request: Request,
    monitor: Monitor = SILENT,
    *,
    threads: int = 1,
    stream: BinaryIO | None = None,
) -> Crossed:
    """Derive, compile and follow all motions, so many ``threads`` at a time, and write their crossings to
    ``target``, or as a table to ``stream``.

    However they end, what was found of those that have ended is written. The results do not depend on
    ``threads``.

    Raises:
        SpecError: no equations of motion can be derived, or they are too large.
        UsageError: a section of this system cannot be taken, or its crossings do not fit into memory.
        FileError: the output cannot be written, or an earlier run is in the way.
    """
    assert ensemble.cut is not None
    if request.format == CSV and is_many(ensemble):
        raise UsageError(
            "sections of many motions are written as HDF5: give --output a name that ends in .h5"
        )
    made_by = origin_of(ensemble)
    with nullcontext() if stream is not None else target.claimed():
        start = begun(target, made_by, request, monitor)
        if start.finished is not None:
            return Crossed(ensemble, start)
        for note in ensemble.notes:
            monitor.tell(f"{ensemble.spec.name}: {note}")
        prepared = prepare(ensemble, request, monitor)
        program, count = prepared.machine.program, ensemble.cut.kept.count
        most = LARGEST // (8 * (program.rows + 1 + len(program.observed)))
        if count > most:
            raise UsageError(
                f"{count} crossings of a motion exceed the limit of {most}, as they are kept in memory: "
                "ask for fewer --crossings"
            )
        file, outcome, written = follow_and_write(
            [Group(ensemble, prepared)], start, request, monitor, threads,
            partial(file_of, stream=stream, form=request.format),
            lambda file, outcome: sentence(ensemble, outcome, *counts(ensemble, file)),
        )  # fmt: skip
    start = replace(start, target=written)
    return Crossed(ensemble, start, outcome, *counts(ensemble, file), prepared.cached)


def counts(ensemble: Ensemble, file: EnsembleFile) -> tuple[int, int]:
    """The number of crossings found, and of motions that have fewer than asked for."""
    assert ensemble.cut is not None
    return int(file.found.sum()), int((file.found < ensemble.cut.kept.count).sum())


def origin_of(ensemble: Ensemble) -> dict[str, str | int | float]:
    """The root's attributes that say what made the file."""
    said = made_by(ensemble)
    return said if is_many(ensemble) else {n: x for n, x in said.items() if n not in ("members", "sweep")}


def is_many(ensemble: Ensemble) -> bool:
    """Whether it is a sweep, if only of one member."""
    return bool(ensemble.members.columns)


def prepare(ensemble: Ensemble, request: Request, monitor: Monitor) -> Prepared:
    """The compiled system. Raises ``UsageError`` for a surface that is proven to be crossed nowhere."""
    assert ensemble.cut is not None
    kind = SECTION if ensemble.cut.where else STROBE
    try:
        return prepare_ensemble(ensemble, request, monitor, kind)
    except SpecError as error:
        for one in error.problems:
            if SURFACE in one.message:  # it is not in the file
                what = one.message.rpartition(" one ")[2]
                raise UsageError(f"{SURFACE} {ensemble.cut.where}: this {what}") from error
        raise


def file_of(
    ensemble: Ensemble, prepared: Prepared, start: Start, units: Mapping[str, str], stream: BinaryIO | None,
    form: str,
) -> EnsembleFile:  # fmt: skip
    """Where the crossings go."""
    from lagrange_cli.run.sections.files import CrossingsTable, MotionFile

    if form == CSV:
        return CrossingsTable(ensemble, prepared, start, units, stream)
    return (MembersFile if is_many(ensemble) else MotionFile)(ensemble, prepared, start, units)


def sentence(ensemble: Ensemble, outcome: EnsembleOutcome, crossings: int, fewer: int) -> str:
    """The crossings found, and how motions ended that have fewer than requested."""
    assert ensemble.cut is not None
    members, many = ensemble.values.members, is_many(ensemble)
    found = f"{crossings} crossing{'' if crossings == 1 else 's'}" + (
        f" by {members} members" if many else ""
    )
    if outcome.status == "complete":
        stopped = f"{fewer} of them" if many else "the motion"
        before = f"reached the stop time before {ensemble.cut.kept.count} crossings"
        return f"{found}; {stopped} {before}" if fewer else found
    if many:
        return f"{found}; {how_they_ended(ensemble, outcome)}"
    return (
        f"{found}; {'interrupted' if outcome.failed is None else in_words(ensemble.spec, outcome.failed[1])}"
    )
