"""Members on circles: a coordinate moves several components of a place, and M is constant nevertheless."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

from lagrange_cli.families import system as systems
from lagrange_cli.families.conserved.conservation import constants_of
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.families import family_run
from lagrange_cli.integrate.prepare import prepare_system
from lagrange_cli.run.derive import derive_system
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_values
from tests.families.test_events import keep_families
from tests.support.families import alike
from tests.support.motion import Motion, run

OUTPUTS = frozenset(["q", "v", "p", "h", "T", "positions", "reactions"])
BEADS = """
sizes: {N: COUNT}
parameters: {R: 0.7, g: 2, F: 0.2}
coordinates: {"x[i in range(N)]": {initial: START, velocity: "0.3*cos(i*i + 1)"}}
masses: {"bead[i in range(N)]": 1 + i/7}
embedding: {"bead[i in range(N)]": ["3*i + R*sin(x[i])", 2, "R*cos(x[i])"]}
potential: sum(g*bead[i].z for i in range(N)) + sum(norm(bead[i] - bead[i - 1])**2/9 for i in range(1, N))
"""
CASES = {
    "springs": ("0.4*i", ""),
    "forces": ("i", 'forces: {"bead[i in range(N)]": ["-bead[i].vx", 0.1, sin(t)*bead[i].x]}'),
    "narrow forces": ("i", 'dissipation: "sum(exp(-9*bead[i].vx)/81 for i in range(N))"'),
    "friction": ("0.1*i", 'dissipation: "sum(F*abs(x_dot[i]) for i in range(N))"'),
    "collisions": (
        "1 + 0.1*i",
        'events: {"hit[i in range(N - 1)]": {when: "x[i + 1] - x[i] - 0.05", direction: falling,'
        ' action: {set: {"x_dot[i + 1]": "x_dot[i]", "x_dot[i]": "x_dot[i + 1]"}}}}',
    ),
    "rods": ("3", 'constraints: {"rod[i in range(N - 1)]": "bead[i + 1].x - bead[i].x - 3"}'),
}


def followed(case: str, count: int) -> Motion:
    """A motion and its events."""
    start, more = CASES[case]
    spec = read_spec(BEADS.replace("COUNT", str(count)).replace("START", start) + more, "system.yaml")
    outputs = OUTPUTS - {"reactions"} if case == "friction" else OUTPUTS
    asked = Compilation("taylor", 2.0**-52, outputs, proven=case == "narrow forces")
    assert (family_run(spec, asked) is None) == (systems.FEWEST > 0)
    ready = prepare_system(spec, partial(derive_system, resting=True), None, asked)
    return run(ready, resolve_values(spec, {}), 0.0, 1.5, 7)


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize(
    ("case", "count"),
    [(case, n) for case in CASES for n in (1, 2, 3, 8, 9) if n > 1 or case not in ("collisions", "rods")],
)
def test_beads_on_circles_move_as_the_members_do(
    case: str, count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    keep_families(monkeypatch, whole=True)
    found = followed(case, count)
    keep_families(monkeypatch, whole=False)
    expected = followed(case, count)
    assert found.data.keys() == expected.data.keys()
    alike(found.data, expected.data, 2.0**-38)


def test_charges_on_one_circle_keep_their_angular_momentum() -> None:
    text = """
sizes: {N: 20}
parameters: {R: 2.0, q: 0.1}
coordinates: {"phi[i in range(N)]": {initial: "2*pi*i/N + 0.1*sin(i)", velocity: "0.1*cos(i)"}}
masses: {"bead[i in range(N)]": 1 + i/7}
embedding: {"bead[i in range(N)]": ["R*cos(phi[i])", "R*sin(phi[i])"]}
potential: sum(q**2/norm(bead[i] - bead[j]) for i in range(N) for j in range(i))
"""
    spec = read_spec(text, "system.yaml")
    system = systems.family_system(spec)
    assert system is not None and system.joints is None
    assert {one.quantity for one in constants_of(system).conserved} == {"h", "L_z"}
    asked = Compilation("taylor", 2.0**-52, frozenset(["v"]))
    ready = prepare_system(spec, derive_system, None, asked)
    speeds = run(ready, resolve_values(spec, {}), 0.0, 2.0, 5)["v/phi"]
    momentum = speeds @ (1 + np.arange(20) / 7)
    assert np.max(np.abs(speeds[-1] - speeds[0])) > 0.01
    assert np.max(np.abs(momentum - momentum[0])) < 1e-13
