"""``@jet`` in double-double: the Taylor coefficients of one step, by the recurrences of ``stage``.

Stages with coefficients 0 and 1 are written out, the others are a loop over rows in memory. The series are in
(t - t0)/scale, a power of two about as long as a step: so they do not overflow near a singularity.
"""

from __future__ import annotations

from lagrange_cli.expression.node import Kind, Node
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.native.numbers.double import Operand, literal, operand
from lagrange_cli.native.numbers.double_double import TYPE, DoubleDoubleBody, Pair
from lagrange_cli.native.recurrences.evaluation import Constants
from lagrange_cli.native.recurrences.evaluation_double_double import Values, add_scaled, power
from lagrange_cli.native.recurrences.layout_rows import Rows
from lagrange_cli.records import dataclass, field
from lagrange_cli.series.program import FREE, Op, Series, reciprocal


@dataclass
class Jet:
    """The function while it is being written."""

    residual: Residual
    rows: Rows
    constants: Constants
    body: DoubleDoubleBody = field(default_factory=DoubleDoubleBody)

    def write(self) -> str:
        """Its text: ``i1 @jet(constants, t, its low part, scale, state, work)``, false where M is
        singular."""
        body, program = self.body, self.rows.program
        body.line(f"  call void @clear(ptr %work, i64 {self.rows.block(0)})")
        self.inverse = operand(body.div(literal(1.0), "%scale"))
        self.regular: list[str] = []
        model = self.residual.model
        known = {model.time: Pair(body, "%t", "%tl")}
        for i, symbol in enumerate((*model.q, *model.v)):
            known[symbol] = body.get("%state", i, self.rows.width)
        self.values = Values(body, known, self.constants)
        for cyclic in self.residual.cyclic_momenta:
            self.values.set(cyclic.symbol, self.values.value(cyclic.momentum))
        for one in program.series:
            if one.op is Op.LINEAR:
                assert isinstance(one.data, tuple)
                for node in (one.data[0], *one.data[1]):
                    if not node.is_zero:
                        self.values.value(node)
        self.gains: dict[int, tuple[Pair, Pair]] = {}
        levels = [one.level for one in program.series if one.level > FREE]
        last = self.rows.order - 2
        looped = min(max(1, 2 - min(levels)), last + 1)
        for k in range(-2, looped):
            Stage(self, k).write()
        body.loop(looped, last + 1, lambda k: Stage(self, k).write())
        good = "true"
        for one_good in self.regular:
            good = body.define(f"and i1 {good}, {one_good}")
        lines = "\n".join(body.lines)
        heads = "ptr %constants, double %t, double %tl, double %scale, ptr %state, ptr %work"
        return f"define internal i1 @jet({heads}) #0 {{\n{lines}\n  ret i1 {good}\n}}\n"

    def row(self, index: int) -> int:
        return self.rows.row(index)


