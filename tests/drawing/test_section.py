"""The section ``draw``: what it says takes the place of what is found, and its mistakes are shown."""

import numpy as np
import pytest

from lagrange_cli.cli.main import main
from lagrange_cli.drawing.drawing import Drawing
from lagrange_cli.drawing.evaluate import extent, fitted, locus, points
from lagrange_cli.errors import SpecError
from lagrange_cli.run.request import Request
from lagrange_cli.run.view.motion import read_shown
from lagrange_cli.run.view.page import UNDRAWN, view
from lagrange_cli.spec.draw.colours import NAMES, is_colour
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_values
from tests.drawing.test_draw import drawn, ends
from tests.support.files import underlined

CHAIN = """\
sizes: {N: 4}
parameters: {l: 0.5, g: 9.81, k: 40, m: [1, 2]}
coordinates:
  theta[i in range(N)]: {initial: 0.3}
  x: {initial: 0.2}
definitions: {P: [l, 1], w: g/l, nail: [x, 2]}
masses: {cart: m[0], bead[i in range(N)]: 0.1}
positions:
  cart: [x, 0]
  bead[i in range(N)]:
    - x + sum(l*sin(theta[j]) for j in range(i + 1))
    - -sum(l*cos(theta[j]) for j in range(i + 1))
potential: k*x**2/2 + sum(0.1*g*bead[i].y for i in range(N))
draw:
"""


def of(section: str, system: str = CHAIN) -> Drawing:
    return drawn(f"{system}  {section}\n")


def seen(drawing: Drawing, q: list[float], **parameters: float) -> Drawing:
    """The drawing with bounds and ranges, of a motion that stays at q."""
    state = np.array([q, q])
    return fitted(drawing, extent(drawing, np.zeros(2), state, parameters), parameters)


def test_what_is_not_given_stays_as_it_is_found():
    found, empty, coloured = drawn(CHAIN), of(""), of("colours: {bead: red}")
    assert found.data() == empty.data()
    assert found.rods == coloured.rods and found.curves == coloured.curves and found.trails == coloured.trails


@pytest.mark.exhaustive(keep=7)
@pytest.mark.parametrize(
    "rods, expected",
    [
        ("none", set()),
        ("[[0, cart]]", {("cart", "|")}),
        ("[[P, 'bead[1]', cart]]", {("bead[1]", "|"), ("bead[1]", "cart")}),
        ("[[nail, cart], [(0, l), [x, 0]]]", {("|", "cart"), ("cart", "|")}),
        (
            "['(bead[i], bead[i + 1]) for i in range(N - 1) if i != 1', '0, cart']",
            {("bead[0]", "bead[1]"), ("bead[2]", "bead[3]"), ("cart", "|")},
        ),
        ("'[bead[i], bead[j]] for i in range(3) for j in range(i) if j'", {("bead[1]", "bead[2]")}),
        ("[[cart, 'bead[i] for i in range(1, 3)']]", {("bead[1]", "cart"), ("bead[2]", "cart")}),
    ],
)
@pytest.mark.parametrize("kind", ["rods", "springs"])
def test_lines_are_those_that_are_given(kind, rods, expected):
    drawing = of(f"{kind}: {rods}")
    pivots = {one.point for one in drawing.pivots}
    names = {
        frozenset(one.replace("|", "?") for one in pair) for pair in ends(drawing, getattr(drawing, kind))
    }
    assert names == {frozenset(one.replace("|", "?") for one in pair) for pair in expected}
    assert any("|" in pair for pair in expected) <= bool(pivots)


def test_points_trails_and_what_is_hidden():
    drawing = of(
        "points: [P, nail, '(i, 1) for i in range(2)']\n  trails: [bead, P]\n  hide: [cart, 'bead[0]']"
    )
    names = [one.name for one in drawing.dots]
    assert names == ["bead[1]", "bead[2]", "bead[3]", "P", "nail", "(0, 1)", "(1, 1)"]
    assert len(drawing.trails) == 5
    assert not of("trails: none").trails and len(of("trails: all").trails) == 5
    assert not of("hide: all").dots


