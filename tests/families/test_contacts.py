"""Members of families that bounce and come to rest, beside the same systems written out and closed forms."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from lagrange_cli.families import system as systems
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.ending import Finished
from lagrange_cli.integrate.families import family_run
from lagrange_cli.integrate.impacts.happenings import Happenings
from lagrange_cli.native.families import own_actions
from lagrange_cli.native.guards import EXPLICIT, LOOSE, SIMPLE, Role
from lagrange_cli.spec.read import read_spec
from tests.families.test_events import OUTPUTS, followed, keep_families, ready

BALLS = """
sizes: {{N: {count}}}
parameters: {{g: 9.81, s: 0.3, L: 0.9, "e[i in range(N)]": "0.4 + 0.1*cos(i)"}}
coordinates:
  x[i in range(N)]: {{initial: "0.2*sin(i)", velocity: "0.3*cos(i*i + 1)"}}
  y[i in range(N)]: {{initial: "1 + 0.3*sin(i)", velocity: "0.3*cos(i*i + 2)"}}
masses: {{"ball[i in range(N)]": 1 + i/7}}
embedding: {{"ball[i in range(N)]": ["x[i]", "y[i]"]}}
potential: sum((1 + i/7)*g*y[i] + x[i]**2 + 0.1*y[i]*x[i] for i in range(N))
generalized_forces: {{"x[i in range(N)]": "{across}", "y[i in range(N)]": "{up}"}}
events: {events}
"""


def event(when: str, sets: str, direction: str = "falling") -> str:
    """The text of an event."""
    return f'{{when: "{when}", direction: {direction}, action: {{set: {{{sets}}}}}}}'


FLOOR = event("y[i]", '"y_dot[i]": "-e[i]*y_dot[i]"')
ALONG = '"y_dot[i]": "y_dot[i] - (1 + e[i])*{0}/{1}", "x_dot[i]": "x_dot[i] + {2}*(1 + e[i])*{0}/{1}"'
SLOPE = ALONG.format("(y_dot[i] - s*x_dot[i])", "(1 + s**2)", "s")
BOWL = ALONG.format("(y_dot[i] - 2*s*x[i]*x_dot[i])", "(1 + 4*s**2*x[i]**2)", "2*s*x[i]")
BACK = '"x_dot[i]": "-e[i]*x_dot[i]"'
SHAKEN = '"y_dot[i]": "1.2*cos(6*t) - e[i]*(y_dot[i] - 1.2*cos(6*t))"'
CASES = {
    "a floor": ("0", "0", f'{{"floor[i in range(N)]": {FLOOR}}}'),
    "a floor that drags": (
        "0",
        "0",
        '{"floor[i in range(N)]": '
        + event("y[i]", '"y_dot[i]": "-e[i]*y_dot[i]", "x_dot[i]": "x_dot[i] + 0.1*y_dot[i]"')
        + "}",
    ),
    "a slope": ("0", "0", f'{{"floor[i in range(N)]": {event("y[i] - s*x[i]", SLOPE)}}}'),
    "a bowl": ("0", "0", f'{{"floor[i in range(N)]": {event("y[i] - s*x[i]**2", BOWL)}}}'),
    "a floor that shakes": ("0", "0", f'{{"floor[i in range(N)]": {event("y[i] - 0.2*sin(6*t)", SHAKEN)}}}'),
    "walls": (
        "9*sin(1.5*t + i)",
        "0",
        f'{{"right[i in range(N)]": {event("x[i] - L", BACK, "rising")},'
        f' "left[i in range(N)]": {event("x[i] + L", BACK)}, "floor[i in range(N)]": {FLOOR}}}',
    ),
    "kicks": (
        "0",
        "0",
        f'{{"floor[i in range(N)]": {FLOOR}, "zero[i in range(N)]": {{when: "x[i]"}},'
        ' kick: {when: "t - 1.6", action: {set: {"y_dot[i in range(N)]": "y_dot[i] + 0.3*i"}}}}',
    ),
    "balls that are lifted": ("0", "12*max(0, sin(2*t + i))", f'{{"floor[i in range(N)]": {FLOOR}}}'),
    "an elastic wall besides": (
        "-3",
        "0",
        f'{{"floor[i in range(N)]": {FLOOR}, "wall[i in range(N)]": '
        + event("-x[i] - 0.1", '"x_dot[i]": "-x_dot[i]"', "rising")
        + "}",
    ),
    "clay": ("0", "0", '{"floor[i in range(N)]": ' + event("y[i]", '"y_dot[i]": 0') + "}"),
}
SAMPLES, LATE = 2.0**-36, 2.0**-26
"""Bounds for samples, and for impacts shortly before members rest, whose times are known less well."""
FIRST = 6
"""Impacts of a member that are compared: how many there are before it rests is up to rounding."""


@pytest.mark.exhaustive(keep=0.55)
@pytest.mark.parametrize("count", [1, 2, 3, 8, 9])
@pytest.mark.parametrize("case", CASES)
def test_members_rest_as_they_do_one_by_one(case: str, count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    across, up, events = CASES[case]
    text = BALLS.format(count=count, across=across, up=up, events=events)
    keep_families(monkeypatch, whole=True)
    assert family_run(read_spec(text, "system.yaml"), Compilation("taylor", 2.0**-52, OUTPUTS)) is not None
    found = followed(ready(text), text, 3.1)
    keep_families(monkeypatch, whole=False)
    expected = followed(ready(text), text, 3.1)
    assert found.keys() == expected.keys()
    for path in (one for one in expected if not one.startswith("events/")):
        assert np.max(np.abs(found[path] - expected[path]), initial=0.0) <= SAMPLES, path
    for path in (one for one in expected if one.startswith("events/") and one.endswith("/i")):
        for i in range(count):
            both = [data[path[:-1] + "t"][data[path] == i][:FIRST] for data in (found, expected)]
            assert len(both[0]) == len(both[1])
            assert np.max(np.abs(both[0] - both[1]), initial=0.0) <= LATE, path


@pytest.mark.exhaustive(keep=0.35)
def test_balls_come_to_rest_when_the_geometric_series_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    """Impacts at t0 (1 + 2 e + ... + 2 e^k), t0 = sqrt(2 h/g), until (1 + e)/(1 - e) t0."""
    keep_families(monkeypatch, whole=True)
    text = """
