"""Drawings of systems without positions: those given by a Lagrangian.

Coordinates x, y (and z) are taken for a place, with an angle beside them for the direction that it looks in.
A family is drawn as a string, or as a net, of what its members are. Any other angle is the hand of a dial,
and any other coordinate a point on an axis of its own; their names are written beside them. All but places
are drawn in units of their values at the start.
"""

from __future__ import annotations

from itertools import product

from lagrange_cli.drawing.scene import Place, Scene
from lagrange_cli.drawing.sheet import Sheet
from lagrange_cli.expression.confusions import romanized
from lagrange_cli.expression.node import Kind, Node, reachable, union
from lagrange_cli.expression.vocabulary import member_name
from lagrange_cli.spec.spec import Coordinate, Family

ANGLES = frozenset(
    ("theta", "phi", "psi", "alpha", "beta", "gamma", "delta", "chi", "varphi", "omega", "epsilon", "angle")
)
"""Names of angles, where the file gives no unit."""
LENGTHS = frozenset("xyzuXYZ")
"""Names that are no angles, even where their sine is taken, as in a potential that repeats itself."""
PLACES = (("x", "y", "z"), ("x", "y"), ("X", "Y", "Z"), ("X", "Y"))
LINES = 24
"""Lines of a net in each direction, at most."""
WIDE = 8.0
"""The width of a string, in units of its elongation."""
BESIDE = 2.6
"""The distance of dials."""


def sketch(scene: Scene) -> Sheet:
    """A sheet with all coordinates."""
    families = scene.spec.coordinate_families
    named = {one.name: q for one, q in zip(scene.spec.coordinates, scene.coordinates)}
    loose = [one for one in scene.spec.coordinates if one.name.partition("[")[0] not in families]
    net = next((one for one in families.values() if len(one.shape) == 2), None)
    names = next((names for names in PLACES if all(name in named for name in names)), ())
    sheet = Sheet(scene, 3 if len(names) == 3 or (net and not names) else 2)
    sheet.abstract = True
    sheet.scaled = bool(names)
    if names:
        _place(sheet, names, [one for one in loose if one.name not in names], named)
    elif net is not None:
        _net(sheet, net, named)
    else:
        right = 0.0
        for family in families.values():
            _string(sheet, family, named, right)
            right += WIDE + BESIDE
        _gauges(sheet, loose, named, right)
    return sheet


def is_angle(scene: Scene, coordinate: Coordinate) -> bool:
    """Whether a coordinate is an angle, by its unit or, without one, by its name, or because its sine or
    cosine is taken."""
    if coordinate.unit:
        return coordinate.unit in ("rad", "deg")
    name = romanized(coordinate.name.partition("[")[0].rstrip("0123456789_"))
    if name in ANGLES or name in LENGTHS:
        return name in ANGLES
    return bool(turning(scene) & scene.coordinates[scene.number[coordinate.name]].symbols)


def turning(scene: Scene) -> int:
    """The coordinates of whose sums L contains a sine or a cosine."""
    lagrangian, found = scene.spec.lagrangian, 0
    for one in () if lagrangian is None else reachable([scene.scope.scalar(lagrangian)]):
        if one.kind is Kind.FUNCTION and one.data in ("sin", "cos"):
            (argument,) = one.arguments
            terms = argument.arguments if argument.kind is Kind.SUM else (argument,)
            found |= union(term for term in terms if term in scene.coordinates)
    return found


def _place(sheet: Sheet, names: tuple[str, ...], others: list[Coordinate], named: dict[str, Node]) -> None:
    """A point where the coordinates are, and where it looks."""
    place = tuple(named[name] for name in names)
    sheet.dot(", ".join(names), place, trail=True)
    angles = [one for one in others if is_angle(sheet.scene, one)]
    if len(angles) == 1 and len(names) == 2:
        angle, length = named[angles[0].name], 0.3 * sheet.scene.swing(names)
        ahead = (
            place[0] + length * sheet.scene.graph.function("cos", [angle]),
            place[1] + length * sheet.scene.graph.function("sin", [angle]),
        )
        sheet.rod(place, ahead)


def _net(sheet: Sheet, family: Family, named: dict[str, Node]) -> None:
    """Elongations over a plane of two indices."""
    graph, size = sheet.scene.graph, sheet.scene.swing(family.members)
    rows, columns = (range(0, n, -(-n // LINES)) for n in family.shape)
    far = WIDE / max(len(rows), len(columns))

    def place(i: int, j: int) -> Place:
        height = named[member_name(family.name, (rows[i], columns[j]))] * (1 / size)
        return (graph.constant(far * i), graph.constant(far * j), height)

    for i, j in product(range(len(rows)), range(len(columns))):
        sheet.dot(member_name(family.name, (rows[i], columns[j])), place(i, j))
        if i:
            sheet.rod(place(i - 1, j), place(i, j))
        if j:
            sheet.rod(place(i, j - 1), place(i, j))


def _string(sheet: Sheet, family: Family, named: dict[str, Node], right: float) -> None:
    """Elongations over one index, or over all members in their order."""
    graph, size = sheet.scene.graph, sheet.scene.swing(family.members)
    before: Place | None = None
    for k, name in enumerate(family.members):
        place = (graph.constant(right + WIDE * k / max(1, len(family.members) - 1)), named[name] * (1 / size))
        sheet.dot(name, place)
        if before is not None:
            sheet.rod(before, place)
        before = place


def _gauges(sheet: Sheet, loose: list[Coordinate], named: dict[str, Node], right: float) -> None:
    """Dials of angles and points on axes; two other coordinates span a plane."""
    graph = sheet.scene.graph
    if len(loose) == 2 and not right and not any(is_angle(sheet.scene, one) for one in loose):
        both = f"{loose[0].name}, {loose[1].name}"
        sheet.dot(both, (named[loose[0].name], named[loose[1].name]), trail=True, label=both)
        sheet.scaled = True
        return
    for one in loose:
        q, middle = named[one.name], graph.constant(right)
        if is_angle(sheet.scene, one):
            tip = (middle + graph.function("sin", [q]), -graph.function("cos", [q]))
            sheet.rod((middle, graph.zero), tip)
            number = sheet.scene.number[one.name]
            sheet.locus("", tip, [number], [(0.0, 6.283185307179586)])
        else:
            value = q * (1 / sheet.scene.swing((one.name,)))
            tip = (value, graph.zero) if len(loose) == 1 and not right else (middle, value)
            sheet.locus("", tip, [sheet.scene.number[one.name]], [None])
        sheet.dot(one.name, tip, label=one.name)
        right += BESIDE