def test_colours_of_members_come_after_those_of_their_family():
    drawing = of(
        "colors: {'bead[2]': '#0f0', bead: red, rods: navy, edge: tan}\n  curves: {edge: [[0, 0], P]}"
    )
    assert [one.colour for one in drawing.dots] == ["", "red", "red", "#0f0", "red"]
    assert [one.colour for one in drawing.rods if not one.thin] == ["navy"] * 4
    assert [one.colour for one in drawing.rods if one.thin] == ["tan"]


def test_curves_run_along_parameters_and_coordinates():
    drawing = of(
        "curves: {rail: {at: [x + u, l*u], u: [-l, 2]}, arc: {at: 'bead[0]', 'theta[0]': [0, pi]}, "
        "path: {at: cart, x: }, all: nail, string: {through: [0, bead]}, edge: [P, nail, 'bead[0]']}"
    )
    q = [0.0, 0.0, 0.0, 0.0, 3.0]
    values = {"l": 0.5, "g": 9.81, "k": 40.0, "m[0]": 1.0, "m[1]": 2.0}
    drawing = seen(drawing, q, **values)
    rail, arc, path, everywhere = (locus(drawing, one, 0.0, q, values) for one in drawing.curves)
    assert rail[:, [0, -1]] == pytest.approx(np.array([[2.5, 5.0], [-0.25, 1.0]]))
    assert locus(drawing, drawing.curves[0], 0.0, q, {**values, "l": 1.0})[0, 0] == pytest.approx(2.0)
    assert drawing.curves[0].depends == (4,) and not drawing.curves[0].on_time
    assert arc[:, [0, -1]] == pytest.approx(np.array([[3.0, 3.0], [-0.5, 0.5]]), abs=1e-12)
    assert path[0, 0] < 3.0 < path[0, -1] and everywhere[1] == pytest.approx(2.0)
    assert sum(one.thin for one in drawing.rods) == 6
    plain = of("curves: {rail: nail}")
    assert drawing.free and not plain.free


def test_a_surface_in_space_and_the_camera():
    drawing = of(
        "curves: {bowl: {at: [r*cos(u), r*sin(u), r**2], r: [0, 1], u: [0, 2*pi]}}\n"
        "  camera: {azimuth: 10*k, elevation: 5, bounds: {z: [-2, l]}, up: y}"
    )
    assert drawing.dimension == 3 and drawing.up == "y"
    q = [0.0] * 5
    values = {"l": 0.5, "g": 9.81, "k": 40.0, "m[0]": 1.0, "m[1]": 2.0}
    drawing = seen(drawing, q, **values)
    x, y, z = locus(drawing, drawing.curves[0], 0.0, q, values)
    assert z == pytest.approx(x * x + y * y)
    assert (drawing.camera.azimuth, drawing.camera.elevation) == (400, 5)
    assert drawing.camera.bounds is not None
    assert (drawing.camera.bounds[0][2], drawing.camera.bounds[1][2]) == (-2, 0.5)
    assert drawing.camera.bounds[1][0] > 1


def test_what_is_followed_is_in_the_middle():
    drawing = of("camera: {follow: cart}")
    q = [0.0, 0.0, 0.0, 0.0, 100.0]
    drawing = seen(drawing, q, l=0.5, g=9.81, k=40.0, **{"m[0]": 1.0, "m[1]": 2.0})
    assert drawing.camera.bounds is not None
    assert drawing.camera.bounds[0][0] < 0 < drawing.camera.bounds[1][0] < 10


def test_a_lagrangian_is_drawn_as_its_file_says():
    system = "parameters: {l: 1}\ncoordinates: {a: {initial: 0.1}}\nlagrangian: a_dot**2/2 + cos(a)\ndraw:\n"
    drawing = of("rods: [[0, (l*sin(a), -l*cos(a))]]", system)
    assert not drawing.abstract and len(drawing.rods) == 1 and len(drawing.pivots) == 1
    places = points(drawing, np.zeros(1), np.array([[0.1]]), {"l": 1.0})
    assert places[drawing.rods[0].ends[1], :, 0] == pytest.approx([np.sin(0.1), -np.cos(0.1)])
    dial = of("colours: {a: red}\n  sliders: {a: [-pi, pi], a_dot: [0, l]}", system)
    assert dial.abstract and dial.dots[0].colour == "red"
    assert dial.sliders == {"a": (-np.pi, np.pi), "a_dot": (0, 1)}


