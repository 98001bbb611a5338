"""Code that computes the Taylor coefficients of one step, order by order.

The first stages are written out, coefficient by coefficient; the later ones are loops over the stage k whose
convolutions run over vectors of 8 coefficients. A convolution sum_j x[j] y[k-j] reads x forwards and y from a
row that is stored backwards, so that both are contiguous. Rows lie in the array ``%work``.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from lagrange_cli.expression.graph import Kind, Node
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.native.emitter import ONE, Emitter, Value, literal, operand
from lagrange_cli.native.linear import Definite, General, factor_definite, factor_general
from lagrange_cli.native.scalars import Constants, emit_function, emit_power, emit_values
from lagrange_cli.mechanics.series import SHORT, UNBOUNDED, Op, Series, SeriesProgram, needs

LANES = 8
WRITTEN_OUT = 3
"""Stages 0 .. WRITTEN_OUT - 1 (and the two before, that start the series) are written out."""


@dataclass(frozen=True)
class Layout:
    """Where rows lie in ``%work``: all forward rows, q, v and integrals first, then the backward ones."""

    order: int
    forward: dict[int, int]
    backward: dict[int, int]

    @property
    def span(self) -> int:
        """Doubles in a forward row; index m >= 1 is at slot m - 1. A backward row has two spans: m at span - m."""
        return LANES * -(-self.order // LANES)

    @property
    def doubles(self) -> int:
        """Size of ``%work``."""
        return self.span * (len(self.forward) + 2 * len(self.backward)) + LANES

    def forward_slot(self, series: int) -> int:
        """Slot of index 0 (not stored) of a forward row."""
        return self.span * self.forward[series] - 1

    def backward_slot(self, series: int) -> int:
        """Slot of index 0 (always 0) of a backward row."""
        return self.span * (len(self.forward) + 2 * self.backward[series]) + self.span


def arrange(program: SeriesProgram, order: int) -> Layout:
    """Choose which operand of each convolution is stored backwards; few rows are stored twice."""
    pairs: list[tuple[int, int]] = []
    backward: dict[int, int] = {}
    forward: dict[int, int] = {}
    for index in (*program.coordinates, *program.velocities, *program.integrals):
        forward[index] = len(forward)
    for index, one in enumerate(program.series):
        if one.op is Op.MULTIPLY:
            pairs.append((one.arguments[0], one.arguments[1]))
        elif one.op is Op.COMPOSE:
            pairs += list(zip(one.rates, one.partials))
        elif one.op is Op.POWER and program.series[one.arguments[0]].degree == UNBOUNDED:
            forward.setdefault(index, len(forward))
            backward.setdefault(one.arguments[0], len(backward))
    long = [p for p in pairs if all(program.series[i].degree == UNBOUNDED for i in p)]
    count: dict[int, int] = {}
    for pair in long:
        for index in pair:
            count[index] = count.get(index, 0) + 1
    for a, b in sorted(long, key=lambda p: -max(count[p[0]], count[p[1]])):
        if a in backward and b not in backward or (a in backward) == (b in backward) and count[a] > count[b]:
            a, b = b, a
        forward.setdefault(a, len(forward))
        backward.setdefault(b, len(backward))
    for index in read_back(program, pairs):
        if index not in backward:
            forward.setdefault(index, len(forward))
    return Layout(order, forward, backward)


def read_back(program: SeriesProgram, pairs: list[tuple[int, int]]) -> list[int]:
    """Series of which a looped stage reads single coefficients that earlier stages have made."""
    series = program.series
    found = [index for index in program.residual if series[index].level > 0]
    for one in series:
        found += [index for index, ahead in needs(one) if series[index].level > one.level + ahead]
    for a, b in pairs:
        if series[a].degree <= SHORT or series[b].degree <= SHORT:
            found += [a, b]
    for index, one in enumerate(series):
        if one.op is Op.POWER and series[one.arguments[0]].degree <= SHORT:
            found.append(index)
    return [index for index in found if series[index].degree == UNBOUNDED]


@dataclass
class Jet:
    """Writes the function ``@jet``; ``table[i][m]`` is coefficient m of series i where it was written out."""

    residual: Residual
    program: SeriesProgram
    layout: Layout
    constants: Constants
    emitter: Emitter = field(default_factory=Emitter)
    table: list[dict[int, Value]] = field(default_factory=list)
    factors: list[Definite | General] = field(default_factory=list)
    gains: dict[int, tuple[Value, Value]] = field(default_factory=dict)
    low: dict[int, Value] = field(default_factory=dict)
    """What q and q_dot hold beyond their double, as the compensated update leaves it."""
    unrounded: dict[Node, Value] = field(default_factory=dict)
    """Functions of a coordinate before its low part is added."""
    regular: str = "true"

    def write(self) -> str:
        """The whole function: coefficients of q, v and the integrals into ``%work``; false if M is singular."""
        self.table = [{} for _ in self.program.series]
        for kind, indices in enumerate((self.program.coordinates, self.program.velocities)):
            for i, index in enumerate(indices):
                row = kind * len(indices) + i
                self.low[index] = self.emitter.load("%state", self.rows + row)
        last = self.layout.order - 2
        for k in range(-2, min(last + 1, WRITTEN_OUT)):
            WrittenOut(self, k).write()
        if last >= WRITTEN_OUT:
            label = "written"
            self.emitter.line(f"  br label %{label}\n{label}:")
            for start, stop in segments(WRITTEN_OUT, last):
                label = self._loop(start, stop, label)
        body = "\n".join(self.emitter.lines)
        return (
            "define internal i1 @jet(ptr noalias %constants, double %t, ptr noalias %state, ptr noalias %work)"
            f" #0 {{\n{body}\n  ret i1 {self.regular}\n}}\n"
        )

    @property
    def rows(self) -> int:
        """Rows of the state: q, v and the integrals; their low parts follow them."""
        return 2 * len(self.program.coordinates) + len(self.program.integrals)

    def _loop(self, start: int, stop: int, before: str) -> str:
        """A loop over the stages start .. stop; returns the label after it."""
        emitter = self.emitter
        head, after = f"stages{start}", f"after{stop}"
        emitter.line(f"  br label %{head}\n{head}:")
        emitter.line(f"  %k{start} = phi i64 [ {start}, %{before} ], [ %next{start}, %{head} ]")
        Looped(self, f"%k{start}", start, stop).write()
        emitter.line(f"  %next{start} = add nuw nsw i64 %k{start}, 1")
        emitter.line(f"  %more{start} = icmp ule i64 %next{start}, {stop}")
        emitter.line(f"  br i1 %more{start}, label %{head}, label %{after}\n{after}:")
        return after

    def start(self, index: int) -> Value:
        """Coefficient 0 of a series whose operation has a closed form at order 0."""
        one, emitter = self.program.series[index], self.emitter
        if one.op is Op.TIME:
            return "%t"
        if one.op is Op.COORDINATE:
            assert isinstance(one.data, int)
            return emitter.load("%state", one.data)
        if one.op is Op.POWER:
            return self._start_power(index, one)
        assert one.op is Op.COMPOSE and one.node is not None
        if all(i in self.low for i in one.arguments):
            return self._start_function(one, one.node)
        values = {a: self.table[i][0] for a, i in zip(self._moving(one.node), one.arguments)}
        if one.node.kind is Kind.POWER:
            return emitter.call("llvm.pow.f64", *(self._operand(a, values) for a in one.node.arguments))
        return emit_function(emitter, str(one.data), [self._operand(a, values) for a in one.node.arguments])

    def _start_function(self, one: Series, node: Node) -> Value:
        """A function of coordinates, to first order in what they hold beyond their doubles."""
        emitter, moving = self.emitter, self._moving(node)
        partials = [p for a, p in zip(node.arguments, self.residual.graph.partials(node)) if a in moving]
        for argument, index in zip(moving, one.arguments):
            self.unrounded[argument] = self.table[index][0]
        emit_values(emitter, [node, *partials], self.unrounded, self.constants)
        value = self.unrounded[node]
        for partial, index in zip(partials, one.arguments):
            value = emitter.fma(self.unrounded[partial], self.low[index], value)
        return value

    def _moving(self, node: Node) -> list[Node]:
        return [a for a in node.arguments if a.symbols & self.residual.variables]

    def _operand(self, node: Node, values: dict[Node, Value]) -> Value:
        return values[node] if node in values else self.constants.value(self.emitter, node)

    def _start_power(self, index: int, one: Series) -> Value:
        emitter, base = self.emitter, self.table[one.arguments[0]][0]
        assert isinstance(one.data, Node)
        exponent = self.constants.value(emitter, one.data)
        if one.data.kind is Kind.NUMBER:
            value = emit_power(emitter, base, one.data.data)
        else:
            value = emitter.call("llvm.pow.f64", base, exponent)
        reciprocal = emitter.div(ONE, base)
        slope = emitter.mul(emitter.mul(exponent, value), reciprocal)
        value = emitter.fma(slope, self.low.get(one.arguments[0]), value)
        self.gains[index] = (emitter.mul(emitter.mul(exponent, value), reciprocal), reciprocal)
        return value

    def factor(self) -> None:
        """The mass matrix at order 0, factored block by block."""
        emitter, residual = self.emitter, self.residual
        model = residual.model
        known: dict[Node, Value] = {}
        for index, one in enumerate(self.program.series):
            if one.node is not None and 0 in self.table[index]:
                known[one.node] = self.table[index][0]
        for i, velocity in enumerate(model.v):
            known[velocity] = self.table[self.program.velocities[i]][0]
        entries = [entry for row in residual.mass_matrix for entry in row if not entry.is_zero]
        emit_values(emitter, [e for e in entries if e.symbols & residual.variables], known, self.constants)
        for block in residual.blocks:
            matrix: list[list[Value]] = [
                [
                    known[entry]
                    if (entry := residual.mass_matrix[j][k]).symbols & residual.variables
                    else self.constants.value(emitter, entry)
                    for k in block
                ]
                for j in block
            ]
            factor = factor_definite if residual.definite else factor_general
            made, good = factor(emitter, matrix)
            self.factors.append(made)
            self.regular = emitter.define(f"and i1 {self.regular}, {good}")

    def accelerations(self, residual: list[Value]) -> list[Value]:
        """a with M a = -``residual``."""
        result: list[Value] = [None] * len(residual)
        for block, factor in zip(self.residual.blocks, self.factors):
            right = [self.emitter.neg(residual[j]) for j in block]
            if any(value is not None for value in right):
                for j, value in zip(block, factor.solve(self.emitter, right)):
                    result[j] = value
        return result


def segments(start: int, last: int) -> list[tuple[int, int]]:
    """Split the looped stages where convolutions outgrow a vector: (first stage, last stage)."""
    cuts = [k for k in range(LANES - 2, last, LANES) if k > start]
    starts = [start, *(cut + 1 for cut in cuts)]
    return list(zip(starts, [*cuts, last]))


@dataclass
class Stage:
    """What written-out and looped stages share: the recurrences. ``ahead`` is an index relative to k."""

    jet: Jet
    top: dict[int, Value] = field(default_factory=dict)

    def at(self, index: int, ahead: int) -> Value:
        """Coefficient k + ahead of a series."""
        raise NotImplementedError

    def middle(self, a: int, b: int, ahead: int) -> Value:
        """sum_{m=1}^{n-1} a[m] b[n-m] with n = k + ahead."""
        raise NotImplementedError

    def weighted(self, index: int, base: int, exponent: Value, ahead: int) -> Value:
        """sum_{m=1}^{n-1} (exponent (n-m) - m) base[n-m] series[m] with n = k + ahead."""
        raise NotImplementedError

    def number(self, ahead: int) -> Value:
        """k + ahead."""
        raise NotImplementedError

    def divided(self, value: Value, ahead: int) -> Value:
        """``value / (k + ahead)``, correctly rounded or nearly so.

        (A product with the rounded reciprocal errs by the same factor in every step: the energy would drift.)
        """
        raise NotImplementedError

    def product(self, a: int, b: int, ahead: int) -> Value:
        """Coefficient k + ahead (at least 1) of a product."""
        emitter, table = self.jet.emitter, self.jet.table
        total = self.middle(a, b, ahead)
        total = emitter.fma(table[a][0], self.at(b, ahead), total)
        return emitter.fma(self.at(a, ahead), table[b][0], total)

    def recur(self, index: int) -> Value:
        """Coefficient k + level (at least 1) of a series from those of its operands."""
        jet, emitter = self.jet, self.jet.emitter
        one = jet.program.series[index]
        ahead = one.level
        if one.op in (Op.COORDINATE, Op.TIME):
            return literal(1.0) if one.op is Op.TIME and self.is_index(ahead, 1) else None
        if one.op is Op.LINEAR:
            total: Value = None
            for argument, scale in zip(one.arguments, linear_data(one)[1]):
                total = add_scaled(jet, scale, self.at(argument, ahead), total)
            return total
        if one.op is Op.MULTIPLY:
            return self.product(one.arguments[0], one.arguments[1], ahead)
        if one.op is Op.DERIVATIVE:
            return emitter.mul(self.number(ahead + 1), self.at(one.arguments[0], ahead + 1))
        if one.op is Op.INTEGRAL:
            return self.divided(self.at(one.arguments[0], ahead - 1), ahead)
        if one.op is Op.POWER:
            gain, inverse = jet.gains[index]
            base = one.arguments[0]
            assert isinstance(one.data, Node)
            if one.data.kind is Kind.NUMBER and one.data.data == -1.0:
                rest = emitter.neg(emitter.mul(inverse, self.middle(index, base, ahead)))
            else:
                rest = self.weighted(index, base, jet.constants.value(emitter, one.data), ahead)
                rest = self.divided(emitter.mul(rest, inverse), ahead)
            return emitter.fma(gain, self.at(base, ahead), rest)
        total = None
        for rate, partial in zip(one.rates, one.partials):
            if self.is_index(ahead, 1):
                total = emitter.fma(jet.table[rate][0], jet.table[partial][0], total)
            else:
                total = emitter.add(total, self.product(rate, partial, ahead - 1))
        return self.divided(total, ahead)

    def is_index(self, ahead: int, index: int) -> bool:
        """Whether k + ahead is ``index`` (in a loop it never is a small one)."""
        return False

    def correction(self, index: int, change: dict[int, Value]) -> Value:
        """What the change of the operands' newest coefficients adds to the newest one of a series."""
        jet, emitter = self.jet, self.jet.emitter
        one = jet.program.series[index]
        if one.op is Op.LINEAR:
            total: Value = None
            for argument, scale in zip(one.arguments, linear_data(one)[1]):
                total = add_scaled(jet, scale, change.get(argument), total)
            return total
        if one.op is Op.MULTIPLY:
            a, b = one.arguments
            total = emitter.mul(jet.table[b][0], change.get(a))
            return emitter.fma(jet.table[a][0], change.get(b), total)
        if one.op is Op.DERIVATIVE:
            return emitter.mul(self.number(one.level + 1), change.get(one.arguments[0]))
        if one.op is Op.POWER:
            return emitter.mul(jet.gains[index][0], change.get(one.arguments[0]))
        if one.op is Op.COMPOSE:
            total = None
            for argument, partial in zip(one.arguments, one.partials):
                total = emitter.fma(jet.table[partial][0], change.get(argument), total)
            return total
        raise ValueError(f"{one.op} is never corrected")

    def solve(self) -> None:
        """The accelerations' coefficient k, and what it adds to everything that depends on it."""
        jet, emitter, program = self.jet, self.jet.emitter, self.jet.program
        accelerations = jet.accelerations([self.at(index, 0) for index in program.residual])
        change: dict[int, Value] = {}
        for coordinate, velocity, value in zip(program.coordinates, program.velocities, accelerations):
            change[velocity] = self.divided(value, 1)
            change[coordinate] = self.divided(change[velocity], 2)
        for index in self.corrected():
            if index not in change:
                change[index] = self.correction(index, change)
            self.set_top(index, emitter.add(self.at(index, program.series[index].level), change[index]))

    def corrected(self) -> Iterable[int]:
        """Series that depend on the newest acceleration and are read again later."""
        read = {i for one in self.jet.program.series for i in (*one.arguments, *one.rates, *one.partials)}
        read |= {*self.jet.program.coordinates, *self.jet.program.velocities}
        return [i for i, one in enumerate(self.jet.program.series) if one.corrected and i in read]

    def set_top(self, index: int, value: Value) -> None:
        """Set coefficient k + level of a series."""
        raise NotImplementedError


