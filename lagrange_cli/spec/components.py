"""Constraints that are vectors: each of their components is a constraint, called ``NAME.x`` and so on.

A component that is 0 in every state, as the third one of a joint between bodies in a plane, is none.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

from lagrange_cli.expression.syntax import Binary, Call, Name, Negative, Sum, Tree, Vector
from lagrange_cli.expression.vocabulary import COMPONENTS, MULTIPLIER
from lagrange_cli.records import replace
from lagrange_cli.spec.content import by_name, groups_by_name, statements
from lagrange_cli.spec.draft import Draft
from lagrange_cli.spec.family import Family
from lagrange_cli.spec.names import Names
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.source import Expression
from lagrange_cli.spec.whole import WrittenFamily
from lagrange_cli.spec.zeros import Zeros

Given: TypeAlias = "Mapping[str, Expression]"
Spread: TypeAlias = "Tree | tuple[Tree, ...]"


def with_components(
    given: Given, families: Mapping[str, Family], draft: Draft, names: Names, problems: Problems
) -> tuple[Given, Mapping[str, Family]]:
    """Constraints and their families, those that are vectors by their components."""
    if problems.found:
        return given, families
    found: dict[str, Any] = {}
    known = dict(families)
    zeros: Zeros | None = None
    for name, group in groups_by_name(given).items():
        parts = [spread(one.tree, names) for one in statements(group)]
        counts = [len(one) if isinstance(one, tuple) else 0 for one in parts]
        if len(set(counts)) > 1:
            note_unlike(statements(group), counts, name, problems)
        elif not counts or not counts[0]:
            found[name] = group
            continue
        note_multipliers(name, names, problems)
        zeros = zeros or Zeros(draft, names, lambda tree: spread(tree, names))
        kept = [k for k in range(counts[0]) if not all(zeros.is_zero(one[k]) for one in parts)]  # type: ignore[index]
        for k in kept or range(counts[0]):
            own = name if counts[0] == 1 else f"{name}.{COMPONENTS[k]}"
            found[own] = component(group, k, own, names)
            if isinstance(group, WrittenFamily):
                known[own] = group.family.renamed(own)
    return by_name(found), known


def component(group: Any, k: int, name: str, names: Names) -> Any:
    """The component of a number of a constraint, or of a family of them."""

    def taken(one: Expression) -> Expression:
        items = spread(one.tree, names)
        assert isinstance(items, tuple)
        return replace(one, tree=items[k])

    if isinstance(group, WrittenFamily):
        return WrittenFamily(group.family.renamed(name), group.parts, group.order).mapped(taken)
    return taken(group)


def note_unlike(written: Sequence[Expression], counts: Sequence[int], name: str, problems: Problems) -> None:
    """Note members of a family that have not as many components as the first."""
    other = next(one for one, count in zip(written, counts) if count != counts[0])
    message = f"the members of '{name}' differ in their number of components"
    problems.add_once(other.place, message, "give all members the same number, or other names")


def note_multipliers(name: str, names: Names, problems: Problems) -> None:
    """Note where something contains the multiplier of a vector, which has several."""
    if name in names.multiplied:
        expression, tree, where = names.multiplied[name]
        message = f"'{name}' is a vector: '{name}.{MULTIPLIER}' in {where} would be several numbers"
        hint = f"write its components as constraints {name}_x, {name}_y, ... of their own"
        problems.add_once(expression.at(tree.span), message, hint)


def spread(tree: Tree, names: Names) -> Spread:
    """The components of an expression, if it is a vector; else the expression itself."""

    def of(inner: Tree) -> Spread:
        return spread(inner, names)

    if isinstance(tree, Vector):
        return tree.items
    if isinstance(tree, Name):
        meaning = names.table.get(tree.identifier)
        several = meaning.value if meaning is not None else None
        if not isinstance(several, tuple):
            return tree
        axes = COMPONENTS[: len(several)]
        return tuple(replace(tree, identifier=f"{tree.identifier}.{axis}") for axis in axes)
    if isinstance(tree, Negative):
        return each(lambda one: replace(tree, operand=one), of(tree.operand))
    if isinstance(tree, Sum):
        return each(lambda one: replace(tree, body=one), of(tree.body))
    if isinstance(tree, Call) and tree.function == "cross":
        return crossed(tree, *map(of, tree.arguments))
    if isinstance(tree, Binary):
        return each(lambda a, b: replace(tree, left=a, right=b), of(tree.left), of(tree.right))
    return tree


def each(made: Callable[..., Tree], *parts: Spread) -> Spread:
    """What is made of parts, component by component where there are vectors among them."""
    counts = [len(one) for one in parts if isinstance(one, tuple)]
    if not counts:
        return made(*parts)
    return tuple(
        made(*(one[k] if isinstance(one, tuple) else one for one in parts)) for k in range(counts[0])
    )


def crossed(tree: Call, left: Spread, right: Spread) -> tuple[Tree, ...]:
    """The components of a cross product."""
    assert isinstance(left, tuple)
    assert isinstance(right, tuple)

    def product(i: int, j: int) -> Tree:
        return Binary("*", left[i], right[j], tree.span)

    turns = ((1, 2), (2, 0), (0, 1))
    return tuple(Binary("-", product(i, j), product(j, i), tree.span) for i, j in turns)
