"""Combinations of changes of coordinates and of time that conserve something together.

Each change has conditions under which it leaves the equations as they are. Relations between the conditions
are guessed from their values at random states, and proven.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from lagrange_cli.expression.node import Kind, Node, factors_of, reachable, union
from lagrange_cli.mechanics.conserved.found import Found, Trial
from lagrange_cli.mechanics.conserved.noether import Change
from lagrange_cli.mechanics.conserved.reasons import (
    current_text,
    is_constant,
    reason,
    without_denominators,
)  # fmt: skip
from lagrange_cli.mechanics.relations import rational
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.variables import variables

MOST_QUADRATIC, MOST_LINEAR, MOST_COMBINED = 3, 6, 40
"""The largest numbers of coordinates for which quadratic changes, linear ones, and combinations are tried."""


def combinations(found: Found) -> None:
    """Relations between the conditions for changes of coordinates."""
    model = found.model
    if not model.q or len(model.q) > MOST_COMBINED:
        return
    kept = combined(found, [*elementary(found)])
    turning = [k for one in kept for k, xi in one.directions.items() if xi is found.graph.one]
    cyclic = [k for k, name in enumerate(model.coordinates) if f"p_{name}" in found.names]
    if turning and len(cyclic) > 1:  # a body is turned together with its place, as in a fluid
        places = [Change({k: model.q[j]}) for j in cyclic for k in cyclic if j != k]
        combined(found, [*places, *turns_of_spheres(found, turning)])
    if len(model.q) <= MOST_LINEAR and not any(one.body for one in model.particles):  # short formulas
        with_factors(found)


def combined(found: Found, changes: Sequence[Change], *, linear: bool = False) -> list[Change]:
    """Report what combinations of these changes conserve; those of several coordinates. Functions of what is
    known are left out; where only ``linear`` functions count, h is none of these."""
    model, kept = found.model, list[Change]()
    trials = {id(one.change): one for one in found.trials}
    columns = found.noether.conditions(changes)
    number = sum(name.startswith("C_") for name in found.names)
    relations = found.relations.relations(columns)
    if found.eventful:  # the angular momentum of all that collides, before others that follow from it
        relations.sort(key=lambda one: any(factor.symbols for factor in one.values()))
    for relation in relations:
        parts = [(factor, changes[i]) for i, factor in relation.items()]
        parts = scaled(found, sorted(parts, key=lambda one: id(one[1]) not in trials))
        named = [(factor, trials[id(one)]) for factor, one in parts if id(one) in trials]
        change = found.noether.together(parts)
        others = found.noether.together([one for one in parts if id(one[1]) not in trials])
        if not named:
            change = others = in_lowest_terms(found, change)
            named, others = translated(found, change)
        node = found.noether.current(change)
        trivial = is_trivial(found, change, node, found.kept_linear if linear else None)
        if trivial and found.eventful and change.time is None and found.noether.keeps(change):
            found.currents.append(("", change))  # it may survive events together with others
        if not trivial and found.noether.keeps(change):
            name, because = momentum_of(found, change), reason(found.noether, change, named, others)
            because += found.place if named else ""
            if is_energy_first(found, change):  # h - omega L_z is named, not its opposite
                named = [(-factor, one) for factor, one in named]
                minus = -found.graph.one
                change, others = (found.noether.together([(minus, one)]) for one in (change, others))
            new = found.add(name or f"C_{number + 1}", current_text(model, others, named), because, change)
            number += new and not name
            kept += [change] if new and len(change.directions) > 1 and change.time is None else []
    return kept


def translated(found: Found, change: Change) -> tuple[list[tuple[Node, Trial]], Change]:
    """A change of several coordinates that is a displacement of all particles, by the name of that; and what
    is left of it."""
    moved = {**change.directions}
    for one in found.trials if len(moved) > 1 and change.time is None else ():
        own = one.change.directions
        if one.change.gain is None and own.keys() == moved.keys():
            factors = {moved[k] / xi for k, xi in own.items()}
            if len(factors) == 1 and not next(iter(factors)).symbols & variables(found.model):
                return [(factors.pop(), one)], Change(gain=change.gain)
    return [], change


def elementary(found: Found) -> Iterable[Change]:
    """Changes whose combinations are tried, simple ones first."""
    model, one = found.model, found.graph.one
    small = len(model.q) <= MOST_LINEAR
    yield from (Change({k: one}) for k in range(len(model.q)))
    yield from along_constraints(found)
    yield from (
        Change(gain=one) for one in (*(gains_of_places(found) if small else ()), *gains_of_time(found))
    )
    yield from (one.change for one in found.trials)
    cyclic = [k for k, name in enumerate(model.coordinates) if f"p_{name}" in found.names]
    yield from turns_of_spheres(found, cyclic) if small else ()
    if "h" not in found.names:
        yield Change(time=one)
    if small:
        yield from (Change({k: factor}) for factor in (model.time, *model.q) for k in range(len(model.q)))
        yield from (Change(time=factor) for factor in (model.time, *model.q))
    if given_by_lagrangian(found):
        yield from (Change({k: one}) for one in squares_of(model.q) for k in range(len(model.q)))


def gains_of_places(found: Found) -> Iterable[Node]:
    """Functions of q by whose rates changes may add to L, in magnetic fields."""
    model = found.model
    places = sum(q.symbols for q in model.q)
    given = [*model.q, *(x for each in model.particles for x in each.position)]
    yield from (x for x in dict.fromkeys(given) if x.symbols & places)
    if given_by_lagrangian(found):
        yield from squares_of(model.q)
    if not all(force.is_zero for force in found.noether.energetics.applied):  # of turning about an axis
        for each in model.particles:
            squares = [x * x for x in each.position]
            yield from (a + b for i, a in enumerate(squares) for b in squares[i + 1 :])


def given_by_lagrangian(found: Found) -> bool:
    """Whether a few coordinates may be those of any space, such as a sphere's by stereographic projection,
    and the gauge of a magnetic field any."""
    return found.model.lagrangian is not None and len(found.model.q) <= MOST_QUADRATIC


def squares_of(places: Sequence[Node]) -> list[Node]:
    """Products of two of them."""
    return [a * b for i, a in enumerate(places) for b in places[i:]]


def gains_of_time(found: Found) -> Iterable[Node]:
    """Functions of t by whose rates changes add to L: for uniform forces, also those that change with t."""
    model, graph = found.model, found.graph
    yield model.time
    time, energetics = model.time.symbols, found.noether.energetics
    for one in reachable([energetics.lagrangian, *energetics.applied]):
        if one.kind is Kind.FUNCTION and one.symbols & variables(model) == time:
            pair = ("sin", "cos") if one.data in ("sin", "cos") else (one.data,) * (one.data == "exp")
            known = [graph.function(name, one.arguments) for name in pair]
            yield from (*known, *([known[0] * known[1]] if len(known) > 1 else []))
        for base, power in factors_of(one) if one.symbols & variables(model) == time else ():
            if power == -1 or not (isinstance(power, int) and power > 0):  # of forces such as F/(t0 + t)
                yield graph.function("log", (base,)) if power == -1 else graph.product([(base, power + 1)])
    rate = energetics.lagrangian_rate(model.time)
    if rate.symbols & time or not rate.is_zero:
        yield from (model.time * model.time, model.time * model.time * model.time)


def along_constraints(found: Found) -> Iterable[Change]:
    """Changes that nonholonomic constraints allow, one for each coordinate that they leave free."""
    model, graph, known = found.model, found.graph, found.noether.eliminated
    if all(one.holonomic for one in model.constraints):
        return
    bound = {k: known[v] for k, v in enumerate(model.v) if v in known}
    for s, v in enumerate(model.v):
        slopes = {k: graph.diff(speed, v) for k, speed in bound.items()} if s not in bound else {}
        slopes = {k: slope for k, slope in slopes.items() if not slope.is_zero}
        if slopes:
            parts = [factors_of(graph.split_coefficient(slope)[1]) for slope in slopes.values()]
            below = dict.fromkeys(base for factors in parts for base, e in factors if e < 0)
            clearing = graph.product([(base, 1) for base in below])
            yield Change({s: clearing, **{k: clearing * slope for k, slope in slopes.items()}})


def with_factors(found: Found) -> None:
    """Report changes that constraints allow, times a function f of place. Where the rate of a current is the
    current times - sum_i c_i u_i_dot/u_i, its product with f = u_1^c_1 u_2^c_2 ... is conserved. The u_i are
    factors of the masses with which velocities are in it."""
    graph, noether, places = found.graph, found.noether, sum(q.symbols for q in found.model.q)
    for change in along_constraints(found):
        (current,) = substituted(graph, [noether.current(change)], noether.eliminated)
        masses = [graph.diff(current, v) for v in found.model.v]
        bases = dict.fromkeys(u for one in masses for u, _ in factors_of(one) if u.symbols & places)
        scaled_by = [noether.together([(u, change)]) for u in bases]
        rates, *others = noether.conditions([change, *scaled_by])
        columns = [[a / u - b for a, b in zip(own, rates)] for u, own in zip(bases, others)]
        powers = found.relations.combination(columns, [-one for one in rates]) if columns else None
        if powers and any(powers):
            factor = graph.product((u, int(c) if c == int(c) else c) for u, c in zip(bases, powers))
            combined(found, [noether.together([(factor, change)])], linear=True)


def turns_of_spheres(found: Found, turning: Sequence[int]) -> Iterable[Change]:
    """Parts of rotations about other axes than that of a ``turning`` angle phi: changes of theta by cos(phi),
    of phi by sin(phi) cot(theta), and so on, where a given L contains theta in sines; with hyperbolic
    functions of theta, those of a hyperbolic plane. A third angle of Euler changes by sin(phi)/sin(theta). A
    charge near a magnetic monopole gains terms such as cos(phi)/sin(theta)."""
    model, graph = found.model, found.graph
    if model.spec is None or model.spec.lagrangian is None:
        return
    lagrangian = found.noether.energetics.lagrangian
    inside = {one for one in reachable([lagrangian]) if one.kind is Kind.FUNCTION}
    for theta, angle in enumerate(model.q):
        for sine, cosine in (("sin", "cos"), ("sinh", "cosh")):
            across, along = (graph.function(name, (angle,)) for name in (sine, cosine))
            if inside.isdisjoint((across, along)):
                continue
            slope = along / across
            for phi in (k for k in turning if k != theta):
                for name in ("cos", "sin"):
                    turned = graph.function(name, (model.q[phi],))
                    yield from (Change({theta: turned}), Change({phi: turned * slope}))
                    others = (k for k in range(len(model.q)) if k not in (theta, phi))
                    yield from (Change({psi: turned / across}) for psi in others)
                    yield from (Change(gain=turned * one) for one in (slope, graph.one / across, across))


def scaled(found: Found, parts: Sequence[tuple[Node, Change]]) -> list[tuple[Node, Change]]:
    """The same with coefficients that have no denominators, the first of them positive."""
    factors = without_denominators(found.graph, [factor for factor, _ in parts])
    sign = -1.0 if found.graph.split_coefficient(factors[0])[0] < 0 else 1.0
    return [(sign * factor, change) for factor, (_, change) in zip(factors, parts)]


def in_lowest_terms(found: Found, change: Change) -> Change:
    """Divided by the common factor of the numbers in front of its rates, where these are simple fractions."""
    rates = [*change.directions.values(), *([] if change.time is None else [change.time])]
    if len(rates) == 1 and rates[0].kind is Kind.NUMBER:  # a momentum itself, or h
        return found.noether.together([(found.graph.one / rates[0], change)])
    numbers = [rational(abs(number)) for rate in rates for number in numbers_of(rate)]
    simple = [one for one in numbers if one]
    if not simple or len(simple) < len(numbers):
        return change
    whole = math.lcm(*(one.denominator for one in simple))
    common = math.gcd(*(int(one * whole) for one in simple))
    factor = found.graph.constant(whole / common)
    return change if whole == common else found.noether.together([(factor, change)])


def numbers_of(node: Node) -> Iterable[float]:
    """The numbers in front of the terms of a sum."""
    if node.kind is Kind.SUM:
        constant, coefficients = node.data
        return [one for one in (constant, *coefficients) if one]
    return [float(node.data) if node.kind is Kind.NUMBER else 1.0]


def is_trivial(found: Found, change: Change, node: Node, known: Sequence[Node] | None = None) -> bool:
    """Whether a current is trivial: it is 0 wherever the constraints hold; a coordinate grows linearly; and
    where it is no momentum, what follows from other currents, or from those that are ``known``."""
    model = found.model
    time, places = model.time.symbols, union(model.q)
    if not change.directions and change.time is None:
        return True
    if model.constraints and found.noether.vanishes(node):
        return True
    rates = [*change.directions.values(), *([] if change.time is None else [change.time])]
    turning = (
        change.time is not None and change.time.symbols & places
    )  # of a coordinate and t: Lorentz boosts
    free = [k for k in change.directions if f"p_{model.coordinates[k]}" in found.names]
    if any(one.symbols & time for one in rates) and not turning:
        single = len(change.directions) <= 1 or len(model.q) - len(model.constraints) <= 1
        if single and (change.time is None or free or not change.directions):
            return True
        if change.time is None and len(free) == len(change.directions):
            return True
    boost = turning and change.directions
    if boost or (all(is_circular(found, xi) for xi in change.directions.values()) and change.time is None):
        return False  # the components of a vector are all given
    return not is_constant(model, change) and not found.is_independent(node, known)


def is_energy_first(found: Found, change: Change) -> bool:
    """Whether a current contains h with a factor that is constant, and negative where it is a number."""
    time = change.time
    moving = variables(found.model)
    return time is not None and not time.symbols & moving and found.graph.split_coefficient(time)[0] > 0


def is_circular(found: Found, node: Node) -> bool:
    """Whether it has sines of conserved angles as factors, as the rotations in ``turns_of_spheres`` do, or of
    an angle that grows with t."""
    angles = [q for name, q in zip(found.model.coordinates, found.model.q) if f"p_{name}" in found.names]
    inside = (one for one in reachable([node]) if one.kind is Kind.FUNCTION and one.data in ("sin", "cos"))
    time, moving = found.model.time.symbols, variables(found.model)
    turned = [one.arguments[0] for one in inside]
    return any(one in angles or one.symbols & moving == time for one in turned)


def momentum_of(found: Found, change: Change) -> str:
    """The name of the momentum that a current is, if it is one."""
    if len(change.directions) != 1 or change.time is not None or change.gain is not None:
        return ""
    ((k, xi),) = change.directions.items()
    return f"p_{found.model.coordinates[k]}" if xi is found.graph.one else ""
