"""``Motion``: a motion to be followed, and from it to its compiled form."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING, Any, TypeAlias

from lagrange_cli.integrate.methods.table import METHODS, STIFF
from lagrange_cli.integrate.precision import DOUBLE
from lagrange_cli.records import dataclass
from lagrange_cli.run.derive import read_run
from lagrange_cli.run.domains import check_domain
from lagrange_cli.run.jumps import check_energies
from lagrange_cli.run.monitor import Monitor, Stage, untimed
from lagrange_cli.run.pace import Pace
from lagrange_cli.run.prepare import prepare_run
from lagrange_cli.run.request import HDF5
from lagrange_cli.run.start import NOTHING, Begin, consistent_values, rounding_of_run
from lagrange_cli.run.strength import with_proofs

if TYPE_CHECKING:
    import numpy as np

    from lagrange_cli.integrate.certify.certificate import Certificate
    from lagrange_cli.integrate.checkpoint import Checkpointing, Progress
    from lagrange_cli.integrate.method import Cause, End
    from lagrange_cli.integrate.outcome import Outcome
    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.integrate.times import Times
    from lagrange_cli.run.certify import Demand
    from lagrange_cli.run.derive import Examine
    from lagrange_cli.run.request import Request
    from lagrange_cli.run.settings.settings import Settings
    from lagrange_cli.spec.spec import Spec
    from lagrange_cli.spec.values import Values

Prepare: TypeAlias = "Callable[..., Prepared]"
Consistent: TypeAlias = "Callable[..., tuple[Spec, Values, Begin]]"
Check: TypeAlias = "Callable[[Spec, Mapping[str, float]], None]"


@dataclass(frozen=True)
class Motion:
    """A motion to be followed: the system, the values of its parameters and its initial state, and the
    settings. ``begin`` says how the initial state was made consistent with the constraints."""

    spec: Spec
    values: Values
    settings: Settings
    begin: Begin = NOTHING

    @property
    def may_be_stiff(self) -> bool:
        """Whether a trial may find another method than the one of the settings (``run.trial``)."""
        settings, spec = self.settings, self.spec
        finest, _ = METHODS[STIFF].tolerances[DOUBLE]
        chosen = settings.automatic and settings.without_implicit.method != STIFF
        if not chosen or settings.wanted < finest or not any(spec.forces.values()):
            return False
        if not spec.events:
            return True
        from lagrange_cli.run.linear_events import are_linear

        return are_linear(spec)

    def cause(self, end: End) -> Cause | None:
        """The reason in the system for the end of the motion, if it could not go on."""
        from lagrange_cli.integrate.ending import Ending

        if end.ending is Ending.COMPLETE:
            return None
        if self.spec.bodies:
            from lagrange_cli.run.singular import singular_angles

            found = singular_angles(self.spec, self.values.parameters, self.settings.start, end)
            if found is not None:
                return found
        if self.spec.all_constraints:
            from lagrange_cli.run.singular import singular_constraints

            found = singular_constraints(self.spec, self.values.parameters, self.settings.start, end)
            if found is not None:
                return found
        from lagrange_cli.run.singular import STUCK, singular_masses

        if end.ending in (*STUCK, Ending.CRAWLING, Ending.EDGE):
            from lagrange_cli.run.causes import explained, too_long

            found = explained(self.spec, self.values.parameters, self.settings.start, end)
            found = found or too_long(self.settings.start, self.settings.stop, end)
            if found is not None:  # L may have no value there, and no masses
                return found
        long = self.settings.precision != DOUBLE
        return singular_masses(self.spec, self.values.parameters, self.settings.start, end, long=long)


@dataclass(frozen=True)
class Ready:
    """A motion with its compiled code, and what an error estimate takes: the ``companions``, and by how much
    the numbers as they are written exceed those of the run. So many ``threads`` share its work,
    one on each processor if there is no number."""

    motion: Motion
    prepared: Prepared
    companions: Sequence[Prepared] = ()
    rounding: Values | None = None
    threads: int | None = None

    @property
    def times(self) -> Times:
        """When the motion is sampled."""
        from lagrange_cli.integrate.times import Times

        settings = self.motion.settings
        return Times(settings.start, settings.stop, settings.count, settings.step)


def read_motion(
    content: bytes,
    filename: str,
    request: Request,
    stage: Stage = untimed,
    read: Examine | None = None,
    begin_at: Consistent = consistent_values,
) -> Motion:
    """The motion that ``request`` asks for of the system file with this ``content``.

    ``read`` and ``begin_at`` stand for ``spec.read.examine`` and ``consistent_values``, where what they find
    is kept.

    Raises ``SpecError`` where the file is wrong, ``UsageError`` where the request is.
    """
    with stage("import"):
        from lagrange_cli.spec.values import resolve_long_values, resolve_portable_values, resolve_values
    with stage("parse"):
        resolve = resolve_portable_values if request.portable else resolve_values
        if request.precision != DOUBLE:
            resolve = resolve_long_values
        spec, values = read_run(
            content,
            filename,
            request.sizes,
            lambda spec, problems: resolve(spec, request.overrides, problems),
            read,
        )
        settings = request.settings(spec, values.parameters)
        exact = request.portable or request.precision != DOUBLE
        with stage("start"):
            spec, values, begin = begin_at(
                spec, values, settings.start, request.overrides, forced=request.projected, exact=exact
            )
        return Motion(spec, values, settings, begin)


def initial_state(values: Values) -> list[Any]:
    """The initial state as the output describes it: q, v, and their low parts if there are any."""
    rest = values.remainder
    return [values.q, values.v, *([] if rest is None else [rest.q, rest.v, dict(rest.parameters)])]


def prepare_all(
    motion: Motion,
    request: Request,
    demand: Demand | None,
    stage: Stage,
    prepare: Prepare = prepare_run,
    check: Check = check_energies,
) -> Ready:
    """Compile the motion, and the companions that a certificate needs: these while LLVM compiles.

    ``prepare`` and ``check`` stand for ``prepare_run`` and ``check_energies``, where what they find is kept.
    """
    check(motion.spec, motion.values.parameters)
    check_domain(motion.spec, motion.values, motion.settings.start)
    companions: list[Prepared] = []
    spec, rounding = motion.spec, None
    settings = with_proofs(spec, motion.settings, iter([motion.values]))

    def meanwhile() -> None:
        import_the_rest(request.format)
        if demand is not None:
            from lagrange_cli.integrate.certify.companion import FACTORS
            from lagrange_cli.run.certify import companion_settings

            chosen, orders = companion_settings(settings)
            for order, factor in zip(orders, FACTORS):
                companions.append(
                    prepare(spec, chosen, stage, cached=request.cache, order=order, factor=factor)
                )

    prepared = prepare(spec, settings, stage, cached=request.cache, meanwhile=meanwhile)
    if demand is not None:
        rounding = rounding_of_run(
            spec, motion.values, settings.start, request.overrides, forced=request.projected
        )
    return Ready(motion, prepared, companions, rounding, request.threads)


def import_the_rest(form: str) -> None:
    """Import what the integration needs, above all numpy and h5py."""
    import lagrange_cli.integrate.methods.taylor
    import lagrange_cli.integrate.run

    if form == HDF5:
        import lagrange_cli.store.writer  # noqa: F401


def certificate_of(ready: Ready, demand: Demand | None) -> AbstractContextManager[Certificate | None]:
    """The certificate asked for, if one is."""
    if demand is None:
        return nullcontext()
    from lagrange_cli.integrate.certify.certificate import Certificate

    assert ready.rounding is not None
    given = ready.companions, ready.motion.values, ready.rounding, ready.times
    return Certificate(*given, demand.digits, demand.target)


def follow(
    ready: Ready,
    demand: Demand | None,
    monitor: Monitor,
    emit: Callable[[dict[str, np.ndarray]], None],
    interrupted: Callable[[], bool],
    emit_events: Callable[[dict[str, np.ndarray]], None] = lambda chunk: None,
    checkpointing: Checkpointing[Progress] | None = None,
) -> Outcome:
    """Integrate a motion (see ``integrate.run.integrate``), with an estimate of its errors if there is a
    ``demand``."""
    from lagrange_cli.integrate.run import integrate

    progress, name = monitor.progress(), ready.motion.spec.name
    pace = Pace(ready.times.stop, progress, lambda text: monitor.warn(f"{name}: {text}"))
    with monitor.stage("integrate"), certificate_of(ready, demand) as certificate:
        outcome = integrate(
            ready.prepared, ready.motion.values, ready.times, emit, interrupted,
            progress=pace.show, checkpointing=checkpointing, certificate=certificate,
            explain=ready.motion.cause, emit_events=emit_events, threads=ready.threads,
        )  # fmt: skip
    progress.clear()
    return outcome
