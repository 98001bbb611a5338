"""Expressions that must be scalars, and how one is made of a vector."""

from __future__ import annotations

from lagrange_cli.expression.near import shown
from lagrange_cli.expression.syntax import Vector, names, plain_names
from lagrange_cli.spec.kinds import Kind
from lagrange_cli.spec.names import Names
from lagrange_cli.spec.spec import Expression


def check_scalar(names: Names, expression: Expression, section: str, where: str) -> frozenset[Kind]:
    """Check an expression that must be a scalar. Returns the kinds of its names."""
    kinds, bounds = names.check(expression, section, where)
    if isinstance(bounds, tuple):
        names.problems.add_once(
            expression.place,
            f"expected a scalar in {where}, found a vector",
            vector_hint(names, expression, section),
        )
        names.problems.distrust(expression.tree)
    return kinds


def vector_items(expression: Expression) -> list[str]:
    """The components of a vector as they are written, if it is a plain one; else an example."""
    tree = expression.tree
    items = tree.items if isinstance(tree, Vector) else ()
    return [expression.text[one.span.start : one.span.stop] for one in items] or ["1", "2"]


def vector_hint(known: Names, expression: Expression, section: str = "") -> str:
    """How a scalar is made of the vectors of an expression."""
    tree = expression.tree
    if isinstance(tree, Vector) and len(tree.items) == 1:
        return "leave out the comma at the end"
    if section == "parameters":
        items = ", ".join(vector_items(expression))
        return f"write a list, [{items}]; or write vectors under 'definitions'"
    vectors = [one for one in plain_names(tree) if isinstance(known.values.get(one), tuple)]
    for one in sorted(vectors):
        components = any(name.identifier.startswith(f"{one}.") for name in names(tree))
        if components and known.table[one].what is Kind.PARTICLE:  # m1*g*m1.y: the first m1 should be a mass
            return f"{shown(one)} is a position: write its mass as a parameter M, with 'masses: {{{one}: M}}'"
    hint = f"take a component, as in {min(vectors, default='bead')}.x, or norm() or dot()"
    return f"{shown(vectors[0])} is a vector: {hint}" if len(vectors) == 1 else hint
