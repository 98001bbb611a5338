"""Integrals of heavy tops that belong to no symmetry: Kovalevskaya's, and Goryachev's and Chaplygin's.

A body turns about a fixed point, in a uniform field: U = c . gamma + constant, where gamma are the components
of a direction of space along the axes of the body and c is constant. With the angular velocity omega,

    d(I omega)/dt = I omega x omega + gamma x c,    dgamma/dt = gamma x omega.

If two moments of inertia about the fixed point are equal and twice the third, I3, and c is across the third
axis, then with z = omega_1 + i omega_2, nu = (c_1 + i c_2)/I3 and g = gamma_1 + i gamma_2

    d(z^2 - nu g)/dt = -i omega_3 (z^2 - nu g),

so that |z^2 - nu g|^2 is constant (S. Kovalevskaya, Acta Math. 12, 177, 1889). Besides the tops of Euler and
of Lagrange, whose integrals are those of symmetries, there is no other heavy top with a further algebraic
integral (E. Husson, 1906). If the two moments are four times the third, then

    d/dt [omega_3 |z|^2 - (c_1 omega_1 + c_2 omega_2) gamma_3/I3] =
        (c_2 omega_1 - c_1 omega_2) (I omega . gamma)/(4 I3^2),

so that it is constant on motions without angular momentum about the direction of the field (D. N. Goryachev,
1899; S. A. Chaplygin, 1901).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import chain

from lagrange_cli.expression.node import Kind, Node
from lagrange_cli.expression.text import joined
from lagrange_cli.expression.vocabulary import COMPONENTS
from lagrange_cli.expression.zero import is_zero, zeros
from lagrange_cli.mechanics.conservation import Conserved
from lagrange_cli.mechanics.conserved.noether import Noether
from lagrange_cli.mechanics.conserved.reasons import term
from lagrange_cli.mechanics.constrained.reactions import InSpace
from lagrange_cli.mechanics.relations import Relations
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.variables import graph_of, variables
from lagrange_cli.model.model import Model
from lagrange_cli.model.orientation import Turning
from lagrange_cli.model.rigid_body import moments_of
from lagrange_cli.model.scope import Scope
from lagrange_cli.records import dataclass
from lagrange_cli.spec.bodies.norms import norm_name

ROUNDED = 2.0**-48
"""Numbers that differ by so small a part of them do so by rounding."""
MOST_PARTICLES = 20
"""Axes that are fixed to the body."""
ANGLES, QUATERNION = 3, 4
"""Coordinates of a body with a fixed point."""

Matrix = Sequence[Sequence[Node]]


@dataclass(frozen=True)
class Top:
    """A heavy top: the ``inertia`` about its fixed point, and ``field``, the c of U = c . gamma, along the
    axes of the body; gamma is the row of R with the number ``up``."""

    body: str
    turning: Turning[Node]
    inertia: Matrix
    field: Sequence[Node]
    up: int


@dataclass(frozen=True)
class OnLevel:
    """A function of the state that motions conserve on which another one, the ``level``, is 0."""

    conserved: Conserved
    node: Node
    level: Node


def kovalevskaya(model: Model[Node], noether: Noether) -> tuple[Conserved, Node] | None:
    """The integral, and the function of q and q_dot that it is, where it is proven to be conserved."""
    found = symmetric_top(model, noether, 2)
    if found is None:
        return None
    top, k = found
    a, b = across(k)
    x, y = (top.field[i] / top.inertia[k][k] for i in (a, b))
    u, v = top.turning.in_body[a], top.turning.in_body[b]
    g, h = top.turning.axes[a][top.up], top.turning.axes[b][top.up]
    real = u * u - v * v - x * g + y * h
    imaginary = 2.0 * u * v - x * h - y * g
    node = real * real + imaginary * imaginary
    because = f"Kovalevskaya's top: {reason(k, 'twice')}"
    return Conserved("K", in_formula(top, (a, b), (x, y)), because), graph_of(model).sum([(node, 1.0)])


def goryachev_chaplygin(model: Model[Node], noether: Noether) -> OnLevel | None:
    """The integral on motions without angular momentum about the direction of the field."""
    found = symmetric_top(model, noether, 4)
    if found is None:
        return None
    (top, k), graph, name = found, graph_of(model), found[0].body
    a, b = across(k)
    x, y = (top.field[i] / top.inertia[k][k] for i in (a, b))
    w, gamma = top.turning.in_body, [axis[top.up] for axis in top.turning.axes]
    node = w[k] * (w[a] * w[a] + w[b] * w[b]) - (x * w[a] + y * w[b]) * gamma[k]
    level = graph.sum([(top.inertia[i][i] * w[i] * gamma[i], 1.0) for i in range(3)])
    u, v, n = (f"{name}.w{i + 1}" for i in (a, b, k))
    sums = [term(c, what) for c, what in ((x, u), (y, v)) if not is_zero(c)]
    text = f"{n}*({u}**2 + {v}**2) - "
    text += (sums[0] if len(sums) == 1 else f"({joined(sums)})") + f"*{name}.R{top.up + 1}{k + 1}"
    because = (
        f"Goryachev's and Chaplygin's top: {reason(k, 'four times')}; conserved since the angular momentum "
        f"about {COMPONENTS[top.up]} is 0, not on other motions"
    )
    return OnLevel(Conserved("G", text.replace("- -", "+ "), because), node, level)


def symmetric_top(model: Model[Node], noether: Noether, ratio: int) -> tuple[Top, int] | None:
    """A heavy top with two equal moments, ``ratio`` times the third one, and its centre of mass across the
    axis of that; and the number of that axis."""
    top = top_of(model, noether)
    if top is None:
        return None
    products = [top.inertia[i][j] for i in range(3) for j in range(3) if i != j]
    if zeros(products) < {*products}:
        return None
    moments = [top.inertia[i][i] for i in range(3)]
    for k, third in enumerate(moments):
        a, b = across(k)
        if all(is_zero(top.field[i]) for i in (a, b)) or not is_zero(top.field[k]):
            continue
        if are_equal(moments[a], moments[b]) and are_equal(moments[a], float(ratio) * third):
            return top, k
    return None


def across(k: int) -> tuple[int, int]:
    """The other axes, in cyclic order."""
    return (k + 1) % 3, (k + 2) % 3


def are_equal(one: Node, other: Node) -> bool:
    """Whether two moments are equal, at least up to rounding of the numbers of the file."""
    if one.kind is other.kind is Kind.NUMBER:
        return math.isclose(one.data, other.data, rel_tol=ROUNDED)
    return is_zero(one - other)


def reason(k: int, times: str) -> str:
    """What its moments are, in words."""
    return (
        f"two moments of inertia about the fixed point are equal and {times} the third, and "
        f"the centre of mass lies in the plane perpendicular to axis {k + 1}"
    )


def in_formula(top: Top, others: tuple[int, int], ratio: tuple[Node, Node]) -> str:
    """The integral in terms of a body's components."""
    (a, b), (x, y), name = others, ratio, top.body
    u, v = f"{name}.w{a + 1}", f"{name}.w{b + 1}"
    g, h = f"{name}.R{top.up + 1}{a + 1}", f"{name}.R{top.up + 1}{b + 1}"

    def total(text: str, *further: tuple[Node, str]) -> str:
        return joined([text, *(term(c, what) for c, what in further if not is_zero(c))])

    real, imaginary = total(f"{u}**2 - {v}**2", (-x, g), (y, h)), total(f"2*{u}*{v}", (-x, h), (-y, g))
    return f"({real})**2 + ({imaginary})**2"


