"""Random systems: what is said to be conserved has no rate of change at random states, by doubles."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.mechanics.conservation import conservation
from lagrange_cli.mechanics.conserved.noether import Noether
from lagrange_cli.mechanics.conserved.symmetries import symmetries
from lagrange_cli.model.build import build_model
from tests.support.draws import examples
from tests.support.motion import spec_of
from tests.support.rates import rates

PARAMETERS = "parameters: {m: 1.3, k: 0.4, a: 0.6, g: 9.81, R: 0.3, D: 2, I: 0.2, J: 0.3}"
FACTORS = ["k", "a", "2", "m*g", "-0.7"]
RATIOS = ["1", "2", "3", "8", "k", "1/3"]
SPACES = [
    (
        "m/2*(r_dot**2 + r**2*phi_dot**2)",
        "1/r, r**2, r*sin(phi), 1/r**2, cos(phi)/r**2, r**2*cos(2*phi), phi, sqrt(r)*cos(phi/2), cos(t)*r**2",
    ),
    ("(m + K*m)/2*r_dot**2 + m/2*r**2*th_dot**2", "r, r*cos(th), 1/r, r**2, r*cos(th/2), sin(th/2)/r"),
    (
        "m/2*(r_dot**2 + r**2*th_dot**2 + (r*sin(th)*phi_dot)**2)",
        "1/r, r**2, r*cos(th), r**2*cos(th)**2, 1/(r*sin(th))**2, cos(th)/r**2, r*sin(th)*cos(phi)",
    ),
    (
        "m/2*(r_dot**2 + r**2*phi_dot**2 + K*z_dot**2)",
        "r**2, z, z**2, 1/r**2, 1/sqrt(r**2 + z**2), r*cos(phi)",
    ),
    (
        "m/2*(u**2 + w**2)*(u_dot**2 + w_dot**2)",
        "1/(u**2 + w**2), (u**4 + w**4)/(u**2 + w**2), u*w, u**2 - w**2, (u**2 + w**2)**2",
    ),
    (
        "m/2*(sinh(u)**2 + sin(w)**2)*(u_dot**2 + w_dot**2)",
        "1/(cosh(u) - cos(w)), 1/(cosh(u) + cos(w)), cosh(u)",
    ),
    (
        "m/2*(x_dot**2 + K*y_dot**2)",
        "x**2, y**2, x*y, y, 1/sqrt(x**2 + y**2), x**2*y, x**2*y + 2*y**3, 1/x**2",
    ),
    ("m/2*(th_dot**2 + sin(th)**2*phi_dot**2)", "cos(th), cos(th)**2, 1/cos(th)**2, sin(th)*cos(phi)"),
    ("m/2*(y**2*x_dot**2 + y_dot**2)", "y**2, 1/y, y*cosh(x), x"),
    ("m/2*(x_dot**2 + y_dot**2)/y**2", "y**2, 1/y, x, x**2 + y**2"),
]
SURFACES = [
    ("x y", "x, y, R", "ball.vx - R*ball.wy", "ball.vy + R*ball.wx"),
    ("x y", "x, y, R", "ball.vx - R*ball.wy + a*ball.y", "ball.vy + R*ball.wx - a*ball.x"),
    (
        "x y",
        "x - k*R*sin(al)*sin(be), y + k*R*cos(al)*sin(be), R - k*R*cos(be)",
        "x_dot - R*ball.wy",
        "y_dot + R*ball.wx",
    ),
    (
        "s z",
        "(D - R)*cos(s), (D - R)*sin(s), z",
        "ball.vy*cos(s) - ball.vx*sin(s) + R*ball.wz",
        "ball.vz + R*(ball.wx*sin(s) - ball.wy*cos(s))",
    ),
    (
        "th ph",
        "(D + R)*sin(th)*cos(ph), (D + R)*sin(th)*sin(ph), (D + R)*cos(th)",
        "(D + R)*th_dot - R*(ball.wy*cos(ph) - ball.wx*sin(ph))",
        "(D + R)*sin(th)*ph_dot + R*((ball.wx*cos(ph) + ball.wy*sin(ph))*cos(th) - ball.wz*sin(th))",
    ),
]


@st.composite
def particles(draw: st.DrawFn) -> str:
    """A particle in curvilinear coordinates of flat or curved space, with forces."""
    kinetic, potentials = draw(st.sampled_from(SPACES))
    chosen = draw(st.lists(st.sampled_from(potentials.split(", ")), max_size=3, unique=True))
    terms = [f" - {draw(st.sampled_from(FACTORS))}*({one})" for one in chosen]
    names = [name for name in ("r", "u", "w", "x", "y", "th", "phi", "z") if f"{name}_dot" in kinetic]
    text = f"lagrangian: {kinetic}{''.join(terms)}".replace("K", draw(st.sampled_from(RATIOS)))
    forces = [
        "",
        "",
        "",
        f"generalized_forces: {{{names[0]}: k*cos(t)}}",
        f"dissipation: k*{names[0]}_dot**2/2",
    ]
    return f"{PARAMETERS}\ncoordinates: {{{places(names)}}}\n{text}\n{draw(st.sampled_from(forces))}\n"


@st.composite
def balls(draw: st.DrawFn) -> str:
    """A ball that rolls on a plane, on a turntable, in a cylinder or on a sphere; its centre of mass may be
    elsewhere."""
    names, centre, *constraints = draw(st.sampled_from(SURFACES))
    more = draw(st.sampled_from(["", "", "", ", spin: ball.wz", ", spin: ball.w3"]))
    inertia = draw(st.sampled_from(["I, I, I", "I, I, J", "I, J, 2*I"]))
    potential = draw(st.sampled_from(["0", "m*g*ball.z", "m*g*ball.x", "m*g*(ball.x + ball.z)"]))
    return f"""{PARAMETERS}
