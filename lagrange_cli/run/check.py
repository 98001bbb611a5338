"""``check``: what kind of system a file describes, and what a run of it leaves out."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from lagrange_cli.errors import TooLarge, TooLargeSystem
from lagrange_cli.integrate.methods.table import AUTO, TAYLOR
from lagrange_cli.integrate.precision import DOUBLE, FULL_PRECISION
from lagrange_cli.outputs.catalog import OUTPUTS
from lagrange_cli.records import dataclass, replace
from lagrange_cli.run.choice import chosen_method
from lagrange_cli.run.derive import derive_system, located
from lagrange_cli.run.domains import check_domain
from lagrange_cli.run.doubtful import (
    contradicting_units,
    odd_dissipation,
    rounded_equalities,
    singular_poses,
    singular_start,
    unused_names,
)
from lagrange_cli.run.integrability import undecided, velocity_constraints
from lagrange_cli.run.jumps import check_energies
from lagrange_cli.run.monitor import Stage, untimed
from lagrange_cli.run.prepare import measures_of, named
from lagrange_cli.run.settings.methods import resolve_method, resolve_tolerance
from lagrange_cli.run.settings.outputs import ALL, default_outputs, optional_outputs, resolve_outputs
from lagrange_cli.run.start import NOTHING, Begin, consistent_values

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from lagrange_cli.errors import Problem
    from lagrange_cli.expression.node import Node
    from lagrange_cli.mechanics.conservation import Conserved
    from lagrange_cli.mechanics.constrained.frobenius import Integrability
    from lagrange_cli.mechanics.residual import Dependent
    from lagrange_cli.model.model import Model
    from lagrange_cli.spec.spec import Spec
    from lagrange_cli.spec.values import Values


@dataclass(frozen=True)
class Eliminated:
    """A ``coordinate`` that follows from a linear ``constraint``: what it is, or where only its velocity
    follows, what that is."""

    coordinate: str
    constraint: str
    quantity: str
    expression: str


@dataclass(frozen=True)
class Mechanics:
    """What the equations of motion show: what depends on time explicitly (``depending``), which coordinates
    are ``cyclic``, all that every motion keeps (between events), and whether there are ``applied`` forces.
    ``engine`` says how the equations are integrated, sentence by sentence; ``convolutions`` are those of each
    formulation an order."""

    depending: tuple[str, ...]
    cyclic: tuple[str, ...]
    conserved: tuple[Conserved, ...]
    applied: bool
    engine: tuple[str, ...]
    formulation: str
    convolutions: Mapping[str, int]
    structure: tuple[str, ...] = ()
    """What the system is made of, in sentences."""
    model: Model[Node] | None = None
    """What they were derived from, member by member."""
    eliminated: tuple[Eliminated, ...] = ()
    """The coordinates that follow from constraints beforehand."""
    searched: bool = True
    """Whether the search for conserved quantities came to its end."""
    too_large: tuple[str, ...] = ()
    """The outputs for which members would have to be written out that are many."""


@dataclass(frozen=True)
class Classification:
    """A system, and what is known of it before any run.

    ``skipped`` says what a run does not compute. ``warnings`` are places of the file that are allowed and
    perhaps not meant (``doubtful``). ``begin`` says how the initial state became consistent,
    ``integrability`` which constraints on velocities, and combinations of them, are holonomic after all, and
    ``integrals`` has the functions that these keep constant, by name, as far as they are found.
    """

    spec: Spec
    mechanics: Mechanics
    skipped: tuple[str, ...]
    warnings: tuple[Problem, ...]
    begin: Begin = NOTHING
    integrability: Integrability | None = None
    integrals: Mapping[str, str] = {}


def classify(
    spec: Spec, stage: Stage = untimed, values: Values | None = None, given: Collection[str] = ()
) -> Classification:
    """Derive the equations of motion of a system, and say what follows from them.

    With ``values`` also say how its initial state, of which some values are ``given`` besides those of the
    file, becomes consistent with its constraints, and which of these depend on others.

    Raises ``SpecError`` where none can be derived, where the method of the file cannot follow them, or where
    numbers of its section ``draw`` make no sense.
    """
    method, begin = resolve_method(spec.solve.method), NOTHING
    asked = default_outputs(spec) if spec.solve.outputs is None else spec.solve.outputs
    outputs = resolve_outputs(asked, has_particles=spec.lagrangian is None)
    if method == AUTO:
        method, _ = chosen_method(spec, outputs, resolve_tolerance(spec.solve.tolerance, TAYLOR))
    if values is not None:
        with stage("start"):
            start = spec.solve.start or 0.0
            spec, consistent, begin = consistent_values(spec, values, start, given)
        check_energies(spec, values.parameters)
        check_domain(spec, consistent, start)
    with stage("derive"), located(spec):
        mechanics = of_families(spec, method, outputs)
        if mechanics is None:
            mechanics = of_members_or_less(spec, method, outputs, optional_outputs(asked))
        if values is not None and spec.bodies:
            mechanics = with_this_motion(mechanics, consistent)
    if spec.draw is not None and values is not None:
        from lagrange_cli.drawing.draw import draw

        draw(spec, values, spec.solve.start or 0.0)
    warnings = (*contradicting_units(spec), *rounded_equalities(spec), *unused_names(spec))
    if values is not None:
        warnings += odd_dissipation(spec, values.parameters)
    if values is not None:
        poses = singular_poses(spec, consistent) if spec.bodies else ()
        warnings += poses or singular_start(spec, consistent)
    parameters = {} if values is None else values.parameters
    found, integrals = velocity_constraints(spec, mechanics.model, parameters)
    skipped = (*left_out(mechanics, left_out_of(spec)), *undecided(spec, found))
    return Classification(spec, mechanics, skipped, warnings, begin, found, integrals)


def of_families(spec: Spec, method: str, outputs: frozenset[str]) -> Mechanics | None:
    """The mechanics of a system that ``solve`` follows as one of families; None if it is not."""
    if not spec.coordinate_families:
        return None
    from lagrange_cli.families.conserved.conservation import constants_of
    from lagrange_cli.integrate.compilation import Compilation
    from lagrange_cli.integrate.families import engine, family_run
    from lagrange_cli.integrate.family_program import write_families

    compilation = Compilation(method, FULL_PRECISION, outputs)
    system = family_run(spec, compilation)
    if system is None:
        return None
    write_families(system, compilation)  # refuses what is too large
    constants = constants_of(system)
    if spec.lagrangian is None:
        depending = ("positions",) if system.moved_in_time else ()
    else:
        depending = ("L",) if constants.timed else ()
    return Mechanics(
        depending, constants.cyclic, constants.conserved, system.driven, engine(system), "Lagrange", {}
    )


def of_members_or_less(
    spec: Spec, method: str, outputs: frozenset[str], optional: frozenset[str]
) -> Mechanics:
    """The mechanics member by member, or where that is too large, without optional outputs, as in
    ``integrate.prepare``."""
    try:
        return of_members(spec, method, outputs)
    except (TooLarge, TooLargeSystem):
        from lagrange_cli.integrate.compilation import Compilation
        from lagrange_cli.integrate.families import without_expansion

        asked = Compilation(method, FULL_PRECISION, outputs, optional=optional)
        less = without_expansion(spec, asked)[1]
        found = None if less is None else of_families(spec, method, less.outputs)
        if found is None or less is None:
            raise
        return replace(found, too_large=tuple(sorted(outputs - less.outputs)))


def of_members(spec: Spec, method: str, outputs: frozenset[str]) -> Mechanics:
    """The mechanics of any system, derived member by member."""
    from lagrange_cli.integrate.compilation import Compilation
    from lagrange_cli.integrate.convolutions import check_convolutions, foresee_convolutions
    from lagrange_cli.mechanics.conserved.related import related
    from lagrange_cli.mechanics.conserved.symmetries import symmetries
    from lagrange_cli.mechanics.derive import depending_on_time
    from lagrange_cli.mechanics.omitted_work import engine, has_forces
    from lagrange_cli.mechanics.structure import structure
    from lagrange_cli.mechanics.variables import variables
    from lagrange_cli.native.elimination import reduced

    with named(spec, Compilation(method, FULL_PRECISION, outputs)):
        residual = derive_system(
            spec,
            foresee=lambda model: foresee_convolutions(model, method, DOUBLE),
            measures=partial(measures_of, method, DOUBLE),
        )
        check_convolutions(residual, method, DOUBLE)
    with residual.graph.work.apart():
        less = reduced(residual)
        integrated = residual if less is None else less.after
        cut = residual.graph.work.cut
        model = residual.independent
        found = symmetries(model, residual.conserved)
        found = (*found, *related(model, residual.conserved, found))
        further = tuple(one.conserved for one in found)
        cut = residual.graph.work.cut - cut
        return Mechanics(
            depending_on_time(residual.model),
            residual.cyclic,
            (*residual.conserved, *further),
            has_forces(residual),
            engine(integrated),
            integrated.formulation,
            integrated.costs,
            structure(residual),
            model,
            tuple(eliminated(one, variables(residual.model)) for one in integrated.dependent),
            searched=not cut,
        )


def with_this_motion(mechanics: Mechanics, values: Values) -> Mechanics:
    """With what only some motions keep, if the one that begins at these values does."""
    from lagrange_cli.expression.vocabulary import velocity_name
    from lagrange_cli.mechanics.conserved.symmetries import on_motions
    from lagrange_cli.mechanics.variables import graph_of

    model = mechanics.model
    if model is None:
        return mechanics
    known = {
        **dict(zip(model.coordinates, values.q)),
        **dict(zip(map(velocity_name, model.coordinates), values.v)),
    }
    with graph_of(model).work.apart():
        kept = on_motions(model, {**values.parameters, **known})
    return replace(mechanics, conserved=(*mechanics.conserved, *kept))


def eliminated(one: Dependent, moving: int) -> Eliminated:
    """What is said of a coordinate that follows from others; symbols that are ``moving`` come last."""
    from lagrange_cli.expression.text import text_of
    from lagrange_cli.expression.vocabulary import velocity_name

    if one.place is None:
        return Eliminated(
            one.name, one.constraint, velocity_name(one.name), text_of(one.speed, moving=moving)
        )
    return Eliminated(one.name, one.constraint, one.name, text_of(one.place, moving=moving))


def left_out(mechanics: Mechanics, outputs: Sequence[str]) -> tuple[str, ...]:
    """What ``solve`` does not compute for this system, a sentence each; ``outputs`` are those that it has and
    that the file does not ask for."""
    said = [] if mechanics.applied else ["generalized forces: all of them are zero"]
    if not mechanics.searched:
        said.append("further conserved quantities: looking for all of them takes too much work")
    if mechanics.too_large:
        what = "members of families would have to be written out, and are many"
        said.append(f"{', '.join(mechanics.too_large)}: {what}")
    if outputs:
        said.append(f"{', '.join(outputs)}: computed only if --outputs asks for them")
    return tuple(said)


def left_out_of(spec: Spec) -> list[str]:
    """The outputs that the system has and that ``solve`` leaves out by default."""
    particles = spec.lagrangian is None
    has = resolve_outputs((ALL,), has_particles=particles)
    asked = resolve_outputs(spec.solve.outputs or default_outputs(spec), has_particles=particles)
    none = {name for name, row in OUTPUTS.items() if row.section and not getattr(spec, row.section)}
    return [name for name in OUTPUTS if name in has - asked - none]
