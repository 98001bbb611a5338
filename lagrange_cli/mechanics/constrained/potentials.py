"""Functions of coordinates and t that constraints on velocities keep constant, found by integration.

The form sum_k a_k dq_k + b dt of an integrable constraint, or combination of constraints, is the differential
of a function F, up to a factor, which is looked for among its coefficients.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.expression.text import text_of
from lagrange_cli.expression.zero import is_zero
from lagrange_cli.mechanics.conservation import Conserved
from lagrange_cli.mechanics.constrained.frobenius import Form, integrability, integrable_forms
from lagrange_cli.mechanics.variables import graph_of
from lagrange_cli.model.model import Model

MOST_PAIRS = 6
"""Products of two coefficients by which a form is divided."""
MOST_OPERATIONS = 120
"""The largest number of operations in a form whose integral is looked for."""
ANTIDERIVATIVES = {
    "sin": ("cos", -1.0), "cos": ("sin", 1.0),
    "exp": ("exp", 1.0), "sinh": ("cosh", 1.0), "cosh": ("sinh", 1.0),
}  # fmt: skip


def integrals(model: Model[Node]) -> list[tuple[Conserved, Node]]:
    """What the constraints on velocities keep constant, alone or in combination, for whatever parameters, as
    far as the functions are found; unless events may set coordinates or parameters."""
    if all(one.holonomic for one in model.constraints) or any(event.changes for event in model.events):
        return []
    graph, found = graph_of(model), integrability(model, {})
    made = list[tuple[Conserved, Node]]()
    for name, form in integrable_forms(model, found).items():
        node = integral(graph, form, (*model.q, model.time))
        if node is not None:
            because = f"{name} is integrable, by Frobenius' theorem"
            made.append((Conserved(f"F_{len(made) + 1}", text_of(node), because), node))
    return made


def integral(graph: Graph, form: Form, variables: Sequence[Node]) -> Node | None:
    """A function that an integrable form, with coefficients by the numbers of its ``variables``, keeps
    constant; None where none is found."""
    made = (potential(graph, divided, variables) for divided in closed_forms(graph, form, variables))
    return next((one for one in made if one is not None), None)


def closed_forms(graph: Graph, form: Form, variables: Sequence[Node]) -> Iterator[Form]:
    """The form, divided by 1, by a coefficient or by two of them, where that is the differential of a
    function; none of a long form."""
    if sum(map(operations, form.values())) > MOST_OPERATIONS:
        return
    factors = [a for a in form.values() if a.symbols]
    pairs = [a * b for i, a in enumerate(factors) for b in factors[i:]]
    for divisor in (graph.one, *factors, *pairs[:MOST_PAIRS]):
        divided = {k: a / divisor for k, a in form.items()}
        if is_closed(graph, divided, variables):
            yield divided


def is_closed(graph: Graph, form: Form, variables: Sequence[Node]) -> bool:
    """Whether da_i/dx_j = da_j/dx_i for all coefficients, as that of a differential."""
    zero = graph.zero
    return all(
        is_zero(graph.diff(form.get(i, zero), x) - graph.diff(form.get(j, zero), y))
        for i, y in enumerate(variables)
        for j, x in enumerate(variables[:i])
        if i in form or j in form
    )


def operations(node: Node) -> int:
    """The number of operands in an expression, written out."""
    count: dict[Node, int] = {}
    for one in reachable([node]):
        count[one] = 1 + sum(count[argument] for argument in one.arguments)
    return count[node]


def potential(graph: Graph, form: Form, variables: Sequence[Node]) -> Node | None:
    """F with dF = sum a dx; None where its terms are not found by elementary rules."""
    found, zero = graph.zero, graph.zero
    for k, x in enumerate(variables):
        missing = form.get(k, zero) - graph.diff(found, x)
        if is_zero(missing):
            continue
        part = antiderivative(graph, missing, x)
        if part is None:
            return None
        found = found + part
    rates = (graph.diff(found, x) - form.get(k, zero) for k, x in enumerate(variables))
    return found if all(map(is_zero, rates)) else None


def antiderivative(graph: Graph, node: Node, x: Node) -> Node | None:
    """The integral over x of a sum whose terms have one factor each that contains it: a power of what is
    linear in x, or a function of that; None of another one."""
    if not node.symbols & x.symbols:
        return node * x
    scale, u = graph.split_coefficient(node)
    if u.kind is Kind.SUM:
        parts = [antiderivative(graph, one, x) for one in u.arguments]
        if any(one is None for one in parts):
            return None
        pairs = [(one, c) for one, c in zip(parts, u.data[1]) if one is not None]
        return scale * (graph.sum(pairs) + x * graph.constant(u.data[0]))
    factors = [*zip(u.arguments, u.data)] if u.kind is Kind.PRODUCT else [(u, 1)]
    moving = [(base, e) for base, e in factors if base.symbols & x.symbols]
    if len(moving) > 1:
        return None
    base, exponent = moving[0]
    rest = graph.product([(one, e) for one, e in factors if one is not base])
    inner = base.arguments[0] if base.kind is Kind.FUNCTION else base
    slope = graph.diff(inner, x)
    if slope.symbols & x.symbols:
        return None
    if base.kind is not Kind.FUNCTION:
        one = graph.function("log", (base,)) if exponent == -1 else base ** (exponent + 1) / (exponent + 1)
    elif exponent == 1 and base.data in ANTIDERIVATIVES:
        name, sign = ANTIDERIVATIVES[base.data]
        one = sign * graph.function(name, (inner,))
    else:
        return None
    return scale * rest * one / slope
