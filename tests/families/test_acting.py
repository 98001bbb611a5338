"""Members whose terms are 0 by the modes of their switches are left out: nothing else may change."""

from __future__ import annotations

import random

import numpy as np
import pytest

from lagrange_cli.families import system as systems
from lagrange_cli.integrate.precision import DOUBLE_DOUBLE
from lagrange_cli.native.families import acting
from lagrange_cli.native.families.acting import ActingLoop, parted
from lagrange_cli.native.families.loops import Loop, loops, needed
from lagrange_cli.spec.read import read_spec
from tests.families.test_events import keep_families
from tests.families.test_switches import long_motions
from tests.support.families import alike, followed

FORCES = {
    "contacts": "k/2*max(0, 2*R - norm(disc[i] - disc[j]))**2",
    "contacts and charges": "k/2*max(0, 2*R - norm(disc[i] - disc[j]))**2 + c/norm(disc[i] - disc[j])",
    "shells": "where(norm(disc[i] - disc[j]) < 3*R, c*(norm(disc[i] - disc[j]) - 3*R)**3, 0)",
    "squares": "k*max(0, 4*R**2 - (x[i] - x[j])**2 - (y[i] - y[j])**2)**2",
    "two in one": "(k + c)*max(0, x[j] - x[i] - 4*R)**2 + k*max(0, y[j] - y[i] - 5*R)**2",
}
"""Of pairs of discs; charges act always."""
GAS = """
sizes: {{N: {count}}}
parameters: {{R: {radius!r}, k: {k!r}, c: 0.01}}
coordinates:
  x[i in range(N)]: {{initial: 0.3*(i % 4) + 0.05*sin(3*i), velocity: {speed}sin({a!r}*i*i)}}
  y[i in range(N)]: {{initial: 0.3*(i//4) + 0.05*cos(5*i), velocity: {speed}cos({a!r}*i*i)}}
masses: {{"disc[i in range(N)]": 1 + i % 3}}
positions: {{"disc[i in range(N)]": ["x[i]", "y[i]"]}}
potential:
  pairs: sum({pair} for i in range(N) for j in range(i))
  weight: sum(2*y[i] for i in range(N))
  walls: sum(k*max(0, -x[i])**2 + k*max(0, x[i] - 1)**2 + k*max(0, -y[i])**2 for i in range(N))
{further}
"""
RODS = """
definitions:
  x_at[i in range(N)]: 0.3*(i % 4) + 0.05*sin(3*i)
  y_at[i in range(N)]: 0.3*(i//4) + 0.05*cos(5*i)
constraints:
  rod[i in range(1, N) if i % 4]: >-
    norm(disc[i] - disc[i - 1]) - sqrt((x_at[i] - x_at[i - 1])**2 + (y_at[i] - y_at[i - 1])**2)
"""
DRAG = "dissipation: sum(0.1*(x_dot[i] - x_dot[j])**2 for i in range(N) for j in range(i))"


def gas(pair: str, count: int, chance: random.Random, further: str = "") -> str:
    """Discs with random velocities; on rods, at rest."""
    given = {"radius": chance.uniform(0.05, 0.15), "k": chance.uniform(50, 500), "a": chance.uniform(1, 9)}
    speed = "0*" if further == RODS else ""
    return GAS.format(count=count, pair=FORCES[pair], further=further, speed=speed, **given)


