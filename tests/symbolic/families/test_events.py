"""Events that are printed with their indices, beside those of the members."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

import lagrange_cli
from lagrange_cli.errors import UsageError

SYSTEM = """
sizes: {N: COUNT}
parameters: {k: 1.5, r: 0.1, "d[i in range(N)]": 0.1 + i/9}
coordinates: {"x[i in range(N)]": {initial: i}, y: {initial: 0.2}}
masses: {"bead[i in range(N)]": 1 + i/7, cart: 2}
embedding: {"bead[i in range(N)]": "x[i]", cart: y}
potential: sum(k*(x[i] - x[(i + 1) % N])**2/2 for i in range(N))
events:
  hit[i in range(N), j in range(i) if (i + j) % 2]:
    when: x[i] - x[j] - r
    direction: falling
    action: {set: {"x_dot[i]": "x_dot[j]*d[i]", "x_dot[j]": "x_dot[i]"}}
  wall[i in range(0, N, 2)]: {when: "bead[i].x - d[i]", direction: rising}
  wall[i in range(1, N, 2)]: {when: "bead[i].vx - i", action: stop}
  back: {when: y - t, action: {set: {"x[j in range(1, N) if j % 2]": "x[j - 1] - y", k: 2*k, "d[0]": "r"}}}
"""


def listed(data: dict[str, Any], count: int) -> dict[str, Any]:
    """Each event of lines, with the values of what becomes 0 and of what is set at some state."""
    chance, found = np.random.default_rng(1), {}
    known: dict[str, Any] = {"N": count, "t": 0.7, "k": 1.2, "r": 0.3, "y": 0.9}
    for name in ("x", "x_dot", "d"):
        known[name] = chance.normal(size=count).tolist()
        known |= {f"{name}_{i}": value for i, value in enumerate(known[name])}
    known["y_dot"] = 1.3

    def sets(each: dict[str, Any], own: dict[str, Any]) -> dict[str, float]:
        made = {}
        for target, value in each["set"].items():
            loops = each.get("of", {}).get(target, "for _ in [0]")
            base, bracket, index = target.partition("[")
            place = f"[{index[:-1]}]" if bracket else "''"
            for at, new in eval(f"[({place}, {value}) {loops}]", {**known, **own}):
                made[base + str(at or "")] = new
        return made

    for each in data["events"]:
        base, bracket, inside = each["name"].partition("[")
        names = re.findall(r"[a-z]", inside)
        loops = each.get("members") or "for _ in [0]"
        for place in eval(f"[({''.join(f'{one},' for one in names)}) {loops}]", dict(known)):
            own = dict(zip(names, place))
            inner = ",".join(str(own.get(one, one)) for one in inside[:-1].split(","))
            name = f"{base}[{inner}]" if bracket else base
            value = eval(each["when"], {**known, **own})
            found[name] = value, each["direction"], each["action"], sets(each, own)
    return found


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize("count", [3, 8])
def test_they_are_those_of_the_members(count: int) -> None:
    text = SYSTEM.replace("COUNT", str(count))
    lines, members = (lagrange_cli.equations(text, indexed=indexed).as_data() for indexed in (True, False))
    found, expected = listed(lines, count), listed(members, count)
    assert found.keys() == expected.keys()
    for name, (value, direction, action, sets) in expected.items():
        assert found[name][1:3] == (direction, action)
        assert found[name][0] == pytest.approx(value, rel=1e-12)
        assert found[name][3] == pytest.approx(sets, rel=1e-12)
    broken = {one["quantity"]: one.get("broken_by") for one in members["conserved"]}
    for one in lines["conserved"]:
        assert one.get("broken_by") == broken[one["quantity"]]


@pytest.mark.exhaustive(keep=0.25)
def test_their_lines_do_not_grow_with_them() -> None:
    shown = [lagrange_cli.equations(SYSTEM.replace("COUNT", str(n))).write() for n in (60, 300)]
    one, other = (text.partition("Events\n")[2] for text in shown)
    assert one == other
    said = " ".join(one.split())
    assert (
        "hit[i,j], falling, for i in range(N) for j in range(i) if (i + j) % 2 != 0: "
        "x_dot[i] -> d[i]*x_dot[j], x_dot[j] -> x_dot[i]"
    ) in said
    assert "x[j] -> x[j - 1] - y (for j in range(1, N) if j % 2 != 0), k -> 2*k, d[0] -> r" in said


def test_actions_with_constraints_are_those_of_members() -> None:
    text = SYSTEM.replace("COUNT", "3") + "constraints: {tie: x[0] - y + 0.2}\n"
    with pytest.raises(UsageError, match="constraints and events that set something every member"):
        lagrange_cli.equations(text, indexed=True)


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize("count", [3, 7])
def test_modules_have_the_events_of_members(count: int) -> None:
    """What becomes 0, its direction, and the state after each event are those that members have."""
    text = SYSTEM.replace("COUNT", str(count))
    modules = []
    for indexed in (True, False):
        modules.append(dict[str, Any]())
        exec(lagrange_cli.equations(text, indexed=indexed).write("python"), modules[-1])
    lines, members = modules
    assert "for i in range(N)" in lagrange_cli.equations(text, indexed=True).write("python")
    for name in ("COORDINATES", "EVENTS", "DIRECTIONS"):
        assert lines[name] == members[name]
    chance = np.random.default_rng(2)
    q, v = (tuple(chance.normal(size=count + 1)) for _ in range(2))
    parameters = {name: chance.uniform(0.5, 1.5) for name in lines["PARAMETERS"]}
    state = 0.3, q, v, parameters
    assert lines["events"](*state) == pytest.approx(members["events"](*state), rel=1e-14)
    acted = 0
    for name in lines["EVENTS"]:
        base, _, place = name.rstrip("]").partition("[")
        found = members.get("after_" + re.sub(r"\W", "_", name).rstrip("_"))
        if found is None:
            assert f"after_{base}" not in lines
            continue
        own = [tuple(map(int, place.split(",")))] if place else []
        for one, other in zip(lines[f"after_{base}"](*own, *state), found(*state), strict=True):
            assert one == pytest.approx(other, rel=1e-14)
        acted += 1
    assert acted == len([name for name in lines["EVENTS"] if not name.startswith("wall")])
