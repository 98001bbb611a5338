"""The first root of a guard's argument within a step, against polynomials whose roots are known."""

from __future__ import annotations

import ctypes
from collections.abc import Callable

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from lagrange_cli.native.compilation.llvm import compile_text
from lagrange_cli.native.compilation.machine import LoadedCode, load
from lagrange_cli.native.stepping.roots import BACK, Roots

ORDER = 29


class Known(ctypes.Structure):
    """What ``@known`` gives."""

    _fields_ = (("length", ctypes.c_double), ("size", ctypes.c_double))


First = Callable[[Polynomial, float, float, bool], float]


def compiled(roots: Roots, head: str) -> LoadedCode:
    """Its functions, of which one may be called from here."""
    return load(compile_text(roots.text().replace(f"define internal {head}", f"define {head}"), 1))


@pytest.fixture(scope="module")
def first_root() -> First:
    """``@first_root`` for a polynomial, compiled."""
    roots = Roots(ORDER, 1)
    pointer, real = ctypes.c_void_p, ctypes.c_double
    kinds = pointer, real, real, real, ctypes.c_bool, ctypes.c_bool
    code = compiled(roots, "double @first_root")
    call = ctypes.CFUNCTYPE(real, *kinds)(code.address("first_root"))

    def first(u: Polynomial, h: float, side: float, fresh: bool) -> float:
        assert code is not None
        scratch = np.full(roots.room, np.nan)
        scratch[: 8 * roots.vectors] = 0.0
        scratch[: len(u.coef)] = u.coef * h ** np.arange(len(u.coef))
        return float(call(scratch.ctypes.data, h, 0.0, side, fresh, False))

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


@pytest.mark.parametrize("term", [1, 4])
@pytest.mark.parametrize(("order", "radius"), [(29, 0.5), (29, 8.0), (12, 0.8), (47, 0.7)])
def test_terms_are_known_as_far_as_the_series_has_converged(order, radius, term):
    """That of 1/(1 - t/R): its last terms are 2^-50 of the sum there."""
    roots = Roots(order, term)
    code = compiled(roots, "{ double, double } @known")
    put = ctypes.CFUNCTYPE(Known, ctypes.c_void_p, ctypes.c_double, ctypes.c_void_p)(code.address("known"))
    m = np.arange(order - 1)
    row, terms = np.full((order + 1, term), np.nan), np.full(roots.room, np.nan)
    row[1:order, 0] = radius**-m / (m + 1.0)
    known = put(row.ctypes.data, 1.0, terms.ctypes.data)
    t = known.length
    converged = min(1.0, radius * 2.0 ** (-50 / (order - 3)))
    assert 0.8 * converged < t <= converged * 1.1
    assert terms[: order - 1] == pytest.approx((t / radius) ** m, rel=1e-14)
    assert not terms[order - 1 : 8 * roots.vectors].any()
    assert known.size == pytest.approx(terms[: order - 1].sum(), rel=1e-14)
    assert terms[order - 3] <= 2.0**-50 * known.size


def test_rounding_moves_a_threefold_root_by_its_cube_root_and_no_more(first_root):
    """The slope there is rounding: it leads nowhere. Here n = 2^-52 times the size of the polynomial's terms,
    and c is its third coefficient at the root."""
    source = np.random.default_rng(3)
    for root, *zeros in source.uniform([0.2, 2.0, 2.0], [0.9, 4.0, 4.0], (400, 3)):
        u = Polynomial.fromroots([root, root, root, *zeros])
        noise = 2.0**-52 * Polynomial(np.abs(u.coef))(root)
        found = first_root(u, 1.0, float(np.sign(u(0.0))), False)
        assert abs(found - root) <= 2 * np.cbrt(noise / abs(u.deriv(3)(root) / 6))
