"""Chains that are released from the horizontal, at rest to the last bit.

All bodies fall freely at first, so that only the first joint turns. The accelerations of the others are
differences of large forces, nothing but rounding, and then grow as high powers of the time, one link after
another.
"""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.families import followed

CHAIN = """
sizes: {{N: {count}}}
parameters: {{g: 9.81, l: {length}, k: {stiffness}}}
coordinates: {{"a[i in range(N)]": {{initial: {angle}}}}}
definitions:
  x[0]: l*cos(a[0])
  y[0]: l*sin(a[0])
  x[i in range(1, N)]: x[i - 1] + l*cos(a[i])
  y[i in range(1, N)]: y[i - 1] + l*sin(a[i])
masses: {{"bob[i in range(N)]": 0.3}}
embedding: {{"bob[i in range(N)]": ["x[i]", "y[i]"]}}
potential: sum(0.3*g*y[i] for i in range(N)) + sum(k*(a[i] - a[i - 1])**2/2 for i in range(1, N))
"""


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("method", ["taylor", "ias15"])
@pytest.mark.parametrize("count", [2, 4, 11, 12, 50])
def test_no_step_follows_rounding(count: int, method: str) -> None:
    """The chain takes about as many steps as one whose links are not quite in line, also an elastic one."""
    length = 0.1 + np.random.default_rng(count).random()
    for stiffness in (0.0, length**2):
        steps = list[int]()
        for angle in ("0", "0.01*(i % 3)"):
            text = CHAIN.format(count=count, length=length, stiffness=stiffness, angle=angle)
            _, motion = followed(text, frozenset(["q", "h"]), stop=0.5, method=method)
            steps.append(motion.outcome.steps)
            h = motion["diagnostics/h"]
            assert abs(h[-1] - h[0]) <= 1e-13 * count**2 * 0.3 * 9.81 * length, (length, stiffness)
        assert steps[0] <= 2 * steps[1] + 150, (length, stiffness, steps)


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("method", ["taylor", "ias15"])
@pytest.mark.parametrize("count", [3, 20])
def test_bodies_fall_freely_at_first(count: int, method: str) -> None:
    """The first link turns as all bodies fall, and the others stay horizontal."""
    length, late = 0.7, 1e-3
    text = CHAIN.format(count=count, length=length, stiffness=0.0, angle="0")
    _, motion = followed(text, frozenset(["q"]), stop=late, samples=2, method=method)
    angles = motion["q/a"][-1]
    fall = 9.81 * late**2 / 2
    assert angles[0] == pytest.approx(-fall / length, rel=1e-9)
    assert np.all(np.abs(angles[1:]) <= (fall / length) ** 2)
