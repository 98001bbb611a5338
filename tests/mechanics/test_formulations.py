"""Each way to write the equations gives the same motion; Routh's keeps its momenta."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lagrange_cli as lagrange
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.methods.equations import Equations
from lagrange_cli.integrate.single_state import compiled_values
from lagrange_cli.mechanics.residual import Residual
from tests.support.draws import examples
from tests.support.motion import FULL, Motion, each_formulation, follow, prepare, residual_of, run, values_of

OUTPUTS = frozenset(("q", "v", "p", "h", "ledger"))
TWO_BODIES = """
parameters: {m: 2.0, M: 3.0, k: 1.5, e: 0.3}
coordinates:
  X: {initial: 0.1, velocity: 0.3}
  r: {initial: 1.2, velocity: -0.2}
  theta: {initial: 0.4, velocity: 0.8}
masses: {a: m, b: M}
embedding:
  a: [X + r*cos(theta)*M/(m + M), r*sin(theta)*M/(m + M)]
  b: [X - r*cos(theta)*m/(m + M), -r*sin(theta)*m/(m + M)]
potential: -k/norm(a - b) + e*r*r_dot*sin(t)
"""
"""The centre of mass and the angle are cyclic."""
COUPLED = """
parameters: {k: 1.5, g: 0.4}
coordinates:
  a: {initial: 0.3, velocity: 0.7}
  r: {initial: 1.1, velocity: 0.2}
  b: {initial: -0.2, velocity: -0.6}
  s: {initial: 0.5, velocity: 0.1}
lagrangian: >-
  (r_dot**2 + s_dot**2)/2 + r**2*(a_dot + b_dot)**2/2 + r**4*b_dot**2/(4*k) + g*s*r*a_dot*cos(t)
  + k/r - s**2/r
