"""What many events are and set, as groups of what is written once."""

from __future__ import annotations

import pytest

from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.families.conserved import breaks
from lagrange_cli.families.groups import Group
from lagrange_cli.families.written_events import arguments_of, assigned_by, directions_of
from lagrange_cli.run.check import classify
from lagrange_cli.spec.content import names_of
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.spec import Expression
from tests.families.test_events import FREE

EVENTS = """
  wall: {when: y - 1, direction: rising, action: {set: {y_dot: -y_dot, k: 2*k}}}
  "hit[i in range(N), j in range(i)]":
    when: x[i] - x[j]
    direction: falling
    action:
      set:
        x_dot[i]: x_dot[i] - 2*(7 + j)/(14 + i + j)*(x_dot[i] - x_dot[j])
        x_dot[j]: x_dot[j] + 2*(7 + i)/(14 + i + j)*(x_dot[i] - x_dot[j])
  "ring[i in range(N) if i % 2]": {when: "x[i] - 3", action: {set: {"x[(i + 1) % N]": "x[i] - 3"}}}
  "ring[i in range(N) if i % 2 == 0]": {when: "x[i] + 3", action: stop}
  "all[i in range(2)]":
    {when: "t - 3 - i", action: {set: {"x_dot[l in range(N) if l != i]": "-x_dot[l]", "x[l in range(i)]": 0}}}
  top: y_dot
"""


def written_one_by_one(group: Group) -> list[tuple[object, dict[str, int]]]:
    """The trees of a group's members, with the values of the indices."""
    indices = {name: values.tolist() for name, values in group.indices.items()}
    return [
        (group.trees[label], {name: values[k] for name, values in indices.items()})
        for k, label in enumerate(group.labels.tolist())
    ]


def are(group: Group, expected: list[Expression]) -> None:
    found = written_one_by_one(group)
    assert [tree for tree, _ in found] == [one.tree for one in expected]
    for (_, indices), one in zip(found, expected):
        assert one.indices.items() <= indices.items()


@pytest.mark.parametrize("count", [1, 2, 5, 20])
def test_groups_of_events_are_those_of_members(count: int) -> None:
    spec = read_spec(FREE.replace("EVENTS", EVENTS).replace("COUNT", str(count)), "system.yaml")
    events = [*spec.events.values()]
    coordinates = [*names_of(spec.coordinates)]
    names = [*coordinates, *map(velocity_name, coordinates), *names_of(spec.parameters)]
    are(arguments_of(spec), [one.when for one in events])
    directions, stops = directions_of(spec)
    assert directions.tolist() == [one.direction for one in events]
    assert stops.tolist() == [one.stops for one in events]
    found = assigned_by(spec)
    expected = [(e, names.index(name), x) for e, one in enumerate(events) for name, x in one.changes.items()]
    assert [*zip(found.events.tolist(), found.places.tolist())] == [(e, place) for e, place, _ in expected]
    are(found.values, [x for *_, x in expected])


@pytest.mark.exhaustive(keep=0.75)
def test_each_event_is_looked_at_where_it_sets_something(monkeypatch: pytest.MonkeyPatch) -> None:
    """Elastic impacts are seen to keep P and h beside events that set places and parameters, even where h
    takes too long to evaluate at these."""
    text, found = FREE.replace("EVENTS", EVENTS).replace("COUNT", "6"), []
    for most in (breaks.MOST, 0):
        monkeypatch.setattr(breaks, "MOST", most)
        found.append(
            {one.quantity: one.breaks for one in classify(read_spec(text, "a.yaml")).mechanics.conserved}
        )
    rings, every = ("ring[1]", "ring[3]", "ring[5]"), ("all[0]", "all[1]")
    assert found[0]["p_y"] == ("wall",)
    assert found[0]["P_x"] == ("wall", *every)
    assert found[0]["h"] == ("wall", *rings, "all[1]")
    assert found[1] == found[0]
