"""Families of definitions of particles and bodies: systems in loops move as with each put in by hand, and are
printed and verified alike."""

from __future__ import annotations

import numpy as np
import pytest

from lagrange_cli.families import system as systems
from lagrange_cli.run.verification import verify_families
from tests.families.test_missing_members import in_loops
from tests.support.families import both_in_loops, followed, printed_alike, with_indices
from tests.support.inlined import inlined

OUTPUTS = frozenset(["q", "v", "h", "p", "observables", "positions"])
SPRINGS = """
sizes: {N: 12}
parameters: {k: 1.5, l: 0.9, c: 0.1}
coordinates:
  "x[i in range(N)]": {initial: "i + 0.1*sin(i)"}
  "y[i in range(N)]": {initial: "0.1*cos(2*i)", velocity: 0.1}
definitions:
  "d[i in range(1, N)]": norm(p[i] - p[i - 1])
  "stretch[i in range(1, N)]": d[i] - l
  "u[i in range(N - 1)]": p[i + 1].vx - p[i].vx
  high: sum(p[j].y for j in range(N))
masses: {"p[i in range(N)]": "1 + i/7"}
positions: {"p[i in range(N)]": ["x[i]", "y[i]"]}
potential: sum(k*stretch[i]**2/2 for i in range(1, N)) + high
forces:
  "p[i in range(N - 1)]": ["c*u[i]", "-c*u[i]*d[i + 1]"]
observables: {"e[i in range(1, N)]": "stretch[i]*u[i - 1]", all: high**2}
"""
PENDULA = """
sizes: {N: 14}
parameters: {k: 1.5, l: 0.3, g: 9.81}
coordinates: {"theta[i in range(N)]": {initial: "0.2 + 0.1*i", velocity: "0.1*(i % 3)"}}
definitions:
  "d[i in range(2, N)]": norm(bob[i] - bob[i - 2])
  "speed[i in range(N)]": bob[i].vx**2 + bob[i].vy**2
masses: {"bob[i in range(N)]": "1/(i + 1)"}
positions:
  "bob[i in range(N)]":
    - sum(l*sin(theta[j]) for j in range(i + 1))
    - -sum(l*cos(theta[j]) for j in range(i + 1))
potential: sum(g/(i + 1)*bob[i].y for i in range(N)) + sum(k*(d[i] - l)**2/2 for i in range(2, N))
generalized_forces: {"theta[i in range(2, N)]": "-0.1*theta_dot[i]*d[i]"}
observables: {"w[i in range(N)]": "speed[i]", "b[i in range(2, N)]": "d[i]"}
"""
ARC = SPRINGS.replace(
    "  high:",
    """  "s[0]": 0*x[0]
  "s[i in range(1, N)]": s[i - 1] + (p[i].x - p[i - 1].x)*l
  "r[0]": 0*p[0]
  "r[i in range(1, N)]": r[i - 1] + (p[i] - p[i - 1])*l
  high:""",
).replace("all: high**2", 'all: high**2, "arc[i in range(N)]": "s[i]", "way[i in range(N)]": "r[i].y"')
"""What follows from member to member: a number, and a vector."""
BODIES = """
sizes: {N: 5}
parameters: {k: 2.0, r: 0.2, I: 0.1}
coordinates:
  "x[i in range(N)]": {initial: "i"}
  "z[i in range(N)]": {initial: "0.1*i*i", velocity: 0.1}
  "a[i in range(N)]": {initial: "0.2 + 0.1*i"}
  "b[i in range(N)]": {initial: "0.7 - 0.1*i"}
  "c[i in range(N)]": {initial: 0.1, velocity: "1 + i"}
definitions:
  "gap[i in range(N - 1)]": norm(top[i].at(r, 0, 0) - top[i + 1].at(0, r, r))
  "spin[i in range(N)]": top[i].w3 + top[i].wx
  "drag[i in range(N)]": top[i].vx*top[i].R13
bodies:
  "top[i in range(N)]":
    mass: 1 + i/7
    inertia: [I, 2*I, 1.5*I]
    position: ["x[i]", 0.1*i, "z[i]"]
    orientation: {euler: ["a[i]", "b[i]", "c[i]"]}
potential: sum(k*(gap[i] - 1)**2/2 for i in range(N - 1)) + sum(top[i].z for i in range(N))
generalized_forces: {"x[i in range(N)]": "-0.1*drag[i]", "c[i in range(N)]": "-0.01*spin[i]"}
observables: {"s[i in range(N)]": "spin[i]", "g[i in range(N - 1)]": "gap[i]"}
"""
SYSTEMS = {"springs": SPRINGS, "pendula": PENDULA, "bodies": BODIES}


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize("name", SYSTEMS)
def test_systems_in_loops_move_as_with_definitions_put_in_by_hand(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    in_loops(monkeypatch, True)
    monkeypatch.setattr(systems, "FEWEST_TURNING", 0)
    both_in_loops(SYSTEMS[name], inlined(SYSTEMS[name]), OUTPUTS, 2.0**-44)


def test_definitions_that_follow_from_one_another_contain_particles(monkeypatch: pytest.MonkeyPatch) -> None:
    """Their sum is known: all but its ends cancels."""
    in_loops(monkeypatch, True)
    found, motion = followed(ARC, OUTPUTS)
    assert found.machine.program.loops
    for name, place in (("arc", "q/x"), ("way", "q/y")):
        x, length = motion.data[place], 0.9
        expected = (x - x[:, :1]) * length
        np.testing.assert_allclose(motion.data[f"observables/{name}"], expected, rtol=1e-13, atol=1e-13)


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize("name", ["springs", "pendula"])
def test_equations_in_loops_are_printed_as_with_definitions_put_in_by_hand(name: str) -> None:
    derived = with_indices(SYSTEMS[name])
    assert printed_alike(derived, with_indices(inlined(SYSTEMS[name])))
    assert verify_families(derived, {}).difference < 1e-12
