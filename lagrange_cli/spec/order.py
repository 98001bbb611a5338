"""What things are made of, and the order in which they can be computed."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from heapq import heappop, heappush
from typing import Any

from lagrange_cli.expression.syntax import names
from lagrange_cli.expression.vocabulary import BODY_COMPONENTS
from lagrange_cli.spec.content import statements
from lagrange_cli.spec.draft import Declared, Written, WrittenBody
from lagrange_cli.spec.spec import Expression, distinct
from lagrange_cli.spec.whole import WrittenFamily

AXES = ".R"
"""Stands for the axes of a body beside its position."""


def uses_of(groups: Mapping[str, Any]) -> dict[str, set[str]]:
    """The names that each of some groups uses, members of families apart. The axes of a body have a key of
    their own: a position may follow from them, and they from others."""
    found: dict[str, set[str]] = {}
    for name, group in groups.items():
        written = statements(group)
        found[name] = bases_in(*written, axes=True)
        if isinstance(group, WrittenFamily):
            found[name].discard(name)
        turned = [one.orientation for one in written if isinstance(one, WrittenBody) and one.orientation]
        if turned:
            found[name + AXES] = parts_in((value for one in turned for value in one.entries), axes=True)
    return found


def bases_in(*written: Written, axes: bool = False) -> set[str]:
    """The names that something uses; ``axes`` tells those of bodies from their positions."""
    return parts_in((one for each in written if (one := expression_of(each)) is not None), axes)


def parts_in(given: Iterable[Expression], axes: bool) -> set[str]:
    """The same of expressions."""
    return {
        name.base + AXES if axes and name.identifier.partition(".")[2] in BODY_COMPONENTS else name.base
        for one in distinct(given)
        for name in names(one.tree)
    }


def expression_of(written: Written) -> Expression | None:
    """The value of a parameter or a definition, or a position; None where it could not be read."""
    if isinstance(written, WrittenBody):
        return written.position
    found: Expression | None
    found = written.fields.get("value") if isinstance(written, Declared) else getattr(written, "value", None)
    return found


def value_of(written: Written) -> Expression:
    """The same of what could be read."""
    found = expression_of(written)
    assert isinstance(found, Expression)
    return found


def dependency_order(uses: Mapping[str, Iterable[str]]) -> tuple[list[str], list[list[str]]]:
    """The keys of ``uses``, each after all it uses and else in their order, and the cycles there are.

    Names that are no keys are ignored. A cycle is given from a name back to itself; its members, and what
    uses them, are missing from the order.
    """
    remaining = {name: {other for other in used if other in uses} for name, used in uses.items()}
    users: dict[str, list[str]] = {name: [] for name in uses}
    for name, used in remaining.items():
        for other in used:
            users[other].append(name)
    listed = list(uses)
    position = {name: number for number, name in enumerate(listed)}
    ready = [position[name] for name, used in remaining.items() if not used]
    order: list[str] = []
    while ready:
        name = listed[heappop(ready)]
        order.append(name)
        for user in users[name]:
            remaining[user].discard(name)
            if not remaining[user]:
                heappush(ready, position[user])
    stuck = {name: used for name, used in remaining.items() if used}
    return order, _cycles(stuck)


def leading_to(uses: Mapping[str, Iterable[str]], targets: Iterable[str]) -> list[str]:
    """Those keys of ``uses``, each of which comes after all it uses, that use one of the ``targets``, or what
    does."""
    known, found = set(targets), list[str]()
    for name, used in uses.items():
        if not known.isdisjoint(used):
            known.add(name)
            found.append(name)
    return found


class Needs(Exception):
    """Raised in computing one thing: another, of this name, must be computed before."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.name = name


def on_demand(wanted: Iterable[str], compute: Callable[[str], None]) -> tuple[list[str], list[list[str]]]:
    """Compute each of those ``wanted``, what it ``Needs`` first: the order of that, and the cycles.

    A member of a cycle, or what needs one, is not computed.
    """
    order: list[str] = []
    cycles: list[list[str]] = []
    seen: set[str] = set()
    for first in wanted:
        path = {} if first in seen else {first: None}  # in order, and quick to search
        while path:
            name = next(reversed(path))
            seen.add(name)
            try:
                compute(name)
            except Needs as needed:
                if needed.name in path:
                    walked = list(path)
                    cycles.append([*walked[walked.index(needed.name) :], needed.name])
                    path = {}
                elif needed.name in seen:  # it could not be computed, and neither can what waits for it
                    path = {}
                else:
                    path[needed.name] = None
            else:
                order.append(name)
                del path[name]
    return order, cycles


def chain(cycle: list[str], most: int = 10) -> str:
    """``a -> b -> a``, shortened if it is long."""
    shown = cycle if len(cycle) <= most else [*cycle[: most - 2], "...", cycle[-1]]
    return " -> ".join(shown)


def _cycles(stuck: Mapping[str, set[str]]) -> list[list[str]]:
    """Follow the dependencies of a stuck name until a name comes again: every such walk ends in a cycle."""
    cycles: list[list[str]] = []
    seen: set[str] = set()
    for name in stuck:
        path: list[str] = []
        position: dict[str, int] = {}
        while name not in seen:
            seen.add(name)
            position[name] = len(path)
            path.append(name)
            name = min(other for other in stuck[name] if other in stuck)
        if name in position:
            cycles.append([*path[position[name] :], name])
    return cycles
