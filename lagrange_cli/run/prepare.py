"""From a system and its settings to a run that is ready to go."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING

from lagrange_cli.errors import TooLargeSystem, TooManyNumbers
from lagrange_cli.integrate.methods.table import METHODS, Needs
from lagrange_cli.integrate.precision import DOUBLE
from lagrange_cli.limits import limit, way_out
from lagrange_cli.records import replace
from lagrange_cli.run.derive import derive_system, located, many_members
from lagrange_cli.run.jumps import with_actions_judged
from lagrange_cli.run.monitor import Stage, untimed

if TYPE_CHECKING:
    from lagrange_cli.expression.node import Node
    from lagrange_cli.integrate.compilation import Compilation
    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.mechanics.residual import Residual
    from lagrange_cli.model.model import Model
    from lagrange_cli.run.foresight import Measure
    from lagrange_cli.run.settings.settings import Settings
    from lagrange_cli.spec.spec import Spec


def nothing() -> None:
    """Load nothing."""


def foresee(settings: Settings, model: Model[Node]) -> None:
    """Refuse at once what would be refused after its equations have been derived."""
    from lagrange_cli.integrate.convolutions import foresee_convolutions

    foresee_convolutions(model, settings.method, settings.precision)
    if model.events and METHODS[settings.method].needs is Needs.SERIES:
        from lagrange_cli.mechanics.contacts import foresee_contacts

        foresee_contacts(model)


def measures_of(method: str, precision: str) -> Sequence[Measure]:
    """What smaller systems show of the equations of a large one, for a method."""
    if METHODS[method].needs is not Needs.SERIES:
        return []
    from lagrange_cli.integrate.convolutions import refuse_like
    from lagrange_cli.run.foresight import Measure

    def refuse(found: int, alike: Residual) -> None:
        refuse_like(alike, found, precision, "at least ")

    return [Measure(lambda residual: residual.costs, refuse)]


def foresee_matrices(count: int) -> None:
    """Raise ``TooManyNumbers`` where derivatives by so many coordinates, and the matrix that scipy makes of
    them, take too much memory."""
    numbers = 3 * count**2 + (2 * count) ** 2
    if numbers > limit("numbers"):
        raise TooManyNumbers(
            f"the matrices of implicit steps of this system are {numbers} numbers, more than "
            f"{limit('numbers'):.0f}",
            f"choose --method DOP853, make the system smaller, {way_out('numbers')}",
        )


@contextmanager
def named(spec: Spec, compilation: Compilation) -> Iterator[None]:
    """A context in which errors of systems that are too large say what members are written out for."""
    try:
        yield
    except TooLargeSystem as error:
        if not many_members(spec):
            raise
        from lagrange_cli.integrate.families import family_run_or_why
        from lagrange_cli.integrate.written_out import OTHER, WrittenOut, unsuited
        from lagrange_cli.spec.source import Source

        found = family_run_or_why(spec, compilation)
        if not isinstance(found, WrittenOut):
            raise
        found = unsuited(spec) if found is OTHER else found
        first, *others = error.problems
        message = f"{first.message}; members are written out for {found.what}"
        first = replace(first, message=message, hint=f"{found.way}, or {first.hint}")
        if found.place is not None:
            first = Source(spec.filename, spec.text).problem(found.place, first.message, first.hint)
        raise TooLargeSystem(error.filename, [first, *others]) from error


def prepare_run(
    spec: Spec,
    settings: Settings,
    stage: Stage = untimed,
    *,
    cached: bool,
    ensemble: bool = False,
    few: bool = False,
    order: int | None = None,
    section: str = "",
    factor: int | None = None,
    meanwhile: Callable[[], object] = nothing,
) -> Prepared:
    """Compile a system for a run, or take the code from the cache of earlier runs if it may be ``cached``.

    Code for an ``ensemble`` follows many motions, or a ``few``, through a ``section`` of a kind if that is
    given. ``order`` is that of the Taylor series; without it, it follows from the tolerance. With a
    ``factor`` the code is that of a companion. ``meanwhile`` is called while LLVM compiles: it loads what the
    run needs next.

    Raises ``SpecError`` if no equations of motion can be derived, or they are too large to be compiled.
    """
    with stage("import"):
        from lagrange_cli.integrate.prepare import prepare_system
        from lagrange_cli.native.compilation.cache import find_cache
    compilation = settings.compilation(
        ensemble=ensemble, few=few, order=order, section=section, factor=factor
    )
    with named(spec, compilation), located(spec):
        if METHODS[settings.method].needs is Needs.JACOBIAN:
            foresee_matrices(len(spec.coordinates))
        prepared = prepare_system(
            spec,
            partial(
                derive_system,
                exact=settings.precision != DOUBLE or factor is not None,
                portable=settings.portable,
                resting=True,
                foresee=partial(foresee, settings),
                measures=partial(measures_of, settings.method, settings.precision),
            ),
            find_cache(wanted=cached),
            compilation,
            stage=stage,
            meanwhile=meanwhile,
        )
        return with_actions_judged(spec, prepared)
