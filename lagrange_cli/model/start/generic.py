"""The constraints at consistent states nearby: which of them are independent, and whether the others
agree."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from contextlib import suppress
from typing import Any

from lagrange_cli.errors import NotLinear, SpecError
from lagrange_cli.expression.syntax import Binary, Call, Name, Negative, Tree, names
from lagrange_cli.model.start.dependence import APART, in_turn, independent, joined, tied
from lagrange_cli.model.start.linear import damped, scattered, steepness
from lagrange_cli.model.start.nearest import NEAR, ROUNDS
from lagrange_cli.model.start.search import NEARBY, TRIES, Generic, Search
from lagrange_cli.spec.spec import Spec

AGREE = 1e-7
"""Constraints that depend on others agree with them if they are off by no more nearby."""
FAINT = 1e-6
"""The part of the largest coefficient below which one is all but 0."""
EXACTLY = 1e-12
"""States nearby are consistent if constraints are off by no more."""
CLOSER = (1.0, 2.0**-5, 2.0**-10)
"""Parts of the usual distance: a long chain is far larger than its links, which limit how far it moves."""
PATIENCE = 10
"""Rounds in which constraints must be satisfied twice as well."""
LATER = (0.37, 1.13)
"""Times after the start at which a constraint is looked at that restricts nothing at the start."""


def refuse_constants(search: Search) -> None:
    """Refuse constraints whose gradient vanishes everywhere, or has no value where they are satisfied, and
    nonlinear constraints on velocities."""
    for name in search.names[: search.count]:
        function = length_of(search.spec, search.parameters, search.spec.constraints[name].tree)
        if function is not None:
            raise search.refusal.never_negative(name, function)
    v = search.given.v
    scale = search.metric(search.given.q)[0]
    q = search.first(scale)
    rows = search.rates(q, v).rows
    here = steepness(rows, scale)
    if search.spec.nonholonomic:
        faster = [a + size * b for a, size, b in zip(v, scale, scattered(0, len(v)))]
        others = search.rates(q, faster).rows
        for name, row, other in zip(search.names, rows, others):
            sizes = {k: abs(a) + abs(row.get(k, 0.0)) for k, a in other.items()}
            if any(abs(a - row.get(k, 0.0)) > NEAR * sizes[k] for k, a in other.items()):
                raise NotLinear(name)
    for i, (name, steep, usual) in enumerate(zip(search.names, here, search.typical(scale))):
        if steep == usual == 0.0:
            later = (search.rates(q, v, search.given.t + dt).rows for dt in LATER)
            awakes = any(steepness(rows, scale)[i] for rows in later)
            raise search.refusal.constant(name, float(search.given.t) if awakes else None)


def length_of(spec: Spec, parameters: Collection[str], tree: Tree) -> str | None:
    """The function, if an expression is a length or a root, perhaps times a constant."""

    def fixed(part: Tree) -> bool:
        return all(one.base in parameters for one in names(part))

    while True:
        if isinstance(tree, Negative):
            tree = tree.operand
        elif isinstance(tree, Name) and tree.identifier in spec.definitions:
            tree = spec.definitions[tree.identifier].tree
        elif isinstance(tree, Binary) and tree.operator == "*" and fixed(tree.left):
            tree = tree.right
        elif isinstance(tree, Binary) and tree.operator in ("*", "/") and fixed(tree.right):
            tree = tree.left
        else:
            break
    return tree.function if isinstance(tree, Call) and tree.function in ("norm", "sqrt") else None


def in_general(search: Search, q: Sequence[Any], scale: Sequence[float]) -> Generic:
    """Which constraints are independent at consistent states nearby, where most of them are."""
    if search.known is not None:
        return search.known.generic
    rows, typical = search.rates(q, search.given.v).rows, search.typical(scale)
    best = independent(rows, scale, typical)
    if len(best) == len(search.names):
        return Generic(tuple(best), tuple(typical))
    places = Places(search, q, scale)
    for part in CLOSER:
        seen, slopes = [best], [rows]
        later = NEARBY * places.move()  # the start may stand alone at its time
        for number in range(TRIES if not later else 2 * TRIES):
            t = search.given.t + later * max(0, number - TRIES + 1)
            near = places.nearby([*range(search.count)], number, t, part)
            if near is not None:
                there = search.rates(near, search.given.v, t).rows
                seen.append(independent(there, scale, typical, sine=APART))
                slopes.append(there)
        if len(seen) > 1:
            break
        rest = disagreement(places, best, part)
        if rest <= agreeing(part):
            return Generic(tuple(best), tuple(typical), joined(tied(rows, best, scale)), rest)
    else:  # a place that stands alone: nothing is known beyond it
        return Generic(tuple(range(len(search.names))), tuple(typical))
    best = max(seen, key=len)
    refuse_restricting(places, best, part)
    whole = [rows for rows, kept in zip(slopes, seen) if len(kept) == len(best)]
    found = joined(one for rows in whole for one in tied(rows, best, scale))
    return Generic(tuple(best), tuple(typical), found, in_turn=in_turn(whole, best, scale))


class Places:
    """Places near ``q`` that satisfy constraints, each found once."""

    def __init__(self, search: Search, q: Sequence[Any], scale: Sequence[float]) -> None:
        self.search, self.q, self.scale = search, q, scale
        self._found: dict[tuple[Any, ...], list[Any] | None] = {}

    def move(self) -> bool:
        """Whether constraints change with time at a place."""
        search = self.search
        times = search.given.t, search.given.t + NEARBY
        return any(float(one) for t in times for one in search.rates(self.q, search.given.v, t).drifts)

    def nearby(self, kept: Sequence[int], number: int, t: Any, part: float) -> list[Any] | None:
        """The place with this ``number``, at a ``part`` of the usual distance, that satisfies the constraints
        ``kept``, if there is one."""
        key = tuple(kept), number, t, part
        if key not in self._found:
            self._found[key] = self._nearby(kept, number, t, part)
        return self._found[key]

    def _nearby(self, kept: Sequence[int], number: int, t: Any, part: float) -> list[Any] | None:
        search, scale = self.search, self.scale
        place, least, since = search.away(self.q, scale, number, part), math.inf, 0
        for done in range(ROUNDS):
            try:
                values, rows = search.position_values(place, t)
                mine = [rows[i] for i in kept]
                off = search.worst([values[i] for i in kept], mine, scale)
                if off <= least / 2:
                    least, since = off, done
                elif done - since >= PATIENCE:
                    return None
                step = damped(mine, [float(values[i]) for i in kept], scale)
            except ArithmeticError:
                return None
            place = [x + step.get(k, 0.0) for k, x in enumerate(place)]
            if max((abs(dx) / scale[k] for k, dx in step.items()), default=0.0) <= EXACTLY:
                return place if off <= EXACTLY else None
        return None


def agreeing(part: float) -> float:
    """By how much constraints may be off at a ``part`` of the usual distance: other ones by its square."""
    return max(AGREE * part * part, EXACTLY)


def disagreement(places: Places, best: Sequence[int], part: float) -> float:
    """By how much the other constraints are off, relative to their size, where the ``best`` are satisfied
    nearby; infinite where that is not known."""
    search = places.search
    bound, found = [i for i in best if i < search.count], list[float]()
    for number in range(TRIES if not places.move() else 0):
        near = places.nearby(bound, number, search.given.t, part)
        if near is not None:
            values, rows = search.position_values(near)
            rest = [i for i in range(search.count) if i not in best]
            found.append(search.worst([values[i] for i in rest], [rows[i] for i in rest], places.scale))
    return max(found, default=math.inf)


def faint(search: Search, q: Sequence[Any], scale: Sequence[float]) -> tuple[str, ...]:
    """Constraints with a coefficient that is all but 0 beside others, here and nearby."""

    def at(place: Sequence[Any]) -> set[int]:
        rows = search.rates(place, search.given.v).rows
        terms = [[abs(float(a)) * scale[k] for k, a in row.items()] for row in rows]
        return {i for i, some in enumerate(terms) if min(some) <= FAINT * max(some)}

    found = at(q)
    if found:
        with suppress(SpecError):  # where another one has no value
            found &= at(search.away(q, scale, 0))
    return tuple(name for i, name in enumerate(search.names) if i in found)


def refuse_restricting(places: Places, best: Sequence[int], part: float) -> None:
    """Refuse constraints that depend on others and contradict them nearby or later."""
    search, scale, moving = places.search, places.scale, places.move()
    among = {*best}
    rest = [i for i in range(len(search.names)) if i not in among]
    bound = [i for i in best if i < search.count]
    for number in range(TRIES if rest else 0):
        for later in (0.0, NEARBY * (number + 1))[: 1 + moving]:
            t = search.given.t + later
            near = places.nearby(bound, number, t, part)
            if near is None:
                continue
            rates = search.rates(near, [0.0 * x for x in near], t)
            drifts = [float(rates.drifts[i]) for i in best]
            v = damped([rates.rows[i] for i in best], drifts, scale, damping=0.0)
            for i in rest:
                size = max(steepness([rates.rows[i]], scale)[0], search.typical(scale)[i])
                off = float(rates.values[i]) if i < search.count else 0.0
                if abs(off) > agreeing(part) * size:
                    raise search.refusal.restricting(search.names[i], later=bool(later))
                rate = sum(float(a) * v.get(k, 0.0) for k, a in rates.rows[i].items())
                rate += float(rates.drifts[i])
                speed = max((abs(dx) / scale[k] for k, dx in v.items()), default=0.0)
                if abs(rate) > AGREE * max(size * speed, abs(float(rates.drifts[i]))):
                    raise search.refusal.restricting(search.names[i], later=True)
