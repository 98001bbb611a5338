"""Our elementary functions against mpmath, in units in the last place, and lanes against single doubles."""

import math

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lagrange_cli.native.elementary import definitions
from lagrange_cli.native.formulas import LARGEST_ANGLE
from tests.native.calls import function, text

LANES = 8
SIN_COS = function("sin_cos", 1)
SIN_COS_LANES = function("sin_cos", LANES)
COUNT = 400
RANDOM = np.random.default_rng(20260101)

ANGLES = {
    "small": RANDOM.uniform(-1, 1, COUNT),
    "some turns": RANDOM.uniform(-20, 20, COUNT),
    "many turns": RANDOM.uniform(-LARGEST_ANGLE, LARGEST_ANGLE, COUNT),
    "all sizes": np.ldexp(RANDOM.uniform(1, 2, COUNT), RANDOM.integers(-1074, 20, COUNT)),
    "beyond": np.ldexp(RANDOM.uniform(1, 2, COUNT), RANDOM.integers(20, 1023, COUNT)),
    "where the reduction changes": (RANDOM.integers(0, 1000, COUNT) + 0.5) * math.pi / 2,
    "multiples of pi/2": RANDOM.integers(-600_000, 600_000, COUNT) * math.pi / 2,
    "first multiples of pi/2": np.arange(-COUNT // 2, COUNT // 2) * math.pi / 2,
}


def errors(found: np.ndarray, known: list[mpmath.mpf]) -> np.ndarray:
    """Each error in units in the last place of the true value."""
    return np.array([float(abs(x - y) / math.ulp(float(y))) for x, y in zip(found, known)])


@pytest.mark.parametrize("where", ANGLES)
def test_sine_and_cosine(where: str) -> None:
    x = ANGLES[where]
    with mpmath.workprec(1300):
        for found, exact in zip(SIN_COS(x, np.zeros(COUNT)), (mpmath.sin, mpmath.cos)):
            wrong = errors(found, [exact(mpmath.mpf(one)) for one in x])
            assert np.max(wrong) < 0.8
            assert np.sqrt(np.mean(wrong**2)) < 0.31  # rounding alone: 12^(-1/2) = 0.289


@pytest.mark.parametrize("where", ["small", "some turns", "many turns", "where the reduction changes"])
def test_the_low_part_of_the_angle(where: str) -> None:
    x = ANGLES[where]
    low = RANDOM.uniform(-0.5, 0.5, COUNT) * np.spacing(np.abs(x))
    with mpmath.workprec(300):
        for found, exact in zip(SIN_COS(x, low), (mpmath.sin, mpmath.cos)):
            wrong = errors(found, [exact(mpmath.mpf(a) + mpmath.mpf(b)) for a, b in zip(x, low)])
            assert np.max(wrong) < 0.8


@pytest.mark.parametrize("where", ["multiples of pi/2", "first multiples of pi/2"])
def test_the_low_part_where_a_result_vanishes(where: str) -> None:
    """There the low part is all that counts: the error is that of its last place, too."""
    x = ANGLES[where]
    low = RANDOM.uniform(-0.5, 0.5, COUNT) * np.spacing(np.abs(x))
    with mpmath.workprec(300):
        for found, exact in zip(SIN_COS(x, low), (mpmath.sin, mpmath.cos)):
            known = [exact(mpmath.mpf(a) + mpmath.mpf(b)) for a, b in zip(x, low)]
            for one, true, rest in zip(found, known, low):
                assert abs(one - true) <= 0.8 * math.ulp(float(true)) + math.ulp(float(rest))


def test_angles_that_are_none() -> None:
    with np.errstate(invalid="ignore"):
        for lanes in (SIN_COS, SIN_COS_LANES):
            x = np.array([math.nan, math.inf, -math.inf, 0.0, -0.0, 5e-324, -5e-324, 1e300])
            sine, cosine = lanes(x, np.zeros(8))
            assert np.isnan(sine[:3]).all() and np.isnan(cosine[:3]).all()
            assert np.array_equal(sine[3:7], x[3:7]) and np.array_equal(cosine[3:7], np.ones(4))
            assert abs(sine[7] ** 2 + cosine[7] ** 2 - 1) < 1e-15


@given(
    st.lists(st.floats(), min_size=LANES, max_size=LANES),
    st.lists(st.floats(-1, 1), min_size=LANES, max_size=LANES),
)
@settings(max_examples=300)
def test_lanes_have_the_bits_of_single_doubles(x: list[float], low: list[float]) -> None:
    """Whatever their neighbours hold."""
    arguments = np.array(x), np.array(low) * np.spacing(np.minimum(np.abs(x), 1e300))
    single, together = SIN_COS(*arguments), SIN_COS_LANES(*arguments)
    assert np.array_equal(single, together, equal_nan=True)
    assert np.array_equal(np.signbit(single), np.signbit(together))


def test_only_what_is_called_is_defined() -> None:
    assert definitions("define void @f() {\n  ret void\n}\n") == ""
    one, eight = (definitions(text("sin_cos", lanes).partition("}\n")[0]) for lanes in (1, LANES))
    assert one.count("define ") == 1 and eight.count("define ") == 2


def test_declarations_are_not_repeated() -> None:
    line = "declare double @llvm.fma.f64(double, double, double)\n"
    calling = text("sin_cos", 1).partition("}\n")[0]
    assert line in definitions(calling) and line not in definitions(line + calling)
