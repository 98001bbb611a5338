"""The program of a system of families: its accelerations, and what is observed of it.

What does not change during a motion is computed by ``@prepare``: masses, and whatever terms contain of
indices and parameters. Behind the constants, ``%constants`` has arrays of these, and scratch for
``@observe``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from lagrange_cli.errors import TooLarge
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.families.arrays import Array, Source, Term, Total, total_of
from lagrange_cli.families.system import FamilySystem
from lagrange_cli.limits import way_out, whole
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.native.families.evaluation import Evaluation
from lagrange_cli.native.families.floors import FLOORS, write_floors
from lagrange_cli.native.families.loops import loops, needed, room
from lagrange_cli.native.families.series import LoopSeries, SeriesWriter, begin_sums
from lagrange_cli.native.functions.elementary import definitions
from lagrange_cli.native.interface import LANES, Interface
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import tables as numbers
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.native.motions import RATES
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.native.numbers.lanes import LaneEmitter
from lagrange_cli.native.program import Program
from lagrange_cli.native.recurrences.convolution_batches import AHEAD, dot_products
from lagrange_cli.native.recurrences.evaluation import Constants, emit_values
from lagrange_cli.native.recurrences.layout_batches import Tables
from lagrange_cli.native.recurrences.vector_stage import rests
from lagrange_cli.native.state import StateLayout
from lagrange_cli.native.stepping.advance import advance
from lagrange_cli.native.stepping.doubles import DoubleSteps, accelerate
from lagrange_cli.native.stepping.lengths import Lengths
from lagrange_cli.native.stepping.motion import Given
from lagrange_cli.native.stepping.steps import STRAIGHT
from lagrange_cli.records import replace
from lagrange_cli.series.program import SeriesProgram

MOST_NUMBERS = whole("numbers")
"""Of all series of a system."""
BEGUN, MANY = 7, 2**18
"""From this stage on, dot products are begun for several orders together, where coefficients are so many that
they do not fit a processor's own memory. (The code is twice as long.)"""
Observed = Mapping[str, tuple[Total, int]]
"""Quantities by name: where each of them is."""


def write_family_program(
    system: FamilySystem, observed: Observed, tolerance: float, order: int, *, scheme: str = ""
) -> Program:
    """The program of ``system`` with q's series to ``order``; one of ``RATES`` gives the accelerations alone,
    with the steps of a ``scheme`` on these."""
    return _Writer(system, observed, tolerance, order, scheme).program()


class FamilySteps(DoubleSteps):
    """What steps are made of where coefficients of all rows are side by side."""

    def straighten(self, f: Function) -> None:
        first, last = STRAIGHT * self.lengths.term, (self.lengths.order + 1) * self.lengths.term
        with f.loop(first, last, LANES, tested=False) as i:
            f.store_row(f.zero(LANES), "%work", i)


