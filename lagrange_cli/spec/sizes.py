"""The sizes of families: whole numbers that the ranges of indices are written with."""

from __future__ import annotations

from collections.abc import Mapping

from lagrange_cli.errors import UsageError
from lagrange_cli.expression.indices import integer
from lagrange_cli.expression.near import known_hint, near_hint
from lagrange_cli.expression.parse import parse
from lagrange_cli.expression.syntax import ExpressionError, Tree, plain_names
from lagrange_cli.expression.vocabulary import RESERVED, velocity_name
from lagrange_cli.spec.draft import Draft, Entry
from lagrange_cli.spec.order import chain, dependency_order
from lagrange_cli.spec.problems import Problems


def resolve_sizes(draft: Draft, overrides: Mapping[str, str], problems: Problems) -> dict[str, int]:
    """The sizes of the families; ``overrides`` are those of the command line, name to expression.

    Raises:
        UsageError: an override of an unknown size, or one that is no whole number greater than 0.
    """
    entries = {entry.name: entry for entry in draft.entries("sizes") if entry.name not in RESERVED}
    trees = {name: entry.value.tree for name, entry in entries.items() if entry.value is not None}
    for name, text in overrides.items():
        if name not in entries:
            raise UsageError(f"--size {name}={text}: {_no_size(draft, name, text, entries)}")
        try:
            trees[name] = parse(text)
        except ExpressionError as error:
            raise _usage(name, text, error) from error
    order, cycles = dependency_order({name: plain_names(tree) for name, tree in trees.items()})
    for cycle in cycles:
        problems.add(
            entries[cycle[0]].place, f"size '{cycle[0]}' depends on itself: {chain(cycle)}", "write a number"
        )
    found: dict[str, int] = {}
    for name in order:
        if plain_names(trees[name]) & (entries.keys() - found.keys()):
            continue  # follows from a problem already noted
        try:
            found[name] = _size(trees[name], found)
        except ExpressionError as error:
            if name in overrides:
                raise _usage(name, overrides[name], error) from error
            value = entries[name].value
            assert value is not None
            problems.add_expression(value, error, f"size '{name}'")
    problems.broken |= entries.keys() - found.keys()
    return {name: found[name] for name in entries if name in found}


def _no_size(draft: Draft, name: str, text: str, known: Mapping[str, Entry]) -> str:
    """Why a name is no size, and what was perhaps meant."""
    from lagrange_cli.spec.roles import COORDINATE, PARAMETER, VELOCITY, role_in_draft

    what = role_in_draft(draft, name)
    if what in (PARAMETER, COORDINATE, VELOCITY):
        declared = [*draft.declared("parameters"), *draft.declared("coordinates")]
        named = [one for one in declared if name in (one.name, velocity_name(one.name))]
        if any(one.key.axes or one.is_list for one in named):
            return f"'{name}' is a family; --set {name}[...]={text} sets a member of it"
        sets = "it" if what == PARAMETER else "its initial value"
        return f"'{name}' is {what}; --set {name}={text} sets {sets}"
    hint = near_hint(name, known) or known_hint(known) or "the file has no 'sizes'"
    return f"'{name}' is {what}, and no size; {hint}" if what else f"unknown size '{name}'; {hint}"


def _size(tree: Tree, known: Mapping[str, int]) -> int:
    value = integer(tree, known)
    if value <= 0:
        raise ExpressionError(tree.span, f"the value is {value}", "sizes are whole numbers greater than 0")
    return value


def _usage(name: str, text: str, error: ExpressionError) -> UsageError:
    return UsageError(f"--size {name}={text}: {error.message}; {error.hint}")
