"""The equations of the shipped systems are those of the textbooks."""

import pytest
import sympy

from lagrange_cli.symbolic import canonical, monomials
from lagrange_cli.symbolic.derive import derive_equations
from lagrange_cli.symbolic.notations import Text
from lagrange_cli.symbolic.render import render
from tests.support.systems import (
    NAMES,
    agree_at_random,
    derived,
    equations_of,
    expression,
    model_of,
    renamed,
    same,
)


def acceleration(name: str, index: int = 0) -> sympy.Expr:
    accelerations = equations_of(name).accelerations
    assert accelerations is not None
    return accelerations[index]


def equation(name: str, index: int = 0) -> sympy.Expr:
    each = equations_of(name).equations[index]
    return each.left - each.right


ACCELERATIONS = {
    "pendulum": ["-g*sin(theta)/l"],
    "physical_pendulum": ["-m*g*d*sin(theta)/(m*a**2/12 + m*d**2)"],
    "atwood": ["(m1 - m2)*g/(m1 + m2)"],
    "incline": ["g*sin(alpha)"],
    "bouncing_ball": ["-g"],
    "kicked_rotor": ["0"],
    "parabola_bead": ["-(4*k**2*x*x_dot**2 + 2*g*k*x)/(1 + 4*k**2*x**2)"],
    "rotating_hoop": ["sin(theta)*(a*omega**2*cos(theta) - g)/a"],
    "rotating_rod": ["omega**2*r"],
    "henon_heiles": ["-x - 2*x*y", "-y - x**2 + y**2"],
    "harmonic_oscillator": ["-k*x/m"],
    "gauge_oscillator": ["-k*x/m"],
    "central_force": ["r*theta_dot**2 - mu/r**2", "-2*r_dot*theta_dot/r"],
    "central_force_cartesian": ["-mu*x/(x**2 + y**2)**(3/2)", "-mu*y/(x**2 + y**2)**(3/2)"],
    "spherical_pendulum": [
        "sin(theta)*cos(theta)*phi_dot**2 - g*sin(theta)/l",
        "-2*cos(theta)*theta_dot*phi_dot/sin(theta)",
    ],
    "driven_damped_pendulum": ["-g*sin(theta)/l - c*theta_dot/(m*l**2) + A*g*cos(Omega*t)/l"],
    "charged_particle": ["e*B*y_dot/m", "-e*B*x_dot/m", "0"],
    "fpu_chain": [
        "(k*(u_1 - 2*u_0) + alpha*((u_1 - u_0)**2 - u_0**2))/m",
        "(k*(u_0 - 2*u_1) + alpha*(u_1**2 - (u_1 - u_0)**2))/m",
    ],
    "lattice": [
        f"k*(u_{(i + 1) % 3}_0 + u_{(i + 2) % 3}_0 - 2*u_{i}_0) - w**2*sin(u_{i}_0)" for i in range(3)
    ],
    "double_pendulum": [
        # the form of most textbooks, with 2*theta1 - 2*theta2 in the denominator
        "(-g*(2*m1 + m2)*sin(theta1) - m2*g*sin(theta1 - 2*theta2) - 2*sin(theta1 - theta2)*m2"
        "*(theta2_dot**2*l2 + theta1_dot**2*l1*cos(theta1 - theta2)))"
        "/(l1*(2*m1 + m2 - m2*cos(2*theta1 - 2*theta2)))",
        "2*sin(theta1 - theta2)*(theta1_dot**2*l1*(m1 + m2) + g*(m1 + m2)*cos(theta1)"
        " + theta2_dot**2*l2*m2*cos(theta1 - theta2))/(l2*(2*m1 + m2 - m2*cos(2*theta1 - 2*theta2)))",
    ],
}


def of_equal_bobs(text: str) -> str:
    """What the double pendulum has, in the names of the n-pendulum of two bobs."""
    for i in (0, 1):
        text = text.replace(f"theta{i + 1}_dot", f"theta_dot_{i}").replace(f"theta{i + 1}", f"theta_{i}")
        text = text.replace(f"l{i + 1}", "l").replace(f"m{i + 1}", "m")
    return text


