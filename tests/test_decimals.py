"""Numbers in messages are written as in files."""

from __future__ import annotations

import ast
import math
import re
from pathlib import Path

import pytest

import lagrange_cli
from lagrange_cli.decimals import decimal, exact, scientific

PACKAGE = Path(lagrange_cli.__file__).parent
READ_BACK = {
    "integrate/stiffness.py",
    "expression/zero.py",
    "run/trial.py",
    "figures/film.py",
    "expression/written.py",
}
"""Where a number is rounded or handed to a program, and not shown."""


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (1e-9, "1e-9"),
        (-2.5e7, "-2.5e7"),
        (0.0001, "0.0001"),
        (123456.0, "123456"),
        (1e300, "1e300"),
        (0.0, "0"),
    ],
)
def test_a_number_in_few_digits_is_written_as_in_files(value, text):
    assert decimal(value) == text
    assert float(text) == value


@pytest.mark.parametrize(
    ("value", "text"), [(1.44e-6, "1.4e-6"), (7.1e-15, "7.1e-15"), (0.0, "0.0"), (1.5, "1.5")]
)
def test_errors_have_an_exponent_unless_it_is_0(value, text):
    assert scientific(value) == text


@pytest.mark.parametrize("value", [1e-9, 0.1 + 0.2, 5e-324, 1.7976931348623157e308, -3.0])
def test_exact_numbers_are_read_back_to_the_last_bit(value):
    assert float(exact(value)) == value and "e-0" not in exact(value) and "+" not in exact(value)


def test_what_is_no_finite_number_is_written_too():
    assert [decimal(math.inf), scientific(-math.inf), decimal(math.nan)] == ["inf", "-inf", "nan"]


def test_every_number_that_is_shown_is_written_by_these_functions():
    own = [
        f"{name}:{part.lineno}"
        for path in sorted(PACKAGE.rglob("*.py"))
        if (name := path.relative_to(PACKAGE).as_posix()) not in READ_BACK | {"decimals.py"}
        if re.search(r"[^\w{][eg]\}|\d[eg]\}", text := path.read_text(encoding="utf-8"))
        for part in ast.walk(ast.parse(text))
        if isinstance(part, ast.FormattedValue)
        and isinstance(part.format_spec, ast.JoinedStr)
        and ast.unparse(part.format_spec).rstrip("'\"")[-1:] in "eg"
    ]
    assert own == []
