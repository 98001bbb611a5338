"""Refuses an orientation that is not a rotation: a body would be strained, and its motion wrong."""

from __future__ import annotations

from collections.abc import Sequence

from lagrange_cli.expression.node import Node
from lagrange_cli.expression.zero import is_zero
from lagrange_cli.mechanics.constraints import Constraints
from lagrange_cli.model.model import Model
from lagrange_cli.model.scope import Scope
from lagrange_cli.spec.source import Source
from lagrange_cli.spec.spec import Spec


def refuse_strain(model: Model[Node]) -> None:
    """Raise SpecError where a body's matrix is not orthogonal at all times, or mirrors. What constraints do
    not allow, such as a quaternion whose length is not 1, does not count."""
    spec = model.spec
    given = {} if spec is None else {k: b for k, b in spec.bodies.items() if b.orientation.form == "matrix"}
    for name in given:
        assert spec is not None
        axes: Sequence[Sequence[Node]] = Scope(spec, model.algebra).turning(name).axes
        if model.constraints:
            from lagrange_cli.mechanics.conserved.allowed_states import AllowedStates

            axes = AllowedStates(model, Constraints(model)).where_constraints_hold(axes)
        refuse_strained(spec, name, axes)


def refuse_strained(spec: Spec, name: str, axes: Sequence[Sequence[Node]]) -> None:
    """Raise SpecError where the columns of a body's matrix are not the axes of a rotation."""
    graph = axes[0][0].graph
    source, place = Source(spec.filename, spec.text), spec.bodies[name].orientation.place
    for i, one in enumerate(axes):
        for j, other in enumerate(axes[: i + 1]):
            product = graph.sum([(x * y, 1.0) for x, y in zip(one, other)])
            if not is_zero(product - graph.one if i == j else product):
                what = f"column {i + 1} does not have the length 1"
                if i != j:
                    what = f"columns {j + 1} and {i + 1} are not at right angles"
                message = f"the matrix of body '{name}' is not a rotation: {what}"
                raise source.error(place, message, "its columns are the body's axes in space")
    (a, b, c), (d, e, f), (g, h, k) = axes
    if is_zero(a * (e * k - f * h) + b * (f * g - d * k) + c * (d * h - e * g) + graph.one):
        message = f"the matrix of body '{name}' is not a rotation: it has the determinant -1"
        raise source.error(place, message, "turn one of its axes round")
