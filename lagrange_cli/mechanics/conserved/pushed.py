"""Integrals of linear systems that are driven: M a + G v + K q = f(t) with constant M, G and K.

Where u.G = g u.M and u.K = k u.M for a vector u, y = u.M q is a normal coordinate: y'' + g y' + k y = u.f.
Let Y(t) be one of its motions, and z'' - g z' + k z = 0. Then

    z (y' - Y') - (z' - g z) (y - Y)

is constant (L. D. Landau and E. M. Lifshitz, Mechanics, 3rd ed., section 22, without friction). Y is looked
for where all derivatives of u.f are sums of a few functions of t.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from itertools import combinations, product
from operator import mul
from random import Random

from lagrange_cli.errors import LagrangeError
from lagrange_cli.expression.evaluate import evaluate
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.expression.text import joined, text_of
from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.expression.zero import is_zero
from lagrange_cli.mechanics.conserved.ansatz import has_smooth_forces
from lagrange_cli.mechanics.conserved.combinations import combined
from lagrange_cli.mechanics.conserved.found import Found
from lagrange_cli.mechanics.conserved.linear import LinearSystem
from lagrange_cli.mechanics.conserved.noether import Change
from lagrange_cli.mechanics.conserved.reasons import term
from lagrange_cli.mechanics.conserved.residue_states import States
from lagrange_cli.mechanics.conserved.separation import multiplied_out, terms_of_sum
from lagrange_cli.mechanics.laurent import primitive
from lagrange_cli.mechanics.matrices import determinant, united
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.variables import variables
from lagrange_cli.records import dataclass
from lagrange_cli.spec.values import resolve_parameters

MOST_FUNCTIONS = 4
"""Functions of t of which Y consists."""
MOST_RESONANT = 2
"""The highest power of t with which Y grows in resonance."""
MOST_COUPLED = 3
"""Coupled coordinates whose normal modes are looked for."""
RATIOS = (0.0, 1.0, -1.0, 2.0, -2.0)
"""The components of u that are tried, up to a common factor, and perhaps divided by the masses."""
NEGLIGIBLE = 1e-9
"""What is smaller, relative to its terms, is 0."""

Functions = Mapping[Node, Node]
"""A function of t: the coefficients of others."""


def pushed(found: Found) -> None:
    """Integrals that are linear in coordinates and velocities, of normal modes that a force of t drives."""
    system = LinearSystem(found, States(found.model, found.noether))
    if not has_smooth_forces(found.model, found.noether) or not system.possible:
        return
    driving = Driving(found)
    for part in united(system.count, system.coupled):
        for mode in modes(system, part):
            for change, text, because in driving.integrals(mode):
                node = found.noether.current(change)
                if found.is_independent(node) and found.noether.keeps(change):
                    number = sum(name.startswith("C_") for name in found.names) + 1
                    found.add(f"C_{number}", text, because, change)


@dataclass(frozen=True)
class Mode:
    """u, as a change of the coordinates, by number, and y = sum_k ``weights``_k q_k, with
    y'' + ``drag`` y' + ``spring`` y = ``force``."""

    directions: Mapping[int, Node]
    weights: Mapping[int, Node]
    drag: Node
    spring: Node
    force: Node


def modes(system: LinearSystem, part: Sequence[int]) -> Iterator[Mode]:
    """Those with simple ratios of the coordinates that act on each other."""
    graph, count = system.graph, len(part)
    matrices = [[[rows[i][k] for i in part] for k in part] for rows in system.matrices]
    sizes = [[[drawn(one) for one in row] for row in rows] for rows in matrices]
    ratios = product(RATIOS if count > 1 else (1.0,), repeat=count) if count <= MOST_COUPLED else ()
    inverse = [graph.one / row[k] for k, row in enumerate(matrices[0])]
    scales = [[graph.one] * count] + [inverse] * (len({*inverse}) > 1)
    for ratio, scale in product(ratios, scales):
        if next((one for one in ratio if one), 0.0) != 1:
            continue
        u = [r * one for r, one in zip(ratio, scale)]
        numbers, *more = [[sum(map(mul, row, map(drawn, u))) for row in rows] for rows in sizes]
        at = max(range(count), key=lambda k: abs(numbers[k]))
        apart = [x * numbers[at] - y * one[at] for one in more for x, y in zip(one, numbers)]
        if numbers[at] and max(map(abs, apart)) < NEGLIGIBLE:  # the integral will be proven
            masses, *others = [
                [graph.sum([(m * x, 1.0) for m, x in zip(row, u)]) for row in rows] for rows in matrices
            ]
            drag, spring = (one[at] / masses[at] for one in others)
            directions = {k: one / masses[at] for k, one in zip(part, u) if not one.is_zero}
            force = graph.sum([(a * system.constant[k], 1.0) for k, a in directions.items()])
            weights = {k: m / masses[at] for k, m in zip(part, masses) if not is_zero(m)}
            yield Mode(directions, weights, drag, spring, force)


