"""Events: what a file may say of them, and each mistake at its place."""

from __future__ import annotations

import pytest

from lagrange_cli.errors import SpecError
from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.model.build import build_model
from lagrange_cli.model.model import Event
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.spelling import spelled
from tests.support.files import problems, underlined

SYSTEM = """\
parameters: {e: 0.9, g: 9.81, k: [1, 2]}
sizes: {N: 3}
definitions: {w: 2*y, twice: g**2}
coordinates: {y: {initial: 1}, x[i in range(N)]: {initial: i + 1}}
masses: {ball: 1, bead[i in range(N)]: 1}
positions: {ball: [0, y], bead[i in range(N)]: [x[i], 0]}
potential: g*ball.y
observables: {height: y}
events:
"""


def written(events: str) -> dict[str, Event]:
    """The events of a file, with their expressions as texts."""
    model = build_model(read_spec(SYSTEM + events, "file.yaml"), GraphAlgebra())
    return {
        one.name: Event(
            one.name,
            str(one.argument),
            one.direction,
            one.stops,
            {name: str(value) for name, value in one.changes.items()},
        )
        for one in model.events
    }


def graph(text: str) -> str:
    """An expression as it is shown in those texts."""
    spec = read_spec(SYSTEM.replace("height: y", f"height: {text}").replace("events:\n", ""), "file.yaml")
    return str(build_model(spec, GraphAlgebra()).observables["height"])


@pytest.mark.exhaustive(keep=0.7)
def test_an_event_is_recorded_in_either_direction_unless_more_is_said():
    found = written("  top: y_dot\n  low: {when: ball.y - 1/2}\n")
    assert found == {
        "top": Event("top", graph("y_dot"), 0, False),
        "low": Event("low", graph("y - 1/2"), 0, False),
    }


def test_directions_and_actions():
    found = written("""\
  up: {when: w, direction: rising, action: record}
  down: {when: ball.vy, direction: falling, action: stop}
  any: {when: sin(t), direction: either}
""")
    assert [(one.direction, one.stops) for one in found.values()] == [(1, False), (-1, True), (0, False)]
    assert [one.argument for one in found.values()] == [graph("2*y"), graph("y_dot"), graph("sin(t)")]


def test_coordinates_velocities_and_parameters_are_set():
    found = written("  floor: {when: y, action: {set: {y_dot: -e*ball.vy, k[1]: 2*k[1], y: w + t}}}\n")
    assert found["floor"].changes == {
        "y_dot": graph("-e*y_dot"),
        "k[1]": graph("2*k[1]"),
        "y": graph("2*y + t"),
    }


def test_a_family_of_events_sets_members_by_their_indices():
    found = written("""\
  wall[i in range(N)]: {when: x[i], action: {set: {x_dot[i]: -x_dot[i], x_dot[(i + 1) % N]: i}}}
  pair[i in range(1, N)]: {when: "x[i] - x[i - 1]"}
""")
    assert [*found] == ["wall[0]", "wall[1]", "wall[2]", "pair[1]", "pair[2]"]
    assert found["wall[2]"].changes == {"x_dot[2]": graph("-x_dot[2]"), "x_dot[0]": graph("2")}
    assert found["pair[1]"].argument == graph("x[1] - x[0]")


def test_an_event_sets_all_members_of_a_family():
    found = written("  kick: {when: sin(t), action: {set: {x_dot[j in range(N)]: x_dot[j] + j}}}\n")
    assert found["kick"].changes == {f"x_dot[{j}]": graph(f"x_dot[{j}] + {j}") for j in range(3)}


@pytest.mark.parametrize(
    "name", ["y", "height", "e"], ids=["a coordinate's", "an observable's", "a parameter's"]
)
def test_an_event_may_have_the_name_of_something_else(name):
    assert [*written(f"  {name}: y\n")] == [name]


