"""Actions of events where M is constant but not diagonal, beside the same systems written out member by
member."""

from __future__ import annotations

import random

import numpy as np
import pytest

from lagrange_cli.families import system as systems
from lagrange_cli.spec.read import read_spec
from tests.families.test_closed_chains import exactly_followed
from tests.families.test_coupled_constraints import (
    FORCES,
    HOLONOMIC,
    KINETIC,
    NONHOLONOMIC,
    POTENTIALS,
    SIZES,
    in_loops,
    text_of,
)
from tests.support.families import alike, followed

OUTPUTS = frozenset(["q", "v", "h", "p", "conserved"])
ACTIONS = {
    "walls": (
        'hit[i in range(N)]: {when: "u[i] - 0.2*(i + 1) - 0.15", direction: rising, '
        'action: {set: {"u_dot[i]": "-u_dot[i]"}}}'
    ),
    "kicks": (
        'kick[i in range(N)]: {when: "t - 0.0937*(i + 1)", '
        'action: {set: {"w_dot[i]": "w_dot[i]/2 + u[i]/3"}}}'
    ),
    "a jump": (
        'jump: {when: "t - 0.2113", '
        'action: {set: {"u[N - 1]": "u[N - 1] + 0.1", "u_dot[0]": "u_dot[0] + 0.3"}}}'
    ),
    "exchanges": (
        'cross[i in range(N - 1)]: {when: "u[i + 1] - u[i] - 0.25", direction: either, '
        'action: {set: {"u_dot[i]": "u_dot[i + 1]", "u_dot[i + 1]": "u_dot[i]"}}}'
    ),
    "a parameter": 'harder: {when: "t - 0.17", action: {set: {s: "2*s"}}}',
}


def drawn(chance: random.Random) -> str:
    """The text of a random system, with constraints in half of all cases."""
    potential = POTENTIALS[chance.choice(sorted(POTENTIALS))]
    kinetic = f"lagrangian: >-\n  {KINETIC[chance.choice(sorted(KINETIC))]}\n  - s*({potential})"
    bound, rolling = list[str](), list[str]()
    if chance.random() < 0.5:
        bound = [HOLONOMIC[chance.choice(sorted(HOLONOMIC))]]
        rolling = [NONHOLONOMIC[chance.choice(sorted(NONHOLONOMIC))]] * chance.randint(0, 1)
    forces = FORCES[chance.choice(sorted(FORCES))]
    text = text_of(kinetic, chance.choice(SIZES), forces, bound, rolling)
    text = text.replace("{k: 1.5}", "{k: 1.5, s: 1}")
    action = ACTIONS[chance.choice(sorted(ACTIONS))]
    if bound:  # two walls may throw what they hit back and forth through the constraint, ever faster
        action = action.replace("hit[i in range(N)]", "hit[i in range(1)]")
    return f"{text}\nevents:\n  {action}\n"


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize("case", range(40))
def test_motions_are_those_of_the_members(
    case: int, pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    chance = random.Random(f"{pytestconfig.option.seed} actions {case}")
    text, method, motions = drawn(chance), chance.choice(["taylor", "ias15", "DOP853"]), []
    for loops in True, False:
        in_loops(monkeypatch, loops=loops)
        ready, motion = followed(text, OUTPUTS, method=method, stop=0.7)
        assert ready.machine.program.loops == loops, text
        motions.append(motion.data)
    together, apart = ({k: v for k, v in one.items() if "conserved" not in k} for one in motions)
    alike(together, apart, 2.0**-40 if method != "DOP853" else 1e-8, text)


@pytest.mark.exhaustive(keep=0.15)
def test_motions_in_double_double(monkeypatch: pytest.MonkeyPatch) -> None:
    kinetic = f"lagrangian: {KINETIC['neighbours']} - ({POTENTIALS['pairs']})"
    text, motions = text_of(kinetic, 8, "", [HOLONOMIC["curves"]], []), []
    text += f"\nevents:\n  {ACTIONS['kicks']}\n"
    for loops in True, False:
        in_loops(monkeypatch, loops=loops)
        ready, motion = exactly_followed(text, frozenset(["q", "v", "h"]))
        assert ready.machine.program.loops == loops
        assert len(motion.data["events/kick/t"]) == 2
        motions.append({key: values for key, values in motion.data.items() if "events" not in key})
    alike(*motions, 2.0**-90)


@pytest.mark.exhaustive(keep=0.6)
def test_a_blow_on_a_rod_of_elements() -> None:
    """An impulse P on one node changes the velocities by those that M^-1 gives: the sum of momenta by P. The
    file says what the velocities become; of a chain of consistent masses they fall off as (sqrt(3) - 2)^k."""
    count, middle, decay = 300, 150, 3**0.5 - 2
    reach = 40
    sets = ", ".join(
        f'"u_dot[{middle + k}]": "u_dot[{middle + k}] + {3**0.5 * decay ** abs(k)!r}"'
        for k in range(-reach, reach + 1)
    )
    text = f"""
sizes: {{N: {count}}}
coordinates: {{"u[i in range(N + 1)]": {{initial: 0}}}}
lagrangian: >-
  sum((u_dot[i]**2 + u_dot[i]*u_dot[i + 1] + u_dot[i + 1]**2)/6 - (u[i + 1] - u[i])**2/2 for i in range(N))
events: {{blow: {{when: t - 0.123, action: {{set: {{{sets}}}}}}}}}
"""
    ready, motion = followed(text, frozenset(["q", "v", "p"]), stop=0.1234, samples=2)
    assert ready.machine.program.loops
    momenta = motion["diagnostics/p/u"][-1]
    assert abs(np.sum(momenta) - 1.0) < 1e-12
    assert np.max(np.abs(np.delete(momenta, [middle - 1, middle, middle + 1]))) < 1e-6


def test_actions_that_set_masses_go_through_the_members(monkeypatch: pytest.MonkeyPatch) -> None:
    in_loops(monkeypatch, loops=True)
    kinetic = f"lagrangian: {KINETIC['neighbours']} - ({POTENTIALS['pairs']})"
    text = text_of(kinetic, 8, "", [], []) + '\nevents: {more: {when: "t - 0.1", action: {set: {k: 2*k}}}}\n'
    assert systems.family_system(read_spec(text, "system.yaml")) is None