def top_of(model: Model[Node], noether: Noether) -> Top | None:
    """The only body of a system, if it is a heavy top."""
    spec = model.spec
    if spec is None or len(spec.bodies) != 1 or model.redundant or model.lagrangian is not None:
        return None
    ((body, given),) = spec.bodies.items()
    quaternion = given.orientation.form == "quaternion"
    if len(model.q) != (QUATERNION if quaternion else ANGLES):
        return None
    if [one.name for one in model.constraints] != [norm_name(body)] * quaternion:
        return None
    if len(spec.embedding) > MOST_PARTICLES or not all(map(is_zero, noether.energetics.applied)):
        return None
    scope = Scope(spec, model.algebra)
    places = fixed_in(model, scope.turning(body), quaternion)
    if places is None:
        return None
    field = field_of(model, body, places, quaternion)
    if field is None:
        return None
    return Top(body, scope.turning(body), inertia_of(model, scope, body, places), *field)


def fixed_in(
    model: Model[Node], turning: Turning[Node], quaternion: bool
) -> Mapping[str, Sequence[Node]] | None:
    """Where each particle is in the body, if all are fixed in it and the body turns about the origin.

    It is seen in a pose in which R is made of numbers, and then proven.
    """
    graph = graph_of(model)
    pose = dict.fromkeys(model.q, graph.zero)
    if quaternion:
        pose[model.q[0]] = graph.one
    names = [one for one in model.particles if not one.body]
    axes = [substituted(graph, axis, pose) for axis in turning.axes]
    if any(x.kind is not Kind.NUMBER for axis in axes for x in axis):
        return None
    units = [[sum(float(x.data) * float(y.data) for x, y in zip(a, b)) for b in axes] for a in axes]
    if units != [[float(i == j) for j in range(3)] for i in range(3)]:
        return None
    found, left = {}, []
    for one in names:
        there = substituted(graph, one.position, pose)
        place = [graph.sum([(x * e, 1.0) for x, e in zip(there, axis)]) for axis in axes]
        found[one.name] = place
        if any(x.symbols & variables(model) for x in place):
            return None
        for k, x in enumerate(one.position):
            left.append(x - graph.sum([(s * axis[k], 1.0) for s, axis in zip(place, turning.axes)]))
    left = [*substituted(graph, left, normalized(model))] if quaternion else left
    return found if zeros(left) >= {*left} else None


