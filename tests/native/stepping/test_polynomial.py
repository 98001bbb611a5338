"""The sum of a series over a step, against exact rational numbers."""

from __future__ import annotations

import ctypes
from fractions import Fraction

import numpy as np
import pytest

from lagrange_cli.native.compilation.llvm import compile_text
from lagrange_cli.native.compilation.machine import load
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Real
from lagrange_cli.native.stepping.polynomial import CAREFUL, careful_sum


def summed(c: np.ndarray, h: float) -> tuple[float, float]:
    """``careful_sum`` of these coefficients, compiled."""
    f = Function("define void @run(ptr %c, ptr %sums, double %h)")
    terms = [f.load("%c", k) for k in range(len(c))]
    for place, part in enumerate(careful_sum(f, terms, Real(f, "%h"))):
        f.store(part, "%sums", place)
    f.give()
    code = load(compile_text(f.text(), 1))
    sums = np.empty(2)
    run = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_double)(code.address("run"))
    run(c.ctypes.data, sums.ctypes.data, h)
    return float(sums[0]), float(sums[1])


@pytest.mark.parametrize("seed", range(10))
def test_rounding_of_the_first_terms_is_kept(seed: int) -> None:
    """What is left is the rounding of the rest, and of the further terms: an ulp of each of these few."""
    source = np.random.default_rng(seed)
    c = source.uniform(-1, 1, 12) * 0.05 ** np.arange(12.0)
    h = float(source.uniform(0.5, 1.0))
    exact = [Fraction(float(one)) * Fraction(h) ** (m + 1) for m, one in enumerate(c)]
    first, rest = summed(c, h)
    further = sum(abs(one) for one in exact[CAREFUL:])
    twice_rounded = Fraction(2) ** -104 * sum(map(abs, exact))
    bound = Fraction(2) ** -50 * (further + abs(Fraction(rest))) + 64 * twice_rounded
    assert abs(Fraction(first) + Fraction(rest) - sum(exact)) <= bound
