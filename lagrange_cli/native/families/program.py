"""The program of a system of families: its accelerations, and what is observed of it.

What does not change during a motion is computed by ``@prepare``: masses, and whatever terms contain of
indices and parameters. Behind the constants, ``%constants`` has arrays of these, and scratch for
``@observe``.
"""

from __future__ import annotations

from functools import cached_property, partial
from typing import TypeAlias

import numpy as np

from lagrange_cli.families.contacts import Coupled
from lagrange_cli.native.families.allowing import Allowing
from lagrange_cli.native.families.approach import approach
from lagrange_cli.native.families.coupling import of_families
from lagrange_cli.native.families.evaluation import room
from lagrange_cli.native.families.floors import FLOORS, related, write_floors
from lagrange_cli.native.families.jets import Jet
from lagrange_cli.native.families.joints.pressing import eliminations
from lagrange_cli.native.families.motion_jets import MotionJets
from lagrange_cli.native.families.nearness import Watch
from lagrange_cli.native.families.observation import OBSERVE, Observation
from lagrange_cli.native.families.own_actions import OwnActions
from lagrange_cli.native.families.preparation import BOARD, low_parts
from lagrange_cli.native.families.proof import FamilyProof, proof_room
from lagrange_cli.native.families.returning import Returning
from lagrange_cli.native.families.series_places import AT_ONCE, BRIEF, JET, velocity_planes
from lagrange_cli.native.families.shared_work import SharedSteps
from lagrange_cli.native.families.sharing import board_size
from lagrange_cli.native.families.steps import FamilySteps, VelocitySteps, idle_places, weights_size
from lagrange_cli.native.families.vectors import DoubleVectors, rests
from lagrange_cli.native.functions.double_double import functions, of_vectors
from lagrange_cli.native.functions.elementary import definitions
from lagrange_cli.native.guards import EXPLICIT, LOOSE, PLACED, SIMPLE, Role, rooted_kind
from lagrange_cli.native.interface import Interface
from lagrange_cli.native.linear.dependent import called_in
from lagrange_cli.native.llvm import length
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import tables as numbers
from lagrange_cli.native.motions import RATES
from lagrange_cli.native.numbers.double_double import operations
from lagrange_cli.native.program import Program
from lagrange_cli.native.rates.places import wide_of
from lagrange_cli.native.stepping.advance import advance
from lagrange_cli.native.stepping.coupling import Coupling
from lagrange_cli.native.stepping.doubles import accelerate
from lagrange_cli.native.stepping.given import Given
from lagrange_cli.native.stepping.lengths import Lengths, side_by_side
from lagrange_cli.native.stepping.proof import Proving
from lagrange_cli.native.stepping.pushing import push
from lagrange_cli.native.stepping.related import FEWEST, of_names
from lagrange_cli.records import replace
from lagrange_cli.series.program import SeriesProgram

COMPANION = 3
"""Doubles for each constant of a companion, which computes them once in doubles and once in two parts."""
Steps: TypeAlias = "tuple[int, list[str], tuple[int, int, int]]"
"""The doubles that steps work on, their texts, and where series are (``Interface.series_at``)."""


