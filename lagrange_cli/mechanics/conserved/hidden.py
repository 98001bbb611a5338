"""Conserved quantities that are quadratic in the velocities and belong to no change of coordinates and time.

Of one particle, or of two that move relative to each other, the sums

    sum a_ij m v_i v_j + b_ij v_i L_j + c_ij L_i L_j / m + f(r)

are looked through: their quadratic parts are the Killing tensors of flat space (products of translations and
rotations; Thompson, J. Math. Phys. 27, 2693, 1986). f is a sum of x_i, x_i x_j and of the terms of U times 1,
x_i and x_i x_j. Examples are the Laplace-Runge-Lenz vector (Goldstein, Classical Mechanics, 3rd ed.,
section 3.9), Fradkin's tensor of the isotropic oscillator (Am. J. Phys. 33, 207, 1965) and the constants of
two fixed centres and of the Stark effect.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.expression.text import joined, text_of
from lagrange_cli.expression.vocabulary import COMPONENTS
from lagrange_cli.expression.zero import is_zero
from lagrange_cli.mechanics.conservation import Conserved
from lagrange_cli.mechanics.conserved.found import Found
from lagrange_cli.mechanics.conserved.noether import Noether
from lagrange_cli.mechanics.conserved.reasons import term, without_denominators
from lagrange_cli.mechanics.conserved.separation import terms_of_sum
from lagrange_cli.mechanics.embedding import Embedding
from lagrange_cli.mechanics.variables import graph_of, variables
from lagrange_cli.model.model import Model, Particle
from lagrange_cli.records import dataclass, replace

MOST_TERMS = 4
"""Terms of U of which products are tried."""
TURNS = {2: {"z": (0, 1)}, 3: {"x": (1, 2), "y": (2, 0), "z": (0, 1)}}


Vector = tuple[str, str]
"""A component: of the velocity "v" or the angular momentum "L", and its axis."""


@dataclass(frozen=True)
class Candidate:
    """A function of the state, its ``rate`` of change along the motion, and what it is called. Where it
    depends on velocities, it is a product of ``vectors``, such as ("v", "x") and ("L", "z"). ``parts`` are
    its factors that are fixed, and the text of the others."""

    node: Node
    rate: Node
    text: str
    vectors: tuple[Vector, ...] = ()
    parts: tuple[Node, str] | None = None


def hidden(found: Found) -> None:
    """Conserved quantities quadratic in the velocities, of one particle or two. Components of a vector or of
    a tensor are all given; others only if they are no functions of what else is known."""
    given = candidates(found.model, found.noether)
    before, others = len(found.symmetries), list[tuple[Conserved, Node]]()
    for numbers in found.relations.relations([[one.rate] for one in given]):
        relation = dict(zip(numbers, without_denominators(found.graph, [*numbers.values()])))
        parts = [(given[i], factor) for i, factor in relation.items()]
        rate = found.graph.sum([(factor * one.rate, 1.0) for one, factor in parts])
        name, text, because, sign = described(found.model, given, relation)
        node = found.graph.sum([(factor * one.node, sign) for one, factor in parts])
        if not is_turning(given, relation) and not found.is_made(node) and is_zero(rate):
            if sum(not one.body for one in found.model.particles) > 1:
                because += "; m, r and v are those of the relative motion"
            if name and name not in found.names:
                found.store(Conserved(found.free_name(name), text, because), node)
            else:
                others.append((Conserved("", text, because), node))
    found.symmetries[before:] = sorted(found.symmetries[before:], key=lambda one: one.conserved.quantity)
    number = 0
    for each, node in others:
        if found.is_independent(node):
            number += 1
            found.store(replace(each, quantity=found.free_name(f"I_{number}")), node)


def candidates(model: Model[Node], noether: Noether) -> list[Candidate]:
    """The terms of the sums, functions of place first; none where the system is not of this kind."""
    moving = [one for one in model.particles if not one.body]
    dimensions = {len(one.position) for one in moving}
    if len(model.particles) != len(moving) or len(moving) not in (1, 2) or model.constraints:
        return []
    if len(dimensions) != 1 or len(model.q) != len(moving) * min(dimensions) or min(dimensions) == 1:
        return []
    driving = sum(v.symbols for v in model.v)
    if not any(x.symbols & model.time.symbols for one in moving for x in one.position):
        driving |= model.time.symbols  # else U may depend on t by the positions alone
    bound = [model.potential, *noether.energetics.applied]
    if any(one.symbols & driving for one in bound):
        return []
    if any(one.kind is Kind.SWITCH or one.data == "atan2" for one in reachable(bound)):
        return []  # a term of U may jump where U does not
    pushes = [forces(model, noether, one) for one in moving]
    if any(len(push) != min(dimensions) for push in pushes):
        return []
    return [*places(model, noether, moving), *products(graph_of(model), moving, pushes)]


def forces(model: Model[Node], noether: Noether, particle: Particle[Node]) -> list[Node]:
    """The force on a particle in space; shorter where it is not found."""
    graph, embedding, found = graph_of(model), Embedding(model), list[Node]()
    own = [force - graph.diff(model.potential, q) for q, force in zip(model.q, noether.energetics.applied)]
    for i in range(len(particle.position)):
        others = {(one.name, k): graph.zero for one in model.particles for k in range(len(particle.position))}
        directions = embedding.change({**others, (particle.name, i): graph.one})
        if directions is None:
            break
        found.append(graph.sum([(own[k] * xi, 1.0) for k, xi in directions.items()]))
    return found


def relative(graph: Graph, values: Sequence[Sequence[Node]]) -> list[Node]:
    """The vector of one particle, or the difference of those of two."""
    if len(values) == 1:
        return [*values[0]]
    return [graph.sum([(a, 1.0), (b, -1.0)]) for a, b in zip(*values)]


def places(model: Model[Node], noether: Noether, moving: Sequence[Particle[Node]]) -> Iterator[Candidate]:
    """Functions of place."""
    graph = graph_of(model)
    r = relative(graph, [one.position for one in moving])
    simple = [(x, name) for x, name in zip(r, COMPONENTS)]
    squares = [(a * b, squares_of(m, n)) for i, (a, m) in enumerate(simple) for b, n in simple[i:]]
    powers = parts_of(model.potential)[:MOST_TERMS]
    for node, text in (*simple, *squares):
        yield Candidate(node, noether.rate(node), text)
    for u in powers:
        for x, n in ((graph.one, ""), *simple, *squares):
            yield Candidate(x * u, noether.rate(x * u), times(model, n, u), parts=split_text(model, n, u))


def parts_of(potential: Node) -> list[Node]:
    """The terms of U that are no numbers."""
    return [one for one, _ in coefficients(potential)]


def times(model: Model[Node], name: str, node: Node) -> str:
    """Something that has a name, or 1, times a term of U."""
    fixed, text = split_text(model, name, node)
    return term(fixed, text).replace("*1/", "/")


def split_text(model: Model[Node], name: str, node: Node) -> tuple[Node, str]:
    """The fixed factors of this, and the text of the others."""
    fixed, rest = graph_of(model).split_parameters(node, variables(model))
    moving = text_of(rest) if rest.kind is not Kind.SUM else f"({text_of(rest)})"
    texts = [text for text in (name, moving) if text not in ("", "1")]
    return fixed, "*".join(texts).replace("*1/", "/") or "1"


def coefficients(potential: Node) -> list[tuple[Node, float]]:
    """The same, with their numerical coefficients."""
    return [(one, c) for one, c in terms_of_sum(potential, 1.0) if one.symbols]


def is_affine(model: Model[Node], node: Node) -> bool:
    """Whether it is a sum of coordinates with constant factors."""
    graph, moving = graph_of(model), variables(model)
    return not any(graph.diff(node, q).symbols & moving for q in model.q)


def squares_of(one: str, other: str) -> str:
    """The product of two components of r."""
    return f"{one}**2" if one == other else f"{one}*{other}"


def products(
    graph: Graph, moving: Sequence[Particle[Node]], pushes: Sequence[Sequence[Node]]
) -> Iterator[Candidate]:
    """Products of two components of velocity and angular momentum, each of the order of m v^2."""
    masses = [one.mass for one in moving]
    mass = masses[0] if len(masses) == 1 else masses[0] * masses[1] / (masses[0] + masses[1])
    r = relative(graph, [one.position for one in moving])
    v = relative(graph, [one.velocity for one in moving])
    a = relative(graph, [[f / m for f in push] for push, m in zip(pushes, masses)])
    known: dict[tuple[str, str], tuple[Node, Node]] = {
        ("v", name): (x, y) for name, x, y in zip(COMPONENTS, v, a)
    }
    for name, (i, j) in TURNS[len(r)].items():
        known["L", name] = r[i] * v[j] - r[j] * v[i], r[i] * a[j] - r[j] * a[i]
    keys = [*known]
    for i, one in enumerate(keys):
        for other in keys[i:]:
            (x, x_rate), (y, y_rate) = known[one], known[other]
            node, rate = mass * x * y, mass * (x_rate * y + x * y_rate)
            yield Candidate(node, rate, name_of(one, other), (one, other))


def name_of(one: tuple[str, str], other: tuple[str, str]) -> str:
    """The product of two components, with one mass in all."""
    first, second = (f"v{axis}" if kind == "v" else f"L_{axis}" for kind, axis in (one, other))
    text = f"{first}**2" if first == second else f"{first}*{second}"
    return f"m*{text}" if other[0] == "v" else f"{text}/m" if one[0] == "L" else text


def is_turning(given: Sequence[Candidate], relation: Mapping[int, Node]) -> bool:
    """Whether it is made of angular momenta alone, or of nothing that moves."""
    return all({kind for kind, _ in given[i].vectors} == {"L"} for i in relation) or not any(
        given[i].vectors for i in relation
    )


def described(
    model: Model[Node], given: Sequence[Candidate], relation: Mapping[int, Node]
) -> tuple[str, str, str, float]:
    """The name of a conserved sum if it has one, its formula, the reason, and the sign with which all this is
    meant."""
    moving = {given[i].vectors: factor for i, factor in relation.items() if given[i].vectors}
    kinds = {"".join(kind for kind, _ in one) for one in moving}
    still = {given[i].text: factor for i, factor in relation.items() if not given[i].vectors}
    name, because, sign = "", "a hidden symmetry: it is constant by the equations of motion", 1.0
    for axis, after, last in zip("xyz", "yzx", "zxy"):
        pairs: dict[tuple[Vector, ...], float] = {
            (("v", after), ("L", last)): 1.0,
            (("v", last), ("L", after)): -1.0,
        }
        if kinds == {"vL"} and moving.keys() <= pairs.keys():
            (first, factor), *_ = moving.items()
            sign = pairs[first] * (-1.0 if text_of(factor).startswith("-") else 1.0)
            because = "the equations of motion separate in parabolic coordinates"
            name = f"A_{axis}" if still else ""  # without forces it is a product of others
            parts = coefficients(model.potential)
            if sum(not one.body for one in model.particles) > 1:  # uniform fields do not act between them
                parts = [part for part in parts if not is_affine(model, part[0])]
            whole = {times(model, axis, one): c * factor * pairs[first] for one, c in parts}
            if still.keys() == whole.keys() and all(is_zero(still[one] - whole[one]) for one in whole):
                because = "a component of the Laplace-Runge-Lenz vector, v x L + U r"
    if kinds == {"vv"} and len(moving) == 1:
        ((one, other),) = moving
        if [*still] == [squares_of(one[1], other[1])]:
            name, because = f"F_{one[1]}{other[1]}", "a component of Fradkin's tensor, m v v + k r r"
    shown = [(sign * factor, given[i]) for i, factor in reversed([*relation.items()])]
    texts = [
        term(factor, one.text) if one.parts is None else term(factor * one.parts[0], one.parts[1])
        for factor, one in shown
    ]
    text = joined([one.replace("*1/", "/") for one in texts])
    return name, text, because, sign
