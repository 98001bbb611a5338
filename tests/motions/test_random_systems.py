"""Random systems, followed with steps on rates: the motion, its ending and its events are those of the Taylor
method; samples change nothing; and a run goes on from each of its checkpoints to the same bits."""

from __future__ import annotations

import math
import random
from unittest import mock

import numpy as np
import pytest

from lagrange_cli.integrate.events import NO_EVENTS
from lagrange_cli.integrate.method import CheckpointSink, End, Observer, Snapshot, Start
from lagrange_cli.integrate.methods.taylor import TaylorMethod
from lagrange_cli.records import replace
from tests.support.motion import Motion, follow, prepared, run, values_of

METHODS = [("ias15", 2.0**-52, 1e-9), ("DOP853", 1e-10, 1e-5), ("Radau", 1e-8, 1e-4)]
"""With tolerances, and how far motions may be apart."""
ON_A_ROD = """
coordinates: {{x: {{initial: {x}}}, y: {{initial: {y}}}}}
masses: {{b: 1}}
embedding: {{b: [x, y]}}
potential: 9.81*b.y + {k}*max(0, x - {a})**2/2
dissipation: {c}*(x_dot**2 + y_dot**2)/2
constraints: {{rod: x**2 + y**2 - 1}}
events:
  down: x
  wall: {{when: x + {b}, direction: falling, action: {{set: {{x_dot: -{e}*x_dot, y_dot: -{e}*y_dot}}}}}}
"""


def random_system(chance: random.Random) -> str:
    """Its text: oscillators with walls, kinks, friction, switches, impacts and other events, or a pendulum in
    Cartesian coordinates."""

    def number(low: float, high: float) -> float:
        return round(chance.uniform(low, high), 3)

    if chance.random() < 0.25:
        angle, hard, damped = (
            chance.uniform(0.5, 1.2),
            chance.choice([0, 200, 1e4]),
            chance.choice([0, 0.1, 3]),
        )
        places = {"x": math.sin(angle), "y": -math.cos(angle), "a": number(0.1, 0.4), "b": number(0.1, 0.4)}
        return ON_A_ROD.format(**places, k=hard, c=damped, e=chance.choice([1, 0.9]))
    names = "xyz"[: chance.randint(1, 3)]
    some = lambda: chance.choice(names)  # noqa: E731
    terms = [f"{q}_dot**2/{chance.randint(1, 3)} - {number(0.5, 20)}*{q}**2/2" for q in names]
    terms += [f"0.3*cos({names[0]} - {names[-1]})", f"0.1*sqrt(1 + {some()}**2)", f"0.2*abs({some()} - 0.1)"]
    terms += [f"-10**{chance.randint(1, 4)}*max(0, {some()} - {number(0.2, 0.8)})**2/2"]
    forces = [f"-0.05*{q}_dot + where(t > {number(1, 4)}, 0.5, -0.2)" for q in names]
    rubbed = chance.random() < 0.4
    if rubbed:  # whether velocities that are held at 0 cross 0 is rounding: no event asks for that
        forces[0] += f" - {number(0.02, 0.4)}*sign({names[0]}_dot)"
    watched = [f"{some()} - {number(-0.4, 0.4)}", f"{names[0]}*{names[-1]} - 0.01", f"sin(3*t) - {some()}"]
    watched += [] if rubbed else [f"{some()}_dot", f"{names[0]}_dot*{names[-1]} - 0.1"]
    ways = "rising", "falling", "either"
    events = [f"{{when: '{one}', direction: {chance.choice(ways)}}}" for one in chance.sample(watched, 2)]
    if chance.random() < 0.4:
        q = some()
        action = f"action: {{set: {{{q}_dot: -0.9*{q}_dot}}}}"
        events.append(f"{{when: {q} + {number(0.1, 0.4)}, direction: falling, {action}}}")
    lines = ["coordinates:"]
    lines += [f"  {q}: {{initial: {number(-0.2, 0.6)}, velocity: {number(-1, 1)}}}" for q in names]
    lines += ["lagrangian: " + " + ".join(terms), "generalized_forces:"]
    lines += [f"  {q}: {force}" for q, force in zip(names, forces)]
    lines += ["events:", *(f"  e{k}: {event}" for k, event in enumerate(events))]
    return "\n".join([*lines, ""])


def apart(found: Motion, known: Motion) -> float:
    """How far two motions are apart, at most samples: at those beside an impact velocities may be others."""
    names = [name for name in known.data if name.startswith(("q/", "v/"))]
    return max(float(np.sort(np.abs(found[name] - known[name]))[-4]) for name in names)


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("number", range(120))
def test_methods_agree(number: int) -> None:
    text = random_system(random.Random(number))
    known = follow(text, 4.0, 41)
    for method, tolerance, far in METHODS:
        found = follow(text, 4.0, 41, method=method, tolerance=tolerance)
        assert found.outcome.ending is known.outcome.ending, (method, text)
        assert apart(found, known) < far, (method, text)
        for name in known.data:
            if name.startswith("events/") and name.endswith("/t") and len(known[name]) < 20:
                assert found.data.get(name, np.empty(0)) == pytest.approx(known[name], abs=far), (
                    method,
                    text,
                )


@pytest.mark.exhaustive(keep=0.4)
@pytest.mark.parametrize("number", range(40))
def test_samples_and_checkpoints_change_nothing(number: int) -> None:
    chance = random.Random(number)
    text, (method, tolerance, _) = random_system(chance), chance.choice(METHODS)
    ready, kept, ends = prepared(text, method, tolerance), list[Snapshot](), list[End]()
    every, goes = chance.randint(2, 40), TaylorMethod.follow

    def kept_on_the_way(self: TaylorMethod, start: Start, observer: Observer, threads: int) -> End:
        def followed(sink: CheckpointSink) -> End:
            return goes(self, start, replace(observer, checkpoints=sink, events=NO_EVENTS))

        sink = CheckpointSink(None, lambda steps: True, kept.append, every=every)
        ends.append(followed(sink))
        again = CheckpointSink(chance.choice(kept), lambda steps: False, kept.append) if kept else sink
        ends.append(followed(again))
        return goes(self, start, observer, threads)

    with mock.patch.object(TaylorMethod, "follow", kept_on_the_way):
        few = run(ready, values_of(text), 0.0, 4.0, 97)
    many = run(ready, values_of(text), 0.0, 4.0, 1777)
    assert few.outcome.final == many.outcome.final and few.outcome.steps == many.outcome.steps
    whole, again = ends
    assert np.array_equal(whole.state, again.state) and whole.steps == again.steps
    assert whole.evaluations == again.evaluations
