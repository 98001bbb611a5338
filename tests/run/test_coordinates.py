"""A system in other coordinates: the same equations, the same motion, and what cannot be."""

import json

import numpy as np
import pytest

from lagrange_cli.errors import SpecError, UsageError
from lagrange_cli.records import replace
from lagrange_cli.run.coordinates import AGREES, STATES, covariance, in_coordinates, old_state, start_in
from lagrange_cli.run.equations import derive
from lagrange_cli.run.start import consistent_values
from lagrange_cli.run.verification import along, verify_system
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_values
from lagrange_cli.symbolic.states import State
from tests.support.command import lagrange
from tests.support.files import problems, underlined

PLANE = """
parameters: {m: 1.5, k: 2.0, c: 0.1, w: 0.4}
coordinates:
  x: {initial: 1, velocity: 0.3}
  y: {initial: 0.5, velocity: 0.7}
masses: {p: m}
embedding: {p: [x, y]}
definitions: {speed: x_dot + y_dot}
potential: k/2*(x**2 + 2*p.y**2)
generalized_forces: {x: -c*x_dot*(1 + y**2)}
forces: {p: "(0, sin(w*t))"}
dissipation: c*speed**2/2
transformations:
  polar: {coordinates: [r, phi], replace: {x: r*cos(phi), y: r*sin(phi)}}
  turning: {coordinates: [u, s], replace: {x: u*cos(w*t) - s*sin(w*t), y: u*sin(w*t) + s*cos(w*t)}}
  one: {coordinates: {z: {initial: 1}}, replace: {x: z**3 + z + t*y}}
solve: {stop: 2}
"""
PENDULUM = """
parameters: {m: 1.0, l: 1.0, g: 9.81}
coordinates: {x: {initial: 0.6}, y: {initial: -0.8}}
masses: {p: m}
embedding: {p: [x, y]}
potential: m*g*p.y
constraints: {rod: x**2 + y**2 - l**2}
transformations:
  polar: {coordinates: [r, phi], replace: {x: r*sin(phi), y: -r*cos(phi)}}
solve: {stop: 2}
"""
SLEIGH = """
parameters: {m: 1.0, J: 0.3, a: 0.2}
coordinates: {x: {initial: 0, velocity: 0.3}, y: {initial: 0}, theta: {initial: 0.2, velocity: 0.5}}
lagrangian: m/2*(x_dot**2 + y_dot**2) + J/2*theta_dot**2
nonholonomic: {blade: y_dot*cos(theta) - x_dot*sin(theta) - a*theta_dot}
transformations:
  turned:
    coordinates: [xi, eta]
    replace: {x: xi*cos(theta) - eta*sin(theta), y: xi*sin(theta) + eta*cos(theta)}
solve: {stop: 2}
"""
CHAIN = """
sizes: {N: 3}
parameters: {m: 1.0, k: 2.0}
coordinates: {"u[i in range(N)]": {initial: 0.1*i**2}}
masses: {"p[i in range(N)]": m}
embedding: {"p[i in range(N)]": "u[i]"}
potential: k/2*sum((u[i + 1] - u[i])**2 for i in range(N - 1))
transformations:
  modes:
    coordinates: {"a[j in range(N)]": {}}
    replace: {"u[i in range(N)]": "sum(a[j]*cos(pi*j*(i + 0.5)/N) for j in range(N))"}
events: {hit: {when: "u[0] + 1", action: {set: {"u_dot[0]": "-u_dot[0]"}}}}
solve: {stop: 2}
"""
CASES = {
    "polar": PLANE,
    "turning": PLANE,
    "one": PLANE,
    "rod": PENDULUM.replace("polar", "rod"),
    "turned": SLEIGH,
    "modes": CHAIN,
}


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize("name", CASES)
def test_the_motion_is_the_same_in_other_coordinates(name):
    """Both are integrated; the new one is taken back to the coordinates of the file."""
    old = read_spec(CASES[name], "a.yaml")
    new, values = start_in(old, in_coordinates(old, name), {})
    first, here, _ = consistent_values(replace(old, events={}), resolve_values(old), 0.0, {})
    ours, theirs = along(new, values), along(first, here)
    assert len(ours) == len(theirs) == 8
    for (t, q, v), (_, expected, speeds) in zip(ours, theirs):
        state = State(dict(values.parameters), t, q, v)
        back = [old_state(new, state, [0.0] * len(q))[one.name].value for one in old.coordinates]
        assert [one[0] for one in back] == pytest.approx(expected, rel=1e-11, abs=1e-11)
        assert [one[1] for one in back] == pytest.approx(speeds, rel=1e-11, abs=1e-11)


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("name", ["turning", "rod", "turned", "modes"])
def test_the_equations_keep_their_form(name):
    spec = read_spec(CASES[name], "a.yaml")
    derived = derive(spec, coordinates=name)
    assert derived.covariance.agrees and derived.covariance.states == STATES
    assert {*derived.equations.replaced} == {*spec.transformations[name].replaced}
    assert verify_system(derived, {}).agrees


