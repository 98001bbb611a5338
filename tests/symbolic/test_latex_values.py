"""LaTeX has the value of what it shows: random expressions are read back by a parser of LaTeX."""

import mpmath
import pytest
import sympy
from hypothesis import assume, given
from hypothesis import strategies as st

from lagrange_cli.errors import LagrangeError
from lagrange_cli.expression.build import build
from lagrange_cli.expression.parse import parse
from lagrange_cli.expression.symbolic import SympyAlgebra
from lagrange_cli.expression.syntax import ExpressionError
from lagrange_cli.symbolic.latex import Latex
from lagrange_cli.symbolic.order import Order, Role
from lagrange_cli.symbolic.render import render
from tests.support.draws import examples
from tests.support.expressions import known, texts
from tests.support.latex import value

VALUES = {"x": 0.73, "y": -1.21, "k": 2.9, "e": 0.41}
ROLES = {"x": Role.COORDINATE, "y": Role.COORDINATE, "k": Role.PARAMETER, "e": Role.PARAMETER}
NUMBERS = ("1.2e18", "2.5e-7", "1/3", "9.81", "1e-12", "123456.789")


def shown(text, names):
    symbols = {name: sympy.Symbol(name, real=True) for name in names}
    order = Order({symbols[name]: (ROLES[name], k) for k, name in enumerate(names)})
    return render(build(parse(text), symbols.__getitem__, SympyAlgebra()), Latex(), order)


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize("names", [("x", "y", "k"), ("x", "y", "e")])
@examples(18)
@given(data=st.data())
def test_a_random_expression(names, data):
    text = data.draw(texts(names))
    for name in data.draw(st.sets(st.sampled_from(names), max_size=1)):
        text = text.replace(name, f"({data.draw(st.sampled_from(NUMBERS))}*{name})", 1)
    expected = known(text, {name: VALUES[name] for name in names})
    assume(expected is not None)
    try:
        formula = shown(text, names)
    except (LagrangeError, ExpressionError):
        assume(False)
    assume("Abs" not in formula)  # of sympy: (x*x)**x becomes Abs(x)**(2*x), which no equations contain
    with mpmath.workdps(40):
        found = value(formula, {name: mpmath.mpf(VALUES[name]) for name in names})
        assert abs(found - expected) <= 1e-9 * (1 + abs(expected)), (text, formula)


@pytest.mark.parametrize(
    "text",
    [
        "x*(1.2 + ((1/10)**9)**2)**0.7",
        "k*exp(2*x)*x**2",
        "e**2*exp(2*x)",
        "where(x > 0 and y < 1, x, 2)*max(x, y)**3",
    ],
)
def test_an_expression_that_was_read_otherwise(text):
    names = ("x", "y", "e") if "e**" in text else ("x", "y", "k")
    values = {name: mpmath.mpf(VALUES[name]) for name in names}
    assert float(value(shown(text, names), values)) == pytest.approx(float(known(text, VALUES)), rel=1e-12)