ACCELERATIONS["n_pendulum"] = [of_equal_bobs(text) for text in ACCELERATIONS["double_pendulum"]]

BODIES = {"free_particles": "xyz", "figure_eight": "xy", "solar_system": "xyz"}
"""Systems of three bodies that attract each other, with their coordinates."""

RIGID = {"foucault_gyroscope", "gravity_gradient", "kovalevskaya_top", "lagrange_top"}
"""Compared with closed forms and known integrals in ``tests/motions/test_bodies.py``."""

CONTACTS = {"newtons_cradle"}
"""Compared with other methods and a mirror image in ``tests/motions/test_contact_forces.py``."""


def test_every_shipped_system_is_compared():
    assert {*ACCELERATIONS, *BODIES, *RIGID, *CONTACTS} == set(NAMES)


@pytest.mark.exhaustive(keep=0.45)
@pytest.mark.parametrize("name", ACCELERATIONS)
def test_accelerations_are_the_known_ones(name):
    accelerations = equations_of(name).accelerations
    assert accelerations is not None and len(accelerations) == len(ACCELERATIONS[name])
    for found, known in zip(accelerations, ACCELERATIONS[name], strict=True):
        assert same(renamed(equations_of(name), found), known)


@pytest.mark.exhaustive(keep=0.6)
@pytest.mark.parametrize("name", BODIES)
def test_bodies_obey_newton(name):
    equations, axes = equations_of(name), len(BODIES[name])
    masses = [symbol for key, symbol in equations.parameters.items() if key.startswith("m")][:3]
    if name == "free_particles":  # the coordinates of one body after those of another
        bodies = [equations.q[i * axes : (i + 1) * axes] for i in range(3)]
        place = [[i * axes + axis for axis in range(axes)] for i in range(3)]
    else:
        bodies = [equations.q[i::3] for i in range(3)]
        place = [[axis * 3 + i for axis in range(axes)] for i in range(3)]
    G = sympy.Symbol("k") ** 2 if name == "solar_system" else sympy.Symbol("G")
    for i, here in enumerate(bodies):
        for axis in range(axes):
            pull = sympy.S.Zero
            for j, there in enumerate(bodies):
                if i != j:
                    distance = sympy.sqrt(sum((x - y) ** 2 for x, y in zip(here, there, strict=True)))
                    pull += G * masses[j] * (there[axis] - here[axis]) / distance**3
            assert same(acceleration(name, place[i][axis]), pull)


PRINTED = {
    "pendulum": ["l*theta_ddot + g*sin(theta) = 0"],
    "atwood": ["(m1 + m2)*x_ddot = (m1 - m2)*g"],
    "incline": ["s_ddot = g*sin(alpha)"],
    "parabola_bead": ["(1 + 4*k**2*x**2)*x_ddot + 4*k**2*x*x_dot**2 + 2*g*k*x = 0"],
    "rotating_hoop": ["a*theta_ddot + g*sin(theta) - a*omega**2*sin(theta)*cos(theta) = 0"],
    "rotating_rod": ["r_ddot - omega**2*r = 0"],
    "harmonic_oscillator": ["m*x_ddot + k*x = 0"],
    "gauge_oscillator": ["m*x_ddot + k*x = 0"],
    "central_force": ["r_ddot - r*theta_dot**2 + mu/r**2 = 0", "r**2*theta_ddot + 2*r*r_dot*theta_dot = 0"],
    "double_pendulum": [
        "(m1 + m2)*l1*theta1_ddot + m2*l2*cos(theta1 - theta2)*theta2_ddot"
        " + m2*l2*sin(theta1 - theta2)*theta2_dot**2 + (m1 + m2)*g*sin(theta1) = 0",
        "l1*cos(theta1 - theta2)*theta1_ddot + l2*theta2_ddot"
        " - l1*sin(theta1 - theta2)*theta1_dot**2 + g*sin(theta2) = 0",
    ],
    "spherical_pendulum": [
        "l*theta_ddot - l*sin(theta)*cos(theta)*phi_dot**2 + g*sin(theta) = 0",
        "sin(theta)**2*phi_ddot + 2*sin(theta)*cos(theta)*theta_dot*phi_dot = 0",
    ],
    "driven_damped_pendulum": ["m*l**2*theta_ddot + c*theta_dot + m*g*l*sin(theta) = m*g*l*A*cos(Omega*t)"],
    "charged_particle": ["m*x_ddot - e*B*y_dot = 0", "m*y_ddot + e*B*x_dot = 0", "z_ddot = 0"],
}


