"""Which runs are followed without expanding families (see ``families.system``), and why others are not."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from typing import TYPE_CHECKING

from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.families.arrays import Array, Total
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.jumps import is_root
from lagrange_cli.families.poles import moving, shown_slowly, slow
from lagrange_cli.families.reactions import reactions
from lagrange_cli.families.switching.smooth import passing_where_parameters_jump
from lagrange_cli.families.system import any_family_system, family_system, mostly_single, with_all_constraints
from lagrange_cli.integrate.methods.table import MANY_BODIES, METHODS, TAYLOR, Needs
from lagrange_cli.integrate.precision import DOUBLE
from lagrange_cli.integrate.written_out import OTHER, WrittenOut, without_outputs
from lagrange_cli.mechanics.defect import hides, is_distance, shows
from lagrange_cli.mechanics.switching.lengths import bases
from lagrange_cli.native.families.loops import needed
from lagrange_cli.native.members import SECTION
from lagrange_cli.records import replace

if TYPE_CHECKING:
    from lagrange_cli.integrate.compilation import Compilation
    from lagrange_cli.spec.spec import Spec

OF_CONSTRAINTS = frozenset({"constraints", "multipliers"})
"""Those of all constraints, also of those that are left out."""
OUTPUTS = frozenset(
    {"q", "v", "p", "h", "T", "U", "energy", "positions", "observables", "conserved", "reactions"}
    | OF_CONSTRAINTS
)
"""The outputs that can be computed with families; others go through the members."""
OF_BODIES = frozenset({"angular_velocities", "angular_momenta", "rotational_energies", "orientations"})
"""Those that systems with rigid bodies have besides."""
INTEGRALS = frozenset({"ledger", "action"})
"""Those that are integrated beside the motion."""
FEWEST_COSTLY = 100
"""Coordinates from which on members are not written out for outputs that were not asked for by name: each
takes 5 to 30 ms."""
FEWEST_PROVEN = 500
"""Terms of all sums from which on it takes long, or is refused, to write members out for proofs of steps."""
FEWEST_DAMPED = 100
"""Those from which on this takes longer than most motions that implicit steps can follow in loops."""
TO_BE_PROVEN = "steps that have to be proven, on chains, with constraints, contact, friction"
FEWEST_ONE_BY_ONE = 1000
"""Terms of all sums from which on the motions of an ensemble are followed one by one."""


def suited(spec: Spec, outputs: Collection[str]) -> FamilySystem | None:
    """The system as one of families, if ``ias15`` can follow it so and no force hides."""
    if spec.events or not known(outputs):
        return None
    system = in_loops(spec, MANY_BODIES)
    if system is None or system.bonds is not None or system.smooth is not None:
        return None
    return None if narrow(system, MANY_BODIES) or system.mixed else system


def unprovable(spec: Spec, outputs: Collection[str], method: str = MANY_BODIES) -> bool:
    """Whether members of a large system would be written out since steps by series have to be proven, and are
    not for steps of another method. Implicit ones miss no force then."""
    from lagrange_cli.integrate.compilation import Compilation

    by_series, by_rates = (Compilation(one, 0.0, frozenset(outputs)) for one in (TAYLOR, method))
    found, system = family_run_or_why(spec, by_series), family_run(spec, by_rates)
    if system is None or not isinstance(found, WrittenOut) or found.what != TO_BE_PROVEN:
        return False
    if METHODS[method].approaches:
        return system.terms >= FEWEST_DAMPED and not narrow(system, method)
    return system.terms >= FEWEST_PROVEN


def in_loops(spec: Spec, method: str, algebra: type[GraphAlgebra] = GraphAlgebra) -> FamilySystem | None:
    """The system as one of families, if its members are followed in loops: if they are many, or if forces
    hide from ``method`` only where members are written out."""
    system = family_system(spec, algebra)
    if system is not None or method != MANY_BODIES or not spec.coordinate_families:
        return system
    few = any_family_system(spec, algebra)
    if few is None or any((few.joints, few.bonds, few.smooth, few.events, few.bodies, few.first_order)):
        return None
    if mostly_single(few):
        return None
    return few if narrow(few, large=False) and not narrow(few, MANY_BODIES, large=False) else None


def dragged(spec: Spec) -> FamilySystem | None:
    """The system as one of families, if it has drag along a vector of velocities, which may be 0."""
    system = family_system(spec)
    if system is None:
        return None
    smooth = system.smooth or system
    totals = needed([smooth.forces, *smooth.loads], smooth.slots)
    nodes = [term.node for total in totals for term in total.terms]
    variables, speeds = moving(smooth)[0], speedy(smooth, totals)
    found = bases(nodes, speeds)
    return (
        system if any(is_distance(one, variables) for one in found if one.kind is not Kind.SWITCH) else None
    )


def speedy(system: FamilySystem, totals: Iterable[Total]) -> int:
    """The symbols of velocities, and of those totals that contain some, each behind those it is made of."""
    slots, made = system.slots, set[Array]([system.v])
    for total in totals:
        if any(slot.array in made for term in total.terms for _, slot in slots.inside(term.node)):
            made.add(total)
    return slots.symbols_of(*made)


def known(outputs: Collection[str]) -> bool:
    """Whether the outputs can be computed with families."""
    return (OUTPUTS | OF_BODIES).issuperset(outputs)


def family_run(spec: Spec, compilation: Compilation) -> FamilySystem | None:
    """The system as one of families, where that serves a run; else None."""
    found = family_run_or_why(spec, compilation)
    return None if isinstance(found, WrittenOut) else found


def family_run_or_why(spec: Spec, compilation: Compilation) -> FamilySystem | WrittenOut:
    """The same, or why members are written out."""
    method = compilation.method
    if METHODS[method].needs is Needs.JACOBIAN:
        return WrittenOut(f"--method {method}", "use --method taylor")
    outputs = compilation.outputs - INTEGRALS
    others = [one for one in sorted(outputs) if not known([one])]
    if others:
        return without_outputs(others)
    plain = compilation.precision == DOUBLE and compilation.factor is None
    if not plain and compilation.backward:
        kind = "--certify" if compilation.precision == DOUBLE else f"--precision {compilation.precision}"
        return WrittenOut(f"motion backward in time with {kind}", "let it go forward, or leave that out")
    redundant = sorted(outputs & OF_CONSTRAINTS) if spec.left_out else []
    system = in_loops(with_all_constraints(spec) if redundant else spec, method, algebra_for(compilation))
    if redundant and (system is None or not keeps_all(system)):
        return without_outputs(redundant)
    if system is None or (compilation.ensemble and not compilation.few and suits_lanes(system, method)):
        return OTHER
    return looped(system, compilation)


def looped(system: FamilySystem, compilation: Compilation) -> FamilySystem | WrittenOut:
    """The system as loops follow it, or why its members are written out, however few they are."""
    outputs = compilation.outputs - INTEGRALS
    if compilation.section == SECTION:
        from lagrange_cli.integrate.unchanging import may_be_conserved

        if may_be_conserved(system):
            return WrittenOut("a surface that may be conserved", "let --where depend on coordinates alone")
    if METHODS[compilation.method].needs is Needs.SERIES and unproven(system, compilation):
        way = "use --method ias15, which proves no steps"
        if compilation.proven:
            way = "leave out --proven"
        elif system.contacts is not None:
            way = "write forces that are less narrow"
        return WrittenOut(TO_BE_PROVEN, way)
    if outputs != compilation.outputs and system.moved_in_time:
        return without_outputs(sorted(INTEGRALS & compilation.outputs))
    worked = system.contacts is not None or (
        system.bonds is not None and system.smooth is not None and not held(system)
    )
    unknown = system.contacts is not None or held(system)
    if "multipliers" in compilation.outputs and unknown and system.bonds is not None:
        return without_outputs(["multipliers"])
    if "ledger" in compilation.outputs and worked:
        return without_outputs(["ledger"])
    of_constraints = sorted(outputs & OF_CONSTRAINTS)
    if system.first_order is not None and of_constraints:
        return without_outputs(of_constraints)
    timed = system.moved_in_time or system.timed_masses
    if compilation.backward and (timed or not system.steady_bonds):
        what = "motion backward in time where positions or masses depend on t"
        return WrittenOut(what, "let it go forward")
    if compilation.backward and not system.idle_bonds:
        return WrittenOut("motion backward in time where constraints do work", "let it go forward")
    acting = system.events is not None and bool(system.events.changed.size)
    if acting and compilation.backward:
        return WrittenOut("motion backward in time through actions of events", "let it go forward")
    if "reactions" in compilation.outputs and reactions(system) is None:
        return without_outputs(["reactions"])
    if system.smooth is not None and doubtful(system):
        passing = None if system.passes else passing_or_none(system)
        if passing is not None and not doubtful(passing):
            return passing
        way = "write them without roots and exponentials"
        return WrittenOut("arguments of switches whose zeros may hide", way)
    return system


def keeps_all(system: FamilySystem) -> bool:
    """Whether the constraints that follow from others are in the equations, too."""
    return system.bonds is not None and len(system.bonds.surplus) == len(system.spec.left_out)


def passing_or_none(system: FamilySystem) -> FamilySystem | None:
    """The system that passes where parameters say whether forces jump; None where that does not help."""
    try:
        return passing_where_parameters_jump(system)
    except Unsuited:
        return None


def without_expansion(
    spec: Spec, compilation: Compilation
) -> tuple[FamilySystem, Compilation] | tuple[None, None]:
    """The system as one of families, without those optional outputs that members would be written out for,
    and what it is compiled for then; twice None where members are written out for something else."""
    while isinstance(found := family_run_or_why(spec, compilation), WrittenOut):
        if not found.outputs or not compilation.optional.issuperset(found.outputs):
            return None, None
        compilation = replace(compilation, outputs=compilation.outputs.difference(found.outputs))
    return found, compilation


def without_costly(
    spec: Spec, compilation: Compilation
) -> tuple[FamilySystem, Compilation] | tuple[None, None]:
    """The same, where members are so many that writing them out costs much more than the motion."""
    optional = compilation.optional and len(spec.coordinates) >= FEWEST_COSTLY
    return without_expansion(spec, compilation) if optional else (None, None)


def in_loops_if_few(spec: Spec, compilation: Compilation) -> bool:
    """Whether the motions of an ensemble are followed one by one, in loops, only as they are few."""
    found = family_run(spec, replace(compilation, few=True))
    return found is not None and suits_lanes(found, compilation.method)


def suits_lanes(system: FamilySystem, method: str) -> bool:
    """Whether the motions of an ensemble are followed faster side by side, with members written out, and no
    force hides from the method then."""
    special = system.joints is not None or system.bonds is not None or system.smooth is not None
    if special or system.terms >= FEWEST_ONE_BY_ONE:
        return False
    return method != MANY_BODIES or not narrow(system, large=False)


def algebra_for(compilation: Compilation) -> type[GraphAlgebra]:
    """What the numbers of expressions are: not rounded for double-double numbers and for companions."""
    if compilation.precision != DOUBLE or compilation.factor is not None:
        from lagrange_cli.expression.exact import ExactGraphAlgebra

        return ExactGraphAlgebra
    if compilation.portable:
        from lagrange_cli.expression.exact import PortableGraphAlgebra

        return PortableGraphAlgebra
    return GraphAlgebra


def engine(system: FamilySystem) -> tuple[str, ...]:
    """How the equations are integrated, a sentence for each fact."""
    said = ["families are not expanded: the code has a loop over the members of each"]
    turns = system.bonds is not None and bool(system.bonds.surplus)
    if system.coupled_masses is not None:
        chosen = system.saddle is not None and system.saddle.pivoting
        sparse = None if turns or chosen else (system.saddle or system.coupled_masses).elimination
        by = f"its factor has {sparse.entries} entries" if sparse else "as a dense matrix"
        by = "in blocks of known rank" if turns else "in blocks with pivoting" if chosen else by
        if system.saddle is None:
            said.append(f"the mass matrix contains parameters only: it is factored once per run, {by}")
        elif system.bonds is None:
            said.append(f"the mass matrix is factored in each step, {by}")
        else:
            often = "once per run" if system.lasting_matrix and not turns else "in each step"
            said.append(f"the matrix of masses and constraints is factored {often}, {by}")
    elif system.joints is None:
        said.append("the mass matrix is diagonal and contains parameters only: it is computed once per run")
        if system.bonds is not None:
            sparse = None if turns else system.bonds.elimination
            by = f"a sparse matrix, whose factor has {sparse.entries} entries" if sparse else "a dense matrix"
            by = "a matrix in blocks of known rank" if turns else by
            said.append(f"multipliers are found from {by}")
    else:
        said.append(
            "the accelerations are found along chains and trees, from their tips to their roots and back"
        )
    if turns:
        from lagrange_cli.mechanics.omitted_work import IN_TURN

        said.append(IN_TURN)
    if system.first_order is not None:
        said.append("velocities of coordinates without mass are computed from their places, after each step")
    said.append(f"the forces have {system.terms} terms in all")
    if system.steady:
        said.append("the equations do not depend on t")
    return tuple(said)


def unproven(system: FamilySystem, compilation: Compilation) -> bool:
    """Whether steps must be proven, and cannot be."""
    together = system.joints is not None or system.bonds is not None or system.coupled_masses is not None
    provable = not (together or held(system) or system.contacts)
    return not (provable or compilation.unproven) and (compilation.proven or narrow(system))


def held(system: FamilySystem) -> bool:
    """Whether dry friction may hold coordinates."""
    return system.smooth is not None and system.smooth.modes is not None and bool(system.smooth.modes.limits)


def narrow(system: FamilySystem, method: str = TAYLOR, *, large: bool = True) -> bool:
    """Whether forces may hide between the places where steps of a method look at them; those of a ``large``
    system do not where something softens them (``mechanics.defect``)."""
    smooth = system.smooth or system
    nodes = [*system.bonds.nodes] if system.bonds else []
    moved = system.joints.places if system.joints else ()
    bounded: Collection[Node] = ()
    tame = frozenset[Node]()
    if method == MANY_BODIES:
        bounded, tame = slow(smooth, needed([smooth.forces], smooth.slots))
    elif METHODS[method].approaches:
        _, tame, bounded = shown_slowly(smooth, needed([smooth.forces], smooth.slots))
    return hidden(system, [smooth.forces, *smooth.loads, *moved], nodes, bounded, tame, large=large)


def doubtful(system: FamilySystem) -> bool:
    """Whether zeros of arguments of switches may hide there."""
    modes = system.smooth.modes if system.smooth else None
    return modes is not None and hidden(system, modes.followed)


def hidden(
    system: FamilySystem,
    totals: Sequence[Total],
    nodes: Sequence[Node] = (),
    bounded: Collection[Node] = (),
    tame: Collection[Node] = (),
    *,
    large: bool = True,
) -> bool:
    """Whether something may hide in totals, in what these are made of, or in further expressions; so may
    places without a series on a side of a switch. Steps approach poles of what is ``bounded`` slowly, and the
    exponentials that are ``tame``."""
    terms = (term for total in needed(totals, system.slots) for term in total.terms)
    inside = reachable([*(term.node for term in terms), *nodes])
    sides = [side for one in inside if one.kind is Kind.SWITCH for side in one.arguments[1:]]
    variables, speeds = moving(system)
    if hides(inside, variables, speeds, large=large, bounded=bounded, slow=tame):
        return True
    return any(is_root(one, variables) and not shows(one, variables, speeds) for one in reachable(sides))
