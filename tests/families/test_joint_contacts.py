"""Chains, trees and rigid bodies whose impacts reduce the speed, beside the same systems written out, closed
forms and conservation."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from lagrange_cli.families import system as systems
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.families import family_run
from lagrange_cli.integrate.precision import DOUBLE_DOUBLE, FULL_DOUBLE_DOUBLE
from lagrange_cli.integrate.prepare import prepare_system
from lagrange_cli.native.families import nearness
from lagrange_cli.run.derive import derive_system
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_long_values
from tests.families.test_actions import BODIES
from tests.families.test_coupled_contacts import motion
from tests.families.test_events import keep_families
from tests.families.test_locked import CART, CHAIN, HEAD, SPACE, TOPS, TREE
from tests.families.test_switches import OUTPUTS
from tests.support.draws import examples
from tests.support.motion import run

FALLS = '"hit[i in range(N)]": {{when: "a[i] - 0.2", direction: falling, action: {{set: {{{0}}}}}}}'
SLOWER = '"a_dot[i]": "-{e}*a_dot[i]"'
STOP = f"\nevents:\n  {FALLS.replace('{0}', SLOWER)}\n"
RIGHT = f'  "right[i in range(N)]": {{{{when: "a[i] - 0.4", action: {{{{set: {{{{{SLOWER}}}}}}}}}}}}}\n'
TURNED = f"""
events:
  "hit[i in range(N)]": {{{{when: "a[i] - 1.2", direction: rising, action: {{{{set: {{{{{SLOWER}}}}}}}}}}}}}
"""
CURVED = STOP.replace("a[i] - 0.2", "sin(a[i]) - 0.2 - 0.05*t").replace(
    '"-{e}*a_dot[i]"', '"0.05*(1 + {e})/cos(a[i]) - {e}*a_dot[i]"'
)
SQUARE = STOP.replace("a[i] - 0.2", "a[i]**2 - 0.0025").replace("falling", "rising")
DRAGGED = STOP.replace(SLOWER, SLOWER + ', "b_dot[i]": "b_dot[i] + 0.1*a_dot[i]"').replace("0.2", "0.7")
BETWEEN = """
generalized_forces: {{"a[i in range(N)]": "-9*i + 3*sin(4*t)*(-1)**i"}}
events:
  "hit[i in range(1, N)]":
    when: "a[i] - a[i - 1] + 0.1"
    direction: falling
    action:
      set:
        "a_dot[i]": "a_dot[i] - (0.4 + 0.1*sin(a[i]))*(1 + {e})*(a_dot[i] - a_dot[i - 1])"
        "a_dot[i - 1]": "a_dot[i - 1] + (0.6 - 0.1*sin(a[i]))*(1 + {e})*(a_dot[i] - a_dot[i - 1])"
"""
FLOOR = """
events:
  "hit[i in range(N)]": {{when: "z[i]", direction: falling, action: {{set: {{"z_dot[i]": "-{e}*z_dot[i]"}}}}}}
"""
WALL = """
events:
  "hit[i in range(N)]": {{{{when: "{when}", direction: {direction}, action: {{{{set: {{{{{sets}}}}}}}}}}}}}