class FamilyProgram(Allowing, Returning, Observation, MotionJets):
    """The functions of a program."""

    def written(self) -> Program:
        """The program."""
        order = self.order
        if self.scheme:
            from lagrange_cli.native.rates.schemes import scheme_of

            scheme = scheme_of(self.scheme)
            order = scheme.order
        interface = Interface(
            order=order, degrees=self.degrees, parameters=self.parameters,
            integrals=self.integrals[self.silent :], stored=0, observed=tuple(self.observed),
            constants=0, work=0, single=0, lanes=0, parts=self.kind.parts,
            given=self.kind.parts if self.factor is None else 2,
            guards=self.switches, silent=() if self.modes is None else tuple(self.modes.silent),
            limits=() if self.modes is None else tuple(self.modes.holding.tolist()),
            vectors=() if self.modes is None else tuple(self.modes.vectors),
            events=self.numbered(), changed=tuple(zip(*self.events.changed.tolist())) if self.events else (),
            affected=self.events.affected if self.events else (), reached=self.reached(),
            jumping=tuple(range(self.events.count)) if self.events and self.events.jumping else (),
            joined=self.joined, masses=(),
            constraints=0 if self.system.bonds is None else self.system.bonds.count,
            pattern=self.pattern,
            series_at=(0, 0, 0), carried=0, strips=0, board=0,
        )  # fmt: skip
        if self.scheme:
            interface = replace(interface, carried=scheme.carried(interface.inner))
        jet = self.jet(Watch(interface.rows_of_guards, interface.inner) if interface.guarded else None)
        work, steps, at = (self.steps if self.kind.parts == 1 else self.pair_steps)(interface, jet)
        parts = [jet.text, *steps, self.shared()]
        observe, counted = self.values(OBSERVE, self.observed.values(), self.roots, self.pulled)
        parts.append(observe)
        if self.acted:
            parts.append(self.values("act", self.acted, [*dict.fromkeys(one for one, _ in self.acted)])[0])
            parts.append(self.own_actions.text())
        if self.nearing:
            rates, _ = self.nearing[0]
            parts.append(self.values("speeds", self.nearing, [rates])[0])
        if self.joined and self.impulses is None:
            parts.append(push(interface.rows_of_guards, interface.inner))
        if self.closing:
            roots = [*dict.fromkeys(one for one, _ in self.closing)]
            parts.append(self.values("constrain", self.closing, roots)[0])
        parts += [self.jet_at_a_state(), self.prepare()]
        text, listed = "\n".join(parts), self.tables.text()
        text += f"@scratch = private constant i64 {self.tables.scalars}\n" + listed
        text += f"{BOARD} = private constant i64 {self.board}\n" if self.strips else ""
        constants = self.tables.scalars + self.size
        if self.kind.parts > 1 or self.factor is not None:
            text += low_parts(work // 2, constants) + "".join(of_vectors(text))
        text += eliminations(text) + called_in(text)
        text += definitions(text)
        length.allow(text.count(" = "))
        return Program(
            **{
                **interface.as_data(), "work": work, "single": jet.single or work,
                "constants": constants * (self.kind.parts if self.factor is None else COMPANION),
                "strips": self.strips, "board": self.tables.scalars + self.board,
                "series_at": at if self.integrals else (0, 0, 0),
            },
            text=text,
            series=SeriesProgram((), (), (), (), ()),
            hiding=self.proven,
            tables=len(listed),
            loops=True,
            operations={"jet": jet.operations, "observe": counted},
        )  # fmt: skip

    @property
    def switches(self) -> tuple[int, ...]:
        """The guards of switches as ``Interface`` has them."""
        if self.modes is None:
            return ()
        roots = self.modes.roots if self.scheme else {}  # series show how far they are good
        kinds = {i: rooted_kind(one.steep, one.side) for i, one in roots.items()}
        kinds |= dict.fromkeys(self.modes.holding.tolist(), EXPLICIT)
        kinds |= dict.fromkeys(self.modes.placed.tolist(), PLACED)
        return tuple(kinds.get(i, SIMPLE) for i in range(self.modes.signs.count))

    def steps(self, interface: Interface, jet: Jet) -> Steps:
        """What follows a motion in doubles."""
        parts, work, floor = list[str](), jet.work, 0
        by_series = self.order > RATES and not self.scheme
        floors = self.floors() if self.diagonal and (self.scheme or by_series) else ""
        if by_series and (floors or self.related):
            floor, work = work, work + room(self.layout.width)
        lengths = side_by_side(self.degrees, self.layout.rows, self.order, floor)
        if self.order > RATES and self.balance is None and self.motion is None:
            first, term = velocity_planes(self.layout.rows - self.degrees)
            lengths = replace(lengths, term=term, first=first - self.degrees, followers=True)
            work += weights_size(self.order)
        if self.scheme:
            work, steps = self.on_rates(interface, work, floors)
            parts += steps
        elif by_series:
            given = replace(self.given(interface, work, floors), near=jet.near)
            if lengths.followers:
                given = replace(given, idle=idle_places(given.guards, given.state))
            parts.append(advance(self.by_series(lengths, self.with_integrals(given, lengths))))
        if self.order > RATES or any(one is not None for one in (self.balance, self.motion, self.factors)):
            parts += [*numbers("", self.order + 4), rests(self.order + 4)]
        return (
            work,
            [*parts, accelerate(lengths, AT_ONCE if self.looked_at else JET)],
            (lengths.first, lengths.row, lengths.term),
        )

    def on_rates(self, interface: Interface, work: int, floors: str) -> tuple[int, list[str]]:
        """Steps on rates, which ``@jet`` gives or, if it gives series, a function beside it; and the doubles
        that both work on."""
        from lagrange_cli.native.rates.schemes import on_rates

        own, name, texts = work, "jet", list[str]()
        if self.order > RATES:
            made = self.rates_alone(BRIEF)
            own, name = made.work, BRIEF
            texts.append(made.text)
        families = [*related(self.system.spec), *self.alike]
        given = replace(self.given(interface, own, floors), rates=name, related=families)
        if self.poles:
            both = (self.moved.bounds, 0), (self.moved.shifts, wide_of(given.state))
            at = {
                array: place + first
                for arrays, place in both
                for array, first in zip(arrays.values(), (0, self.degrees))
            }
            given = replace(given, approach=approach(self, self.poles, at, self.span))
        work, steps = on_rates(self.scheme, given, self.coupling_of_steps, work)
        return work, [*texts, steps]

    def coupling_of_steps(self) -> Coupling:
        """Which rates depend on which coordinates; if M is banded, which forces do."""
        found = of_families(self.system)
        if self.factors is None or self.system.bonds is not None or found.band.full:
            return found
        from lagrange_cli.native.families.banded_masses import BandedMasses

        return replace(found, masses=BandedMasses(self, found.places))

    def by_series(self, lengths: Lengths, given: Given) -> FamilySteps:
        """Steps by series, whose rows threads share if they share the series."""
        if not lengths.followers:
            return FamilySteps(lengths, given)
        if self.parts is None or not self.parts.listed:
            return VelocitySteps(lengths, given)
        return SharedSteps(lengths, given, self.parts)

    def pair_steps(self, interface: Interface, jet: Jet) -> Steps:
        """The same in double-double: low parts are behind all high ones."""
        from lagrange_cli.native.stepping.double_doubles import stepper

        floors, width, work = self.floors() if self.diagonal else "", self.layout.width, jet.work
        floor = work if self.degrees > 1 else 0
        orders = -(-(work + room(width)) // width)
        lengths = Lengths(self.degrees, self.layout.rows, width, self.order, 1, 1, 1, width, floor=floor)
        given = self.with_integrals(self.given(interface, 2 * orders * width, floors), lengths)
        texts = [*operations(), *functions(), *stepper(lengths, orders, given)]
        if self.shaken is not None or self.proven:  # accelerations, and series of proofs, are doubles
            order = self.order if self.proven else RATES
            texts += [*numbers("", order + 4), rests(order + 4)]
        return given.work, texts, (lengths.first, lengths.row, lengths.term)

    def with_integrals(self, given: Given, lengths: Lengths) -> Given:
        """The same, with what is measured by the largest of its family, too."""
        return replace(given, related=self.related) if lengths.floor else given

    @property
    def together(self) -> list[tuple[int, int]]:
        """The families of coordinates whose accelerations are found together."""
        if self.system.bonds is not None or not self.diagonal or self.system.coupled_masses is not None:
            return self.all_coordinates or related(self.system.spec)
        return []

    @property
    def related(self) -> list[tuple[int, int]]:
        """The families of coordinates whose velocities are measured by the fastest one, and of integrals."""
        families = [] if self.diagonal else self.all_coordinates or related(self.system.spec, FEWEST)
        return [*families, *self.alike]

    @property
    def all_coordinates(self) -> list[tuple[int, int]]:
        """All of them as one family, where constraints may hold one: all that moves there are rounding errors
        of others."""
        return [] if self.system.bonds is None else [(0, self.degrees)]

    @property
    def alike(self) -> list[tuple[int, int]]:
        """The integrals of each family: the first one, and their number."""
        return of_names(self.integrals, self.layout.integrals.start - self.degrees)

    def given(self, interface: Interface, work: int, floors: str) -> Given:
        """What steps need to know of the motion."""
        return Given(
            interface.inner, work, self.tolerance, (self.proving(), None, None),
            interface.rows_of_guards if interface.guarded else None,
            project=self.projection() + self.push(), timed=not self.system.steady, floors=floors,
            jointed=self.system.mixed, alone=bool(self.own_actions.loops),
            coupled=self.together, static=self.static(),
            directions=self.directions(interface.inner), cancelling=self.cancelled(),
        )  # fmt: skip

    @cached_property
    def own_actions(self) -> OwnActions:
        """What gives the actions of events one by one."""
        return OwnActions(self)

    def numbered(self) -> tuple[tuple[int, int, int], ...]:
        """The events as ``Interface`` has them."""
        if self.events is None:
            return ()
        kinds = dict.fromkeys(
            [] if self.events.impacts is None else self.events.impacts.events.tolist(), LOOSE
        )
        kinds |= dict.fromkeys([] if self.contact is None else self.contact.events.tolist(), EXPLICIT)
        roles = np.where(self.events.stops, int(Role.ACTION), int(Role.RECORD))
        roles[self.events.changed[0]] = int(Role.ACTION)
        roles[self.events.simple] = int(Role.CHANGE)
        listed = enumerate(zip(self.events.directions.tolist(), roles.tolist()))
        return tuple((direction, role, kinds.get(e, SIMPLE)) for e, (direction, role) in listed)

    def reached(self) -> tuple[tuple[int, int], ...]:
        """The coordinates on which impacts depend that act on one another, if any of them is simple."""
        contact = self.contact
        if self.motion is None or self.events is None or not isinstance(contact, Coupled):
            return ()
        if not self.events.simple.any():
            return ()
        pairs = [
            np.stack([contact.events[one.numbers - contact.fixed], rows])
            for one in contact.bonds.bounds
            for rows in one.rows
            if one.numbers[0] >= contact.fixed
        ]
        guards, rows = np.concatenate(pairs, axis=1)
        if self.joined:
            guards, rows = np.unique([guards, np.array(self.joined)[rows]], axis=1)
        return tuple(zip(guards.tolist(), rows.tolist()))

    def shared(self) -> str:
        """The functions by which threads share work, if they do; their board is the next array."""
        if self.parts is None or not self.parts.listed:
            return ""
        self.strips, self.lines = self.parts.threads, board_size(self.parts.listed)
        self.board = self.size
        self.size += self.lines
        return self.parts.text()

    def proving(self) -> Proving | None:
        """The proof of steps, if they are proven; its arrays are the next ones."""
        if not self.proven:
            return None
        first = self.size
        self.size += proof_room(self)
        return partial(FamilyProof, self, first)

    def floors(self) -> str:
        """``@floors``: the least that velocities are measured by."""
        f = Function(FLOORS)
        base = self.scratch(DoubleVectors(f))
        masses, inverses = (f.place(base, self.places[one], "double") for one in self.diagonal)
        write_floors(f, self.system.spec, masses, inverses, bound=self.system.bonds is not None)
        return f.text()
