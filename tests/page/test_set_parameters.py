"""Parameters that actions set: a page draws every time with those of that time."""

import pytest

import lagrange_cli as lagrange
from lagrange_cli.run.request import Request
from lagrange_cli.run.view.motion import read_shown
from lagrange_cli.run.view.page import view
from tests.support.v8 import Engine

CUT = """
parameters: {m: 1, l: 1, g: 9.81}
coordinates: {theta: {initial: 0.5}}
masses: {bob: m}
positions: {bob: [l*sin(theta), -l*cos(theta)]}
potential: m*g*bob.y
events:
  cut: {when: t - 1, action: {set: {l: 0.5*l}}}
  up: {when: theta_dot, action: {set: {l: 1.1*l}}}
solve: {stop: 3, samples: 31}
"""


@pytest.fixture(scope="module")
def engine():
    return Engine(view(read_shown(CUT.encode(), "cut.yaml", Request())).text)


@pytest.fixture(scope="module")
def expected():
    motion = lagrange.solve(CUT, outputs="q,v,positions")
    return motion.t.tolist(), motion.positions["bob"].tolist()


def places(engine, times, motion="follow(data, opened.engine).motion"):
    script = f"(() => {{ const m = {motion}; return {times}.map((t) => Array.from(m.points(t))); }})()"
    point = engine.data["drawing"]["dots"][0]["point"]
    return [row[2 * point : 2 * point + 2] for row in engine.run(script)]


@pytest.mark.parametrize("backward", [False, True])
def test_a_particle_is_where_it_was_before_an_action_and_after_it(engine, expected, backward):
    times, there = expected
    if backward:  # the reader seeks an earlier time
        times, there = times[::-1], there[::-1]
    for found, place in zip(places(engine, times), there, strict=True):
        assert found == pytest.approx(place, abs=1e-5)  # between samples


def test_what_is_drawn_meanwhile_does_not_change_what_is_computed(engine):
    """The first time is drawn again and again while the motion goes on."""
    traces = """(() => {
      const start = new Start(data, opened.engine);
      const m = new Motion(opened.engine, { ...start }, data.time.start, start.stop, data.time.count);
      while (!m.ended) { m.compute(0); if (SEEKS) { m.points(0); m.points(m.last); } }
      return Array.from({ length: opened.engine.data.points }, (_, k) => Array.from(m.trace(k)));
    })()"""
    still, seeking = (engine.run(traces.replace("SEEKS", one)) for one in ("false", "true"))
    assert still == seeking
