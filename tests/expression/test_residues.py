"""Values modulo a prime: identities hold there, too, and nothing else vanishes."""

from __future__ import annotations

import math
import random
from fractions import Fraction

import pytest

from lagrange_cli.expression.build import build
from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.modular import Equations, fraction_of, solved
from lagrange_cli.expression.node import reachable
from lagrange_cli.expression.parse import parse
from lagrange_cli.expression.residues import LARGE, SMALL, NoValue, Residues
from lagrange_cli.expression.written import as_written
from lagrange_cli.mechanics.conserved.recognition import Recognition

IDENTITIES = [
    "sin(x)**2 + cos(x)**2 - 1",
    "sin(x + y) - sin(x)*cos(y) - cos(x)*sin(y)",
    "cos(3*x/2) - 4*cos(x/2)**3 + 3*cos(x/2)",
    "tan(2*x) - 2*tan(x)/(1 - tan(x)**2)",
    "exp(x - 2*y)*exp(2*y)/exp(x) - 1",
    "cosh(x)**2 - sinh(x)**2 - 1",
    "sqrt(x**2 + y**2)**2 - x**2 - y**2",
    "x**(1/3)*x**(2/3) - x",
    "x**(5/6)/x**(1/3) - sqrt(x)",
    "exp(log(x) + y) - x*exp(y)",
    "(sqrt(3)*x + y)*(sqrt(3)*x - y) - 3*x**2 + y**2",
    "asin(x)*y - y*asin(x)",
]
WRONG = [
    "sin(x)**2 - cos(x)**2",
    "sin(x + y) - sin(x) - sin(y)",
    "exp(x)*exp(y) - exp(x - y)",
    "sqrt(x*y + y) - sqrt(y)*sqrt(x + 1)",
    "x**(1/3) - x**(1/5)",
    "asin(x) - acos(x)",
    "0.1*x*(1 + y) - 0.10000001*x - 0.1*x*y",
    "pi*x - 22*x/7",
]


def values(text, prime, tries=40):
    """Of an expression, at random states that have one."""
    algebra = GraphAlgebra()
    node = build(parse(text), algebra.symbol, algebra)
    found = []
    for seed in range(tries):
        residues = Residues(prime, random.Random(seed))
        try:
            found.append(
                residues.values(reachable([node]), {"x": residues.random(), "y": residues.random()})[node]
            )
        except NoValue:
            continue
    assert len(found) > tries // 8
    return found


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("prime", [SMALL, LARGE])
def test_identities(prime):
    for text in IDENTITIES:
        assert not any(values(text, prime)), text
    for text in WRONG:
        assert any(values(text, prime)), text


@pytest.mark.exhaustive(keep=0.55)
def test_roots_of_different_numbers_have_signs_of_their_own():
    """sqrt(x*y + y) - sqrt(y)*sqrt(x + 1) vanishes on one branch: at about half of the states here."""
    found = values("sqrt(x*y + y) - sqrt(y)*sqrt(x + 1)", LARGE, tries=200)
    assert len(found) / 4 < sum(one == 0 for one in found) < len(found) * 3 / 4


@pytest.mark.parametrize("prime", [SMALL, LARGE])
def test_primes(prime):
    assert all(pow(a, prime - 1, prime) == 1 for a in range(2, 50))
    assert prime % 4 == 3
    assert all((prime - 1) % n for n in (3, 5, 7, 11, 13))
    assert all(pow(a, (prime - 1) // 2, prime) == 1 for a in (2, 3, 5))


def test_fractions_are_found_again():
    source = random.Random(1)
    for _ in range(50):
        given = Fraction(source.randint(-(10**60), 10**60), source.randint(1, 10**60))
        assert fraction_of(given.numerator * pow(given.denominator, -1, LARGE), LARGE) == given


def test_linear_equations():
    source, p = random.Random(2), SMALL
    unknown = [source.randrange(p) for _ in range(6)]
    matrix = [[source.randrange(p) for _ in unknown] for _ in unknown]
    right = [sum(a * x for a, x in zip(row, unknown)) % p for row in matrix]
    assert solved(matrix, right, p) == unknown
    equations = Equations(6, p)
    assert [equations.add(row) for row in (*matrix[:4], matrix[0])] == [True] * 4 + [False]
    solutions = equations.solutions()
    assert len(solutions) == len(equations.free) == 2
    for vector in solutions:
        assert not any(sum(row[j] * x for j, x in vector.items()) % p for row in matrix[:4])


def test_coefficients_are_recognized():
    algebra = GraphAlgebra()
    a, b = algebra.symbol("a"), algebra.symbol("b")
    recognition = Recognition(algebra.graph, (a, b), LARGE)
    expected = [(a - b) * (4.0 * a + b), 2.0 * a**3 / b, b + 3.0, algebra.graph.constant(5.0)]
    below = reachable(expected)
    at = Residues(LARGE, random.Random(0)).values(below, recognition.values)
    found = recognition.coefficients([at[one] for one in expected])
    assert found is not None
    ratio = found[-1] / expected[-1]
    for one, other in zip(found, expected):
        nodes = [one - ratio * other]
        assert Residues(LARGE, random.Random(3)).values(reachable(nodes), {"a": 17, "b": 101})[nodes[0]] == 0
    assert recognition.coefficients([at[a] ** 7 + at[b] * 12345 + 1]) is None


@pytest.mark.parametrize("number", [1.2345678901234567e-200, 1.2345678901234567e300, 7.654321098765432e-305])
def test_numbers_whose_squares_are_no_doubles_are_what_they_are(number):
    fraction, root, turns = as_written(number)
    assert not root and float(fraction) * math.pi**turns == pytest.approx(number, rel=1e-14, abs=0)
