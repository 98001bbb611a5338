"""Text to tree: what is accepted, what is refused and how, and that spans are exact."""

from __future__ import annotations

import math

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from lagrange_cli.expression.cursor import MAX_NESTING, WRITTEN
from lagrange_cli.expression.keys import parse_key
from lagrange_cli.expression.numbers import NumberAlgebra, evaluate
from lagrange_cli.expression.parse import parse, read, read_printed
from lagrange_cli.expression.syntax import (
    Binary,
    Call,
    Comparison,
    ExpressionError,
    Logic,
    Name,
    Negative,
    Number,
    Span,
    Sum,
    Tree,
    Vector,
    children,
    names,
)
from lagrange_cli.expression.vocabulary import CALLABLE
from tests.support.draws import examples


def test_tree_with_spans() -> None:
    assert parse("-a.x*sin(2e-3)") == Binary(
        "*",
        Negative(Name("a.x", Span(1, 4)), Span(0, 4)),
        Call("sin", (Number("2e-3", Span(9, 13)),), Span(5, 14)),
        Span(0, 14),
    )


def test_precedence_is_that_of_python() -> None:
    assert evaluate(parse("-2**2 + 3*4/6 - 2**-1**2")) == -(2**2) + 3 * 4 / 6 - 2 ** -(1**2)
    assert evaluate(parse("8/4/2 - 1 - 1 + +3")) == 2


def test_offset_is_added_to_every_span() -> None:
    assert parse("a + b", 7).span == Span(7, 12)
    with pytest.raises(ExpressionError) as caught:
        parse("a + 2b", 7)
    assert caught.value.span == Span(11, 13)
    with pytest.raises(ExpressionError) as caught:
        parse("a + x**99", 7)
    assert caught.value.span == Span(14, 16)


def test_spans_count_characters() -> None:
    tree = parse("θ*sin(ü, 1)".replace(", 1", "") + " + ωω")
    assert [(name.identifier, name.span) for name in names(tree)] == [
        ("θ", Span(0, 1)),
        ("ü", Span(6, 7)),
        ("ωω", Span(11, 13)),
    ]


def test_vectors() -> None:
    for text in ("(x, y)", "x, y", "[x, y]", "x,\n\ty"):
        tree = parse(text)
        assert isinstance(tree, Vector)
        assert [name.identifier for name in names(tree)] == ["x", "y"]
    assert isinstance(parse("(x,)"), Vector)
    assert isinstance(parse("(x)"), Name)


