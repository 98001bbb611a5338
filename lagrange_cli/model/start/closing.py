"""All closures of a system: of each block of its constraints in turn, given those of earlier ones."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import lru_cache
from itertools import islice, product
from typing import Any

from lagrange_cli.model.start.beginnings import starts
from lagrange_cli.model.start.blocks import Block, Pattern, blocks, reached
from lagrange_cli.model.start.closures import ALMOST, MOST_CLOSURES, Closures, closures, satisfied
from lagrange_cli.model.start.equations import KEPT, Masses, Row
from lagrange_cli.model.start.nearest import ROUND, Surface, Values
from lagrange_cli.records import dataclass

PLACES = 3
"""Places at which it is looked which coordinates constraints contain."""
TRIED = 16
"""Steps of the search, for each block: where blocks do not close, others are tried."""

Way = Mapping[int, float]
"""Values of unknown coordinates."""


class FreeCoordinates(Exception):
    """Coordinates with these numbers could change with the constraints still satisfied."""

    def __init__(self, numbers: Sequence[int]) -> None:
        super().__init__("free coordinates")
        self.numbers = [*numbers]


@dataclass(frozen=True)
class Closing:
    """``at`` has constraints and their slopes at a place, by number, of those that are asked for. All of them
    are the ``rows``; ``x`` is a state whose ``unknown`` coordinates do not count, ``scale`` the size of
    coordinates, and ``sizes`` are numbers of the system, among which the lengths of its parts may be."""

    at: Callable[[Sequence[float], Sequence[int]], tuple[Mapping[int, Any], Mapping[int, Row]]]
    rows: Sequence[int]
    unknown: Sequence[int]
    x: Sequence[float]
    scale: float
    sizes: Sequence[float]

    def closures(self) -> Closures:
        """All that are found."""
        contained = self.contained()
        if contained is None:
            return self.together()
        unknown = {*self.unknown}
        pattern = {i: some for i, row in contained.items() if (some := [k for k in row if k in unknown])}
        found, left = blocks(pattern, self.unknown)
        if left:
            return Closures([], left)
        chained = chains(found, pattern)
        try:
            ways = [[*islice(self.ways(chain, contained), MOST_CLOSURES)] for chain in chained]
            if all(ways):
                states = [self.state(*one) for one in islice(product(*ways), MOST_CLOSURES)]
                if satisfied(self.surface(), states[0], ALMOST):
                    return Closures(sorted(states), [])
                return self.together()
            best = [some[0] if some else self.best(one, contained) for some, one in zip(ways, chained)]
        except FreeCoordinates as error:
            return Closures([], error.numbers)
        return Closures([], [], self.state(*(one for one in best if one)) if all(best) else None)

    def together(self) -> Closures:
        """The same by all constraints at once."""
        return closures(self.surface(), self.x, self.sizes)

    def surface(self) -> Surface:
        """Where all constraints are satisfied."""

        def at(x: Sequence[Any]) -> Values:
            return self.at(x, self.rows)  # type: ignore[return-value]

        return Surface(at, self.rows, self.unknown, Masses({}), [self.scale] * len(self.x), ROUND)

    def state(self, *ways: Way) -> list[float]:
        """The state with these values."""
        known = {k: one for way in ways for k, one in way.items()}
        return [known.get(k, one) for k, one in enumerate(self.x)]

    def contained(self) -> dict[int, list[int]] | None:
        """The coordinates that each constraint contains; None where that is not known."""
        found: dict[int, dict[int, None]] = {i: {} for i in self.rows}
        seen = False
        for place in islice(starts(self.x, self.unknown, self.sizes, len(self.rows), []), PLACES):
            try:
                _, rows = self.at(place, self.rows)
            except ArithmeticError:
                continue
            seen = True
            for i in self.rows:
                found[i].update(dict.fromkeys(k for k, a in rows[i].items() if a))
        return {i: [*row] for i, row in found.items()} if seen else None

    def ways(self, chain: Sequence[Block], contained: Pattern) -> Iterator[Way]:
        """The closures of a chain of blocks. Raises ``FreeCoordinates`` where all that are found leave some
        open."""
        x, loose, closed = list(self.x), list[FreeCoordinates](), False

        def states(block: Block) -> Iterator[list[float]]:
            try:
                yield from self.within(block, contained, x).states
            except FreeCoordinates as error:
                loose.append(error)

        stack = [states(chain[0])]
        for _ in range(TRIED * (TRIED + len(chain))):
            values = next(stack[-1], None)
            if values is None:
                stack.pop()
                if not stack:
                    break
                continue
            for k, one in zip(chain[len(stack) - 1].unknown, values):
                x[k] = one
            if len(stack) == len(chain):
                closed = True
                yield {k: x[k] for block in chain for k in block.unknown}
            else:
                stack.append(states(chain[len(stack)]))
        if loose and not closed:
            raise loose[0]

    def best(self, chain: Sequence[Block], contained: Pattern) -> Way | None:
        """Values with which the constraints of a chain of blocks are almost satisfied."""
        x = list(self.x)
        for block in chain:
            found = self.within(block, contained, x)
            values = found.states[0] if found.states else found.best
            if values is None:
                return None
            for k, one in zip(block.unknown, values):
                x[k] = one
        return {k: x[k] for block in chain for k in block.unknown}

    def within(self, block: Block, contained: Pattern, x: list[float]) -> Closures:
        """The closures of a block, as the values of its unknown coordinates; earlier ones have their values
        in ``x``, in which these change."""
        numbers = sorted({*block.unknown, *(k for i in block.rows for k in contained[i])})
        place = {k: number for number, k in enumerate(numbers)}

        @lru_cache(maxsize=KEPT)
        def known(local: tuple[float, ...]) -> Values:
            for k, one in zip(numbers, local):
                x[k] = one
            values, rows = self.at(x, block.rows)
            mine = {i: {place[k]: a for k, a in rows[i].items() if k in place} for i in block.rows}
            return values, mine  # type: ignore[return-value]

        def at(local: Sequence[Any]) -> Values:
            return known(tuple(local))

        unknown = [place[k] for k in block.unknown]
        surface = Surface(at, block.rows, unknown, Masses({}), [self.scale] * len(numbers), ROUND)
        found = closures(surface, [x[k] for k in numbers], self.sizes)
        if found.left:
            raise FreeCoordinates([numbers[k] for k in found.left])
        best = None if found.best is None else [found.best[k] for k in unknown]
        return Closures([[one[k] for k in unknown] for one in found.states], [], best)


def chains(found: Sequence[Block], pattern: Pattern) -> list[list[Block]]:
    """The blocks that depend on each other, directly or not, in their order."""
    block_of = {k: b for b, one in enumerate(found) for k in one.unknown}
    around: list[set[int]] = [set() for _ in found]
    for b, one in enumerate(found):
        for c in {block_of[k] for i in one.rows for k in pattern[i]}:
            around[b].add(c)
            around[c].add(b)
    left = dict.fromkeys(range(len(found)))
    made: list[list[Block]] = []
    while left:
        part = reached([next(iter(left))], lambda b: around[b])
        for b in part:
            del left[b]
        made.append([found[b] for b in sorted(part)])
    return made
