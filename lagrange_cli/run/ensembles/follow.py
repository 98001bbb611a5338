"""Every member of an ensemble followed into a file: of a sweep, or of a section."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, TypeVar

from lagrange_cli.records import dataclass
from lagrange_cli.run.attributes import units_of
from lagrange_cli.run.ensembles.contents import told
from lagrange_cli.run.ensembles.ensemble import Ensemble, alone
from lagrange_cli.run.ensembles.files import EnsembleFile
from lagrange_cli.run.monitor import Monitor, Progress, watched
from lagrange_cli.run.motion import Motion
from lagrange_cli.run.pace import PaceOfMany
from lagrange_cli.run.settings.settings import tell_empty
from lagrange_cli.run.singular import in_words

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from lagrange_cli.integrate.ensemble.outcome import EnsembleOutcome
    from lagrange_cli.integrate.method import Cause, End
    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.run.request import Request
    from lagrange_cli.run.resume import Start
    from lagrange_cli.store.target import Target

F = TypeVar("F", bound=EnsembleFile)


def cause(ensemble: Ensemble, member: int, end: End) -> Cause | None:
    """What in the system ended the motion of a member."""
    return Motion(ensemble.spec, ensemble.values.of(member), ensemble.settings).cause(end)


@dataclass(frozen=True)
class Group:
    """The ``chosen`` members (members,) of an ensemble, or all, whose constraints depend on each other in the
    same way, and their system, compiled."""

    ensemble: Ensemble
    prepared: Prepared
    chosen: NDArray[np.bool_] | None = None


def follow_and_write(
    groups: Sequence[Group],
    start: Start,
    request: Request,
    monitor: Monitor,
    threads: int,
    make: Callable[[Ensemble, Prepared, Start, Mapping[str, str]], F],
    describe: Callable[[F, EnsembleOutcome], str],
) -> tuple[F, EnsembleOutcome, Target]:
    """Follow all members into the file that ``make`` makes, with the units of datasets, however they end;
    how they did, as ``describe`` says it, and the target that was written."""
    from lagrange_cli.integrate.checkpoint import Schedule
    from lagrange_cli.integrate.ending import Ending
    from lagrange_cli.integrate.ensemble.follow import ensemble_method, follow_ensemble
    from lagrange_cli.integrate.method import Unfit
    from lagrange_cli.store.checkpoint import damaged

    ensemble = groups[0].ensemble
    units = units_of(ensemble.spec, monitor.tell)
    tell_empty(ensemble.spec, ensemble.settings, monitor.tell)
    if ensemble.spec.forces.get("dissipation"):
        from lagrange_cli.run.doubtful import tell_dissipation

        tell_dissipation(ensemble.spec, ensemble.values.of(0).parameters, monitor.tell)
    progress, stage, name = monitor.progress(), monitor.stage, ensemble.spec.name
    pace: Progress = progress
    if ensemble.cut is None:
        pace = PaceOfMany(ensemble.values.members, progress, lambda text: monitor.warn(f"{name}: {text}"))
    with monitor.interrupts() as interrupted:
        with stage("write"):
            file = make(ensemble, groups[0].prepared, start, units)

        def write(index: np.ndarray, values: dict[str, Any]) -> None:
            with stage("write"):
                file.write(index, values)

        with file.output:
            schedule = Schedule(request.checkpoint, request.checkpoint_count, start.reached or 0)
            with stage("write"):
                motion, members = file.of_motion(schedule), file.of_members(schedule)
            try:
                with stage("integrate"):
                    for group in groups:
                        outcome = follow_ensemble(
                            group.prepared,
                            ensemble_method(group.prepared, partial(alone, group.ensemble, request), motion),
                            ensemble.values,
                            ensemble.families,
                            ensemble.times,
                            write,
                            watched(pace, interrupted),
                            sampled=ensemble.sampled and ensemble.cut is None,
                            threads=threads,
                            checkpointing=members,
                            section=None if ensemble.cut is None else ensemble.cut.kept,
                            chosen=group.chosen,
                            explain=partial(cause, group.ensemble),
                        )
                        members = members and members.beginning(outcome)
            except Unfit as error:
                raise damaged(start.target.shown) from error
            progress.clear()
            with stage("write"):
                said = told(ensemble, outcome, describe(file, outcome), file.events)
                sentences = [in_words(ensemble.spec, ending.value) for ending in Ending]
                written = file.close({**start.made_by, **said}, sentences, outcome)
    return file, outcome, written or start.target
