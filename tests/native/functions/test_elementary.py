"""Our elementary functions against mpmath, in units in the last place, and lanes against single doubles."""

import itertools
import math
import sys
from collections.abc import Callable, Sequence

import llvmlite.binding as llvm
import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lagrange_cli.expression.vocabulary import FUNCTIONS as LANGUAGE
from lagrange_cli.native.functions.elementary import FUNCTIONS, definitions
from lagrange_cli.native.functions.formulas import LARGEST_ANGLE
from lagrange_cli.native.llvm.declarations import complete
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Real
from lagrange_cli.native.numbers.lanes import LaneEmitter
from tests.support.calls import compiled, function, loaded, over_columns, text

LANES = 8
SIN_COS, SIN_COS_LANES = (function("sin_cos", lanes) for lanes in (1, LANES))
EXP, EXP_LANES = (function("exp", lanes) for lanes in (1, LANES))
LOG, LOG_LANES = (function("log", lanes) for lanes in (1, LANES))
POW, POW_LANES = (function("pow", lanes) for lanes in (1, LANES))
COUNT = 2000
RANDOM = np.random.default_rng(20260101)

ANGLES = {
    "small": RANDOM.uniform(-1, 1, COUNT),
    "some turns": RANDOM.uniform(-20, 20, COUNT),
    "many turns": RANDOM.uniform(-LARGEST_ANGLE, LARGEST_ANGLE, COUNT),
    "all sizes": np.ldexp(RANDOM.uniform(1, 2, COUNT), RANDOM.integers(-1074, 20, COUNT)),
    "beyond": np.ldexp(RANDOM.uniform(1, 2, COUNT), RANDOM.integers(20, 1023, COUNT)),
    "where the reduction changes": (RANDOM.integers(0, 1000, COUNT) + 0.5) * math.pi / 2,
    "multiples of pi/2 beyond": RANDOM.integers(10**6, 10**10, COUNT) * math.pi / 2,
    "multiples of pi/2": RANDOM.integers(-600_000, 600_000, COUNT) * math.pi / 2,
    "first multiples of pi/2": np.arange(-COUNT // 2, COUNT // 2) * math.pi / 2,
}


def errors(found: np.ndarray, known: list[mpmath.mpf]) -> np.ndarray:
    """Each error in units in the last place of the true value."""
    return np.array([float(abs(x - y) / math.ulp(float(y))) for x, y in zip(found, known)])


def assert_rounded(wrong: np.ndarray, bound: float) -> None:
    """No error is beyond the bound, and their mean square is that of rounding alone, 1/12, and at most 0.05^2
    more: up to five standard deviations of the mean of so many squares, each of which has (1/180)^(1/2)."""
    assert np.max(wrong) < bound
    assert np.mean(wrong**2) < 1 / 12 + 0.05**2 + 5 * math.sqrt(1 / 180 / len(wrong))


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("where", ANGLES)
def test_sine_and_cosine(where: str) -> None:
    x = ANGLES[where]
    with mpmath.workprec(1300):
        for found, exact in zip(SIN_COS(x, np.zeros(COUNT)), (mpmath.sin, mpmath.cos)):
            assert_rounded(errors(found, [exact(mpmath.mpf(one)) for one in x]), 0.8)


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


EXPONENTS = {
    "small": RANDOM.uniform(-0.4, 0.4, COUNT),
    "medium": RANDOM.uniform(-20, 20, COUNT),
    "all": RANDOM.uniform(-708, 708, COUNT),
    "beyond": np.concatenate([RANDOM.uniform(-745, -708, COUNT // 2), RANDOM.uniform(708, 712, COUNT // 2)]),
    "all sizes": np.ldexp(RANDOM.uniform(-1, 1, COUNT), RANDOM.integers(-1074, 0, COUNT)),
}


@pytest.mark.exhaustive(keep=4)
@pytest.mark.parametrize("where", EXPONENTS)
def test_exponential(where: str) -> None:
    """Beyond its formula's range the C library's is changed by the low part afterwards."""
    x = EXPONENTS[where]
    low = RANDOM.uniform(-0.5, 0.5, COUNT) * np.spacing(np.abs(x))
    for rest in (np.zeros(COUNT), low):
        with mpmath.workprec(300):
            known = [mpmath.exp(mpmath.mpf(a) + mpmath.mpf(b)) for a, b in zip(x, rest)]
            finite = np.array([abs(y) < sys.float_info.max for y in known])
            wrong = errors(EXP(x, rest)[0][finite], list(itertools.compress(known, finite)))
            if where == "beyond":
                assert np.max(wrong) < 2 and np.mean(wrong**2) < 0.6**2
            else:
                assert_rounded(wrong, 0.7)


POSITIVE = {
    "near 1": 1 + RANDOM.uniform(-1, 1, COUNT) * np.ldexp(1.0, RANDOM.integers(-52, -1, COUNT)),
    "medium": RANDOM.uniform(0.01, 30, COUNT),
    "where the reduction changes": math.sqrt(2)
    * RANDOM.uniform(0.97, 1.03, COUNT)
    * RANDOM.choice([0.5, 1], COUNT),
    "all": np.ldexp(RANDOM.uniform(1, 2, COUNT), RANDOM.integers(-1074, 1023, COUNT)),
}


@pytest.mark.parametrize("where", POSITIVE)
def test_logarithm(where: str) -> None:
    x = POSITIVE[where]
    with mpmath.workprec(300):
        assert_rounded(errors(LOG(x)[0], [mpmath.log(mpmath.mpf(one)) for one in x]), 0.52)


@pytest.mark.exhaustive(keep=6)
@pytest.mark.parametrize("where", POSITIVE)
@pytest.mark.parametrize("exponent", [-2.7, 0.3, 5.0, None])
def test_power(where: str, exponent: float | None) -> None:
    """Without an exponent given: with one for each base that makes the power very large or small."""
    x = POSITIVE[where]
    steep = RANDOM.uniform(600, 700, COUNT) * RANDOM.choice([-1, 1], COUNT)
    y = np.full(COUNT, exponent) if exponent else steep / np.where(x == 1, 1, np.log(x))
    with mpmath.workprec(300):
        known = [mpmath.mpf(a) ** mpmath.mpf(b) for a, b in zip(x, y)]
        normal = np.array([sys.float_info.min < value < sys.float_info.max for value in known])
        assert_rounded(errors(POW(x, y)[0][normal], list(itertools.compress(known, normal))), 0.7)


SPECIAL = np.array([math.nan, math.inf, -math.inf, 0.0, -0.0, 1.0, -1.0, 2.0, -2.0, 0.5, 5e-324, 1e308, -3.5])


@pytest.mark.parametrize("lanes", [(EXP, LOG, POW), (EXP_LANES, LOG_LANES, POW_LANES)], ids=["one", "eight"])
def test_special_values_are_those_of_the_c_library(lanes: tuple[Callable[..., np.ndarray], ...]) -> None:
    exp, log, pow = lanes
    x, y = (axis.ravel()[: 21 * LANES] for axis in np.meshgrid(SPECIAL, SPECIAL))
    with np.errstate(all="ignore"):
        np.testing.assert_array_max_ulp(exp(x, np.zeros(len(x)))[0], np.exp(x))
        np.testing.assert_array_max_ulp(log(x)[0], np.log(x))
        np.testing.assert_array_max_ulp(pow(x, y)[0], np.power(x, y))
        assert np.array_equal(np.signbit(pow(x, y)[0]), np.signbit(np.power(x, y)))


FLOATS = st.lists(st.floats(), min_size=LANES, max_size=LANES)
PARTS = st.lists(st.floats(-1, 1), min_size=LANES, max_size=LANES)


@pytest.mark.exhaustive(keep=0.4)
@given(FLOATS, FLOATS, PARTS)
@settings(max_examples=150)
def test_lanes_have_the_bits_of_single_doubles(x: list[float], y: list[float], part: list[float]) -> None:
    """Whatever their neighbours hold."""
    low = np.array(part) * np.spacing(np.minimum(np.abs(x), 1e300))
    for one, eight, second in (
        (SIN_COS, SIN_COS_LANES, [low]),
        (EXP, EXP_LANES, [low]),
        (LOG, LOG_LANES, []),
        (POW, POW_LANES, [np.array(y)]),
    ):
        single, together = one(np.array(x), *second), eight(np.array(x), *second)
        assert np.array_equal(single, together, equal_nan=True)
        assert np.array_equal(np.signbit(single), np.signbit(together))


@pytest.mark.exhaustive(keep=3)
@pytest.mark.parametrize("name", ["sin_cos", "exp", "log", "pow"])
def test_the_simplest_processor_computes_the_same_bits(name: str) -> None:
    """One without wide vectors and, on many platforms, without fma."""
    here = llvm.Target.from_triple(llvm.get_process_triple())
    plainest = here.create_target_machine(cpu="", features="", opt=1, jit=True)
    program = llvm.parse_assembly(complete(text(name, LANES)))
    simple = loaded(plainest.emit_object(program), FUNCTIONS[name].results)
    x, y = RANDOM.uniform(0, 500, COUNT), RANDOM.uniform(-1, 1, COUNT)
    arguments = [x, y if name == "pow" else 1e-14 * y][: FUNCTIONS[name].arguments]
    assert np.array_equal(simple(*arguments), function(name, LANES)(*arguments))


@pytest.mark.exhaustive(keep=6)
@pytest.mark.parametrize(("name", "count"), [*LANGUAGE.items(), ("pow", 2)])
def test_every_function_of_the_language_in_lanes(name: str, count: int) -> None:
    """The C library's tanh is off by 2 units itself."""
    x, y = RANDOM.uniform(0.05, 0.95, (2, COUNT))
    arguments = [x, y][:count]

    def write(f: Function, values: Sequence[Real]) -> list[Real]:
        return [Real(f, LaneEmitter(f).function(name, *(x.name for x in values)))]

    program = over_columns(write, len(arguments), LANES)
    found = compiled(program + definitions(program), 1)(*arguments)[0]
    with mpmath.workprec(200):
        exact = getattr(mpmath, {"pow": "power"}.get(name, name))
        known = [exact(*map(mpmath.mpf, point)) for point in zip(*arguments)]
        assert max(abs(a - b) / math.ulp(float(b) or 1.0) for a, b in zip(found, known)) < 3


def test_only_what_is_called_is_defined() -> None:
    assert definitions("define void @f() {\n  ret void\n}\n") == ""
    one, eight = (definitions(text("sin_cos", lanes).partition("}\n")[0]) for lanes in (1, LANES))
    assert one.count("define ") == 1 and eight.count("define ") == 2


def test_what_is_called_is_declared_once() -> None:
    declared = [line for line in complete(text("atan2", LANES)).split("\n") if line.startswith("declare")]
    assert declared == ["declare double @atan2(double, double) memory(none)"]
    declared = [line for line in complete(text("sin_cos", LANES)).split("\n") if line.startswith("declare")]
    fma = "<8 x double> @llvm.fma.v8f64(<8 x double>, <8 x double>, <8 x double>)"
    assert f"declare {fma}" in declared and len(declared) == len(set(declared)) == 7
