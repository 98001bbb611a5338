"""What a program of families is made of, as totals, and where those are that last during a motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from types import MappingProxyType

from lagrange_cli.families.arrays import Array, Domain, Source, Term, Total, total_of
from lagrange_cli.families.contacts import Coupled
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.poles import moved_by, nearing, nearing_alike
from lagrange_cli.families.rounding import of_integrands, places_of
from lagrange_cli.families.static_forces import rounding_at_rest, rounding_of_joints
from lagrange_cli.native.families.constraints.contacts import ContactRestraint
from lagrange_cli.native.families.constraints.coupled_masses import factors_of
from lagrange_cli.native.families.constraints.dense import DenseTables, SolvingTables
from lagrange_cli.native.families.constraints.equations import (
    Pulled,
    along_motion,
    at_a_state,
    moves_of,
    tables_of,
)
from lagrange_cli.native.families.constraints.impulses import Impulses
from lagrange_cli.native.families.constraints.matrix import MatrixOfConstraints
from lagrange_cli.native.families.constraints.restraint import AlongMotion
from lagrange_cli.native.families.constraints.sticking import Sticking
from lagrange_cli.native.families.evaluation import room
from lagrange_cli.native.families.joints.balance import Balance
from lagrange_cli.native.families.joints.closed_projection import Residuals
from lagrange_cli.native.families.joints.closure import Closure
from lagrange_cli.native.families.joints.contacts import JointContacts
from lagrange_cli.native.families.joints.sticking import StickingClosure
from lagrange_cli.native.families.lasting import Lasting
from lagrange_cli.native.families.loops import needed
from lagrange_cli.native.families.scratch import Scratch
from lagrange_cli.native.families.vectors import DoubleVectors, Vectors
from lagrange_cli.native.motions import RATES, highest
from lagrange_cli.native.rates.schemes import scheme_of
from lagrange_cli.native.state import StateLayout
from lagrange_cli.records import replace
from lagrange_cli.spec.content import names_of

Element = tuple[Total, int]
"""A number: the total that contains it, and its place there."""
Observed = Mapping[str, Element]
"""Quantities by name: where each of them is."""
NOTHING: Observed = MappingProxyType({})


class Arrangement(Scratch):
    """What a program computes, and where arrays of what lasts during a motion are in ``%constants``.

    The program is that of ``system`` with q's series to ``order``, in numbers of a ``kind``, and
    integrals of ``integrands``; one of ``RATES`` gives the accelerations alone, with the steps of a
    ``scheme`` on these, in doubles. What is ``observed`` is that of ``sampled``, if it is another one:
    the system as it is at samples, with the switches themselves, as modes are not known there, and not in
    reversed time. With a ``factor`` it is that of a companion, whose numbers are of a kind beside those
    of the run (``numbers.beside``). If steps by series are to be ``proven``, M is diagonal, there are no
    constraints, and numbers are doubles. A ``concise`` program has no second copy of the code for many
    coefficients: it is compiled in less time, and slower.
    """

    def __init__(
        self,
        system: FamilySystem,
        observed: Observed,
        tolerance: float,
        order: int,
        *,
        sampled: FamilySystem | None = None,
        scheme: str = "",
        kind: type[Vectors] = DoubleVectors,
        factor: int | None = None,
        proven: bool = False,
        integrands: Observed = NOTHING,
        concise: bool = False,
        approaches: bool = False,
    ) -> None:
        super().__init__(system)
        self.kind, self.factor, self.concise = kind, factor, concise
        self.graph = system.slots.graph
        sampled = self.sampled = sampled or system
        self.observed, self.tolerance, self.scheme = observed, tolerance, scheme
        self.proven = proven
        guarded = system.modes is not None or system.events is not None
        self.order = highest(order, scheme, guarded=guarded)
        stepping = bool(scheme) or order > RATES
        self.lasting = Lasting(system)
        acting = system.events if stepping else None
        self.events = acting and acting.simple_in(kind.parts, scheme)
        self.modes = system.modes
        followed = [one.arguments for one in (self.modes, self.events) if one is not None]
        guards = sum(one.count for one in followed)
        if self.modes is not None:
            followed += [one for one in (self.modes.limits, self.modes.beside) if one is not None]
        self.contact = system.contact
        if self.contact is not None:
            followed.append(self.contact.multipliers)
        self.silent = sum(one.count for one in followed)
        """How many of the ``integrals`` nobody needs the values of: all but quadratures."""
        self.integrals = (*(f"guard {i}" for i in range(self.silent)), *integrands)
        """What is followed beside the motion: the arguments of switches and events, limits of forces that
        hold coordinates, forces of contact, and quadratures."""
        self.sides = len(self.parameters) + guards
        """Where the modes of contacts are among the settings."""
        self.settings = self.sides + (0 if self.contact is None else self.contact.count)
        """The numbers of all parameters and of all modes."""
        self.layout = StateLayout(self.degrees, len(self.integrals))
        self.sample_rows = StateLayout(self.degrees, len(self.integrals) - self.silent).rows
        """Rows of a sample, without integrals whose values nobody needs."""
        if isinstance(self.contact, Coupled):
            self.lasting.changed[self.contact.bonds.multipliers] = self.contact.bonds.multipliers
        self.factors = factors_of(system, self.lasting, self.tables)
        """Those of M, or of the matrix with constraints, where M is not diagonal and they last."""
        self.motion: AlongMotion | None = None
        self.closure: Closure | None = None
        self.balance = self.sticking = self.touch = None
        if self.modes is not None and self.modes.sticking is not None:
            self.lasting.changed[self.modes.sticking.multipliers] = self.modes.sticking.multipliers
        if system.joints is not None and system.bonds is not None:
            self.closure = Closure(system, self.lasting)
            self.balance = self.closure.balance
        elif system.joints is not None and self.modes is not None and self.modes.sticking is not None:
            self.closure = StickingClosure(system, self.lasting)
            self.balance = self.closure.balance
        elif system.joints is not None:
            if self.modes is not None and self.modes.locks is not None:
                self.lasting.changed[self.modes.locks.left] = self.modes.locks.left
            self.balance = Balance(system, self.lasting.arranged)
        elif isinstance(self.contact, Coupled):
            self.motion = ContactRestraint(system, self.lasting)
        elif system.bonds is not None or system.saddle is not None:
            self.motion = along_motion(system, self.lasting, kind.parts)
        elif self.modes is not None and self.modes.sticking is not None:
            self.sticking = Sticking(system, self.lasting)
        if self.balance is not None and isinstance(self.contact, Coupled):
            self.touch = JointContacts(system, self.lasting, self.balance)
            self.balance.add_pushes(self.touch.added)
        self.residuals = None
        if self.closure is not None and system.bonds is not None and stepping:
            self.residuals = Residuals(self.closure, careful=kind.parts == 1)
        bound = self.motion is not None and system.bonds is not None
        self.moves = moves_of(system, self.lasting) if bound and stepping else None
        self.velocities: Total | None = None
        """Those that follow from places."""
        if system.first_order is not None and stepping:
            self.velocities = self.lasting.arranged(system.first_order.velocities, kept=False)
        self.impulses: Impulses | None = None
        if self.events is not None and self.events.pushing is not None and self.events.pushing.any():
            self.impulses = Impulses(system, self.lasting)
        if system.bonds is not None:
            self.lasting.changed[system.bonds.multipliers] = system.bonds.multipliers
        if self.balance is not None or system.coupled_masses is not None:
            self.lasting.changed[system.accelerations] = system.accelerations
        self.forces = self.lasting.arranged(system.forces, kept=False)
        roots = dict.fromkeys(total for total, _ in observed.values())
        self.roots = [self.lasting.arranged(total) for total in roots]
        self.acted: list[Element] = []
        """What ``@act`` computes."""
        self.nearing: list[Element] = []
        """What ``@speeds`` computes: how fast bodies come nearer to what they may rest on."""
        if self.events is not None:
            acts = [self.events.values, self.events.sizes]
            impacts = self.events.impacts
            if impacts is not None and self.events.simple[impacts.events].any():
                acts.append(impacts.speeds)
            acted = [self.lasting.arranged(one) for one in acts]
            self.acted = [(one, i) for one in acted for i in range(one.count)]
            if impacts is not None and impacts.contacts is not None and impacts.rates is not None:
                rates = self.lasting.arranged(impacts.rates)
                self.nearing = [(rates, i) for i in range(rates.count)]
        self.pattern: tuple[tuple[int, int], ...] = ()
        self.closing: list[Element] = []
        """What ``@constrain`` computes, and the places in the equations' matrix of all but the first numbers
        (see ``Interface``)."""
        if system.bonds is not None and self.events is not None and self.events.changed.size:
            matrix = MatrixOfConstraints(system)
            self.pattern = matrix.pattern
            arranged = map(self.lasting.arranged, (matrix.values, matrix.speeds, matrix.entries))
            self.closing = [(one, i) for one in arranged for i in range(one.count)]
        self.integrands = self.beside(followed, [*integrands.values()]) if self.integrals else None
        closed = None if system.bonds is None else self.closure
        self.pulled: Pulled | None = None
        self.resting = closed or self.balance
        """How multipliers, and on chains and trees accelerations, are found at a sample."""
        solved = {system.accelerations, system.bonds.multipliers if system.bonds else None}
        if not solved.isdisjoint(needed(self.roots, self.slots)):
            if self.balance is None:
                self.pulled = at_a_state(sampled, self.lasting)
            elif closed is not None and sampled is not system:
                self.resting = Closure(sampled, self.lasting)
            elif sampled is not system:
                self.resting = Balance(sampled, self.lasting.arranged)
        if self.balance is not None:
            for both in zip(self.balance.found.nodes, self.balance.found.rates):
                # a place and its velocity are followed together
                if not self.lasting.changed.keys().isdisjoint(both):
                    for one in both:
                        if one is not None:
                            self.lasting.arranged(one)
        self.poles: list[Term] = []
        """How much nearer a step may bring the motion to poles, or to where narrow forces act if it
        ``approaches`` these, with the arrays of what it does and the ``span`` of ``families.poles``."""
        self.moved, self.span = moved_by(system, self.degrees), self.graph.symbol("span")
        if scheme and (approaches or scheme_of(scheme).approaches):
            forces = needed([system.forces], self.slots)
            found = nearing_alike if approaches else nearing
            nearer = found(system, forces, self.moved, self.span)
            self.poles = [replace(one, node=self.lasting.with_arrays(one)) for one in nearer]
        everyone = system.everyone
        force, mass = (self.slots.own(everyone, one) for one in (self.forces, self.lasting.masses))
        self.rates = total_of(self.degrees, [Term(everyone, force / mass, everyone.every)], self.graph)
        varied = self.balance is not None or system.curved
        self.diagonal = () if varied else (self.lasting.masses, self.lasting.inverses)
        """M and 1/M, where M is diagonal, or the diagonal of a constant one."""
        self.rounded, self.held = None, None
        """The rounding errors of forces that may cancel at rest, and what gives the multipliers in them."""
        if stepping and self.diagonal:
            alone = self.motion is not None and not isinstance(self.contact, Coupled)
            pulled = alone and kind.parts == 1 and bool(scheme)
            self.rounded = rounding_at_rest(system, pulled=pulled)
            if self.rounded is not None:
                self.rounded = self.lasting.arranged(self.rounded, kept=False)
                self.held = at_a_state(system, self.lasting) if pulled else None
        self.cancelling: Total | None = None
        """The rounding errors of the integrands whose integrals are asked for."""
        if stepping and integrands:
            sizes = of_integrands(
                system, dict(enumerate(integrands.values(), self.silent)), len(self.integrals)
            )
            self.cancelling = sizes and self.lasting.arranged(sizes, kept=False)
        self.blurred: Total | None = None
        """The rounding errors of accelerations by friction along differences of velocities."""
        if self.modes is not None and self.modes.errors is not None and stepping:
            self.blurred = self.lasting.arranged(self.modes.errors, kept=False)
        self.shaken: Balance | None = None
        """The same of joints, which move by them, with these ``signs``."""
        self.signs = Array(Source.TOTAL, self.degrees)
        if self.balance is not None and stepping:
            self.signs = Array(Source.TOTAL, max(self.degrees, self.balance.count))
            shaken = rounding_of_joints(system, self.signs)
            self.shaken = Balance(shaken, self.lasting.arranged) if shaken else None
        self.board, self.lines, self.strips = 0, 0, 0
        for array, count in ((system.given, system.given.count), (system.whole, self.largest)):
            self.place(array, count)
        if self.modes is not None:
            self.place(self.modes.signs, self.modes.signs.count)
        if self.contact is not None:
            self.place(self.contact.signs, self.contact.count)
        if self.shaken is not None:
            self.place(self.signs, self.signs.count)
        for array in self.lasting.fixed:
            self.place(array, array.count)
        if self.factors is not None:
            self.place(self.factors.array, self.factors.array.count)
        dense = self.motion is not None and isinstance(self.tabled_in_motion, DenseTables)
        if dense and isinstance(self.motion, ContactRestraint) and self.factor is None:
            # not among what callers clear, as few contacts of many touch; companions copy what is here
            self.place(self.motion.solving, room(self.tabled_in_motion.size))

    def beside(self, followed: Sequence[Total], listed: Sequence[Element]) -> Total:
        """One array of all that is ``followed``, and of what is ``listed``."""
        terms, first = list[Term](), 0
        for one in followed:
            terms += [replace(term, targets=term.targets + first) for term in one.terms]
            first += one.count
        for total, (chosen, put) in places_of(dict(enumerate(listed, first))).items():
            domain = Domain(len(chosen))
            terms.append(Term(domain, self.slots.symbol(domain, total, chosen), put))
        whole = total_of(len(self.integrals), terms, self.graph)
        return self.lasting.arranged(whole, kept=False)

    @property
    def multipliers_beside(self) -> Total | None:
        """The multipliers, if what is followed beside the motion contains them."""
        bonds = self.contact.bonds if isinstance(self.contact, Coupled) else self.system.bonds
        if isinstance(self.closure, StickingClosure):
            bonds = self.closure.bonds
        if bonds is None or self.integrands is None:
            return None
        return bonds.multipliers if bonds.multipliers in needed([self.integrands], self.slots) else None

    @cached_property
    def tabled(self) -> SolvingTables:
        """How multipliers are found."""
        if self.factors is not None:
            return self.factors.tabled
        solved = self.sticking or self.closure
        bonds = self.system.bonds if solved is None else solved.bonds
        equations = self.system.saddle or bonds
        assert equations is not None
        return tables_of(equations, self.tables)

    @cached_property
    def tabled_in_motion(self) -> SolvingTables:
        """The same along a motion, with the forces of contacts."""
        contact = self.contact
        return tables_of(contact.bonds, self.tables) if isinstance(contact, Coupled) else self.tabled

    @property
    def parameters(self) -> tuple[str, ...]:
        """The names of all parameters, in the order in which they are given."""
        return tuple(names_of(self.system.spec.parameters))