@pytest.mark.parametrize("name", PRINTED)
def test_equations_read_as_in_a_textbook(name):
    equations = equations_of(name)
    sides = [[render(s, Text(), equations.order) for s in (e.left, e.right)] for e in equations.equations]
    assert [" = ".join(pair) for pair in sides] == PRINTED[name]


def test_energies_of_the_double_pendulum():
    equations = equations_of("double_pendulum")
    assert same(
        equations.L,
        "(m1 + m2)*l1**2*theta1_dot**2/2 + m2*l2**2*theta2_dot**2/2"
        " + m2*l1*l2*theta1_dot*theta2_dot*cos(theta1 - theta2)"
        " + (m1 + m2)*g*l1*cos(theta1) + m2*g*l2*cos(theta2)",
    )


def test_double_pendulum_without_the_lower_mass():
    m2 = sympy.Symbol("m2")
    upper, lower = (acceleration("double_pendulum", index).subs(m2, 0) for index in (0, 1))
    assert same(upper, "-g*sin(theta1)/l1")
    # a test mass hung from a given motion of the upper bob
    carried = expression(
        "-(l1*cos(theta1 - theta2)*A1 - l1*sin(theta1 - theta2)*theta1_dot**2 + g*sin(theta2))/l2"
    )
    assert same(lower, carried.subs("A1", upper))


def test_hoop_has_no_time_left_and_keeps_h_but_not_the_energy():
    equations = equations_of("rotating_hoop")
    assert same(equations.h, "m*a**2*theta_dot**2/2 - m*a**2*omega**2*sin(theta)**2/2 - m*g*a*cos(theta)")
    assert all(
        equations.time not in e.free_symbols for e in (equations.L, equations.h, equation("rotating_hoop"))
    )
    assert [each.quantity for each in equations.conserved] == ["h"]
    (energy,) = equations.changing
    assert energy.quantity == "T + U"
    assert same(energy.rate, "2*m*a**2*omega**2*sin(theta)*cos(theta)*theta_dot")


def test_rod_keeps_h():
    equations = equations_of("rotating_rod")
    assert same(equations.h, "m*(r_dot**2 - omega**2*r**2)/2")
    assert [each.quantity for each in equations.conserved] == ["h"]


def test_central_force_keeps_the_angular_momentum():
    p_theta = next(c for c in equations_of("central_force").conserved if c.quantity == "p_theta")
    assert same(p_theta.expression, "m*r**2*theta_dot")
    assert "cyclic" in p_theta.because


def test_a_gauge_term_changes_p_and_h_but_not_the_equation():
    plain, gauged = equations_of("harmonic_oscillator"), equations_of("gauge_oscillator")
    assert plain.equations == gauged.equations
    assert same(gauged.momenta[0] - plain.momenta[0], "c*x*cos(w*t)")
    assert same(gauged.h - plain.h, "c*w*x**2*sin(w*t)/2")
    assert not gauged.conserved


