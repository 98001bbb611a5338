"""Contractions are exact, end, and give what a textbook writes."""

import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from lagrange_cli.symbolic.canonical import contract, to_terms
from lagrange_cli.symbolic.monomials import LARGEST, TooLargeError, from_terms
from tests.support.systems import agree_at_random, expression


def contracted(text: str) -> sympy.Expr:
    return from_terms(contract(to_terms(expression(text))))


@pytest.mark.parametrize(
    ("long", "short"),
    [
        ("m*sin(a)**2 + m*cos(a)**2", "m"),
        ("3*sin(a)**2 + cos(a)**2", "1 + 2*sin(a)**2"),
        ("m - m*sin(a)**2", "m*cos(a)**2"),
        ("m1 + m2 - m2*cos(a)**2", "m1 + m2*sin(a)**2"),
        ("k*cosh(a)**2 - k*sinh(a)**2", "k"),
        ("cos(a)*cos(b) + sin(a)*sin(b)", "cos(a - b)"),
        ("cos(a)*cos(b) - sin(a)*sin(b)", "cos(a + b)"),
        ("sin(a)*sin(b) - cos(a)*cos(b)", "-cos(a + b)"),
        ("sin(a)*cos(b) - cos(a)*sin(b)", "sin(a - b)"),
        ("sin(a)*cos(b) + cos(a)*sin(b)", "sin(a + b)"),
        ("cos(a)*sin(b) - sin(a)*cos(b)", "sin(b - a)"),
        ("(l*cos(a)*cos(p))**2 + (l*cos(a)*sin(p))**2 + (l*sin(a))**2", "l**2"),
        ("cos(w*t)*cos(w*t + a) + sin(w*t)*sin(w*t + a)", "cos(a)"),
        ("sqrt((r*cos(a))**2 + (r*sin(a))**2)", "sqrt(r**2)"),
        ("sqrt(x**2 + y**2)**2", "x**2 + y**2"),
        ("sqrt(2)*x*sqrt(2)", "2*x"),
    ],
)
def test_contractions(long, short):
    assert contracted(long) == expression(short)


@pytest.mark.parametrize(
    "text",
    [
        "m*x**m",
        "(x + y)**12",
        "x*(x + y)**12 - (x + y)**11",
        "cos(a)*cos(b) + 2*sin(a)*sin(b)",
        "sin(a)*cos(a)",
        "sin(a)**2",
        "m1*sin(a)**2 + m2*cos(a)**2",
    ],
)
def test_what_no_rule_shortens_stays(text):
    assert contracted(text) == expression(text)


factors = st.sampled_from(
    [
        "x",
        "m",
        "2",
        "sin(a)",
        "cos(a)",
        "sin(b)",
        "cos(b)",
        "sin(a - b)",
        "sinh(x)",
        "cosh(x)",
        "1/(x + m)",
        "sqrt(x + m)",
    ]
)
products = st.lists(factors, min_size=1, max_size=5).map("*".join)
sums = st.lists(st.tuples(st.sampled_from("+-"), products), min_size=1, max_size=8)


@pytest.mark.exhaustive(keep=0.55)
@settings(max_examples=30, deadline=None)
@given(sums)
def test_a_contraction_is_exact(terms):
    long = expression("".join(sign + product for sign, product in terms))
    assert agree_at_random(long, from_terms(contract(to_terms(long))))


def test_a_sum_too_large_to_expand_is_refused():
    wide = sympy.Add(*sympy.symbols(f"x:{LARGEST // 10}"))
    with pytest.raises(TooLargeError):
        to_terms(wide**2)
