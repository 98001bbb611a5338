"""The program and the outputs of a system whose families are not expanded (see ``families.system``)."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from lagrange_cli.errors import TooManyNumbers
from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.node import reachable
from lagrange_cli.families.arrays import Source, Term, Total, total_of
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.slopes import slopes
from lagrange_cli.families.system import family_system
from lagrange_cli.integrate.arrays import Array
from lagrange_cli.integrate.methods.equations import Equations
from lagrange_cli.integrate.methods.table import METHODS, Needs
from lagrange_cli.integrate.precision import DOUBLE, DOUBLE_DOUBLE, FULL_PRECISION
from lagrange_cli.integrate.program import portable_if_asked
from lagrange_cli.mechanics.conservation import Conserved
from lagrange_cli.mechanics.defect import hides
from lagrange_cli.model.model import Constraint, Model, Particle
from lagrange_cli.native.compilation.machine import QUICK, compile_program
from lagrange_cli.native.families.jets import WITHOUT_SERIES
from lagrange_cli.native.families.pairs import PairVectors
from lagrange_cli.native.families.program import write_family_program
from lagrange_cli.native.families.vectors import DoubleVectors, Vectors, beside_doubles
from lagrange_cli.native.motions import RATES
from lagrange_cli.native.orders import double_double_order, order_for
from lagrange_cli.native.program import Program
from lagrange_cli.outputs.plan import planned
from lagrange_cli.outputs.planner import Planner
from lagrange_cli.outputs.recording import NARROW, Dataset, EventGroup, Recording
from lagrange_cli.records import dataclass
from lagrange_cli.spec.content import names_of

if TYPE_CHECKING:
    from lagrange_cli.integrate.compilation import Compilation
    from lagrange_cli.spec.spec import Spec

OUTPUTS = frozenset({"q", "v", "p", "h", "T", "U", "energy", "positions", "observables", "conserved"})
"""The outputs that can be computed with families; others go through the members."""
INTEGRALS = frozenset({"ledger", "action"})
"""Those that are integrated beside the motion, by Taylor series."""
OF_CONSTRAINTS = frozenset({"constraints", "multipliers", "reactions"})
"""Those that systems with constraints have besides."""
Element = tuple[Total, int]
"""A number: the total that contains it, and its place there."""


def suits(spec: Spec, outputs: Collection[str]) -> bool:
    """Whether the system can be followed as one of families, and no force hides."""
    if spec.events or not known(spec, outputs):
        return False
    system = family_system(spec)
    return system is not None and system.bonds is None and not narrow(system) and not mixed(system)


def known(spec: Spec, outputs: Collection[str]) -> bool:
    """Whether the outputs can be computed with families."""
    constrained = bool(spec.constraints) and not spec.left_out
    return (OUTPUTS | OF_CONSTRAINTS if constrained else OUTPUTS).issuperset(outputs)


def integrable(spec: Spec, outputs: Collection[str]) -> bool:
    """Whether those of them that are integrals can be integrated with families. (The forces of constraint are
    not known there.)"""
    return INTEGRALS.isdisjoint(outputs) or not spec.constraints


def family_run(spec: Spec, compilation: Compilation) -> FamilySystem | None:
    """The system as one of families, where that serves a run; else None."""
    needs = METHODS[compilation.method].needs
    if needs is Needs.JACOBIAN:
        return None
    if compilation.section:
        return None
    outputs = compilation.outputs
    if needs is Needs.SERIES and integrable(spec, outputs):
        outputs -= INTEGRALS
    if not known(spec, outputs):
        return None
    plain = compilation.precision == DOUBLE and compilation.factor is None
    if not plain and (compilation.backward or spec.events or outputs != compilation.outputs):
        return None
    if spec.events and needs is not Needs.SERIES:
        return None
    system = family_system(spec, algebra_for(compilation))
    if system is None or (needs is Needs.SERIES and unproven(system, compilation)):
        return None
    if outputs != compilation.outputs and moved_in_time(system):
        return None
    if compilation.backward and (moved_in_time(system) or not system.steady_bonds):
        return None
    acting = system.events is not None and bool(system.events.changed)
    if acting and (compilation.backward or "conserved" in compilation.outputs):
        return None
    if system.bonds is not None and "reactions" in compilation.outputs and system.reactions is None:
        return None
    if system.bonds is not None and system.joints is not None and not closable(system, compilation):
        return None
    return None if needs is Needs.STEPS and mixed(system) else system


def closable(system: FamilySystem, compilation: Compilation) -> bool:
    """Whether a motion of chains and trees with constraints can be followed: in doubles, forwards, without
    events and without outputs that contain multipliers at all samples."""
    plain = compilation.precision == DOUBLE and compilation.factor is None and not compilation.backward
    needs = METHODS[compilation.method].needs
    further = bool(system.spec.events) or "multipliers" in compilation.outputs
    return plain and needs is Needs.SERIES and not further


def algebra_for(compilation: Compilation) -> type[GraphAlgebra]:
    """What the numbers of expressions are: not rounded for double-double numbers and for companions."""
    if compilation.precision != DOUBLE or compilation.factor is not None:
        from lagrange_cli.expression.exact import ExactGraphAlgebra

        return ExactGraphAlgebra
    if compilation.portable:
        from lagrange_cli.expression.exact import PortableGraphAlgebra

        return PortableGraphAlgebra
    return GraphAlgebra


def mixed(system: FamilySystem) -> bool:
    """Whether a joint has several coordinates. One that rests, as the angle of a planar motion in space, has
    accelerations that are rounding errors then, and ``ias15`` would follow these."""
    return system.joints is not None and any(len(one.rows) > 1 for one in system.joints.joints)


def moved_in_time(system: FamilySystem) -> bool:
    """Whether positions depend on t besides coordinates."""
    return system.joints is not None and any(one.symbols & system.time.symbols for one in system.joints.moved)


def engine(system: FamilySystem) -> tuple[str, ...]:
    """How the equations are integrated, a sentence for each fact."""
    said = ["families are not expanded: the code has a loop over the members of each"]
    if system.joints is None:
        said.append("the mass matrix is diagonal and contains parameters only: it is computed once per run")
        if system.bonds is not None:
            entries = system.bonds.elimination.entries
            said.append(f"multipliers are found from a sparse matrix, whose factor has {entries} entries")
    else:
        said.append(
            "the accelerations are found along chains and trees, from their tips to their roots and back"
        )
    said.append(f"the forces have {system.terms} terms in all")
    if system.steady:
        said.append("the equations do not depend on t")
    return tuple(said)


def unproven(system: FamilySystem, compilation: Compilation) -> bool:
    """Whether steps must be proven, and cannot be."""
    provable = compilation.precision == DOUBLE and system.joints is None and system.bonds is None
    return not (provable or compilation.unproven) and (compilation.proven or narrow(system))


def narrow(system: FamilySystem) -> bool:
    """Whether forces may hide between the places where steps look at them."""
    return hides(reachable(system.force_nodes), moving(system), large=True)


def write_families(system: FamilySystem, compilation: Compilation) -> tuple[Program, Recording]:
    """The program for ``compilation``, and the datasets made of its results."""
    conserved = frozenset(system.conserved)
    planner = FamilyPlanner(cast("Any", Described(system)), cast("Any", Quantities(system)), conserved)
    planned(planner, compilation.outputs, compilation.optional)
    observed = cast("dict[str, Element]", planner.observed)
    integrands = cast("dict[str, Element]", planner.integrands)
    needs, tolerance, order = METHODS[compilation.method].needs, compilation.tolerance, RATES
    kind: type[Vectors] = DoubleVectors if compilation.factor is None else beside_doubles(compilation.factor)
    if compilation.precision == DOUBLE_DOUBLE:
        order, kind = double_double_order(tolerance), PairVectors
    elif needs is Needs.SERIES:
        order = order_for(tolerance) if compilation.order is None else compilation.order
    scheme = compilation.method if needs is Needs.STEPS else ""
    hides = narrow(system)
    proven = needs is Needs.SERIES and not compilation.unproven and (hides or compilation.proven)
    followed = system
    if compilation.backward:
        from lagrange_cli.families.backward import Reversal

        reversal = Reversal(system)
        followed, integrands = reversal.equations(), reversal.integrands(integrands)
    try:
        program = write_family_program(
            followed, observed, tolerance, order,
            scheme=scheme, kind=kind, factor=compilation.factor, proven=proven, integrands=integrands,
        )  # fmt: skip
    except TooManyNumbers as error:
        if compilation.precision == DOUBLE and compilation.factor is None:
            raise
        raise TooManyNumbers(error.message, error.hint.replace(WITHOUT_SERIES, "")) from error
    constant = unbroken(system, conserved.union(planner.kept))
    events = planner.families("events", [*system.spec.events])
    at_events = {"q", "v"} if events else frozenset[str]()
    states = planned(FamilyPlanner(planner.residual, planner.energetics, conserved), at_events).states
    recording = Recording(
        coordinates=tuple(names_of(system.spec.coordinates)),
        states=tuple(planner.states),
        made=tuple(planner.made),
        conserved=tuple(name for name in observed if name in constant),
        undetected=(NARROW,) * (hides and not proven),
        events=tuple(EventGroup(one.name, one.shape, tuple(one.members)) for one in events),
        at_events=tuple(states),
    )
    return portable_if_asked(program, compilation), recording


def unbroken(system: FamilySystem, conserved: Collection[str]) -> Collection[str]:
    """What is conserved at events, too."""
    events = system.events
    if events is None or not events.changed:
        return conserved
    first = system.q.count
    kept = {"h"} if events.keeps_energy else set[str]()
    for i, name in enumerate(names_of(system.spec.coordinates)):
        if f"p_{name}" in conserved and i + first not in events.set:
            kept.add(f"p_{name}")
    return kept.intersection(conserved)


def compiled_accelerations(system: FamilySystem) -> Callable[[float, Array, Array, Array], Array]:
    """(t, q, v, parameters) -> accelerations, from the code that ``solve`` runs."""
    machine = compile_program(write_family_program(system, {}, FULL_PRECISION, RATES), QUICK)

    def accelerations(t: float, q: Array, v: Array, parameters: Array) -> Array:
        rates = Equations.of(machine, parameters).rates(t, np.concatenate([q, v]))
        return rates[machine.program.state.v]

    return accelerations


def moving(system: FamilySystem) -> int:
    """The symbols of t, q and v."""
    found = system.time.symbols
    for symbol, slot in system.slots.of.items():
        if slot.array in (system.q, system.v, *system.totals):
            found |= symbol.symbols
    return found


def of_time(system: FamilySystem) -> list[Term]:
    """The terms of dU/dt, at fixed coordinates: each term of U with t, times what U has of its sum."""
    slots, graph, root = system.slots, system.slots.graph, system.root
    alone = np.zeros(1, dtype=np.int64)
    found = [Term(root, graph.diff(system.potential, system.time), alone)]
    for total in system.totals:
        if not system.depends_on_time([total]):
            continue
        (factor,), _ = slopes(system.potential, root, system.totals, slots, total)
        for term in total.terms if factor.terms else ():
            node = slots.symbol(term.domain, factor, term.targets) * graph.diff(term.node, system.time)
            found.append(Term(term.domain, node, np.zeros_like(term.targets)))
    return [one for one in found if not one.node.is_zero]


class FamilyPlanner(Planner):
    """Plans with families: quantities are places in totals."""

    def further(self) -> Sequence[tuple[Conserved, Any]]:
        """Conserved quantities besides h and momenta of cyclic coordinates."""
        from lagrange_cli.families.conservation import constants_of
        from lagrange_cli.families.currents import current

        system = self.residual.system  # type: ignore[attr-defined]
        known = {one.quantity for one in self.residual.conserved}
        found = constants_of(system).conserved
        return [(one, (current(system, one.quantity), 0)) for one in found if one.quantity not in known]

    def balanced(self) -> tuple[Any, str]:
        """No term of L is a total time derivative of velocities."""
        return self.energetics, ""

    def torques(self, energetics: Any) -> Mapping[str, Any]:
        """dL/dq_k + Q_k."""
        return dict(zip(self.model.coordinates, energetics.torques))

    def add_balance(self, dataset: Dataset, integrands: Iterable[Any]) -> None:
        for source, (total, index) in zip(dataset.sources, integrands):
            if source not in self.conserved and total.terms:
                self.integrands[dataset.quadrature(source)] = cast("Any", (total, index))
        self.made.append(dataset)

    def reactions(self) -> tuple[Mapping[str, tuple[Any, ...]], Mapping[str, str]]:
        system = self.residual.system  # type: ignore[attr-defined]
        found = {}
        for family in self.families("embedding", [one.name for one in self.model.particles]):
            for i, name in enumerate(family.members):
                found[name] = tuple((one, i) for one in system.reactions[family.name])
        return found, {}


@dataclass(frozen=True)
class Described:
    """What the planner asks of a residual."""

    system: FamilySystem

    @property
    def contacts(self) -> tuple[()]:
        """Bodies that may rest on each other: none."""
        return ()

    bent = False
    """Whether forces depend on multipliers."""

    @property
    def conserved(self) -> tuple[Conserved, ...]:
        """h, and momenta of cyclic coordinates."""
        from lagrange_cli.families.conservation import constants_of

        found = constants_of(self.system).conserved
        return tuple(one for one in found if one.quantity == "h" or one.quantity.startswith("p_"))

    @cached_property
    def model(self) -> Model[Any]:
        """Names and families, with places in totals in place of expressions."""
        system, spec = self.system, self.system.spec
        return Model(
            name=spec.name,
            algebra=cast("Any", None),
            coordinates=cast("Any", names_of(spec.coordinates)),
            time=None,
            q=(),
            v=(),
            parameters={},
            particles=cast("Any", Particles(self.particles())),
            potential=None,
            lagrangian=None if spec.lagrangian is None else spec.lagrangian,
            generalized_forces=(),
            dissipation=None,
            observables=dict(system.observables),
            families=spec.families,
            constraints=tuple(self.constraints()),
        )

    def constraints(self) -> Iterator[Constraint[Any]]:
        """What should be 0, and the multipliers."""
        bonds = self.system.bonds
        for i, name in enumerate(bonds.names if bonds else ()):
            assert bonds is not None
            yield Constraint(name, (bonds.values, i), (bonds.multipliers, i), holonomic=True)

    def particles(self) -> list[tuple[tuple[Total, ...], Sequence[str]]]:
        """The positions of each family of particles, and the members' names."""
        from lagrange_cli.families.groups import particle_families
        from lagrange_cli.spec.spec import grouped

        families = grouped(self.system.spec.embedding, particle_families(self.system.spec))
        return [(tuple(self.system.positions[one.name]), one.members) for one in families]


