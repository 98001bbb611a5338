"""Arguments of Python programs: numbers and tables of any kind."""

from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest
import sympy

import lagrange_cli as lagrange
from tests.support.command import SYSTEMS

PENDULUM = SYSTEMS / "pendulum.yaml"

TENTHS = [
    Decimal("0.1"), Fraction(1, 10), np.float64(0.1), np.array(0.1), sympy.Rational(1, 10),
    sympy.Float("0.1"),
]  # fmt: skip


@pytest.mark.parametrize("number", TENTHS, ids=lambda number: type(number).__name__)
def test_a_number_of_any_kind_is_a_number(number):
    assert lagrange.solve(PENDULUM, set={"l": number}, stop=1).parameters["l"] == 0.1


def test_a_number_of_sympy_may_be_a_formula():
    found = lagrange.solve(PENDULUM, set={"theta": sympy.pi / 3}, stop=sympy.sqrt(2)).q["theta"][0]
    assert found == float(sympy.pi / 3)


@pytest.mark.parametrize("wrong", [Decimal("nan"), sympy.Symbol("x"), sympy.I, 1j, True, None, "", b"2"])
def test_what_is_no_number_is_refused(wrong):
    with pytest.raises(lagrange.UsageError, match="set: l must be a number or an expression"):
        lagrange.solve(PENDULUM, set={"l": wrong}, stop=1)


class Frame:
    """What tables of pandas, polars and astropy have in common."""

    def __init__(self, columns):
        self.columns, self._columns = np.array([*columns]), columns

    def __getitem__(self, name):
        return self._columns[name]


def structured(columns):
    """The columns as a structured array."""
    return np.array([*zip(*columns.values())], dtype=[(name, float) for name in columns])


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("kind", [dict, Frame, structured])
def test_a_table_is_anything_with_columns(kind):
    lengths, angles = [1.0, 2.0], [0.1, 0.2]
    swept = lagrange.sweep(PENDULUM, table=kind({"l": lengths, "theta": angles}), stop=1)
    alone = (lagrange.solve(PENDULUM, set={"l": a, "theta": x}, stop=1) for a, x in zip(lengths, angles))
    assert swept.q["theta"] == pytest.approx([motion.q["theta"][-1] for motion in alone], abs=1e-13)


@pytest.mark.parametrize("wrong", [3, [{"l": 1}], np.ones((2, 2))], ids=["number", "records", "matrix"])
def test_what_has_no_columns_is_no_table(wrong):
    with pytest.raises(lagrange.UsageError, match="table must be the name of a CSV file, or columns by name"):
        lagrange.sweep(PENDULUM, table=wrong, stop=1)


@pytest.mark.parametrize("wrong", [[1, None], b"12", [True, False], ["1", "2"], np.array(["1"])])
def test_what_numpy_takes_for_numbers_is_refused(wrong):
    """None is nan for it, a text the number that it shows, and True is 1."""
    with pytest.raises(lagrange.UsageError, match="over: l must be a sequence of numbers"):
        lagrange.sweep(PENDULUM, over={"l": wrong})
    with pytest.raises(lagrange.UsageError, match="table: l must be a sequence of numbers"):
        lagrange.sweep(PENDULUM, table={"l": wrong})


@pytest.mark.parametrize("name", ["portable", "proven", "project_initial", "certify", "cache"])
def test_a_text_is_neither_yes_nor_no(name):
    """``portable="no"`` would be yes."""
    with pytest.raises(lagrange.UsageError, match=f"{name} must be True or False, not 'no'"):
        lagrange.solve(PENDULUM, stop=1, **{name: "no"})
    assert lagrange.solve(PENDULUM, stop=1, **{name: np.bool_(False)}).status == "complete"


def test_a_text_replaces_no_file(folder):
    motion = lagrange.solve(PENDULUM, stop=1)
    motion.save("run.h5")
    for result in (motion, lagrange.load("run.h5")):
        with pytest.raises(lagrange.UsageError, match="force must be True or False, not 'no'"):
            result.save("run.h5", force="no")


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"methods": 3}, "methods must be a list of at least one, not 3"),
        ({"methods": []}, "methods must be a list of at least one"),
        ({"tolerances": 1e-6}, "tolerances must be a list of at least one, not 1e-06"),
        ({"tolerances": [np.nan]}, "tolerances must be a finite number, not nan"),
        ({"size": {"N": [2]}}, r"size: N must be a number or an expression, not \[2\]"),
    ],
)
def test_what_cannot_be_compared_is_refused(given, message):
    with pytest.raises(lagrange.UsageError, match=message):
        lagrange.bench(PENDULUM, stop=1, **given)


def test_an_unknown_form_is_refused():
    equations = lagrange.equations(PENDULUM)
    for ask in (equations.as_data, lambda form: equations.write(form=form)):
        with pytest.raises(lagrange.UsageError, match="unknown form 'newton'; known: lagrange, "):
            ask("newton")


def test_a_single_member_is_one_member():
    assert ": 1 member (1 l)" in repr(lagrange.sweep(PENDULUM, over={"l": 2}, stop=1))
