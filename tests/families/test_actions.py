"""Actions of events on chains and on families with constraints, beside the same systems written out."""

from __future__ import annotations

import numpy as np
import pytest

from lagrange_cli.families import system as systems
from lagrange_cli.integrate.impacts import impulses
from tests.families.test_events import keep_families
from tests.families.test_locked import CHAIN, HEAD, SPACE, TREE
from tests.families.test_switches import OUTPUTS, compare, followed, ready

EVENT = """
events:
  "hit[i in range(N)]": {{when: "{when}", direction: {direction}, action: {{set: {{{sets}}}}}}}
"""
REVERSED = '"a_dot[j in range(N)]": "-a_dot[j]"'
CHAINS = {
    "a wall": (CHAIN, "bob[i].x - 1.1*l[0]", "rising", REVERSED),
    "a wall of a tree": (TREE, "bob[i].x - 1.1*l[0]", "rising", REVERSED),
    "a floor in space": (
        SPACE, "bob[i].z + 1.2", "falling", f'{REVERSED}, "b_dot[j in range(N)]": "-b_dot[j]"',
    ),
    "stops of joints": (CHAIN, "a[i] - 0.4", "either", '"a_dot[i]": "-a_dot[i]"'),
    "turning points": (CHAIN, "a_dot[i]", "falling", '"a[i]": "a[i] - 0.1"'),
    "kicks of others": (CHAIN, "a[i] - 0.4", "rising", '"a[0]": "a[0] - 0.1", "a_dot[N - 1]": "0.3*i"'),
    "more weight": (CHAIN, "a[i] - 0.3", "rising", '"g": "1.1*g"'),
}  # fmt: skip
BOBS = """
sizes: {{N: {count}}}
parameters: {{g: 9.8, r: 0.09}}
coordinates:
  "x[i in range(N)]": {{initial: "i + 1", velocity: "0.4"}}
  "y[i in range(N)]": {{initial: "1 + 0.3*sin(i)"}}
masses: {{"bob[i in range(N)]": "1 + 0.1*i"}}
embedding: {{"bob[i in range(N)]": ["x[i]", "y[i]"]}}
potential: "sum((1 + 0.1*i)*g*y[i] for i in range(N))"
constraints:
  "rod[i in range(1, N)]": "(x[i] - x[i - 1])**2 + (y[i] - y[i - 1])**2 - 1 - r*(sin(i) - sin(i - 1))**2"
"""
BOUND = {
    "a floor": ("y[i]", "falling", '"y_dot[i]": "-y_dot[i]"'),
    "a floor that rubs": ("y[i]", "falling", '"y_dot[i]": "-y_dot[i]", "x_dot[i]": "x_dot[i]/2"'),
    "a floor that stops all": ("y[i]", "falling", '"y_dot[j in range(N)]": "-y_dot[j]"'),
    "other speeds": (
        "x[i] - 1.01*i - 1.2", "rising", '"x_dot[j in range(N)]": "-x_dot[j]", "y_dot[i]": "0.2"',
    ),
    "other places": ("y[i] - 0.9", "falling", '"y[i]": "y[i] - 0.02", "x[i]": "x[i] + 0.05"'),
    "more weight": ("y[i] - 0.9", "falling", '"g": "1.1*g"'),
}  # fmt: skip


def chain(case: str, count: int) -> str:
    """The text of a system file."""
    form, when, direction, sets = CHAINS[case]
    head = (HEAD + form).format(count=count, start="0.3*sin(i)", speed="1 + cos(i)")
    return head + EVENT.format(when=when, direction=direction, sets=sets)


