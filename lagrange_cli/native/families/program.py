"""The program of a system of families: its accelerations, and what is observed of it.

What does not change during a motion is computed by ``@prepare``: masses, and whatever terms contain of
indices and parameters. Behind the constants, ``%constants`` has arrays of these, and scratch for
``@observe``.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import partial
from itertools import product
from types import MappingProxyType
from typing import Any, TypeAlias

from lagrange_cli.families.arrays import Array, Total
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.native.families.arrangement import Element, Observed
from lagrange_cli.native.families.articulated import ArticulatedJet
from lagrange_cli.native.families.beside import BesideJet
from lagrange_cli.native.families.closed import ClosedJet
from lagrange_cli.native.families.closed_projection import AT_A_STATE, ClosedProjection, Residuals
from lagrange_cli.native.families.constrained import ConstrainedJet, solved_at_a_state
from lagrange_cli.native.families.coupling import of_families
from lagrange_cli.native.families.evaluation import Evaluation, room
from lagrange_cli.native.families.floors import FLOORS, write_floors
from lagrange_cli.native.families.jets import BRIEF, HEAD, JET, Jet, SeriesJet, regular, velocity_planes
from lagrange_cli.native.families.loops import needed
from lagrange_cli.native.families.preparation import Preparation, low_parts
from lagrange_cli.native.families.projection import Projection
from lagrange_cli.native.families.proof import FamilyProof, proof_room
from lagrange_cli.native.families.restraint import AtAState
from lagrange_cli.native.families.runs import runs_of
from lagrange_cli.native.families.sharing import board_size
from lagrange_cli.native.families.sharing import sharing as shared_functions
from lagrange_cli.native.families.steps import FamilySteps, VelocitySteps, weights_size
from lagrange_cli.native.families.strips import Sharing
from lagrange_cli.native.families.vectors import DoubleVectors, Vectors
from lagrange_cli.native.functions.double_double import functions, of_vectors
from lagrange_cli.native.functions.elementary import definitions
from lagrange_cli.native.interface import LANES, Interface
from lagrange_cli.native.llvm import length
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import tables as numbers
from lagrange_cli.native.llvm.vector import Integer, Pointer, Real
from lagrange_cli.native.motions import RATES
from lagrange_cli.native.numbers.double_double import operations
from lagrange_cli.native.program import Program
from lagrange_cli.native.recurrences.vector_stage import rests
from lagrange_cli.native.state import Clock, Role
from lagrange_cli.native.stepping.advance import advance
from lagrange_cli.native.stepping.double_doubles import stepper
from lagrange_cli.native.stepping.doubles import accelerate
from lagrange_cli.native.stepping.lengths import Lengths, side_by_side
from lagrange_cli.native.stepping.motion import Given
from lagrange_cli.native.stepping.projection import HEAD as HEAD_OF_PROJECTION
from lagrange_cli.native.stepping.proof import Proving
from lagrange_cli.records import replace
from lagrange_cli.series.program import SeriesProgram

COMPANION = 3
"""Doubles for each constant of a companion, which computes them once in doubles and once in two parts."""
NOTHING: Observed = MappingProxyType({})
Steps: TypeAlias = "tuple[int, list[str], tuple[int, int, int]]"
"""The doubles that steps work on, their texts, and where series are (``Interface.series_at``)."""


def write_family_program(
    system: FamilySystem,
    observed: Observed,
    tolerance: float,
    order: int,
    *,
    scheme: str = "",
    kind: type[Vectors] = DoubleVectors,
    factor: int | None = None,
    proven: bool = False,
    integrands: Observed = NOTHING,
) -> Program:
    """The program of ``system`` with q's series to ``order``, in numbers of a ``kind``, and integrals of
    ``integrands``; one of ``RATES`` gives the accelerations alone, with the steps of a ``scheme`` on these,
    in doubles. With a ``factor`` it is that of a companion, whose numbers are of a kind beside those of the
    run (``numbers.beside``). If steps by series are to be ``proven``, M is diagonal, there are no
    constraints, and numbers are doubles."""
    return _Writer(system, observed, tolerance, order, scheme, kind, factor, proven, integrands).program()


class _Writer(Preparation):
    """The functions of a program."""

    def program(self) -> Program:
        """The program."""
        order = self.order
        if self.scheme:
            from lagrange_cli.native.stepping.schemes import scheme_of

            scheme = scheme_of(self.scheme)
            order = scheme.order
        interface = Interface(
            order=order, degrees=self.degrees, parameters=self.parameters, integrals=self.integrals,
            stored=0, observed=tuple(self.observed), constants=0, work=0, lanes=0, parts=self.kind.parts,
            given=self.kind.parts if self.factor is None else 2,
            guards=(), limits=(), events=self.numbered(), changed=self.events.changed if self.events else (),
            affected=self.events.affected if self.events else (), masses=(),
            constraints=0 if self.system.bonds is None else self.system.bonds.count, pattern=(),
            series_at=(0, 0, 0), carried=0, strips=0, board=0,
        )  # fmt: skip
        if self.scheme:
            interface = replace(interface, carried=scheme.carried(interface.inner))
        jet = self.jet()
        work, steps, at = (self.steps if self.kind.parts == 1 else self.pair_steps)(interface, jet)
        parts = [jet.text, *steps]
        observe, counted = self.values("observe", self.observed.values(), self.roots, self.pulled)
        parts.append(observe)
        if self.acted:
            parts.append(self.values("act", self.acted, [*dict.fromkeys(one for one, _ in self.acted)])[0])
        parts.append(self.prepare())
        text, listed = "\n".join(parts), self.tables.text()
        text += f"@scratch = private constant i64 {self.scalars}\n" + listed
        constants = self.scalars + self.size
        if self.kind.parts > 1 or self.factor is not None:
            text += low_parts(work // 2, constants) + "".join(of_vectors(text))
        text += definitions(text)
        length.allow(text.count(" = "))
        return Program(
            **{
                **interface.as_data(), "work": work,
                "constants": constants * (self.kind.parts if self.factor is None else COMPANION),
                "strips": self.strips, "board": self.scalars + self.board,
                "series_at": at if self.integrals else (0, 0, 0),
            },
            text=text,
            series=SeriesProgram((), (), (), (), ()),
            hiding=self.proven,
            tables=len(listed),
            loops=True,
            operations={"jet": jet.operations, "observe": counted},
        )  # fmt: skip

    def steps(self, interface: Interface, jet: Jet) -> Steps:
        """What follows a motion in doubles."""
        parts, work, floor = list[str](), jet.work, 0
        floors = self.floors() if self.diagonal and (self.scheme or self.order > RATES) else ""
        if floors and not self.scheme:
            floor, work = work, work + room(self.layout.width)
        lengths = side_by_side(self.degrees, self.layout.rows, self.order, floor)
        if self.order > RATES and self.balance is None and self.motion is None:
            first, term = velocity_planes(self.layout.rows - self.degrees)
            lengths = replace(lengths, term=term, first=first - self.degrees, followers=True)
            work += weights_size(self.order)
        given = self.given(interface, work, floors)
        if self.scheme:
            from lagrange_cli.native.stepping.schemes import on_rates, scheme_of

            work, steps = on_rates(scheme_of(self.scheme), lengths, given, partial(of_families, self.system))
            parts.append(steps)
        elif self.order > RATES:
            kind = VelocitySteps if lengths.followers else FamilySteps
            parts.append(advance(kind(lengths, given)))
        if self.order > RATES or self.balance is not None or self.motion is not None:
            parts += [*numbers("", self.order + 4), rests(self.order + 4)]
        return work, [*parts, accelerate(lengths)], (lengths.first, lengths.row, lengths.term)

    def pair_steps(self, interface: Interface, jet: Jet) -> Steps:
        """The same in double-double: low parts are behind all high ones."""
        floors, width, work = self.floors() if self.diagonal else "", self.layout.width, jet.work
        floor = work if self.degrees > 1 else 0
        orders = -(-(work + room(width)) // width)
        lengths = Lengths(self.degrees, self.layout.rows, width, self.order, 1, 1, 1, width, floor=floor)
        given = self.given(interface, 2 * orders * width, floors)
        texts = [*operations(), *functions(), *stepper(lengths, orders, given)]
        return given.work, texts, (0, 0, 0)

    def given(self, interface: Interface, work: int, floors: str) -> Given:
        """What steps need to know of the motion."""
        return Given(
            interface.inner, work, self.tolerance, (self.proving(), None, None),
            interface.rows_of_guards if interface.guarded else None,
            project=self.projection(), timed=not self.system.steady, floors=floors,
        )  # fmt: skip

    def jet(self) -> Jet:
        """``@jet``."""
        given = self.system, self.lasting, self.places, self.tables, self.layout, self.order
        if self.closure is not None:
            return self.with_beside(ClosedJet(self.closure, self.tabled, *given, self.kind), *given)
        if self.balance is not None:
            return self.with_beside(ArticulatedJet(self.balance, *given, self.kind), *given)
        if self.motion is not None:
            return self.with_beside(ConstrainedJet(self.motion, self.tabled, *given, self.kind), *given)
        if self.order == RATES:
            return self.accelerations()
        jet = self.with_beside(SeriesJet(*given, self.kind), *given)
        brief = SeriesJet(*given[:-1], RATES, self.kind, BRIEF).write()
        return replace(jet, text=jet.text + brief.text)

    def with_beside(self, motion: SeriesJet, *given: Any) -> Jet:
        """The jet of a motion, and of what is followed beside it."""
        motion.beside = self.integrands is not None
        jet = motion.write()
        if self.integrands is None:
            return jet
        beside = BesideJet(self.integrands, motion, *given).write()
        operations = jet.operations + beside.operations
        return Jet(beside.text + jet.text, beside.work, operations)

    def numbered(self) -> tuple[tuple[int, int, int], ...]:
        """The events as ``Interface`` has them."""
        if self.events is None:
            return ()
        found = []
        for e, one in enumerate(self.events.listed):
            acts = Role.CHANGE if e in self.events.simple else Role.ACTION
            found.append((one.direction, int(acts if one.stops or one.changes else Role.RECORD), -1))
        return tuple(found)

    def projection(self) -> str:
        """``@project``, if there are constraints; its arrays are the next ones."""
        if self.residuals is not None:
            return self.closed_projection(self.residuals)
        if self.moves is None:
            return ""
        f, layout = Function(HEAD_OF_PROJECTION), self.layout
        vectors = self.kind(f)
        base = self.scratch(vectors)
        q, v = f.pointer("%state"), f.place("%state", self.degrees, "double")
        arrays: dict[Array, Pointer] = {
            array: vectors.in_state(place, layout.width)
            for array, place in ((self.system.q, q), (self.system.v, v))
        }
        for array in self.moves.arrays:
            arrays[array] = vectors.place(base, self.size)
            self.size += room(array.count)
        time, low = (f.load("%state", layout.at(one)) for one in (Clock.TIME, Clock.TIME_LOW))
        written = Projection(
            self.moves, self.evaluation(vectors, arrays, vectors.at(time, low)), layout, self.tabled,
            vectors.place(base, self.size), f.splat(low, LANES).name,
        )  # fmt: skip
        self.size += room(self.tabled.size)
        return written.text()

    def closed_projection(self, residuals: Residuals) -> str:
        """The same of chains and trees, and the jet that it calls."""
        assert self.closure is not None
        given = self.system, self.lasting, self.places, self.tables, self.layout, RATES
        jet = ClosedJet(self.closure, self.tabled, *given, self.kind, AT_A_STATE)
        text = jet.write().text
        f, layout = Function(HEAD_OF_PROJECTION), self.layout
        vectors = self.kind(f)
        base = self.scratch(vectors)
        places = self.system.q, self.system.v, residuals.low_q, residuals.low_v
        rows = 0, self.degrees, layout.width, layout.width + self.degrees
        arrays = {one: f.place("%state", row, "double") for one, row in zip(places, rows)}
        for array in residuals.arrays:
            if array not in self.lasting.fixed:
                arrays[array] = vectors.place(base, self.size)
                self.size += room(array.count + 1)
        work = vectors.place(base, self.size)
        self.size += jet.work
        time, low = (f.load("%state", layout.at(one)) for one in (Clock.TIME, Clock.TIME_LOW))
        evaluation = self.evaluation(vectors, arrays, time)
        fixed = frozenset(self.lasting.fixed)
        return text + ClosedProjection(residuals, evaluation, layout, jet, work, time, low, fixed).text()

    def accelerations(self) -> Jet:
        """``@jet`` without series."""
        f, width = Function(HEAD.format(JET, DoubleVectors.times)), self.layout.width
        work = room(width * (RATES + 1) + self.degrees)
        totals = needed([self.rates], self.slots, self.lasting.fixed)
        at: dict[Array, tuple[str, int]] = {
            self.system.q: ("%state", 0),
            self.system.v: ("%state", self.degrees),
            self.rates: ("%work", width + self.degrees),
        }
        for total in totals:
            if total is not self.rates:
                at[total] = "%work", work
                work += room(total.count)

        def within(f: Function) -> Evaluation:
            arrays = {array: f.place(base, place, "double") for array, (base, place) in at.items()}
            return self.evaluation(DoubleVectors(f), arrays, Real(f, "%t", 1))

        sharing = Sharing(within)
        evaluation = replace(within(f), share=sharing.take)
        evaluation.write(totals)
        positive = self.system.spec.lagrangian is None
        f.give(regular(f, evaluation.where(self.lasting.masses), self.degrees, positive=positive))
        return Jet(self.shared(sharing) + f.text(), work, evaluation.emitter.operations)

    def shared(self, sharing: Sharing) -> str:
        """The functions by which threads share an evaluation, if they do; their board is the next array."""
        if not sharing.parts:
            return ""
        self.board, self.strips = self.size, max(one.strips for one in sharing.parts)
        self.size += board_size(sharing.parts)
        return "".join([*sharing.tiles, *shared_functions(sharing.parts, self.board_of)])

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
        write_floors(f, self.system.spec, masses, inverses)
        return f.text()

    def values(
        self, name: str, listed: Iterable[Element], roots: Sequence[Total], pulled: AtAState | None = None
    ) -> tuple[str, int]:
        """A function of that name: quantities that are ``listed``, of totals at the ``roots``, at each of
        ``%count`` samples; and its operations. Multipliers are found as they are ``pulled``."""
        head = "ptr noalias %constants, ptr noalias %times, ptr noalias %states, ptr noalias %results"
        f = Function(f"define void @{name}({head}, i64 %stride, i64 %count) #0")
        stride, vectors = Integer(f, "%stride", 1), self.kind(f)
        base = self.scratch(vectors)
        arrays: dict[Array, Pointer] = {}

        def put(array: Array, count: int) -> None:
            arrays[array] = vectors.place(base, self.size)
            self.size += room(count)

        put(self.system.q, self.degrees)
        put(self.system.v, self.degrees)
        first = [] if pulled is None else [pulled.square, pulled.right]
        known = needed(first, self.slots, self.lasting.fixed)
        totals = [one for one in needed(roots, self.slots, self.lasting.fixed) if one not in known]
        for total in (*known, *totals):
            put(total, total.count)
        scratch = vectors.place(base, self.size)
        at = {id(array): place for array, place in arrays.items()}
        changed = self.lasting.changed
        listed = [*listed]
        runs, count = runs_of((changed[total], index) for total, index in listed), len(listed)
        operations = 0
        with f.loop(0, Integer(f, "%count", 1)) as sample:
            for part, k in product(range(vectors.parts), range(2)):
                target = vectors.parts_at(at[id((self.system.q, self.system.v)[k])], part)
                before = k * self.degrees + part * self.layout.rows
                with f.loop(0, self.degrees, tested=False) as i:
                    row = stride * (i + before if before else i) + sample
                    f.store(f.load("%states", row), target, i)
            evaluation = self.evaluation(vectors, arrays, vectors.at(f.load("%times", sample)))
            if pulled is not None:
                evaluation.write(known)
                multipliers = pulled.bonds.multipliers
                solved_at_a_state(evaluation, pulled, self.tabled, scratch, multipliers)
                self.size += room(self.tabled.size)
                totals = [one for one in totals if one is not multipliers]
            evaluation.write(totals)
            for part, run in product(range(vectors.parts), runs):
                source = vectors.parts_at(evaluation.where(run.total), part)
                place = run.row + part * count
                with f.loop(0, run.count, tested=False) as i:
                    value = f.load(source, i + run.start if run.start else i)
                    f.store(value, "%results", stride * (i * run.step + place) + sample)
            operations = evaluation.emitter.operations
        f.give()
        return f.text(), operations
