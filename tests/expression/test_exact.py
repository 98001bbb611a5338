"""Arithmetic of exact numbers, beside that of fractions."""

from __future__ import annotations

import math
from fractions import Fraction
from operator import add, mul, sub, truediv
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lagrange_cli.expression.exact import Exact, ExactGraph
from tests.support.draws import examples

RATIOS = st.one_of(
    st.integers(-9, 9).map(Fraction), st.fractions(max_denominator=99), st.integers().map(Fraction)
)
OTHERS = st.one_of(
    RATIOS,
    RATIOS.map(Exact),
    st.integers(-9, 9),
    st.floats(-9, 9).filter(lambda x: x == 0.0 or abs(x) > 1e-250),  # sums of others are rounded
    st.sampled_from([0.0, 1.0, math.inf, -math.inf]),
)


@examples(60)
@given(RATIOS, OTHERS, st.sampled_from([add, sub, mul, truediv]), st.booleans())
def test_operations_are_those_of_fractions(one: Fraction, other: Any, operation: Any, turned: bool) -> None:
    given = (other, Exact(one)) if turned else (Exact(one), other)
    if isinstance(other, float) and not math.isfinite(other):
        assert isinstance(operation(*given), float)
        return
    first, second = (Fraction(other), one) if turned else (one, Fraction(other))
    if operation is truediv and second == 0:
        with pytest.raises(ZeroDivisionError):
            operation(*given)
    else:
        found = operation(*given)
        assert type(found) is Exact and found == operation(first, second)
        assert math.gcd(found.numerator, found.denominator) == 1 and found.denominator > 0


def test_numbers_that_become_too_long_are_rounded() -> None:
    long = Exact(3**700, 2**900)
    product = long * long
    assert product != Fraction(long) * Fraction(long)
    assert abs(product / (Fraction(long) * Fraction(long)) - 1) < ExactGraph.rounding


def test_operations_of_exact_numbers_ask_fractions_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Most of what ``Fraction`` does is to find out what the other number is."""
    made = []
    plain = Fraction.__new__

    def counted(cls: type[Fraction], *numbers: Any) -> Fraction:
        made.append(numbers)
        return plain(cls, *numbers)

    x, y, half = Exact(3), Exact(5), Exact(1, 2)
    monkeypatch.setattr(Fraction, "__new__", counted)
    found = (x * 2.0 + y) * half - x / 4
    assert len(made) == 5  # the results
    assert found == Fraction(19, 4)