REFUSED = [
    ("", 0, 1, "empty", ""),
    ("2x", 0, 2, "missing operator", "write 2*x"),
    ("m g", 0, 3, "missing operator", "write m*g"),
    ("m g h + 1", 0, 3, "missing operator between 'm' and 'g'", "write m*g*h"),
    ("m 2 (x)", 0, 3, "missing operator", "write m*2*(...)"),
    ("x(0)", 0, 1, "unknown function", "write x*0 for a product, or x[0] for a member"),
    ("6.67 x 10", 0, 6, "missing operator", "write 6.67*10"),
    ("2(x)", 0, 2, "missing operator", "write 2*(...)"),
    ("(a)(b)", 2, 4, "missing operator", "write (...)*(...)"),
    ("1_000*x", 0, 5, "unknown notation of a number", "write 1000"),
    ("2*0x10", 2, 6, "unknown notation of a number", "write 16"),
    ("0x1F", 0, 4, "unknown notation of a number", "write 31"),
    ("1,000", 0, 5, "comma in a number", "write 1000 or 1.000"),
    ("-12,345", 0, 7, "comma in a number", "write -12345 or -12.345"),
    ("1,000.5", 0, 7, "comma between thousands", "write 1000.5"),
    ("2,000,000", 0, 9, "comma between thousands", "write 2000000"),
    ("0,125", 0, 5, "decimal comma", "write 0.125"),
    ("cos(x₁)", 5, 6, "is not allowed", "write 1, or _1"),
    ("x\u200b*y", 1, 2, "invisible character U+200B", "delete it"),
    ("$m g y$", 0, 1, "expressions are not LaTeX", "write theta for"),
    ("np.pi*x", 0, 5, "'np.pi' is not a name", "write pi"),
    ("integrate(x, 0, 1)", 0, 9, "'integrate' is not supported", "the integral itself"),
    ("f(x, y)", 0, 1, "unknown function 'f'", "known: "),
    ("plate.at.z", 0, 10, "'plate.at' without coordinates", "write plate.at(a, b, c).z"),
    ("1.2.3", 0, 5, "missing operator", ""),
    ("sin x", 0, 5, "missing parentheses after 'sin'", "write sin(x)"),
    ("x squared", 0, 9, "power written as a word", "write x**2"),
    ("2*bob.y cubed + 1", 6, 13, "power written as a word", "write bob.y**3"),
    ("1.602×10^-19*x", 0, 12, "power of ten written as a product", "write 1.602e-19"),
    ("2 · 10**{−3}", 0, 12, "power of ten written as a product", "write 2e-3"),
    ("6.67 x 10^(-11)", 0, 15, "power of ten written as a product", "write 6.67e-11"),
    ("3*2X10⁻⁷", 2, 8, "power of ten written as a product", "write 2e-7"),
    ("6.67 e−11", 0, 9, "unknown notation of a number", "write 6.67e-11"),
    ("2e - 11", 0, 2, "missing operator between '2' and 'e'", ""),
    ("x*r⁻¹²", 3, 6, "unknown operator '⁻¹²'", "write **-12"),
    ("“x”", 0, 1, "quotation marks are not allowed", "leave them out"),
    ("1" + " m" * 60, 0, 3, "missing operator", ""),  # too long to be matched as a number with a unit
    ("5e3×10^2", 3, 4, "unknown operator '×'", "write *"),
    ("exp^x", 0, 5, "missing parentheses after 'exp'", "write exp(x)"),
    ("exp^(-x)", 0, 8, "missing parentheses after 'exp'", "write exp(-x)"),
    ("θ'", 0, 2, "prime", "θ_dot"),
    ("a = b", 2, 3, "'='", "leave out"),
    ("a == b", 2, 4, "comparison outside 'where' and the 'if' of a sum", "where(x > 0"),
    ("a < b", 2, 3, "comparison", ""),
    ("a if b else c", 2, 4, "condition outside", ""),
    ("not a", 0, 3, "condition", ""),
    ("a and b", 2, 5, "condition", ""),
    ("[x for x in y]", 3, 6, "'for' outside a sum", "sum("),
    ("x in y", 2, 4, "'in' outside a sum", ""),
    ("sum x", 0, 5, "missing parentheses after 'sum'", ""),
    ("sum(x)", 0, 6, "sum without a loop", "for j in range(N)"),
    ("sum(x for x in y)", 15, 16, "an index needs a range", "range(N)"),
    ("sum(x for i in range())", 15, 22, "wrong number of arguments for 'range'", ""),
    ("sum(x for i range(3))", 12, 17, "missing 'in' before 'range'", ""),
    ("sum(x for in range(3))", 10, 12, "missing name of the index before 'in'", ""),
    ("sum(for i in range(3))", 4, 7, "missing value before 'for'", ""),
    ("sum(x for 2 in range(3))", 10, 11, "an index must be a name", ""),
    ("sum(x for i.j in range(3))", 10, 13, "an index must be a name", ""),
    ("sum(x for pi in range(3))", 10, 12, "the name 'pi' is reserved", "pi_"),
    ("sum(x for i in range(3), 2)", 23, 24, "unexpected ','", ""),
    ("sum(x for i in range(3) if i = 2)", 29, 30, "'=' is not a comparison", "=="),
    ("sum(x for i in range(3) if)", 26, 27, "missing value after 'if'", ""),
    ("sum(x for i in range(3) if i else 2)", 29, 33, "'else' is not allowed", "where("),
    ("sum(x if i else 2 for i in range(3))", 6, 8, "condition outside", ""),
    ("sum(x for i in range(3) if i in range(2))", 29, 31, "'in'", ""),
    ("sin(x for i in range(3))", 6, 9, "'for' outside a sum", ""),
    ("sum(" * 9 + "x" + " for i in range(2))" * 9, 35, 36, "nested more than 8 deep", "definitions"),
    ("sum(x" + " for i in range(2)" * 9 + ")", 150, 153, "nested more than 8 deep", "definitions"),
    ("range(3)", 0, 5, "'range' outside a loop", ""),
    ("x[]", 2, 3, "missing index", "theta[0]"),
    ("x[1][2]", 4, 5, "misplaced index", "u[i, j]"),
    ("(x)[1]", 3, 4, "misplaced index", ""),
    ("bob.x[1]", 0, 8, "index after the component", "bob[i].x"),
    ("x[1:2]", 3, 4, "':'", ""),
    ("x[i in range(3)]", 4, 6, "'in' outside a sum", ""),
    ("x[1", 1, 2, "unclosed '['", "]"),
    ("abs(x, y)", 0, 9, "wrong number of arguments for 'abs': 2 instead of 1", "abs(x)"),
    ("min(x)", 0, 6, "wrong number of arguments for 'min': 1 instead of 2 or more", "min(x, y)"),
    ("where(x, 1, 2)", 6, 7, "'where' needs a condition first", "where(x > 0"),
    ("where(x > 0, 1)", 0, 15, "2 instead of 3", "a condition and two values"),
    ("where(x > 0, y > 0, 2)", 15, 16, "comparison outside", "where("),
    ("where(x = 0, 1, 2)", 8, 9, "'=' is not a comparison", "write =="),
    ("where(x =< 0, 1, 2)", 8, 9, "'=' is not a comparison", "write <="),
    ("sum(x for i in range(3) if i => 2)", 29, 30, "'=' is not a comparison", "write >="),
    ("1 if x > 0 else 2", 2, 4, "condition outside", "where("),
    ("floor(x)", 0, 5, "'floor' is not supported", "where()"),
    ("x[floor(i/2)]", 2, 7, "'floor' is not supported", "write //, as in i//2"),
    ("x[int((i - 1)/2)]", 2, 5, "'int' is not supported", "write //, as in i//2"),
    ("sum(x[i] for i in range(ceil(N/2)))", 24, 28, "'ceil' is not supported", "write //, as in i//2"),
    ("x[i//2] + int(x)", 10, 13, "'int' is not supported", "write the integral itself"),
    ("'a'", 0, 1, "quotation marks", ""),
    ("sin(x).y", 6, 7, "misplaced '.'", ""),
    ("a.b.c", 0, 5, "has no components", ""),
    ("a.(b)", 1, 2, "missing component", ""),
    ("sin(x, y=1)", 8, 9, "'='", ""),
    ("sin(*x)", 4, 5, "missing value", ""),
    ("sinn(x)", 0, 4, "unknown function 'sinn'", "did you mean 'sin'?"),
    ("arcsin(x)", 0, 6, "unknown function", "write asin"),
    ("m(x)", 0, 1, "unknown function 'm'", "write m*x for a product, or m[x] for a member of a family"),
    ("sin()", 0, 5, "0 instead of 1", "sin(x)"),
    ("atan2(x)", 0, 8, "1 instead of 2", "atan2(x, y)"),
    ("x^2", 1, 2, "'^'", "write ** for powers"),
    ("a +", 2, 3, "missing value after '+'", ""),
    ("5%", 1, 2, "missing value after '%'", "write 5% as 0.05"),
    ("(a + )", 5, 6, "missing value after '+'", ""),
    ("*a", 0, 1, "missing value before '*'", ""),
    ("a,,b", 2, 3, "missing value after ','", ""),
    ("(a", 0, 1, "unclosed", ""),
    ("a)", 1, 2, "unmatched", ""),
    ("(a]", 2, 3, "unmatched", ""),
    ("()", 0, 2, "a vector of 0 components", ""),
    ("(1, 2, 3, 4)", 0, 12, "a vector of 4 components", ""),
    ("x²", 1, 2, "'²'", "**2"),
    ("−x", 0, 1, "minus", "write -"),
    ("007", 0, 3, "leading zero", "write 7"),
    ("1e999", 0, 5, "too large", ""),
    ("2*1e-400", 2, 8, "too small", "4.9e-324"),
    ("x + .0001E-330", 4, 14, "too small", "4.9e-324"),
    ("__import__('os').system('x')", 11, 12, "quotation marks", ""),
    ("__import__(os)", 0, 10, "unknown function", ""),
    ("x := 1", 2, 3, "':'", ""),
    ("x; y", 1, 2, "';'", "a comma"),
    ("a # b", 2, 3, "'#'", ""),
    ("a\\\nb", 1, 2, "not LaTeX", "theta_dot for"),
    ("\ud800", 0, 1, "is not allowed", ""),
    ("a\0", 1, 2, "is not allowed", ""),
    ("x**65", 3, 5, "the exponent 65 is out of bounds", ""),
    ("x**-65", 3, 6, "the exponent -65", ""),
    ("9**9**9**9", 6, 10, "the exponent 3.8742e8", ""),
    ("9**(9**9)", 4, 8, "the exponent 3.8742e8", ""),
    ("x**(1/0)", 4, 7, "division by zero", ""),
    ("x**(1, 2)", 3, 9, "a vector", ""),
    ("x" * (WRITTEN.length + 1), 0, 1, "too long", "definitions"),
    ("(" * 4000 + "x" + ")" * 4000, MAX_NESTING, MAX_NESTING + 1, "nested more than", "definitions"),
    ("-" * 4000 + "x", MAX_NESTING, MAX_NESTING + 1, "nested more than", ""),
    ("x" + "**x" * 3000, 3 * MAX_NESTING + 1, 3 * MAX_NESTING + 3, "nested more than", ""),
    ("sin(" * 1500 + "x" + ")" * 1500, 4 * MAX_NESTING + 3, 4 * MAX_NESTING + 4, "nested more than", ""),
    ("x" + "+x" * 4000, 2 * WRITTEN.operators + 1, 2 * WRITTEN.operators + 2, "more than 1000 operators", ""),
]