class _Writer:
    def __init__(
        self, system: FamilySystem, observed: Observed, tolerance: float, order: int, scheme: str
    ) -> None:
        self.system, self.slots, self.graph = system, system.slots, system.slots.graph
        self.observed, self.tolerance, self.order, self.scheme = observed, tolerance, order, scheme
        self.tables = Tables(Constants())
        self.fixed: dict[Total, None] = {}
        """Totals that are constants of the motion, in the order of their computation."""
        self.changed: dict[Total, Total] = {}
        self.degrees = system.q.count
        self.layout = StateLayout(self.degrees)
        for total in system.totals:
            self.arranged(total)
        self.forces = self.arranged(system.forces)
        roots = dict.fromkeys(total for total, _ in observed.values())
        self.roots = [self.arranged(total) for total in roots]
        everyone = np.arange(self.degrees)
        masses = self.arranged(system.masses)
        force, mass = (self.slots.symbol(system.everyone, one, everyone) for one in (self.forces, masses))
        self.rates = total_of(self.degrees, [Term(system.everyone, force / mass, everyone)], self.graph)
        self.masses = masses
        one = self.graph.number(1) / mass
        self.inverses = self.arranged(
            total_of(self.degrees, [Term(system.everyone, one, everyone)], self.graph)
        )
        self.lasting: dict[Array, int] = {}
        """Where arrays are that last, from the beginning of scratch in ``%constants``."""
        self.size = 0
        for array, count in ((system.given, system.given.count), (system.whole, self.largest)):
            self.place(array, count)
        for total in self.fixed:
            self.place(total, total.count)

    @property
    def parameters(self) -> tuple[str, ...]:
        """The names of all parameters, in the order in which they are given."""
        return tuple(one.name for one in self.system.spec.parameters)

    def place(self, array: Array, count: int) -> None:
        self.lasting[array] = self.size
        self.size += room(count)

    @property
    def largest(self) -> int:
        """How many whole numbers are needed."""
        listed = [one.table for one in self.slots.of.values() if one.array.source is Source.WHOLE]
        return 1 + max((int(table.max()) for table in listed), default=0)

    # what is constant

    def is_fixed(self, node: Node) -> bool:
        """Whether a node is a constant of the motion."""
        if node.symbols & self.system.time.symbols:
            return False
        lasting = Source.PARAMETERS, Source.WHOLE
        return all(
            slot.array.source in lasting or slot.array in self.fixed for _, slot in self.slots.inside(node)
        )

    def arranged(self, total: Total) -> Total:
        """The total with arrays in place of what is constant in its terms."""
        if total in self.changed:
            return self.changed[total]
        terms = [replace(one, node=self.with_arrays(one)) for one in self.followed(total)]
        made = Total(Source.TOTAL, total.count, tuple(terms))
        if all(self.is_fixed(one.node) for one in terms):
            self.fixed[made] = None
        self.changed[total] = made
        return made

    def followed(self, total: Total) -> Sequence[Term]:
        """Its terms, with slots of totals that have been arranged."""
        found = []
        for term in total.terms:
            others = {
                symbol: self.slots.symbol(slot.domain, self.arranged(slot.array), slot.table)
                for symbol, slot in self.slots.inside(term.node)
                if isinstance(slot.array, Total)
            }
            node = substituted(self.graph, [term.node], others)[0] if others else term.node
            found.append(replace(term, node=node))
        return found

    def with_arrays(self, term: Term) -> Node:
        """A term's node, what is constant in it and no plain slot being one."""
        if self.is_fixed(term.node):
            return term.node
        places = np.arange(term.domain.count)
        inside = reachable([term.node])
        fixed = {node for node in inside if self.is_fixed(node)}
        used = {a for node in inside if node not in fixed for a in node.arguments if a in fixed}
        replaced: dict[Node, Node] = {}
        for node in inside:
            if node in used and node.kind not in (Kind.SYMBOL, Kind.NUMBER) and any(self.slots.inside(node)):
                array = Total(Source.TOTAL, term.domain.count, (Term(term.domain, node, places),))
                self.fixed[array] = None
                replaced[node] = self.slots.symbol(term.domain, array, places)
        return substituted(self.graph, [term.node], replaced)[0] if replaced else term.node

    # functions

    def program(self) -> Program:
        """The program."""
        order = self.order
        if self.scheme:
            from lagrange_cli.native.stepping.schemes import on_rates, scheme_of

            scheme = scheme_of(self.scheme)
            order = scheme.order
        interface = Interface(
            order=order, degrees=self.degrees, parameters=self.parameters, integrals=(),
            stored=0, observed=tuple(self.observed), constants=0, work=0, lanes=0, parts=1, given=1,
            guards=(), limits=(), events=(), changed=(), affected=(), masses=(), constraints=0, pattern=(),
            series_at=(0, 1, self.layout.width) if self.order > RATES else (0, 0, 0), carried=0,
        )  # fmt: skip
        if self.scheme:
            interface = replace(interface, carried=scheme.carried(interface.inner))
        jet, work, operations = self.series_jet() if self.order > RATES else self.jet()
        parts, floor = [jet], 0
        lanes, width = min(self.layout.width, LANES), self.layout.width
        if self.order > RATES and not self.scheme:
            floor, work = work, work + room(width)
        lengths = Lengths(
            self.degrees, self.layout.rows, width, self.order, lanes, lanes, 1, 1, width, floor=floor
        )
        given = Given(
            interface.inner, work, self.tolerance, (None, None, None), None, timed=not self.system.steady,
            floors=self.floors() if floor or self.scheme else "",
        )  # fmt: skip
        if self.scheme:
            work, steps = on_rates(scheme, lengths, given)
            parts.append(steps)
        elif self.order > RATES:
            parts += [*numbers("", order + 4), rests(order + 4), *dot_products()]
            parts.append(advance(FamilySteps(lengths, given)))
        parts.append(accelerate(lengths))
        observe, counted = self.observe()
        parts += [observe, self.prepare()]
        text, listed = "\n".join(parts), self.tables.text()
        text += f"@scratch = private constant i64 {self.scalars}\n" + listed
        text += definitions(text)
        Emitter().allow(text.count(" = "))
        return Program(
            **{**interface.as_data(), "constants": self.scalars + self.size, "work": work},
            text=text,
            series=SeriesProgram((), (), (), (), ()),
            hiding=False,
            tables=len(listed),
            operations={"jet": operations, "observe": counted},
        )

    @property
    def scalars(self) -> int:
        """Constants of the motion, in whole vectors."""
        return LANES * -(-len(self.tables.constants.slots) // LANES)

    def scratch(self, f: Function) -> Pointer:
        """Where arrays begin in ``%constants``."""
        return f.place("%constants", f.load_integer("@scratch"), "double")

    def evaluation(self, f: Function, arrays: Mapping[Array, Pointer], time: Real) -> Evaluation:
        """What computes totals in ``f``, where some arrays are besides those that last."""
        base = self.scratch(f)
        places = {array: f.place(base, at, "double") for array, at in self.lasting.items()}
        places.update(arrays)
        return Evaluation(
            f, self.slots, places.__getitem__, self.tables,
            {self.system.time: f.splat(time, LANES).name},
        )  # fmt: skip

    def jet(self) -> tuple[str, int, int]:
        """``@jet``, its doubles of ``%work``, and its operations."""
        f = Function(
            "define internal i1 @jet(ptr noalias %constants, double %t, ptr noalias %state, "
            "ptr noalias %work) #0"
        )
        width = self.layout.width
        work = room(width * (RATES + 1) + self.degrees)
        totals = needed([self.rates], self.slots, self.fixed)
        arrays = {
            self.system.q: f.place("%state", 0, "double"),
            self.system.v: f.place("%state", self.degrees, "double"),
            self.rates: f.place("%work", width + self.degrees, "double"),
        }
        for total in totals:
            if total is not self.rates:
                arrays[total] = f.place("%work", work, "double")
                work += room(total.count)
        evaluation = self.evaluation(f, arrays, Real(f, "%t", 1))
        evaluation.write(totals)
        self.give_regular(f, evaluation.where(self.masses))
        return f.text(), work, evaluation.emitter.operations

    def floors(self) -> str:
        """``@floors``: the least that velocities are measured by."""
        f = Function(FLOORS)
        base = self.scratch(f)
        masses, inverses = (
            f.place(base, self.lasting[one], "double") for one in (self.masses, self.inverses)
        )
        write_floors(f, self.system.spec, masses, inverses)
        return f.text()

    def give_regular(self, f: Function, masses: Pointer) -> None:
        """Return whether the masses are regular."""
        regular, positive = f.variable(Bit(f, "true", 1)), self.system.spec.lagrangian is None
        with f.loop(0, self.degrees, tested=False) as i:
            mass = f.load(masses, i)
            regular.set(regular.get() & ((mass if positive else f.magnitude(mass)) > 0.0))
        f.give(regular.get())

    def series_jet(self) -> tuple[str, int, int]:
        """The same with series: coefficient m of the state's row i is at ``m * width + i``."""
        f = Function(
            "define internal i1 @jet(ptr noalias %constants, double %t, ptr noalias %state, "
            "ptr noalias %work) #0"
        )
        width, degrees, order = self.layout.width, self.degrees, self.order
        work = room(width * (order + 1) + self.degrees)
        totals = needed([self.forces], self.slots, self.fixed)
        planes: dict[Array, tuple[int, int]] = {self.system.q: (0, width), self.system.v: (degrees, width)}
        """Where coefficient 0 of arrays is, and how far it is from one to the next."""
        for total in totals:  # of these, coefficients of one order are needed at a time
            planes[total] = work, 0
            work += room(total.count)
        moving = self.system.time.symbols
        for symbol, slot in self.slots.of.items():
            moving |= symbol.symbols if slot.array in planes else 0
        made: list[tuple[LoopSeries, int]] = []
        for loop in loops(totals, self.slots):
            series = LoopSeries(loop, self.slots, moving, self.system.time, order)
            made.append((series, work))
            work += series.doubles
        if work > MOST_NUMBERS:
            raise TooLarge(
                f"the Taylor series of this system are {work} numbers, more than {MOST_NUMBERS}",
                f"choose --method ias15, which has no series, make the system smaller, {way_out('numbers')}",
            )
        base, time, emitter = self.scratch(f), f.splat(Real(f, "%t", 1), LANES).name, LaneEmitter()
        places = {array: f.place(base, at, "double") for array, at in self.lasting.items()}

        def at(array: Array, k: int | Integer) -> Pointer:
            if array not in planes:
                return places[array]
            first, step = planes[array]
            return f.place("%work", k * step + first, "double")

        def stage(k: int | Integer, phase: int | None = None) -> int:
            before = emitter.operations
            evaluation = Evaluation(
                f, self.slots, lambda array: at(array, k), self.tables, {self.system.time: time}, emitter
            )
            evaluation.clear(totals)
            for series, place in made:
                SeriesWriter(evaluation, series, k, place, phase).write()
            emitter.repeated = degrees // LANES + 1
            at_k = str(k) if isinstance(k, int) else k.name
            number, after = (
                [Real(f, emitter.everywhere(f"@{name}", at_k, m), LANES) for name in ("reciprocals", "rests")]
                for m in (1, 2)
            )
            force, mass, inverse = at(self.forces, k), places[self.masses], places[self.inverses]
            following, beyond = (k + 1) * width, (k + 2) * width
            # from the last ones on: a whole vector of velocities goes beyond them, where the next
            # coefficients of the first coordinates are
            last = LANES * ((degrees - 1) // LANES)
            with f.loop(0, degrees, LANES, tested=False) as j:
                i = f.count(last) - j
                given = (f.load_row(one, i, LANES) for one in (force, mass, inverse))
                rate = divided(f, quotient(f, *given), *number)
                f.store_row(rate, "%work", i + degrees + following)
                f.store_row(divided(f, rate, *after), "%work", i + beyond)
            return emitter.operations - before

        with f.loop(0, 2 * degrees, tested=False) as i:
            f.store(f.load("%state", i), "%work", i)
        with f.loop(0, degrees, tested=False) as i:
            f.store(f.load("%state", i + degrees), "%work", i + width)
        last, rolled, operations = order - 2, min(3, order - 1), 0
        for k in range(rolled):
            operations += stage(k)
        ahead = max(0, last + 1 - BEGUN) if sum(one.doubles for one, _ in made) >= MANY else 0
        begun = last + 1 - ahead // AHEAD * AHEAD
        if rolled < begun:
            with f.loop(rolled, begun, tested=False) as counter:
                operations += (begun - rolled) * stage(counter)
        if begun <= last:
            with f.loop(begun, last + 1, AHEAD, tested=False) as counter:
                for series, place in made:
                    begin_sums(f, series, counter, place)
                for phase in range(AHEAD):
                    operations += (last + 1 - begun) // AHEAD * stage(counter + phase, phase)
        with f.loop(0, degrees, tested=False) as i:
            f.store(f.constant(0.0), "%work", i + degrees + order * width)
        self.give_regular(f, places[self.masses])
        return f.text(), work, operations

    def observe(self) -> tuple[str, int]:
        """``@observe``: the observed quantities at each of ``%count`` samples; and its operations."""
        head = "ptr noalias %constants, ptr noalias %times, ptr noalias %states, ptr noalias %results"
        f = Function(f"define void @observe({head}, i64 %stride, i64 %count) #0")
        stride, base = Integer(f, "%stride", 1), self.scratch(f)
        arrays: dict[Array, Pointer] = {}

        def put(array: Array, count: int) -> None:
            arrays[array] = f.place(base, self.size, "double")
            self.size += room(count)

        put(self.system.q, self.degrees)
        put(self.system.v, self.degrees)
        totals = needed(self.roots, self.slots, self.fixed)
        for total in totals:
            put(total, total.count)
        at = {id(array): place for array, place in arrays.items()}
        runs = self.runs()
        operations = 0
        with f.loop(0, Integer(f, "%count", 1)) as sample:
            for k, array in enumerate((self.system.q, self.system.v)):
                with f.loop(0, self.degrees, tested=False) as i:
                    row = stride * (i + k * self.degrees if k else i) + sample
                    f.store(f.load("%states", row), at[id(array)], i)
            evaluation = self.evaluation(f, arrays, f.load("%times", sample))
            evaluation.write(totals)
            for first, total, start, count in runs:
                source = evaluation.where(total)
                with f.loop(0, count, tested=False) as i:
                    value = f.load(source, i + start if start else i)
                    f.store(value, "%results", stride * (i + first) + sample)
            operations = evaluation.emitter.operations
        f.give()
        return f.text(), operations

    def runs(self) -> list[tuple[int, Total, int, int]]:
        """The observed quantities in parts that follow one another in one total: the first row, the total,
        where they begin in it, and how many they are."""
        found: list[tuple[int, Total, int, int]] = []
        for row, (total, index) in enumerate(self.observed.values()):
            here = self.changed[total]
            if found:
                first, last, start, count = found[-1]
                if last is here and start + count == index:
                    found[-1] = first, last, start, count + 1
                    continue
            found.append((row, here, index, 1))
        return found

    def prepare(self) -> str:
        """``@prepare``: constants, and arrays that last."""
        f = Function("define void @prepare(ptr noalias %parameters, ptr noalias %constants) #0")
        base = self.scratch(f)
        given = f.place(base, self.lasting[self.system.given], "double")
        whole = f.place(base, self.lasting[self.system.whole], "double")
        with f.loop(0, self.system.given.count) as i:
            f.store(f.load("%parameters", i), given, i)
        with f.loop(0, self.largest, tested=False) as i:
            f.store(i.to_real(), whole, i)
        # arrays may need further constants, which are computed before them
        inner = Function("define internal void @arrays(ptr noalias %constants) #0")
        self.evaluation(inner, {}, inner.constant(0.0)).write([*self.fixed])
        inner.give()
        emitter = Emitter()
        emitter.lines = f.sink
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
        f.give()
        return inner.text() + f.text()


def quotient(f: Function, a: Real, b: Real, inverse: Real) -> Real:
    """a / b, given 1/b as it is rounded: correctly rounded but in rare cases."""
    rough = a * inverse
    return f.fused(f.fused(-rough, b, a), inverse, rough)


def divided(f: Function, a: Real, inverse: Real, rest: Real) -> Real:
    """a / b, given 1/b in two parts."""
    return f.fused(a, inverse, a * rest)