def drawn(node: Node) -> float:
    """The value of a constant at random values of the parameters."""
    names = [str(one.data) for one in reachable([node]) if one.kind is Kind.SYMBOL]
    value, _ = evaluate([node], {name: Random(name).uniform(0.6, 1.6) for name in names})
    return float(value[node])


def in_turning_frames(found: Found) -> None:
    """Report momenta along axes at rest where two coordinates are those of a frame that turns: velocities act
    on each other by Coriolis's force, -2 m w v."""
    graph, model = found.graph, found.model
    if not all(map(is_zero, found.noether.energetics.applied)):
        return
    momenta, matrix, time = found.noether.energetics.momenta, found.noether.matrix, model.time
    changes = list[Change]()
    for i, j in combinations(range(len(model.q)), 2):
        mixed = graph.diff(momenta[j], model.q[i]) - graph.diff(momenta[i], model.q[j])
        if mixed.is_zero or mixed.symbols & variables(model) or matrix[i][i] is not matrix[j][j]:
            continue
        angle = 0.5 * mixed / matrix[i][i] * time
        cos, sin = (graph.function(name, (angle,)) for name in ("cos", "sin"))
        changes += [Change({i: cos, j: -sin}), Change({i: sin, j: cos})]
        changes += [Change(gain=one * q) for one in (cos, sin) for q in (model.q[i], model.q[j])]
    if changes:
        combined(found, [*changes, Change(gain=time)])