@pytest.mark.exhaustive(keep=87)
@pytest.mark.parametrize(
    ("text", "start", "stop", "message", "hint"), REFUSED, ids=[ascii(text[:30]) for text, *_ in REFUSED]
)
def test_refused_with_place_and_way_out(text: str, start: int, stop: int, message: str, hint: str) -> None:
    with pytest.raises(ExpressionError) as caught:
        parse(text)
    assert caught.value.span == Span(start, stop)
    assert message in caught.value.message
    assert hint in caught.value.hint
    assert caught.value.hint


@pytest.mark.parametrize(
    "name", ["lambda", "is", "from", "class", "None", "True", "def", "yield", "async", "import"]
)
def test_words_of_python_are_names(name: str) -> None:
    tree = parse(f"2*{name}**2 + {name}_dot*{name}[0].x")
    assert [one.identifier for one in names(tree)] == [name, f"{name}_dot", f"{name}.x"]
    assert parse_key(f"{name}[i in range(3)]").name == name


HABITS = [
    # what is written, what it is read as, and the hint of each mistake
    ("x^2", "x**2", ["write ** for powers"]),
    ("x²·y", "x**2*y", ["write **2", "write *, or dot(a, b) for vectors"]),
    ("2x − 3 y", "2*x - 3*y", ["write 2*x", "write -", "write 3*y"]),
    ("a×b÷c", "a*b/c", ["write *, or cross(a, b) for vectors", "write /"]),
    ("√(x)", "sqrt(x)", ["write sqrt(...)"]),
    ("{x + y}*z", "(x + y)*z", ["write (", "write )"]),
    ("U = m*y", "m*y", ["leave out 'U ='"]),
    ("m*x(t)", "m*x", ["write x: coordinates have no '(t)'"]),
    ("x'*y", "x*y", ["write x_dot for the velocity of x"]),
    ("x´ + x\u0307", "x + x", ["write x_dot for the velocity of x"] * 2),
    (
        "\u03b8\u0307_1*\u03b8\u03071",
        "\u03b8_1*\u03b81",
        [f"write {name}_dot for the velocity of {name}" for name in ("\u03b8_1", "\u03b81")],
    ),
    ("x\u0308", "x", ["the equations of motion determine them"]),
    ("d(x)/dt*2", "x*2", ["write x_dot for the velocity of x"]),
    ("d/dt(bob.y)*2", "bob.y*2", ["write bob.vy for the velocity of bob.y"]),
    ("2*d/dt x", "2*x", ["write x_dot for the velocity of x"]),
    ("cos 2x", "[2]*x", ["write cos(2*x)", "write 2*x"]),
    ("x''", "x", ["the equations of motion determine them"]),
    ("sin(30 deg)", "sin(30)", ["angles are in radians: write 30*pi/180"]),
    ("cos(0.5rad)", "cos(0.5)", ["leave out 'rad': angles are in radians"]),
    (
        "k*|x| + y",
        "k*x + y",
        ["write abs(x), or norm(a) for the length of a vector; in conditions, write or"],
    ),
    ("sin²(x) + y", "[x] + y", ["write sin(x)**2"]),
    ("cos(30°)", "cos(30)", ["angles are in radians: write 30*pi/180"]),
]


