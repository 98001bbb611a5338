"""What happens at one time."""

from __future__ import annotations

import numpy as np
import pytest

from lagrange_cli.integrate.impacts.at_once import AGAIN, AtOnce


def test_what_is_small_beside_what_was_at_the_same_time_is_rounding() -> None:
    """After a while it is no more."""
    at_once = AtOnce(2, 0.0, 1)
    assert at_once.noise(1.0, np.array([4.0, 0.0]), np.zeros(2)) == pytest.approx([2.0**-42, 0.0])
    assert at_once.noise(1.0, np.array([1.0, 1.0]), np.zeros(2)) == pytest.approx([2.0**-42, 2.0**-44])
    assert at_once.noise(1.1, np.array([1.0, 0.0]), np.zeros(2)) == pytest.approx([2.0**-44, 0.0])
    kept = AtOnce(2, 0.0, 1)
    assert [*kept.restore([*at_once.state(), 7.0])] == [7.0] and kept.state() == at_once.state()


def test_actions_at_one_time_are_counted() -> None:
    at_once = AtOnce(2, 0.0, 1)
    assert not any(at_once.recurs(1.0, 0.0) for _ in range(2 * AGAIN)) and at_once.recurs(1.0, 0.0)
    assert not at_once.recurs(1.1, 0.0) and at_once.same == 0


def test_the_end_of_impacts_is_told_once_at_one_time() -> None:
    at_once = AtOnce(2, 0.0, 1)
    assert at_once.first(1, 1.0) and not at_once.first(1, 1.0) and at_once.first(0, 1.0)
    assert at_once.first(1, 1.1)