def test_on_a_line_a_number_is_a_place():
    system = "parameters: {k: 1}\ncoordinates: {x: {initial: 1}}\nmasses: {b: 1}\npositions: {b: x}\n"
    drawing = of("springs: [[-k - 2, b]]", f"{system}draw:\n")
    start = points(drawing, np.zeros(1), np.array([[1.0]]), {"k": 1.0})[drawing.springs[0].ends[0]]
    assert start[:, 0] == pytest.approx([-3, 0])


WRONG = [
    ("rods: [[0, bib]]", "bib", "unknown particle 'bib' in rods", "known: cart, bead"),
    ("rods: [[0, bead]]", "bead", "missing index on the family 'bead'", "bead[i]"),
    ("rods: [[0, 'bead[7]']]", "bead[7]", "no member 'bead[7]'", "bead[0] to bead[3]"),
    ("rods: [[0, x]]", "x", "expected a point, found a number", "write 0 for the origin, or (x, y)"),
    ("rods: [[0, (theta_dot[0], 0)]]", "theta_dot[0]", "'theta_dot' cannot be used", "coordinates, t"),
    ("rods: [[0, b=cart]]", "=", "'=' is not allowed", "leave out 'b ='"),
    ("rods: [[0]]", "[", "joins two points", "rods: [[0, bob]]"),
    ("rods: [cart]", "cart", "a line joins two points or more", "[[0, bob]]"),
    ("rods: ['(bead[i], cart) for i in range(M)']", "M", "'M' is neither an index nor a size", ""),
    ("rods: ['(bead[i], bead[i + 1]) for i in range(N)']", "bead[i + 1]", "no member 'bead[4]'", ""),
    ("rods: ['(cart, cart) for i in range(10**3) for j in range(10**3)']", "j", "more than 100", ""),
    ("rods: ['(cart, 0) for i in range(1000)']", "i", "more than 100 repetitions", ""),
    ("rods: ['(bead[k], 0) for k in range(N)']", "k", "the index 'k' has the name of a parameter", ""),
    ("springs: {a: cart}", "{", "must be a list", "springs: [[(0, 0), block]]"),
    ("points: [w]", "w", "expected a point, found a number", "'w' is a definition"),
    ("hide: [cat]", "cat", "unknown particle 'cat'", "did you mean 'cart'?"),
    ("hide: ['bead[9]']", "bead[9]", "no member 'bead[9]'", ""),
    ("curves: {c: {at: [u, v], u: [0, 1]}}", "v", "unknown name 'v'", ""),
    ("curves: {c: {at: [u, 1], u: [0, 1], v: [0, 1]}}", "v", "does not contain 'v'", ""),
    ("curves: {c: {at: [k, 1], k: [0, 1]}}", "k", "the parameter 'k' cannot have a range", "coordinate"),
    ("curves: {c: {at: [t, 1], t: [0, 1]}}", "t", "the time has no range", ""),
    ("curves: {c: {at: [u, 1], u: }}", "u", "'u' has no range", "u: [0, 1]"),
    ("curves: {c: {at: [u, 1]}}", "u", "unknown name 'u'", "or give it a range: {at: ..., u: [-1, 1]}"),
    ("curves: {c: {at: cart, theta: [0, 1]}}", "theta", "a range for several coordinates", "theta[0]"),
    ("colours: {cart: rod}", "rod", "unknown colour of 'cart': 'rod'", "did you mean 'red'?"),
    ("colours: {cart: 'red;}</style>'}", "red;}</style>", "unknown colour", "a colour of CSS"),
    ("colours:\n    cart: #f00", " ", "'cart' has no colour", "in quotes"),
    ("colours: {card: red}", "card", "unknown name 'card' in colours", "'cart'"),
    ("camera: {follow: card}", "card", "unknown particle 'card'", "'cart'"),
    ("camera: {azimuth: 30 deg}", "30 deg", "is in degrees", "write 30"),
    ("colours: {cart: #f00}", "", "YAML syntax error", "put '#f00' in quotes"),
    ("rods: [[cart, bead[i]] for i in range(N)]", "f", "YAML syntax error", "in quotes, or write its list"),
    ("camera: {azimuth: x}", "x", "the coordinate 'x' cannot be used", "numbers and parameters"),
    ("camera: {bounds: {x: 1}}", "1", "must be a list of two numbers", "[0, 1]"),
    ("sliders: {r: [0, 1]}", "r", "unknown name 'r' in sliders", ""),
    ("sliders: {k: [1, 0]}", "1", "the slider 'k' goes from 1 down to 0", "write the smaller value first"),
    ("camera: {bounds: {x: [1, 0]}}", "1", "the range of x in bounds goes from 1 down to 0", "smaller"),
    ("sliders: {k: [0, 1/(k - 40)]}", "1/(k - 40)", "no finite value", ""),
    ("curves: {c: P}", "c", "depends on no coordinate", "u: [0, 1]"),
    ("curves: {c: 'bead[3]'}", "c", "depends on 5 coordinates", ""),
    ("trace: all", "trace", "unknown key 'trace' in draw", "write 'trails'"),
]  # fmt: skip