def normalized(model: Model[Node]) -> Mapping[Node, Node]:
    """The coordinates of a quaternion divided by its length."""
    graph = graph_of(model)
    square = graph.sum([(q * q, 1.0) for q in model.q])
    return {q: graph.product([(q, 1), (square, -0.5)]) for q in model.q}


def inertia_of(
    model: Model[Node], scope: Scope[Node], body: str, places: Mapping[str, Sequence[Node]]
) -> Matrix:
    """About the origin, along the axes of the body."""
    graph = graph_of(model)
    squares, products = moments_of(scope, body)
    masses = {one.name: one.mass for one in model.particles}

    def second(i: int, j: int) -> Node:
        own = squares[i] if i == j else products.get((min(i, j), max(i, j)), graph.zero)
        further = [(masses[name] * place[i] * place[j], 1.0) for name, place in places.items()]
        return graph.sum([(own, 1.0), *further])

    moments = [[second(i, j) for j in range(3)] for i in range(3)]
    trace = graph.sum([(moments[i][i], 1.0) for i in range(3)])
    return [[(trace if i == j else graph.zero) - moments[i][j] for j in range(3)] for i in range(3)]


def field_of(
    model: Model[Node], body: str, places: Mapping[str, Sequence[Node]], quaternion: bool
) -> tuple[Sequence[Node], int] | None:
    """c of U = c . gamma, and which row of R gamma is; None where U is not of this kind."""
    graph, spec = graph_of(model), model.spec
    assert spec is not None
    scope = InSpace(spec, model.algebra)
    axes = scope.turning(body).axes
    potential = scope.total([scope.scalar(term) for term in spec.potential.values()])
    there = {
        scope.places[name, k]: graph.sum([(s * axis[k], 1.0) for s, axis in zip(place, axes)])
        for name, place in places.items()
        for k in range(len(place))
    }
    (potential,) = substituted(graph, [potential], there)
    rows = [[graph.diff(potential, axis[k]) for axis in axes] for k in range(3)]
    linear = graph.sum([(c * axis[k], 1.0) for k, row in enumerate(rows) for c, axis in zip(row, axes)])
    if are_moving(model, scope, [potential - linear, *chain.from_iterable(rows)]):
        guessed = rows_of(model, scope, axes, potential, quaternion)
        if guessed is None or are_moving(model, scope, chain.from_iterable(guessed)):
            return None
        rows = guessed
    acting = [k for k, row in enumerate(rows) if not all(map(is_zero, row))]
    return (rows[acting[0]], acting[0]) if len(acting) == 1 else None


def are_moving(model: Model[Node], scope: InSpace, nodes: Iterable[Node]) -> bool:
    """Whether one of these depends on the motion, also by a velocity or an angular velocity."""
    actual = substituted(graph_of(model), [*nodes], scope.actual)
    return any(one.symbols & variables(model) for one in actual)


def rows_of(
    model: Model[Node], scope: InSpace, axes: Sequence[Sequence[Node]], potential: Node, quaternion: bool
) -> list[list[Node]] | None:
    """c for each row of R, where U is written in coordinates: a sum of entries of R, guessed and proven."""
    graph = graph_of(model)
    entries = [(i, k) for k in range(3) for i in range(3)]
    nodes = [*(axes[i][k] for i, k in entries), potential]
    nodes = [*substituted(graph, nodes, scope.actual)]
    if quaternion:
        nodes = [*substituted(graph, nodes, normalized(model))]
    relation = Relations(graph, (model.time, *model.q, *model.v)).relations(
        [[one] for one in (graph.one, *nodes)]
    )
    found = next((one for one in relation if len(nodes) in one), None)
    if found is None:
        return None
    whole = found[len(nodes)]
    parts = [-(found.get(n + 1, graph.zero) / whole) for n in range(len(entries))]
    left = nodes[-1] - graph.sum([(c * x, 1.0) for c, x in zip(parts, nodes)])
    left = left + found.get(0, graph.zero) / whole
    return [parts[3 * k : 3 * k + 3] for k in range(3)] if is_zero(left) else None
