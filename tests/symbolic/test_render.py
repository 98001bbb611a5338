"""One walk, four notations."""

from textwrap import dedent

import pytest
import sympy

from lagrange_cli.run.equations import derive
from lagrange_cli.spec.read import read_spec
from lagrange_cli.symbolic.latex import Latex
from lagrange_cli.symbolic.mathml import MathML
from lagrange_cli.symbolic.notations import Identifiers, Notation, Text, Unicode, identifiers
from lagrange_cli.symbolic.order import Order, Role
from lagrange_cli.symbolic.render import render
from tests.support.systems import agree_at_random, expression

ROLES = {
    Role.PARAMETER: ("m", "m1", "m2", "g", "l", "a", "omega", "lambda_1", "mass"),
    Role.TIME: ("t",),
    Role.COORDINATE: ("theta", "theta1", "theta2", "x", "q_no"),
    Role.VELOCITY: ("theta_dot", "theta1_dot", "x_dot"),
    Role.ACCELERATION: ("theta_ddot", "theta1_ddot", "x_ddot"),
}
ORDER = Order({sympy.Symbol(n): (role, i) for role, names in ROLES.items() for i, n in enumerate(names)})

LARGE = sympy.Integer(1_200_000_000_000_000_001) ** sympy.Rational(7, 10)


def shown(value: sympy.Expr | str, notation: Notation) -> str:
    return render(expression(value), notation, ORDER)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (sympy.Rational("0.5") * sympy.Symbol("m"), "m/2"),
        (sympy.Rational("9.81") * sympy.Symbol("m"), "9.81*m"),
        (sympy.Rational("6.674e-11") * sympy.Symbol("m"), "6.674e-11*m"),
        (sympy.Rational("0.2"), "1/5"),
        (sympy.Rational("0.3"), "0.3"),
        (sympy.Rational(1, 3), "1/3"),
        (-sympy.Rational(3, 2), "-3/2"),
        ("0", "0"),
        ("m*g*l*cos(theta)", "m*g*l*cos(theta)"),
        ("theta_dot**2*m*l**2/2", "m*l**2*theta_dot**2/2"),
        ("-g*sin(theta)/l", "-g*sin(theta)/l"),
        ("(m1 - m2)*g/(m1 + m2)", "(m1 - m2)*g/(m1 + m2)"),
        ("1/(m*l**2)", "1/(m*l**2)"),
        ("x**(-3/2)", "1/x**(3/2)"),
        ("1/sqrt(x)", "1/sqrt(x)"),
        ("x - l", "x - l"),
        ("theta2 - theta1", "theta2 - theta1"),
        ("x + m*x_ddot - x_dot", "m*x_ddot - x_dot + x"),
        ("exp(-x)*pi*x", "pi*x*exp(-x)"),
        ("atan2(x, l)", "atan2(x, l)"),
        ("(-x)**m", "(-x)**m"),
        ("m**(x + 1)", "m**(1 + x)"),
        ("x**(3/10)*m**x", "m**x*x**0.3"),
        ("(x + l)**(-5/2)", "1/(l + x)**(5/2)"),
        ("-m*(x + l)", "-m*(l + x)"),
    ],
)
def test_plain_text(value, text):
    assert shown(value, Text()) == text
    assert agree_at_random(expression(text), expression(value), digits=14)


def test_a_file_without_decimals_is_answered_with_fractions():
    """A ball that rolls in a bowl has T = 7/10 m (R - r)^2 theta_dot^2: J = 2/5 m r^2."""
    text = """
        parameters: {m: 1, R: 1.5, r: 0.25, g: 9.81}
        coordinates: {th: {initial: 0.5}}
        bodies:
          ball:
            mass: m
            solid: {sphere: r}
            position: [(R - r)*sin(th), 0, -(R - r)*cos(th)]
            orientation: {euler: [0, -th*(R - r)/r, 0], sequence: zyz}
        potential: 3/10*g*m*ball.z
        """
    fractions, decimals = "7*m*(R - r)**2*th_dot**2/10 + 3*m", "0.7*m*(R - r)**2*th_dot**2 + 0.3*m"
    for given, start in (("3/10", fractions), ("0.3", decimals)):
        equations = derive(read_spec(dedent(text).replace("3/10", given), "bowl.yaml")).equations
        assert render(equations.L, Text(), equations.order).startswith(start)


