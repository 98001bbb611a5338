"""Random expressions of the language, as text, for hypothesis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import mpmath
from hypothesis import strategies as st

from lagrange_cli.expression.syntax import ExpressionError
from tests.motion import evaluate

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
        )

    return st.recursive(leaves, grow, max_leaves=8)


def known(text: str, values: Mapping[str, float]) -> mpmath.mpf | None:
    """The value to many digits; None where it is not real and of moderate size, here and close by.

    What is 0 by an identity, 0**-1 or log of it is not asked for: a value that a change of 1e-25 of the
    arguments changes is none.
    """
    found = []
    with mpmath.workdps(50):
        for shift in (0, mpmath.mpf(10) ** -25):
            try:
                nudged = {name: mpmath.mpf(x) * (1 + shift) for name, x in values.items()}
                value = evaluate(text, nudged, real=True)
            except (ExpressionError, ValueError, OverflowError):
                return None
            value = mpmath.mpmathify(value)
            if not mpmath.isfinite(value) or abs(value.imag) > mpmath.mpf(10) ** -30 or abs(value) > LARGEST:
                return None
            found.append(mpmath.mpf(value.real))
        return found[0] if abs(found[0] - found[1]) < mpmath.mpf(10) ** -18 else None