@pytest.mark.exhaustive(keep=0.55)
def test_polar_and_cartesian_kepler_are_one_law():
    r, theta, r_dot, theta_dot = sympy.symbols("r theta r_dot theta_dot", positive=True)
    x, y = r * sympy.cos(theta), r * sympy.sin(theta)
    rates = {r: r_dot, theta: theta_dot}

    def d(e):
        return sum(e.diff(s) * v for s, v in rates.items())

    polar = [
        a.subs({s.name: s for s in (r, theta, r_dot, theta_dot)})
        for a in equations_of("central_force").accelerations
    ]
    rates |= {r_dot: polar[0], theta_dot: polar[1]}
    for found, coordinate in zip(equations_of("central_force_cartesian").accelerations, (x, y), strict=True):
        assert sympy.simplify(found.subs({"x": x, "y": y}) - d(d(coordinate))) == 0


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("name", NAMES)
def test_equations_are_those_of_the_chain_rule_applied_to_functions_of_time(name):
    """An independent derivation: q(t) as functions, dL/dv differentiated by t, nothing simplified."""
    model, equations = model_of(name), equations_of(name)
    t = model.time
    paths = [sympy.Function(f"path{index}")(t) for index in range(len(model.q))]
    along = {v: path.diff(t) for v, path in zip(model.v, paths, strict=True)}
    along |= dict(zip(model.q, paths, strict=True))
    lagrangian = model.lagrangian
    if lagrangian is None:
        lagrangian = -model.potential
        for particle in model.particles:
            lagrangian += particle.mass * sum(component**2 for component in particle.velocity) / 2
    back = {path.diff(t, 2): a for path, a in zip(paths, equations.a, strict=True)}
    then = {path.diff(t): v for path, v in zip(paths, model.v, strict=True)}
    last = dict(zip(paths, model.q, strict=True))
    for q, v, given, each in zip(
        model.q, model.v, model.generalized_forces, equations.equations, strict=True
    ):
        raw = lagrangian.diff(v).subs(along).diff(t).subs(back).subs(then).subs(last)
        raw += model.dissipation.diff(v) - lagrangian.diff(q) - given
        assert agree_at_random(raw, each.factor * (each.left - each.right))


def test_particle_forces_enter_by_dalembert():
    equations = derived(
        """
        parameters: {m: 1, l: 1, F: 2}
        coordinates: {theta: {initial: 0.1}}
        masses: {bob: m}
        embedding:
          bob: [l*sin(theta), -l*cos(theta)]
        forces:
          bob: [F, 0]
        """
    )
    assert same(equations.generalized_forces[0], "F*l*cos(theta)")
    assert same(equations.accelerations[0], "F*cos(theta)/(m*l)")


def test_common_factors_of_sums_are_cancelled():
    equations = derived(
        """
        parameters: {m1: 1, m2: 1, g: 9.81, l: 1}
        coordinates: {theta: {initial: 0.1}}
        masses: {a: m1, b: m2}
        embedding:
          a: [l*sin(theta), -l*cos(theta)]
          b: [-l*sin(theta), -l*cos(theta)]
        potential: m1*g*a.y + m2*g*b.y
        """
    )
    assert render(equations.accelerations[0], Text(), equations.order) == "-g*sin(theta)/l"


def test_what_is_coupled_beyond_reading_is_left_as_a_matrix():
    names = [f"q{i}" for i in range(5)]
    x = " + ".join(f"sin({name})" for name in names)
    equations = derived(
        "coordinates: {" + ", ".join(f"{name}: {{initial: 0.1}}" for name in names) + "}\n"
        "masses: {a: 1, b: 2, c: 3, d: 4, e: 5}\n"
        "embedding:\n"
        + "".join(
            f"  {body}:\n    - {' + '.join(f'sin({n})' for n in names[: k + 1])}\n"
            f"    - {' + '.join(f'cos({n})' for n in names[: k + 1])}\n"
            for k, body in enumerate("abcde")
        )
        + f"potential: {x}\n"
    )
    assert equations.accelerations is None
    assert len(equations.mass_matrix) == 5
    assert same(equations.mass_matrix[0][4], "5*cos(q0 - q4)")


