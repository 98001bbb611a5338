"""Definitions of particles and bodies: a system is the same, node by node, as with each put in by hand."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lagrange_cli.expression.arrays import evaluate
from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.node import Node
from lagrange_cli.model.build import build_model
from lagrange_cli.model.model import Model
from lagrange_cli.model.quantity import UNKNOWN
from lagrange_cli.model.survey import Survey
from lagrange_cli.model.unit_text import read_unit
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.surface import with_surface
from tests.support.draws import examples
from tests.support.inlined import inlined

SECOND = read_unit("s")
PARTICLES = """
parameters: {m: {value: 1.0, unit: kg}, k: {value: 3.0, unit: N/m}, l: {value: 0.7, unit: m}, c: 0.1}
coordinates: {theta: {initial: 0.3, unit: rad}, s: {initial: 1.0, unit: m}}
definitions:
  stretch: norm(gap) - l
  rate: dot(gap, rel)/norm(gap)
  rel: ["bob.vx - cart.vx", "bob.vy - cart.vy"]
  gap: ["bob.x - cart.x", "bob.y - cart.y"]
  turned: theta + c*t
masses: {bob: m, cart: m}
positions:
  bob: ["l*sin(turned)", "-l*cos(turned)"]
  cart: ["s", "0*m"]
potential: k*stretch**2/2 + k*gap.y*l
forces: {bob: "-c*rel", cart: ["c*rel.x", "-c*rate"]}
generalized_forces: {s: "-c*rate*rel.y"}
dissipation: c*rate**2/2
observables: {a: stretch, b: "rate + cart.vx", d: "gap.x*rel.y"}
events: {slack: stretch, hit: {when: rate, direction: falling, action: {set: {s_dot: "rel.x + rate"}}}}
"""
BODIES = """
parameters: {m: 1.0, I1: 0.2, I2: 0.3, I3: 0.4, r: 0.5, k: 2.0}
coordinates: {x: {initial: 0.0}, y: {initial: 0.5}, a: {initial: 0.3}, b: {initial: 0.4}, c: {initial: 0.1}}
definitions:
  slip: disc.at(r, 0, low).vx
  touch: disc.at(r, 0, low)
  spin: [disc.wx, disc.wy, disc.wz]
  low: r*sin(tilt)
  tilt: b + 0.1
  turning: disc.w3*disc.R13 + dot(spin, touch)
  wire: norm(touch - disc) + support.multiplier
bodies:
  disc: {mass: m, inertia: [I1, I2, I3], position: [x, y, low], orientation: {euler: [a, tilt, c]}}
potential: k*(touch.x**2 + touch.y)
torques: {disc: "-spin"}
forces: {disc: "-0.1*cross(spin, touch)"}
constraints: {support: touch.z - 0.1}
nonholonomic: {rolls: "disc.vx - r*turning + 0.1*slip"}
observables: {w: wire, s: "spin.z + low"}
"""
FAMILIES = """
sizes: {N: 4}
parameters: {k: 1.5, m: [1, 2, 3, 4], n: [1, 2, 3]}
coordinates: {"x[i in range(N)]": {initial: "i"}, "y[i in range(N)]": {initial: "0.1*i"}}
definitions:
  "d[i in range(1, N)]": norm(p[i] - p[i - 1])
  "u[i in range(N), j in range(i)]": (p[i].vx - p[j].vx)*d[i] + at[i]
  "at[i in range(N)]": x[i] + 0.1*i
  centre: ["sum(m[c]*p[c].x for c in range(N))/10", "sum(m[c]*p[c].y for c in range(N))/10"]
  far: sum(norm(p[i] - centre) for i in range(N))
