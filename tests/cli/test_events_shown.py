"""The line of the summary about events."""

from lagrange_cli.cli.report.events import events_shown


def one(count, last=None):
    return {"count": count, "last": last}


def test_few_events_are_named_each():
    events = {"floor": one(2, 1.5), "wall[0]": one(0), "wall[1]": one(3, 2.0)}
    assert events_shown(events) == [
        "  events: wall[1] 3 (last at t = 2), floor 2 (last at t = 1.5), wall[0] 0"
    ]
    assert events_shown({}) == []


def test_many_are_counted_by_family():
    events = {
        f"hit[{i},{j}]": one(i if j == 0 else 0, i / 4 if j == 0 else None)
        for i in range(5)
        for j in range(i)
    }
    events |= {f"wall[{i}]": one(0) for i in range(5)} | {"top": one(11, 3.0)}
    said = "  events: top 11 (last at t = 3), hit[i,j] 10 at 4 of 10 members (last at t = 1)"
    assert events_shown(events) == [said]


def test_where_none_of_many_happened_that_is_said():
    assert events_shown({f"wall[{i}]": one(0) for i in range(9)}) == ["  events: none happened"]


def test_of_many_families_the_first_are_named():
    events = {f"{name}[{i}]": one(9 - k) for k, name in enumerate("abcdef") for i in range(2)}
    assert events_shown(events)[0].endswith("d[i] 12 at 2 of 2 members (and 2 more)")
