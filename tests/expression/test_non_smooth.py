"""Absolute values, signs, extrema and cases: one meaning in all algebras, and what is refused."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
import sympy
from hypothesis import assume, given
from hypothesis import strategies as st

from lagrange_cli.expression.bounds import BoundsAlgebra
from lagrange_cli.expression.build import build
from lagrange_cli.expression.columns import Column, ColumnAlgebra
from lagrange_cli.expression.evaluate import evaluate
from lagrange_cli.expression.exact import LongNumberAlgebra
from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.numbers import NumberAlgebra
from lagrange_cli.expression.parse import parse
from lagrange_cli.expression.signs import Sign, signs
from lagrange_cli.expression.symbolic import SympyAlgebra
from lagrange_cli.expression.syntax import ExpressionError
from lagrange_cli.symbolic.grouping import tidy
from lagrange_cli.symbolic.latex import Latex
from lagrange_cli.symbolic.notations import Python, Sympy, Text, Unicode
from lagrange_cli.symbolic.order import Order, Role
from lagrange_cli.symbolic.render import render
from tests.support.draws import examples
from tests.support.expressions import texts

NAMES = ("x", "y")
VALUES = st.floats(-2, 2).filter(lambda x: abs(x) > 1e-3)

KNOWN = [
    ("abs(x)", -2.0, 0.5, 2.0),
    ("sign(x)", -2.0, 0.5, -1.0),
    ("sign(x)", 0.0, 0.5, 0.0),
    ("sign(y)", 0.0, 0.5, 1.0),
    ("min(x, y)", -2.0, 0.5, -2.0),
    ("max(x, y, 3)", -2.0, 0.5, 3.0),
    ("min(x, 3, y, 1)", -2.0, -2.5, -2.5),
    ("where(x > 0, 1, 2)", 0.0, 0.0, 2.0),
    ("where(x >= 0, 1, 2)", 0.0, 0.0, 1.0),
    ("where(x < 0, 1, 2)", 0.0, 0.0, 2.0),
    ("where(x <= 0, 1, 2)", 0.0, 0.0, 1.0),
    ("where(-1 < x <= 1, 5, 6)", -1.0, 0.0, 6.0),
    ("where(-1 < x <= 1, 5, 6)", 1.0, 0.0, 5.0),
    ("where(x > 0 and y > 0, 1, 2)", 1.0, -1.0, 2.0),
    ("where(x > 0 or y > 0, 1, 2)", 1.0, -1.0, 1.0),
    ("where(not x > 0, 1, 2)", 1.0, -1.0, 2.0),
    ("where(x == y, 1, 2)", 1.0, 1.0, 1.0),
    ("where(x == y, 1, 2)", 1.0, 1.5, 2.0),
    ("where(x != y, 1, 2)", 1.0, 1.5, 1.0),
    ("where(x != 1 or y > 3, 1, 2)", 1.0, 1.5, 2.0),
    ("where(0.5 < x == y, 1, 2)", 1.0, 1.0, 1.0),
    ("where(not (x > 0 and not y > 0) or x > 5, 1, 2)", 1.0, -1.0, 2.0),
    ("where(x > 0, sqrt(x), log(-x))", 4.0, 0.0, 2.0),
    ("where(x > 0, sqrt(x), log(-x))", -1.0, 0.0, 0.0),
    ("where(x > 1, 1/(x - 1), where(x > 0, 7, 8))", 1.0, 0.0, 7.0),
    ("norm(where(x > 0, (x, y), (3, 4)))", -1.0, 0.0, 5.0),
    ("sum(where(i == 1, x, 1) for i in range(3))", 5.0, 0.0, 7.0),
    ("sum(where(i < j, 1, where(i == j, 10, 100)) for i in range(2) for j in range(2))", 0.0, 0.0, 121.0),
]


@pytest.mark.parametrize(("text", "x", "y", "value"), KNOWN)
def test_known_values_in_every_algebra(text: str, x: float, y: float, value: float) -> None:
    values, tree = {"x": x, "y": y}, parse(text)
    for algebra in (NumberAlgebra(), LongNumberAlgebra()):
        given_ones = {
            name: algebra.number(str(abs(one))) * (-1 if one < 0 else 1) for name, one in values.items()
        }
        assert float(build(tree, given_ones.__getitem__, algebra)) == pytest.approx(value, abs=1e-15)
    graph, symbolic = GraphAlgebra(), SympyAlgebra()
    node = build(tree, graph.symbol, graph)
    assert evaluate([node], values)[0][node] == pytest.approx(value)
    expression = build(tree, symbolic.symbol, symbolic)
    assert float(expression.subs({sympy.Symbol(name): one for name, one in values.items()})) == pytest.approx(
        value
    )
    columns = ColumnAlgebra(3)
    rows = {"x": columns.column(np.array([7.0, x, -7.0])), "y": columns.column(np.array([1.0, y, 2.0]))}
    with np.errstate(all="ignore"):
        column = build(tree, rows.__getitem__, columns)
    column = column if isinstance(column, Column) else columns.column(np.full(3, column))
    assert column.values[1] == pytest.approx(value)
    assert not columns.failed[1]
    assert build(tree, BoundsAlgebra().symbol, BoundsAlgebra()).value in (None, value)


def test_a_member_fails_where_its_own_branch_does() -> None:
    algebra = ColumnAlgebra(4)
    x = algebra.column(np.array([4.0, -4.0, 0.0, math.nan]))
    with np.errstate(all="ignore"):
        found = build(parse("where(x > 0, sqrt(x), where(x < 0, 1, 1/x))"), {"x": x}.__getitem__, algebra)
    assert found.values[:2].tolist() == [2.0, 1.0]
    assert algebra.failed.tolist() == [False, False, True, True]


@pytest.mark.parametrize(
    ("text", "kept"),
    [
        ("min(1, sin(1)**2 + cos(1)**2)", "min(1, cos(1)**2 + sin(1)**2)"),
        ("max(1/2, sin(1)**2 + cos(1)**2, 1)", "max(1, cos(1)**2 + sin(1)**2)"),
        ("sign(sin(1)**2 + cos(1)**2 - 1)", "sign(-1 + cos(1)**2 + sin(1)**2)"),
        ("where(sin(1)**2 + cos(1)**2 > 1, 3, 5)", "where(-1 + cos(1)**2 + sin(1)**2, 3, 5, -1)"),
        ("where(sqrt(2) > 1, x, y)", "x"),
        ("min(x, 2, pi, x)", "min(2, x)"),
        ("max(max(y, x), max(2, y), 3)", "max(3, x, y)"),
        ("min(min(x, y), max(y, x))", "min(x, y, max(x, y))"),
    ],
)
def test_constants_are_compared_where_sympy_can(text: str, kept: str) -> None:
    """It raises where it is asked which of two equal ones is greater."""
    symbolic = SympyAlgebra()
    assert str(build(parse(text), symbolic.symbol, symbolic)) == kept


def test_the_angle_at_the_origin_is_0() -> None:
    """As in doubles, within other functions, too."""
    symbolic, numbers = SympyAlgebra(), NumberAlgebra()
    for text in ("atan2(0, 0)", "atan2(0, atan2(0, 0))", "1 + atan2(atan2(0, 1), 0)"):
        exact = build(parse(text), symbolic.symbol, symbolic)
        assert float(exact) == build(parse(text), {}.__getitem__, numbers), text


@pytest.mark.parametrize(
    ("text", "sign"),
    [
        ("max(0, y)", Sign.NEVER_NEGATIVE),
        ("-min(0, 3*(x - y))", Sign.NEVER_NEGATIVE),
        ("max(0, y - 9) + max(0, -y)", Sign.NEVER_NEGATIVE),
        ("where(y > 2, y - 2, 0)", Sign.NEVER_NEGATIVE),
        ("max(1, y)", Sign.POSITIVE),
        ("where(y > 0, y - 1, 0)", Sign.ANY),
        ("where(y > 0, 0, y)", Sign.ANY),
        ("-max(0, y)", Sign.ANY),
        ("where(y > 0, 0, x)", Sign.ANY),
    ],
)
def test_branches_count_where_their_condition_holds(text: str, sign: Sign) -> None:
    graph = GraphAlgebra()
    assert signs(build(parse(text), graph.symbol, graph), {}) is sign


@pytest.mark.parametrize(
    ("text", "sign"),
    [
        ("1 + 0.3*cos(x)*sin(y)**2 - 0.6*tanh(x*y) + y**2", Sign.POSITIVE),
        ("1 - 0.5*cos(x) + sin(y)/2", Sign.NEVER_NEGATIVE),
        ("1 + 1.1*cos(x)", Sign.ANY),
        ("2 + sin(x)/cos(y)", Sign.ANY),
    ],
)
def test_sines_count_by_their_size(text: str, sign: Sign) -> None:
    graph = GraphAlgebra()
    assert signs(build(parse(text), graph.symbol, graph), {}) is sign


SIDES = st.sampled_from(["x", "y", "-x", "x - y", "y - x", "2*x - 3", "x + 1", "0", "1", "-1"])


@examples(100)
@given(st.sampled_from(["where({0} > 0, {1}, {2})", "max({0}, {1}) - {2}", "-min({0}, {1})"]), *3 * [SIDES],
       VALUES, VALUES)  # fmt: skip
def test_what_is_never_negative_is_not(form: str, u: str, one: str, other: str, x: float, y: float) -> None:
    graph = GraphAlgebra()
    node = build(parse(form.format(f"({u})", f"({one})", f"({other})")), graph.symbol, graph)
    for own in (node, -node):
        value = evaluate([own], {"x": x, "y": y})[0][own]
        assert value >= (0.0 if signs(own, {}) is Sign.NEVER_NEGATIVE else -math.inf)
        assert value > 0.0 or signs(own, {}) is not Sign.POSITIVE


@pytest.mark.exhaustive(keep=0.35)
@examples(60)
@given(texts(NAMES), VALUES, VALUES)
def test_graph_sympy_and_numbers_agree(text: str, x: float, y: float) -> None:
    """And what is printed, in notations that can be read back."""
    values, numbers = {"x": x, "y": y}, NumberAlgebra()
    try:
        tree = parse(text)  # which refuses exponents that are not real, or large
        value = build(tree, values.__getitem__, numbers)
        beside = [
            build(tree, {"x": x * (1 + dx), "y": y * (1 + dy)}.__getitem__, numbers)
            for dx, dy in itertools.product((-1e-9, 1e-9), repeat=2)
        ]
    except (ExpressionError, ValueError):
        assume(False)
    assume(abs(value) < 1e4 and all(abs(value - one) < 1e-5 for one in beside))  # no boundary near
    assume("atan2" not in text or abs(abs(value) - math.pi) > 1e-6)  # at its cut the sign of 0 decides
    graph, symbolic = GraphAlgebra(), SympyAlgebra()
    try:
        node = build(tree, graph.symbol, graph)
    except ExpressionError:
        assume(False)
    found, size = evaluate([node], values)
    assume(math.isfinite(size[node]) and size[node] < 1e6)
    assert found[node] == pytest.approx(value, abs=1e-6)
    expression = build(tree, symbolic.symbol, symbolic)
    symbols = [sympy.Symbol(name) for name in NAMES]
    order = Order({symbol: (Role.COORDINATE, i) for i, symbol in enumerate(symbols)})
    assume(not expression.has(sympy.zoo, sympy.nan, sympy.oo, sympy.I))
    names = {name: name for name in NAMES}
    again = build(parse(render(expression, Text(), order)), values.__getitem__, numbers)
    assert again == pytest.approx(value, abs=1e-6)
    python = render(expression, Python(names), order)
    scope = {name: getattr(math, name) for name in ("sin", "cos", "tan", "exp", "log", "sqrt", "pi", "atan2")}
    scope |= {name: getattr(math, name) for name in ("asin", "acos", "atan", "sinh", "cosh", "tanh")}
    scope["sign"] = lambda u: (u > 0) - (u < 0)
    assert eval(python, scope, values) == pytest.approx(value, abs=1e-6)


@pytest.mark.parametrize(
    ("text", "shown", "python", "read"),
    [
        ("abs(x - y)", "abs(x - y)", "abs(x - y)", "Abs(x - y)"),
        ("max(x, y)*2", "2*max(x, y)", "2*max(x, y)", "2*Max(x, y)"),
        (
            "where(x > 1, x, 0)",
            "where(x > 1, x, 0)",
            "(x if x > 1 else 0)",
            "Piecewise((x, x > 1), (0, True))",
        ),
        (
            "where(x < 1, x, 0)",
            "where(x < 1, x, 0)",
            "(x if x < 1 else 0)",
            "Piecewise((x, x < 1), (0, True))",
        ),
        ("where(x + y >= 2*x, 1, 0)", "where(y >= x, 1, 0)", None, None),
        (
            "where(x > 0 and y <= 1, x, y)",
            "where(x > 0 and y <= 1, x, y)",
            "(x if x > 0 and y <= 1 else y)",
            "Piecewise((x, And(x > 0, y <= 1)), (y, True))",
        ),
        (
            "where(x > 0 or y > 0, x, y)",
            "where(x > 0 or y > 0, x, y)",
            None,
            "Piecewise((x, Or(x > 0, y > 0)), (y, True))",
        ),
        ("where(0 < x < 1, x, y)", "where(x > 0 and x < 1, x, y)", None, None),
        (
            "where(x > 1, 1, where(x > 0, x, 0))",
            "where(x > 1, 1, where(x > 0, x, 0))",
            "(1 if x > 1 else x if x > 0 else 0)",
            "Piecewise((1, x > 1), (x, x > 0), (0, True))",
        ),
    ],
)
def test_how_they_are_printed(text: str, shown: str, python: str | None, read: str | None) -> None:
    algebra = SympyAlgebra()
    expression = build(parse(text), algebra.symbol, algebra)
    order = Order({sympy.Symbol(name): (Role.COORDINATE, i) for i, name in enumerate(NAMES)})
    names = {name: name for name in NAMES}
    assert render(expression, Text(), order) == shown
    assert python is None or render(expression, Python(names), order) == python
    if read is not None:
        assert render(expression, Sympy(names), order) == read
        assert sympy.sympify(read).free_symbols == {
            sympy.Symbol(name) for name in NAMES if name in text.split("(", 1)[1]
        }


@pytest.mark.parametrize(
    ("text", "message", "hint"),
    [
        ("where((x, y) > (0, 1), 1, 2)", "vectors cannot be compared", "components"),
        ("where(x and y, 1, 2)", "expected a condition", "x > 0"),
        ("where((x > 0)*2 > 1, 1, 2)", "expected a number, found a condition", "where(CONDITION, 1, 0)"),
        ("where(x > 0, (x, y), 1)", "cannot choose between a vector and a scalar", "same number"),
        ("where(x > 0, (x, y), (x, y, x))", "vectors of 2 and 3 components", "same number"),
        ("abs((x, y))", "'abs' needs a scalar", "norm()"),
        ("max((x, y), x)", "'max' needs a scalar", "norm()"),
    ],
)
def test_what_is_refused(text: str, message: str, hint: str) -> None:
    algebra = BoundsAlgebra()
    with pytest.raises(ExpressionError) as caught:
        build(parse(text), lambda name: algebra.symbol(name), algebra)
    assert message in caught.value.message
    assert hint in caught.value.hint


def test_derivatives_of_sympy_and_the_graph_agree() -> None:
    for text in (
        "abs(x*y)",
        "sign(x)*x**2",
        "max(x**2, y*x, 1)",
        "min(x, y)",
        "where(x > y, x**3, where(y > 0, x, 2))",
    ):
        graph, symbolic = GraphAlgebra(), SympyAlgebra()
        node = build(parse(text), graph.symbol, graph)
        slope = graph.diff(node, graph.symbol("x"))
        other = symbolic.diff(build(parse(text), symbolic.symbol, symbolic), symbolic.symbol("x"))
        for x, y in ((0.3, 1.7), (-0.4, 0.6), (1.3, -0.2), (2.1, 0.5), (-2.0, -3.0)):
            value = evaluate([slope], {"x": x, "y": y})[0][slope]
            assert value == pytest.approx(float(other.subs({"x": x, "y": y})))


@pytest.mark.parametrize(
    ("text", "unicode", "latex"),
    [
        ("abs(x)**3", "|x|³", r"\left|x\right|^{3}"),
        ("abs(x - 1)", "|x − 1|", r"\left|x - 1\right|"),
        ("2*sign(x)", "2 sign(x)", r"2 \operatorname{sgn} x"),
        ("max(0, x)**2", "max²(0, x)", r"\max^{2}(0, x)"),
        (
            "where(x >= 1 and y < 2, x, y)",
            "where(x ≥ 1 and y < 2, x, y)",
            r"{\begin{cases} x & \text{if } x \ge 1 \text{ and } y < 2 \\ y & \text{otherwise} \end{cases}}",
        ),
    ],
)
def test_how_textbooks_print_them(text: str, unicode: str, latex: str) -> None:
    algebra = SympyAlgebra()
    expression = build(parse(text), algebra.symbol, algebra)
    order = Order({sympy.Symbol(name): (Role.COORDINATE, i) for i, name in enumerate(NAMES)})
    assert render(expression, Unicode(), order) == unicode
    assert render(expression, Latex(), order) == latex


def test_forces_are_simplified_as_a_textbook_does() -> None:
    algebra = SympyAlgebra()
    order = Order({sympy.Symbol(name): (Role.COORDINATE, i) for i, name in enumerate(NAMES)})
    for text, force in (
        ("max(0, x - 5)**2/2", "max(0, x - 5)"),
        ("min(x, 0)**4", "4*min(0, x)**3"),
        ("max(0, -x)**2 + min(0, x)**2", "4*min(0, x)"),
        ("max(0, -x)**3 + min(0, x)**3", "0"),
        ("abs(x)**3 - x**2*abs(x)", "0"),
        ("abs(x)**3", "3*x**2*sign(x)"),
        ("x*sign(x)", "sign(x)"),
        ("max(x, y)**2", "2*max(x, y)*where(x > y, 1, 0)"),
    ):
        slope = algebra.diff(build(parse(text), algebra.symbol, algebra), algebra.symbol("x"))
        assert render(tidy(slope, order), Text(), order) == force


def test_many_conditions_are_no_deep_recursion() -> None:
    text = "where(" + " and ".join(["x > 0"] * 450) + ", 1, 2)"
    for algebra in (GraphAlgebra(), NumberAlgebra({"x": 1.0})):
        build(parse(text), algebra.symbol, algebra)