@pytest.mark.parametrize(("text", "meant", "hints"), HABITS, ids=[text for text, *_ in HABITS])
def test_habits_are_read_as_what_they_mean(text: str, meant: str, hints: list[str]) -> None:
    tree, errors = read(text)
    assert [error.hint for error in errors] == hints
    assert bare(tree) == bare(parse(meant))


MEANT = {
    "ln": "log(x)", "log10": "log(x)/log(10)", "arctan": "atan(x)", "arcsin": "asin(x)", "arccos": "acos(x)",
    "Sin": "sin", "SQRT": "sqrt", "sec": "1/cos(x)", "hypot": "sqrt(x**2 + y**2)", "mag": "norm(a)",
    "mod": "x % n", "Abs": "abs", "sgn": "sign(x)", "Heaviside": "where(x > 0, 1, 0)",
    "step": "where(x > 0, 1, 0)",
    "Piecewise": "where(x > 0, a, b)", "Max": "max", "fabs": "abs(x)", "floor": "where()",
}  # fmt: skip


@pytest.mark.parametrize(("function", "hint"), MEANT.items())
def test_functions_of_other_languages_have_a_hint(function: str, hint: str) -> None:
    (error,) = read(f"1 + {function}(x + 1)")[1]
    assert error.span == Span(4, 4 + len(function))
    assert hint in error.hint


