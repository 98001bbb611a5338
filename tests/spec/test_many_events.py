"""Events of many members are read once, and are those of Python's loops; mistakes are said as of few."""

from __future__ import annotations

import pytest

from lagrange_cli.spec.draft import WrittenEvent
from lagrange_cli.spec.event import Event
from lagrange_cli.spec.read import examine, read_spec

FILE = """\
sizes: {{N: {count}}}
parameters: {{e: 0.9, "gap[i in range(N)]": "1 + i"}}
coordinates: {{"x[i in range(N)]": {{initial: "3*i"}}}}
definitions: {{"d[i in range(N), j in range(N) if i != j]": "x[i] - x[j]", p: "[x[0], 0]"}}
masses: {{"bead[i in range(N)]": 1}}
embedding: {{"bead[i in range(N)]": ["x[i]"]}}
potential: 0
events:
  "hit[i in range(N), j in range(i)]": {{when: {when}, direction: falling, action: {{set: {{{sets}}}}}}}
  last: x[0] - 2
"""
SETS = {
    '"x_dot[i]": "-e*x_dot[j]", "gap[j]": "2*gap[i]"': lambda i, j, n: {
        f"x_dot[{i}]": {"i": i, "j": j},
        f"gap[{j}]": {"i": i, "j": j},
    },
    '"x_dot[k in range(N) if k != i and (k - j) % 3 == 1]": "d[k, i] + x_dot[k]", e: 1': lambda i, j, n: {
        **{f"x_dot[{k}]": {"i": i, "j": j, "k": k} for k in range(n) if k != i and (k - j) % 3 == 1},
        "e": {"i": i, "j": j},
    },
    '"x[k in range(j)]": "x[k] + i"': lambda i, j, n: {f"x[{k}]": {"i": i, "j": j, "k": k} for k in range(j)},
}


@pytest.mark.parametrize("sets", SETS)
def test_what_many_events_set_is_what_loops_say(sets: str) -> None:
    for count in (4, 17):  # 6 pairs, and 136: as many as are read together
        spec = read_spec(FILE.format(count=count, when="d[i, j] - 0.1", sets=sets), "file.yaml")
        pairs = [(i, j) for i in range(count) for j in range(i)]
        assert [*spec.events] == [f"hit[{i},{j}]" for i, j in pairs] + ["last"]
        for (i, j), event in zip(pairs, spec.events.values()):
            expected = SETS[sets](i, j, count)
            assert {name: one.indices for name, one in event.changes.items()} == expected
            assert event.when.indices == {"i": i, "j": j}
            assert (event.direction, event.stops) == (-1, False)


def test_members_are_not_looked_at_one_by_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 1770 events, the first of each row is made, and no action."""
    made, member = list[str](), WrittenEvent.member
    monkeypatch.setattr(
        WrittenEvent, "member", lambda self, name, indices: made.append(name) or member(self, name, indices)
    )
    monkeypatch.setattr(Event, "changes", property(lambda self: pytest.fail("the action of a member")))
    for sets in SETS:
        made.clear()
        _, problems = examine(FILE.format(count=60, when="d[i, j] - 0.1", sets=sets), "file.yaml")
        assert problems.found == []
        assert len(made) <= 60


WRONG = {
    ("d[i, j]", '"x_dot[i]": 0, "x_dot[(2*j) % N]": 1'): "sets 'x_dot[",
    ("d[i, j]", '"x[k in range(i)]": 0, "x[j]": 1'): "sets 'x[",
    ("d[i, j]", '"x_dot[i + 1]": 0'): "no member 'x_dot[",
    ("d[i, j]", '"x[i]": "1/(j - 3)"'): "division by zero",
    ("d[i, j]", '"x[k in range(N)]": "d[i, k]"'): "no member 'd[",
    ("d[i, j]", '"x[i]": p'): "expected a scalar",
    ("d[i, j]", '"bead[i]": 0'): "the particle 'bead' cannot be set",
    ("d[i, j]", '"x[i]": "y[i]"'): "unknown name 'y'",
    ("d[i, j]", '"x[i in range(N)]": 0'): "the index 'i' is already used",
    ("gap[i] - e", '"x[i]": 0'): "never changes",
    ("d[j, j]", '"x[i]": 0'): "no member 'd[",
}


@pytest.mark.exhaustive(keep=5)
@pytest.mark.parametrize(("when", "sets"), WRONG)
def test_mistakes_in_many_events_are_said_as_in_few(when: str, sets: str) -> None:
    said = []
    for count in (8, 20):
        _, problems = examine(FILE.format(count=count, when=when, sets=sets), "file.yaml")
        said.append([(one.line, one.column, one.message.partition("[")[0]) for one in problems.found])
        assert WRONG[when, sets] in problems.found[0].message
    assert said[0] == said[1]