masses: {"p[i in range(N)]": "m[i]"}
positions: {"p[i in range(N)]": ["at[i]", "y[i]"]}
potential: sum(k*(d[i] - 1)**2/2 for i in range(1, N)) + far
forces: {"p[i in range(N)]": ["-sum(u[i,j] for j in range(i))", "-u[N - 1, 0]"]}
constraints: {"rod[i in range(2, N)]": "d[i] - 1.2 - 0.01*d[n[i - 2]]"}
observables: {"e[i in range(N)]": "centre.x + d[(i + 1)//2 + 1]"}
events: {"near[i in range(1, N)]": "d[i] - 0.3"}
"""


def nodes(model: Model[Node]) -> Iterator[tuple[str, Node]]:
    """All expressions of a model, with what they are."""
    yield "potential", model.potential
    yield "dissipation", model.dissipation
    for one in model.particles:
        for what, values in (("r", one.position), ("v", one.velocity), ("F", one.force), ("m", [one.mass])):
            yield from ((f"{what} of {one.name}", value) for value in values)
    yield from ((f"Q {k}", value) for k, value in enumerate(model.generalized_forces))
    yield from model.observables.items()
    yield from ((one.name, one.expression) for one in model.constraints)
    for event in model.events:
        yield event.name, event.argument
        yield from event.changes.items()


def compare(text: str, by_hand: str) -> None:
    """Two systems are the same: in one graph, equal expressions are one node."""
    algebra = GraphAlgebra()
    found, expected = ([*nodes(build_model(read_spec(one, "file"), algebra))] for one in (text, by_hand))
    assert [name for name, _ in found] == [name for name, _ in expected]
    assert [name for (name, one), (_, other) in zip(found, expected) if one is not other] == []


SYSTEMS = {"particles": PARTICLES, "bodies": BODIES, "families": FAMILIES}


@pytest.mark.parametrize("name", SYSTEMS)
def test_systems_are_the_same_with_definitions_put_in_by_hand(name: str) -> None:
    by_hand = inlined(SYSTEMS[name])
    assert "definitions" not in by_hand
    compare(SYSTEMS[name], by_hand)


def test_units_are_those_of_the_same_written_by_hand() -> None:
    one, other = (Survey(read_spec(text, "file"), SECOND) for text in (PARTICLES, inlined(PARTICLES)))
    assert one.conflicts == other.conflicts == []
    assert one.observables == other.observables
    assert one.values["rate"] == one.observables["b"] != UNKNOWN


HELD = """
parameters: {m: {value: 1, unit: kg}, g: {value: 9.81, unit: m/s^2}, v0: {value: 1, unit: m/s}}
coordinates: {x: {initial: 0, unit: m}, y: {initial: 0, unit: m}}
definitions: {friction: -normal*(block.vx - v0)/v0, normal: ground.multiplier}
masses: {block: m}
positions: {block: [x, y]}
potential: m*g*block.y
constraints: {ground: y}
forces: {block: [friction, "0*m*g"]}
observables: {f: friction, n: normal*block.x}
"""


def test_definitions_have_the_units_of_multipliers() -> None:
    one, other = (Survey(read_spec(text, "file"), SECOND) for text in (HELD, inlined(HELD)))
    assert one.conflicts == other.conflicts == []
    assert one.observables == other.observables
    assert one.values["friction"] == other.observables["f"] != UNKNOWN
    compare(HELD, inlined(HELD))


def test_a_unit_that_contradicts_a_position_is_reported_in_the_definition() -> None:
    wrong = Survey(read_spec(PARTICLES.replace("norm(gap) - l", "norm(gap) - m"), "file"), SECOND)
    assert [one.message for one in wrong.conflicts] == ["m and kg are added in definition 'stretch'"]


def test_a_surface_may_use_definitions_of_particles() -> None:
    algebra = GraphAlgebra()
    texts = ((PARTICLES, "stretch - gap.x"), (inlined(PARTICLES), "norm(bob - cart) - l - (bob.x - cart.x)"))
    surfaces = [with_surface(read_spec(text, "file"), surface) for text, surface in texts]
    one, other = (build_model(spec, algebra).events[-1].argument for spec in surfaces)
    assert one is other


LEAVES = "theta", "s_dot", "t", "m", "bob.x", "cart.vx", "bob.vy", "top.w1", "top.wz", "top.at(s, 1, 0).vy"
DRAWN = """
parameters: {{m: 1.0}}
coordinates: {{theta: {{initial: 0.3}}, s: {{initial: 1.0}}}}
masses: {{bob: m, cart: m}}
positions: {{bob: ["sin(early)", "-cos(theta)"], cart: [s, "0*m"]}}
bodies:
  top:
    mass: m
    inertia: [m, m, m]
    position: [s, "early", "0*m"]
    orientation: {{euler: [theta, early, s]}}
definitions:
{definitions}
  early: theta + 0.1*t
potential: "{use} + top.x"
"""


@pytest.mark.exhaustive(keep=0.25)
@examples(30)
@given(st.data())
def test_definitions_in_any_order_are_what_they_stand_for(data: st.DataObject) -> None:
    names = data.draw(st.permutations(["a", "b", "c", "d", "e"]))
    lines = []
    for k, name in enumerate(names):
        known = st.sampled_from([*LEAVES, "early", *names[:k]])
        operator = st.sampled_from(["{} + {}", "{}*{}", "sin({} - {})", "norm(({}, {}))"])
        lines.append(f'  {name}: "{data.draw(operator).format(data.draw(known), data.draw(known))}"')
    given = "\n".join(data.draw(st.permutations(lines)))
    text = DRAWN.format(definitions=given, use=f"{names[-1]}*theta + {names[-2]}")
    compare(text, inlined(text))


def test_definitions_of_particles_are_built_only_where_they_are_used() -> None:
    """As an expression that stands nowhere."""
    text = PARTICLES.replace("definitions:", "definitions:\n  never: 1/(bob.y - bob.y)")
    compare(text, PARTICLES)


def test_long_chains_of_definitions_of_particles_are_built() -> None:
    links = "\n".join(f'  d{k}: "d{k - 1} + cart.x*theta**2"' for k in range(1, 400))
    text = PARTICLES.replace("definitions:", f"definitions:\n{links}\n  d0: cart.x").replace(
        "k*stretch", "d399 + k*stretch"
    )
    model = build_model(read_spec(text, "file"), GraphAlgebra())
    known = {"theta": 0.5, "s": 2.0, "t": 0.0, "m": 1.0, "k": 0.0, "l": 0.7, "c": 0.1}
    assert evaluate([model.potential], known)[0] == pytest.approx(2.0 + 399 * 2.0 * 0.25)
