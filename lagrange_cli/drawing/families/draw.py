"""The drawing of families: points and lines come from what is written once for all members.

The work is that of numpy on whole families, so that it is proportional to the number of members, not to the
text that they would have. Curves and surfaces are not looked for: among so many particles they would hide
what moves.
"""

from __future__ import annotations

import numpy as np

from lagrange_cli.drawing.drawing import TRAILS, Camera, Dot, Drawing, Line, Pivot
from lagrange_cli.drawing.families.crowd import Crowd, Piece, Place, crowd_of
from lagrange_cli.drawing.families.rods import Lines, rods_of
from lagrange_cli.drawing.families.springs import springs_of
from lagrange_cli.drawing.line import APART, FEW, lie_together
from lagrange_cli.drawing.upright import TILT
from lagrange_cli.errors import TooLarge
from lagrange_cli.expression.index_arrays import Differ
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Node
from lagrange_cli.expression.syntax import ExpressionError
from lagrange_cli.families.arrays import Domain, Source
from lagrange_cli.families.groups import group_of
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.records import replace
from lagrange_cli.spec.content import names_of
from lagrange_cli.spec.spec import Spec
from lagrange_cli.spec.values import Values

MASSES = 1000
"""Masses that differ, up to which particles are drawn in sizes of their own."""


def family_drawing(spec: Spec, values: Values, start: float) -> Drawing | None:
    """The drawing of a system of families; None where it is of a kind that goes through the members."""
    try:
        crowd = crowd_of(spec, values, start)
        return Sketch(crowd).drawing()
    except (Unsuited, Differ, ExpressionError, TooLarge, ArithmeticError):
        return None


