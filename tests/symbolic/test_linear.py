"""The explicit solution of linear equations: what is certain to be too long is not written."""

from __future__ import annotations

from pathlib import Path

import pytest
import sympy

from lagrange_cli.cli.main import main
from lagrange_cli.run import equations
from lagrange_cli.symbolic import linear
from lagrange_cli.symbolic.canonical import to_terms
from lagrange_cli.symbolic.linear import least_size, solve
from lagrange_cli.symbolic.order import Order, Role
from lagrange_cli.symbolic.work import size_of

a, x, y = sympy.symbols("a x y")
ORDER = Order({a: (Role.PARAMETER, 0), x: (Role.COORDINATE, 0), y: (Role.COORDINATE, 1)})
ROOT = sympy.sqrt(1 + x**2 + y**2)


@pytest.mark.parametrize(
    "value", [a * x + y, (a + x) * (y + ROOT), sympy.sin(x - y) * ROOT + a, x**3 * ROOT**3 / a, x + x * y + y]
)
def test_a_sum_is_not_shorter_than_its_factors_together(value: sympy.Expr) -> None:
    assert least_size(to_terms(value)) <= min(size_of(value), size_of(sympy.expand(value)))


def test_a_solution_that_is_certain_to_be_too_long_is_not_written(monkeypatch: pytest.MonkeyPatch) -> None:
    matrix, right = [[a + ROOT, x], [y, ROOT]], [x * sympy.sin(ROOT), y]
    found = solve(matrix, right.__getitem__, ORDER, longest=200)
    assert found is not None and max(map(size_of, found)) < 200
    monkeypatch.setattr(linear, "quotient", lambda *_: pytest.fail("it is written"))
    assert solve(matrix, right.__getitem__, ORDER, longest=15) is None


COUPLED = """
coordinates: {x: {initial: 0}, y: {initial: 0}, z: {initial: 0}, u: {initial: 0}}
lagrangian: >-
  x_dot**2 + y_dot**2 + z_dot**2 + u_dot**2
  + sin(x*y)*x_dot*y_dot + sin(y*z)*y_dot*z_dot + sin(z*u)*z_dot*u_dot - cos(x + u)
"""


def test_missing_explicit_accelerations_are_said_before_conserved_quantities_are_searched_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "coupled.yaml").write_text(COUPLED)
    monkeypatch.setattr(equations, "further_conserved", lambda *_: pytest.fail("they are searched for"))
    assert main(["equations", str(tmp_path / "coupled.yaml"), "--form", "explicit"]) == 2
    assert "the explicit accelerations are too long to print: use --form matrix" in capsys.readouterr().err