"""
"""Two cyclic coordinates that the mass matrix couples, in a field that acts on one of them."""


def motion(form: Residual, system: str, stop: float, samples: int = 41) -> Motion:
    """The motion in one formulation."""
    ready = prepare(form, Compilation(method="taylor", tolerance=FULL, outputs=OUTPUTS))
    return run(ready, values_of(system), 0.0, stop, samples)


@st.composite
def cyclic(draw: st.DrawFn) -> str:
    """A Lagrangian with one to three cyclic coordinates, whose inertias are what the potential divides by."""
    count = draw(st.integers(1, 3))
    number = st.integers(1, 9).map(lambda k: k / 4)
    bases = draw(st.lists(st.sampled_from(["r", "(2 + s**2)", "(r + s**2)"]), min_size=1, max_size=2))
    coordinates = [f"c{k}: {{initial: 0.2, velocity: {draw(number)}}}" for k in range(count)]
    coordinates += [f"r: {{initial: 1.5, velocity: {draw(number) / 4}}}", "s: {initial: 0.4, velocity: 0.3}"]
    terms = [f"(1 + {draw(number)})*(r_dot**2 + s_dot**2)", f"r_dot*s_dot/{draw(st.integers(2, 5))}"]
    terms += [f"{draw(number)}/{base}**{draw(st.integers(1, 3))}" for base in bases]
    for k in range(count):
        base = draw(st.sampled_from(bases))
        terms.append(f"m*{draw(number)}*{base}**{draw(st.sampled_from([-1, 1, 2]))}*c{k}_dot**2/2")
        field = draw(st.sampled_from(["0", "r*s", "cos(t)", "sin(s - t)"]))
        terms.append(f"{draw(number)}*({field})*c{k}_dot")
    force = draw(st.sampled_from(["0", "-s_dot/5", "cos(c0)*r_dot/3"]))
    return (
        f"parameters: {{m: 1.3}}\ncoordinates: {{{', '.join(draw(st.permutations(coordinates)))}}}\n"
        f'lagrangian: "{" + ".join(terms)}"\ngeneralized_forces: {{s: "{force}"}}\n'
    )


def check_agreement(system: str, stop: float) -> None:
    forms = each_formulation(system)
    (reduced, one), *others = sorted(
        ((name, motion(form, system, stop)) for name, form in forms.items()),
        key=lambda pair: pair[0] != "Routh",
    )
    assert reduced == "Routh"
    for name, other in others:
        assert len(one.t) == len(other.t) == 41
        for path, series in other.data.items():
            assert np.max(np.abs(one[path] - series)) <= 1e-12 * max(1.0, np.max(np.abs(series))), (
                name,
                path,
            )


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize(
    "system", ["central_force", TWO_BODIES, COUPLED], ids=["kepler", "two bodies", "coupled"]
)
def test_routh_s_motion_is_that_of_the_other_formulations(system: str) -> None:
    check_agreement(system, 3.0)


@pytest.mark.exhaustive(keep=0.2)
@examples(2)
@given(cyclic())
def test_random_systems_move_as_without_the_reduction(system: str) -> None:
    check_agreement(system, 0.5)


@pytest.mark.exhaustive(keep=0.2)
@examples(2)
@given(cyclic(), st.floats(-1, 1), st.floats(-1, 1))
def test_accelerations_and_jacobian_are_those_without_the_reduction(system: str, a: float, b: float) -> None:
    """At states where momenta are not what they were in the beginning."""
    forms = each_formulation(system)
    values = values_of(system)
    n = len(values.q)
    y = np.array([*values.q, *values.v]) + 0.1 * np.sin(np.arange(2 * n) + a)
    found, jacobians = [], []
    for name in ("lagrangian", "Routh"):
        made = compiled_values(forms[name])([1.3], b, y[:n], y[n:])
        found.append(made[0])
        machine = prepare(
            forms[name], Compilation(method="BDF", tolerance=1e-8, outputs=frozenset(("q", "v")))
        ).machine
        jacobians.append(Equations.of(machine, np.array([1.3])).jacobian(b, y))
    assert np.max(np.abs(found[0] - found[1])) <= 1e-12 * max(1.0, np.max(np.abs(found[0])))
    assert np.max(np.abs(jacobians[0] - jacobians[1])) <= 1e-11 * max(1.0, np.max(np.abs(jacobians[0])))


@pytest.mark.exhaustive(keep=0.35)
def test_the_formulations_of_the_spherical_pendulum_agree() -> None:
    forms = each_formulation("spherical_pendulum")
    assert set(forms) == {"embedding", "kinetic energy"}  # nothing is divided by sin(theta)
    one, other = (motion(form, "spherical_pendulum", 10.0) for form in forms.values())
    assert np.max(np.abs(one["q/theta"] - other["q/theta"])) <= 1e-11


@pytest.mark.exhaustive(keep=0.25)
def test_a_cyclic_momentum_does_not_drift() -> None:
    """Nor does the energy, as far: p is one number all the time, and the radial motion knows no other."""
    forms = each_formulation("central_force")
    motions = {name: motion(form, "central_force", 500.0, 2001) for name, form in forms.items()}
    p = motions["Routh"]["diagnostics/p/theta"]
    assert np.max(np.abs(p / p[0] - 1)) <= 1e-15
    drift = {name: one.outcome.p_drift["theta"] for name, one in motions.items()}
    assert drift["Routh"] < min(drift["embedding"], drift["kinetic energy"])


def test_the_state_in_the_beginning_is_the_one_given() -> None:
    one = follow("central_force", 1.0, 3)
    values = values_of("central_force")
    assert residual_of("central_force").formulation == "Routh"
    assert [one["v/r"][0], one["v/theta"][0]] == list(values.v)


FREE = "coordinates: {{r: {{initial: {r}, velocity: {v}}}, phi: {{initial: 0, velocity: {w}}}}}\n"
FREE += "lagrangian: {lagrangian}\n"
KEPLER = "(r_dot**2 + r**2*phi_dot**2)/2 + 1/r"


@pytest.mark.exhaustive(keep=0.45)
@pytest.mark.parametrize("r, v, w", [(0, 1, 1), (0, 1, 0), (1, 0, 0), (1, -1, 1e-9)])
def test_where_the_inertia_vanishes_it_ends_as_without_the_reduction(r: float, v: float, w: float) -> None:
    system = FREE.format(r=r, v=v, w=w, lagrangian=KEPLER)
    forms = each_formulation(system)
    endings = {name: motion(form, system, 5.0).outcome.ending for name, form in forms.items()}
    assert residual_of(system).formulation == "Routh"
    assert endings["Routh"] is endings["lagrangian"]
    assert (endings["Routh"] is Ending.SINGULAR_MASS_MATRIX) is (r == 0)


@pytest.mark.parametrize("theta", ["pi", "1e-15", "1e-150"])
def test_a_pendulum_goes_through_its_poles(theta: str) -> None:
    """Where sin(theta) is next to nothing, and phi does not turn: so there must be no powers of 1/sin."""
    found = follow(
        f"coordinates: {{theta: {{initial: {theta}, velocity: 1.0}}, phi: {{initial: 0}}}}\n"
        "masses: {bob: 1}\nembedding: {bob: [sin(theta)*cos(phi), sin(theta)*sin(phi), -cos(theta)]}\n"
        "potential: 9.81*bob.z\n",
        5.0,
    )
    assert found.outcome.ending is Ending.COMPLETE
    assert np.max(np.abs(found["v/phi"])) == 0


def test_only_what_is_cyclic_uncoupled_and_unforced_is_eliminated() -> None:
    """A cart is coupled to its pendulum; a torque acts on an angle; a velocity occurs to the fourth power."""
    for lagrangian, more in (
        ("r_dot**2/2 + r**2*phi_dot**2/2 + cos(r)*r_dot*phi_dot/3 + 1/r", ""),
        (KEPLER, "generalized_forces: {phi: 0.1}\n"),
        (KEPLER, "dissipation: phi_dot**2/10\n"),
        (KEPLER + " + phi/10", ""),
        (KEPLER + " + phi_dot**4/10", ""),
    ):
        system = FREE.format(r=1, v=0, w=1, lagrangian=lagrangian) + more
        assert set(each_formulation(system)) == {"lagrangian"}


TOP = """
parameters: {{I1: 1, I3: 0.5, mgl: 1, spin: {spin!r}}}
coordinates:
  theta: {{initial: {theta!r}, velocity: {theta_dot!r}}}
  phi: {{initial: {phi!r}, velocity: {phi_dot!r}}}
  psi: {{initial: 0, velocity: "spin - ({phi_dot!r})*cos({theta!r})"}}
