"""The expression graph: what it simplifies keeps its value, and what it derives is the derivative."""

from __future__ import annotations

import math

import mpmath
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from lagrange_cli.expression.build import build
from lagrange_cli.expression.evaluate import evaluate
from lagrange_cli.expression.exact import ExactGraphAlgebra, PortableGraphAlgebra
from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.expression.parse import parse
from lagrange_cli.expression.syntax import ExpressionError
from tests.support.draws import examples
from tests.support.expressions import known, texts

NAMES = ("x", "y", "z")
POINTS = st.fixed_dictionaries({name: st.floats(0.2, 1.4) for name in NAMES})
SIGNED = st.fixed_dictionaries({name: st.floats(-2, 2) for name in NAMES})


def node_of(text: str, algebra: GraphAlgebra | None = None) -> Node:
    algebra = algebra or GraphAlgebra()
    return build(parse(text), algebra.symbol, algebra)


def close(node: Node, value: mpmath.mpf, values: dict[str, float], slack: float = 1e-12) -> bool:
    """Whether a node has this value, within the rounding of the terms that it is summed from."""
    found, size = evaluate([node], values)
    return abs(found[node] - float(value)) <= slack * max(1.0, size[node])


def conditioned(node: Node, values: dict[str, float], bound: float = 1e3) -> bool:
    """Whether all below ``node`` is of moderate size and no function amplifies rounding."""
    perturbed = {name: value * (1 + 1e-9) for name, value in values.items()}
    found, size = evaluate([node], values)
    beside, _ = evaluate([node], perturbed)
    return (
        all(math.isfinite(x) and size[n] < bound for n, x in found.items())
        and all(abs(found[n] - beside[n]) < 1e-9 * bound for n in found)
        and all(abs(found[n]) > 1e-3 or n.kind is Kind.NUMBER for n in found)
    )


def test_differences_of_numbers_are_those_of_what_was_written() -> None:
    graph = Graph()
    x = graph.symbol("x")
    for numbers, left in (
        ((0.1, 0.2, -0.3), 0.0),
        ((0.6000000000000001, -0.8), -0.2),
        ((1.7, -0.3, -1.5), -0.1),
    ):
        assert graph.sum([(x, one) for one in numbers]) is graph.sum([(x, left)])
        assert graph.sum([(graph.constant(one), 1.0) for one in numbers]) is graph.constant(left)
    random = 0.3183098861837907
    assert graph.sum([(x, random), (x, -0.3)]) is graph.sum([(x, random - 0.3)])


def test_sums_that_differ_by_sign_or_powers_of_two_are_one_factor() -> None:
    """So that each pair of bodies has one difference, and one product of it with the inverse cube."""
    algebra = GraphAlgebra()
    for text in ("(x - y)*z", "(y - x)*z", "(2*x - 2*y)*z", "(y - x)/4*z"):
        _, product = algebra.graph.split_coefficient(node_of(text, algebra))
        assert product is node_of("(x - y)*z", algebra)
    assert node_of("(y - x - 1)**2", algebra) is node_of("(x - y + 1)**2", algebra)
    assert node_of("(3*x - 3*y)**2", algebra) is not node_of("9*(x - y)**2", algebra)  # 3 may round


@pytest.mark.exhaustive(keep=0.35)
@examples(50)
@given(texts(NAMES), SIGNED)
@example("(x**2)**0.5", {"x": -1.5, "y": 1.0, "z": 1.0})
@example("x*(x**2)**-0.5", {"x": -1.5, "y": 1.0, "z": 1.0})
@example("(x*y)**1.5", {"x": -1.5, "y": -0.5, "z": 1.0})
@example("(-4*x)**0.5", {"x": -1.5, "y": -0.5, "z": 1.0})
@example("((x - 1)**2*y)**0.5", {"x": 0.5, "y": 0.5, "z": 1.0})
@example("(2*x**3)**-1/(x**-3)", {"x": -0.5, "y": 0.5, "z": 1.0})
@example("asin(sin(9)**2 + cos(9)**2)", {"x": 0.0, "y": 0.0, "z": 0.0})
def test_a_graph_has_the_value_of_its_expression(text: str, values: dict[str, float]) -> None:
    value = known(text, values)
    assume(value is not None)
    try:
        node = node_of(text)
    except ExpressionError:
        assume(False)
    assume(conditioned(node, values))
    assert close(node, value, values)


