"""Terms of which a conserved polynomial in the velocities may consist.

In flat space the terms of the highest degree are products of momenta and angular momenta, so that their
coefficients are polynomials in the coordinates (Thompson, J. Math. Phys. 27, 2693, 1986). By the equations of
motion, the coefficients of the terms two degrees lower are integrals of these times dU/dx. Candidates for
them are terms of U times polynomials; for the next terms, products of two terms of U, and so on.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations_with_replacement

from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.expression.vocabulary import COMPONENTS, velocity_name
from lagrange_cli.expression.written import as_written
from lagrange_cli.mechanics.conserved.noether import Noether
from lagrange_cli.mechanics.conserved.separation import terms_of_sum
from lagrange_cli.mechanics.variables import graph_of, variables
from lagrange_cli.model.model import Model
from lagrange_cli.records import dataclass, field

INVERSE = frozenset({"asin", "acos", "atan", "atan2"})
"""Functions that may jump or have kinks, such as atan(tan(x))."""

Powers = tuple[int, ...]
"""Exponents of variables."""


@dataclass(frozen=True)
class Variables:
    """What conserved sums are polynomials of: ``places`` and ``speeds``, functions of the state, and their
    names. They are ``flat`` if they are independent, and the places change at the speeds, with constant
    masses. ``words`` are names of functions."""

    places: Sequence[Node]
    speeds: Sequence[Node]
    names: Sequence[str]
    speed_names: Sequence[str]
    flat: bool = False
    words: Mapping[Node, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Material:
    """The parts of L and of the forces: functions of place that are not polynomials, with the degree of their
    polynomial factors, and the ``degree`` of the polynomials without such functions. Forces are ``odd`` if
    they change when all velocities are reversed."""

    functions: Mapping[Node, int] = field(default_factory=dict)
    degree: int = 0
    odd: bool = False


@dataclass(frozen=True)
class Term:
    """v^``speeds`` x^``places`` times a product of functions."""

    speeds: Powers
    places: Powers
    functions: tuple[Node, ...] = ()


def own_variables(model: Model[Node]) -> Variables:
    """The coordinates."""
    names = [velocity_name(name) for name in model.coordinates]
    return Variables(model.q, model.v, model.coordinates, names, not model.constraints)


def variables_in_space(model: Model[Node]) -> Variables | None:
    """The components of the particles' positions; None if something else moves freely, too."""
    if model.constraints or any(one.body for one in model.particles):
        return None
    moving = variables(model)
    found = {
        x: (u, f"{one.name}.{axis}".lstrip("."), f"{one.name}.v{axis}".lstrip("."))
        for one in model.particles
        for x, u, axis in zip(one.position, one.velocity, COMPONENTS)
        if x.symbols & moving
    }
    if len(found) < len(model.q):
        return None
    speeds, names, speed_names = zip(*found.values())
    return Variables([*found], speeds, names, speed_names, len(found) == len(model.q))


def material_of(model: Model[Node], noether: Noether, given: Variables) -> Material | None:
    """None where it is not of this kind."""
    graph, moving = graph_of(model), variables(model)
    lagrangian = -model.potential if model.lagrangian is None else model.lagrangian
    applied = [force for force in noether.energetics.applied if not force.is_zero]
    own = given.speeds is model.v
    functions: dict[Node, int] = {}
    degree, odd = 0, False
    for source, raised in ((lagrangian, 0), *((force, 1) for force in applied)):
        for term, _ in terms_of_sum(source, 1.0):
            rest, power, speeds = split(term, model, moving, own)
            if rest is None or any(rest.symbols & v.symbols for v in model.v):
                return None
            if speeds == 2 and not raised and not power and rest is graph.one:
                continue
            odd |= speeds % 2 == 1
            if rest is graph.one:
                degree = max(degree, power + raised)
                continue
            for one, highest in integrated(rest, power) if raised else ((rest, power),):
                functions[one] = max(functions.get(one, 0), highest)
    return Material(functions, degree, odd)


def has_smooth_forces(model: Model[Node], noether: Noether) -> bool:
    """Whether L and the forces have neither kinks nor jumps."""
    lagrangian = model.potential if model.lagrangian is None else model.lagrangian
    moving = variables(model)
    return all(is_smooth(one, moving) for one in reachable([lagrangian, *noether.energetics.applied]))