@pytest.mark.exhaustive(keep=0.7)
def test_decimals_do_not_become_long_integers():
    """A rotating pendulum with a small moment of inertia about its rod."""
    text = """
        parameters: {m: 0.1, l: 0.3, a: 0.25, J: 0.002, g: 9.81}
        coordinates: {p: {initial: 1}, b: {initial: 0.5}}
        lagrangian: >
          (0.003 + m*a**2 + m*l**2*sin(b)**2 + 1e-9*cos(b)**2)*p_dot**2/2 + (m*l**2 + J + 1.5e-4)*b_dot**2/2
          + m*a*l*cos(b)*p_dot*b_dot - m*g*l*cos(b)
        """
    equations = derive(read_spec(dedent(text), "furuta.yaml")).equations
    momentum = render(equations.momenta[1], Text(), equations.order)
    assert momentum == "m*l*a*cos(b)*p_dot + (0.00015 + m*l**2 + J)*b_dot"
    assert equations.accelerations is not None
    for found in (*(each.left for each in equations.equations), *equations.accelerations):
        assert max(abs(number) for number in found.atoms(sympy.Rational)) < 1000
    rates = sympy.Matrix(equations.mass_matrix) * sympy.Matrix(equations.accelerations)
    balance = rates - sympy.Matrix(equations.force)
    values = {one: sympy.Rational(1, 3 + n) for n, one in enumerate(sorted(balance.free_symbols, key=str))}
    assert max(abs(one.evalf(30, subs=values, maxn=60)) for one in balance) < 1e-25


@pytest.mark.parametrize(
    ("value", "text"),
    [
        ("m*l**2*theta_dot**2/2", "m l² θ̇²/2"),
        ("theta1_ddot", "θ̈₁"),
        ("sin(theta)**2*omega", "ω sin²(θ)"),
        ("x - sqrt(x + 1)", "x − √(1 + x)"),
        ("-x", "−x"),
        (sympy.Rational("6.674e-11"), "6.674·10⁻¹¹"),
        ("mass*x", "mass x"),
        ("q_no", "q_no"),
    ],
)
def test_unicode(value, text):
    assert shown(value, Unicode()) == text


@pytest.mark.parametrize(
    ("value", "text"),
    [
        ("m*l**2*theta_dot**2/2", r"\frac{1}{2} m l^{2} \dot{\theta}^{2}"),
        ("theta1_ddot", r"\ddot{\theta}_{1}"),
        ("lambda_1*mass", r"\lambda_{1} \mathrm{mass}"),
        ("sin(theta)**2", r"\sin^{2} \theta"),
        ("sin(theta1)*cos(2*theta)*x", r"x \cos(2 \theta) \sin \theta_{1}"),
        ("sin(x/l)", r"\sin\left(\frac{x}{l}\right)"),
        ("(x + l)/(m + m1)", r"\frac{l + x}{m + m_{1}}"),
        ("(x + l)/2", r"\frac{1}{2} l + \frac{1}{2} x"),
        (sympy.Mul(sympy.Rational(1, 2), sympy.Symbol("x") + 1, evaluate=False), r"\frac{1}{2} (1 + x)"),
        ("-sqrt(x/l)", r"-\sqrt{\frac{x}{l}}"),
        ("asin(x)*exp(-x)", r"e^{-x} \arcsin x"),
        ("2*x*(m1 + m2)", r"2 (m_{1} + m_{2}) x"),
        (sympy.Rational("6.674e-11"), r"6.674 \cdot 10^{-11}"),
        ("pi*x", r"\pi x"),
        ("x**(5/2)", r"x^{\frac{5}{2}}"),
        (LARGE, r"(1.2 \cdot 10^{18})^{0.7}"),
    ],
)
def test_latex(value, text):
    assert shown(value, Latex()) == text


@pytest.mark.parametrize(
    ("notation", "text"),
    [
        (Text(), "1.2e18**0.7*x"),
        (Unicode(), "(1.2·10¹⁸)^0.7 x"),
        (MathML(), "<mo>(</mo><mrow><mrow><mn>1.2</mn>"),
    ],
)
def test_a_power_of_ten_in_a_power_is_in_parentheses(notation, text):
    assert text in shown(LARGE * sympy.Symbol("x"), notation)


@pytest.mark.parametrize(("notation", "power"), [(Latex(), "e^{-x}"), (MathML(), "<msup><mi>e</mi>")])
def test_exp_is_no_power_of_what_a_file_calls_e(notation, power):
    value = expression("exp(-x)")
    assert power in render(value, notation, ORDER)
    named = Order(ORDER.ranks | {sympy.Symbol("e"): (Role.PARAMETER, 20)})
    assert power not in render(value, notation, named) and "exp" in render(value, notation, named)


def test_python_avoids_its_own_words():
    symbols = sympy.symbols("lambda q x")
    assert (
        render(sympy.Add(*symbols), Identifiers(identifiers(map(str, symbols), {"q"})), order_of(symbols))
        == "lambda_ + q_ + x"
    )


def order_of(symbols: tuple[sympy.Symbol, ...]) -> Order:
    return Order({symbol: (Role.COORDINATE, index) for index, symbol in enumerate(symbols)})
