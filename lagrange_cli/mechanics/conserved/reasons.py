"""Conserved quantities, and the reasons why they are conserved, in words and formulas for the user."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, factors_of, terms_of
from lagrange_cli.expression.text import joined, text_of
from lagrange_cli.expression.vocabulary import COMPONENTS, VELOCITY_COMPONENTS
from lagrange_cli.expression.zero import is_zero
from lagrange_cli.mechanics.conserved.noether import Change, Noether
from lagrange_cli.mechanics.variables import graph_of, variables
from lagrange_cli.model.model import Model

if TYPE_CHECKING:
    from lagrange_cli.mechanics.conserved.found import Trial

Named = Sequence[tuple[Node, "Trial"]]
"""Displacements of all particles, each times a factor."""
LONGEST, LONGEST_CHANGE = 400, 120
"""Longer formulas are described: those of currents, and of changes."""


def is_constant(model: Model[Node], change: Change) -> bool:
    """Whether it changes coordinates by constants."""
    moving = variables(model)
    return change.time is None and not any(xi.symbols & moving for xi in change.directions.values())


def has_field(model: Model[Node]) -> bool:
    """Whether momenta are more than mass times velocity, as in a magnetic field."""
    return any(model.potential.symbols & v.symbols for v in model.v)


def stands_for_all(model: Model[Node]) -> bool:
    """Whether its one particle is none of the file: the system moves like it (``flat``)."""
    return [one.name for one in model.particles] == [""]


def is_plain(model: Model[Node]) -> bool:
    """Whether the place of that particle is (x, y) or (x, y, z)."""
    place = tuple(model.particles[0].position)
    return place == tuple(model.q) and model.coordinates == COMPONENTS[: len(place)]


def momentum_text(model: Model[Node], axis: str) -> str:
    """The total momentum along an axis."""
    return f"{summed(model)}m*v{axis}" + f" - dU/dv{axis}" * has_field(model)


def turning_text(model: Model[Node], i: int, j: int) -> str:
    """The total angular momentum, of rotations from axis i to axis j."""
    if stands_for_all(model) and is_plain(model):  # the file gives L, and no mass
        momenta = [f"p_{axis}" for axis in COMPONENTS]
    else:
        momenta = [f"(m*{u} - dU/d{u})" if has_field(model) else f"m*{u}" for u in VELOCITY_COMPONENTS]
    spins = " + spins" * any(one.body for one in model.particles)
    return f"{summed(model)}{COMPONENTS[i]}*{momenta[j]} - {COMPONENTS[j]}*{momenta[i]}{spins}"


def summed(model: Model[Node]) -> str:
    """What is said before a term of each particle."""
    return "sum of " if len(model.particles) > 1 else ""


def unchanged(noether: Noether, change: Change) -> str:
    """The end of a sentence on a displacement of all particles that leaves the equations as they are."""
    applied = noether.energetics.applied
    constrained = ", and is compatible with the constraints" if noether.model.constraints else ""
    if constrained and not noether.leaves_everywhere(change):
        constrained = " where the constraints hold, and is compatible with them"
    same = "leaves L unchanged" if stands_for_all(noether.model) else "changes neither T nor U"
    if all(map(is_zero, applied)):
        return f"{same}{constrained}"
    work = graph_of(noether.model).sum([(xi * applied[k], 1.0) for k, xi in change.directions.items()])
    if is_zero(work):
        return f"{same}{constrained}; the other forces do no work in it"
    return f"leaves T unchanged{constrained}; U changes by the work of the other forces"


def current_text(model: Model[Node], change: Change, named: Named = ()) -> str:
    """A current in terms of momenta, coordinates and h; those of ``named`` displacements by their names. h is
    first if its factor is constant."""
    moving = variables(model)
    terms = [term(factor, one.name, moving) for factor, one in named]
    for k, xi in sorted(change.directions.items()):
        if xi.symbols & moving:
            from lagrange_cli.mechanics.laurent import multiplied_out

            xi = multiplied_out(graph_of(model), xi)
        terms.append(term(xi, f"p_{model.coordinates[k]}", moving))
    if change.time is not None and not change.time.is_zero:
        steady = not change.time.symbols & moving
        terms.insert(0 if steady else len(terms), term(-change.time, "h", moving))
    if change.gain is not None and not change.gain.is_zero:
        terms.append(text_of(-change.gain, moving=moving))
    text = joined(terms)
    return text if len(text) <= LONGEST else f"a sum of {len(terms)} terms with p_k"


def reason(noether: Noether, change: Change, named: Named, others: Change) -> str:
    """Why the current of a change is conserved, which consists of ``named`` displacements and ``others``."""
    model = noether.model
    gained = change.gain is not None and not is_zero(noether.rate(change.gain))
    ending = "adds only a total time derivative to L" if gained else "leaves L unchanged"
    if change.time is not None:
        ending = "leaves the action unchanged"
    if not all(map(is_zero, noether.energetics.applied)):
        ending = "leaves the equations of motion unchanged"
    if model.constraints:
        ending += " where the constraints hold, and is compatible with them"
    moving = variables(model)
    if named:
        turns = [f"{one.how}{by(factor, moving)}" for factor, one in named]
        turns += [f"changing {changes_text(model, others)}"] if others.directions or others.time else []
        the = "the " if summed(model) else ""
        meaning = "; ".join(f"{one.name} is {the}{one.text}" for _, one in named)
        comma = "," * (len(turns) > 1)
        return f"{', and '.join(turns)}{comma} {ending}; {meaning}"
    changed = [(model.coordinates[k], xi) for k, xi in sorted(change.directions.items())]
    names = [name for name, _ in changed]
    if is_constant(model, change) and len(names) > 1:
        ratio = " : ".join(text_of(xi) for xi in in_lowest_terms(graph_of(model), [xi for _, xi in changed]))
        return f"changing {', '.join(names[:-1])} and {names[-1]} together, in the ratio {ratio}, {ending}"
    if is_constant(model, change):
        return f"changing {names[0]} {ending}"
    if not names and change.time is graph_of(model).one:
        return f"a shift of t {ending}"
    return f"an infinitesimal change of {changes_text(model, change)} {ending}"


def by(factor: Node, moving: int) -> str:
    """How far something is displaced."""
    text = text_of(factor, moving=moving)
    return "" if text == "1" else f" by {text}"


def changes_text(model: Model[Node], change: Change) -> str:
    """What changes by what."""
    changed = [(model.coordinates[k], xi) for k, xi in sorted(change.directions.items())]
    changed += [] if change.time is None else [("t", change.time)]
    moving = variables(model)
    text = ", ".join(f"{name} by {text_of(xi, moving=moving)}" for name, xi in changed)
    return text if len(text) <= LONGEST_CHANGE else "the coordinates"


def in_lowest_terms(graph: Graph, ratio: Sequence[Node]) -> list[Node]:
    """A ratio of whole numbers without a common divisor, or of what is the same; any other one as it is."""
    if len({*ratio}) == 1:
        return [graph.one for _ in ratio]
    numbers = [float(xi.data) if xi.kind is Kind.NUMBER else math.nan for xi in ratio]
    if not all(number.is_integer() for number in numbers):
        return [*ratio]
    common = math.gcd(*map(int, numbers))
    return [graph.constant(number / common) for number in numbers]


def term(factor: Node, name: str, moving: int = 0) -> str:
    """``factor`` times something that has a name; in the factor, symbols that are ``moving`` come last."""
    if factor.kind is Kind.NUMBER and abs(factor.data) == 1:
        return f"-{name}" if factor.data < 0 else name
    single = factor.kind is Kind.SUM and len(factor.arguments) == 1 and factor.data[0] == 0
    if single and factor.data[1][0] == -1:
        return f"-{term(factor.arguments[0], name, moving)}"
    text = text_of(factor, moving=moving)
    return times(text, name) if single or factor.kind is not Kind.SUM else f"({text})*{name}"


def times(product: str, name: str) -> str:
    """A product, multiplied by what has a name: in front of what it is divided by."""
    depth = 0
    for at, sign in enumerate(product):
        depth += (sign == "(") - (sign == ")")
        if sign == "/" and depth == 0:
            above = "" if product[:at] == "1" else f"{product[:at]}*"
            return f"{above}{name}{product[at:]}"
    return f"{product}*{name}"


def without_denominators(graph: Graph, factors: Sequence[Node]) -> list[Node]:
    """The same ratio without denominators."""
    each = [terms_of(factor) for factor in factors]
    powers: dict[Node, float] = {}
    for term, _ in (one for terms in each for one in terms):
        for base, exponent in factors_of(graph.split_coefficient(term)[1]):
            powers[base] = min(exponent, powers.get(base, 0))
    common = [(base, -exponent) for base, exponent in powers.items() if exponent]
    if not common:
        return [*factors]
    return [graph.sum([(graph.product([(one, 1), *common]), c) for one, c in terms]) for terms in each]
