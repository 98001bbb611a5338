"""Double-double numbers in compiled code against mpmath at 60 digits."""

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lagrange_cli.expression.exact import ExactGraphAlgebra
from lagrange_cli.expression.vocabulary import FUNCTIONS
from lagrange_cli.integrate.arrays import aligned
from lagrange_cli.mechanics.derive import derive
from lagrange_cli.model.build import build_model
from lagrange_cli.native.compilation.machine import QUICK, compile_program
from lagrange_cli.native.numbers.double_double import DoubleDouble
from lagrange_cli.native.program import Steps, write_program
from lagrange_cli.spec.read import read_spec

MP = mpmath.mp.clone()
MP.dps = 60
BOUND = 1e-30
SPEC = b"""
coordinates: {x: {initial: 1}, y: {initial: 1}}
lagrangian: (x_dot**2 + y_dot**2)/2
"""
RESIDUAL = derive(build_model(read_spec(SPEC, "test", {}), ExactGraphAlgebra()))
X, Y = RESIDUAL.model.q
NODES = {
    **{name: RESIDUAL.graph.function(name, (X, Y)[: FUNCTIONS[name]]) for name in FUNCTIONS},
    "pow": X**Y,
    "sum": X + Y,
    "difference": X - Y,
    "product": X * Y,
    "quotient": X / Y,
    "cube": X**3,
    "x^-7/2": X ** RESIDUAL.graph.constant(-3.5),
    "thirds": X / 3.0 + Y / 7.0,
}
MACHINE = compile_program(write_program(RESIDUAL, Steps(20, kind=DoubleDouble), {}, NODES), QUICK)


def long(pair) -> mpmath.mpf:
    return MP.mpf(float(pair[0])) + MP.mpf(float(pair[1]))


def computed(name: str, *arguments: mpmath.mpf) -> tuple[mpmath.mpf, list[mpmath.mpf]]:
    """The value, and the arguments that it is of."""
    given = np.zeros((8, 1))
    for row, argument in enumerate(arguments):
        given[row] = float(argument)
        given[row + 4] = float(argument - MP.mpf(float(argument)))
    results = np.empty((2 * len(NODES), 1))
    constants, times = aligned(8), np.zeros(1)
    MACHINE.observe(constants.ctypes.data, times.ctypes.data, given.ctypes.data, results.ctypes.data, 1, 1)
    row = list(NODES).index(name)
    exact = [long((given[i, 0], given[i + 4, 0])) for i in range(len(arguments))]
    return long((results[row, 0], results[row + len(NODES), 0])), exact


def number(low: float, high: float) -> st.SearchStrategy:
    """Numbers with sixty digits, some of them very small."""
    part = st.integers(0, 10**40)
    plain = part.map(lambda n: MP.mpf(low) + MP.mpf(high - low) * n / 10**40)
    tiny = st.tuples(st.integers(1, 10**40), st.integers(1, 12)).map(
        lambda p: MP.mpf(p[0]) / 10 ** (40 + p[1])
    )
    return plain | tiny.map(lambda x: min(max(x, MP.mpf(low)), MP.mpf(high)))


RANGES = {
    "sin": (-1000, 1000), "cos": (-1000, 1000), "tan": (-20, 20), "asin": (-1, 1), "acos": (-1, 1),
    "atan": (-50, 50), "sinh": (-300, 300), "cosh": (-300, 300), "tanh": (-50, 50), "exp": (-300, 300),
    "log": (1e-9, 1e9), "sqrt": (0, 1e12), "cube": (-1e9, 1e9), "x^-7/2": (1e-9, 1e9),
}  # fmt: skip


@pytest.mark.exhaustive(keep=3)
@pytest.mark.parametrize("name", RANGES)
def test_functions_of_one_number(name):
    """No further off than if the argument had been, by its own rounding."""
    exact = {"cube": lambda x: x**3, "x^-7/2": lambda x: x ** (-MP.mpf(7) / 2)}.get(name) or getattr(MP, name)

    @settings(max_examples=60, deadline=None)
    @given(number(*RANGES[name]))
    def check(x):
        found, (x,) = computed(name, x)
        known, step = exact(x), abs(x) * MP.mpf(10) ** -40
        inside = abs(x) + step < 1 or name not in ("asin", "acos")
        slope = abs(exact(x + (step or MP.mpf(10) ** -50)) - known) * MP.mpf(10) ** 40 if inside else 0
        if inside:
            assert abs(found - known) <= BOUND * (abs(known) + slope)

    check()


PAIRS = {
    "sum": lambda x, y: x + y, "difference": lambda x, y: x - y, "product": lambda x, y: x * y,
    "quotient": lambda x, y: x / y, "atan2": MP.atan2, "thirds": lambda x, y: x / 3 + y / 7,
    "pow": lambda x, y: x**y,
}  # fmt: skip


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("name", PAIRS)
@settings(max_examples=60, deadline=None)
@given(x=number(1e-3, 20), y=number(1e-3, 20))
def test_functions_of_two_numbers(name, x, y):
    found, (x, y) = computed(name, x, y)
    known = PAIRS[name](x, y)
    slack = abs(x) + abs(y) if name in ("sum", "difference", "thirds") else 0
    growth = 1 + abs(y * MP.log(x)) if name == "pow" else 1
    assert abs(found - known) <= BOUND * growth * (abs(known) + slack * 1e-1)


@settings(max_examples=60, deadline=None)
@given(x=number(1e-3, 20), n=st.integers(-9, 9))
def test_whole_powers_of_negative_numbers(x, n):
    found, (x, _) = computed("pow", -abs(x), MP.mpf(n))
    assert abs(found - x**n) <= BOUND * (1 + abs(n * MP.log(-x))) * abs(x**n)


def test_other_powers_of_negative_numbers_are_none():
    """Also where the fraction is in the low part; a large number with an odd low part is odd."""
    for n in (MP.mpf(0.5), MP.mpf(2) ** 60 + MP.mpf(0.25)):
        assert MP.isnan(computed("pow", MP.mpf(-1), n)[0])
    assert computed("pow", MP.mpf(-1), MP.mpf(2) ** 60 + 1)[0] == -1
    assert computed("pow", MP.mpf(-1), MP.mpf(2) ** 60 - 2)[0] == 1


def test_beyond_the_range():
    """Infinities and what is no number come out as such."""
    for name, argument in (("log", -1), ("sqrt", -1), ("asin", 2), ("sin", 1e300)):
        assert MP.isnan(computed(name, MP.mpf(argument))[0])
    assert computed("exp", MP.mpf(800))[0] == MP.inf
    assert computed("exp", MP.mpf(-800))[0] == 0
    assert computed("sqrt", MP.mpf(0))[0] == 0
    assert computed("tanh", MP.mpf(1000))[0] == 1