@pytest.mark.exhaustive(keep=0.25)
@examples(40)
@given(texts(NAMES), POINTS)
@example("x**y", {"x": 0.7, "y": 1.1, "z": 1.0})
@example("atan2(x*y, x - 2)", {"x": 0.7, "y": 1.1, "z": 1.0})
@example("sqrt(x**2)", {"x": 0.7, "y": 1.1, "z": 1.0})
@example("(x**2 - y)**7*acos(x/2)*tan(y)", {"x": 0.7, "y": 1.1, "z": 1.0})
def test_a_derivative_is_the_limit_of_differences(text: str, values: dict[str, float]) -> None:
    """Against the central difference in 50 digits, whose own error is 1e-20 or so."""
    step = mpmath.mpf(10) ** -12
    with mpmath.workdps(50):
        sides = [known(text, {**values, "x": mpmath.mpf(values["x"]) + s * step}) for s in (-1, 1)]
        assume(None not in sides)
        slope = (sides[1] - sides[0]) / (2 * step)
    algebra = GraphAlgebra()
    try:
        node = node_of(text, algebra)
    except ExpressionError:
        assume(False)
    derivative = algebra.diff(node, algebra.symbol("x"))
    assume(conditioned(node, values) and conditioned(derivative, values))
    assert close(derivative, slope, values, 1e-10)


@pytest.mark.parametrize("base", ["x*z", "-x - z", "x**2*z"])
def test_broken_powers_that_make_a_whole_one_are_taken_apart(base: str) -> None:
    algebra = GraphAlgebra()
    node = node_of(f"({base})**-0.5*({base})**-0.5", algebra)
    assert node is node_of(f"1/({base})", algebra)
    assert node * algebra.number("1") is node


@pytest.mark.exhaustive(keep=0.7)
@examples(25)
@example("x*asin(2)**0")  # nan, which is not equal to itself
@example("sin((-1)**0.5)**2 + cos((-1)**0.5)**2")  # nan on the way to 1
@given(texts(NAMES))
def test_equal_expressions_are_one_node(text: str) -> None:
    algebra = GraphAlgebra()
    try:
        node = node_of(text, algebra)
    except ExpressionError:
        assume(False)
    passed = repr(algebra.graph.nodes)
    assume("inf" not in passed and "nan" not in passed)
    before = len(algebra.graph.nodes)
    assert node_of(text, algebra) is node
    assert len(algebra.graph.nodes) == before
    zero, one, two = algebra.number("0"), algebra.number("1"), algebra.number("2")
    assert node + zero is node
    assert node * one is node
    assert node + node is two * node
    if node.kind is not Kind.NUMBER:
        assert (node - node).is_zero
        assert (node * zero).is_zero
    for inner in reachable([node]):
        assert all(argument.number < inner.number for argument in inner.arguments)
        assert all(argument.symbols & ~inner.symbols == 0 for argument in inner.arguments)


@pytest.mark.parametrize(
    ("text", "same"),
    [
        ("x + y + x", "2*x + y"),
        ("x - x", "0"),
        ("x*y*x", "x**2*y"),
        ("x/x", "1"),
        ("x**2/x**3", "1/x"),
        ("(x*y)**3", "x**3*y**3"),
        ("2*x*3*y", "6*x*y"),
        ("-(x - y)", "y - x"),
        ("(x**2)**3", "x**6"),
        ("sqrt(x)*sqrt(x)", "x"),
        ("sin(x)**2 + cos(x)**2", "1"),
        ("z*y*sin(x)**2 + z*y*cos(x)**2 + x", "x + y*z"),
        ("y*sin(x)**2*sin(z)**2 + y*sin(x)**2*cos(z)**2 + y*cos(x)**2", "y"),
        ("3*cos(x)**2 - 2 + 3*sin(x)**2", "1"),
        ("0*log(x)", "0"),
        ("x**0", "1"),
        ("1**x", "1"),
        ("atan2(0, 1) + sin(0)", "0"),
        ("2**3 - 8", "0"),
        ("x*cos(pi/2) + y*sin(-270*pi/180) + z*tan(2*pi)", "y"),
    ],
)
@pytest.mark.parametrize("kind", [GraphAlgebra, PortableGraphAlgebra, ExactGraphAlgebra])
def test_simplified_to_the_same_node(text: str, same: str, kind: type[GraphAlgebra]) -> None:
    algebra = kind()
    assert node_of(text, algebra) is node_of(same, algebra)


