"""The program of a system of families: its accelerations, and what is observed of it.

What does not change during a motion is computed by ``@prepare``: masses, and whatever terms contain of
indices and parameters. Behind the constants, ``%constants`` has arrays of these, and scratch for
``@observe``.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import partial
from types import MappingProxyType
from typing import Any

from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Array, Total
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.native.families.arrangement import Arrangement, Element, Observed
from lagrange_cli.native.families.articulated import ArticulatedJet
from lagrange_cli.native.families.beside import BesideJet
from lagrange_cli.native.families.constrained import ConstrainedJet, solved_at_a_state
from lagrange_cli.native.families.coupling import of_families
from lagrange_cli.native.families.evaluation import Evaluation, room
from lagrange_cli.native.families.floors import FLOORS, write_floors
from lagrange_cli.native.families.jets import BRIEF, HEAD, JET, Jet, SeriesJet, regular, velocity_planes
from lagrange_cli.native.families.loops import needed
from lagrange_cli.native.families.projection import Projection
from lagrange_cli.native.families.restraint import AtAState
from lagrange_cli.native.families.runs import runs_of
from lagrange_cli.native.families.sharing import board_size
from lagrange_cli.native.families.sharing import sharing as shared_functions
from lagrange_cli.native.families.steps import FamilySteps, VelocitySteps, weights_size
from lagrange_cli.native.families.strips import Sharing
from lagrange_cli.native.functions.elementary import definitions
from lagrange_cli.native.interface import LANES, Board, Interface
from lagrange_cli.native.llvm import length
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import tables as numbers
from lagrange_cli.native.llvm.vector import Integer, Pointer, Real
from lagrange_cli.native.motions import RATES
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.native.program import Program
from lagrange_cli.native.recurrences.evaluation import emit_values
from lagrange_cli.native.recurrences.vector_stage import rests
from lagrange_cli.native.state import Clock, Role
from lagrange_cli.native.stepping.advance import advance
from lagrange_cli.native.stepping.doubles import accelerate
from lagrange_cli.native.stepping.lengths import Lengths
from lagrange_cli.native.stepping.motion import Given
from lagrange_cli.records import replace
from lagrange_cli.series.program import SeriesProgram

NOTHING: Observed = MappingProxyType({})


def write_family_program(
    system: FamilySystem,
    observed: Observed,
    tolerance: float,
    order: int,
    *,
    scheme: str = "",
    integrands: Observed = NOTHING,
) -> Program:
    """The program of ``system`` with q's series to ``order``, and integrals of ``integrands``; one of
    ``RATES`` gives the accelerations alone, with the steps of a ``scheme`` on these."""
    return _Writer(system, observed, tolerance, order, scheme, integrands).program()


class _Writer(Arrangement):
    """The functions of a program."""

    def program(self) -> Program:
        """The program."""
        order = self.order
        if self.scheme:
            from lagrange_cli.native.stepping.schemes import on_rates, scheme_of

            scheme = scheme_of(self.scheme)
            order = scheme.order
        interface = Interface(
            order=order, degrees=self.degrees, parameters=self.parameters,
            integrals=self.integrals,
            stored=0, observed=tuple(self.observed), constants=0, work=0, lanes=0, parts=1, given=1,
            guards=(), limits=(), events=self.numbered(), changed=self.events.changed if self.events else (),
            affected=self.events.affected if self.events else (), masses=(),
            constraints=0 if self.motion is None else self.motion.count, pattern=(),
            series_at=(0, 0, 0), carried=0, strips=0, board=0,
        )  # fmt: skip
        if self.scheme:
            interface = replace(interface, carried=scheme.carried(interface.inner))
        jet = self.jet()
        parts, work, floor = [jet.text], jet.work, 0
        floors = self.floors() if self.diagonal and (self.scheme or self.order > RATES) else ""
        lanes, width = min(self.layout.width, LANES), self.layout.width
        if floors and not self.scheme:
            floor, work = work, work + room(width)
        lengths = Lengths(
            self.degrees, self.layout.rows, width, self.order, lanes, lanes, 1, 1, width, floor=floor
        )
        if self.order > RATES and self.balance is None and self.motion is None:
            first, term = velocity_planes(self.layout.rows - self.degrees)
            lengths = replace(lengths, term=term, first=first - self.degrees, followers=True)
            work += weights_size(self.order)
        given = Given(
            interface.inner, work, self.tolerance, (None, None, None),
            interface.rows_of_guards if interface.guarded else None,
            project=self.projection(), timed=not self.system.steady, floors=floors,
        )  # fmt: skip
        if self.scheme:
            work, steps = on_rates(scheme, lengths, given, partial(of_families, self.system))
            parts.append(steps)
        elif self.order > RATES:
            kind = VelocitySteps if lengths.followers else FamilySteps
            parts.append(advance(kind(lengths, given)))
        if self.order > RATES or self.balance is not None or self.motion is not None:
            parts += [*numbers("", self.order + 4), rests(self.order + 4)]
        parts.append(accelerate(lengths))
        observe, counted = self.values("observe", self.observed.values(), self.roots, self.pulled)
        parts.append(observe)
        if self.acted:
            parts.append(self.values("act", self.acted, [*dict.fromkeys(one for one, _ in self.acted)])[0])
        parts.append(self.prepare())
        text, listed = "\n".join(parts), self.tables.text()
        text += f"@scratch = private constant i64 {self.scalars}\n" + listed
        text += definitions(text)
        length.allow(text.count(" = "))
        return Program(
            **{
                **interface.as_data(), "constants": self.scalars + self.size, "work": work,
                "strips": self.strips, "board": self.scalars + self.board,
                "series_at": (lengths.first, lengths.row, lengths.term) if self.integrals else (0, 0, 0),
            },
            text=text,
            series=SeriesProgram((), (), (), (), ()),
            hiding=False,
            tables=len(listed),
            operations={"jet": jet.operations, "observe": counted},
        )  # fmt: skip

    def jet(self) -> Jet:
        """``@jet``."""
        given = self.system, self.lasting, self.places, self.tables, self.layout, self.order
        if self.balance is not None:
            return self.with_beside(ArticulatedJet(self.balance, *given), *given)
        if self.motion is not None:
            return self.with_beside(ConstrainedJet(self.motion, self.tabled, *given), *given)
        if self.order == RATES:
            return self.accelerations()
        jet, brief = self.with_beside(SeriesJet(*given), *given), SeriesJet(*given[:-1], RATES, BRIEF).write()
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
        if self.moves is None:
            return ""
        f, layout = Function("define void @project(ptr %constants, ptr %state) #0"), self.layout
        base = self.scratch(f)
        arrays: dict[Array, Pointer] = {
            self.system.q: f.pointer("%state"), self.system.v: f.place("%state", self.degrees, "double")
        }  # fmt: skip
        for array in self.moves.arrays:
            arrays[array] = f.place(base, self.size, "double")
            self.size += room(array.count)
        time, low = (f.load("%state", layout.at(one)) for one in (Clock.TIME, Clock.TIME_LOW))
        written = Projection(
            self.moves, self.evaluation(f, arrays, time), layout, self.tabled,
            f.place(base, self.size, "double"), f.splat(low, LANES).name,
        )  # fmt: skip
        self.size += room(self.tabled.size)
        return written.text()

    def accelerations(self) -> Jet:
        """``@jet`` without series."""
        f, width = Function(HEAD.format(JET)), self.layout.width
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
            return self.evaluation(f, arrays, Real(f, "%t", 1))

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

    def board_of(self, f: Function) -> Pointer:
        """Where the board is."""
        return f.place(self.scratch(f), self.board, "double")

    def floors(self) -> str:
        """``@floors``: the least that velocities are measured by."""
        f = Function(FLOORS)
        base = self.scratch(f)
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
        stride, base = Integer(f, "%stride", 1), self.scratch(f)
        arrays: dict[Array, Pointer] = {}

        def put(array: Array, count: int) -> None:
            arrays[array] = f.place(base, self.size, "double")
            self.size += room(count)

        put(self.system.q, self.degrees)
        put(self.system.v, self.degrees)
        first = [] if pulled is None else [pulled.square, pulled.right]
        before = needed(first, self.slots, self.lasting.fixed)
        totals = [one for one in needed(roots, self.slots, self.lasting.fixed) if one not in before]
        for total in (*before, *totals):
            put(total, total.count)
        scratch = f.place(base, self.size, "double")
        at = {id(array): place for array, place in arrays.items()}
        changed = self.lasting.changed
        runs = runs_of((changed[total], index) for total, index in listed)
        operations = 0
        with f.loop(0, Integer(f, "%count", 1)) as sample:
            for k, array in enumerate((self.system.q, self.system.v)):
                with f.loop(0, self.degrees, tested=False) as i:
                    row = stride * (i + k * self.degrees if k else i) + sample
                    f.store(f.load("%states", row), at[id(array)], i)
            evaluation = self.evaluation(f, arrays, f.load("%times", sample))
            if pulled is not None:
                evaluation.write(before)
                multipliers = pulled.bonds.multipliers
                solved_at_a_state(evaluation, pulled, self.tabled, scratch, multipliers)
                self.size += room(self.tabled.size)
                totals = [one for one in totals if one is not multipliers]
            evaluation.write(totals)
            for run in runs:
                source = evaluation.where(run.total)
                with f.loop(0, run.count, tested=False) as i:
                    value = f.load(source, i + run.start if run.start else i)
                    f.store(value, "%results", stride * (i * run.step + run.row) + sample)
            operations = evaluation.emitter.operations
        f.give()
        return f.text(), operations

    def prepare(self) -> str:
        """``@prepare``: constants, and arrays that last."""
        f = Function("define void @prepare(ptr noalias %parameters, ptr noalias %constants) #0")
        base = self.scratch(f)
        given = f.place(base, self.places[self.system.given], "double")
        whole = f.place(base, self.places[self.system.whole], "double")
        with f.loop(0, self.system.given.count) as i:
            f.store(f.load("%parameters", i), given, i)
        with f.loop(0, self.largest, tested=False) as i:
            f.store(i.to_real(), whole, i)
        # arrays may need further constants, which are computed before them
        inner = Function("define internal void @arrays(ptr noalias %constants) #0")
        self.evaluation(inner, {}, inner.constant(0.0)).write(
            [one for one in self.lasting.fixed if isinstance(one, Total)]
        )
        inner.give()
        emitter = Emitter(f)
        slots, symbols = self.tables.constants.slots, self.system.parameters
        inside = 0
        for node in slots:
            inside |= node.symbols
        known: dict[Node, str | None] = {
            symbols[name]: emitter.load("%parameters", i)
            for i, name in enumerate(self.parameters)
            if name in symbols and symbols[name].symbols & inside
        }
        emit_values(emitter, [*slots], known, None)
        for node, slot in slots.items():
            emitter.store(known[node], "%constants", slot)
        f.call(None, "arrays", f.pointer("%constants"))
        if self.strips:
            board, size = self.board_of(f), Board.STRIPS + LANES * self.strips
            with f.loop(0, size, LANES, tested=False) as i:
                f.store_row(f.zero(LANES), board, i)
        f.give()
        return inner.text() + f.text()
