"""What is proven to be identically 0, and what only vanishes at many arguments."""

from __future__ import annotations

import pytest

from lagrange_cli.expression.build import build
from lagrange_cli.expression.exact import ExactGraphAlgebra
from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.parse import parse
from lagrange_cli.expression.zero import is_zero

ALGEBRAS = [GraphAlgebra, ExactGraphAlgebra]


def vanishes(text, algebra=GraphAlgebra):
    made = algebra()
    return is_zero(build(parse(text), made.symbol, made))


@pytest.mark.exhaustive(keep=28)
@pytest.mark.parametrize("algebra", ALGEBRAS)
@pytest.mark.parametrize(
    "text",
    [
        "sin(x + y) - sin(x)*cos(y) - cos(x)*sin(y)",
        "tan(x)*cos(x) - sin(x)",
        "cosh(x)**2 - sinh(x)**2 - 1",
        "tanh(1e6*x)*cosh(1e6*x) - sinh(1e6*x)",
        "exp(exp(9*x))**2 - exp(2*exp(9*x))",
        "1/(x - y) + 1/(y - x)",
        "(x + y)**3 - x**3 - 3*x**2*y - 3*x*y**2 - y**3",
        "sin(sqrt(x))**2 + cos(sqrt(x))**2 - 1",
        "sqrt((x + y)**2 + z) - sqrt(x**2 + 2*x*y + y**2 + z)",
        "log((x + y)**3 + 1) - log(x**3 + 3*x**2*y + 3*x*y**2 + y**3 + 1)",
        "(x**y)*x - x**(y + 1)",
        "x**1.5 - x*sqrt(x)",
        "(atan(1/x) + sin(y + z))**2 - (atan(1/x) + sin(y)*cos(z) + cos(y)*sin(z))**2",
        "0.1*sin(x + y) + 0.2*(sin(x)*cos(y) + cos(x)*sin(y)) - 0.3*sin(x + y)",
        "cos(x) + cos(x + 2*pi/3) + cos(x - 2*pi/3)",
        "cos(x + pi/4) - (cos(x) - sin(x))/sqrt(2)",
        "sin(1/3*x + 2*x/3 + y) - sin(x)*cos(y) - cos(x)*sin(y)",
        "1e-200*(sin(x + y) - sin(x)*cos(y) - cos(x)*sin(y))",
    ],
)
def test_identities_are_proven(text, algebra):
    assert vanishes(text, algebra)


@pytest.mark.parametrize("algebra", ALGEBRAS)
@pytest.mark.parametrize(
    "text",
    [
        "x - 5 + sqrt((x - 5)**2)",
        "x - 5 + ((x - 5)**4)**0.25",
        "x - 5 + ((x - 5)**2*(1 + y**2))**0.5/sqrt(1 + y**2)",
        "x - 5 + sqrt((x - 5)**2 + 0*y)",
        "x - 5 + ((x - 5)**2)**(y/(2*y))",
        "x - 30 + (1 + ((x - 30)**2)**1.5 - 1)/(x - 30)**2",
        "sqrt(x**2 - 2*x*y + y**2)*(x - y) - (x - y)**2",
        "log(exp(x)) - log((exp(x) - 100)**2)/2",
        "atan(tan(x)) - x",
        "asin(sin(x)) - x",
        "acos(cos(x)) - sqrt(x**2)",
        "atan2(sin(x), cos(x)) - x",
        "atan(1/(x - 7)) + atan(x - 7) + pi/2",
        "cos(x/100) - 1 + (x/100)**2/2 - (x/100)**4/24 + (x/100)**6/720",
        "sin(0.001*sin(0.001*sin(0.001*x))) - 0.001*sin(0.001*sin(0.001*x))",
        "((1 - tanh(x)**2)**30)**30",
        "((1 - tanh(1e9*x)**2)**30)**30",
        "(sin(x)**2 + cos(x)**4 - cos(x)**2 - sin(x)**4 + 1e-3*x)**64",
        "exp(-1e9*(x - 9)**2) + exp(-exp(30 + x**2))",
        "1e-300*x**30",
        "cos(x + 3.141592653) + cos(x)",
        "sin(1e40*x)",
        "sqrt(x + 1e-30) - sqrt(x)",
    ],
)
def test_what_only_vanishes_here_and_there_is_not_zero(text, algebra):
    assert not vanishes(text, algebra)


def test_a_large_sum_is_not_worked_on_for_ever():
    powers = " + ".join(f"sin({k}*x + y) - sin({k}*x)*cos(y) - cos({k}*x)*sin(y)" for k in range(1, 40))
    assert vanishes(powers)
    made = GraphAlgebra()
    made.graph.work.most = made.graph.work.spent + 20_000
    assert not is_zero(build(parse(powers), made.symbol, made))
    assert made.graph.work.spent < 20_000