def bobs(case: str, count: int) -> str:
    """The same."""
    when, direction, sets = BOUND[case]
    return BOBS.format(count=count) + EVENT.format(when=when, direction=direction, sets=sets)


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("method", ["taylor", "ias15"])
@pytest.mark.parametrize("count", [1, 2, 3, 8, 9])
@pytest.mark.parametrize("case", CHAINS)
def test_chains_act_as_written_out(
    case: str, count: int, method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    compare(chain(case, count), monkeypatch, stop=0.8, method=method)


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize("few", [64, 0])
@pytest.mark.parametrize("method", ["taylor", "ias15"])
@pytest.mark.parametrize("count", [2, 3, 8, 9])
@pytest.mark.parametrize("case", BOUND)
def test_constraints_have_impulses_as_written_out(
    case: str, count: int, method: str, few: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(impulses, "FEW", few)
    compare(bobs(case, count), monkeypatch, OUTPUTS | {"multipliers"}, stop=0.7, method=method)


BODIES = """
sizes: {{N: {count}}}
coordinates:
  "z[i in range(N)]": {{initial: "1 + 0.1*i"}}
  "a[i in range(N)]": {{initial: 1}}
  "b[i in range(N)]": {{initial: 0, velocity: 0.1}}
  "c[i in range(N)]": {{initial: 0, velocity: 0.2}}
  "d[i in range(N)]": {{initial: 0, velocity: "0.3 + i/9"}}
bodies:
  "body[i in range(N)]":
    mass: 1
    inertia: [1, "2 + 0.1*i", 2.5]
    position: [0, 0, "z[i]"]
    orientation: {{quaternion: ["a[i]", "b[i]", "c[i]", "d[i]"]}}
potential: "sum(9.8*z[i] for i in range(N))"
"""
TURNED = {
    "a floor": ("z[i]", "falling", '"z_dot[i]": "-z_dot[i]"'),
    "what turns back": (
        "c[i] - 0.02", "rising", ", ".join(f'"{x}_dot[j in range(N)]": "-{x}_dot[j]"' for x in "abcd"),
    ),
    "what turns back in part": ("c[i] - 0.02", "rising", '"c_dot[i]": "-c_dot[i]"'),
}  # fmt: skip


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize("method", ["taylor", "ias15"])
@pytest.mark.parametrize("count", [1, 2, 3, 8, 9])
@pytest.mark.parametrize("case", TURNED)
def test_bodies_have_impulses_as_written_out(
    case: str, count: int, method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(systems, "FEWEST_TURNING", 0)
    when, direction, sets = TURNED[case]
    text = BODIES.format(count=count) + EVENT.format(count=count, when=when, direction=direction, sets=sets)
    compare(text, monkeypatch, stop=1.4, method=method)


@pytest.mark.exhaustive(keep=0.3)
def test_a_chain_of_rods_bounces_without_loss(monkeypatch: pytest.MonkeyPatch) -> None:
    """The floor gives what turns the velocity of a bob back, and the rods do no work."""
    keep_families(monkeypatch, whole=True)
    text = bobs("a floor", 60)
    found = followed(ready(text), text, 0.6)
    h = found["diagnostics/h"]
    assert np.all(np.abs(h - h[0]) <= 1e-12 * h[0])
    assert len(found["events/hit/t"]) > 40
    x, y = found["q/x"], found["q/y"]
    assert np.all(y > -1e-12)
    start = (x[0], y[0])
    lengths = [np.diff(a, axis=-1) ** 2 + np.diff(b, axis=-1) ** 2 for a, b in ((x, y), start)]
    assert np.allclose(lengths[0], lengths[1], rtol=0.0, atol=1e-13)


@pytest.mark.exhaustive(keep=0.5)
def test_a_chain_goes_back_on_its_way_from_a_wall(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where all velocities are reversed, the motion is that before in reversed time."""
    keep_families(monkeypatch, whole=True)
    text = chain("a wall", 40).replace('"0.3*sin(i)"', '"0.01*i"').replace('"1 + cos(i)"', "2")
    ready_made = ready(text)
    hit = float(followed(ready_made, text, 1.0)["events/hit/t"][0])
    found = followed(ready_made, text, 2.0 * hit)
    assert np.allclose(found["q/a"][-1], found["q/a"][0], rtol=0.0, atol=1e-10)
    assert np.allclose(found["v/a"][-1], -found["v/a"][0], rtol=0.0, atol=1e-9)
