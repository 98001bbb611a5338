"""Chains in relative angles, with members written out: their accelerations are differences of large ones,
known to few digits. They move as the same chains in angles from one direction."""

from __future__ import annotations

import numpy as np
import pytest

from lagrange_cli.families import system as systems
from tests.support.families import followed

CHAIN = """
sizes: {{N: {count}}}
parameters: {{m: 1, l: 0.2, g: 9.81}}
coordinates: {{"{name}[i in range(N)]": {{initial: "{initial}"}}}}
definitions:
  {angles}
  x[0]: l*cos(th[0])
  x[i in range(1, N)]: x[i - 1] + l*cos(th[i])
  y[0]: l*sin(th[0])
  y[i in range(1, N)]: y[i - 1] + l*sin(th[i])
masses: {{"b[i in range(N)]": m}}
embedding: {{"b[i in range(N)]": ["x[i]", "y[i]"]}}
potential: sum(m*g*b[i].y for i in range(N))
"""
ANGLES = '"th[0]": phi[0]\n  "th[i in range(1, N)]": th[i - 1] + phi[i]'


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize("count", [8, 13, 17])
def test_arms_in_relative_angles_move_as_in_others(count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without an end of ever shorter steps: 17 links took 14,000 and more, from 18 on millions."""
    start = 0.1
    monkeypatch.setattr(systems, "FEWEST_JOINTED", 10**9)
    relative = CHAIN.format(count=count, name="phi", initial=start, angles=ANGLES)
    plain = CHAIN.format(count=count, name="th", initial=f"{start}*(i + 1)", angles="")
    asked = frozenset(["q"])
    _, found = followed(relative, asked, stop=0.6)
    _, expected = followed(plain, asked, stop=0.6)
    assert found.outcome.steps < 4000
    off = np.cumsum(found["q/phi"], axis=1) - expected["q/th"]
    assert np.max(np.abs(off)) < 1e-12
