"""``Sheet``: a drawing while it is made. Equal places are one point, and so are equal sizes."""

from __future__ import annotations

from collections.abc import Iterable

from lagrange_cli.drawing.drawing import Dot, Drawing, Line, Locus, Pivot, Solid
from lagrange_cli.drawing.scene import Place, Scene
from lagrange_cli.expression.node import Node, union


class Sheet:
    """The drawing so far, in ``dimension`` dimensions."""

    def __init__(self, scene: Scene, dimension: int) -> None:
        self.scene = scene
        self.dimension = dimension
        self.points: dict[Place, int] = {}
        self.sizes: dict[Node, int] = {}
        self.groups: dict[str, int] = {}
        self.places: dict[int, None] = {}
        self.dots: list[Dot] = []
        self.rods: list[Line] = []
        self.springs: list[Line] = []
        self.pivots: dict[int, Pivot] = {}
        self.curves: list[Locus] = []
        self.solids: list[Solid] = []
        self.trails: list[int] = []
        self.abstract = False
        self.scaled = True

    def point(self, place: Place, seen: bool = True) -> int:
        """The number of a place; one that need not be ``seen`` does not move the camera."""
        number = self.points.setdefault(place, len(self.points))
        if seen:
            self.places[number] = None
        return number

    def direction(self, vector: Place) -> int:
        """The number of a vector that is no place."""
        return self.point(vector, seen=False)

    def size(self, node: Node) -> int:
        """The number of a mass or a length."""
        return self.sizes.setdefault(node, len(self.sizes))

    def group(self, name: str) -> int:
        """The number of what has one colour: a particle, or all members of a family."""
        return self.groups.setdefault(name.partition("[")[0], len(self.groups))

    def dot(
        self,
        name: str,
        place: Place,
        mass: Node | None = None,
        *,
        trail: bool = False,
        group: str = "",
        label: str = "",
    ) -> None:
        """Add a particle, or a point, with the colour of its ``group`` or of its name."""
        number = self.point(place)
        size = None if mass is None else self.size(mass)
        self.dots.append(Dot(name, number, size, self.group(group or name), label=label))
        if trail:
            self.trails.append(number)

    def rod(self, start: Place, end: Place, colour: str = "") -> None:
        """Add a rod, and a pivot where it is held."""
        self.rods.append(Line((self.held(start), self.held(end)), colour))

    def spring(self, start: Place, end: Place, colour: str = "") -> None:
        """Add a spring, and a pivot where it is held."""
        self.springs.append(Line((self.held(start), self.held(end)), colour))

    def line(self, start: Place, end: Place, colour: str = "") -> None:
        """Add a thin line."""
        self.rods.append(Line((self.point(start), self.point(end)), colour, thin=True))

    def held(self, place: Place) -> int:
        """The number of a place, which is a pivot if no coordinate moves it."""
        number = self.point(place)
        if not union(place) & self.scene.moving:
            self.pivots.setdefault(number, Pivot(number))
        return number

    def locus(
        self,
        name: str,
        place: Place,
        along: Iterable[int],
        ranges: Iterable[tuple[float, float] | None],
        colour: str = "",
    ) -> None:
        """Add a curve or a surface."""
        along = tuple(along)
        others = tuple(k for k in self.scene.depends(place) if k not in along)
        moves = bool(union(place) & self.scene.time)
        number = self.point(place, seen=False)
        self.curves.append(Locus(number, along, tuple(ranges), others, moves, name, colour))

    def drawing(self) -> Drawing:
        """The finished drawing."""
        return Drawing(
            dimension=self.dimension,
            up="y" if self.dimension == 2 else "z",
            coordinates=tuple(one.name for one in self.scene.spec.coordinates),
            points=tuple(self.points),
            sizes=tuple(self.sizes),
            places=tuple(self.places),
            dots=tuple(self.dots),
            rods=tuple(self.rods),
            springs=tuple(self.springs),
            pivots=tuple(self.pivots.values()),
            curves=tuple(self.curves),
            solids=tuple(self.solids),
            trails=tuple(self.trails),
            abstract=self.abstract,
            scaled=self.scaled,
        )