sizes: {N: 9}
parameters: {g: 2, "h[i in range(N)]": "1 + i/4", "e[i in range(N)]": "0.2 + 0.05*i"}
coordinates: {"y[i in range(N)]": {initial: "h[i]"}}
masses: {"ball[i in range(N)]": 1 + i}
embedding: {"ball[i in range(N)]": "y[i]"}
potential: sum((1 + i)*g*y[i] for i in range(N))
events:
  floor[i in range(N)]: {when: "y[i]", direction: falling, action: {set: {"y_dot[i]": "-e[i]*y_dot[i]"}}}
"""
    prepared, acted = ready(text), list[int]()
    act = Happenings._act

    def counting(self: Happenings, event: int, *given: Any) -> Finished | None:
        acted.append(event)
        return act(self, event, *given)

    monkeypatch.setattr(Happenings, "_act", counting)
    assert {one[2] for one in prepared.machine.program.events} == {EXPLICIT}
    assert prepared.recording.conserved == ()
    found = followed(prepared, text, 9.0)
    for i in range(9):
        first, e = np.sqrt(1.0 + i / 4), 0.2 + 0.05 * i
        times = found["events/floor/t"][found["events/floor/i"] == i]
        powers = e ** np.arange(1, len(times))
        assert len(times) > 10
        assert np.allclose(times, first * (1.0 + 2.0 * np.cumsum([0.0, *powers])), rtol=0.0, atol=2.0**-40)
    assert 9 <= len(acted) <= 3 * 9  # of more than 200 impacts: the rest is done by compiled code
    at_rest = (1.0 + 0.6) / (1.0 - 0.6) * np.sqrt(3.0)
    assert found["t"][-1] > at_rest
    assert np.max(np.abs(found["q/y"][-1])) <= 2.0**-60
    assert np.max(np.abs(found["v/y"][-1])) <= 2.0**-60


@pytest.mark.parametrize(
    "events",
    [
        '{"knock[i in range(1, N)]": {when: "y[i] - y[i - 1]",'
        ' action: {set: {"y_dot[i]": "0.5*y_dot[i - 1]", "y_dot[i - 1]": "0.5*y_dot[i]"}}}}',
        '{"floor[i in range(N)]": {when: "y[i]",'
        ' action: {set: {"y_dot[i]": "-y_dot[i]/(1 + abs(y_dot[i]))"}}}}',
    ],
)
def test_other_contacts_go_through_the_members(events: str, monkeypatch: pytest.MonkeyPatch) -> None:
    keep_families(monkeypatch, whole=True)
    spec = read_spec(BALLS.format(count=3, across="0", up="0", events=events), "system.yaml")
    assert systems.family_system(spec) is None


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("case", CASES)
def test_what_is_said_of_contacts_does_not_grow_with_them(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    keep_families(monkeypatch, whole=True)

    def counted(count: int) -> tuple[int, int]:
        across, up, events = CASES[case]
        text = BALLS.format(count=count, across=across, up=up, events=events)
        system = systems.family_system(read_spec(text, "system.yaml"))
        assert system is not None
        program = ready(text).machine.program
        return len(system.slots.graph.nodes), len(program.text.splitlines())

    assert counted(200) == counted(264)


@pytest.mark.exhaustive(keep=0.3)
def test_a_ball_rests_on_while_others_bounce(monkeypatch: pytest.MonkeyPatch) -> None:
    """Written out, too: what an impact leaves of a speed by rounding is none."""
    across, up, events = CASES["kicks"]
    text = BALLS.format(count=3, across=across, up=up, events=events)
    for whole in (True, False):
        keep_families(monkeypatch, whole=whole)
        assert np.min(followed(ready(text), text, 3.1)["q/y"]) >= -(2.0**-40)


def test_ledgers_and_proofs_go_through_the_members(monkeypatch: pytest.MonkeyPatch) -> None:
    keep_families(monkeypatch, whole=True)
    across, up, events = CASES["a floor"]
    spec = read_spec(BALLS.format(count=3, across=across, up=up, events=events), "system.yaml")
    for asked in (
        Compilation("taylor", 2.0**-52, OUTPUTS | {"ledger"}),
        Compilation("taylor", 2.0**-52, OUTPUTS, proven=True),
    ):
        assert family_run(spec, asked) is None
    for method in ("ias15", "DOP853"):
        assert family_run(spec, Compilation(method, 2.0**-52, OUTPUTS)) is not None


DISCS = """
sizes: {{N: {count}}}
parameters: {{R: 0.2, e: {restitution}}}
coordinates:
  x[i in range(N)]: {{initial: "0.5*(i % 3) + 0.02*sin(i)", velocity: "cos(7*i*i + 1)"}}
  y[i in range(N)]: {{initial: "0.5*(i // 3) + 0.03*cos(i)", velocity: "sin(5*i*i + 2)"}}