@pytest.mark.exhaustive(keep=16)
@pytest.mark.parametrize("section, piece, message, hint", WRONG)
def test_a_mistake_is_shown_at_its_place(section, piece, message, hint, monkeypatch):
    monkeypatch.setenv("LAGRANGE_LIMITS", "members=100")
    with pytest.raises(SpecError) as caught:
        of(section)
    (found,) = caught.value.problems
    assert message in found.message and hint in found.hint
    assert underlined(found).startswith(piece[:1]) and (len(piece) < 2 or underlined(found) == piece)


def test_all_mistakes_are_shown_at_once():
    text = f"{CHAIN}  rods: [[0, bib]]\n  colours: {{card: red, cart: rod}}\n  camera: {{tilt: 3}}\n"
    with pytest.raises(SpecError) as caught:
        resolve_values(read_spec(text.replace("0.1*g", "0.1*gg"), "a.yaml"))
    assert len(caught.value.problems) == 5


def test_a_colour_is_a_colour_and_nothing_else():
    assert len(NAMES) == 148 and all(map(is_colour, NAMES))
    assert is_colour("#aBc") and is_colour("#012345")
    for text in ("", "#abcd", "#12345", "red ", "red\n", "Red", "url(x)", "#٣٣٣", "var(--x)", "<b>"):
        assert not is_colour(text)


@pytest.mark.exhaustive(keep=0.4)
def test_check_and_view_show_numbers_that_make_no_sense(tmp_path, capsys):
    file = tmp_path / "chain.yaml"
    file.write_text(f"{CHAIN}  sliders: {{k: [2, 1]}}\n")
    for command in (
        ["check", str(file)],
        ["view", str(file), "--stop", "0.01", "-o", str(tmp_path / "a.html")],
    ):
        assert main(command) == 3
        assert "the slider 'k' goes from 2 down to 1" in capsys.readouterr().err
    assert main(["solve", str(file), "--stop", "0.01", "-o", str(tmp_path / "a.h5"), "--quiet"]) == 0


def test_places_may_be_definitions_of_particles():
    system = CHAIN.replace("nail: [x, 2]", "nail: [x, 2], mid: (cart + bead[0])/2, fast: bead[0].vx")
    named, by_hand = (of(f"springs: [[{one}, nail]]", system) for one in ("mid", "(cart + bead[0])/2"))
    assert named.data() == by_hand.data()
    for speed in ("fast", "'bead[0].vx'"):
        with pytest.raises(SpecError, match=r"velocity.* cannot be used in points") as caught:
            of(f"points: [[{speed}, 0]]", system)
        assert underlined(caught.value.problems[0]) in speed


@pytest.mark.exhaustive(keep=0.3)
def test_a_drawing_that_is_too_large_is_left_out_of_a_page():
    system = "coordinates: {x: {initial: 0}}\nmasses: {a: 1}\npositions: {a: [x, 0]}\nsolve: {stop: 0.01}\n"
    rods = "draw: {rods: ['((i, x), (i + 1, 0)) for i in range(4000)']}\n"
    large, small = (shown(f"{system}{text}") for text in (rods, rods.replace("4000", "4")))
    assert UNDRAWN in large and UNDRAWN not in small


def shown(text: str) -> str:
    return view(read_shown(text.encode(), "a.yaml", Request())).text
