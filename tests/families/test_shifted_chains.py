"""Chains in which the places of members follow from coordinates of the members before, too, as of the centres
of links."""

from __future__ import annotations

import random

import pytest

from lagrange_cli.families import system as systems
from lagrange_cli.spec.read import read_spec
from tests.families.test_chains import fewest
from tests.support.families import alike, followed

WRITTEN = frozenset(["q", "v", "h", "p", "positions"])
BEGINNINGS = {
    "a hinge": ("", "l[0]/2*cos(a[0])", "l[0]/2*sin(a[0])"),
    "a free link": (
        "X: {initial: 0.1, velocity: 0.3}\n  Y: {initial: -0.2}\n  ",
        "X", "Y",
    ),
    "a driven end": ("", "0.1*sin(2*t) + l[0]/2*cos(a[0])", "l[0]/2*sin(a[0])"),
}  # fmt: skip
PLANE = """
sizes: {{N: {count}}}
parameters: {{g: 9.81, "l[i in range(N)]": "0.5 + 0.1*sin(3*i)", "m[i in range(N)]": "1 + 0.2*cos(i)"}}
coordinates:
  {free}a[i in range(N)]: {{initial: "{seed}*sin(i + {seed}) - 1.2", velocity: "0.3*cos({seed}*i)"}}
definitions:
  x[0]: {x}
  y[0]: {y}
  x[i in range(1, N)]: "{across}"
  y[i in range(1, N)]: "{up}"
bodies:
  b[i in range(N)]:
    {{mass: "m[i]", inertia: [0.1, 0.1, "m[i]*l[i]**2/12"], position: "[x[i], y[i], 0]",
      orientation: {{euler: ["a[i]", 0, 0], sequence: zxz}}}}
potential: sum(m[i]*g*b[i].y for i in range(N)) + sum(2*(1 - cos(a[i] - a[i - 1])) for i in range(1, N))
dissipation: sum((0.2*b[i].vx**2 + 0.1*b[i].vy**2)/2 for i in range(N))
{more}
"""
STEPS = {
    "apart": ("l[i - 1]/2*{0}(a[i - 1]) + l[i]/2*{0}(a[i])", "{} - 1] + {}"),
    "together": ("(l[i - 1]*{0}(a[i - 1]) + l[i]*{0}(a[i]))/2", "{1} + {0} - 1]"),
}
"""What is added, and how."""


def text(count: int, beginning: str, steps: str, more: str, seed: float) -> str:
    """A chain of links in a plane."""
    free, x, y = BEGINNINGS[beginning]
    step, whole = STEPS[steps]
    across, up = (whole.format(f"{name}[i", step.format(one)) for name, one in (("x", "cos"), ("y", "sin")))
    return PLANE.format(count=count, free=free, x=x, y=y, across=across, up=up, more=more, seed=seed)


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize("count", [2, 3, 8, 9])
@pytest.mark.parametrize("beginning", BEGINNINGS)
def test_links_move_as_with_members_written_out(
    beginning: str, count: int, pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    chance = random.Random(f"{pytestconfig.option.seed} {beginning} {count}")
    seed, method = round(chance.uniform(0.3, 1.0), 2), chance.choice(["taylor", "ias15"])
    more = chance.choice(["", "generalized_forces: {'a[i in range(1, N)]': 'sin(t + i)'}"])
    given = text(count, beginning, chance.choice([*STEPS]), more, seed)
    monkeypatch.setattr(systems, "FEWEST_JOINTED", 0)
    fewest(monkeypatch, 0)
    system = systems.family_system(read_spec(given, "links.yaml"))
    assert system is not None and system.joints is not None and system.joints.count == count
    _, found = followed(given, WRITTEN, stop=0.3, method=method)
    fewest(monkeypatch, 10**9)
    monkeypatch.setattr(systems, "FEWEST_JOINTED", 10**9)
    _, expected = followed(given, WRITTEN, stop=0.3, method=method)
    alike(found.data, expected.data, 2.0**-40, given)


@pytest.mark.exhaustive(keep=0.15)
def test_centres_and_ends_of_links_are_the_same_motion() -> None:
    """200 links: by their centres, each from the one before, and by their ends."""
    centres = text(200, "a hinge", "together", "", 0.5)
    ends = centres.replace("x[0]: l[0]/2", "x[0]: l[0]").replace("y[0]: l[0]/2", "y[0]: l[0]")
    ends = ends.replace("(l[i - 1]*cos(a[i - 1]) + l[i]*cos(a[i]))/2", "l[i]*cos(a[i])")
    ends = ends.replace("(l[i - 1]*sin(a[i - 1]) + l[i]*sin(a[i]))/2", "l[i]*sin(a[i])")
    ends = ends.replace("[x[i], y[i], 0]", "[x[i] - l[i]/2*cos(a[i]), y[i] - l[i]/2*sin(a[i]), 0]")
    motions = [followed(one, frozenset(["q", "v", "positions"]), stop=0.2)[1].data for one in (centres, ends)]
    alike(*motions, 2.0**-40)


@pytest.mark.parametrize("leaves", [1, 2])
def test_members_of_which_several_follow_are_written_out(
    leaves: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Their places differ by functions of the same coordinate, which then moves several members."""
    fewest(monkeypatch, 0)
    given = f"""
sizes: {{N: 7}}
coordinates: {{"a[i in range(N)]": {{initial: 0.1}}}}
definitions:
  x[0]: sin(a[0])
  x[i in range(1, N)]: x[(i - 1)//{leaves}] + sin(a[(i - 1)//{leaves}]) + sin(a[i])
masses: {{"b[i in range(N)]": 1}}
embedding: {{"b[i in range(N)]": "x[i]"}}
potential: sum(b[i].x**2 for i in range(N))
"""
    found = systems.any_family_system(read_spec(given, "tree.yaml"))
    assert (found is not None) == (leaves == 1)