class Sketch:
    """A drawing while it is made: the points of the particles are first, those of pivots behind them."""

    def __init__(self, crowd: Crowd) -> None:
        self.crowd = crowd
        self.pieces = [*crowd.pieces]
        self.count = crowd.count
        self.pivots = list[int]()
        self.fixed: dict[Place, int] = {}

    def drawing(self) -> Drawing:
        """The finished drawing."""
        crowd = self.crowd
        rods, springs = rods_of(crowd), springs_of(crowd)
        springs = self.spread(springs)
        lines = [self.lines(rods), self.lines(springs)]
        up, camera = self.view()
        dots, sizes = self.dots()
        return Drawing(
            dimension=crowd.dimension,
            up=up,
            coordinates=tuple(names_of(crowd.spec.coordinates)),
            points=(),
            sizes=sizes,
            places=tuple(range(self.count)),
            dots=dots,
            rods=lines[0],
            springs=lines[1],
            pivots=tuple(map(Pivot, self.pivots)),
            trails=self.trails(),
            camera=camera,
            located=crowd.located(self.pieces, self.count),
        )

    # lines

    def lines(self, found: list[Lines]) -> tuple[Line, ...]:
        """Lines by the numbers of their ends, with points for pivots."""
        made = list[Line]()
        for one in found:
            starts = one.starts
            if starts is None:
                assert one.domain is not None
                starts = self.held(one.domain, one.place)
            made += map(Line, zip(starts.tolist(), one.ends.tolist()))
        return tuple(made)

    def held(self, domain: Domain, place: Place) -> np.ndarray:
        """The numbers of points that do not move: one, where it is the same for all members."""
        alike = not any(True for node in place for _ in self.crowd.slots.inside(node))
        if alike and place in self.fixed:
            return np.full(domain.count, self.fixed[place])
        count = 1 if alike else domain.count
        numbers = np.arange(self.count, self.count + count)
        self.pieces.append(Piece(Domain(1) if alike else domain, place, numbers, self.crowd.families[0]))
        self.pivots += numbers.tolist()
        self.count += count
        if alike:
            self.fixed[place] = int(numbers[0])
        return np.full(domain.count, numbers[0]) if alike else numbers

    def spread(self, springs: list[Lines]) -> list[Lines]:
        """The elongations of many particles on a line across it, if they begin where others are (see
        ``drawing.line``)."""
        crowd = self.crowd
        if not crowd.flat or crowd.dimension != 2:
            return springs
        along = 1 if crowd.upright else 0
        places = crowd.axes(crowd.pieces)[along]
        if crowd.count > 1 and not lie_together(crowd.initial.of(places)[:, 0].tolist()):
            return springs
        size, last, string = crowd.size, crowd.count - 1, crowd.count > FEW
        step = 8 * size / (last + 2) if string else APART * size
        ends = np.zeros(crowd.count, dtype=np.int64)

        def there(domain: Domain, numbers: np.ndarray, value: Node) -> Place:
            """The place of particles of these numbers, or where one of these would be."""
            k = crowd.slots.symbol(domain, crowd.builder.whole, numbers + 1)
            if string:
                return step * k, value
            return crowd.lifted((value + step * (k - 1.0),))

        self.pieces = [
            replace(one, place=there(one.domain, one.numbers, one.place[along])) for one in self.pieces
        ]
        found = []
        for one in springs:
            if one.starts is None and one.slack:
                assert one.domain is not None
                beyond = one.ends - 1
                at_last = one.ends == last
                seen = ends[one.ends] > 0
                beyond[at_last & ((crowd.count > 1) | seen)] = last + 1
                ends[one.ends] += 1
                one = replace(one, place=there(one.domain, beyond, one.place[along]))
            found.append(one)
        return found

    # the rest

    def dots(self) -> tuple[tuple[Dot, ...], tuple[Node, ...]]:
        """All particles, and the masses that they have."""
        crowd, builder = self.crowd, self.crowd.builder
        sizes: dict[Node, int] = {}
        masses = np.zeros(crowd.count, dtype=np.int64)
        first = 0
        names = [*names_of(crowd.spec.parameters)]
        for family in crowd.families:
            group = group_of(family, crowd.spec.masses)
            for domain, value, which in builder.pieces(group, np.arange(group.count)):
                if isinstance(value, tuple):
                    raise Unsuited
                inside = [*crowd.slots.inside(value)]
                if inside and len(sizes) + domain.count > MASSES:
                    masses[first + which] = -1
                    continue
                for i in range(domain.count if inside else 1):
                    own: dict[Node, Node] = {}
                    for symbol, slot in inside:
                        k = int(slot.table[i])
                        if slot.array is builder.given:
                            own[symbol] = crowd.graph.symbol(names[k])
                        elif slot.array.source is Source.WHOLE:
                            own[symbol] = crowd.graph.constant(float(k))
                        else:
                            raise Unsuited
                    node = substituted(crowd.graph, [value], own)[0] if own else value
                    number = sizes.setdefault(node, len(sizes))
                    masses[first + (which[i] if inside else which)] = number
            first += group.count
        numbers, found = masses.tolist(), list[Dot]()
        for colour, family in enumerate(crowd.families):
            for name in family.members:
                k = len(found)
                found.append(Dot(name, k, numbers[k] if numbers[k] >= 0 else None, colour))
        return tuple(found), tuple(sizes)

    def trails(self) -> tuple[int, ...]:
        """The particles that leave a trail: of many, the last one."""
        crowd = self.crowd
        if crowd.flat:
            return ()
        free = np.flatnonzero(crowd.moved.any(axis=1))
        return tuple((free if len(free) <= TRAILS else free[-1:]).tolist())

    def view(self) -> tuple[str, Camera]:
        """The axis that points upward, and the camera."""
        crowd = self.crowd
        if crowd.dimension == 2:
            return "y", Camera()
        rests = [
            not any(crowd.moves(one.place[k]) or crowd.timed(one.place[k]) for one in crowd.pieces)
            for k in range(3)
        ]
        across = next((k for k in (2, 1, 0) if rests[k]), None)
        if across is None:
            return "z", Camera()
        turn = -90.0 if across == 1 else 0.0
        return "y" if across == 2 else "z", Camera(azimuth=turn + TILT, elevation=TILT)