@dataclass
class WrittenOut(Stage):
    """Stage ``k`` with every coefficient a value of its own."""

    k: int = 0

    def __init__(self, jet: Jet, k: int) -> None:
        super().__init__(jet)
        self.k = k

    def at(self, index: int, ahead: int) -> Value:
        return self.jet.table[index].get(self.k + ahead)

    def set_top(self, index: int, value: Value) -> None:
        self.jet.table[index][self.k + self.jet.program.series[index].level] = value

    def middle(self, a: int, b: int, ahead: int) -> Value:
        n, total = self.k + ahead, None
        for m in range(1, n):
            total = self.jet.emitter.fma(self.jet.table[a].get(m), self.jet.table[b].get(n - m), total)
        return total

    def weighted(self, index: int, base: int, exponent: Value, ahead: int) -> Value:
        n, emitter, table = self.k + ahead, self.jet.emitter, self.jet.table
        total: Value = None
        for m in range(1, n):
            weight = emitter.sub(emitter.mul(exponent, literal(n - m)), literal(m))
            total = emitter.fma(emitter.mul(weight, table[base].get(n - m)), table[index].get(m), total)
        return total

    def number(self, ahead: int) -> Value:
        return literal(self.k + ahead)

    def divided(self, value: Value, ahead: int) -> Value:
        return value if self.k + ahead == 1 else self.jet.emitter.div(value, literal(self.k + ahead))

    def is_index(self, ahead: int, index: int) -> bool:
        return self.k + ahead == index

    def write(self) -> None:
        """Compute, solve (from stage 0 on) and store this stage's coefficients."""
        jet = self.jet
        for index, one in enumerate(jet.program.series):
            if one.level + self.k == 0:
                jet.table[index][0] = self.begin(index, one)
            elif one.level + self.k > 0:
                if self.k < 0 and index in jet.program.coordinates:  # q[1] is the velocity of the state
                    assert isinstance(one.data, int)
                    value: Value = jet.emitter.load("%state", one.data + len(jet.program.coordinates))
                else:
                    value = self.recur(index)
                jet.table[index][self.k + one.level] = value
        if self.k == 0:
            jet.factor()
        if self.k >= 0:
            self.solve()
        for index, one in enumerate(jet.program.series):
            m = self.k + one.level
            if m >= 1 and index in jet.layout.forward:
                jet.emitter.store(jet.table[index][m], "%work", jet.layout.forward_slot(index) + m)
            if m >= 1 and index in jet.layout.backward:
                jet.emitter.store(jet.table[index][m], "%work", jet.layout.backward_slot(index) - m)

    def begin(self, index: int, one: Series) -> Value:
        """Coefficient 0."""
        jet, emitter = self.jet, self.jet.emitter
        first = [jet.table[i].get(0) for i in one.arguments]
        if one.op is Op.LINEAR:
            constant, scales = linear_data(one)
            total: Value = None
            for index, scale in zip(one.arguments, scales):
                total = add_scaled(jet, scale, jet.low.get(index), total)
            if not constant.is_zero:
                total = emitter.add(total, jet.constants.value(emitter, constant))
            for value, scale in zip(first, scales):
                total = add_scaled(jet, scale, value, total)
            return total
        if one.op is Op.MULTIPLY:
            a, b = one.arguments
            rest = emitter.fma(first[0], jet.low.get(b), emitter.mul(first[1], jet.low.get(a)))
            return emitter.fma(first[0], first[1], rest)
        if one.op is Op.DERIVATIVE:
            return jet.table[one.arguments[0]][1]
        if one.op is Op.INTEGRAL:
            return None
        return jet.start(index)