@pytest.mark.parametrize(
    ("text", "other"),
    [
        ("sqrt(x**2)", "x"),
        ("(x*y)**0.5", "x**0.5*y**0.5"),
        ("2*sin(x)**2 + cos(x)**2", "1"),
        ("sin(x)**2 + cos(y)**2", "1"),
        ("(x**3)**(1/3)", "x"),
        ("x**y", "y**x"),
        ("atan2(x, y)", "atan2(y, x)"),
        ("sin(3.14159265358)", "0"),
        ("sin(1e-30)", "0"),
        ("x*y*(x + y)", "x**2*y + x*y**2"),  # kept as written: a sum times a product is one convolution
    ],
)
def test_not_simplified_where_it_would_be_wrong_or_dearer(text: str, other: str) -> None:
    algebra = GraphAlgebra()
    assert node_of(text, algebra) is not node_of(other, algebra)


@pytest.mark.parametrize(
    ("text", "absolute", "factor"),
    [
        ("sqrt(x**2)", "x", "1"),
        ("sqrt(4*x**2)", "x", "2"),
        ("(x**2)**1.5", "x", "x**2"),
        ("sqrt(x**4)*sqrt(y**2)", "y", "x**2"),
        ("sqrt(x**2*y)", "x", "sqrt(y)"),
        ("sqrt(exp(z)*x**2)", "x", "exp(z)**0.5"),
        ("sqrt((3 - x)**2)", "x - 3", "1"),
        ("sqrt(x**2 - 10*x + 25)", "x - 5", "1"),
        ("sqrt(2*x**2 + 2*y**2 - 4*x*y)", "x - y", "sqrt(2)"),
        ("sqrt(0.01 - 0.2*x + x**2)", "x - 0.1", "1"),
        ("sqrt(x**2 + y**2 + z**2 - 2*x*y + 2*x*z - 2*y*z)", "x - y + z", "1"),
        ("sqrt(1 - cos(x))", "sin(x/2)", "sqrt(2)"),
        ("sqrt(3*y + 3*cos(2*x)*y)", "cos(x)", "sqrt(6*y)"),
        ("(cosh(x) - 1)**1.5", "sinh(x/2)", "sqrt(8)*sinh(x/2)**2"),
        ("sqrt(z**2 - z**2*cos(x)**2)", "sin(x)", "abs(z)"),
        ("sqrt(4 - 4*sin(x)**2)", "cos(x)", "2"),
        ("sqrt(cosh(x)**2 - 1)", "sinh(x)", "1"),
        ("sqrt(1 - sin(x))", "cos(x/2) - sin(x/2)", "1"),
        ("sqrt(1 - (1 - 2*sin(x)**2)**2)", "sin(2*x)", "1"),
        ("sqrt(1 - 4*sin(x)**2*cos(x)**2)", "cos(2*x)", "1"),
        ("sqrt((cos(x) - cos(y))**2 + (sin(x) - sin(y))**2)", "sin(x/2 - y/2)", "2"),
        ("sqrt(exp(2*x) - 2 + exp(-2*x))", "sinh(x)", "2"),
        ("sqrt(1 - 4*x**2/(1 + x**2)**2)", "x**2 - 1", "1/(1 + x**2)"),
        ("sqrt(1 + 2*x*y + x**2*y**2)", "1 + x*y", "1"),
    ],
)
def test_roots_of_squares_are_absolute_values(text: str, absolute: str, factor: str) -> None:
    for algebra in (GraphAlgebra(), ExactGraphAlgebra()):
        found, expected = node_of(text, algebra), algebra.graph.absolute(node_of(absolute, algebra))
        assert found is expected * node_of(factor, algebra)


TERMS = [
    "x",
    "y",
    "2",
    "sin(x)",
    "cos(2*x)",
    "sin(x - y)",
    "cos(y + 1)",
    "exp(x)",
    "cosh(y)",
    "x*cos(y)",
    "tan(x)",
]


@pytest.mark.exhaustive(keep=0.4)
@examples(40)
@given(st.lists(st.sampled_from(TERMS), min_size=2, max_size=3, unique=True), SIGNED)
def test_a_sum_of_products_that_is_a_square_has_a_root_without_a_power(terms, values) -> None:
    square = " + ".join(f"{a}*{b}" for a in terms for b in terms)
    root = node_of(f"sqrt({square})")
    for node in reachable([root]):  # what is positive is its own absolute value
        assert node.kind is not Kind.PRODUCT or all(isinstance(e, int) for e in node.data)
    value = known(f"abs({' + '.join(terms)})", values)
    assume(value is not None and value > 1e-3)
    assert close(root, value, values)