masses: {{"disc[i in range(N)]": 1 + i/7}}
embedding: {{"disc[i in range(N)]": ["x[i]", "y[i]"]}}
potential: {potential}
events:
  hit[i in range(N), j in range(i)]:
    when: (x[i] - x[j])**2 + (y[i] - y[j])**2 - 4*R**2
    direction: falling
    action: {{set: {{{sets}}}}}
  right[i in range(N)]:
    {{when: "x[i] - 1.3", direction: rising, action: {{set: {{"x_dot[i]": "-e*x_dot[i]"}}}}}}
"""


def discs(count: int, restitution: str, square: str, potential: str = "0") -> str:
    """The text of a system of discs whose impulses are divided by the ``square`` of their distance."""
    speed = "((x[i] - x[j])*(x_dot[i] - x_dot[j]) + (y[i] - y[j])*(y_dot[i] - y_dot[j]))"
    impulse = f"(1 + e)/(2 + (i + j)/7)*{speed}/{square}"
    sets = ", ".join(
        f'"{x}_dot[{a}]": "{x}_dot[{a}] - (1 + {b}/7)*({x}[{a}] - {x}[{b}])*{impulse}"'
        for a, b in ("ij", "ji")
        for x in "xy"
    )
    return DISCS.format(count=count, restitution=restitution, sets=sets, potential=potential)


DISTANCE = "((x[i] - x[j])**2 + (y[i] - y[j])**2)"


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize(("restitution", "square"), [("0.9", DISTANCE), ("0.5", "(4*R**2)")])
def test_discs_collide_inelastically_as_they_do_one_by_one(
    restitution: str, square: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without forces nothing comes back after an impact: no contact is followed, or would keep discs."""
    text = discs(4, restitution, square, "3*sum((1 + i/7)*y[i] for i in range(N))")
    keep_families(monkeypatch, whole=True)
    prepared = ready(text)
    assert {one[1:] for one in prepared.machine.program.events} == {(int(Role.CHANGE), LOOSE)}
    assert prepared.machine.program.order == 12  # arguments of degree 4 have no more coefficients
    found = followed(prepared, text, 0.9)
    keep_families(monkeypatch, whole=False)
    expected = followed(ready(text), text, 0.9)
    assert found.keys() == expected.keys()
    assert len(found["events/hit/t"]) >= 4
    for path, values in expected.items():
        assert np.max(np.abs(found[path] - values), initial=0.0) <= 2.0**-40, path


