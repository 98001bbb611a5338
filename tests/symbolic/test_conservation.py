"""What is conserved, why, and what is not."""

import pytest
import sympy

from lagrange_cli.run.equations import derive
from lagrange_cli.symbolic.statements import plain
from tests.support.motion import spec_of
from tests.support.systems import NAMES, agree_at_random, derived, equations_of, same

CONSERVED = {
    "atwood": {"h"},
    "bouncing_ball": {"h"},
    "central_force": {"p_theta", "h"},
    "central_force_cartesian": {"h"},
    "charged_particle": {"p_z", "h"},
    "double_pendulum": {"h"},
    "driven_damped_pendulum": set(),
    "figure_eight": {"h"},
    "foucault_gyroscope": {"p_psi", "h"},
    "fpu_chain": {"h"},
    "free_particles": {"h"},
    "gauge_oscillator": set(),
    "gravity_gradient": {"h"},
    "harmonic_oscillator": {"h"},
    "henon_heiles": {"h"},
    "incline": {"h"},
    "kicked_rotor": {"p_theta", "h"},
    "kovalevskaya_top": {"p_phi", "h"},
    "lagrange_top": {"p_phi", "p_psi", "h"},
    "lattice": {"h"},
    "n_pendulum": {"h"},
    "newtons_cradle": {"h"},
    "parabola_bead": {"h"},
    "pendulum": {"h"},
    "physical_pendulum": {"h"},
    "rotating_hoop": {"h"},
    "rotating_rod": {"h"},
    "solar_system": {"h"},
    "spherical_pendulum": {"p_phi", "h"},
}


def along_the_motion(equations, quantity):
    """d/dt of a quantity with the accelerations put in."""
    rate = quantity.diff(equations.time)
    for symbols, values in ((equations.q, equations.v), (equations.v, equations.accelerations)):
        rate += sum(quantity.diff(s) * value for s, value in zip(symbols, values, strict=True))
    return rate


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize("name", NAMES)
def test_what_is_named_conserved_is(name):
    equations = equations_of(name)
    assert {each.quantity for each in equations.conserved} == CONSERVED[name]
    for each in equations.conserved:
        assert same(along_the_motion(equations, each.expression), "0")


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("name", NAMES)
def test_rates_of_what_is_not_conserved(name):
    equations = equations_of(name)
    for each in equations.changing:
        quantity = equations.h if each.quantity == "h" else equations.T + equations.U
        assert each.rate != 0
        assert agree_at_random(along_the_motion(equations, quantity), each.rate)


def test_reasons():
    def because(name, quantity):
        equations = equations_of(name)
        (found,) = [e.because for e in (*equations.conserved, *equations.changing) if e.quantity == quantity]
        return plain(found)

    assert "h = T + U" in because("pendulum", "h")
    assert "U contains velocities" in because("charged_particle", "h")
    assert "h is not T + U, as the embedding contains t" in because("rotating_rod", "h")
    assert "friction" in because("driven_damped_pendulum", "h")
    assert because("gauge_oscillator", "h") == "L contains t explicitly"


def test_friction_breaks_a_cyclic_momentum():
    equations = derived(
        """
        parameters: {m: 1, c: 0.1}
        coordinates: {x: {initial: 0}}
        masses: {body: m}
        embedding: {body: [x]}
        dissipation: c*x_dot**2/2
        """
    )
    assert not equations.conserved
    momentum = equations.changing[0]
    assert momentum.quantity == "p_x" and same(momentum.rate, "-c*x_dot")
    assert "cyclic, but" in momentum.because


def test_a_force_that_does_no_work_leaves_h():
    equations = derived(
        """
        parameters: {m: 1, b: 2}
        coordinates: {x: {initial: 0}, y: {initial: 0}}
        masses: {body: m}
        embedding:
          body: [x, y]
        generalized_forces: {x: b*y_dot, y: -b*x_dot}
        """
    )
    (h,) = equations.conserved
    assert h.quantity == "h" and "no work" in h.because


def test_a_moving_frame_in_which_the_energy_is_kept_all_the_same():
    equations = derived(
        """
        parameters: {m: 1, u: 2}
        coordinates: {x: {initial: 0}}
        masses: {body: m}
        embedding: {body: [x + u*t]}
        """
    )
    assert {each.quantity for each in equations.conserved} == {"p_x", "h", "T + U"}


@pytest.mark.parametrize("jump", ["sqrt(({0} - 5)**2)/({0} - 5)", "atan(1/{0}) + atan({0})"])
def test_what_jumps_depends_on_its_argument_although_its_derivative_vanishes(jump):
    system = (
        "coordinates: {{x: {{initial: 1}}, z: {{initial: 1}}}}\nlagrangian: x_dot**2/2 + z_dot**2/2 - ({})"
    )
    assert {e.quantity for e in derived(system.format(jump.format("x"))).conserved} == {"p_z", "h"}
    assert {e.quantity for e in derived(system.format(jump.format("t"))).conserved} == {"p_x", "p_z"}


@pytest.mark.exhaustive(keep=0.35)
def test_what_formulas_of_parameters_conserve_is_printed():
    """The integral of the swinging Atwood machine whose masses are 3 : 1 (N. B. Tufillaro 1986)."""
    text = """
        parameters: {m: 1, M: 3*m, g: 9.81}
        coordinates: {r: {initial: 1}, theta: {initial: 1.2}}
        masses: {swing: m, weight: M}
        positions: {swing: [r*sin(theta), -r*cos(theta)], weight: [0, r]}
        potential: m*g*swing.y + M*g*weight.y
        """
    (found,) = [one for one in derive(spec_of(text)).equations.conserved if one.quantity == "A_y"]
    assert found.because.endswith("only where M = 3*m")
    r, theta, v, w, m, g = sympy.symbols("r theta r_dot theta_dot m g")
    sin, cos = sympy.sin(theta / 2), sympy.cos(theta / 2)
    known = r**2 * w * (v * cos - r * w * sin / 2) + g * r**2 * sin * cos**2
    written = found.expression.subs(sympy.cos(theta), 2 * cos**2 - 1)
    assert sympy.expand(written + 2 * m * known) == 0
    without = derive(spec_of(text.replace("3*m", "3"))).equations.conserved
    assert [one.quantity for one in without] == ["h"]


@pytest.mark.parametrize(
    ("potential", "jumps"),
    [
        ("where(t < 1, 1, 2)*x**2", True),
        ("sign(t - k)*x**2", True),
        ("k*max(0, x - 1 - sin(t)/5)**2", False),  # a moving wall
        ("where(x > t, k*(x - t)**2, 0)", False),
        ("abs(x)*cos(t)", False),
    ],
)
def test_an_energy_jumps_at_a_time_only(potential, jumps):
    """Where it would jump at a place, the force would be infinite, which is refused."""
    text = "parameters: {k: 2}\ncoordinates: [x]\nmasses: {p: 1}\npositions: {p: x}\npotential: "
    (energy,) = (one for one in derived(f"{text}{potential}").changing if one.quantity == "h")
    assert ("jumps at a time" in energy.because) == jumps
