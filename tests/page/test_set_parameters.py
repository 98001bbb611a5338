"""Parameters that actions set: a page draws every time with those of that time."""

import struct

import numpy as np
import pytest

import lagrange_cli as lagrange
from lagrange_cli.drawing.evaluate import points
from lagrange_cli.run.reel import FilmRequest, reel_of
from lagrange_cli.run.replay import view_output
from lagrange_cli.run.request import Request
from lagrange_cli.run.view.motion import read_shown
from lagrange_cli.run.view.page import view
from lagrange_cli.store.result import Result
from tests.support.v8 import Engine, unpacked

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
FAMILY = """
sizes: {N: 2}
parameters: {m: 1, g: 9.81, l: [1, 0.7]}
coordinates: {"theta[i in range(N)]": {initial: 0.5 + 0.3*i}}
masses: {"bob[i in range(N)]": m}
positions: {"bob[i in range(N)]": ["l[i]*sin(theta[i])", "-l[i]*cos(theta[i])"]}
potential: sum(m*g*bob[i].y for i in range(N))
events:
  up[i in range(N)]: {when: "theta_dot[i]", action: {set: {"l[i]": "l[i]*(1 + theta[i]**2)"}}}
solve: {stop: 3, samples: 31}
"""
MANY = """
sizes: {N: 64}
parameters: {m: 1, l: 1, g: 9.81}
coordinates: {"theta[i in range(N)]": {initial: 0.5 + 0.01*i}}
masses: {"bob[i in range(N)]": m}
positions: {"bob[i in range(N)]": ["l*sin(theta[i]) + 3*i", "-l*cos(theta[i])"]}
potential: sum(m*g*bob[i].y for i in range(N))
events: {cut: {when: t - 1, action: {set: {l: 0.5*l}}}}
solve: {stop: 3, samples: 31}
"""
BOUND = """
parameters: {m: 1, l: 1, g: 9.81}
coordinates: {x: {initial: 0.6}, y: {initial: -0.8}}
masses: {bob: m}
positions: {bob: [x, y + l - 1]}
potential: m*g*bob.y
constraints: {rod: x**2 + y**2 - l**2}
events: {cut: {when: t - 1, action: {set: {l: 0.8*l, m: m + x_dot**2}}}}
solve: {stop: 3, samples: 31}
"""


@pytest.fixture(scope="module")
def engine():
    return Engine(view(read_shown(CUT.encode(), "cut.yaml", Request())).text)


@pytest.fixture(scope="module")
def expected():
    motion = lagrange.solve(CUT, outputs="q,v,positions")
    return motion.t.tolist(), motion.positions["bob"].tolist()


MOTION = "follow(data, opened.engine).motion"


def places(engine, motion, times):
    script = f"(() => {{ const m = {motion}; return {times}.map((t) => Array.from(m.points(t))); }})()"
    point = engine.data["drawing"]["dots"][0]["point"]
    return [row[2 * point : 2 * point + 2] for row in engine.run(script)]


@pytest.mark.exhaustive(keep=0.3)
@pytest.mark.parametrize("backward", [False, True])
def test_a_particle_is_where_it_was_before_an_action_and_after_it(engine, expected, backward):
    times, there = expected
    if backward:  # the reader seeks an earlier time
        times, there = times[::-1], there[::-1]
    for found, place in zip(places(engine, MOTION, times), there, strict=True):
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


def replayed(page):
    """The engine of a page that replays, and its motion as a script."""
    engine = Engine(page.text)
    member = engine.data["members"][0]
    rows = unpacked(member["rows"])
    table = list(struct.unpack(f"<{len(rows) // 8}d", rows))
    values = "data.parameters.map((one) => one.value)"
    script = f"new Recorded(opened.engine, data.members[0], Float64Array.from({table}), {values})"
    assert member["settings"]["times"]
    return engine, script


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("text", [CUT, FAMILY, MANY])
def test_a_page_of_an_output_draws_with_what_actions_have_set(tmp_path, text):
    motion = lagrange.solve(text, outputs="q,v,positions")
    motion.save(tmp_path / "run.h5")
    expected = np.asarray(motion.positions["bob"]).reshape(31, -1)[:, :2]
    found = places(*replayed(view_output(tmp_path / "run.h5")[1]), motion.t.tolist())
    assert np.array(found) == pytest.approx(expected, abs=1e-12)


@pytest.mark.exhaustive(keep=0.35)
def test_so_does_a_page_that_cannot_compute():
    page = view(read_shown(BOUND.encode(), "bound.yaml", Request()))
    motion = lagrange.solve(BOUND, outputs="q,v,positions")
    assert not page.live
    found = places(*replayed(page), motion.t.tolist())
    assert np.array(found) == pytest.approx(motion.positions["bob"], abs=1e-9)


@pytest.mark.exhaustive(keep=0.3)
@pytest.mark.parametrize("text", [CUT, MANY])
def test_a_film_draws_with_what_actions_have_set(tmp_path, text):
    motion = lagrange.solve(text, outputs="q,v,positions")
    motion.save(tmp_path / "run.h5")
    with Result(str(tmp_path / "run.h5")) as result:
        reel = reel_of(result, FilmRequest(10.0))
    found = points(reel.drawing, motion.t, motion.q["theta"].reshape(31, -1), reel.parameters)
    expected = motion.positions["bob"].reshape(31, -1)[:, :2]
    assert found[reel.drawing.dots[0].point].T.reshape(31, 2) == pytest.approx(expected, abs=1e-12)
    assert reel.picture(reel.scene(), 3).shape == (600, 800, 3)
