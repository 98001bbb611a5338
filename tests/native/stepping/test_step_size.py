"""Which coefficients determine a step, and how."""

from __future__ import annotations

import ctypes

import numpy as np
import pytest

from lagrange_cli.native.compilation.llvm import compile_text
from lagrange_cli.native.compilation.machine import load
from lagrange_cli.native.stepping.lengths import side_by_side
from lagrange_cli.native.stepping.step_size import (
    BLOCKS,
    LOWEST_TERM,
    SLACK,
    StepSize,
    offset_of,
    split_terms,
)  # fmt: skip


@pytest.mark.parametrize("top", [10, 16, 20, 21, 28, 40, 52, 60])
def test_blocks_hold_each_coefficient_once_in_order(top: int) -> None:
    blocks = split_terms(top)
    assert len(blocks) <= BLOCKS
    terms = [term for block in blocks for term in block]
    assert terms == list(range(LOWEST_TERM, LOWEST_TERM + len(terms))) and terms[-1] in (top - 1, top)


@pytest.mark.parametrize("top", [16, 20, 21, 28, 40, 52, 60])
def test_coefficients_of_the_first_three_quarters_may_be_larger(top: int) -> None:
    """By ``SLACK`` binary orders; the exponent of a double is biased by 1023."""
    for block in split_terms(top):
        slack = -1023.0 - offset_of(block, top) * block[0]
        assert slack == pytest.approx(SLACK if 4 * block[-1] < 3 * top else 0, abs=1e-9)


def cautious_steps(order: int, tolerance: float):
    """``@cautious_step`` of a motion with two coordinates, compiled; and the arrays that it is given."""
    lengths = side_by_side(2, 4, order)
    step = StepSize(lengths, tolerance, fades=False)
    text = step.cautious_step().text().replace("define internal", "define")
    code = load(compile_text(text, 1))
    kinds = ctypes.c_void_p, ctypes.c_void_p, ctypes.c_double
    call = ctypes.CFUNCTYPE(ctypes.c_double, *kinds)(code.address("cautious_step"))

    def found(v: np.ndarray, series: np.ndarray, h: float) -> float:
        assert code is not None
        state, work = np.zeros(lengths.width), np.zeros((order + 1, lengths.width))
        state[2:4], work[:order, 2:4] = v, series
        return float(call(state.ctypes.data, work.ctypes.data, h))

    return step, found


@pytest.mark.parametrize("order", [12, 29])
def test_a_cautious_step_is_bounded_by_every_coefficient(order: int) -> None:
    """By (size / |c_m|)^(1/m), which is computed only where a rough logarithm does not exclude it."""
    step, found = cautious_steps(order, 2.0**-52)
    m = np.arange(LOWEST_TERM, order)
    for case in range(300):
        source = np.random.default_rng(case)
        radius, slope = source.uniform(0.01, 100.0), source.uniform(-0.3, 0.3)
        orders = np.arange(order)[:, None]
        series = source.normal(size=(order, 2)) * (radius * np.exp(slope * orders)) ** -orders
        series *= source.random((order, 2)) < source.choice([0.3, 1.0])
        h, v = radius * source.uniform(0.01, 0.5), source.normal(size=2)
        terms = np.abs(series[1:4]) * h ** np.arange(1, 4)[:, None]
        size = np.maximum(np.abs(v), terms.max(axis=0))
        with np.errstate(divide="ignore"):
            ratios = np.where(series[m] == 0.0, np.inf, size / np.abs(series[m])).min(axis=1)
        assert found(v, series, h) == pytest.approx(step.safety * np.min(ratios ** (1.0 / m)), rel=1e-13)