@pytest.mark.exhaustive(keep=0.65)
def test_impacts_of_discs_keep_momentum_and_reduce_the_speed(monkeypatch: pytest.MonkeyPatch) -> None:
    """v+ = -e v along the line of centres, v across it; the momentum is that before."""
    keep_families(monkeypatch, whole=True)
    text = discs(2, "0.6", "(4*R**2)")
    data = followed(ready(text), text, 0.6)
    state = np.concatenate([data["events/hit/q/x"][0], data["events/hit/q/y"][0]]).reshape(2, 2)
    before, after = (np.array([data[f"v/{x}"][row] for x in "xy"]) for row in (0, -1))
    assert len(data["events/hit/t"]) == 1
    normal = (state[:, 1] - state[:, 0]) / 0.4
    across = np.array([-normal[1], normal[0]])
    masses = 1 + np.arange(2) / 7
    relative = before[:, 1] - before[:, 0], after[:, 1] - after[:, 0]
    assert np.isclose(normal @ relative[1], -0.6 * (normal @ relative[0]), rtol=1e-13)
    assert np.allclose(across @ after, across @ before, rtol=0.0, atol=1e-14)  # of each disc
    assert np.allclose(after @ masses, before @ masses, rtol=0.0, atol=1e-14)


def test_discs_that_are_elastic_at_their_surface_keep_the_energy(monkeypatch: pytest.MonkeyPatch) -> None:
    keep_families(monkeypatch, whole=True)
    prepared = ready(discs(4, "1", "(4*R**2)").replace("1 + e", "2").replace("-e*", "-"))
    assert {one[1:] for one in prepared.machine.program.events} == {(int(Role.CHANGE), SIMPLE)}
    assert prepared.recording.conserved == ("h",)


def test_a_cradle_hands_a_velocity_on(monkeypatch: pytest.MonkeyPatch) -> None:
    """Equal balls at rest, a small gap apart: with restitution e the last one gets ((1 + e)/2)^(N - 1)."""
    keep_families(monkeypatch, whole=True)
    text = """
sizes: {N: 9}
parameters: {e: 0.8}
coordinates: {"x[i in range(N)]": {initial: "1.01*i", velocity: "where(i == 0, 1, 0)"}}
masses: {"ball[i in range(N)]": 1}
embedding: {"ball[i in range(N)]": "x[i]"}
potential: 0
events:
  hit[i in range(1, N)]:
    when: x[i] - x[i - 1] - 1
    direction: falling
    action:
      set:
        x_dot[i]: (1 - e)/2*x_dot[i] + (1 + e)/2*x_dot[i - 1]
        x_dot[i - 1]: (1 + e)/2*x_dot[i] + (1 - e)/2*x_dot[i - 1]
"""
    found = followed(ready(text), text, 0.2)
    assert found["events/hit/i"][:8].tolist() == [*range(1, 9)]
    assert np.isclose(np.max(found["v/x"][:, -1]), 0.9**8, rtol=1e-14)
    assert np.allclose(np.sum(found["v/x"], axis=1), 1.0, rtol=1e-14)


@pytest.mark.exhaustive(keep=0.8)
def test_compiled_code_does_elastic_actions_beside_contacts(monkeypatch: pytest.MonkeyPatch) -> None:
    keep_families(monkeypatch, whole=True)
    across, up, events = CASES["an elastic wall besides"]
    text, acted = BALLS.format(count=3, across=across, up=up, events=events), list[int]()
    act = Happenings._act

    def counting(self: Happenings, event: int, *given: Any) -> Finished | None:
        acted.append(event)
        return act(self, event, *given)

    monkeypatch.setattr(Happenings, "_act", counting)
    found = followed(ready(text), text, 3.1)
    assert np.all(np.bincount(found["events/wall/i"].astype(int)) >= 2)
    assert set(acted) <= {0, 1, 2}  # those of the floor, where balls may rest


ALONE = "a floor", "walls", "an elastic wall besides"


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("case", CASES)
def test_actions_of_one_event_give_the_same_bits_as_those_of_all(
    case: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With many events only the action of the one that happens is computed (``native.families.own_actions``),
    also where impacts use what it sets."""
    across, up, events = CASES[case]
    text = BALLS.format(count=9, across=across, up=up, events=events)
    keep_families(monkeypatch, whole=True)
    found = []
    for fewest in (0, 10**9):
        monkeypatch.setattr(own_actions, "FEWEST", fewest)
        prepared = ready(text)
        alone = "@act_alone" in prepared.machine.program.text
        assert not alone if fewest else alone or case not in ALONE, case
        found.append(followed(prepared, text))
    for path, values in found[1].items():
        assert np.array_equal(found[0][path], values, equal_nan=True), (case, path)