# the events, then (underlined piece, part of the message, part of the hint) each
BAD = [
    # keys
    ("{condition: y}", [("condition", "unknown key 'condition' in event 'f'", "write 'when'")]),
    ("{event: y}", [("event", "unknown key 'event'", "write 'when'")]),
    ("{trigger: y}", [("trigger", "unknown key 'trigger'", "write 'when'")]),
    ("{when: y, terminal: true}", [("terminal", "unknown key 'terminal'", "write 'action: stop'")]),
    ("{when: y, terminal: false}", [("terminal", "unknown key 'terminal'", "leave it out")]),
    ("{when: y, set: {e: g + z}}", [
        ("set", "unknown key 'set'", "write 'action: {set: {e: ...}}'"), ("z", "unknown name 'z'", "")
    ]),
    ("{direction: rising}", [("f", "event 'f' has no 'when'", "write f: {when: x")]),
    ("", [("", "missing value in event 'f'", "")]),
    # what is watched
    ("y < 0", [("y < 0", "event 'f' needs an expression that becomes", "when: y' and 'direction: falling")]),
    ("{when: y < 0}", [("y < 0", "not a condition", "'when: y' and 'direction: falling'")]),
    ("{when: y <}", [("y <", "not a condition", "'when: y' and 'direction: falling'")]),
    ("{when: 0 < y}", [("0 < y", "not a condition", "'when: y' and 'direction: rising'")]),
    ("{when: y >= 1 + e}", [("y >= 1 + e", "", "'when: y - (1 + e)' and 'direction: rising'")]),
    ("{when: y == 0}", [("y == 0", "", "write 'when: y'")]),
    ("{when: y = 2}", [("y = 2", "", "write 'when: y - 2'")]),
    ("{when: y < z}", [("y < z", "not a condition", "'when: y - z'"), ("z", "unknown name 'z'", "")]),
    ("{when: y > 0 and y < e}", [("y > 0 and y < e", "", "an event for each comparison")]),
    ("{when: 3}", [("3", "never changes", "a coordinate, a velocity or t")]),
    ("{when: g - twice}", [("g - twice", "never changes", "")]),
    ("N", [("N", "never changes", "")]),
    ("{when: ball}", [("ball", "expected a scalar in event 'f', found a vector", "norm()")]),
    ("{when: [y, 1]}", [("[", "must be a scalar", "")]),
    ("{when: thta}", [("thta", "unknown name 'thta' in event 'f'", "")]),
    ("{when: y_ddot}", [("y_ddot", "the acceleration", "")]),
    ("{when: where(ball > 1, 1, y)}", [("ball", "vectors cannot be compared in event 'f'", "norm()")]),
    # directions and actions
    ("{when: y, direction: up}", [("up", "unknown direction of event 'f': 'up'", "write rising")]),
    ("{when: y, direction: -1}", [("-1", "unknown direction", "write falling")]),
    ("{when: y, direction: fallng}", [("fallng", "unknown direction", "write falling")]),
    ("{when: y, direction: left}", [("left", "unknown direction", "known: rising, falling, either")]),
    ("{when: y, action: bounce}", [("bounce", "unknown action of event 'f'", "{set: {x_dot: -x_dot}}")]),
    ("{when: y, action: terminate}", [("terminate", "unknown action", "write stop")]),
    ("{when: y, action: [stop]}", [("[", "must be one action", "record, stop")]),
    ("{when: y, action: y_dot = 1}", [("y_dot = 1", "unknown action", "'action: {set: {y_dot: 1}}'")]),
    ("{when: y, action: {y_dot: 1}}", [("y_dot", "unknown key", "'action: {set: {y_dot: ...}}'")]),
    ("{when: y, action: {impulse: {y: 1}}}", [("impulse", "unknown key", "{set: {x_dot: -x_dot}}")]),
    ("{when: y, action: {velocity: {y: 1}}}", [("velocity", "unknown key", "{set: {x_dot: -x_dot}}")]),
    ("{when: y, action: {change: {y: 1}}}", [("change", "unknown key", "write 'set'")]),
    ("{when: y, action: {bounce: 0.5}}", [("bounce", "unknown key", "{set: {x_dot: -x_dot}}")]),
    ("{when: y, action: {stop: true}}", [("stop", "unknown key", "'action: stop'")]),
    ("{when: y, action: {stop: true, set: {e: 1}}}", [("stop", "unknown key", "either stops")]),
    # what is set
    ("{when: y, action: {set: {}}}", [("{", "set of event 'f' is empty", "'action: record'")]),
    ("{when: y, action: {set: y_dot = 1}}", [("y_dot = 1", "must be a mapping", "'set: {y_dot: 1}'")]),
    ("{when: y, action: {set: {y_dot = 1}}}", [("y_dot = 1", "cannot set", "write y_dot: 1")]),
    ("{when: y, action: {set: {ball.y: 1}}}", [("ball.y", "follows from the coordinates", "")]),
    ("{when: y, action: {set: {ball: 1}}}", [("ball", "the particle 'ball' cannot be set", "")]),
    ("{when: y, action: {set: {height: 1}}}", [("height", "the observable 'height' cannot be set", "")]),
    ("{when: y, action: {set: {w: 1}}}", [("w", "the definition 'w' cannot be set", "")]),
    ("{when: y, action: {set: {t: 1}}}", [("t", "the time 't' cannot be set", "")]),
    ("{when: y, action: {set: {N: 1}}}", [("N", "the size 'N' cannot be set", "")]),
    ("{when: y, action: {set: {k: 1}}}", [("k", "missing index on the family 'k'", "k[i]")]),
    ("{when: y, action: {set: {z_dot: 1}}}", [("z_dot", "unknown name 'z_dot' in event 'f'", "y_dot")]),
    ("{when: y, action: {set: {vy: 1}}}", [("vy", "unknown name 'vy'", "write y_dot for the velocity")]),
    ("{when: y, action: {set: {y': 1}}}", [("y'", "cannot set", "write y_dot for the velocity")]),
    ("{when: y, action: {set: {y_ddot: 1}}}", [("y_ddot", "the acceleration", "determine it")]),
    ("{when: y, action: {set: {x[3]: 1}}}", [("3", "no member 'x[3]'", "x[0] to x[2]")]),
    ("{when: y, action: {set: {x[i]: 1}}}", [("i", "neither an index nor a size", "")]),
    ("{when: y, action: {set: {y[0]: 1}}}", [("y", "not a family", "")]),
    ("{when: y, action: {set: {x[0]: 1, x[j in range(N)]: j}}}", [("x[j in range(N)]", "'x[0]' twice", "")]),
    ("{when: y, action: {set: {e: ball}}}", [("ball", "expected a scalar in the new e of event 'f'", "")]),
    ("{when: y, action: {set: {e: a1 + a2}}}", [("a1", "unknown name", ""), ("a2", "unknown name", "")]),
    ("{when: y < 0, direction: up, action: {set: {w: b}}}", [
        ("y < 0", "", ""), ("up", "", ""), ("w", "cannot be set", ""), ("b", "unknown name 'b'", "")
    ]),
]  # fmt: skip


