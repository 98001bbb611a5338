"""Whole numbers, conditions, and sums over them: the meaning is Python's."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lagrange_cli.expression.build import MAX_TERMS, Builder, NoMember, build
from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.indices import LARGEST, counted, holds, integer
from lagrange_cli.expression.numbers import NumberAlgebra
from lagrange_cli.expression.parse import parse
from lagrange_cli.expression.symbolic import SympyAlgebra
from lagrange_cli.expression.syntax import ExpressionError, Span, Sum
from lagrange_cli.expression.vocabulary import acceleration_name, family_name, member_name, velocity_name

SIZES = {"N": 7, "M": 3}
PYTHON = {"__builtins__": {"abs": abs, "min": min, "max": max}}


def larger(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    return st.one_of(
        st.builds("({} {} {})".format, inner, st.sampled_from(["+", "-", "*", "//", "%"]), inner),
        st.builds("(-{})".format, inner),
        st.builds("abs({})".format, inner),
        st.builds("{}({}, {})".format, st.sampled_from(["min", "max"]), inner, inner),
    )


WHOLE = st.recursive(st.sampled_from(["0", "1", "12", "i", "j", "N", "M"]), larger, max_leaves=12)
PLACES = st.fixed_dictionaries({"i": st.integers(-3, 20), "j": st.integers(0, 5)}).map(
    lambda one: one | SIZES
)


@given(WHOLE, PLACES)
def test_index_arithmetic_is_that_of_python(text: str, indices: dict[str, int]) -> None:
    try:
        expected = eval(text, PYTHON, indices)
    except ZeroDivisionError:
        with pytest.raises(ExpressionError, match="division by zero"):
            integer(parse(text), indices)
    else:
        assert integer(parse(text), indices) == expected


@pytest.mark.parametrize("base", ["0", "1", "(-1)", "i", "(i - 5)", "(N*M)"])
@pytest.mark.parametrize("exponent", ["0", "1", "M", "j", "2*j + 1", "10**6 + j"])
def test_powers_are_those_of_python(base: str, exponent: str) -> None:
    tree = parse(f"{base}**({exponent})")
    for i in range(10):
        indices = {**SIZES, "i": i, "j": i % 4}
        power = eval(f"{base}**min({exponent}, 99)", PYTHON, indices)
        if abs(power) > LARGEST:
            with pytest.raises(ExpressionError, match="too large"):
                integer(tree, indices)
        else:
            assert integer(tree, indices) == eval(f"{base}**({exponent})", PYTHON, indices)


CONDITIONS = st.recursive(
    st.builds("{} {} {}".format, WHOLE, st.sampled_from(["==", "!=", "<", "<=", ">", ">="]), WHOLE)
    | st.builds("{} < {} <= {}".format, WHOLE, WHOLE, WHOLE),
    lambda inner: (
        st.builds("({} {} {})".format, inner, st.sampled_from(["and", "or"]), inner)
        | st.builds("not ({})".format, inner)
    ),
    max_leaves=4,
)


@pytest.mark.exhaustive(keep=0.4)
@given(CONDITIONS, PLACES)
def test_conditions_are_those_of_python(text: str, indices: dict[str, int]) -> None:
    try:
        expected = eval(text, PYTHON, indices)
    except ZeroDivisionError:
        return
    tree = parse(f"sum(1 for k in range(1) if {text})")
    assert isinstance(tree, Sum)
    try:
        assert holds(tree.conditions[0], indices) == expected
    except ExpressionError as error:  # Python leaves out what would not change the answer
        assert "division by zero" in error.message


@pytest.mark.parametrize("bounds", ["N", "2, N", "N, 2, -1", "0, N, M", "3, 3", "-2, 2"])
def test_ranges_are_those_of_python(bounds: str) -> None:
    loop = parse(f"sum(k for k in range({bounds}))")
    assert isinstance(loop, Sum)
    assert counted(loop, SIZES) == eval(f"range({bounds})", {}, SIZES)


REFUSED = [
    ("0.5", "0.5 is not a whole number", "use whole numbers"),
    ("1e3", "1e3 is not a whole number", "write 1000"),
    ("i/2", "'/' is not allowed between whole numbers", "write //"),
    ("2**(i - 3)", "negative exponent, for i = 2", "no whole number"),
    ("9**(9**9)**i", "too large", ""),
    ("(-3)**(i*50 - 1)", "too large", ""),
    ("x", "'x' is neither an index nor a size here", "known: M, N, i"),
    ("n", "'n' is neither", "did you mean 'N'?"),
    ("u[0]", "'u' is neither", ""),
    ("sin(i)", "expected a whole number", ""),
    ("(1, 2)", "expected a whole number", ""),
    ("i % 0", "division by zero, for i = 2", "must not be 0"),
    (str(LARGEST + 1), "too large", str(LARGEST)),
    ("1" * 400, "too large", ""),
    ("N*" * 30 + "N", "too large", ""),
]


@pytest.mark.parametrize(("text", "message", "hint"), REFUSED, ids=[text[:20] for text, *_ in REFUSED])
def test_what_is_no_whole_number_is_refused(text: str, message: str, hint: str) -> None:
    with pytest.raises(ExpressionError) as caught:
        integer(parse(text), SIZES | {"i": 2})
    assert message in caught.value.message
    assert hint in caught.value.hint
    assert caught.value.hint


VALUES = {member_name("x", (i,)): float(i * i) for i in range(7)} | {"a": 0.5}


def scope(name: str) -> float | tuple[float, float]:
    if name.startswith("r["):
        return (VALUES["x" + name[1:]], 1.0)
    if name not in VALUES:
        raise NoMember("there are 7")
    return VALUES[name]


SUMS = [
    "sum(x[j] for j in range(N))",
    "sum(x[j]*a for j in range(i + 1))",
    "sum(x[j] for j in range(i, N))",
    "sum(x[N - 1 - j]*(j - i) for j in range(0, N, 2) if j != i)",
    "sum(x[(j + 1) % N] - x[j] for j in range(N))",
    "sum(x[j]*x[k] for j in range(N) for k in range(j) if (j + k) % 2 == 0)",
    "sum(x[j]*sum(x[k] for k in range(j)) for j in range(N))",
    "sum(sum(x[k] for k in range(j)) for j in range(i))",
    "-sum(1/(1 + i) for j in range(i))**2 + i % 2 - i//2",
    "sum(j for j in range(3, 3))",
]


@pytest.mark.parametrize("text", SUMS)
def test_sums_are_those_of_python(text: str) -> None:
    x = [VALUES[f"x[{i}]"] for i in range(7)]
    tree = parse(text)
    shared = Builder(scope, NumberAlgebra(), SIZES)
    graph = GraphAlgebra()
    graphs = Builder(lambda name: graph.number(repr(VALUES[name])), graph, SIZES)
    for i in (0, 3, 1, 6, 6):
        expected = eval(text, {"x": x, "a": 0.5, "i": i, **SIZES})
        assert build(tree, scope, NumberAlgebra(), {"i": i, **SIZES}) == pytest.approx(expected, rel=1e-14)
        assert shared.build(tree, {"i": i}) == pytest.approx(expected, rel=1e-14)
        assert graphs.build(tree, {"i": i}).data == pytest.approx(expected, rel=1e-14)


def test_sums_of_vectors_are_vectors() -> None:
    assert build(parse("sum(r[j] - (j, 0) for j in range(3))"), scope, NumberAlgebra()) == (2.0, 3.0)


def test_indices_are_exact_where_the_algebra_is() -> None:
    assert build(parse("i/N"), scope, SympyAlgebra(), {"i": 2, "N": 6}) * 3 == 1


@pytest.mark.parametrize(
    ("text", "start", "stop", "message"),
    [
        ("1 + x[i + 4]", 4, 12, "no member 'x[7]', for i = 3"),
        ("sum(x[j - i] for j in range(3, 11))", 4, 12, "no member 'x[7]', for i = 3, j = 10"),
        ("sum(x[-1] for j in range(2))", 4, 9, "no member 'x[-1]'"),
        ("sum(x[j]/(j - 2) for j in range(5))", 4, 16, "division by zero, for j = 2"),
        ("sum(r[j] for j in range(2)) + 1", 0, 31, "a vector and a scalar"),
        ("sum(x[j] for j in range(2, 4, 0))", 30, 31, "must not be 0"),
        ("a // 2", 0, 1, "'a' is neither"),
    ],
)
def test_what_is_wrong_within_a_sum_is_shown_there(text: str, start: int, stop: int, message: str) -> None:
    with pytest.raises(ExpressionError) as caught:
        build(parse(text), scope, NumberAlgebra(), {"i": 3})
    assert caught.value.span == Span(start, stop)
    assert message in caught.value.message
    assert caught.value.hint


@pytest.mark.exhaustive(keep=0.45)
def test_terms_are_bounded_and_shared_terms_count_once() -> None:
    builder = Builder(lambda name: 1.0, NumberAlgebra())
    prefix = parse("sum(x[j] for j in range(i + 1))")
    assert builder.build(prefix, {"i": MAX_TERMS // 2 - 1}) == MAX_TERMS // 2
    assert [builder.build(prefix, {"i": MAX_TERMS // 2 + i}) for i in range(100)][-1] == MAX_TERMS // 2 + 100
    with pytest.raises(ExpressionError, match=f"more than {MAX_TERMS} terms"):
        builder.build(parse("sum(x[j] for j in range(1000000000))"))


def test_terms_of_prefix_sums_are_asked_for_once() -> None:
    asked: list[str] = []
    builder = Builder(lambda name: asked.append(name) or 1.0, NumberAlgebra())  # type: ignore[func-returns-value]
    tree = parse("sum(x[j]**2 for j in range(i + 1)) + sum(x[j] for j in range(i, 50))")
    assert [builder.build(tree, {"i": i}) for i in range(50)] == [51.0] * 50
    assert len(asked) == 100


def test_names_of_members() -> None:
    assert member_name("bob.x", (1, 2)) == "bob[1,2].x"
    assert velocity_name("theta[3]") == "theta_dot[3]"
    assert acceleration_name("theta") == "theta_ddot"
    assert family_name("bob[1,2].x") == family_name("bob.x") == family_name("bob") == "bob"
