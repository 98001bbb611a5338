"""Sums of products, multiplied out: what they have in common is divided out, and nothing else."""

from __future__ import annotations

import pytest

from lagrange_cli.expression.build import build
from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.parse import parse
from lagrange_cli.expression.zero import is_zero
from lagrange_cli.mechanics.laurent import HIGHEST, multiplied_out, primitive


def nodes(*texts):
    algebra = GraphAlgebra()
    return algebra.graph, [build(parse(text), algebra.symbol, algebra) for text in texts]


@pytest.mark.parametrize(
    ("one", "other", "expected"),
    [
        ("(a + b)*(a - b)", "(a + b)*c**2", ("a - b", "c**2")),
        ("a/(a + b) + b/(a + b)", "c*(a + b)/(a + b)", ("1", "c")),
        ("2*a*b + 4*a*c", "6*a*b**2", ("b + 2*c", "3*b**2")),
        ("a*(b + c)", "0", ("1", "0")),
        ("a*sin(b)/(a + c) - sin(b)", "sin(b)/(a + c)", ("-c", "1")),
    ],
)
def test_common_factors_are_divided_out(one, other, expected):
    graph, (first, second, *wanted) = nodes(one, other, *expected)
    found = primitive(graph, [first, second])
    assert is_zero(found[0] * second - found[1] * first)
    assert all(is_zero(a * wanted[1] - b * wanted[1]) for a, b in zip(found, wanted))


def test_what_would_be_longer_stays():
    graph, (node, high) = nodes("(a + b)*(c + d)*(e + f)", f"(a + b)**{HIGHEST + 9}*c - (a + b)*d")
    assert multiplied_out(graph, node) is node
    assert multiplied_out(graph, high) is high
    assert primitive(graph, [node, node * node]) == [node, node * node]


def test_fractions_are_added():
    graph, (node,) = nodes("0.3*q - 0.3*q*m/(m + k) - 0.3*q*k/(m + k) + x")
    assert multiplied_out(graph, node) is graph.symbol("x")
