"""Kinetic energies and equations in curvilinear coordinates have the form that textbooks give."""

import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

from lagrange_cli.run.equations import as_written, derive
from lagrange_cli.symbolic import common_denominators
from lagrange_cli.symbolic.canonical import contract, to_terms
from lagrange_cli.symbolic.common_denominators import over_one_denominator
from lagrange_cli.symbolic.grouping import group, tidy
from lagrange_cli.symbolic.monomials import TooLargeError, from_terms, term
from lagrange_cli.symbolic.notations import Text
from lagrange_cli.symbolic.render import render
from lagrange_cli.symbolic.squares import shortest
from tests.support.draws import examples
from tests.support.motion import spec_of
from tests.support.systems import agree_at_random, derived, expression

BIPOLAR = "a*sinh(v)/(cosh(v) - cos(u)), a*sin(u)/(cosh(v) - cos(u))"
STEREOGRAPHIC = "2*a*u/(1 + u**2 + v**2), 2*a*v/(1 + u**2 + v**2), a*(1 - u**2 - v**2)/(1 + u**2 + v**2)"
COORDINATES = {
    "torus": ("(a + b*cos(v))*cos(u), (a + b*cos(v))*sin(u), b*sin(v)", "(a + b*cos(v))**2", "b**2"),
    "elliptic": ("a*cosh(u)*cos(v), a*sinh(u)*sin(v)", *["a**2*(sinh(u)**2 + sin(v)**2)"] * 2),
    "parabolic": ("u*v, (u**2 - v**2)/2", "(u**2 + v**2)", "(u**2 + v**2)"),
    "bipolar": (BIPOLAR, *["a**2/(cosh(v) - cos(u))**2"] * 2),
    "stereographic": (STEREOGRAPHIC, *["4*a**2/(1 + u**2 + v**2)**2"] * 2),
    "inverse radius": ("cos(v)/u, sin(v)/u", "u**(-4)", "u**(-2)"),
    "catenoid": ("a*cosh(u)*cos(v), a*cosh(u)*sin(v), a*u", "a**2*cosh(u)**2", "a**2*cosh(u)**2"),
    "pseudosphere": (
        "a*cos(v)/cosh(u), a*sin(v)/cosh(u), a*(u - tanh(u))",
        "a**2*sinh(u)**2/cosh(u)**2",
        "a**2/cosh(u)**2",
    ),
    "helicoid": ("u*cos(v), u*sin(v), a*v", "1", "(a**2 + u**2)"),
}
"""Positions, and the squares of Lame's coefficients: T = m (g_uu u_dot^2 + g_vv v_dot^2)/2."""


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("name", COORDINATES)
def test_metrics_of_curvilinear_coordinates(name):
    position, along_u, along_v = COORDINATES[name]
    equations = derived(
        f"""
        parameters: {{a: 2, b: 0.5, m: 1}}
        coordinates: {{u: {{initial: 0.5}}, v: {{initial: 0.4}}}}
        masses: {{p: m}}
        embedding: {{p: [{position}]}}
        """
    )
    for momentum, velocity, metric in zip(equations.momenta, equations.v, (along_u, along_v)):
        written = render(momentum, Text(), equations.order)
        expected = expression(f"m*({metric})*{velocity}")
        assert written == render(expected, Text(), equations.order)


@pytest.mark.parametrize(
    ("potential", "written"),
    [
        ("k*(x**2 - 2*l*x + l**2)/2", "k*(l - x)**2/2"),
        ("m*g*(l*cos(y) + x*cos(y))", "m*g*(l + x)*cos(y)"),
        ("k*(1 + 2*cos(x) + cos(x)**2)", "k*(1 + cos(x))**2"),
        ("k*x**2 + k*x*y + k*y**2", "k*x**2 + k*x*y + k*y**2"),
    ],
)
def test_potentials(potential, written):
    equations = derived(
        f"""
        parameters: {{k: 3, l: 1, m: 1, g: 9}}
        coordinates: {{x: {{initial: 1}}, y: {{initial: 2}}}}
        masses: {{p: m}}
        embedding: {{p: [x, y]}}
        potential: {potential}
        """
    )
    assert render(equations.U, Text(), equations.order) == written


def test_equations_are_freed_from_denominators_that_all_terms_have():
    equations = derived(
        """
        parameters: {m: 1}
        coordinates: {u: {initial: 1}, phi: {initial: 2}}
        masses: {p: m}
        embedding: {p: [cos(phi)/u, sin(phi)/u]}
        """
    )
    lines = [render(each.left, Text(), equations.order) for each in equations.equations]
    assert lines == ["u*u_ddot - 2*u_dot**2 + u**2*phi_dot**2", "u*phi_ddot - 2*u_dot*phi_dot"]
    assert [str(each.factor) for each in equations.equations] == ["m/u**5", "m/u**3"]


whole = [
    "a",
    "2",
    "x",
    "y",
    "(a + x)",
    "sin(x)",
    "cos(x)",
    "tan(x)",
    "cos(y)",
    "cosh(y)",
    "sinh(y)",
    "tanh(y)",
]
products = st.lists(st.sampled_from([*whole, "1/(a + x)"]), min_size=1, max_size=5)
terms_of_pieces = st.lists(st.tuples(st.integers(-3, 3), products), min_size=1, max_size=5)


