"""What is found in a file: rods, springs, curves, bodies."""

import json
from textwrap import dedent

import numpy as np
import pytest

from lagrange_cli.drawing.draw import draw
from lagrange_cli.drawing.drawing import Drawing, Line
from lagrange_cli.drawing.evaluate import extent, fitted, locus, points, sizes
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_values
from tests.support.command import SYSTEMS


def drawn(text: str, sizes: dict[str, str] | None = None) -> Drawing:
    spec = read_spec(dedent(text).encode(), "system.yaml", sizes)
    return draw(spec, resolve_values(spec))


def shipped(name: str, sizes: dict[str, str] | None = None) -> Drawing:
    return drawn((SYSTEMS / f"{name}.yaml").read_text(encoding="utf-8"), sizes)


def ends(drawing: Drawing, lines: tuple[Line, ...]) -> set[tuple[str, ...]]:
    """Between which particles lines are; a pivot is called ``|``."""
    names = {one.point: one.name for one in drawing.dots} | {one.centre: one.name for one in drawing.solids}
    return {tuple(sorted(names.get(end, "|") for end in one.ends)) for one in lines}


@pytest.mark.parametrize(
    "name, rods, springs, curves",
    [
        ("double_pendulum", {("lower", "upper"), ("upper", "|")}, set(), 0),
        ("spherical_pendulum", {("bob", "|")}, set(), 0),
        ("four_bar", {("A", "|"), ("A", "B"), ("B", "|")}, set(), 0),
        ("car_axis", {("left", "right")}, {("left", "|"), ("right", "|")}, 1),
        ("harmonic_oscillator", set(), {("block", "|")}, 0),
        ("henon_heiles", set(), set(), 0),
        ("central_force", set(), set(), 0),
        ("rotating_hoop", set(), set(), 1),
        ("parabola_bead", set(), set(), 1),
        ("lagrange_top", {("top", "|")}, set(), 0),
    ],
)
def test_rods_springs_and_curves_of_shipped_systems(name, rods, springs, curves):
    drawing = shipped(name)
    assert ends(drawing, drawing.rods) == rods
    assert ends(drawing, drawing.springs) == springs
    assert len(drawing.curves) == curves


@pytest.mark.parametrize("name", ["n_pendulum", "chain"])
def test_a_chain_hangs_bob_on_bob(name):
    drawing = shipped(name, {"N": "7"})
    hung = {tuple(sorted((f"bob[{i}]", f"bob[{i + 1}]"))) for i in range(6)}
    assert ends(drawing, drawing.rods) == hung | {("bob[0]", "|")}


FREE = """
parameters: {a: 1.5, l: 0.7, k: 3.0}
coordinates:
  x1: {initial: 0}
  y1: {initial: 0}
  x2: {initial: 1}
  y2: {initial: 0.3}
masses: {A: 1, B: 2}
positions: {A: [x1, y1], B: [x2, y2]}
"""


@pytest.mark.parametrize(
    "written, found",
    [
        ("k/2*(norm(A - B) - l)**2", {("A", "B")}),
        ("k*(sqrt((x1 - x2)**2 + (y2 - y1)**2) - l)**2/2", {("A", "B")}),
        ("k*dot(A - B, A - B)/2", {("A", "B")}),
        ("k/2*((x1 - x2)**2 + (y1 - y2)**2)", {("A", "B")}),
        ("k/2*(norm(A - (a, 1)) - l)**2", {("A", "|")}),
        ("k/2*(l - norm((a*sin(t), 0) - B))**2", {("B", "|")}),
        ("k*(x2**2 + y2**2)/2 + 9.81*y1", {("B", "|")}),
        ("-k/norm(A - B)", set()),
        ("-k*(norm(A - B) - l)**2/2", set()),
        ("k*(x1 - x2)**2/2", set()),
    ],
)
def test_a_spring_is_found_however_it_is_written(written, found):
    drawing = drawn(f"{FREE}potential: {written}\n")
    assert ends(drawing, drawing.springs) == found


@pytest.mark.parametrize(
    "written, found",
    [
        ("norm(A - B) - a", {("A", "B")}),
        ("(x1 - x2)**2 + (y1 - y2)**2 - a**2", {("A", "B")}),
        ("sqrt((x1 - 1)**2 + (y1 + a)**2) - 2", {("A", "|")}),
        ("x1**2 - 2*x1 + y1**2 - 5", {("A", "|")}),
        ("x1**2 + 2*y1**2 - a", set()),
        ("x1 - x2 - a", set()),
    ],
)
def test_a_rod_is_found_however_its_constraint_is_written(written, found):
    drawing = drawn(f"{FREE}constraints: {{held: {written}}}\n")
    assert ends(drawing, drawing.rods) == found