def nested(depth: int, text: str) -> list[ExpressionError]:
    return nested(depth - 1, text) if depth else read(text)[1]


@pytest.mark.parametrize("opening", ["1 + 1*(", "-sin(", "(1, ", "-(", "1 + 2*norm("])
def test_what_is_nested_is_read_from_anywhere(opening: str) -> None:
    deepest = MAX_NESTING // sum(opening.count(sign) for sign in "-(")
    text = opening * deepest + "x" + ")" * deepest
    assert read(text)[1] == []
    (error,) = nested(900, text)
    assert error.message == "expression nested too deep"


def bare(tree: Tree) -> object:
    """The tree without its places."""
    own = [value for value in vars(tree).values() if isinstance(value, str)]
    return type(tree).__name__, own, [bare(one) for one in children(tree)]


def test_all_mistakes_of_an_expression_are_found() -> None:
    text = "sinn(x)^2 + 3y*atan2(x) + x**99 - bob.x.y + (a"
    places = sorted((error.span.start, error.span.stop) for error in read(text)[1])
    assert [text[start:stop] for start, stop in places] == [
        "sinn", "^", "3y", "atan2(x)", "99", "bob.x.y", "(",
    ]  # fmt: skip
    assert [error.hint for error in read("(x + 1]*(y")[1]] == ["leave it out, or open it first"]