@pytest.mark.exhaustive(keep=0.5)
def test_a_generalized_force_that_is_not_transformed_is_seen():
    spec = read_spec(PLANE, "a.yaml")
    wrong = derive(read_spec(PLANE.replace("-c*x_dot", "-1.001*c*x_dot"), "a.yaml"), coordinates="polar")
    assert covariance(spec, wrong.spec, wrong.equations, {}).difference > 1e3 * AGREES


def test_an_event_that_sets_what_is_replaced_may_change_what_is_conserved():
    derived = derive(read_spec(CHAIN.replace("N: 3", "N: 2"), "a.yaml"), coordinates="modes")
    momentum = next(one for one in derived.equations.conserved if one.quantity == "p_a[0]")
    assert momentum.breaks == ("hit",)


def test_an_unknown_transformation_and_one_that_is_singular():
    spec = read_spec(PLANE, "a.yaml")
    with pytest.raises(UsageError, match="did you mean 'polar'"):
        derive(spec, coordinates="poler")
    flat = PLANE.replace("x: r*cos(phi), y: r*sin(phi)", "x: r + phi, y: 2*r + 2*phi")
    with pytest.raises(SpecError, match="cannot be inverted"):
        derive(read_spec(flat, "a.yaml"), coordinates="polar")


@pytest.mark.parametrize(
    ("old", "new", "message", "where"),
    [
        ("x: r*cos(phi)", "x: r*cos(phj)", "unknown name 'phj' in 'x' of transformation 'polar'", "phj"),
        ("x: r*cos(phi)", "x: r*cos(y)", "'y' is itself replaced and cannot be used", "y"),
        ("x: r*cos(phi)", "x: r*r_dot", "the velocity 'r_dot' cannot be used", "r_dot"),
        ("x: r*cos(phi)", "x: speed", "the definition 'speed'", "speed"),
        ("x: r*cos(phi)", "x: p.x*phi", "the particle 'p' cannot be used", "p.x"),
        ("x: r*cos(phi)", "q: r*cos(phi)", "replaces 'q', which is not a coordinate", "q"),
        ("[r, phi]", "[m, phi]", "the coordinate 'm' has the name of a parameter", "m"),
        ("[r, phi]", "[r, phi, s]", "replaces 2 coordinates by 3", "polar"),
        ("x: r*cos(phi), y: r*sin(phi)", "x: r, y: -r", "on the new coordinate 'phi'", "phi"),
        (", replace: {x: r*cos(phi), y: r*sin(phi)}", "", "has no 'replace'", "polar"),
    ],
)
def test_what_is_wrong_with_a_transformation(old, new, message, where):
    found = problems(PLANE.replace(old, new, 1))
    assert message in found[0].message
    assert underlined(found[0]).startswith(where[0])


def test_the_initial_state_is_found():
    old = read_spec(PLANE, "a.yaml")
    _, values = start_in(old, in_coordinates(old, "polar"), {"x": "-1"})
    assert np.cos(values.q[1]) * values.q[0] == pytest.approx(-1, abs=1e-13)
    assert resolve_values(old).parameters == values.parameters


@pytest.mark.exhaustive(keep=0.3)
def test_the_command_says_how_the_equations_compare(tmp_path):
    file = tmp_path / "plane.yaml"
    file.write_text(PLANE, encoding="utf-8")
    shown = lagrange("equations", file, "--coordinates", "turning", "--json", cwd=tmp_path)
    found = json.loads(shown.stdout)
    assert found["coordinates"] == ["u", "s"] and [*found["replaced"]] == ["x", "y"]
    assert found["covariance"]["agrees"] and shown.returncode == 0


def test_where_the_search_begins_need_not_be_in_the_domain():
    text = (
        "coordinates: {x: {initial: 0.9, velocity: 0.1}}\nmasses: {p: 1}\npositions: {p: [sin(x), cos(x)]}\n"
    )
    text += "transformations: {up: {coordinates: [c], replace: {x: acos(c)}}}\n"
    old = read_spec(text, "a.yaml")
    assert start_in(old, in_coordinates(old, "up"), {})[1].q == pytest.approx([np.cos(0.9)], rel=1e-12)


@pytest.mark.exhaustive(keep=0.8)
def test_the_energy_of_constraints_at_rest_is_conserved_in_coordinates_that_move():
    """Seen from a lift that shakes, h is not conserved, but T + U in space is."""
    shaken = "  shaken: {coordinates: {Y: {initial: -1}}, replace: {y: Y + sin(3*t)/10}}\nsolve:"
    spec = read_spec(PENDULUM.replace("solve:", shaken), "pendulum.yaml")
    equations = derive(spec, coordinates="shaken").equations
    assert [each.quantity for each in equations.conserved] == ["T + U"]
    assert {each.quantity for each in equations.changing} == {"p_x", "h"}
