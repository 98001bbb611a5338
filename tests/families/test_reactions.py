"""Forces of constraint in loops on components of places that no coordinate moves: R = -F there."""

from __future__ import annotations

import numpy as np
import pytest

from lagrange_cli.families import system as systems
from tests.families.test_constraints import followed

BEADS = """
sizes: {{N: {count}}}
parameters: {{m: 0.3, g: 2.0, k: 1.5}}
coordinates:
  x[i in range(N)]: {{initial: "i", velocity: 0.3}}
  z: {{initial: 0.5}}
masses: {{"bead[i in range(N)]": m}}
positions: {{"bead[i in range(N - 1)]": {place}, "bead[N - 1]": ["x[N - 1]", 1, z]}}
{more}
potential: "{potential}"
constraints:
  rod[i in range(N - 1)]: "x[i + 1] - x[i] - 1"
"""
ROD = '["x[i]", 1, "2 + i/9"]'
CASES = {
    "weight": (ROD, "sum(m*g*bead[i].z for i in range(N))", ""),
    "springs": (ROD, "sum(k*(norm(bead[i + 1] - bead[i]) - 0.4)**2/2 for i in range(N - 1))", ""),
    "a mean": (ROD, "k*(sum(bead[i].z*bead[i].y for i in range(N)) + 1)**2", ""),
    "a force": (ROD, "0", 'forces: {"bead[i in range(N)]": ["0.1*x[i]", "sin(t)", "-0.1*bead[i].vx"]}'),
    "friction": (ROD, "0", 'dissipation: "sum((bead[i].vx + bead[i].vz - i)**2/2 for i in range(N))"'),
    "coordinates": (ROD, "sum(k*x[i]**2/2 for i in range(N))", ""),
}  # fmt: skip
OUTPUTS = frozenset(["q", "reactions"])


@pytest.mark.parametrize("case", CASES)
def test_what_rests_feels_what_acts_on_it(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    place, potential, more = CASES[case]
    text = BEADS.format(count=9, place=place, potential=potential, more=more)
    found = []
    for few in (0, 10**9):
        monkeypatch.setattr(systems, "FEWEST_BOUND", few)
        ready, motion = followed(text, OUTPUTS)
        assert ready.machine.program.loops == (few == 0)
        found.append(motion.data["reactions/bead"])
    assert np.max(np.abs(found[0] - found[1])) < 1e-12
    if case == "weight":
        assert np.allclose(found[0][:, :-1], [0.0, 0.0, 0.6], atol=1e-14) and np.all(found[0][:, -1] == 0.0)
