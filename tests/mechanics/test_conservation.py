"""What is said to vanish, or to be conserved, where random arguments alone would not tell."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lagrange_cli.errors import InfiniteForce
from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.zero import is_zero
from lagrange_cli.mechanics.conservation import conservation
from tests.support.draws import examples
from tests.support.motion import model_of, residual_of

FORCED = """
parameters: {{w: 1}}
coordinates: {{x: {{initial: 0, velocity: 1}}}}
lagrangian: x_dot**2/2 - ({potential})
generalized_forces: {{x: {force}}}
"""


@pytest.mark.parametrize(
    ("potential", "force"),
    [
        ("tanh(1e6*x)", "0"),
        ("exp(-100*(x + 9))", "0"),
        ("1/cosh(1e4*(x - 7))**2", "0"),
        ("cosh(30*(x + 2)) - sinh(30*(x + 2))", "0"),
        ("1/(1 + ((x - 1)/1e-7)**30)", "0"),
        ("(1 + ((x - 1)/1e-7)**2)**(-30)", "0"),
        ("x/sqrt(x**2 + 1e-24)", "0"),
        ("sqrt((x - 1)**2 + 1e-30) - sqrt((x - 1)**2 + 4e-30)", "0"),
        ("0", "1e-6*(atan(1e9*t) - atan(1e9*t - 1))"),
        ("0", "exp(-(t - 50)**2/w**2)"),
        ("0", "exp(-(t - 1e9)**2/1e-6)"),
    ],
)
def test_a_force_that_is_tiny_almost_everywhere_is_a_force(potential, force):
    residual = residual_of(FORCED.format(potential=potential, force=force))
    assert "p_x" not in {each.quantity for each in residual.conserved}
    assert not residual.cyclic_momenta


@pytest.mark.exhaustive(keep=0.7)
@examples(30)
@given(scale=st.floats(-1e9, 1e9).filter(lambda x: abs(x) > 1e-3), place=st.floats(-100, 100))
def test_a_function_of_any_scale_is_not_zero(scale, place):
    graph = Graph()
    u = scale * (graph.symbol("x") - place)
    tanh = graph.function("tanh", [u])
    assert not is_zero(graph.function("exp", [u]))
    assert not is_zero(1.0 - tanh * tanh)
    assert not is_zero(graph.function("cosh", [u]) - graph.function("sinh", [u]))


@examples(30)
@given(scale=st.floats(0.1, 5))
def test_identities_of_such_functions_are_seen(scale):
    graph = Graph()
    u = scale * graph.symbol("x")
    exp, sinh, cosh = (graph.function(name, [u]) for name in ("exp", "sinh", "cosh"))
    assert is_zero(cosh * cosh - sinh * sinh - 1.0)
    assert is_zero(exp - cosh - sinh)
    assert not is_zero(exp - cosh - sinh + 1e-6 * u)


@pytest.mark.parametrize("mass", [1.0, 5.97e24, 1e-27])
def test_identities_are_seen_at_any_scale(mass):
    residual = residual_of(f"""
        coordinates: {{r: {{initial: 1}}, phi: {{initial: 0, velocity: 1}}, psi: {{initial: 1}}}}
        masses: {{p: {mass!r}}}
        embedding: {{p: [r*cos(phi + psi), r*sin(phi + psi), psi]}}
        potential: -{mass!r}/sqrt(p.x**2 + p.y**2)
        """)
    assert {each.quantity for each in residual.conserved} >= {"p_phi", "h"}


KINK = "(({0} - 5 + {1})/2)"
ROOTS = ["sqrt(({0} - 5)**2)", "(({0} - 5)**4)**0.25", "sqrt(({0} - 5)**2 + 1e-20)"]


@pytest.mark.parametrize("root", ROOTS)
@pytest.mark.parametrize(
    "force",
    ["potential: {x}**2", "dissipation: {x}*x_dot**2", "generalized_forces: {{x: -{x}}}", "potential: z*{t}"],
)
def test_a_force_beyond_a_kink_is_a_force(force, root):
    """Nothing tells of it at x and t below 5."""
    law = force.format(**{name: KINK.format(name, root.format(name)) for name in ("x", "t")})
    residual = residual_of(f"""
        coordinates: {{x: {{initial: 0.3, velocity: 2}}, z: {{initial: 1}}}}
        masses: {{ball: 1}}
        embedding: {{ball: [x, z]}}
        {law}
        """)
    conserved = {each.quantity for each in residual.conserved}
    if "z*" in law:
        assert conserved == {"p_x"}
    else:
        assert "p_z" in conserved and "p_x" not in conserved
        assert ("h" in conserved) == law.startswith("potential")


@pytest.mark.parametrize("jump", ["sqrt(({0} - 5)**2)/({0} - 5)", "atan(1/{0}) + atan({0})"])
def test_what_jumps_depends_on_its_argument_although_its_derivative_vanishes(jump):
    lagrangian = "lagrangian: x_dot**2/2 + z_dot**2/2 - ({})"
    coordinates = "coordinates: {x: {initial: 1}, z: {initial: 1}}\n"
    try:
        assert residual_of(coordinates + lagrangian.format(jump.format("x"))).cyclic == ("z",)
    except InfiniteForce:
        assert "sqrt" in jump
    of_t = residual_of(coordinates + lagrangian.format(jump.format("t")))
    assert "h" not in {each.quantity for each in of_t.conserved}
    assert not of_t.scleronomic


def test_a_root_of_what_does_not_depend_on_a_coordinate_does_not_either():
    residual = residual_of("""
        coordinates: {r: {initial: 1}, phi: {initial: 0, velocity: 1}, psi: {initial: 1}}
        masses: {p: 1}
        embedding: {p: [r*cos(phi + psi), r*sin(phi)*cos(psi) + r*cos(phi)*sin(psi), psi]}
        potential: atan2(norm(p), psi) + log(p.x**2 + p.y**2)
        """)
    assert {each.quantity for each in residual.conserved} == {"p_phi", "h"}


@pytest.mark.exhaustive(keep=5)
@pytest.mark.parametrize(
    ("event", "broken"),
    [
        ("{when: x}", {}),
        ("{when: x, action: stop}", {}),
        ("{when: x, action: {set: {x_dot: -x_dot}}}", {}),
        ("{when: x, action: {set: {x_dot: -e*x_dot}}}", {"h"}),
        ("{when: t - 1, action: {set: {y: y + 1}}}", {}),
        ("{when: t - 1, action: {set: {x: -x}}}", {}),
        ("{when: t - 1, action: {set: {x: x + 1}}}", {"h"}),
        ("{when: t - 1, action: {set: {y_dot: -y_dot}}}", {"p_y"}),
        ("{when: t - 1, action: {set: {y_dot: y_dot + 1}}}", {"p_y", "h"}),
        ("{when: t - 1, action: {set: {k: 2*k}}}", {"h"}),
        ("{when: t - 1, action: {set: {e: 2*e}}}", {}),
        ("{when: t - 1, action: {set: {m: 2*m}}}", {"p_y", "h"}),
        ("{when: t - 1, action: {set: {m: 2*m, x_dot: x_dot/2, y_dot: y_dot/2, k: k + m*k0}}}", {"h"}),
        ("{when: t - 1, action: {set: {x_dot: x_dot*sin(e)**2 + x_dot*cos(e)**2}}}", {}),
    ],
)
def test_an_event_keeps_what_is_proven_to_be_the_same_after_it(event, broken):
    residual = residual_of(f"""
        parameters: {{m: 2, k: 3, e: 0.5, k0: 1}}
        coordinates: {{x: {{initial: 1}}, y: {{initial: 0}}}}
        masses: {{p: m}}
        positions: {{p: [x, y]}}
        potential: k*x**2/2
        events: {{e: {event}}}
        """)
    found = {each.quantity: each for each in residual.conserved}
    assert found.keys() == {"p_y", "h"}
    assert {name for name, each in found.items() if each.breaks} == set(broken)
    assert all(each.breaks in ((), ("e",)) for each in found.values())
    assert all(
        ("only between events, as 'e'" in each.because) == bool(each.breaks) for each in found.values()
    )


@pytest.mark.parametrize(
    ("change", "broken"),
    [
        ("x_dot: -x_dot", {}),
        ("l: l/2", {"h"}),
        ("x: x/2", {"h"}),
        ("x_dot: u_dot, u_dot: x_dot", {"h"}),
        ("k: 2", {}),
        ("z_dot: z_dot + k", {"h", "p_z"}),
        ("z: z + l", {}),
    ],
)
def test_an_event_that_may_violate_constraints_keeps_what_their_impulses_do_not_change(change, broken):
    """The swing of a pendulum that is shortened begins anew at another height, with another energy."""
    residual = residual_of(f"""
        parameters: {{l: 1, g: 9.81, k: 0}}
        coordinates:
          {{x: {{initial: 0.6}}, y: {{initial: -0.8}}, u: {{initial: 0}}, w: {{initial: -1}},
            z: {{initial: 0}}}}
        masses: {{a: 1, b: 1, c: 2}}
        positions: {{a: [x, y], b: [u, w], c: z}}
        potential: g*(y + w)
        constraints: {{long: norm(a) - l, short: norm(b) - 1}}
        events: {{e: {{when: t - 1, action: {{set: {{{change}}}}}}}}}
        """)
    found = {each.quantity: each for each in residual.conserved}
    assert found.keys() == {"p_z", "h"}
    assert {name for name, each in found.items() if each.breaks} == set(broken)


def test_two_balls_that_collide_keep_energy_and_momentum_together():
    """Newton's law of impact with restitution 1."""
    residual = residual_of("""
        parameters: {m: 2, M: 3}
        coordinates: {s: {initial: 1}, d: {initial: 1}}
        masses: {a: m, b: M}
        positions: {a: s, b: s + d}
        events:
          hit: {when: d, direction: falling, action: {set: {d_dot: -d_dot, s_dot: s_dot + 2*M/(m + M)*d_dot}}}
        """)
    assert {each.quantity: each.breaks for each in residual.conserved} == {
        "p_s": (),
        "p_d": ("hit",),
        "h": (),
    }