@pytest.mark.exhaustive(keep=19)
@pytest.mark.parametrize(("event", "expected"), BAD, ids=[event for event, _ in BAD])
def test_each_mistake_is_shown_at_its_place(event, expected):
    found = sorted(problems(f"{SYSTEM}  f: {event}\n"), key=lambda one: one.column)
    shown = [
        (underlined(one) if piece else "", one.message, one.hint)
        for one, (piece, _, _) in zip(found, expected)
    ]
    assert len(found) == len(expected), found
    for (piece, message, hint), (expected_piece, part, hinted) in zip(shown, expected, strict=True):
        assert piece == expected_piece
        assert part in message
        assert hinted in hint


@pytest.mark.parametrize(
    ("events", "message"),
    [
        ("  f: y\n  f: y\n", "the key 'f' is given twice"),
        ("  f[i in range(N)]: x[i]\n  f[0]: x[0]\n", "'f[0]' is given twice"),
        ("  f[i in range(N)]: x[i]\n  f: y\n", "different numbers of indices"),
        ("  f[i in range(M)]: x[i]\n", "unknown size 'M'"),
        ("  f[i in range(N)]: x[i + 1]\n", "no member 'x[3]'"),
        ("  f[i in range(2)]: {when: y, action: {set: {x[i in range(N)]: 1}}}\n", "'i' is already used"),
        ("  f[i in range(N)]: {when: y, action: {set: {x[i + 1]: 1}}}\n", "no member 'x[3]'"),
        ("  - y\n", "events must be a mapping with names"),
        ("  2f: y\n", "the event cannot be called '2f'"),
    ],
)
def test_mistakes_in_the_names_of_events(events, message):
    assert [one.message for one in problems(SYSTEM + events) if message in one.message]
    assert len(problems(SYSTEM + events)) == 1


def test_an_argument_whose_coordinates_cancel_never_changes():
    with pytest.raises(SpecError, match="never changes"):
        written("  f: {when: y + e - y}\n")


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("x[i] - x[i - 1]", "x[1] - x[0]"),
        ("2*bead[i].vx*i", "2*bead[1].vx*1"),
        ("x[(i + 2) % N]**i", "x[0]**1"),
        ("sum(x[j]*i for j in range(i)) + x[i]", "sum(x[j]*1 for j in range(1)) + x[1]"),
        ("sum(x[j + i] for j in range(N - i))", "sum(x[j + 1] for j in range(N - 1))"),
    ],
)
def test_the_texts_of_members_have_numbers_in_place_of_indices(text, shown):
    spec = read_spec(f"{SYSTEM}  f[i in range(1, 2)]: {text}\n", "file.yaml")
    assert spelled(spec.events["f[1]"].when, spec.sizes) == shown


def test_the_text_of_a_point_of_a_member_has_numbers_too():
    text = """\
sizes: {N: 2}
coordinates: {q[i in range(N)]: {initial: 0.1}}
bodies:
  rod[i in range(N)]:
    {mass: 1, solid: {rod: 1}, position: [0, 0, 0], orientation: {euler: [0, q[i], 0], sequence: xyz}}
events: {low[i in range(N)]: "2*rod[(i + 1) % N].at(q[i], 0, i).x - i"}
"""
    spec = read_spec(text, "file.yaml")
    assert spelled(spec.events["low[1]"].when, spec.sizes) == "2*rod[0].at(q[1], 0, 1).x - 1"


def test_an_event_does_not_set_the_angular_velocity_of_a_body():
    text = """
coordinates: {a: {initial: 1}}
bodies: {top: {mass: 1, solid: {sphere: 1}, position: [0, 0, 0], orientation: {euler: [a, 0, 0]}}}
events: {e: {when: a - 2, action: {set: {top.w3: 0}}}}
"""
    (problem,) = problems(text)
    assert underlined(problem) == "top.w3"
    assert "follows from the coordinates and cannot be set" in problem.message