@pytest.mark.parametrize(
    "place, constraint, found",
    [
        ("[r*sin(phi), -r*cos(phi)]", "r - R", "|"),
        ("[r*sin(phi), -r*cos(phi)]", "r**2 - R**2", "|"),
        ("[z + r*sin(phi), -r*cos(phi)]", "r - R", "cart"),
        ("[r*sin(phi)*cos(z), r*sin(phi)*sin(z), r*cos(phi)]", "r - R", "|"),
        ("[r, phi]", "r - R", None),
        ("[r*sin(phi), -r*cos(phi)]", "phi - R", None),
    ],
)
def test_a_rod_is_found_in_polar_coordinates(place, constraint, found):
    drawing = drawn(
        "parameters: {R: 1.2}\ncoordinates: {r: {initial: R}, phi: {initial: R}, z: {initial: 0.5}}\n"
        f"masses: {{cart: 1, bob: 1}}\npositions: {{cart: [z, 0], bob: {place}}}\n"
        f"constraints: {{held: {constraint}}}\n"
    )
    assert ends(drawing, drawing.rods) == (set() if found is None else {tuple(sorted(("bob", found)))})


@pytest.mark.parametrize(
    ("potential", "found"),
    [
        ("(x1**2 + x2**2 + k*(x1 - x2)**2)/2", {("A", "B"), ("A", "|"), ("B", "|")}),
        ("k*(x2 - x1)**2/2", {("A", "B")}),
        ("k*(x1 + x2)**2/2", set()),
    ],
)
def test_masses_on_springs_are_measured_from_where_they_rest(potential, found):
    drawing = drawn(
        "parameters: {k: 3.0, l: 2}\ncoordinates: {x1: {initial: 0.1}, x2: {initial: 0}}\n"
        f"masses: {{A: 1, B: 1}}\npositions: {{A: x1, B: l + x2}}\npotential: {potential}\n"
    )
    assert ends(drawing, drawing.springs) == found


def test_a_wire_is_found_in_polar_coordinates():
    drawing = drawn(
        "parameters: {R: 1.2}\ncoordinates: {r: {initial: 1.5*R}, phi: {initial: 0}}\n"
        "masses: {bead: 1}\npositions: {bead: [r*cos(phi), r*sin(phi)]}\n"
        "constraints: {wire: r - R*(1 + cos(phi)/2)}\n"
    )
    assert not drawing.rods
    x, y = locus(drawing, drawing.curves[0], 0.0, np.zeros(2), {"R": 1.2})
    r, phi = np.hypot(x, y), np.arctan2(y, x)
    assert np.abs(r - 1.2 * (1 + np.cos(phi) / 2)).max() < 1e-12
    assert np.ptp(phi) > 6


def test_a_pendulum_hangs_on_its_cart():
    drawing = drawn(
        """
        parameters: {l: 1}
        coordinates: {X: {initial: 0}, theta: {initial: 1}}
        masses: {cart: 1, bob: 1}
        positions: {cart: [X, 0], bob: ["X + l*sin(theta)", -l*cos(theta)]}
        """
    )
    assert ends(drawing, drawing.rods) == {("bob", "cart")}
    assert [one.along for one in drawing.curves] == [(0,)]


UNLISTED = {
    "elastic pendulum": (
        "coordinates: {r: {initial: 1.2}, a: {initial: 1}}\nmasses: {bob: 1}\n"
        "positions: {bob: [d + r*sin(a), -r*cos(a)]}\npotential: 9.81*bob.y + k*(r - l)**2/2",
        set(), {("bob", "|")}, 0,
    ),
    "elastic pendulum on a cart": (
        "coordinates: {x: {initial: 0}, r: {initial: 1.2}, a: {initial: 1}}\nmasses: {cart: 1, bob: 1}\n"
        'positions: {cart: [x, 0], bob: ["x + r*sin(a)", -r*cos(a)]}\npotential: k*(r - l)**2/2',
        set(), {("bob", "cart")}, 1,
    ),
    "loop": (
        "coordinates: {a: {initial: 0}}\nmasses: {p: 1}\npositions: {p: [l*sin(a), -l*cos(a)]}\n"
        "description: a particle slides around a loop",
        set(), set(), 1,
    ),
    "ladder": (
        "coordinates: {a: {initial: 0.3}}\nmasses: {top: 1, foot: 1}\n"
        "positions: {top: [0, l*cos(a)], foot: [l*sin(a), 0]}",
        {("foot", "top")}, set(), 2,
    ),
    "cylinder in a bowl": (
        "coordinates: {a: {initial: 0.3}}\nbodies:\n  roll:\n    mass: 1\n    solid: {cylinder: [d, 1]}\n"
        "    position: [(l - d)*sin(a), 0, -(l - d)*cos(a)]\n"
        "    orientation: {matrix: [[cos(a*k), sin(a*k), 0], [0, 0, 1], [sin(a*k), -cos(a*k), 0]]}",
        set(), set(), 1,
    ),
    "ball on a floor": (
        "coordinates: {x: {initial: 0}, y: {initial: 1}}\nmasses: {ball: 1}\npositions: {ball: [x, y]}\n"
        "events: {floor: {when: y - d, action: {set: {y_dot: -y_dot}}}, top: y_dot}",
        set(), set(), 1,
    ),
}  # fmt: skip


