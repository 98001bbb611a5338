"""Several systems side by side, each a member of families, move as one does, in steps as long as its own."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import lagrange_cli as lagrange
from lagrange_cli.run import shipped
from tests.support.replicated import replicated

LONG = {"andrews_squeezer", "bicycle", "four_bar", "rattleback", "solar_system"}
"""Systems that take long."""
SOON = 0.2
"""The part of a motion in which errors have not grown."""
TEXTS = {name: shipped.text(name) for name in shipped.names() if name not in LONG}
CASES = [
    (name, count) for name, text in TEXTS.items() if replicated(text, 1) is not None for count in (2, 12, 30)
]


def solved(text: str, method: str) -> lagrange.Motion:
    """The motion, without warnings."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", lagrange.LagrangeWarning)
        return lagrange.solve(text, samples=51, outputs="q", method=method)


@pytest.mark.exhaustive(keep=3)
@pytest.mark.parametrize("method", ["taylor", "ias15"])
@pytest.mark.parametrize(("name", "count"), CASES)
def test_members_move_as_one_does(name: str, method: str, count: int) -> None:
    one, many = (solved(replicated(TEXTS[name], n) or "", method) for n in (1, count))
    assert many.status == one.status
    assert many.attributes["steps"] <= 1.3 * one.attributes["steps"] + 20
    last = int(SOON * len(one.t))
    for coordinate, values in one.q.items():
        scale = max(1.0, np.abs(values).max())
        assert many.q[coordinate][:last] == pytest.approx(
            np.repeat(values[:last], count, axis=1), abs=1e-7 * scale
        )
