"""Nodes as text: what is written reads back as the same expression."""

import pytest

from lagrange_cli.expression.build import build
from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.parse import parse
from lagrange_cli.expression.text import text_of


@pytest.mark.parametrize(
    "text",
    [
        "x", "-x", "2*x", "x - y", "-x - y + 3", "x*(y + 1)", "-(x + 1)*y", "2/(x*y)", "x/y**2", "(x - 1)**3",
        "x**y", "(x + y)**(x*y)", "sqrt(x**2 + y**2)", "sin(x)/cos(2*pi*x)", "exp(-x**2)", "atan2(y, x)",
        "x*(4*x*y - x)**2 + y", "8*x*sqrt(4*x - y + 1)", "1/(3*x - 5*y)**3", "2*x*(0.3*x - y)",
        "3*(x*y)**0.25", "1/(x + y)", "-x/(2*y)", "(x/y)**y", "x - (y - 2*(x + y)**2)", "5e-7*x", "x/pi",
    ],
)  # fmt: skip
def test_text_reads_back(text):
    algebra = GraphAlgebra()

    def node_of(written):
        return build(parse(written), algebra.symbol, algebra)

    node = node_of(text)
    assert node_of(text_of(node)) is node, text_of(node)


def test_numbers_in_terms_of_pi():
    algebra = GraphAlgebra()
    assert text_of(build(parse("2*pi*x + pi"), algebra.symbol, algebra)) == "2*pi*x + pi"


@pytest.mark.parametrize(
    "text", ["x*(4*x*y - z)", "1/(4*x - y)", "y + 2*x*(4*y - 1)", "8*x*sqrt(4*x - y)", "2*x*(x - y/4)"]
)
def test_factors_go_into_sums_with_fractions(text):
    """The graph has 4*x*(x*y - 0.25*y)."""
    algebra = GraphAlgebra()
    assert text_of(build(parse(text), algebra.symbol, algebra)) == text


@pytest.mark.parametrize(
    "text", ["x/2", "-x/(2*y)", "3*x/(4*y*z)", "z + 2*sqrt(x + y)/3", "0.1*x", "2.3*x/y", "-1/(6*x)"]
)
def test_simple_fractions_are_written_as_such(text):
    """The graph has their decimals."""
    algebra = GraphAlgebra()
    assert text_of(build(parse(text), algebra.symbol, algebra)) == text
