"""The nearest state that satisfies the constraints, where Newton's method alone does not lead to any."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

from tests.model.test_start import start


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize("turn, off", [(0.72, -0.002), (0.72, 0.001), (0.3, -1), (1, -0.5)])
def test_a_chain_of_heavy_middles_is_closed_however_little_opposite_turns_of_its_links_weigh(turn, off):
    """Such turns are the shortest way to first order, along which the values become larger. No nearer state
    is found by another method (SLSQP) from the one that is found, or from the values given."""
    n, length = 30, 0.2
    text = f"""
sizes: {{N: {n}}}
parameters: {{l: {length}, E: 1}}
coordinates: {{"a[i in range(N)]": {{initial: {turn}*(2*i/(N - 1) - 1)}}}}
masses: {{"b[i in range(N)]": 1}}
positions:
  b[i in range(N)]:
    - sum(l*cos(a[j]) for j in range(i)) + l/2*cos(a[i])
    - sum(l*sin(a[j]) for j in range(i)) + l/2*sin(a[i])
constraints: {{x: "sum(l*cos(a[i]) for i in range(N)) - E", y: "sum(l*sin(a[i]) for i in range(N))"}}
"""
    given = turn * np.linspace(-1, 1, n)
    end = length * np.cos(given).sum() + off
    found = np.array(start(text.replace("E: 1", f"E: {end}"), forced=True).q, float)

    def closed(a):
        return np.array([length * np.cos(a).sum() - end, length * np.sin(a).sum()])

    levers = length * (np.tri(n, k=-1) + np.eye(n) / 2)
    masses = np.cos(given[:, None] - given) * (levers.T @ levers)

    def gap(a):
        return (a - given) @ masses @ (a - given)

    assert np.abs(closed(found)).max() < 1e-13
    for begin in (found, given):
        other = minimize(gap, begin, constraints={"type": "eq", "fun": closed}, options={"maxiter": 300})
        assert not other.success or gap(found) <= gap(other.x) * (1 + 1e-6) + 1e-12