lagrangian: >-
  I1*(theta_dot**2 + phi_dot**2*sin(theta)**2)/2 + I3*(psi_dot + phi_dot*cos(theta))**2/2 - mgl*{height}
"""


def test_a_fast_top_near_the_vertical_is_that_of_angles_about_a_level_axis():
    """1e-3 from the pole of its angles M is nearly singular, and its elimination must not cancel."""
    tilt, rate, spin = 1e-3, 1.0, 6.0
    near = TOP.format(
        spin=spin, theta=tilt, theta_dot=0.0, phi=0.0, phi_dot=rate, height="cos(theta)"
    )  # n = (sin theta cos phi, sin theta sin phi, cos theta), the last of them upwards
    level = TOP.format(
        spin=spin,
        theta=math.pi / 2,
        theta_dot=-math.sin(tilt) * rate,
        phi=tilt,
        phi_dot=0.0,
        height="sin(theta)*cos(phi)",
    )  # n = (sin theta sin phi, cos theta, sin theta cos phi)
    assert "psi" in {one.velocity.data.removesuffix("_dot") for one in residual_of(near).cyclic_momenta}
    found, known = follow(near, 50.0, 101), follow(level, 50.0, 101)
    assert found.outcome.steps < 1000
    theta, phi = found["q/theta"], found["q/phi"]
    there, about = known["q/theta"], known["q/phi"]
    assert np.abs(np.sin(theta) * np.cos(phi) - np.sin(there) * np.sin(about)).max() < 1e-12
    assert np.abs(np.sin(theta) * np.sin(phi) - np.cos(there)).max() < 1e-12


@pytest.mark.exhaustive(keep=0.4)
def test_a_cyclic_coordinate_of_constant_inertia_leaves_those_that_it_is_coupled_to():
    """A pendulum on a cart: the cart's momentum is cyclic, and every formulation gives the same motion."""
    cart = """
        parameters: {M: 2.0, m: 1.5, l: 0.8, g: 9.81}
        coordinates: {x: {initial: 0.3, velocity: 0.4}, theta: {initial: 1.2, velocity: -0.7}}
        lagrangian: >-
          (M + m)*x_dot**2/2 + m*l*x_dot*theta_dot*cos(theta) + m*l**2*theta_dot**2/2 + m*g*l*cos(theta)
        """
    forms = each_formulation(cart)
    assert [one.velocity.data for one in forms["Routh"].cyclic_momenta] == ["x_dot"]
    assert forms["Routh"].mass_matrix[1][0].is_zero and not forms["Routh"].mass_matrix[0][1].is_zero
    ends = []
    for form in forms.values():
        ready = prepare(form, Compilation(method="taylor", tolerance=FULL, outputs=OUTPUTS))
        motion = run(ready, values_of(cart), 0.0, 5.0, 11)
        assert motion.outcome.h_drift < 1e-13
        ends.append(np.concatenate([motion["q/x"], motion["q/theta"]]))
    assert np.abs(ends[0] - ends[1]).max() < 1e-12