def test_the_bounds_themselves_are_accepted() -> None:
    assert evaluate(parse("1" + "+1" * WRITTEN.operators)) == WRITTEN.operators + 1
    assert evaluate(parse("(" * MAX_NESTING + "1" + ")" * MAX_NESTING)) == 1
    assert evaluate(parse("(1 - 1)*" * 300 + "1")) == 0
    assert evaluate(parse(" + ".join(["-1"] * 200))) == -200
    assert evaluate(parse("1" * 300)) == pytest.approx(1e300 / 9, rel=1e-12)
    assert parse("x**64")
    assert parse("x**-64")
    assert parse("x**(-3/2)")
    assert parse("x**2**3")
    assert parse("x**(a + 1000)")


@pytest.mark.exhaustive(keep=0.2)
def test_our_own_text_is_read_however_long_it_is() -> None:
    """Only nesting takes stack, and that is bounded."""
    assert evaluate(read_printed("1" + " + 2*1" * WRITTEN.length)) == 2 * WRITTEN.length + 1
    assert evaluate(read_printed("2" + "*2/2" * WRITTEN.length)) == 2
    with pytest.raises(ExpressionError, match="nested more than 100 deep"):
        read_printed("sin(" * (MAX_NESTING + 1) + "x" + ")" * (MAX_NESTING + 1))


@pytest.mark.exhaustive(keep=0.7)
@given(st.text(st.sampled_from("abxyt019.+-*/()[], '^=eθ²'\n\t_"), max_size=40) | st.text(max_size=20))
@example("ำ")  # it may stand within a name, but not begin one
@example("ำ²3ำx")
@example("x²3²")
@examples(150)
def test_any_text_is_a_tree_or_an_expression_error(text: str) -> None:
    try:
        tree = parse(text)
    except ExpressionError as error:
        assert 0 <= error.span.start < error.span.stop <= max(1, len(text))
        assert error.message
        assert error.hint
    else:
        for name in names(tree):
            assert name.span.stop <= len(text)


def written(tree: Tree) -> str:
    """The tree as text, each operation in its own parentheses."""
    if isinstance(tree, Number):
        return tree.text
    if isinstance(tree, Name):
        indices = f"[{', '.join(map(written, tree.indices))}]" if tree.indices else ""
        return tree.base + indices + tree.identifier.removeprefix(tree.base)
    if isinstance(tree, Sum):
        conditions = "".join(f" if {written(one)}" for one in tree.conditions)
        loop = f" for {tree.index} in range({', '.join(map(written, tree.bounds))}){conditions}"
        return f"sum({written(tree.body)}{loop})"
    if isinstance(tree, Comparison):
        pairs = zip(tree.operators, tree.operands[1:])
        return "(" + written(tree.operands[0]) + "".join(f" {sign} {written(x)}" for sign, x in pairs) + ")"
    if isinstance(tree, Logic):
        if tree.operator == "not":
            return f"(not {written(tree.operands[0])})"
        return "(" + f" {tree.operator} ".join(map(written, tree.operands)) + ")"
    if isinstance(tree, Negative):
        return f"(-{written(tree.operand)})"
    if isinstance(tree, Binary):
        return f"({written(tree.left)} {tree.operator} {written(tree.right)})"
    if isinstance(tree, Call):
        return f"{tree.function}({', '.join(map(written, tree.arguments))})"
    return f"({', '.join(map(written, tree.items))},)"


def unplaced(tree: Tree) -> object:
    """The tree without its spans."""
    if isinstance(tree, Number):
        return tree.text
    if isinstance(tree, Name):
        return tree.identifier, *map(unplaced, tree.indices)
    if isinstance(tree, Sum):
        return (
            "sum",
            tree.index,
            *(tuple(map(unplaced, x)) for x in ((tree.body,), tree.bounds, tree.conditions)),
        )
    if isinstance(tree, Comparison):
        return tree.operators, *map(unplaced, tree.operands)
    if isinstance(tree, Logic):
        return tree.operator, *map(unplaced, tree.operands)
    if isinstance(tree, Negative):
        return "-", unplaced(tree.operand)
    if isinstance(tree, Binary):
        return tree.operator, unplaced(tree.left), unplaced(tree.right)
    if isinstance(tree, Call):
        return tree.function, *map(unplaced, tree.arguments)
    return "vector", *map(unplaced, tree.items)


