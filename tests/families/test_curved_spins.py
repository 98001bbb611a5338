"""Spins among masses that depend on coordinates: tops that are given by a Lagrangian."""

from __future__ import annotations

import numpy as np
import pytest
import sympy

from tests.families.test_closed_chains import exactly_followed
from tests.families.test_curved_masses import curved, in_loops
from tests.support.families import alike, followed, with_indices

TOPS = """
sizes: {{N: {count}}}
coordinates:
  a[i in range(N)]: {{initial: {tilt}, velocity: 0}}
  b[i in range(N)]: {{initial: 0, velocity: 0.1}}
  c[i in range(N)]: {{initial: 0, velocity: 20}}
lagrangian: >-
  sum((a_dot[i]**2 + sin(a[i])**2*b_dot[i]**2)*0.6 + 0.1*(c_dot[i] + b_dot[i]*cos(a[i]))**2 for i in range(N))
  - sum(9.81*cos(a[i]) for i in range(N))
{bound}
"""


@pytest.mark.parametrize("method", ["taylor", "ias15", "DOP853"])
@pytest.mark.parametrize("bound", ["", "constraints: {'at[i in range(N - 1)]': 'a[i] - a[i + 1]'}"])
def test_tops_close_to_the_vertical_keep_all_digits(
    method: str, bound: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The masses beside their spins are multiplied out. Numbers with many digits need none of this."""
    text, outputs = TOPS.format(count=9, tilt=0.001, bound=bound), frozenset(["q", "v"])
    in_loops(monkeypatch, loops=False)
    _, exact = exactly_followed(text, outputs)
    in_loops(monkeypatch, loops=True)
    masses = curved(text).coupled_masses
    assert masses is not None and len(masses.factored.spins) == 1
    ready, motion = followed(text, outputs, stop=0.2, samples=3, method=method)
    assert ready.machine.program.loops and motion.outcome.steps < 25
    for path in "q/a", "q/b", "q/c":
        assert np.max(np.abs(motion[path] - exact[path])) < 1e-14 * np.max(np.abs(exact[path])), path


def test_spins_that_constraints_contain_do_not_stand_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    text = TOPS.format(
        count=9, tilt=0.8, bound="nonholonomic: {'roll[i in range(N)]': 'c_dot[i] - 20 - b_dot[i]'}"
    )
    text = text.replace("velocity: 0.1", "velocity: 0")
    motions = []
    for loops in True, False:
        in_loops(monkeypatch, loops=loops)
        ready, motion = followed(text, frozenset(["q", "v", "multipliers"]))
        assert ready.machine.program.loops == loops
        motions.append(motion.data)
    alike(*motions, 2.0**-40)


def test_energies_of_members_are_printed_with_an_index() -> None:
    """That of a member is its part of h, if no term contains another one."""
    text = TOPS.format(count=20, tilt=0.8, bound="")
    found = {one.quantity: one for one in with_indices(text).equations.conserved}
    a, u, v, w = (sympy.Symbol(name) for name in ("a[i]", "a_dot[i]", "b_dot[i]", "c_dot[i]"))
    energy = (u**2 + sympy.sin(a) ** 2 * v**2) * 0.6 + 0.1 * (w + v * sympy.cos(a)) ** 2 + 9.81 * sympy.cos(a)
    assert {"p_b[i]", "p_c[i]", "h", "h_a[i]"} == found.keys()
    left = sympy.lambdify([a, u, v, w], found["h_a[i]"].expression - energy)
    assert abs(left(0.7, 0.3, -1.1, 2.5)) < 1e-14
    springs = text.replace("sum(9.81", "sum((a[i + 1] - a[i])**2 for i in range(N - 1)) - sum(9.81")
    assert "h_a[i]" not in {one.quantity for one in with_indices(springs).equations.conserved}
