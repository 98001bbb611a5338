"""``sweep``: many motions, from an ensemble to the output."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from lagrange_cli.errors import UsageError
from lagrange_cli.records import dataclass, field, replace
from lagrange_cli.run.ensembles.contents import how_they_ended, made_by
from lagrange_cli.run.ensembles.ensemble import Ensemble, prepare_ensemble
from lagrange_cli.run.ensembles.files import MembersFile
from lagrange_cli.run.ensembles.follow import Group, follow_and_write
from lagrange_cli.run.monitor import SILENT, Monitor
from lagrange_cli.run.motion import Motion
from lagrange_cli.run.resume import Start, begun

if TYPE_CHECKING:
    from lagrange_cli.integrate.ensemble.outcome import EnsembleOutcome
    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.run.request import Request
    from lagrange_cli.store.target import Target

LARGEST = 2**26
"""Bytes of one member's samples, which are kept in memory until it has ended."""


@dataclass(frozen=True)
class Swept:
    """An ensemble that was followed: how the run started, and how the members ended.

    ``start`` has the target that was written. ``outcome`` is None where an earlier run had ``finished`` (see
    ``start``). ``cached`` tells that the compiled code is that of an earlier run. ``events`` are how often
    each event happened in all members.
    """

    ensemble: Ensemble
    start: Start
    outcome: EnsembleOutcome | None = None
    cached: bool = False
    events: Mapping[str, int] = field(default_factory=dict)


def sweep(
    ensemble: Ensemble, target: Target, request: Request, monitor: Monitor = SILENT, *, threads: int = 1
) -> Swept:
    """Derive, compile and integrate all members, so many ``threads`` at a time, and write them to ``target``.

    However the members end, what was computed is written. The results do not depend on ``threads``.

    Raises:
        SpecError: no equations of motion can be derived, or they are too large.
        UsageError: the samples of a member do not fit into memory.
        FileError: the output cannot be written, or an earlier run is in the way.
    """
    if Motion(ensemble.spec, ensemble.values.of(0), ensemble.settings).may_be_stiff:
        from lagrange_cli.run.ensembles.trial import settled

        ensemble = settled(ensemble, request, monitor.stage)
    with target.claimed():
        start = begun(target, made_by(ensemble), request, monitor)
        if start.finished is not None:
            return Swept(ensemble, start)
        for note in ensemble.notes:
            monitor.tell(f"{ensemble.spec.name}: {note}")
        groups = grouped(ensemble, request, monitor)
        ensemble, prepared = groups[0].ensemble, groups[0].prepared
        refuse_long_samples(ensemble, prepared)
        file, outcome, written = follow_and_write(
            groups, start, request, monitor, threads, MembersFile,
            lambda file, outcome: how_they_ended(ensemble, outcome),
        )  # fmt: skip
    return Swept(ensemble, replace(start, target=written), outcome, prepared.cached, file.events)


def grouped(ensemble: Ensemble, request: Request, monitor: Monitor) -> list[Group]:
    """The members by which constraints depend on others. Members are refused whose outputs are not those of
    the first ones, as something else is conserved.

    Raises ``SpecError`` as ``prepare_ensemble``.
    """
    import numpy as np

    prepared, otherwise = prepare_ensemble(ensemble, request, monitor), ensemble.values.otherwise
    values = ensemble.values
    made: dict[tuple[str, ...], Prepared] = {}
    for left_out in dict.fromkeys(otherwise.values()):
        spec = replace(ensemble.spec, left_out=left_out)
        other = prepare_ensemble(replace(ensemble, spec=spec), request, monitor)
        if other.recording == prepared.recording:
            made[left_out] = other
        else:
            values = values.without(one for one, names in otherwise.items() if names == left_out)
    ensemble, keys = replace(ensemble, values=values), [ensemble.spec.left_out, *made]
    of_member = [values.otherwise.get(member, keys[0]) for member in range(values.members)]
    return [
        Group(
            replace(ensemble, spec=replace(ensemble.spec, left_out=left_out)),
            made.get(left_out, prepared),
            np.array([one == left_out for one in of_member]),
        )
        for left_out in keys
    ]


def refuse_long_samples(ensemble: Ensemble, prepared: Prepared) -> None:
    """Raise ``UsageError`` unless the samples of several members fit into memory."""
    program, count = prepared.machine.program, ensemble.settings.count
    most = LARGEST // (8 * (program.rows + len(program.observed)))
    if ensemble.sampled and count > most:
        raise UsageError(
            f"{count} samples per member exceed the limit of {most}, as they are kept in memory: "
            "use fewer --samples, or solve the members one by one"
        )
