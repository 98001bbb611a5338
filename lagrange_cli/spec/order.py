"""The order in which things that depend on one another can be computed."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from heapq import heappop, heappush


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
    names = list(uses)
    position = {name: number for number, name in enumerate(names)}
    ready = [position[name] for name, used in remaining.items() if not used]
    order: list[str] = []
    while ready:
        name = names[heappop(ready)]
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


def on_demand(names: Iterable[str], compute: Callable[[str], None]) -> tuple[list[str], list[list[str]]]:
    """Compute each of ``names``, what it ``Needs`` first: the order in which that went, and the cycles.

    A member of a cycle, or what needs one, is not computed.
    """
    order: list[str] = []
    cycles: list[list[str]] = []
    seen: set[str] = set()
    for first in names:
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
