"""Random expressions of the language, as text, for hypothesis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import mpmath
from hypothesis import strategies as st

from lagrange_cli.expression.syntax import ExpressionError
from tests.support.motion import evaluate

UNARY = ["sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "exp", "log", "sqrt"]
NUMBERS = ["0", "1", "2", "3", "0.5", "1.25", "-1", "7"]
EXPONENTS = ["2", "3", "4", "-1", "-2", "0", "1", "0.5", "-0.5", "1.5", "-1.5", "0.3"]
LARGEST = 1e4
"""Values beyond this say more about rounding than about the expression."""


def texts(names: Sequence[str]) -> st.SearchStrategy[str]:
    """Expressions in ``names``, with every operation of the language."""
    leaves = st.sampled_from([*names] * 4 + NUMBERS)

    def grow(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
        pairs = st.tuples(inner, inner)
        return st.one_of(
            st.tuples(inner, st.sampled_from("+-*/"), inner).map(lambda t: f"({t[0]} {t[1]} {t[2]})"),
            pairs.map(lambda t: f"({t[0]} + {t[1]})"),
            pairs.map(lambda t: f"({t[0]}*{t[1]})"),
            st.tuples(inner, st.sampled_from(EXPONENTS)).map(lambda t: f"({t[0]})**{t[1]}"),
            st.tuples(st.sampled_from(UNARY), inner).map(lambda t: f"{t[0]}({t[1]})"),
            pairs.map(lambda t: f"atan2({t[0]}, {t[1]})"),
            pairs.map(lambda t: f"({t[0]})**({t[1]})"),
            inner.map(lambda u: f"(sin({u})**2 + cos({u})**2)"),
            inner.map(lambda u: f"-({u})"),
            st.tuples(st.sampled_from(["abs", "sign"]), inner).map(lambda t: f"{t[0]}({t[1]})"),
            st.tuples(st.sampled_from(["min", "max"]), inner, inner).map(lambda t: f"{t[0]}({t[1]}, {t[2]})"),
            st.tuples(conditions(inner), inner, inner).map(lambda t: f"where({t[0]}, {t[1]}, {t[2]})"),
        )

    return st.recursive(leaves, grow, max_leaves=8)


def conditions(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    """Conditions between such expressions."""
    compared = st.tuples(inner, st.sampled_from(["<", "<=", ">", ">="]), inner).map(" ".join)
    return st.one_of(
        compared,
        st.tuples(compared, st.sampled_from(["and", "or"]), compared).map(" ".join),
        compared.map(lambda one: f"not {one}"),
        st.tuples(inner, inner, inner).map(lambda t: f"{t[0]} < {t[1]} <= {t[2]}"),
    )


PRECISIONS = range(43, 54, 2)
"""Bits with which an expression is computed to see whether it amplifies rounding."""


def known(text: str, values: Mapping[str, float]) -> mpmath.mpf | None:
    """The value to many digits; None where it is not real and of moderate size, here and close by.

    What is 0 by an identity, 0**-1 or log of it is not asked for: a value that a change of 1e-25 of the
    arguments changes is none; and neither is one that fewer digits do not tell: asin of what is 1 by an
    identity.
    """
    exact, beside = (_computed(text, values, 170, shift) for shift in ("0", "1e-25"))
    if exact is None or beside is None or abs(exact - beside) >= 1e-18:
        return None
    for bits in PRECISIONS:
        rough = _computed(text, values, bits, "0")
        if rough is None or abs(exact - rough) >= 1e-9:
            return None
    return exact


def _computed(text: str, values: Mapping[str, float], bits: int, shift: str) -> mpmath.mpf | None:
    with mpmath.workprec(bits):
        try:
            perturbed = {name: mpmath.mpf(x) * (1 + mpmath.mpf(shift)) for name, x in values.items()}
            value = mpmath.mpmathify(evaluate(text, perturbed, real=True))
        except (ExpressionError, ValueError, OverflowError):
            return None
        if not mpmath.isfinite(value) or abs(value.imag) > 2.0 ** (60 - bits) or abs(value) > LARGEST:
            return None
        return mpmath.mpf(value.real)
