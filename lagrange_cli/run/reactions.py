"""The forces of constraint on particles, for printing."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lagrange_cli.errors import UsageError
from lagrange_cli.records import replace

if TYPE_CHECKING:
    from lagrange_cli.spec.spec import Spec
    from lagrange_cli.symbolic.equations import Equations


def with_reactions(spec: Spec, equations: Equations) -> Equations:
    """The equations with the forces of constraint on the particles, as far as these are known.

    Raises ``UsageError`` where none is.
    """
    from lagrange_cli.expression.exact import ExactGraphAlgebra
    from lagrange_cli.mechanics.constrained.reactions import Reactions
    from lagrange_cli.mechanics.explicit import at_rates
    from lagrange_cli.run.derive import graph_model
    from lagrange_cli.symbolic.from_graph import from_graph
    from lagrange_cli.symbolic.reactions import reaction
    from lagrange_cli.symbolic.solved import known_accelerations

    if spec.lagrangian is not None:
        raise UsageError("no --form reactions: the file gives L, in which there are no particles")
    model = graph_model(spec, ExactGraphAlgebra())
    reactions = Reactions(model)
    known, symbols = known_accelerations(equations), [each.multiplier for each in equations.constraints]
    own = dict(zip(map(from_graph, (one.multiplier for one in model.constraints)), symbols))
    found, unknown = [], dict(reactions.unknown)
    for name, nodes in reactions.on_particles.items():
        components = [from_graph(node) for node in at_rates(model, nodes)[1]]
        written = [one.xreplace(own) for one in components if one is not None]
        if len(written) < len(components):
            unknown[name] = f"the force on '{name}' is too long to print"
        else:
            found.append(reaction(name, written, known, equations.order))
    if not found:
        raise UsageError(f"no --form reactions: {next(iter(unknown.values()))}")
    return replace(equations, reactions=tuple(found), unknown_reactions=unknown)