"""
ALL = '"a_dot[j in range(N)]": "-{e}*a_dot[j]"'


def wall(when: str, sets: str = ALL, direction: str = "falling") -> str:
    """The text of a family of events at places of bobs."""
    return WALL.format(when=when, sets=sets, direction=direction)


AT_ONCE = wall("bob[i].x - 0.2*l[0]*(i + 1) + 0.1*sin(3*t) + 0.1*a[i]")
PART = wall("bob[i].x - 0.3*l[0]*(i + 1)", '"a_dot[j in range(N)]": "-({e} + 0.1*j/N)*a_dot[j]"')
DEEP = wall("bob[i].y + 0.85*sum(l[j] for j in range(i + 1))", SLOWER)
APART = wall("dot(bob[i] - bob[i - 2], bob[i] - bob[i - 2]) - 0.9*(l[i] + l[i - 1])**2", SLOWER, "rising")
APART = APART.replace("i in range(N)]", "i in range(2, N)]", 1)
IN_SPACE = wall("bob[i].z + 0.8*(i + 1)", ALL + ', "b_dot[j in range(N)]": "-{e}*b_dot[j]"')
ON_CART = wall("bob[i].x - 0.9*(i + 1)", ALL + ', "x_dot": "-{e}*x_dot"', "rising")
CASES = {
    "a wall": (HEAD + CHAIN + wall("bob[i].x - 0.2*l[0]*(i + 1)"), "0.4 + 0.05*sin(i)", 1.2),
    "a wall that moves": (HEAD + CHAIN + AT_ONCE, "0.4 + 0.05*sin(i)", 1.0),
    "a wall that slows some more": (HEAD + CHAIN + PART, "0.5 + 0.05*sin(i)", 0.5),
    "a wall of a tree": (HEAD + TREE + wall("bob[i].x - 0.2"), "0.4 + 0.05*sin(i)", 1.2),
    "floors that stop one link": (HEAD + CHAIN + DEEP, "1 + 0.05*sin(i)", 1.6),
    "distances": (HEAD + CHAIN + APART, "1 - 0.6*i", 0.6),
    "a floor in space": (HEAD + SPACE + IN_SPACE, "0.3*sin(i)", 1.2),
    "a wall of a chain on a cart": (HEAD + CART + ON_CART, "0.3*sin(i)", 1.2),
    "stops of a chain": (HEAD + CHAIN + STOP, "0.3 + 0.02*i", 1.5),
    "stops on both sides": (HEAD + CHAIN + STOP + RIGHT, "0.3 + 0.02*i", 1.5),
    "stops that move": (HEAD + CHAIN + CURVED, "0.3 + 0.02*i", 1.5),
    "stops whose slope is 0 at the start": (HEAD + CHAIN + SQUARE, "0", 1.5),
    "stops between links": (HEAD + CHAIN + BETWEEN, "0.3 + 0.1*i", 0.4),
    "stops of a tree": (HEAD + TREE + STOP, "0.3 + 0.02*i", 1.5),
    "stops of a chain on a cart": (HEAD + CART + STOP, "0.3 + 0.02*i", 1.5),
    "a chain in space": (HEAD + SPACE + DRAGGED, "0.3 + 0.02*i", 1.5),
    "tops": (HEAD + TOPS + TURNED, "0.02*i", 1.2),
    "quaternion bodies": (BODIES + FLOOR, "0", 1.5),
}
IN_DOUBLE_DOUBLE = [("stops of a chain", 0.25, 1.5), ("stops between links", 0, 0.6), ("a wall", 0.5, 1.2)]
LEAST = {"stops between links": 2, "distances": 3, "stops whose slope is 0 at the start": 2}
"""Members of systems that have fewer: none, or one that touches its stop so slowly that rounding decides."""
CLOSE = 2.0**-36


def written(case: str, count: int, e: float | str) -> str:
    """The text of a system file."""
    form, start, _ = CASES[case]
    return form.format(count=count, start=start, speed="0.3*cos(i)", e=e)


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("e", [0, 0.4])
@pytest.mark.parametrize("count", [1, 2, 3, 8, 9])
@pytest.mark.parametrize("case", CASES)
def test_joints_rest_as_written_out(case: str, count: int, e: float, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(systems, "FEWEST_TURNING", 0)
    count = max(
        count,
        {"stops between links": 2, "distances": 3, "stops whose slope is 0 at the start": 2}.get(case, 1),
    )
    text, stop = written(case, count, e), CASES[case][-1]
    found, expected = (motion(text, stop, whole=whole, patch=monkeypatch) for whole in (True, False))
    for path in (one for one in expected if not one.startswith("events/")):
        size = max(1.0, float(np.max(np.abs(expected[path]))))
        assert np.max(np.abs(found[path] - expected[path])) <= CLOSE * size, path


def random_stops(count: int, e: float, seed: int, start: str = "0.3 + 0.1*i") -> str:
    """The text of a chain with stops between links, on which random forces pull."""
    chance = np.random.default_rng(seed)
    part, pull = (round(float(one), 3) for one in chance.uniform([0.2, 4.0], [0.8, 12.0]))
    text = HEAD + CHAIN + BETWEEN.replace("0.6", f"{round(1 - part, 3)}").replace("(0.4", f"({part}")
    return text.replace("-9*i", f"-{pull}*i").format(
        count=count, start=start, speed=f"0.3*cos({seed}*i)", e=round(e, 3)
    )


@pytest.mark.exhaustive(keep=0.15)
@examples(1)
@given(st.integers(2, 9), st.floats(0.0, 0.9), st.integers(0, 99))
@example(7, 0.0390625, 1)
@example(9, 0.0, 31)
def test_random_stops_of_random_chains(count: int, e: float, seed: int) -> None:
    text = random_stops(count, e, seed)
    with pytest.MonkeyPatch.context() as patch:
        found, expected = (motion(text, 0.3, whole=whole, patch=patch) for whole in (True, False))
    for path in (one for one in expected if not one.startswith("events/")):
        size = max(1.0, float(np.max(np.abs(expected[path]))))
        assert np.max(np.abs(found[path] - expected[path])) <= CLOSE * size, path


@pytest.mark.exhaustive(keep=0.3)
@pytest.mark.parametrize("listed", [False, True])
def test_rounding_errors_do_not_grow_where_impacts_accumulate(
    listed: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two contacts hit each other ever faster until all of them rest: flights become shorter than the last
    digits of angles. Starts that differ by 1e-15 stay as near, also where steps look for arguments near 0."""
    if listed:
        monkeypatch.setattr(nearness, "FEWEST", 0)
        monkeypatch.setattr(nearness, "MANY", 0)
    texts = [random_stops(7, 0.039, 1, f"0.3 + {nudge} + 0.1*i") for nudge in ("0", "1e-15")]
    first, other = (motion(text, 0.3, whole=True, patch=monkeypatch) for text in texts)
    assert len(first["events/hit/t"]) > 50
    assert np.max(np.abs(other["v/a"] - first["v/a"])) <= 1e-12


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize(("case", "e", "stop"), IN_DOUBLE_DOUBLE)
def test_joints_rest_in_double_double(
    case: str, e: float, stop: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    text, found = written(case, 4, e).replace(" + 3*sin(4*t)*(-1)**i", ""), []
    spec = read_spec(text, "system.yaml")
    asked = Compilation("taylor", FULL_DOUBLE_DOUBLE, OUTPUTS, precision=DOUBLE_DOUBLE)
    for whole in (True, False):
        keep_families(monkeypatch, whole=whole)
        assert (family_run(spec, asked) is not None) == whole
        prepared = prepare_system(spec, partial(derive_system, resting=True, exact=True), None, asked)
        found.append(run(prepared, resolve_long_values(spec, {}), 0.0, stop, 4).data)
    for path in ("q/a", "v/a"):
        high, low = (found[0][one] - found[1][one] for one in (path, f"low/{path}"))
        assert np.max(np.abs(high + low)) <= 2.0**-90
    if case == "stops between links":
        assert np.max(np.abs(np.diff(found[0]["v/a"][-1]))) <= 2.0**-80


@pytest.mark.exhaustive(keep=0.15)
def test_bodies_turn_freely_while_they_bounce(monkeypatch: pytest.MonkeyPatch) -> None:
    """Impacts at t0 (1 + 2 e + ... + 2 e^k), t0 = sqrt(2 h/g), until (1 + e)/(1 - e) t0, change neither the
    energy of rotation nor the norms of quaternions."""
    monkeypatch.setattr(systems, "FEWEST_TURNING", 0)
    found = motion(written("quaternion bodies", 9, 0.5), 1.9, whole=True, patch=monkeypatch)
    heights = 1 + 0.1 * np.arange(9)
    falls = np.sqrt(2.0 * heights / 9.8)
    for i, fall in enumerate(falls):
        times = found["events/hit/t"][found["events/hit/i"] == i][:6]
        expected = fall * (1.0 + 2.0 * np.concatenate([[0.0], np.cumsum(0.5 ** np.arange(1, 6))]))
        assert np.allclose(times, expected, rtol=0.0, atol=1e-13)
    rests = 3.0 * falls < found["t"][-1]
    assert rests.any() and np.all(found["q/z"][-1][rests] == 0.0) and np.all(found["v/z"][-1][rests] == 0.0)
    v, z = found["v/z"], found["q/z"]
    turning = found["diagnostics/h"] - np.sum(v**2 / 2.0 + 9.8 * z, axis=1)
    assert np.allclose(turning, turning[0], rtol=0.0, atol=1e-12)
    assert np.allclose(sum(found[f"q/{one}"] ** 2 for one in "abcd"), found["q/a"][0] ** 2, atol=1e-13)


@pytest.mark.exhaustive(keep=0.5)
def test_links_that_rest_do_not_move(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first of many links, which falls on its stop, rests there exactly."""
    form, _, _ = CASES["stops of a chain"]
    text = form.format(count=60, start=0.25, speed=0, e=0.3)
    found = motion(text, 1.0, whole=True, patch=monkeypatch)
    assert np.all(found["q/a"] >= 0.2 - 1e-15)
    assert np.all(found["q/a"][-2:, 0] == 0.2) and np.all(found["v/a"][-2:, 0] == 0.0)


def test_impacts_that_set_other_than_own_velocities_are_written_out() -> None:
    sets = '"a_dot[i]": "a_dot[i] - 1.5*bob[i].vx/(l[i]*cos(a[i]))"'
    text = (HEAD + CHAIN + wall("bob[i].x - 0.2", sets)).format(count=12, start="0.3", speed="0")
    spec = read_spec(text, "system.yaml")
    assert systems.any_family_system(spec) is None
    assert "by those of particles" in systems.reason(spec)[0]


@pytest.mark.exhaustive(keep=0.4)
def test_a_bob_rests_at_a_wall(monkeypatch: pytest.MonkeyPatch) -> None:
    """No bob of many goes through it, and the one that has hit it stays there, on a line."""
    form, _, _ = CASES["a wall"]
    text = form.format(count=40, start=0.4, speed=-1, e=0)
    found = motion(text, 0.8, whole=True, patch=monkeypatch)
    a, lengths, numbers = found["q/a"], 1.0 + np.arange(40) / 9.0, np.arange(40)
    heights = np.cumsum(lengths * np.sin(a), axis=1) - 0.2 * (1 + numbers)
    assert np.all(heights >= -1e-11)
    (hit,) = found["events/hit/i"]
    after = found["t"] > found["events/hit/t"][0]
    assert np.count_nonzero(after) > 3 and np.all(np.abs(heights[after][:, hit]) <= 1e-11)