class Looped(Stage):
    """Stages ``first`` .. ``last`` as the body of a loop over ``k``."""

    def __init__(self, jet: Jet, k: str, first: int, last: int) -> None:
        super().__init__(jet)
        self.k, self.first, self.last = k, first, last
        self._known: dict[tuple[str, int], Value] = {}
        self._rows = jet.emitter.define(f"getelementptr inbounds double, ptr %work, i64 {k}")
        minus = jet.emitter.define(f"sub nsw i64 0, {k}")
        self._mirrored = jet.emitter.define(f"getelementptr inbounds double, ptr %work, i64 {minus}")

    def at(self, index: int, ahead: int) -> Value:
        one, layout = self.jet.program.series[index], self.jet.layout
        if one.degree < self.first + ahead:
            return None
        if ahead == one.level:
            return self.top[index]
        if index in layout.forward:
            return self.jet.emitter.load(self._rows, layout.forward_slot(index) + ahead)
        return self.jet.emitter.load(self._mirrored, layout.backward_slot(index) - ahead)

    def set_top(self, index: int, value: Value) -> None:
        self.top[index] = value

    def middle(self, a: int, b: int, ahead: int) -> Value:
        series = self.jet.program.series
        if series[a].degree > SHORT:
            a, b = b, a
        if series[a].degree <= SHORT:
            total: Value = None
            for m in range(1, series[a].degree + 1):
                total = self.jet.emitter.fma(self.jet.table[a].get(m), self.at(b, ahead - m), total)
            return total
        layout = self.jet.layout
        if a not in layout.forward or b not in layout.backward:
            a, b = b, a
        return self._dot(a, b, ahead, None)

    def weighted(self, index: int, base: int, exponent: Value, ahead: int) -> Value:
        if self.jet.program.series[base].degree > SHORT:
            return self._dot(index, base, ahead, exponent)
        emitter, table = self.jet.emitter, self.jet.table
        total: Value = None
        for j in range(1, self.jet.program.series[base].degree + 1):  # j = n - m
            weight = emitter.sub(
                emitter.mul(exponent, literal(j)), emitter.sub(self.number(ahead), literal(j))
            )
            total = emitter.fma(emitter.mul(weight, table[base].get(j)), self.at(index, ahead - j), total)
        return total

    def _dot(self, a: int, b: int, ahead: int, exponent: Value) -> Value:
        """The vectors' part of a convolution; weighted as the power rule wants if an exponent is given."""
        emitter, layout = self.jet.emitter, self.jet.layout
        blocks = -(-(self.last + ahead - 1) // LANES)
        vector = f"<{LANES} x double>"
        total: str | None = None
        slope = offset = ""
        if exponent is not None:
            slope = self._splat(emitter.neg(emitter.add(exponent, ONE)))
            offset = self._splat(emitter.mul(exponent, self.number(ahead)))
        for block in range(blocks):
            place = layout.forward_slot(a) + 1 + LANES * block
            x = emitter.define(f"getelementptr inbounds double, ptr %work, i64 {place}")
            x = emitter.define(f"load {vector}, ptr {x}, align 64")
            place = layout.backward_slot(b) - ahead + 1 + LANES * block
            y = emitter.define(f"getelementptr inbounds double, ptr {self._mirrored}, i64 {place}")
            y = emitter.define(f"load {vector}, ptr {y}, align 8")
            if exponent is not None:
                steps = ", ".join(f"double {operand(literal(1 + LANES * block + i))}" for i in range(LANES))
                weight = self._vector_fma(slope, f"<{steps}>", offset)
                y = emitter.define(f"fmul {vector} {y}, {weight}")
            if total is None:
                total = emitter.define(f"fmul {vector} {x}, {y}")
            else:
                total = self._vector_fma(x, y, total)
            emitter.operations += LANES
        zero = operand(None)
        return emitter.define(
            f"call reassoc double @llvm.vector.reduce.fadd.v{LANES}f64(double {zero}, {vector} {total})"
        )

    def _vector_fma(self, a: str, b: str, c: str) -> str:
        vector = f"<{LANES} x double>"
        return self.jet.emitter.define(
            f"call {vector} @llvm.fmuladd.v{LANES}f64({vector} {a}, {vector} {b}, {vector} {c})"
        )

    def _splat(self, value: Value) -> str:
        emitter, vector = self.jet.emitter, f"<{LANES} x double>"
        one = emitter.define(f"insertelement {vector} poison, double {operand(value)}, i64 0")
        return emitter.define(
            f"shufflevector {vector} {one}, {vector} poison, <{LANES} x i32> zeroinitializer"
        )

    def _tabulated(self, name: str, ahead: int) -> Value:
        key = (name, ahead)
        if key not in self._known:
            emitter = self.jet.emitter
            place = emitter.define(f"getelementptr inbounds double, ptr @{name}, i64 {self.k}")
            self._known[key] = emitter.load(place, ahead)
        return self._known[key]

    def number(self, ahead: int) -> Value:
        return self._tabulated("numbers", ahead)

    def divided(self, value: Value, ahead: int) -> Value:
        rest = self.jet.emitter.mul(value, self._tabulated("reciprocal_rests", ahead))
        return self.jet.emitter.fma(value, self._tabulated("reciprocals", ahead), rest)

    def write(self) -> None:
        """Compute, solve and store one stage's coefficients."""
        jet = self.jet
        for index, one in enumerate(jet.program.series):
            if one.degree >= self.first + one.level:
                self.top[index] = self.recur(index)
            else:
                self.top[index] = None
        self.solve()
        for index, one in enumerate(jet.program.series):
            if one.degree < self.first + one.level:
                continue
            if index in jet.layout.forward:
                jet.emitter.store(self.top[index], self._rows, jet.layout.forward_slot(index) + one.level)
            if index in jet.layout.backward:
                jet.emitter.store(
                    self.top[index], self._mirrored, jet.layout.backward_slot(index) - one.level
                )


def linear_data(one: Series) -> tuple[Node, tuple[Node, ...]]:
    """Constant and coefficients of a LINEAR series."""
    assert isinstance(one.data, tuple)
    constant, scales = one.data
    return constant, scales


def add_scaled(jet: Jet, scale: Node, value: Value, total: Value) -> Value:
    """``total + scale * value``; nothing is loaded for a value of 0."""
    if value is None:
        return total
    if scale.kind is Kind.NUMBER and scale.data == -1.0:
        return jet.emitter.sub(total, value)
    return jet.emitter.fma(jet.constants.value(jet.emitter, scale), value, total)