@pytest.mark.parametrize(
    ("text", "other"),
    [
        ("sqrt(1 + x**4) - x**2", "1/(sqrt(1 + x**4) + x**2)"),
        ("2*x**2 - sqrt(4*x**4 + 3)", "-3/(sqrt(4*x**4 + 3) + 2*x**2)"),
        (
            "sqrt(1 + ((x - 0.3)/1e-5)**4) - ((x - 0.3)/1e-5)**2",
            "1/(sqrt(1 + ((x - 0.3)/1e-5)**4) + ((x - 0.3)/1e-5)**2)",
        ),
    ],
)
def test_a_root_minus_what_is_nearly_as_large_is_a_fraction(text: str, other: str) -> None:
    algebra = GraphAlgebra()
    assert node_of(text, algebra) is node_of(other, algebra)


def test_what_is_nearly_a_square_is_none() -> None:
    for text in (
        "1 - (1 - 1e-13)*cos(x)",
        "1.0000000000001 - sin(x)",
        "x**2 + 1e-20*y",
        "1 - 2*x + x**2 + 1e-9",
        "1 + 1e20*(x - 0.3)**4",
        "1 + (x - 1e9)**2",
    ):
        assert not any(node.kind is Kind.SWITCH for node in reachable([node_of(f"sqrt({text})")]))


@pytest.mark.parametrize(
    "text",
    [
        "sqrt(x**2 + y**2)",
        "sqrt(x**2 + x*y + y**2)",
        "sqrt(1 - x**2)",
        "sqrt(x**3)",
        "sqrt(2 - cos(x))",
        "sqrt(1 + cosh(x))",
    ],
)
def test_other_roots_stay(text: str) -> None:
    assert not any(node.kind is Kind.SWITCH for node in reachable([node_of(text)]))


def test_a_switch_has_one_form() -> None:
    graph = Graph()
    x, y = graph.symbol("x"), graph.symbol("y")
    size, sign = graph.absolute(x), graph.switch(x, 1.0, -1.0)
    assert graph.diff(size, x) is sign
    assert graph.diff(sign, x).is_zero
    assert size * size is x * x
    assert size**3 is x * x * size
    assert size * sign is x
    assert graph.absolute(-2.0 * x) is 2.0 * size
    assert graph.absolute(x * y**3) is size * graph.absolute(y) * y * y
    assert graph.absolute(y - x) is graph.absolute(x - y)
    assert graph.absolute(1.0 - 3.0 * x) is graph.absolute(3.0 * x - 1.0)
    assert graph.switch(-x, y, x, 1) is graph.switch(x, x, y, -1)
    assert graph.switch(x**3 * graph.function("exp", (y,)), 1.0, -1.0) is sign
    assert graph.switch(x, y, y) is y
    assert graph.switch(x, graph.switch(x, y, 2.0, 1), 3.0, -1) is graph.switch(x, y, 3.0, -1)
    assert graph.absolute(x**2 + 1.0) is x**2 + 1.0
    assert graph.switch(x**2, 1.0, 0.0, -1).kind is Kind.SWITCH  # 0 where x is
    above, mean, below = (graph.switch(0.0, x, y, at) for at in (1, 0, -1))
    assert (above, mean, below) == (x, 0.5 * x + 0.5 * y, y)
    assert graph.switch(3.0, x, y) is x
    assert graph.switch(-3.0, x, y) is y
    assert math.isnan(graph.switch(math.nan, x, y).data)


@pytest.mark.exhaustive(keep=0.4)
@examples(50)
@given(texts(NAMES), texts(NAMES), texts(NAMES), st.sampled_from((-1, 0, 1)), SIGNED)
def test_a_switch_has_the_value_of_its_branch(
    u: str, a: str, b: str, at: int, values: dict[str, float]
) -> None:
    algebra = GraphAlgebra()
    try:
        given_nodes = [node_of(text, algebra) for text in (u, a, b)]
    except ExpressionError:
        assume(False)
    found, size = evaluate(given_nodes, values)
    decides, above, below = (found[node] for node in given_nodes)
    assume(all(map(math.isfinite, (decides, above, below))))
    assume(abs(decides) > 1e-9 * size[given_nodes[0]])  # whose sign no other order of its sums changes
    assume(all(conditioned(node, values) for node in given_nodes))
    node = algebra.graph.switch(*given_nodes, at=at)
    value = evaluate([node], values)[0][node]
    right = above if decides > 0 else below
    assert abs(value - right) <= 1e-9 * max(1.0, size[given_nodes[1]], size[given_nodes[2]])


