"""Which coefficients determine a step, and how."""

from __future__ import annotations

import pytest

from lagrange_cli.native.stepping.step_size import BLOCKS, LOWEST_TERM, SLACK, offset_of, split_terms


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
