"""``--method auto`` tries some members of a sweep, and follows all by implicit steps if that takes less."""

from __future__ import annotations

import math

import numpy as np
import pytest

import lagrange_cli
from lagrange_cli.integrate.stiffness import DEAR, Stiffness, of_many
from tests.run.test_trial import SYRUP, decayed

RELAXING = """
name: relaxing
parameters: {mu: 1}
coordinates: {x: {initial: 2}}
lagrangian: (x_dot**2 - x**2)/2
generalized_forces: {x: mu*(1 - x**2)*x_dot}
solve: {stop: 500, tolerance: 1e-6}
"""
STEEP = 1e4, 2e4, 5e4


def test_members_that_are_stiff() -> None:
    swept = lagrange_cli.sweep(SYRUP, over={"c": STEEP})
    assert swept.attributes["method"] == "Radau" and swept.attributes["steps"] < 100
    assert np.ravel(swept.q["x"]) == pytest.approx([decayed(np.array(100.0), c) for c in STEEP], abs=1e-5)
    series = lagrange_cli.sweep(SYRUP, over={"c": STEEP}, method="taylor")
    assert series.attributes["steps"] > 1e4 * swept.attributes["steps"]


def test_the_choice_depends_on_all_members() -> None:
    """Taylor steps follow eight at once; and one stiff member does not make up for those that are not."""
    assert lagrange_cli.sweep(RELAXING, over={"mu": [800, 900]}).attributes["method"] == "Radau"
    assert lagrange_cli.sweep(RELAXING, over={"mu": [1, 2]}).attributes["method"] == "taylor"
    mixed = lagrange_cli.sweep(RELAXING, over={"mu": [1, 2, 3, 4, 300]}, stop=20000)
    assert mixed.attributes["method"] == "taylor"


@pytest.mark.parametrize("more", [{"tolerance": 2.0**-52, "stop": 1}, {"method": "taylor"}, {"proven": True}])
def test_sweeps_that_are_not_tried(more: dict[str, object]) -> None:
    assert lagrange_cli.sweep(SYRUP, over={"c": [20, 30]}, **more).attributes["method"] == "taylor"


def test_what_members_tell_of_all() -> None:
    stiff, calm = Stiffness(1e-6, 1e4, 1e6), Stiffness(1e-7, 1.0, 1e5)
    assert of_many([None, calm], 1) is None
    found = of_many([stiff, None], 8)
    assert found == Stiffness(1e-6, 1e4, 1e6)
    together = of_many([stiff, calm], 1)  # implicit steps: 100 of one, 4e5 of the other one
    assert together is None and DEAR > 1.1e6 / (100 + 4e5)
    assert of_many([Stiffness(1e-8, 2 * DEAR, 1e6)], 1) is not None
    assert of_many([Stiffness(1e-8, 2 * DEAR, 1e6)], 8) is None
    assert math.isclose(of_many([stiff, Stiffness(1e-8, 100, 1e6)], 1).replaces, 2e6 / 10100)  # type: ignore[union-attr]
