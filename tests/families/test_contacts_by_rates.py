"""Members that bounce and come to rest in steps on rates, beside the same systems written out."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from lagrange_cli.families import system as systems
from lagrange_cli.integrate.ending import Finished
from lagrange_cli.integrate.impacts.happenings import Happenings
from lagrange_cli.run.choice import examined
from lagrange_cli.spec.read import read_spec
from tests.families import test_contacts as contacts
from tests.families import test_coupled_contacts as coupled
from tests.families import test_joint_contacts as jointed
from tests.families.test_coupled_contacts import motion
from tests.families.test_events import keep_families
from tests.families.test_switches import BY_RATES, followed, ready

CLOSE = 2.0**-28


def compare(text: str, stop: float, method: str, patch: pytest.MonkeyPatch) -> None:
    """Members come to rest as they do one by one."""
    patch.setattr(systems, "FEWEST_TURNING", 0)
    found, expected = (motion(text, stop, whole=whole, patch=patch, method=method) for whole in (True, False))
    assert found.keys() == expected.keys()
    for path in (one for one in expected if not one.startswith("events/")):
        assert np.max(np.abs(found[path] - expected[path]), initial=0.0) <= CLOSE, path


@pytest.mark.exhaustive(keep=0.35)
@BY_RATES
@pytest.mark.parametrize("count", [1, 2, 3, 8, 9])
@pytest.mark.parametrize("case", contacts.CASES)
def test_members_rest_by_themselves(
    case: str, count: int, method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    across, up, events = contacts.CASES[case]
    text = contacts.BALLS.format(count=count, across=across, up=up, events=events)
    compare(text, 3.1, method, monkeypatch)


@pytest.mark.exhaustive(keep=0.45)
@BY_RATES
@pytest.mark.parametrize(("e", "count"), [("0.3847 + 0.1126*cos(0.786*i)", 5), ("0.4 + 0.1*cos(i)", 8)])
def test_what_bounces_stays_above_the_floor(
    e: str, count: int, method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However low the last flights are; compiled code does all impacts but the last ones of each member."""
    acted, act = [0], Happenings._act

    def counting(self: Happenings, event: int, *given: Any) -> Finished | None:
        acted[0] += 1
        return act(self, event, *given)

    monkeypatch.setattr(Happenings, "_act", counting)
    across, up, events = contacts.CASES["a floor that drags"]
    text = contacts.BALLS.format(count=count, across=across, up=up, events=events)
    found = motion(text.replace("0.4 + 0.1*cos(i)", e), 3.1, whole=True, patch=monkeypatch, method=method)
    assert found["t"][-1] == 3.1 and np.all(found["q/y"] >= -1e-12)
    assert not found["q/y"][-1].any() and not found["v/y"][-1].any()
    assert 10 * count < len(found["events/floor/t"]) and count <= acted[0] <= 4 * count


@pytest.mark.exhaustive(keep=0.5)
@BY_RATES
@pytest.mark.parametrize("e", [0, 0.3])
@pytest.mark.parametrize("case", coupled.CASES)
def test_contacts_hold_one_another(case: str, e: float, method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    compare(coupled.CASES[case].format(count=3, e=e), 0.8, method, monkeypatch)


@pytest.mark.exhaustive(keep=0.35)
@BY_RATES
@pytest.mark.parametrize("e", [0, 0.4])
@pytest.mark.parametrize("case", jointed.CASES)
def test_joints_rest(case: str, e: float, method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    compare(jointed.written(case, 3, e), jointed.CASES[case][-1], method, monkeypatch)


HAIL = """
sizes: {N: 60}
parameters: {g: 9.81, e: 0.5, c: 0.1}
coordinates: {"x[i in range(N)]": {initial: 0}, "y[i in range(N)]": {initial: "0.5 + 0.01*(i % 7)"}}
masses: {"stone[i in range(N)]": 1}
embedding: {"stone[i in range(N)]": ["x[i]", "y[i]"]}
potential: sum(g*y[i] for i in range(N))
forces: {"stone[i in range(N)]": "-c*norm((x_dot[i], y_dot[i]))*(x_dot[i], y_dot[i])"}
events:
  floor[i in range(N)]: {when: "y[i]", direction: falling, action: {set: {"y_dot[i]": "-e*y_dot[i]"}}}
"""


@pytest.mark.exhaustive(keep=0.15)
def test_what_falls_with_drag_comes_to_rest(monkeypatch: pytest.MonkeyPatch) -> None:
    """v dv/dy = -g + c v^2 gives the speed at the first impact, v^2 = g/c (1 - exp(-2 c y)), at the time
    artanh(v sqrt(c/g))/sqrt(c g)."""
    keep_families(monkeypatch, whole=True)
    method = examined(read_spec(HAIL, "system.yaml"), ["q"], None).split()[0]
    assert method == "ias15"
    found = followed(ready(HAIL, method=method), HAIL, 1.5)
    heights = 0.5 + 0.01 * (np.arange(60) % 7)
    speeds = np.sqrt(9.81 / 0.1 * -np.expm1(-0.2 * heights))
    times = np.arctanh(speeds * np.sqrt(0.1 / 9.81)) / np.sqrt(0.981)
    first = [found["events/floor/t"][found["events/floor/i"] == i][0] for i in range(60)]
    assert np.allclose(first, times, rtol=1e-13, atol=0.0)
    assert not found["q/y"][-1].any() and not found["v/y"][-1].any()