def listing(monkeypatch: pytest.MonkeyPatch, fewest: int) -> None:
    """From so many members on those that act are listed."""
    monkeypatch.setattr(acting, "FEWEST", fewest)
    monkeypatch.setattr(acting, "CROWDED", 0)
    keep_families(monkeypatch, whole=True)


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("method", ["taylor", "ias15", "DOP853"])
@pytest.mark.parametrize("further", ["", DRAG, RODS], ids=["free", "drag", "rods"])
@pytest.mark.parametrize("pair", FORCES)
def test_the_motion_is_that_of_all_members(
    pair: str, further: str, method: str, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    chance = random.Random(f"{request.config.option.seed} {pair} {further} {method}")
    text = gas(pair, chance.choice([2, 3, 8, 9, 12]), chance, further)
    asked = {"stop": 0.4, "method": method, "tolerance": 1e-9 if method == "DOP853" else 2.0**-52}
    outputs = frozenset(["q", "v", "h", "p"])
    motions, texts = [], []
    for fewest in (0, 10**9):
        listing(monkeypatch, fewest)
        prepared, motion = followed(text, outputs, **asked)
        assert prepared.machine.program.loops
        motions.append(motion.data)
        texts.append(prepared.machine.program.text)
    assert texts[0] != texts[1]
    alike(*motions, 1e-5 if method == "DOP853" else 1e-9, text)


@pytest.mark.exhaustive(keep=0.4)
@pytest.mark.parametrize("pair", FORCES)
def test_in_double_double_too(
    pair: str, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    chance = random.Random(f"{request.config.option.seed} {pair} {DOUBLE_DOUBLE}")
    text = gas(pair, 5, chance)
    monkeypatch.setattr(acting, "FEWEST", 0)
    monkeypatch.setattr(acting, "CROWDED", 0)
    alike(*long_motions(text, monkeypatch, 0.3), 2.0**-80, text)


def parts_of(text: str, monkeypatch: pytest.MonkeyPatch) -> list[Loop]:
    """The loops of the forces of a system, in their parts."""
    listing(monkeypatch, 0)
    system = systems.family_system(read_spec(text, "system.yaml"))
    assert system is not None and system.smooth is not None
    listed = loops(needed([system.smooth.forces], system.slots), system.slots)
    return [part for one in listed if isinstance(one, Loop) for part in parted(one, 0)]


@pytest.mark.parametrize("pair", FORCES)
def test_what_may_be_idle_is_apart(pair: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Charges act always, and are in a loop of their own; idle are the modes in which nothing touches."""
    parts = parts_of(gas(pair, 6, random.Random(0)), monkeypatch)
    pairs = [one for one in parts if one.domain.count == 15]
    idle = [one for one in pairs if isinstance(one, ActingLoop)]
    assert len(idle) == 1 and len(pairs) == (2 if "charges" in pair else 1)
    count = 2 if pair == "two in one" else 1
    assert len(idle[0].modes) == count and len(idle[0].idle) == 1
    walls = [one for one in parts if one.domain.count == 6]
    assert [len(one.modes) for one in walls if isinstance(one, ActingLoop)] == [3]


def test_forces_that_always_act_have_no_lists(monkeypatch: pytest.MonkeyPatch) -> None:
    """One side of a switch is 0 nowhere; the other is, in the forces of one coordinate alone."""
    text = """
    sizes: {N: 6}
    coordinates: {x[i in range(N)]: {initial: 0.1*i}}
    lagrangian: sum(x_dot[i]**2/2 - where(x[i] > 0.2, 2, 1)*(x[i] - 0.2)**2 for i in range(N))
    """
    assert not any(isinstance(one, ActingLoop) for one in parts_of(text, monkeypatch))


def test_the_work_of_a_step_is_that_of_those_that_touch(monkeypatch: pytest.MonkeyPatch) -> None:
    """A row of discs, of which two neighbours touch: they move as these two alone do, to the bit."""
    text = """
    sizes: {N: 40}
    parameters: {k: 100}
    coordinates: {x[i in range(N)]: {initial: "where(i == 1, 0.95, i)", velocity: "where(i == 0, 0.5, 0)"}}
    masses: {disc[i in range(N)]: 1}
    positions: {disc[i in range(N)]: "[x[i]]"}
    potential: sum(k/2*max(0, 1 - (x[i] - x[j]))**2 for i in range(N) for j in range(i))
    """
    listing(monkeypatch, 0)
    outputs = frozenset(["q"])
    _, few = followed(text.replace("N: 40", "N: 2"), outputs, stop=0.1)
    _, many = followed(text, outputs, stop=0.1)
    assert many.outcome.steps == few.outcome.steps
    assert np.array_equal(many["q/x"][:, :2], few["q/x"])
    assert np.array_equal(many["q/x"][-1, 2:], np.arange(2.0, 40.0))