class Particles(Sequence[Particle[Any]]):
    """The particles of families, whose positions are in totals."""

    def __init__(self, families: Sequence[tuple[tuple[Total, ...], Sequence[str]]]) -> None:
        self._families = families

    def __len__(self) -> int:
        return sum(len(names) for _, names in self._families)

    def __iter__(self) -> Iterator[Particle[Any]]:
        for arrays, names in self._families:
            for i, name in enumerate(names):
                yield Particle(name, None, tuple((one, i) for one in arrays), (), ())

    def __getitem__(self, number: Any) -> Any:
        return tuple(self)[number]


@dataclass(frozen=True)
class Quantities:
    """What the planner asks of energies and momenta: where they are."""

    system: FamilySystem

    def whole(self, *nodes: Any) -> Element:
        """The sum of expressions that belong to no member."""
        system = self.system
        total = sum(nodes[1:], nodes[0])
        return Total(system.masses.source, 1, (Term(system.root, total, np.zeros(1, dtype=np.int64)),)), 0

    @property
    def kinetic(self) -> Element | None:
        """T."""
        return None if self.system.spec.lagrangian is not None else self.whole(self.system.kinetic)

    @property
    def potential(self) -> Element | None:
        """U."""
        return None if self.system.spec.lagrangian is not None else self.whole(self.system.potential)

    @property
    def energy_function(self) -> Element:
        """h = sum p_k q_dot_k - L, which is T + U where positions do not depend on t."""
        system = self.system
        if not moved_in_time(system):
            return self.whole(system.kinetic, system.potential)
        everyone, places = system.everyone, np.arange(system.q.count)
        p, v = (system.slots.symbol(everyone, one, places) for one in (system.momenta, system.v))
        terms = (
            Term(everyone, p * v, np.zeros_like(places)),
            Term(system.root, system.potential - system.kinetic, np.zeros(1, dtype=np.int64)),
        )
        return Total(Source.TOTAL, 1, terms), 0

    @property
    def lagrangian(self) -> Element:
        """L."""
        return self.whole(self.system.kinetic, -self.system.potential)

    def energy_rate(self, time: Any) -> Element:
        """dh/dt: the power of the forces outside L, less dL/dt."""
        system, places = self.system, np.arange(self.system.q.count)
        power, v = (system.slots.symbol(system.everyone, one, places) for one in (system.applied, system.v))
        terms = [Term(system.everyone, power * v, np.zeros_like(places))] if system.driven else []
        return Total(Source.TOTAL, 1, (*terms, *of_time(system))), 0

    @property
    def torques(self) -> tuple[Element, ...]:
        """dL/dq_k + Q_k."""
        system, found = self.system, self.system.forces
        if system.joints is not None:
            lagrangian = system.kinetic - system.potential
            (rates,), _ = slopes(lagrangian, system.root, system.totals, system.slots, system.q)
            found = total_of(rates.count, [*rates.terms, *system.applied.terms], system.slots.graph)
        return tuple((found, k) for k in range(system.q.count))

    @property
    def momenta(self) -> tuple[Element, ...]:
        """p_k = dL/dq_dot_k."""
        return tuple((self.system.momenta, k) for k in range(self.system.q.count))
