"""From a system file to what is drawn of it."""

from __future__ import annotations

from lagrange_cli.drawing.abstract import sketch
from lagrange_cli.drawing.bodies import shape_of
from lagrange_cli.drawing.curves import floors_of, tracks_of
from lagrange_cli.drawing.distances import End
from lagrange_cli.drawing.drawing import TRAILS, Drawing, Solid
from lagrange_cli.drawing.line import spread
from lagrange_cli.drawing.rods import Rod, rods_of
from lagrange_cli.drawing.scene import Place, Scene
from lagrange_cli.drawing.section import Section
from lagrange_cli.drawing.sheet import Sheet
from lagrange_cli.drawing.springs import Spring, springs_of
from lagrange_cli.expression.node import union
from lagrange_cli.spec.spec import Spec
from lagrange_cli.spec.values import Values

MANY = 60
"""Particles from which on those of families are drawn all at once, without the curves that they are on, and
bodies as their centres of mass."""


def draw(spec: Spec, values: Values, start: float = 0.0) -> Drawing:
    """The drawing of a system; ``values`` are those of a run that begins at the time ``start``.

    They show which lengths are fixed. The drawing holds for other values of the parameters, too.

    Raises:
        SpecError: where the file has a constant that does not exist, such as 1/0, and for all numbers of its
            section ``draw`` that make no sense.
        TooLarge: where the expressions are too many.
    """
    found = at_once(spec, values, start)
    if found is not None:
        return found
    scene = Scene(spec, values, start)
    section = Section(scene)
    if spec.embedding or section.has_places:
        return section.completed(_sheet(scene, section))
    return section.completed(sketch(scene))


def at_once(spec: Spec, values: Values, start: float = 0.0) -> Drawing | None:
    """The drawing of many particles of families, without going through them one by one; None where they are
    few, or of another kind, or the file says what is drawn."""
    if spec.draw is not None or len(spec.embedding) < MANY:
        return None
    from lagrange_cli.drawing.families.draw import family_drawing

    return family_drawing(spec, values, start)


def _sheet(scene: Scene, section: Section) -> Sheet:
    """The parts found in the file, overridden by its section ``draw``."""
    wanted = section.wanted
    rods, springs = rods_of(scene), springs_of(scene)
    tracks = tracks_of(scene, {rod.end for rod in rods if not rod.bar})
    springs = spread(scene, springs)
    sheet = Sheet(scene, scene.dimension)
    if wanted.curves is None:
        for track in tracks:
            sheet.locus(track.name, track.place, track.along, track.ranges)
        for low, high in floors_of(scene):
            sheet.line(low, high)
    else:
        section.curves(sheet, wanted.curves)
    if wanted.rods is None:
        for rod in rods:
            sheet.rod(*_ends(scene, rod), section.colour("rods"))
    else:
        section.rods(sheet, wanted.rods)
    if wanted.springs is None:
        for spring in springs:
            sheet.spring(*_ends(scene, spring), section.colour("springs"))
    else:
        section.springs(sheet, wanted.springs)
    trailing = _trailing(scene, {track.name for track in tracks}) if wanted.trails is None else []
    for name, place in scene.positions.items():
        if name in wanted.hidden:
            continue
        if name in scene.spec.bodies:
            _solid(sheet, name, place)
        else:
            sheet.dot(name, place, scene.scope.scalar(scene.spec.masses[name]), trail=name in trailing)
    section.points(sheet)
    return sheet


def _trailing(scene: Scene, tracked: set[str]) -> list[str]:
    """The particles that leave a trail; one on a curve that is drawn does not."""
    free = [name for name, place in scene.positions.items() if union(place) & scene.moving]
    found = [name for name in free if name not in tracked and name not in scene.flat]
    return found if len(found) <= TRAILS else found[-1:]


def _ends(scene: Scene, line: Rod | Spring) -> tuple[Place, Place]:
    def place(end: End) -> Place:
        return scene.positions[end] if isinstance(end, str) else end

    return place(line.start), place(line.end)


def _solid(sheet: Sheet, name: str, place: Place) -> None:
    """Add a rigid body."""
    shape = shape_of(sheet.scene, name, sheet.scene.spec.bodies[name])
    one, two, three = (sheet.direction(axis) for axis in shape.axes)
    sizes = tuple(map(sheet.size, shape.sizes))
    sheet.solids.append(
        Solid(name, shape.shape, sizes, sheet.point(place), (one, two, three), sheet.group(name))
    )
