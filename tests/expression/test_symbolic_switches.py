"""sympy reads a string among a function's arguments as a program: none may get there."""

from __future__ import annotations

import pytest
import sympy
from sympy.parsing import sympy_parser

from lagrange_cli.expression.build import build
from lagrange_cli.expression.parse import parse
from lagrange_cli.expression.symbolic import SympyAlgebra
from lagrange_cli.expression.symbolic_switches import Absolute, Largest, Least, Sign, Switch
from lagrange_cli.expression.syntax import ExpressionError
from lagrange_cli.run.equations import derive
from lagrange_cli.spec.read import read_spec
from lagrange_cli.symbolic.indexed.members import Summed

KINKS = """
coordinates: {x: {initial: 0.3}, y: {initial: 0.2}}
masses: {bead: 1}
embedding: {bead: [x, y]}
potential: abs(x)**3 + max(0, y)**2 + where(x > y, (x - y)**2, 0)
generalized_forces: {x: -0.1*sign(x_dot), y: -sin(y)*sqrt(2 + x)*atan2(y, 2 + x) - min(x, 1.5e-3)*exp(-y)}
"""


def test_no_text_reaches_functions(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(text: str, *_: object, **__: object) -> None:
        raise AssertionError(f"sympy was given {text!r} to run")

    monkeypatch.setattr(sympy_parser, "parse_expr", refuse)
    derive(read_spec(KINKS, "system.yaml"))
    with pytest.raises(AssertionError, match="to run"):  # it would be seen
        sympy.sympify("x")


PROGRAM = "__import__('os').abort()"


@pytest.mark.parametrize(
    "hidden", [PROGRAM, (PROGRAM,), [PROGRAM], {"u": PROGRAM}, {PROGRAM}, b"x"], ids=repr
)
@pytest.mark.parametrize("function", [Absolute, Sign, Largest, Least, Switch, Summed])
def test_text_is_refused_before_sympy_sees_it(function: type[sympy.Function], hidden: object) -> None:
    for place in range(4):
        arguments = [sympy.Symbol("u"), sympy.Integer(1), sympy.Integer(2), sympy.Integer(0)]
        arguments[place] = hidden
        with pytest.raises(TypeError, match="not text"):
            function(*arguments)


@pytest.mark.parametrize("text", ["max(x, exp(1/(x - x)))", "exp(1/(x - x))", "abs(0/(x - x))"])
def test_a_function_of_what_is_divided_by_zero_is_a_mistake(text: str) -> None:
    with pytest.raises(ExpressionError, match="division by zero"):
        build(parse(text), SympyAlgebra().symbol, SympyAlgebra())
