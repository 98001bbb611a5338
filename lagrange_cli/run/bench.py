"""``bench``: methods and tolerances compared, each by its run time and its error."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

from lagrange_cli.integrate.methods.table import METHODS, TAYLOR, Needs
from lagrange_cli.integrate.precision import DOUBLE, FULL_PRECISION
from lagrange_cli.outputs.catalog import DEFAULT_OUTPUTS
from lagrange_cli.records import dataclass, replace
from lagrange_cli.run.derive import derive_system
from lagrange_cli.run.domains import check_domain
from lagrange_cli.run.monitor import Interrupted, Silence, Stage, untimed
from lagrange_cli.run.monitor import ignore as unseen
from lagrange_cli.run.pace import Pace
from lagrange_cli.run.settings.methods import resolve_tolerance
from lagrange_cli.run.settings.settings import resolve_settings
from lagrange_cli.run.start import consistent_values
from lagrange_cli.run.times import with_times
from lagrange_cli.spec.spec import SolveDefaults

if TYPE_CHECKING:
    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.integrate.times import Times
    from lagrange_cli.spec.spec import Spec
    from lagrange_cli.spec.values import Values
    from lagrange_cli.work_precision.measure import Contender, Result, Rules
    from lagrange_cli.work_precision.reference import Reference
    from lagrange_cli.work_precision.trajectory import Trajectory

Tell = Callable[[int, int, object], None]
"""Gets the number of measurements done, their total number, and the next one."""

TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
MOST_WITH_JACOBIAN = 32
"""Coordinates up to which scipy's implicit methods run unasked: larger Jacobians take long to compile."""

BETTER = 100
"""The reference must be more accurate than the wanted error by this factor."""
PATIENCE = 5
"""Budgets that each of the reference's runs may take: its steps are several times as short."""


def ignore(done: int, count: int, what: object) -> None:
    """Shows nothing."""


def never() -> bool:
    """Never interrupts."""
    return False


@dataclass(frozen=True)
class Ranking:
    """The results for a system of so many ``degrees`` of freedom, and the error that is ``wanted``."""

    name: str
    degrees: int
    wanted: float
    reference: Reference
    results: tuple[Result, ...]


def entries_of(
    methods: Sequence[str] | None,
    tolerances: Sequence[float] | None,
    degrees: int,
    *,
    constrained: bool = False,
) -> dict[str, Sequence[float]]:
    """The tolerances to be tried, by method.

    Without ``methods`` all are, except those that cannot keep a ``constrained`` system to its constraints,
    and scipy's implicit ones for a system of many ``degrees`` of freedom.
    """
    names = [name for name, row in METHODS.items() if row.constrains or not constrained]
    names = names if methods is None else list(methods)
    if methods is None and degrees > MOST_WITH_JACOBIAN:
        names = [name for name in names if METHODS[name].needs is not Needs.JACOBIAN]
    own = {name: (*TOLERANCES, *full_precision_of(name)) for name in names}
    return {name: own[name] if tolerances is None else tolerances for name in names}


def full_precision_of(method: str) -> tuple[float, ...]:
    """The tolerance of full double precision, for a method that has it by default."""
    _, default = METHODS[method].tolerances[DOUBLE]
    return (default,) if default == FULL_PRECISION else ()


def count(entries: Mapping[str, Sequence[float]]) -> int:
    """The number of contenders."""
    return sum(len(set(tolerances)) for tolerances in entries.values())


def rank_methods(
    spec: Spec,
    values: Values,
    stop: str | None,
    wanted: float,
    entries: Mapping[str, Sequence[float]],
    rules: Rules,
    stage: Stage = untimed,
    tell: Tell = ignore,
    interrupted: Interrupted = never,
    given: Collection[str] = (),
    note: Callable[[str], None] = unseen,
) -> Ranking:
    """Measure the time and the error of the methods ``entries`` at their tolerances.

    ``given`` are the names of initial values that are given besides those of the file.

    Errors are relative to the size of q, and to a reference whose own error is far below the one that is
    ``wanted``. It is followed to the file's stop time, or ``stop``, an expression in parameters. If it is
    ``interrupted``, the results so far are returned. ``note`` gets what the user should know at once.

    Raises:
        SpecError: no equations of motion can be derived.
        UsageError: the stop time makes no sense.
        MotionError: no useful part of the motion can be computed accurately enough.
        KeyboardInterrupt: it is interrupted before there is a reference.
    """
    from lagrange_cli.work_precision.measure import measure_all
    from lagrange_cli.work_precision.reference import TOLERANCES as OF_REFERENCE
    from lagrange_cli.work_precision.reference import find_reference
    from lagrange_cli.work_precision.trajectory import SAMPLES, follow

    times = {} if stop is None else {"stop": stop}
    settings = resolve_settings(
        spec, with_times(SolveDefaults(samples=SAMPLES), times, spec, values.parameters)
    )
    spec, values, _ = consistent_values(spec, values, settings.start, given)
    check_domain(spec, values, settings.start)
    with stage("derive"):
        prepare = preparing(spec, settings.backward)

    def reference_run(prepared: Prepared, times: Times) -> Trajectory:
        budget = PATIENCE * rules.budget
        followed = follow(prepared, values, times, budget, interrupted, pace.show)
        if interrupted():
            raise KeyboardInterrupt
        return followed

    pace = Pace(settings.stop, Silence(), lambda text: note(f"{spec.name}: {text}"))
    tell(0, count(entries), "reference")
    reference = find_reference(
        [partial(reference_run, prepare(TAYLOR, tolerance)) for tolerance in OF_REFERENCE],
        settings.start,
        settings.stop,
        wanted / BETTER,
        groups_of(spec),
    )
    results: list[Result] = []

    def prepare_next(contender: Contender) -> Prepared:
        resolve_tolerance(contender.tolerance, contender.method)
        tell(len(results), count(entries), contender)
        return prepare(contender.method, contender.tolerance)

    for result in measure_all(entries, prepare_next, values, reference, rules, interrupted):
        results.append(result)
    return Ranking(spec.name, spec.degrees_of_freedom, wanted, reference, tuple(results))


def preparing(spec: Spec, backward: bool) -> Callable[[str, float], Prepared]:
    """A function that compiles the system for a method and tolerance: at once as well as for a long run."""
    from lagrange_cli.integrate.compilation import Compilation
    from lagrange_cli.integrate.methods.selection import follower
    from lagrange_cli.integrate.prepare import prepare

    residual = derive_system(spec)
    compiled: dict[Needs, Prepared] = {}

    def prepared(method: str, tolerance: float) -> Prepared:
        asked = Compilation(method, tolerance, frozenset(DEFAULT_OUTPUTS), backward=backward)
        needs = METHODS[method].needs
        if needs in (Needs.SERIES, Needs.STEPS):
            return prepare(residual, asked)
        if needs not in compiled:  # these programs serve several methods, at any tolerance
            compiled[needs] = prepare(residual, asked)
        following = follower(compiled[needs].machine, asked)
        return replace(compiled[needs], compilation=asked, follower=following)

    return prepared


def groups_of(spec: Spec) -> list[str]:
    """Which coordinates are measured against one size: those of one unit, else those of one family."""
    from lagrange_cli.expression.vocabulary import family_name

    return [f"in {each.unit}" if each.unit else family_name(each.name) for each in spec.coordinates]
