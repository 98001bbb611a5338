"""Expressions in parameters and constant definitions, as options have them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from lagrange_cli.expression.algebra import Algebra
from lagrange_cli.expression.build import Builder
from lagrange_cli.expression.syntax import Tree, names
from lagrange_cli.expression.vocabulary import COMPONENTS
from lagrange_cli.spec.content import groups_by_name, statements
from lagrange_cli.spec.spec import Spec
from lagrange_cli.spec.whole import WrittenFamily


def made_of(bases: Iterable[str], spec: Spec) -> set[str]:
    """These names and all that they are made of, families without indices."""
    definitions = groups_by_name(spec.definitions)
    found, pending = set[str](), [*bases]
    while pending:
        base = pending.pop()
        if base not in found:
            found.add(base)
            for written in statements(definitions[base]) if base in definitions else ():
                pending += (one.base for one in names(written.tree))
    return found


def builder(
    trees: Iterable[Tree], spec: Spec, parameter: Callable[[str], Any], algebra: Algebra[Any]
) -> Builder:
    """What builds ``trees`` of parameters, which ``parameter`` gives the values of, and definitions."""
    values: dict[str, Any] = {}

    def scope(name: str) -> Any:
        base, _, component = name.partition(".")
        if base not in values:
            return parameter(name)
        return values[base][COMPONENTS.index(component)] if component else values[base]

    found = Builder(scope, algebra, spec.sizes)
    needed = made_of((one.base for tree in trees for one in names(tree)), spec)
    for name, group in groups_by_name(spec.definitions).items():  # each uses only earlier ones
        if name in needed:
            members = zip(group.names, group) if isinstance(group, WrittenFamily) else [(name, group)]
            for member, one in members:
                values[member] = found.build(one.tree, one.indices)
    return found