def test_what_occurs_twice_in_a_velocity_counts_once_in_its_square():
    """A plank rocks on a cylinder: R*cos(th)*th_dot occurs in (R + h)*cos(th)*th_dot, and is subtracted."""
    plank = """
    parameters: {R: 0.5, h: 0.02, I: 0.1}
    coordinates: {th: {initial: 0.6, velocity: 1}}
    bodies:
      plank:
        mass: 1
        inertia: [I, I, I]
        position: (R + h)*(sin(th), cos(th), 0) - R*th*(cos(th), -sin(th), 0)
        orientation: {euler: [-th, 0, 0]}
    potential: 9.81*plank.y
    """
    forms = {name: motion(form, plank, 3.0) for name, form in each_formulation(plank).items()}
    h = forms["kinetic energy"]["diagnostics/h"]
    assert np.max(np.abs(h - h[0])) <= 1e-13
    for path in ("q/th", "v/th"):
        assert forms["kinetic energy"][path] == pytest.approx(forms["embedding"][path], abs=1e-12)


TOPS = """
sizes: {{N: {count}}}
coordinates:
  phi[i in range(N)]: {{initial: 1}}
  psi[i in range(N)]: {{initial: 0, velocity: 1000}}
bodies:
  rotor[i in range(N)]:
    mass: 0.5
    inertia: [1e-4, 1e-4, 1.6e-4]
    position: [0, 0, 0]
    orientation: {{euler: [7e-5*t, "-phi[i]", "psi[i]"], sequence: zxz}}
potential: 0
"""


def test_many_rotors_are_reduced_as_one_is() -> None:
    """The turns of each are eliminated by its own momentum, and steps are as long as those of one."""
    one, many = (lagrange.solve(TOPS.format(count=n), stop=20, outputs="q") for n in (1, 12))
    assert residual_of(TOPS.format(count=12)).formulation == "Routh"
    assert many.attributes["steps"] == one.attributes["steps"]
    for name in one.q:
        assert many.q[name][:, 5] == pytest.approx(one.q[name][:, 0], abs=1e-12)
