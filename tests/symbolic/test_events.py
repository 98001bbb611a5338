"""Events as ``equations`` prints them."""

from __future__ import annotations

from unicodedata import normalize

import pytest
import sympy

from lagrange_cli.run.equations import FORMS
from lagrange_cli.symbolic.data import as_data
from lagrange_cli.symbolic.latex import as_latex
from lagrange_cli.symbolic.layouts import as_text, as_unicode
from lagrange_cli.symbolic.source import as_python
from tests.support.systems import derived

BALLS = """
    parameters: {g: 9.81, e: 0.9, k: 1}
    sizes: {N: 2}
    coordinates: {y: {initial: 1}, "x[i in range(N)]": {initial: i + 1}}
    masses: {ball: 1, "bead[i in range(N)]": 1}
    positions: {ball: y, "bead[i in range(N)]": "x[i]"}
    potential: g*y
    events:
      the_floor: {when: ball.x, direction: falling, action: {set: {y_dot: -e*y_dot, k: 2*k}}}
      wall[i in range(N)]: {when: "x[i]", action: {set: {"x_dot[i]": "-x_dot[i]"}}}
      top: y_dot
      end: {when: y - t, direction: rising, action: stop}
    """


@pytest.fixture(scope="module")
def equations():
    return derived(BALLS)


def listed(page: str) -> list[str]:
    """The lines of the last section but its title."""
    lines = normalize("NFC", page.partition("Events")[2]).splitlines()
    return [line.strip() for line in lines if line.strip()]


def test_as_text(equations):
    assert listed(as_text(equations, "lagrange")) == [
        "y = 0", "the_floor, falling: y_dot -> -e*y_dot, k -> 2*k",
        "x[0] = 0", "wall[0], in either direction: x_dot[0] -> -x_dot[0]",
        "x[1] = 0", "wall[1], in either direction: x_dot[1] -> -x_dot[1]",
        "y_dot = 0", "top, in either direction: recorded",
        "y - t = 0", "end, rising: the motion ends",
    ]  # fmt: skip


def test_as_unicode(equations):
    assert listed(as_unicode(equations, "lagrange"))[1:4] == [
        "the_floor, falling: ẏ → −e ẏ, k → 2 k",
        "x₀ = 0",
        "wall[0], in either direction: ẋ₀ → −ẋ₀",
    ]


def test_as_latex(equations):
    page = as_latex(equations, "lagrange").partition(r"\paragraph{Events}")[2]
    assert r"\item $y = 0$: the\_floor, falling: $\dot{y} \to -e \dot{y}$, $k \to 2 k$" in page
    assert r"\item $\dot{y} = 0$: top, in either direction: recorded" in page


@pytest.mark.parametrize("form", [form for form in FORMS if form not in ("reactions", "vakonomic")])
def test_every_form_has_them(equations, form):
    assert len(listed(as_text(equations, form))) == 10


def test_a_system_without_events_has_no_such_section():
    assert "Events" not in as_text(derived("coordinates: [x]\nlagrangian: x_dot**2/2"), "lagrange")


def test_as_data(equations):
    floor, wall, *_, end = as_data(equations, "lagrange", {})["events"]
    assert floor == {
        "name": "the_floor",
        "when": "y",
        "direction": "falling",
        "action": "set",
        "set": {"y_dot": "-e*y_dot", "k": "2*k"},
    }
    assert wall["name"] == "wall[0]" and wall["set"] == {"x_dot[0]": "-x_dot_0"}
    assert (end["direction"], end["action"], end["set"]) == ("rising", "stop", {})
    assert sympy.sympify(end["when"]) == sympy.sympify("y - t")


def test_as_python(equations):
    module: dict = {}
    exec(as_python(equations, "lagrange", {"g": 9.81, "e": 0.5, "k": 3.0}), module)
    assert module["EVENTS"] == ("the_floor", "wall[0]", "wall[1]", "top", "end")
    assert module["DIRECTIONS"] == (-1, 0, 0, 0, 1)
    t, q, v = 5.0, (1.0, 2.0, 3.0), (-4.0, 6.0, 7.0)
    assert module["events"](t, q, v) == (1.0, 2.0, 3.0, -4.0, -4.0)
    assert module["after_the_floor"](t, q, v) == (q, (2.0, 6.0, 7.0), {"g": 9.81, "e": 0.5, "k": 6.0})
    assert module["after_wall_1"](t, q, v) == (q, (-4.0, 6.0, -7.0), module["PARAMETERS"])


def test_conservation_laws_say_which_events_break_them(equations):
    found = {each.quantity: each for each in equations.conserved}
    assert {name: each.breaks for name, each in found.items()} == {
        "p_x[0]": ("wall[0]",),
        "p_x[1]": ("wall[1]",),
        "h": ("the_floor",),
    }
    assert found["h"].because.endswith("only between events, as 'the_floor' may change it")
    data = as_data(equations, "lagrange", {})["conserved"]
    assert data[-1]["broken_by"] == ["the_floor"]


def test_long_actions_are_broken_between_what_they_set():
    """An elliptic billiard. Before, they made a line of 233 characters."""
    text = """
    parameters: {a: 2, b: 1}
    coordinates: {x: {initial: 0.2, velocity: 0.5}, y: {initial: 0, velocity: 0.9}}
    lagrangian: (x_dot**2 + y_dot**2)/2
    definitions: {u: x/a**2, v: y/b**2, s: 2*(x_dot*u + y_dot*v)/(u**2 + v**2)}
    events:
      wall: {when: x*u + y*v - 1, direction: rising, action: {set: {x_dot: x_dot - s*u, y_dot: y_dot - s*v}}}
    """
    for page, arrow in ((as_text, "->"), (as_unicode, "→")):
        lines = page(derived(text), "hamilton").splitlines()
        assert max(map(len, lines)) <= 104
        (second,) = (line for line in lines if arrow in line and "rising" not in line)
        assert second.startswith(f"      {normalize('NFD', 'ẏ') if arrow == '→' else 'y_dot'} {arrow} ")