class Driving:
    """The integrals of driven modes of a model."""

    def __init__(self, found: Found) -> None:
        self.found, self.graph, self.model = found, found.graph, found.model
        self.time = found.model.time

    def integrals(self, mode: Mode) -> Iterator[tuple[Change, str, str]]:
        """The changes that belong to them, their formulas and reasons: one for each z, times the number that
        ``motion`` is multiplied with."""
        motion = self.motion(mode) if mode.force.symbols & self.time.symbols else None
        if motion is None:
            return
        graph, model, (whole, moved) = self.graph, self.model, motion
        name, time = self.free("Y"), self.time.symbols
        parts = [[(m, one[k]) for k, m in mode.weights.items()] for one in (model.v, model.q)]
        speed, place = (graph.sum([(m * one, 1.0) for m, one in some]) for some in parts)
        own = [(m, model.coordinates[k]) for k, m in mode.weights.items()]
        away = joined([*(term(m, one) for m, one in own), f"-{name}"])
        words = f"({joined([*(term(m, velocity_name(one)) for m, one in own), f'-{name}_dot'])})", f"({away})"
        swings, pace, more = self.adjoint(mode)
        because = f"{away} moves as it would without the force that depends on t, since "
        because += f"{name} = {text_of(moved / whole, moving=time)} is a motion with it{more}"
        momenta = self.found.noether.energetics.momenta
        for z in swings:
            back = mode.drag * z - graph.diff(z, self.time)
            node = z * (whole * speed - graph.diff(moved, self.time)) + back * (whole * place - moved)
            texts = [term(one, said, time) for one, said in zip((z, back), words) if not is_zero(one)]
            text = joined(texts) if len(texts) == 1 or whole is graph.one else f"({joined(texts)})"
            text = words[0][1:-1] if text == words[0] and whole is graph.one else text
            directions = {k: whole * one * z for k, one in mode.directions.items()}
            gain = graph.sum([*((xi * momenta[k], 1.0) for k, xi in directions.items()), (node, -1.0)])
            *changed, gain = substituted(graph, [*directions.values(), gain], pace)
            yield (
                Change(dict(zip(directions, changed)), gain=multiplied_out(gain)),
                term(whole, text),
                because,
            )

    def free(self, name: str) -> str:
        """The name, or one like it that the file does not use."""
        while name in self._values or name in self.model.coordinates:
            name += "'"
        return name

    @cached_property
    def _values(self) -> Mapping[str, float]:
        """The parameters of the file."""
        spec = self.model.spec
        try:
            return {} if spec is None else resolve_parameters(spec)
        except LagrangeError:
            return {}

    def value(self, node: Node) -> float:
        """That of a constant; 0 where it is rounding alone, and 1 where parameters have no values."""
        names = {str(one.data) for one in reachable([node]) if one.kind is Kind.SYMBOL}
        if not names <= self._values.keys():
            return 1.0
        value, size = evaluate([node], self._values)
        return 0.0 if abs(value[node]) <= NEGLIGIBLE * size[node] else float(value[node])

    def adjoint(self, mode: Mode) -> tuple[list[Node], Mapping[Node, Node], str]:
        """Functions z, with a symbol for the frequency; what that is, and in words."""
        graph, square = self.graph, mode.spring - 0.25 * mode.drag * mode.drag
        growth = graph.function("exp", (0.5 * mode.drag * self.time,))
        size = self.value(square)
        if is_zero(mode.spring):
            other = self.time if is_zero(mode.drag) else graph.function("exp", (mode.drag * self.time,))
            plain = other is self.time and len(mode.directions) == 1  # a single coordinate moves uniformly
            return ([graph.one] if plain else [graph.one, other]), {}, ""
        if not size:
            return [growth, growth * self.time], {}, ""
        square = square if size > 0 else -square
        factor, rest = graph.split_coefficient(square)
        rate = math.sqrt(abs(factor)) * graph.product([(rest if factor > 0 else -rest, 0.5)])
        named = rate.kind not in (Kind.SYMBOL, Kind.NUMBER)
        symbol = graph.symbol(self.free("s")) if named else rate
        names = ("cos", "sin") if size > 0 else ("cosh", "sinh")
        swings = [growth * graph.function(name, (symbol * self.time,)) for name in names]
        return swings, {symbol: rate} if named else {}, f"; {symbol.data} = sqrt({text_of(square)})" * named

    def motion(self, mode: Mode) -> tuple[Node, Node] | None:
        """A number, and Y times it; None where Y is not found, or the number is 0 for values in the file."""
        graph, left = self.graph, {**self.in_time(mode.force)}
        parts = list[tuple[Node, Node]]()
        while left:
            functions = self.closed(next(iter(left)), lambda one: self.pushing(mode, one))
            part = self.response(mode, functions, {one: left.pop(one) for one in functions if one in left})
            if part is None or not self.value(part[0]):
                return None
            parts.append(part)
        numbers = dict.fromkeys(below for below, _ in parts)
        whole = graph.split_coefficient(graph.product([(one, 1) for one in numbers]))[1]
        return whole, graph.sum([(whole / below * above, 1.0) for below, above in parts])

    def response(self, mode: Mode, functions: Sequence[Node], force: Functions) -> tuple[Node, Node] | None:
        """The same for a force that consists of some functions, by Cramer's rule: a sum of these, or in
        resonance of their products with t or t^2."""
        graph = self.graph
        for power in range(MOST_RESONANT + 1):
            if power == 1:
                functions = self.closed(functions[0], lambda one: self.in_time(graph.diff(one, self.time)))
            count, found = len(functions), [one * self.time**power for one in functions]
            if count > MOST_FUNCTIONS:
                return None
            pushes = [self.pushing(mode, one) for one in found]
            matrix = [[push.get(one, graph.zero) for push in pushes] for one in functions]
            below = determinant(graph, matrix)
            if not is_zero(below):
                right = [force.get(one, graph.zero) for one in functions]
                rows = [*zip(matrix, right)]
                above = [
                    determinant(graph, [[*row[:c], f, *row[c + 1 :]] for row, f in rows])
                    for c in range(count)
                ]
                below, *above = primitive(graph, [below, *above])
                return below, graph.sum([(factor * one, 1.0) for factor, one in zip(above, found)])
        return None

    def closed(self, function: Node, change: Callable[[Node], Functions]) -> list[Node]:
        """A function, those that it consists of after a ``change``, and so on; more than ``MOST_FUNCTIONS``
        of them where it does not end."""
        found = [function]
        for one in found:
            found += [other for other in change(one) if other not in found]
            if len(found) > MOST_FUNCTIONS:
                break
        return found

    def pushing(self, mode: Mode, motion: Node) -> Functions:
        """The force that y needs to move like this."""
        first = self.graph.diff(motion, self.time)
        return self.in_time(self.graph.diff(first, self.time) + mode.drag * first + mode.spring * motion)

    def in_time(self, node: Node) -> Functions:
        """A function of t in terms of those that it is a sum of."""
        graph, found = self.graph, dict[Node, list[tuple[Node, float]]]()
        constant = node.data[0] if node.kind is Kind.SUM else 0.0
        for one, c in [*terms_of_sum(node, 1.0), (graph.constant(constant), 1.0)]:
            factor, rest = graph.split_parameters(one, self.time.symbols)
            steady = not one.symbols & self.time.symbols
            found.setdefault(graph.one if steady else rest, []).append((one if steady else factor, c))
        sums = {one: graph.sum(terms) for one, terms in found.items()}
        return {one: total for one, total in sums.items() if not is_zero(total)}
