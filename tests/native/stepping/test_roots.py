"""The first root of a guard's argument within a step, against polynomials whose roots are known."""

from __future__ import annotations

import ctypes
from collections.abc import Callable

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from lagrange_cli.native.compilation.llvm import compile_text
from lagrange_cli.native.compilation.machine import load
from lagrange_cli.native.stepping.roots import BACK, Roots

ORDER = 29
First = Callable[[Polynomial, float, float, bool], float]


@pytest.fixture(scope="module")
def first_root() -> First:
    """``@first_root`` for a polynomial, compiled."""
    roots = Roots(ORDER, 1)
    text = roots.text().replace("define internal double @first_root", "define double @first_root")
    code = load(compile_text(text, 1))
    pointer, real = ctypes.c_void_p, ctypes.c_double
    kinds = (pointer, real, real, real, ctypes.c_bool, pointer)
    call = ctypes.CFUNCTYPE(real, *kinds)(code.address("first_root"))

    def first(u: Polynomial, h: float, side: float, fresh: bool) -> float:
        assert code is not None
        row, scratch = np.zeros(ORDER + 1), np.zeros(3 * (roots.degree + 1))
        row[1 : len(u.coef) + 1] = u.coef / np.arange(1, len(u.coef) + 1)
        return float(call(row.ctypes.data, h, 0.0, side, fresh, scratch.ctypes.data))

    return first


@pytest.mark.exhaustive(keep=6)
@pytest.mark.parametrize("seed", range(20))
def test_no_root_is_missed(first_root, seed):
    """Up to seven real roots, many of them close together, and complex ones near the step."""
    source = np.random.default_rng(seed)
    for _ in range(50):
        places = np.sort(source.uniform(-0.3, 1.5, source.integers(0, 8)))
        places = places[np.diff(places, prepend=-9.0) > 1e-3]  # closer ones are conditioned badly
        u = Polynomial.fromroots(places) if len(places) else Polynomial([1.0])
        for centre in source.uniform(-0.2, 1.2, 4):
            u *= Polynomial([centre**2 + source.uniform(1e-4, 1.0), -2 * centre, 1.0])
        wanted = next((x for x in places if x > 0), np.inf)
        found = first_root(u, 1.3, float(np.sign(u(0.0))), False)
        if wanted > 1.3:
            assert found == np.inf
        else:
            noise = 1e-14 * Polynomial(np.abs(u.coef))(wanted) / abs(u.deriv()(wanted))
            assert found == pytest.approx(wanted, abs=noise, rel=1e-14)


def test_a_root_that_is_only_touched_is_none(first_root):
    assert first_root(Polynomial([0.25, -1.0, 1.0]) + 1e-12, 1.0, 1.0, False) == np.inf


@pytest.mark.parametrize("start", [1e-17, -1e-17, 0.0])
def test_the_root_at_which_a_step_begins_does_not_count(first_root, start):
    """Whatever rounding made of it; the next coefficient tells where the motion goes."""
    u = Polynomial([start, 1.0, -2.0])
    assert first_root(u, 1.0, 1.0, True) == pytest.approx(0.5, rel=1e-14)
    assert first_root(u, 1.0, -1.0, True) == BACK
    assert first_root(Polynomial([start, 0.0, 3.0]), 1.0, 1.0, True) == np.inf
