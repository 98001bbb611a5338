"""Positions that contain other particles and bodies: a system is the same, node by node, as without them."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lagrange_cli.model.quantity import UNKNOWN
from lagrange_cli.model.survey import Survey
from lagrange_cli.model.unit_text import read_unit
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.surface import with_surface
from tests.model.test_definitions_of_particles import compare
from tests.support.draws import examples
from tests.support.files import problems

SECOND = read_unit("s")
HEAD = """
parameters:
  l: {value: 0.5, unit: m}
  m: {value: 1, unit: kg}
  I: {value: 0.1, unit: kg m^2}
  w: {value: 2, unit: 1/s}
coordinates: {x: {initial: 0, unit: m}, a: {initial: 1}, b: {initial: 0.5}, s: {initial: 0.1, unit: m}}
"""
PLACES = (
    HEAD
    + """
definitions: {half: (tip + cart)/2, along: "[sin(a), -cos(a), 0]"}
masses: {tip: m, cart: m, mid: m, end: m}
positions:
  end: bar.at(l, 0, s)
  mid: [half.x, 0.5*half.y, s]
  tip: cart + l*along
  cart: [x + s*sin(w*t), 0*s, 0*s]
bodies:
  bar: {mass: m, inertia: [I, 2*I, 2*I], position: "mid + (s, l, 0*s)", orientation: {euler: [b, tip.x/l, 0]}}
potential: m*w**2*(3*tip.y**2 + end.z*bar.x)
observables: {far: norm(end - tip), fast: "dot(half, (tip.vx, end.vy, mid.vz))"}
"""
)
IN_COORDINATES = (
    HEAD
    + """
definitions:
  far: [x + s*sin(w*t), 0*s, 0*s]
  reach: far + l*[sin(a), -cos(a), 0]
  half: (reach + far)/2
  middle: [half.x, 0.5*half.y, s]
masses: {tip: m, cart: m, mid: m, end: m}
positions: {end: "bar.at(l, 0, s)", mid: middle, tip: reach, cart: far}
bodies:
  bar:
    mass: m
    inertia: [I, 2*I, 2*I]
    position: middle + (s, l, 0*s)
    orientation: {euler: [b, reach.x/l, 0]}
potential: m*w**2*(3*tip.y**2 + end.z*bar.x)
observables: {far: norm(end - tip), fast: "dot(half, (tip.vx, end.vy, mid.vz))"}
"""
)


def test_a_system_is_the_same_in_coordinates() -> None:
    compare(PLACES, IN_COORDINATES)


def test_units_are_the_same() -> None:
    one, other = (Survey(read_spec(text, "file"), SECOND) for text in (PLACES, IN_COORDINATES))
    assert one.conflicts == other.conflicts
    assert one.positions == other.positions and UNKNOWN not in one.positions.values()
    assert one.observables == other.observables


@given(data=st.data())
@examples(25)
def test_places_that_follow_from_any_others(data: st.DataObject) -> None:
    """Particles in any order of the file, each made of some of those before it in another order."""
    count = data.draw(st.integers(2, 6))
    order, places = data.draw(st.permutations(range(count))), [""] * count
    for number, one in enumerate(order):
        used = data.draw(st.lists(st.sampled_from(order[:number]), max_size=3)) if number else []
        kinds = st.sampled_from(["@{0}", "(@{0}.y, 2*@{0}.x)", "2*@{0}/3"])
        own = data.draw(st.sampled_from(["(x, s)", "(l*sin(a), -l*cos(b))", "(s*t, x)"]))
        places[one] = " + ".join([own, *(data.draw(kinds).format(k) for k in used)])
    masses = ", ".join(f"p{k}: {k + 1}*m" for k in range(count))
    rest = f"{HEAD}masses: {{{masses}}}\npotential: p0.x*p{count - 1}.y\n"

    def listed(section: str, name: str, values: list[str]) -> str:
        return f"{section}:\n" + "".join(f'  {name}{k}: "{one}"\n' for k, one in enumerate(values))

    defined = listed("definitions", "r", [one.replace("@", "r") for one in places])
    named = listed("positions", "p", [f"r{k}" for k in range(count)])
    compare(
        rest + listed("positions", "p", [one.replace("@", "p") for one in places]), rest + defined + named
    )


def test_definitions_have_velocities() -> None:
    """Those of the particles that are there."""
    use = """