def test_what_a_switch_does_not_choose_may_have_no_value() -> None:
    algebra = GraphAlgebra()
    node = algebra.graph.switch(*(node_of(text, algebra) for text in ("x", "sqrt(x)", "log(-x)")), at=1)
    for x, value in ((4.0, 2.0), (-1.0, 0.0), (0.0, 0.0)):
        assert evaluate([node], {"x": x})[0][node] == value
    assert math.isnan(evaluate([node], {"x": math.nan})[0][node])


def test_derivatives_skip_what_does_not_depend_on_the_symbol() -> None:
    algebra = GraphAlgebra()
    graph = algebra.graph
    large = node_of("log(sin(y)**3 + exp(y*z))*tan(z)", algebra)
    before = len(graph.nodes)
    assert algebra.diff(large, algebra.symbol("x")).is_zero
    assert len(graph.nodes) <= before + 1  # the symbol, at most
    product = large * algebra.symbol("x")
    assert algebra.diff(product, algebra.symbol("x")) is large


def test_shared_parts_are_derived_once() -> None:
    """x -> sin(x)*x + 1, thirty times: a tree of a billion leaves, a graph of some hundred nodes."""
    algebra = GraphAlgebra()
    x = node = algebra.symbol("x")
    for _ in range(30):
        node = algebra.function("sin", (node,)) * node + 1.0
    derivative = algebra.diff(node, x)
    assert len(reachable([derivative])) < 400


def test_time_derivatives_are_left_for_the_series_to_take() -> None:
    graph = Graph()
    x = graph.symbol("x")
    assert graph.ddt(graph.constant(3.0)).is_zero
    assert graph.ddt(x) is graph.ddt(x)
    assert graph.ddt(x).kind is Kind.DDT
    with pytest.raises(ValueError, match="time derivative"):
        evaluate([graph.ddt(x)], {"x": 1.0})


def test_parameters_are_split_off() -> None:
    algebra = GraphAlgebra()
    x, m = algebra.symbol("x"), algebra.symbol("m")
    fixed, moving = algebra.graph.split_parameters(3.0 * m**2 * x * algebra.function("sin", (x,)), x.symbols)
    assert fixed is 3.0 * m**2
    assert moving is x * algebra.function("sin", (x,))
    assert algebra.graph.split_parameters(m + 1.0, x.symbols) == (m + 1.0, algebra.graph.one)


@pytest.mark.parametrize(
    "text",
    ["max(0, x)**0.5", "max(0, x)**z", "(max(0, x)**2 + max(0, y)**2)**0.75", "asin(min(1, x + 1.5))",
     "acos(1 - max(0, 2*x))", "atan2(max(0, x), max(0, y))", "(max(0, x) + max(0, y))**0.5"],
)  # fmt: skip
def test_where_a_switch_is_constant_so_is_any_function_of_it(text: str) -> None:
    """Its slope may be infinite there: the derivative is a switch of derivatives, not a product."""
    algebra = GraphAlgebra()
    slope = algebra.graph.diff(node_of(text, algebra), algebra.symbol("x"))
    constant = {"x": 0.3 if "asin" in text else -0.3, "y": -0.2, "z": 0.4}
    assert evaluate([slope], constant)[0][slope] == 0.0
    inside = {"x": -0.7 if "asin" in text else 0.3, "y": 0.2, "z": 0.4}
    above, below = (known(text, {**inside, "x": inside["x"] + change}) for change in (1e-5, -1e-5))
    assert close(slope, (above - below) / 2e-5, inside, 1e-8)


@pytest.mark.parametrize("coefficient", [math.nan, math.inf, -math.inf])
def test_a_root_with_a_coefficient_that_is_no_number_stays_in_its_sum(coefficient):
    """No difference is without it: to take it away again and again would have no end."""
    graph = Graph()
    root = graph.product([(graph.symbol("x") + 1.0, 0.5)])
    node = graph.sum([(root, coefficient), (graph.symbol("y"), -1.0)])
    assert node.kind is Kind.SUM and root in node.arguments