coordinates: {{{places([*names.split(), "al", "be", "ga"])}}}
bodies:
  ball:
    mass: m
    inertia: [{inertia}]
    position: [{centre}]
    orientation: {{euler: [al, be, ga], sequence: zxz}}
potential: {potential}
nonholonomic: {{along: {constraints[0]}, across: {constraints[1]}{more}}}
"""


@st.composite
def oscillators(draw: st.DrawFn) -> str:
    """Linear systems that forces drive, which depend on t in several ways; some have friction."""
    spring, other = (draw(st.sampled_from(["0", "k", "-k", "g"])) for _ in range(2))
    drives = [
        "cos(a*t)",
        "sin(k*t + 1)",
        "t",
        "t*cos(t)",
        "exp(-a*t)",
        "cos(t)**2",
        "1",
        "1/(2 + t)",
        "exp(sin(t))",
    ]
    forces = [draw(st.sampled_from(drives)) for _ in range(2)]
    friction = draw(
        st.sampled_from(["0", "0", "a*(x_dot**2 + y_dot**2)", "a*x_dot**2", "k*(x_dot - y_dot)**2"])
    )
    turned = draw(st.sampled_from(["0", "0", "2*m*a*(x*y_dot - y*x_dot)", "m*a*x*y_dot"]))
    coupled = draw(st.sampled_from(["0", "g", "k"]))
    return f"""{PARAMETERS}
coordinates: {{{places(["x", "y"])}}}
lagrangian: >
  m*(x_dot**2 + y_dot**2)/2 - ({spring})*x**2/2 - ({other})*y**2/2 - {coupled}*(x - y)**2/2
  + ({turned}) + x*({forces[0]}) - k*y*{forces[1]}
dissipation: ({friction})/2
"""


def places(names):
    return ", ".join(f"{name}: {{initial: 0.7}}" for name in names)


def check(text):
    """All that is claimed, h and momenta too."""
    model = build_model(spec_of(text), GraphAlgebra())
    noether, (_, known) = Noether(model), conservation(model)
    nodes = {f"p_{name}": p for name, p in zip(model.coordinates, noether.energetics.momenta)}
    nodes["h"] = noether.energy
    claims = {one.quantity: nodes[one.quantity] for one in known}
    claims |= {one.conserved.quantity: one.node for one in symmetries(model, known)}
    states = [*rates(model, [*claims.values()])]
    assert len(states) > 2
    for found, sizes in states:
        for name, rate, size in zip(claims, found, sizes):
            assert abs(rate) < 1e-8 * size, name


@given(particles())
@examples(2)
def test_particles_conserve_what_is_claimed(text):
    check(text)


@given(oscillators())
@examples(2)
def test_driven_oscillators_conserve_what_is_claimed(text):
    check(text)


@pytest.mark.exhaustive(keep=0.2)
@given(balls())
@examples(1)
def test_rolling_balls_conserve_what_is_claimed(text):
    check(text)


def test_a_false_claim_would_be_seen():
    model = build_model(
        spec_of(f"{PARAMETERS}\ncoordinates: {{{places('r')}}}\nlagrangian: r_dot**2/2 - r"), GraphAlgebra()
    )
    assert all(abs(rate) > 0.1 for (rate,), _ in rates(model, [model.v[0]]))