def sum_of(drawn: list[tuple[int, list[str]]]) -> sympy.Expr:
    return expression(" + ".join(f"({c})*{'*'.join(factors)}" for c, factors in drawn))


@pytest.mark.exhaustive(keep=0.6)
@examples(30)
@given(terms_of_pieces)
def test_every_form_has_the_same_value(drawn):
    given = sum_of(drawn)
    terms = contract(to_terms(given))
    assert agree_at_random(given, from_terms(shortest(terms)))
    joined = over_one_denominator(terms)
    if joined is not None:
        numerator, denominator = joined
        assert agree_at_random(given, from_terms(numerator) * term(denominator))


def test_fractions_stay_apart_where_one_denominator_would_be_too_long(monkeypatch):
    def refused(*given):
        raise TooLargeError

    monkeypatch.setattr(common_denominators, "multiply", refused)
    with pytest.raises(TooLargeError):
        over_one_denominator(to_terms(expression("x/(x + y) + y/(x + y)**2")))
    given = expression("x/(x + y) + y/(x + y)**2")
    file = "coordinates: {x: {initial: 1}, y: {initial: 1}}\nlagrangian: x_dot**2 + y_dot**2"
    assert agree_at_random(given, group(to_terms(given), derived(file).order))


@pytest.mark.exhaustive(keep=0.6)
@examples(20)
@given(
    st.lists(st.tuples(st.integers(1, 4), st.sampled_from(whole)), min_size=2, max_size=3), st.integers(2, 3)
)
def test_powers_of_sums_are_found(drawn, exponent):
    base = sympy.Add(*(c * expression(text) for c, text in drawn))
    file = "coordinates: {x: {initial: 1}, y: {initial: 1}}\nlagrangian: x_dot**2 + y_dot**2"
    expanded = sympy.expand(base**exponent)
    found = tidy(expanded, derived(f"{file}\nparameters: {{a: 1}}\n").order)
    assert agree_at_random(expanded, found)
    if not base.has(sympy.Function):
        assert not found.is_Add


def test_a_sum_of_negative_terms_has_its_sign_in_front():
    spec = spec_of("""
        parameters: {R: 1, r: 0.2, g: 9.81}
        coordinates: {theta: {initial: 0.1}, phi: {initial: 0}}
        lagrangian: (theta_dot**2 + phi_dot**2)/2 - g*cos(theta)
        nonholonomic: {rolling: r*phi_dot - (R + r)*theta_dot}
        """)
    assert "= -(R + r)*lambda_rolling   [theta]" in as_written(derive(spec), "text", "lagrange", {})


def test_a_difference_of_parameters_has_the_direction_of_the_file():
    """A ball in a bowl, whose radius is the greater one, though it is the later one in the file."""
    spec = spec_of("""
        parameters: {a: 0.1, R: 1, m: 1, g: 9.81}
        coordinates: {theta: {initial: 0.5}}
        lagrangian: 7*m*(R - a)**2*theta_dot**2/10 + m*g*(R - a)*cos(theta)
        """)
    text = as_written(derive(spec), "text", "lagrange", {})
    assert "a - R" not in text
    assert "p_theta = 7*(R - a)**2*m*theta_dot/5" in text
    assert "theta_ddot = -5*g*sin(theta)/(7*(R - a))" in text


def test_an_exponential_of_time_is_divided_out():
    """The damped oscillator by a Lagrangian (Goldstein, Poole and Safko, 3rd ed., derivation 2.14)."""
    spec = spec_of("""
        parameters: {m: 1, k: 4, gamma: 0.5}
        coordinates: {q: {initial: 1}}
        lagrangian: exp(gamma*t)*(m*q_dot**2/2 - k*q**2/2)
        """)
    line = "m*q_ddot + m*gamma*q_dot + k*q = 0   [q, divided by exp(gamma*t)]"
    assert line in as_written(derive(spec), "text", "lagrange", {})


@pytest.mark.exhaustive(keep=0.35)
def test_what_all_terms_share_is_factored_out():
    """The restricted problem of three bodies (Szebehely, Theory of Orbits, 1967, section 1.5), and a cylinder
    that rolls within another one."""
    text = """
        parameters: {mu: 0.0121}
        coordinates: {x: {initial: 0.5}, y: {initial: 0}}
        lagrangian: >-
          ((x_dot - y)**2 + (y_dot + x)**2)/2
          + (1 - mu)/sqrt((x + mu)**2 + y**2) + mu/sqrt((x - 1 + mu)**2 + y**2)
        """
    line = "x_ddot - 2*y_dot - x + (1 - mu)*(mu + x)/(y**2 + (mu + x)**2)**(3/2)\n"
    assert line in as_written(derive(spec_of(text)), "text", "lagrange", {})
    text = """
        parameters: {R: 1, a: 0.2, m: 1, M: 3, g: 9.81}
        coordinates: {psi: {initial: 0}, theta: {initial: 0.4}}
        lagrangian: >-
          R**2*(m + M)*psi_dot**2 + (R - a)**2*m*theta_dot**2 + (R - a)*m*g*cos(theta)
          - R*(R - a)*m*(1 - cos(theta))*psi_dot*theta_dot
        """
    line = "2*R*(m + M)*psi_ddot - (R - a)*m*(1 - cos(theta))*theta_ddot\n"
    assert line in as_written(derive(spec_of(text)), "text", "lagrange", {})