NOWHERE = Span(0, 0)


WHOLE: st.SearchStrategy[Tree] = st.one_of(
    st.builds(Number, st.sampled_from(["0", "12"]), st.just(NOWHERE)),
    st.builds(Name, st.sampled_from(["i", "N"]), st.just(NOWHERE)),
)
SIGNS = st.sampled_from(["==", "!=", "<", "<=", ">", ">="])
COMPARISONS: st.SearchStrategy[Tree] = st.lists(WHOLE, min_size=2, max_size=3).flatmap(
    lambda operands: st.builds(
        Comparison,
        st.lists(SIGNS, min_size=len(operands) - 1, max_size=len(operands) - 1).map(tuple),
        st.just(tuple(operands)),
        st.just(NOWHERE),
    )
)
CONDITIONS: st.SearchStrategy[Tree] = st.recursive(
    COMPARISONS,
    lambda inner: st.one_of(
        st.builds(Logic, st.just("not"), st.tuples(inner), st.just(NOWHERE)),
        st.builds(Logic, st.sampled_from(["and", "or"]), st.tuples(inner, inner), st.just(NOWHERE)),
    ),
    max_leaves=3,
)


def sums_of(body: st.SearchStrategy[Tree]) -> st.SearchStrategy[Tree]:
    return st.builds(
        Sum,
        body,
        st.sampled_from("ij"),
        st.lists(WHOLE, min_size=1, max_size=3).map(tuple),
        st.lists(CONDITIONS, max_size=2).map(tuple),
        st.just(NOWHERE),
        st.just(NOWHERE),
    )


def larger(inner: st.SearchStrategy[Tree]) -> st.SearchStrategy[Tree]:
    calls = st.sampled_from(sorted(CALLABLE.items() - {("where", 3)})).flatmap(
        lambda one: st.builds(Call, st.just(one[0]), st.tuples(*[inner] * one[1]), st.just(NOWHERE))
    )
    return st.one_of(
        st.builds(Negative, inner, st.just(NOWHERE)),
        st.builds(Binary, st.sampled_from("+-*/"), inner, inner, st.just(NOWHERE)),
        st.builds(
            Binary, st.just("**"), inner, st.builds(Name, st.just("n"), st.just(NOWHERE)), st.just(NOWHERE)
        ),
        calls,
        st.builds(Call, st.just("where"), st.tuples(CONDITIONS, inner, inner), st.just(NOWHERE)),
        st.builds(Binary, st.sampled_from(["//", "%"]), WHOLE, WHOLE, st.just(NOWHERE)),
        st.builds(
            Name, st.sampled_from(["u", "bob.x"]), st.just(NOWHERE), st.lists(WHOLE, min_size=1).map(tuple)
        ),
        sums_of(inner),
        st.builds(Vector, st.lists(inner, min_size=1, max_size=3).map(tuple), st.just(NOWHERE)),
    )


TREES: st.SearchStrategy[Tree] = st.recursive(
    st.one_of(
        st.builds(Number, st.sampled_from(["0", "1", "2.5", "1e-3", ".5", "3."]), st.just(NOWHERE)),
        st.builds(Name, st.sampled_from(["x", "theta_dot", "bob.x", "θ", "pi"]), st.just(NOWHERE)),
    ),
    larger,
    max_leaves=20,
)


@pytest.mark.exhaustive(keep=0.3)
@given(TREES)
@settings(deadline=None)
def test_what_is_written_is_read_back(tree: Tree) -> None:
    text = written(tree)
    found = parse(text)
    assert unplaced(found) == unplaced(tree)
    for name in names(found):
        assert text[name.span.start : name.span.stop] == written(name)