@dataclass
class Stage:
    """Stage k: coefficient k + level of every series, then the accelerations' coefficient k."""

    jet: Jet
    k: int | str

    @property
    def body(self) -> DoubleDoubleBody:
        return self.jet.body

    def index(self, ahead: int) -> int | str:
        """k + ahead."""
        return self.k + ahead if isinstance(self.k, int) else self.body.integer("add", self.k, ahead)

    def number(self, ahead: int) -> str:
        """The same as a double."""
        n = self.index(ahead)
        if isinstance(n, int):
            return operand(literal(float(n)))
        return self.body.define(f"sitofp i64 {n} to double")

    def rate(self, ahead: int) -> Operand:
        """What a coefficient is multiplied by where the series is derived, over 1: (k + ahead) / scale."""
        return operand(self.body.mul(self.number(ahead), self.jet.inverse))

    def at(self, series: int, ahead: int) -> Pair | None:
        """Coefficient k + ahead of a series."""
        n = self.index(ahead)
        if isinstance(n, int) and n < 0:
            return None
        return self.body.get(self.address(series), n, self.jet.rows.beyond)

    def address(self, series: int) -> str:
        """Where a series' coefficients are."""
        return self.body.place("%work", self.jet.row(series))

    def set(self, series: int, ahead: int, value: Pair | None) -> None:
        """Store coefficient k + ahead."""
        if value is not None:
            self.body.put(value, self.address(series), self.index(ahead), self.jet.rows.beyond)

    def first(self, series: int) -> Pair:
        """Coefficient 0."""
        return self.body.get(self.address(series), 0, self.jet.rows.beyond)

    def write(self) -> None:
        """Compute and store the stage's coefficients."""
        program = self.jet.rows.program
        for index, one in enumerate(program.series):
            if one.level == FREE:
                continue
            n = self.index(one.level)
            if n == 0:
                self.set(index, one.level, self.begin(one))
                if one.op is Op.POWER:
                    self.gain(index, one)
            elif not isinstance(n, int) or n > 0:
                self.set(index, one.level, self.recur(index, one))
        if self.k == 0:
            self.factor()
        if not isinstance(self.k, int) or self.k >= 0:
            self.solve()
        for index, row in self.jet.rows.weighted.items():
            level = program.series[index].level
            n = self.index(level)
            if not isinstance(n, int) or n > 0:
                value = self.at(index, level)
                assert value is not None
                self.set(row, level, value.scaled(self.number(level)))

    def begin(self, one: Series) -> Pair | None:
        """Coefficient 0."""
        body, values = self.body, self.jet.values
        if one.op is Op.TIME:
            return Pair(body, "%t", "%tl")
        if one.op is Op.COORDINATE:
            assert isinstance(one.data, int)
            return body.get("%state", one.data, self.jet.rows.width)
        if one.op is Op.LINEAR:
            assert isinstance(one.data, tuple)
            constant = one.data[0]
            return self.linear(one, [self.first(i) for i in one.arguments], constant)
        if one.op is Op.MULTIPLY:
            a, b = map(self.first, one.arguments)
            return a * b
        if one.op is Op.DERIVATIVE:
            return body.get(self.address(one.arguments[0]), 1, self.jet.rows.beyond).scaled(self.jet.inverse)
        if one.op is Op.POWER:
            assert isinstance(one.data, Node)
            base = self.first(one.arguments[0])
            if one.data.kind is Kind.NUMBER:
                return power(base, one.data.data)
            return body.function("pow", base, values.value(one.data))
        if one.node is None:
            return None
        moving = [a for a in one.node.arguments if a.symbols & self.jet.residual.variables]
        known = dict(zip(moving, map(self.first, one.sources)))
        arguments = [known[a] if a in known else values.value(a) for a in one.node.arguments]
        name = "pow" if one.node.kind is Kind.POWER else str(one.node.data)
        return body.function(name, *arguments)

    def gain(self, index: int, one: Series) -> None:
        """What p[n] gains by x[n], e p[0]/x[0], and 1/x[0]."""
        assert isinstance(one.data, Node)
        inverse = self.body.number(1) / self.first(one.arguments[0])
        exponent = self.jet.values.value(one.data)
        self.jet.gains[index] = (exponent * self.first(index)) * inverse, inverse

    def recur(self, index: int, one: Series) -> Pair | None:
        """Coefficient n = k + level > 0 of a series from those of its operands (see ``stage``)."""
        body, n = self.body, self.index(one.level)
        if one.op is Op.TIME:
            return body.number(1).scaled("%scale") if n == 1 else None
        if one.op is Op.COORDINATE:
            assert isinstance(one.data, int)
            degrees = len(self.jet.rows.program.coordinates)
            if n != 1:
                return None
            return body.get("%state", one.data + degrees, self.jet.rows.width).scaled("%scale")
        if one.op is Op.LINEAR:
            return self.linear(one, [self.at(i, one.level) for i in one.arguments], None)
        if one.op is Op.MULTIPLY:
            return self.convolution(one.arguments[0], one.arguments[1], one.level)
        if one.op is Op.DERIVATIVE:
            value = self.at(one.arguments[0], one.level + 1)
            return value and value.scaled(self.rate(one.level + 1))
        if one.op is Op.PRIMITIVE:
            value = self.at(one.arguments[0], one.level - 1)
            return value and value.divided(self.rate(one.level))
        # with p[n] = 0 still: n x[0] p[n] = sum_m (e (n - m) - m) x[n-m] p[m]
        inverse, base = self.jet.gains[index][1], one.arguments[0]
        plain = self.convolution(index, base, one.level)
        if reciprocal(one.data):
            return -(plain * inverse)
        assert isinstance(one.data, Node)
        exponent = self.jet.values.value(one.data)
        weighted = self.convolution(self.jet.rows.weighted[index], base, one.level)
        more = (exponent + body.number(1)) * weighted.divided(self.number(one.level))
        return (exponent * plain - more) * inverse

    def convolution(self, a: int, b: int, ahead: int) -> Pair:
        """sum_m a[m] b[n-m]."""
        listed = f"ptr {self.address(a)}, ptr {self.address(b)}, i64 {self.index(ahead)}"
        return self.body.unpacked(self.body.define(f"call {TYPE} @convolve({listed})"))

    def linear(self, one: Series, values: list[Pair | None], constant: Node | None) -> Pair | None:
        """A sum with constant coefficients; ``constant`` is added where there is one."""
        assert isinstance(one.data, tuple)
        total = None if constant is None or constant.is_zero else self.jet.values.value(constant)
        for scale, value in zip(one.data[1], values):
            if value is None:
                continue
            if scale.kind is Kind.NUMBER:
                total = add_scaled(total, value, scale.data)
            else:
                scaled = value * self.jet.values.value(scale)
                total = scaled if total is None else total + scaled
        return total

    def factor(self) -> None:
        """The mass matrix at order 0, factored block by block."""
        jet, body, residual = self.jet, self.body, self.jet.residual
        for index, one in enumerate(jet.rows.program.series):
            if one.node is not None and one.level >= 0:
                jet.values.set(one.node, self.first(index))
        for inertia in residual.inertias:
            jet.regular.append(body.compare("one", jet.values.value(inertia).high, 0.0))
        for number, block in enumerate(residual.blocks):
            place = body.place("%work", jet.rows.block(number))
            for i, j in enumerate(block):
                for c, k in enumerate(block):
                    entry = residual.mass_matrix[j][k]
                    value = None if entry.is_zero else jet.values.value(entry)
                    body.put(value, place, 2 * (i * len(block) + c), 1)
            jet.regular.append(body.define(f"call i1 @factor(ptr {place}, i64 {len(block)})"))

    def solve(self) -> None:
        """The accelerations' coefficient k, and what it adds to everything that depends on it."""
        body, program, rows = self.body, self.jet.rows.program, self.jet.rows
        change: dict[int, Pair] = {}
        for number, block in enumerate(self.jet.residual.blocks):
            size = len(block)
            place = body.place("%work", rows.block(number))
            right = body.place(place, 2 * size * (size + 1))
            for i, j in enumerate(block):
                value = self.at(program.residual[j], 0)
                assert value is not None
                body.put(-value, right, 2 * i, 1)
            body.line(f"  call void @solve(ptr {place}, ptr {right}, i64 {size})")
            for i, j in enumerate(block):
                rate = body.get(right, 2 * i, 1).divided(self.rate(1))
                change[program.velocities[j]] = rate
                change[program.coordinates[j]] = rate.divided(self.rate(2))
        given = set(change)
        for index, one in enumerate(program.series):
            if not one.corrected:
                continue
            if index not in given:
                made = self.correction(index, one, change)
                if made is None:
                    continue
                change[index] = made
            old = self.at(index, one.level)
            assert old is not None
            self.set(index, one.level, old + change[index])

    def correction(self, index: int, one: Series, change: dict[int, Pair]) -> Pair | None:
        """What the change of the operands' newest coefficients adds to a series' newest one."""

        def changed(series: int, ahead: int) -> Pair | None:
            return change.get(series) if self.jet.rows.program.series[series].level == ahead else None

        if one.op is Op.LINEAR:
            return self.linear(one, [changed(i, one.level) for i in one.arguments], None)
        if one.op is Op.MULTIPLY:
            a, b = one.arguments
            total = None
            for moved, other in ((changed(a, one.level), b), (changed(b, one.level), a)):
                if moved is not None:
                    term = moved * self.first(other)
                    total = term if total is None else total + term
            return total
        if one.op is Op.DERIVATIVE:
            value = changed(one.arguments[0], one.level + 1)
            return value and value.scaled(self.rate(one.level + 1))
        if one.op is Op.PRIMITIVE:
            value = changed(one.arguments[0], one.level - 1)
            return value and value.divided(self.rate(one.level))
        value = changed(one.arguments[0], one.level)
        return value and value * self.jet.gains[index][0]