def unlisted(name: str) -> Drawing:
    return drawn(f"parameters: {{l: 1, d: 0.2, k: 30}}\n{UNLISTED[name][0]}\n")


@pytest.mark.parametrize("name", UNLISTED)
def test_what_others_write_is_drawn_as_in_a_textbook(name):
    _, rods, springs, curves = UNLISTED[name]
    drawing = unlisted(name)
    assert ends(drawing, drawing.rods) == rods
    assert ends(drawing, drawing.springs) == springs
    assert len(drawing.curves) == curves


def test_the_bowl_is_below_what_rolls_in_it_and_both_are_seen_from_the_front():
    drawing, parameters = unlisted("cylinder in a bowl"), {"l": 1.0, "d": 0.2, "k": 30.0}
    x, y, z = locus(drawing, drawing.curves[0], 0.0, [0.0], parameters)
    assert np.hypot(x, z) == pytest.approx(1.0) and not y.any()
    assert drawing.up == "z" and -90 < drawing.camera.azimuth < -70


def test_what_hangs_along_y_is_drawn_upright():
    body = "coordinates: {x: {initial: 1}, y: {initial: 0}, z: {initial: 0}}\nmasses: {a: 1, b: 2}\n"
    body += "positions: {a: [x, y, z], b: [z, y, x]}\npotential: "
    assert drawn(f"{body}9.81*(a.y + 2*b.y)\n").up == "y"
    for other in ("9.81*(a.z + 2*b.z)", "9.81*(a.y + b.x)", "y**2"):
        assert drawn(f"{body}{other}\n").up == "z"
    turned = drawn(f"{body}-9.81*(a.y + 2*b.y) + norm(a - b)**2\n")
    assert turned.up == "y" and turned.camera.elevation == 200
    plane = "parameters: {k: 3}\ncoordinates: {a: {initial: 0}}\nmasses: {p: 1}\n"
    plane += "positions: {p: [sin(a), cos(a)]}\npotential: "
    assert drawn(f"{plane}-k*cos(a)\n").up == "-y" and drawn(f"{plane}k*cos(a)\n").up == "y"
    assert drawn(f"{plane}-k*cos(a)\ndraw: {{camera: {{up: y}}}}\n").up == "y"


@pytest.mark.parametrize(
    "stretch, wall", [("L - x - l", 3), ("x + l - L", 3), ("x - L - l", 0), ("x + l", 0), ("l - x", 0)]
)
def test_a_spring_on_a_line_is_held_where_its_length_at_rest_leaves_off(stretch, wall):
    text = (
        "coordinates: {x: {initial: 2}}\nmasses: {b: 1}\npositions: {b: [x, 0]}\nparameters: {L: 3, l: 1}\n"
    )
    drawing = drawn(f"{text}potential: 5*({stretch})**2\n")
    places = points(drawing, np.zeros(1), np.array([[2.0]]), {"L": 3.0, "l": 1.0})
    assert places[drawing.springs[0].ends[0], :, 0] == pytest.approx([wall, 0])


def test_bodies_that_have_the_moments_of_their_solids():
    """A box of given moments has the edges that make them; the same of a cylinder."""
    body = """
    coordinates: {{a: {{initial: 0.1}}, b: {{initial: 1}}, c: {{initial: 0}}}}
    bodies:
      stone:
        mass: 2
        {}
        position: [0, 0, 0]
        orientation: {{euler: [a, b, c], sequence: zxz}}
    """
    for given, shape, lengths in (
        ("solid: {box: [1, 2, 3]}", "box", [1, 2, 3]),
        ("inertia: [2*13/12, 2*10/12, 2*5/12]", "box", [1, 2, 3]),
        ("inertia: [[2*13/12, 0, 0], [0, 2*10/12, 0], [0, 0, 2*5/12]]", "box", [3, 2, 1]),
        ("inertia: [2*(1/4 + 9/12), 1, 2*(1/4 + 9/12)]", "cylinder", [1, 3]),
        ("inertia: [0.8, 0.8, 0.8]", "sphere", [1]),
    ):
        drawing = drawn(body.format(given))
        (solid,) = drawing.solids
        assert solid.shape == shape
        assert sizes(drawing, {})[list(solid.sizes)] == pytest.approx(lengths)


