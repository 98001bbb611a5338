"""The arrays that compiled code works on."""

from __future__ import annotations

import numpy as np
import pytest

from lagrange_cli.integrate.arrays import HUGE, beside_one_another


@pytest.mark.parametrize("sizes", [(1,), (0, 3, 17, 8), (HUGE // 2, 5, HUGE // 2 + 1), (3 * HUGE + 9, 1)])
def test_arrays_are_apart_and_on_boundaries(sizes: tuple[int, ...]) -> None:
    arrays = beside_one_another(*sizes)
    assert [len(one) for one in arrays] == [*sizes]
    assert all(one.ctypes.data % 64 == 0 for one in arrays if len(one))  # numpy gives empty ones any address
    assert not any(one.any() for one in arrays)
    for i, one in enumerate(arrays):
        one[:] = i + 1
    assert all(np.all(one == i + 1) for i, one in enumerate(arrays))
    if sum(sizes) > HUGE:
        assert arrays[0].ctypes.data % (8 * HUGE) == 0
