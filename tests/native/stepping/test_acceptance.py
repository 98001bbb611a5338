"""Which steps are accepted: those at whose end the accelerations are the predicted ones, within bounds."""

from __future__ import annotations

import ctypes

import numpy as np
import pytest

from lagrange_cli.native.compilation.llvm import compile_text
from lagrange_cli.native.compilation.machine import load
from lagrange_cli.native.stepping.acceptance import accepted
from lagrange_cli.native.stepping.lengths import Lengths

DEGREES, TERMS = 2, 8
LENGTHS = Lengths(
    degrees=DEGREES, rows=2 * DEGREES, width=2 * DEGREES, order=TERMS, lanes=1, together=1,
    row=TERMS, term=1,
)  # fmt: skip
TEXT = accepted(LENGTHS).text().replace("define internal", "define zeroext")  # else only one bit is defined
CODE = load(compile_text(TEXT, 1))
POINTER, NUMBER = ctypes.c_void_p, ctypes.c_double
CALL = ctypes.CFUNCTYPE(ctypes.c_bool, POINTER, POINTER, POINTER, NUMBER, NUMBER, ctypes.c_bool, NUMBER)


def judge(
    found: tuple[float, float],
    expected: tuple[float, float],
    allowed: tuple[float, float] = (1e-10, 1e-10),
    *,
    uneven: float = 0.0,
    slack: float = 1.0,
    unexplained: bool = False,
    floor: float = 0.0,
) -> bool:
    """The verdict on accelerations of two coordinates."""
    work = np.full((2 * DEGREES, TERMS), np.nan)  # whatever else it reads is no number
    work[DEGREES:, 1] = found
    rates, bounds = (np.concatenate([[np.nan] * DEGREES, each]) for each in (expected, allowed))
    places = [array.ctypes.data for array in (work, rates, bounds)]
    return CALL(CODE.address("accepted"))(*places, uneven, slack, unexplained, floor)


def test_a_step_is_accepted_if_the_accelerations_agree() -> None:
    assert judge((1.0, -2.0), (1.0, -2.0))
    assert judge((1.0, -2.0), (1.0 + 0.9e-10, -2.0))


@pytest.mark.parametrize("which", [0, 1])
def test_one_that_differs_is_enough_to_refuse_it(which: int) -> None:
    expected = [1.0, -2.0]
    expected[which] += 1.1e-10
    assert not judge((1.0, -2.0), (expected[0], expected[1]))


def test_each_has_a_bound_of_its_own() -> None:
    assert judge((1.0, -2.0), (1.0, -2.0 + 1e-6), (1e-10, 2e-6))
    assert not judge((1.0, -2.0), (1.0 + 1e-6, -2.0), (1e-10, 2e-6))


def test_what_is_no_number_is_refused() -> None:
    assert not judge((np.nan, -2.0), (1.0, -2.0))
    assert not judge((1.0, -2.0), (1.0, np.nan))


def test_unevenness_and_slack_widen_the_bounds() -> None:
    found, expected = (1.0, -2.0), (1.0 + 3e-10, -2.0)
    assert not judge(found, expected)
    assert judge(found, expected, uneven=2.5e-10)
    assert judge(found, expected, slack=4.0)
    assert not judge(found, expected, slack=2.0)


def test_unexplained_failures_ask_for_accelerations_of_nothing_but_rounding() -> None:
    assert judge((1e-17, -2e-17), (-3e-17, 1e-17), (0.0, 0.0), unexplained=True, floor=5e-17)
    assert not judge((1e-17, -2e-17), (-3e-17, 6e-17), (1.0, 1.0), unexplained=True, floor=5e-17)