def test_places_along_a_motion_and_what_is_seen():
    drawing = shipped("rotating_hoop")
    parameters = {"m": 0.2, "g": 9.81, "a": 0.5, "omega": 2.0}
    t, q = np.linspace(0, 1, 5), np.linspace(0, 1, 5)[:, None]
    dot = points(drawing, t, q, parameters)[drawing.dots[0].point]
    expected = 0.5 * np.array([np.sin(t) * np.cos(2 * t), np.sin(t) * np.sin(2 * t), -np.cos(t)])
    assert dot == pytest.approx(expected)
    whole = extent(drawing, t, q, parameters)
    parts = extent(drawing, t[:2], q[:2], parameters).joined(extent(drawing, t[2:], q[2:], parameters))
    assert whole.least == pytest.approx(parts.least) and whole.q_greatest == parts.q_greatest
    seen = fitted(drawing, whole, parameters)
    hoop = locus(seen, seen.curves[0], 0.5, q[0], parameters)
    assert np.hypot(np.hypot(hoop[0], hoop[1]), hoop[2]) == pytest.approx(0.5)
    assert seen.camera.bounds is not None and seen.camera.bounds[1][2] > 0.5


@pytest.mark.exhaustive(keep=1.5)
@pytest.mark.parametrize("name", sorted(path.stem for path in SYSTEMS.glob("*.yaml")))
def test_every_shipped_system_can_be_drawn(name):
    spec = read_spec((SYSTEMS / f"{name}.yaml").read_bytes(), name)
    values = resolve_values(spec)
    drawing = draw(spec, values)
    json.dumps(drawing.data())
    q = np.array([values.q, values.q])
    assert np.isfinite(points(drawing, np.zeros(2), q, values.parameters)).all()
    seen = fitted(drawing, extent(drawing, np.zeros(2), q, values.parameters), values.parameters)
    for curve in seen.curves:
        assert np.isfinite(locus(seen, curve, 0.0, q[0], values.parameters)).all()
    assert drawing.dots or drawing.solids or drawing.rods or drawing.curves


@pytest.mark.exhaustive(keep=4)
@pytest.mark.parametrize(
    "constraint, dimension, along",
    [
        ("(x/a)**2 + (y/b)**2 - 1", 2, (0,)),
        ("3*x**2 + 5*y**2 - 2*x + 4*y - 7*a", 2, (0,)),
        ("(x/a)**2 + (y/b)**2 + z**2/0.09 - 1", 3, (0, 1)),
        ("1 + x - 2*(x**2 + 2*y**2 + 3*z**2)", 3, (0, 1)),
        ("(x/a)**2 + (z/b)**2 - 1", 3, (0, 1)),
    ],
)
def test_ellipses_and_ellipsoids_of_constraints(constraint, dimension, along):
    """All points of the curve, or of the surface, satisfy the constraint, and they go all around."""
    names = "xyz"[:dimension]
    coordinates = ", ".join(f"{name}: {{initial: 0.1}}" for name in names)
    drawing = drawn(
        f"parameters: {{a: 1.2, b: 0.7}}\ncoordinates: {{{coordinates}}}\nmasses: {{bead: 1}}\n"
        f"positions: {{bead: [{', '.join(names)}]}}\nconstraints: {{on: {constraint}}}\n"
    )
    (curve,) = drawing.curves
    assert curve.along == along and drawing.trails == ()
    parameters = {"a": 1.2, "b": 0.7}
    drawing = fitted(drawing, extent(drawing, np.zeros(1), np.zeros((1, dimension)), parameters), parameters)
    places = locus(drawing, drawing.curves[0], 0.0, np.zeros(dimension), parameters)
    values = {name: places[k] for k, name in enumerate(names)} | parameters
    assert np.abs(eval(constraint, {}, values)).max() < 1e-12
    assert places[0].min() < 0 < places[0].max()


@pytest.mark.parametrize(
    "constraint", ["x*y - 1", "x**2 - y**2 - 1", "x**2 + y**2 + 1", "x**4 + y**2 - 1", "x**2 + k*y**2 - 1"]
)
def test_what_is_no_ellipse_is_not_drawn_as_one(constraint):
    drawing = drawn(
        "parameters: {k: -1}\ncoordinates: {x: {initial: 0.1}, y: {initial: 0.1}}\nmasses: {bead: 1}\n"
        f"positions: {{bead: [x, y]}}\nconstraints: {{on: {constraint}}}\n"
    )
    assert drawing.curves == ()


def test_a_throw_has_no_wall():
    """Of a particle that moves in a plane along two axes no surface is drawn; of one on a slope it is."""
    text = "coordinates: {{x: {{initial: 0}}, z: {{initial: 0}}}}\nmasses: {{p: 1}}\npositions: {{p: {}}}\n"
    for place, curves in (("[x, 0, z]", 0), ("[2, x, z]", 0), ("[x, z, 3]", 0), ("[x, z, x/2]", 1)):
        assert len(drawn(text.format(place)).curves) == curves
