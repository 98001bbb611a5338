"""Coordinates without mass, such as the place where a spring and a damper in series are joined, or all
coordinates where L is linear in velocities, as that of vortices.

If L is linear in q_dot_k, and p_k = dL/dq_dot_k contains no velocities, the equation of motion of q_k,

    dp_k/dt - dL/dq_k - Q_k = 0,

contains no accelerations. It is a constraint: on velocities, or on coordinates where it contains no
velocities. The multiplier of such a constraint is 0, since the equation of q_k itself says that its force
along q_k vanishes. (First-order Lagrangians: L. Faddeev and R. Jackiw, Phys. Rev. Lett. 60, 1692, 1988.)
"""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence

from lagrange_cli.errors import LagrangeError, SpecError
from lagrange_cli.expression.evaluate import evaluate
from lagrange_cli.expression.exact import ExactGraphAlgebra
from lagrange_cli.expression.node import Kind, Node, reachable, union
from lagrange_cli.expression.syntax import ExpressionError
from lagrange_cli.expression.trees import tree_of
from lagrange_cli.mechanics.energetics import Energetics
from lagrange_cli.mechanics.variables import numbered
from lagrange_cli.model.build import build_model
from lagrange_cli.model.model import Model
from lagrange_cli.records import replace
from lagrange_cli.spec.content import by_name, groups_by_name
from lagrange_cli.spec.source import Source
from lagrange_cli.spec.spec import Expression, Spec

LINEAR = Kind.NUMBER, Kind.SYMBOL, Kind.SUM, Kind.PRODUCT
"""What an expression that is linear in velocities may have of them."""
NOTHING = 1e-9
"""The least singular value of a regular matrix, as a part of its largest one."""


def with_equations_of_the_massless(spec: Spec) -> Spec:
    """The system with the equations of coordinates without mass as constraints, or as one of first order
    where families are followed in loops; itself if there are none, or if they do not determine these
    coordinates: then it is refused where equations are derived, as other mistakes are.

    Raises ``SpecError`` where such an equation is not linear in velocities.
    """
    if spec.coordinate_families:
        from lagrange_cli.families.system import with_first_order

        spec = with_first_order(spec)
    return spec if spec.first_order else with_constraints_of_the_massless(spec)


def written_out(spec: Spec) -> Spec:
    """A system as it is derived member by member: no factor of a velocity is known not to be 0."""
    if not spec.first_order:
        return spec
    found = with_constraints_of_the_massless(replace(spec, first_order=()))
    return replace(found, faint=tuple(found.all_constraints))


def in_first_order(spec: Spec) -> Spec:
    """A system as one of first order, however few members it has; itself if it is of another kind."""
    if not spec.massless:
        return spec
    from lagrange_cli.families.system import any_family_system

    constraints, nonholonomic = (
        {name: one for name, one in some.items() if name not in spec.massless}
        for some in (spec.constraints, spec.nonholonomic)
    )
    names = tuple(spec.massless.values())
    found = replace(
        spec, constraints=constraints, nonholonomic=nonholonomic, massless={}, first_order=names, left_out=()
    )
    return spec if any_family_system(found) is None else found


def with_constraints_of_the_massless(spec: Spec) -> Spec:
    """The system with the equations of coordinates without mass as constraints, however many there are."""
    try:
        model = build_model(spec, ExactGraphAlgebra())
        found = equations_of_the_massless(model)
        if not found or not determined(model, found):
            return spec
    except (LagrangeError, ExpressionError, ArithmeticError):
        return spec
    velocities, sections = union(model.v), {True: dict[str, Expression](), False: dict[str, Expression]()}
    for k, left in found.items():
        one = spec.coordinates[k]
        if not linear(model, left):
            raise not_linear(spec, k)
        written = Expression("", tree_of(left), one.place)
        sections[not left.symbols & velocities][equation_name(one.name)] = written
    return replace(
        spec,
        constraints=by_name({**groups_by_name(spec.constraints), **sections[True]}),
        nonholonomic=by_name({**groups_by_name(spec.nonholonomic), **sections[False]}),
        massless={equation_name(model.coordinates[k]): model.coordinates[k] for k in found},
    )


def equation_name(coordinate: str) -> str:
    """What the constraint is called, as no constraint of a file can be."""
    return f"equation of {coordinate.replace('[', '(').replace(']', ')')}"


def equations_of_the_massless(model: Model[Node]) -> Mapping[int, Node]:
    """The left sides of the equations of motion of coordinates without mass that no constraint contains, by
    their numbers."""
    energetics, bound = Energetics(model), union(one.expression for one in model.constraints)
    velocities = union(model.v)
    return {
        k: equation(energetics, k, momentum)
        for k, momentum in enumerate(energetics.momenta)
        if not momentum.symbols & velocities and not (model.q[k].symbols | model.v[k].symbols) & bound
    }


def equation(energetics: Energetics, k: int, momentum: Node) -> Node:
    """dp_k/dt - dL/dq_k - Q_k, where p_k contains no velocities."""
    model, graph = energetics.model, energetics.graph
    rates = [(slope * model.v[j], 1.0) for j, slope in graph.gradient(momentum, numbered(model.q)).items()]
    rates.append((graph.diff(momentum, model.time), 1.0))
    forces = energetics.lagrangian_rate(model.q[k]) + energetics.applied[k]
    return graph.sum([*rates, (forces, -1.0)])


def determined(model: Model[Node], lefts: Mapping[int, Node]) -> bool:
    """Whether the equations determine the velocities of these coordinates, or the coordinates where they
    contain no velocities: whether their derivatives by these are a regular matrix at a random state."""
    import numpy as np

    graph, velocities = next(iter(lefts.values())).graph, union(model.v)
    rows: list[Sequence[Node]] = []
    for left in lefts.values():
        unknown = model.v if left.symbols & velocities else model.q
        rows.append([model.algebra.diff(left, unknown[k]) for k in lefts])
    entries = [one for row in rows for one in row]
    source = random.Random(1)
    names = [str(one.data) for one in reachable(entries) if one.kind is Kind.SYMBOL]
    values, _ = evaluate([*entries, graph.one], {name: source.uniform(0.3, 1.3) for name in names})
    sizes = np.linalg.svd(np.array([[values[one] for one in row] for row in rows], float), compute_uv=False)
    return bool(np.all(np.isfinite(sizes)) and sizes[-1] > NOTHING * sizes[0])


def linear(model: Model[Node], left: Node) -> bool:
    """Whether an expression is linear in velocities."""
    velocities = union(model.v)
    inside = [one for one in reachable([left]) if one.symbols & velocities]
    slopes = (model.algebra.diff(left, v) for v in model.v)
    return all(one.kind in LINEAR for one in inside) and not union(slopes) & velocities


def not_linear(spec: Spec, k: int) -> SpecError:
    """The error of an equation that is not."""
    one = spec.coordinates[k]
    message = f"the equation of motion of '{one.name}', which has no mass, is not linear in velocities"
    hint = "give it a mass, or write forces on it that are linear in velocities"
    return Source(spec.filename, spec.text).error(one.place, message, hint)