def test_loops_of_one_sum_are_sums_within_one_another() -> None:
    (outer,) = [parse("sum(x for i in range(2) if i for j in range(i))")]
    assert isinstance(outer, Sum) and isinstance(outer.body, Sum)
    assert (outer.index, outer.body.index) == ("i", "j")
    assert len(outer.conditions) == 1 and outer.body.conditions == ()


def test_names_are_those_of_quantities_and_not_of_whole_numbers() -> None:
    tree = parse("sum(a*i*u[i + k].x*(N % 2) for i in range(M) if i != L) + i + v[0]")
    assert [name.identifier for name in names(tree)] == ["a", "u.x", "i", "v"]


KEYS = [
    ("theta", "theta", "theta"),
    ("θ", "θ", "θ"),
    ("theta[0]", "theta", "theta[0]"),
    ("theta[i in range(N)]", "theta", "theta[i]"),
    ("u[ i in range(N) , j in range(1, M, 2)]", "u", "u[i,j]"),
    ("u[N - 1, j in range(M)]", "u", "u[N - 1,j]"),
]


@pytest.mark.parametrize(("text", "name", "label"), KEYS, ids=[text for text, *_ in KEYS])
def test_a_key_is_a_name_or_members_of_a_family(text: str, name: str, label: str) -> None:
    key = parse_key(text)
    assert (key.name, key.label) == (name, label)


@pytest.mark.parametrize(
    ("text", "start", "stop", "message"),
    [
        ("u[i in N]", 7, 8, "an index needs a range"),
        ("u[i in range(2), i in range(3)]", 17, 30, "the index 'i' is used twice"),
        ("u[t in range(2)]", 2, 3, "the name 't' is reserved"),
        ("u[2 in range(2)]", 2, 3, "an index must be a name"),
        ("u[i in range(2) if]", 18, 19, "missing value after 'if'"),
        ("u[i < 2]", 4, 5, "comparison"),
        ("u[x[i in range(2)]]", 6, 8, "'in' outside a sum"),
        ("u[0].x", 0, 6, "neither a name nor a family"),
        ("u.x", 0, 3, "neither a name nor a family"),
        ("u + v", 0, 5, "neither a name nor a family"),
        ("u[]", 2, 3, "missing index"),
        ("", 0, 1, "missing name"),
    ],
)
def test_other_keys_are_refused(text: str, start: int, stop: int, message: str) -> None:
    with pytest.raises(ExpressionError) as caught:
        parse_key(text)
    assert caught.value.span == Span(start, stop)
    assert message in caught.value.message
    assert caught.value.hint


def test_functions_of_numbers() -> None:
    for text, value in [
        ("sin(1)", math.sin(1)),
        ("atan2(1, -2)", math.atan2(1, -2)),
        ("norm((3, 4))", 5.0),
        ("dot((1, 2, 3), (4, 5, 6))", 32.0),
        ("dot(cross((1, 0, 0), (0, 1, 0)), (0, 0, 7))", 7.0),
        ("norm(2*(1, 2)/2 - (1, 2)*1 + -(0, 1))", 1.0),
        ("log(exp(2))*sqrt(4)*pi", 4 * math.pi),
    ]:
        assert evaluate(parse(text)) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    "text", ["sqrt(-1)", "1/0", "exp(1000)", "1e308*10", "(-1)**0.5", "10.0**309", "(1, 2)", "0**-1"]
)
def test_what_is_no_finite_number_is_refused(text: str) -> None:
    with pytest.raises(ExpressionError):
        evaluate(parse(text))


def test_numbers_have_no_derivative() -> None:
    algebra = NumberAlgebra({"x": 2.0})
    assert algebra.symbol("x") == 2.0
    with pytest.raises(NotImplementedError):
        algebra.diff(2.0, 2.0)


def test_an_exponent_may_be_a_whole_number_of_indices() -> None:
    tree = parse("sum(x[i]**(2 + 2*(i % 2)) for i in range(3))")
    assert "%" in repr(tree)