def is_smooth(node: Node, moving: int) -> bool:
    """Whether a function has neither kinks nor jumps where it has a value."""
    if node.kind in (Kind.SWITCH, Kind.DDT) or (node.data in INVERSE and node.symbols & moving):
        return False
    if node.kind is Kind.PRODUCT:  # x**2/sqrt(x**2) jumps with x
        roots = [a for a, e in zip(node.arguments, node.data) if not isinstance(e, int)]
        return all(a.kind in (Kind.SUM, Kind.SYMBOL, Kind.FUNCTION) or not a.symbols & moving for a in roots)
    return True


def split(term: Node, model: Model[Node], moving: int, own: bool) -> tuple[Node | None, int, int]:
    """The moving factors of a product without polynomials in coordinates and velocities; the degree of these
    polynomials; and the number of velocities."""
    graph = term.graph
    places, speeds, power, speed = {*model.q}, {*model.v}, 0, 0
    rest: list[tuple[Node, float]] = []
    factors = [*zip(term.arguments, term.data)] if term.kind is Kind.PRODUCT else [(term, 1)]
    for base, exponent in factors:
        if not base.symbols & moving:
            continue
        inner = degree_of(base, places, moving)
        if base in speeds:
            if not isinstance(exponent, int) or exponent < 0:
                return None, 0, 0
            speed += exponent
        elif own and inner is not None and exponent == int(exponent) and exponent > 0:
            power += inner * int(exponent)
        elif own and base in places and exponent > 0:
            whole = -int(-exponent // 1)
            power += whole
            rest.append((base, float(as_written(exponent)[0] - whole)))
        else:
            rest.append((base, exponent))
    return graph.product(rest), power, speed


def degree_of(node: Node, places: set[Node], moving: int) -> int | None:
    """The degree of a polynomial in the coordinates."""
    if not node.symbols & moving:
        return 0
    if node in places:
        return 1
    if node.kind is Kind.SUM:
        found = [degree_of(a, places, moving) for a in node.arguments]
        return None if None in found else max(n for n in found if n is not None)
    if node.kind is Kind.PRODUCT and all(isinstance(e, int) and e > 0 for e in node.data):
        each = [degree_of(a, places, moving) for a in node.arguments]
        return None if None in each else sum(n * e for n, e in zip(each, node.data) if n is not None)
    return None


def integrated(node: Node, power: int) -> list[tuple[Node, int]]:
    """Functions whose derivative may be a force, ``node`` times a polynomial of the degree ``power``."""
    factors = [*zip(node.arguments, node.data)] if node.kind is Kind.PRODUCT else []
    steep = [i for i, (_, exponent) in enumerate(factors) if exponent < -1]
    higher = [node.graph.product((a, e + (k == i)) for k, (a, e) in enumerate(factors)) for i in steep]
    return [(one, max(power - 1, 0)) for one in higher] or [(node, power + 1)]


def terms(given: Variables, material: Material, degree: int, most: int) -> list[Term]:
    """The terms of polynomials of a degree in the velocities, whose leading coefficients have the degree
    ``most`` in the coordinates; lower terms first. None of them is constant."""
    n, found = len(given.places), dict[Term, None]()
    kinds: list[tuple[Node | None, int]] = [*material.functions.items()]
    if material.degree:
        kinds.insert(0, (None, material.degree))
    for down in range(0, degree + 1, 1 if material.odd else 2):
        level = down if material.odd else down // 2
        for speeds in powers(n, degree - down):
            for chosen in products(kinds, level, material.odd):
                functions = tuple(one for one, _ in chosen if one is not None)
                highest = most + sum(power for _, power in chosen)
                for places in (one for k in range(highest + 1) for one in powers(n, k)):
                    found[Term(speeds, places, functions)] = None
    constant = Term((0,) * n, (0,) * n)
    return sorted((one for one in found if one != constant), key=order)


def order(term: Term) -> tuple[int, int, int]:
    """Terms of a low degree come first."""
    return sum(term.speeds), sum(term.places), len(term.functions)


def products(
    kinds: Sequence[tuple[Node | None, int]], level: int, fewer: bool
) -> Iterable[tuple[tuple[Node | None, int], ...]]:
    """Products of ``level`` factors, or of ``fewer``."""
    for count in range(0 if fewer else level, level + 1):
        yield from combinations_with_replacement(kinds, count)


def powers(count: int, degree: int) -> list[Powers]:
    """The exponents of all monomials of a degree."""
    found = []
    for chosen in combinations_with_replacement(range(count), degree):
        found.append(tuple(chosen.count(k) for k in range(count)))
    return found