def test_squares_of_sums_stay_in_the_potential_and_are_derived_all_the_same():
    equations = derived(
        """
        parameters: {m: 1, k: 3, l: 1}
        coordinates: {x1: {initial: 1}, x2: {initial: 2}}
        masses: {a: m, b: m}
        embedding: {a: [x1], b: [x2]}
        potential: k*(x1 - l)**2/2 + k*(x2 - x1 - l)**2/2
        """
    )
    assert render(equations.U, Text(), equations.order) == "k*(x1 - l)**2/2 + k*(x2 - l - x1)**2/2"
    assert same(equations.L, "m*x1_dot**2/2 + m*x2_dot**2/2 - k*(x1 - l)**2/2 - k*(x2 - x1 - l)**2/2")
    assert same(equations.equations[0].left - equations.equations[0].right, "m*x1_ddot + 2*k*x1 - k*x2")


def test_a_distance_in_polar_coordinates_is_contracted():
    equations = derived(
        """
        parameters: {m: 1, k: 3, l: 1}
        coordinates: {r: {initial: 1}, phi: {initial: 2}}
        masses: {a: m}
        embedding: {a: "(r*cos(phi), r*sin(phi))"}
        potential: k*(norm(a) - l)**2/2
        """
    )
    assert render(equations.U, Text(), equations.order) == "k*(sqrt(r**2) - l)**2/2"
    assert {each.quantity for each in equations.conserved} == {"p_phi", "h"}


def test_two_bodies_in_coordinates_of_their_centre_of_mass():
    """L. D. Landau and E. M. Lifshitz, Mechanics, section 13: T has the reduced mass, U the distance."""
    equations = derived(
        """
        parameters: {m1: 1, m2: 2, G: 1}
        coordinates: [R, r, phi]
        masses: {a: m1, b: m2}
        embedding:
          a: [R - m2/(m1 + m2)*r*cos(phi), -m2/(m1 + m2)*r*sin(phi)]
          b: [R + m1/(m1 + m2)*r*cos(phi), m1/(m1 + m2)*r*sin(phi)]
        potential: -G*m1*m2/norm(a - b)
        """
    )
    assert render(equations.U, Text(), equations.order) == "-m1*m2*G/sqrt(r**2)"


def test_a_given_lagrangian_stays_as_it_was_written():
    equations = derived(
        """
        parameters: {A: 1, C: 2, k: 1}
        coordinates: {phi: {initial: 0}, theta: {initial: 0.4}, psi: {initial: 0}}
        lagrangian: >-
          A/2*(theta_dot**2 + phi_dot**2*sin(theta)**2) + C/2*(psi_dot + phi_dot*cos(theta))**2 - k*cos(theta)
        """
    )
    assert "C*(cos(theta)*phi_dot + psi_dot)**2/2" in render(equations.L, Text(), equations.order)
    assert same(equations.momenta[2], "C*(psi_dot + phi_dot*cos(theta))")
    assert {each.quantity for each in equations.conserved} == {"p_phi", "p_psi", "h"}


def test_a_lagrangian_that_is_not_quadratic_in_the_velocity():
    equations = derived(
        """
        parameters: {m: 1, c: 10, k: 1}
        coordinates: {x: {initial: 1}}
        lagrangian: -m*c**2*sqrt(1 - x_dot**2/c**2) - k*x**2/2
        """
    )
    assert same(equations.accelerations[0] / expression("(1 - x_dot**2/c**2)**(3/2)"), "-k*x/m")
    assert render(equations.momenta[0], Text(), equations.order) == "m*x_dot/sqrt(1 - x_dot**2/c**2)"


@pytest.mark.exhaustive(keep=0.55)
def test_what_is_too_large_to_simplify_is_still_right(monkeypatch):
    short = equations_of("double_pendulum")  # cached for other tests: not to be made under these limits
    monkeypatch.setattr(canonical, "LARGEST", 1)
    monkeypatch.setattr(monomials, "LARGEST", 1)
    raw = derive_equations(model_of("double_pendulum"))
    assert raw.L != short.L and same(raw.L, short.L)
    assert same(raw.h, short.h)
    for index, symbol in enumerate(short.a):
        each = raw.equations[index]
        known = dict(zip(short.a, short.accelerations, strict=True))
        assert agree_at_random(each.left.subs(known), each.right)
        assert same(raw.mass_matrix[index][index], short.mass_matrix[index][index])
        assert each.left.has(symbol)