@pytest.mark.parametrize(
    ("force", "constraint", "phrase"),
    [
        ("", "", "explicitly; h is"),
        ("generalized_forces: {x: -k*y_dot, y: k*x_dot}", "", "and the generalized forces do no work; h is"),
        ("", "constraints: {c: x - y}", "and the forces of constraint do no work; h is"),
        (
            "generalized_forces: {x: -k*y_dot, y: k*x_dot}",
            "constraints: {c: x - y}",
            "and neither the generalized forces nor the forces of constraint do work; h is",
        ),
    ],
)
def test_the_reason_names_the_forces_that_there_are(force, constraint, phrase):
    found = residual_of(f"""
parameters: {{k: 2}}
coordinates: {{x: {{initial: 0}}, y: {{initial: 0}}, z: {{initial: 0}}}}
masses: {{p: 1}}
positions: {{p: [x, y, z]}}
{force}
{constraint}
""").conserved
    because = {each.quantity: each.because for each in found}
    assert phrase in because["h"]
    acts = "neither a generalized force nor a force of constraint" if constraint else "no generalized force"
    assert because["p_z"].endswith(f", and {acts} acts on it")


def test_the_energy_is_kept_by_a_round_wall():
    """The action has r**2 where x**2 + y**2 may stand, since it happens there alone."""
    text = """
    parameters: {r: 0.5}
    coordinates: {x: {initial: 1, velocity: -1}, y: {initial: 0.2}}
    definitions: {f: 2*(x*x_dot + y*y_dot)/r**2}
    masses: {p: 1}
    positions: {p: [x, y]}
    events:
      disc:
        when: x**2 + y**2 - r**2
        direction: falling
        action: {set: {x_dot: x_dot - f*x, y_dot: y_dot - f*y}}
    """
    for factor, breaks in (("2", ()), ("1.9", ("disc",))):
        _, kept = conservation(model_of(text.replace("f: 2", f"f: {factor}")))
        assert {one.quantity: one.breaks for one in kept}["h"] == breaks