observables: {v: "reach.vx*middle.vy", w: 2*middle.vx}
forces: {tip: ["-m*w*reach.vx", "-m*w*reach.vy", "-m*w*middle.vz"]}
potential: m*w*middle.vx*mid.x
"""
    one = IN_COORDINATES.partition("potential")[0] + use
    compare(one, one.replace("reach.v", "tip.v").replace("middle.v", "mid.v"))
    survey = Survey(read_spec(one, "file"), SECOND)
    assert survey.conflicts == []
    assert survey.observables["w"].unit == read_unit("m/s")


def test_a_surface_may_use_places_that_follow_from_others() -> None:
    spec = with_surface(read_spec(PLACES, "file"), "half.x - end.y + tip.vx")
    assert spec.events


REVERSED = """
sizes: {N: 5}
parameters: {l: {value: 0.5, unit: m}, m: {value: 1, unit: kg}}
coordinates: {"a[i in range(N)]": {initial: 0.1}}
masses: {"p[i in range(N)]": m}
{section}
potential: "0"
"""
FAMILIES = {
    "positions": """positions:
  "p[i in range(N - 1)]": p[i + 1] + l*(sin(a[i]), -cos(a[i]))
  "p[N - 1]": l*(sin(a[N - 1]), -cos(a[N - 1]))""",
    "definitions": """definitions:
  "r[i in range(N - 1)]": r[i + 1] + l*(sin(a[i]), -cos(a[i]))
  "r[N - 1]": l*(sin(a[N - 1]), -cos(a[N - 1]))
positions: {"p[i in range(N)]": "r[i]"}""",
    "one statement": """definitions:
  "r[i in range(N)]": where(i > 0, r[i - 1], (0, 0)) + l*(sin(a[i]), -cos(a[i]))
positions: {"p[i in range(N)]": "r[i]"}""",
    "parameters": """positions: {"p[i in range(N)]": "k[i]*(sin(a[i]), 1)"}""",
}


@pytest.mark.parametrize("kind", FAMILIES)
def test_units_of_members_that_follow_from_later_ones(kind: str) -> None:
    text = REVERSED.replace("{section}", FAMILIES[kind])
    lengths = '{l: {value: 0.5, unit: m}, "k[i in range(N - 1)]": "2*k[i + 1]", "k[N - 1]": "3*l", '
    text = text.replace("{l: {value: 0.5, unit: m}, ", lengths) if kind == "parameters" else text
    survey = Survey(read_spec(text, "file"), SECOND)
    assert survey.conflicts == []
    assert survey.positions["p"].unit == read_unit("m")


@pytest.mark.parametrize(
    ("position", "message", "hint"),
    [
        ("(tip.vx, 0)", "the velocity of 'tip' cannot be used in position of 'end'", "r(q, t)"),
        ("(bar.wx, 0)", "the angular velocity of 'bar' cannot be used in position of 'end'", "r(q, t)"),
        ("(bar.at(l, 0, 0).vx, 0)", "the velocity of 'bar' cannot be used", "r(q, t)"),
        ("(speed, 0)\ndefinitions: {speed: tip.vy}", "'speed', which depends on a velocity,", "r(q, t)"),
        ("end + (l, 0)", "position of 'end' depends on itself: end -> end", "that do not depend on it"),
        ("tip + (l, 0)\n  tip: end", "position of 'end' depends on itself: end -> tip -> end", "one of them"),
        ("(bar.x, u)\ndefinitions: {u: bar.R11}", "", ""),
        ("(tip.x, tip.z)", "'tip' has no component 'z'", "tip.x"),
    ],
)
def test_mistakes_are_said_at_their_place(position: str, message: str, hint: str) -> None:
    others = "" if "\n  tip:" in position else "  tip: (x, s)\n"
    where, _, more = position.partition("\n")
    body = "{mass: m, inertia: [I, I, I], position: [x, s, s], orientation: {euler: [a, 0, 0]}}"
    text = f'{HEAD}masses: {{end: m, tip: m}}\npositions:\n{others}  end: "{where}"\n{more}\n'
    found = problems(f"{text}bodies:\n  bar: {body}\npotential: 0*x\n")
    assert [message in one.message and hint in one.hint for one in found] == ([True] if message else [])
