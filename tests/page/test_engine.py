"""The page's engine, in V8: its numbers against those of ``solve``."""

from __future__ import annotations

import json
import math
from functools import cache
from unittest import mock

import numpy as np
import pytest
from py_mini_racer import MiniRacer

import lagrange_cli as lagrange
from lagrange_cli.drawing.drawing import Drawing
from lagrange_cli.drawing.evaluate import points
from lagrange_cli.page.document import TABLES, asset
from lagrange_cli.page.packed import packed
from lagrange_cli.run import shipped
from lagrange_cli.run.motion import Motion
from lagrange_cli.run.request import Request
from lagrange_cli.run.view import content as shown_content
from lagrange_cli.run.view import page as shown_page
from lagrange_cli.run.view.motion import ViewedMotion, read_shown, watched
from lagrange_cli.run.view.page import Page, view
from tests.families.test_joint_contacts import STOP
from tests.families.test_locked import CHAIN, HEAD
from tests.motions.test_shaking_floor import BALLS
from tests.support.command import SYSTEMS
from tests.support.v8 import Engine, data_of, unpacked

UNTIL = {
    "chain": 1.0,
    "double_pendulum": 5.0,
    "driven_damped_pendulum": 20.0,
    "n_pendulum": 3.0,
    "free_top": 5.0,
    "rattleback": 0.5,
    "bicycle": 0.5,
}
"""Until when motions are compared that grow rounding errors, or take long."""
UNREADABLE = {"bicycle"}
"""Systems whose equations are too large to be shown. It takes half a minute to find that out; here they are
given up at once."""
REPLAYED = {"newtons_cradle"}
"""Those whose motion a page replays."""
LONG = {"bicycle"}
"""Systems whose program would be too long with the proofs of its steps."""


PLAIN = b"{coordinates: {x: {initial: 1}}, lagrangian: x_dot**2/2 - x**2/2, solve: {stop: 5}}"


@cache
def page_of(name: str) -> Page:
    content = (SYSTEMS / f"{name}.yaml").read_bytes()
    times = {"stop": str(UNTIL[name])} if name in UNTIL else {}
    with mock.patch.object(shown_content, "READING", 1000 if name in UNREADABLE else shown_content.READING):
        return view(read_shown(content, f"{name}.yaml", Request(times=times)))


@cache
def engine_of(name: str) -> Engine:
    return Engine(page_of(name).text)


def family(name: str, members: int, stop: float) -> Page:
    """The page of a system with so many members; its equations are not looked at."""
    request = Request(sizes={"N": str(members)}, times={"stop": str(stop)})
    motion = read_shown((SYSTEMS / f"{name}.yaml").read_bytes(), f"{name}.yaml", request)
    with mock.patch.object(shown_content, "READING", 1000):
        return view(motion)


def assert_same(found, name, size=None, **changes):
    expected = lagrange.solve(
        SYSTEMS / f"{name}.yaml", set=changes, size=size, stop=found["t"], outputs="q,v,h"
    )
    for group, row in (("q", found["q"]), ("v", found["v"])):
        values = [x for one in getattr(expected, group).values() for x in one[-1:].ravel().tolist()]
        scale = max(1.0, *map(abs, values))
        assert max(abs(a - b) for a, b in zip(row, values, strict=True)) <= 1e-9 * scale
    return expected


@pytest.mark.exhaustive(keep=0.2, most=16)
@pytest.mark.parametrize("name", shipped.names())
def test_the_page_computes_what_solve_does(name):
    """It is small, needs nothing but memory, and ends where ``solve`` does."""
    page = page_of(name)
    assert page.live == (name not in REPLAYED)
    if not page.live:
        return
    engine = engine_of(name)
    assert len(page.text.encode()) <= 400_000
    assert ("does not prove" in data_of(page.text)["notice"]) == (name in LONG)
    imports = engine.run("WebAssembly.Module.imports(opened.module).map((one) => one.name)")
    assert imports == ["__linear_memory", "__stack_pointer"]
    found = engine.end()
    assert found["reason"] == ""
    assert_same(found, name)


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize(
    ("name", "members", "stop"), [("n_pendulum", 16, 1.0), ("fpu_chain", 400, 50.0), ("chain", 80, 0.1)]
)
def test_a_page_computes_families_as_loops(name, members, stop):
    """Beads, joints and rods: for the values of the file, and for others."""
    engine = Engine(family(name, members, stop).text)
    for changes in ({}, {"g" if "g" in engine.data["engine"]["parameters"] else "alpha": 0.75}):
        found = engine.end(**changes)
        assert found["reason"] == found["note"] == ""
        assert_same(found, name, {"N": members}, **changes)


def drawn_page(members: int) -> tuple[Motion, Drawing, ViewedMotion]:
    """A motion of pendulums, what is drawn of it, and its beginning."""
    content = (
        (SYSTEMS / "n_pendulum.yaml").read_bytes().replace(b"2.0 + 0.1*i", b"g*sum(l for j in range(i))")
    )
    request = Request(sizes={"N": str(members)}, overrides={"l": "0.5"})
    motion = watched(read_shown(content, "chain.yaml", request))
    q = np.array([motion.values.q])
    followed = ViewedMotion(np.zeros(1), q, 0 * q, {}, "", 1)
    drawing = shown_content.drawn(motion, followed)
    assert drawing is not None and drawing.located is not None
    return motion, drawing, followed


@pytest.mark.exhaustive(keep=0.3)
def test_a_page_draws_families_by_loops_and_prints_them_with_their_indices():
    """Where particles are, and initial values for other parameters."""
    motion, drawing, followed = drawn_page(60)
    engine = Engine(shown_page.page(motion, followed).text)
    assert "<munderover>" in unpacked(engine.data["equations"]).decode()
    parameters = {"m": 1.0, "l": 0.25, "g": 2.0}
    listed = [parameters[name] for name in engine.data["engine"]["parameters"]]
    engine.v8.eval(f"opened.engine.prepare({listed})")
    q = np.random.default_rng(0).normal(size=60)
    places = engine.run(f"Array.from(opened.engine.place(0.7, {q.tolist()}))")
    assert np.allclose(places, points(drawing, np.array([0.7]), q[None], parameters).ravel(), atol=1e-13)
    found = engine.run(f"Array.from(opened.engine.derive({listed}))")
    assert np.allclose(found[3:], [*(0.5 * np.arange(60)), *np.zeros(60)], atol=1e-13)


def test_a_page_has_few_bytes_for_each_further_member():
    sizes = []
    for members in (100, 1100):
        motion, drawing, followed = drawn_page(members)
        data = shown_content.described(motion, drawing, followed)
        sizes.append(len("".join(packed(json.dumps(data[name]).encode()) for name in TABLES if name in data)))
    assert sizes[1] - sizes[0] < 60 * 1000


def test_the_program_of_a_family_is_as_long_for_any_number_of_members():
    lines = set()
    for members in (100, 4000):
        request = Request(sizes={"N": str(members)})
        motion = read_shown((SYSTEMS / "n_pendulum.yaml").read_bytes(), "chain.yaml", request)
        motion = watched(motion)
        program, _, notice = shown_page.programmed(motion, shown_page.equations_of(motion))
        lines.add(program.text.count("\n"))
        assert notice == ""
    assert max(lines) < 1.05 * min(lines) < shown_page.LARGEST / 4


@pytest.mark.exhaustive(keep=0.3)
def test_what_would_be_too_large_a_drawing_is_not_begun(monkeypatch):
    monkeypatch.setattr(shown_content, "DRAWN", 15)
    monkeypatch.setattr("lagrange_cli.drawing.draw.draw", None)
    assert shown_page.UNDRAWN in data_of(family("n_pendulum", 16, 0.1).text)["notice"]


def test_a_program_too_large_for_a_page_is_not_in_it(monkeypatch):
    """Its motion is replayed, its equations are not derived for ever, and the page says both."""
    monkeypatch.setattr(shown_page, "LARGEST", 1000)
    monkeypatch.setattr(shown_content, "READING", 1000)
    page = view(read_shown((SYSTEMS / "pendulum.yaml").read_bytes(), "pendulum.yaml", Request()))
    assert not page.live
    assert "instructions is too large for a page (at most 1000)" in page.why
    assert shown_content.UNREADABLE in unpacked(data_of(page.text)["equations"]).decode()
    assert "pendulum.yaml:" not in page.text


@pytest.mark.exhaustive(keep=0.25)
def test_proofs_are_left_out_where_they_are_too_long(monkeypatch):
    """The page says so, its program is shorter, and its numbers are those of ``solve``."""
    motion = read_shown(PLAIN.replace(b"x**2/2", b"exp(x)/2"), "x.yaml", Request())
    proven = Engine(view(motion).text)
    monkeypatch.setattr(shown_page, "PROVEN", 100)
    shorter = Engine(view(motion).text)
    assert proven.data["notice"] == "" and shorter.data["notice"] == shown_page.UNPROVEN
    assert len(shorter.data["engine"]["code"]) < 0.9 * len(proven.data["engine"]["code"])
    expected, found = proven.end(), shorter.end()
    assert found["q"] == pytest.approx(expected["q"], abs=1e-13)
    assert data_of(view(read_shown(PLAIN, "y.yaml", Request())).text)["notice"] == ""


@pytest.mark.exhaustive(keep=0.2)
def test_a_page_is_packed_and_three_js_is_in_pages_in_space_alone():
    """With its license."""
    page, plane = page_of("spherical_pendulum").text, page_of("pendulum").text
    data = data_of(page)
    script, equations, space = (unpacked(data[name]).decode() for name in ("script", "equations", "space"))
    assert "three.js authors" in space and "Permission is hereby granted" in space
    assert "class Space extends Scene" in space and "class App" in script and "</math>" in equations
    assert "class " not in page and "</math>" not in page
    data = data_of(plane)
    assert "space" not in data and "inSpace(data) {" not in unpacked(data["script"]).decode()
    assert len(plane) < 100_000


def test_values_may_be_changed():
    found = engine_of("pendulum").end(l=2.0, theta=1.5, theta_dot=-0.5)
    assert_same(found, "pendulum", l=2.0, theta=1.5, theta_dot=-0.5)


@pytest.mark.exhaustive(keep=0.3)
def test_what_depends_on_parameters_follows_them():
    """omega is 2 sqrt(g/a) in the file, as long as nobody moves it."""
    engine = engine_of("rotating_hoop")
    _, _, parameters = engine.end(a=0.25)["start"]
    assert dict(zip(engine.data["engine"]["parameters"], parameters))["omega"] == pytest.approx(
        2 * (9.81 / 0.25) ** 0.5
    )
    assert_same(engine.end(a=0.25), "rotating_hoop", a=0.25)
    assert_same(engine.end(a=0.25, omega=3.0), "rotating_hoop", a=0.25, omega=3.0)


@pytest.mark.exhaustive(keep=0.35)
def test_a_start_that_depends_on_parameters_follows_them():
    """r and the velocity of theta are expressions in a, e and mu."""
    changes = {"e": 0.3, "a": 1.2}
    assert_same(engine_of("central_force").end(**changes), "central_force", **changes)


def test_a_start_may_be_made_of_constant_definitions():
    """No page was written of such a file."""
    content = (
        b"{parameters: {a: 2}, definitions: {s: 3*a, w: '(s, a/4)'}, "
        b"coordinates: {x: {initial: s, velocity: w.y}, y: {initial: w.x/2}}, "
        b"lagrangian: x_dot**2 + y_dot**2, solve: {stop: 2}}"
    )
    found = Engine(view(read_shown(content, "free.yaml", Request())).text).end(a=4.0)
    assert found["reason"] == "" and found["q"] == pytest.approx([14.0, 6.0], abs=1e-14)


@pytest.mark.exhaustive(keep=0.7)
def test_a_slider_may_take_a_constraint_away():
    """Without the second gear's radius the first one is held, and the other one turns freely."""
    content = (
        b"{parameters: {R: 2, S: 1}, coordinates: {a: {initial: 0}, b: {initial: 0, velocity: 1}}, "
        b"lagrangian: a_dot**2 + b_dot**2, constraints: {mesh: S*a + R*b}, solve: {stop: 1}}"
    )
    found = Engine(view(read_shown(content, "gears.yaml", Request())).text).end(R=0.0)
    assert found["reason"] == "" and found["q"] == pytest.approx([0.0, 1.0], abs=1e-14)


@pytest.mark.exhaustive(keep=0.3)
@pytest.mark.parametrize("rest", ["0, 0", "0.6, -0.8"])
def test_drag_along_a_vector_that_is_0_for_a_while_is_that_of_solve(rest):
    """A ball is dropped; a pendulum on a rod turns."""
    x, y = rest.split(", ")
    rod = "constraints: {rod: (x**2 + y**2 - 1)/2}, " if float(x) else ""
    text = (
        f"{{coordinates: {{x: {{initial: {x}}}, y: {{initial: {y}}}}}, {rod}positions: {{bob: [x, y]}}, "
        "masses: {bob: 1}, potential: 9.81*y, solve: {stop: 4}, "
        'forces: {bob: "-0.2*norm((x_dot, y_dot))*(x_dot, y_dot)"}}'
    )
    found = Engine(view(read_shown(text.encode(), "air.yaml", Request())).text).end()
    expected = lagrange.solve(text, samples=2)
    assert found["reason"] == ""
    assert found["q"] == pytest.approx([expected.q[k][-1] for k in "xy"], rel=1e-13)


@pytest.mark.exhaustive(keep=0.3)
def test_a_ball_bounces_and_comes_to_rest_as_in_solve():
    """Actions of events, infinitely many impacts, and the rest after them."""
    found = engine_of("bouncing_ball").end(e=0.6)
    expected = assert_same(found, "bouncing_ball", e=0.6)
    assert found["q"] == [0.0]
    assert found["events"] == sum(len(one) for path, one in expected.datasets.items() if path.endswith("/t"))


@pytest.mark.exhaustive(keep=0.15)
def test_a_chain_of_many_links_rests_at_its_stops_as_in_solve():
    """Its links are computed in loops, and rest apart from one another."""
    text = (HEAD + CHAIN + STOP).format(count=13, start=0.25, speed=0, e=0.4)
    text += "solve: {stop: 0.8}\n"
    found = Engine(view(read_shown(text.encode(), "chain.yaml", Request())).text).end()
    expected = lagrange.solve(text, samples=2)
    assert found["reason"] == "" and found["events"] == len(expected.datasets["events/hit/t"])
    assert found["q"] == pytest.approx(expected.q["a"][-1], rel=0.0, abs=1e-11)
    assert 0.2 in found["q"]


@pytest.mark.exhaustive(keep=0.25)
def test_many_balls_come_to_rest_as_in_solve():
    """Balls of a family that is computed in loops."""
    text = """
sizes: {N: 120}
coordinates: {"y[i in range(N)]": {initial: "0.01*(1 + i)"}}
masses: {"ball[i in range(N)]": 1}
positions: {"ball[i in range(N)]": "y[i]"}
potential: "sum(9.81*y[i] for i in range(N))"
events: {"hit[i in range(N)]": {when: "y[i]", direction: falling, action: {set: {"y_dot[i]": "-y_dot[i]/3"}}}}
solve: {stop: 0.25}
"""
    found = Engine(view(read_shown(text.encode(), "balls.yaml", Request())).text).end()
    expected = lagrange.solve(text, samples=2)
    assert found["reason"] == ""
    assert found["q"] == pytest.approx(expected.q["y"][-1], rel=0.0, abs=1e-12)
    assert found["q"].count(0.0) > 5


@pytest.mark.exhaustive(keep=0.15)
def test_balls_whose_impacts_are_almost_at_one_time_do_not_fall_through_the_floor():
    """Just after the impact of a ball, rounding decides on which side of the floor it is."""
    text = BALLS.format(count=3, e=0.267, g=6.542, start=1.495) + "solve: {stop: 4}\n"
    found = Engine(view(read_shown(text.encode(), "balls.yaml", Request())).text).end()
    assert min(found["q"]) > 0.2 * math.sin(6 * 4) - 1e-9


def test_pages_replay_friction_that_constraints_bind_together():
    """Blocks that a coupling holds together: a page does not choose what slips then."""
    text = """
sizes: {N: 12}
coordinates: {"x[i in range(N)]": {initial: i}}
masses: {"block[i in range(N)]": 1}
positions: {"block[i in range(N)]": "x[i]"}
potential: 8*(x[0] - t)**2
constraints: {"coupling[i in range(1, N)]": "x[i] - x[i - 1] - 1"}
generalized_forces: {"x[i in range(N)]": "-0.4*sign(x_dot[i])"}
solve: {stop: 2}
"""
    page = view(read_shown(text.encode(), "train.yaml", Request()))
    assert not page.live and page.why.startswith("Friction of many members beside constraints is computed")


def test_a_trail_is_seen_from_the_point_that_is_followed():
    """As in a film: a particle that keeps its distance from it leaves no trail."""
    engine = engine_of("pendulum")
    engine.v8.eval(asset("scene.js"))
    engine.v8.eval(
        """const rows = [[0, 1, 2], [0, 0, 0], [5, 6, 8], [1, 1, 1]], seen = {
          __proto__: Scene.prototype, dimension: 2, points: [2.5, 0, 8.5, 1],
          drawing: { dots: [{ point: 1, group: 0, colour: "red" }], camera: { follow: 0 } },
        };
        const traced = () => seen.trail({ times: [0, 1, 2], trace: (k) => rows[k] }, 2.5, 1).places;"""
    )
    assert engine.run("traced()") == [[7.5, 1], [7.5, 1], [8.5, 1]]
    engine.v8.eval("seen.drawing.camera.follow = null")
    assert engine.run("traced()") == [[5, 1], [6, 1], [8.5, 1]]


def test_graphs_of_whatever_has_ticks_and_an_end():
    """Also where a quantity changes in its last bits only, or is as small as numbers get."""
    engine = engine_of("pendulum")
    engine.v8.eval(asset("format.js") + asset("chart.js"))
    assert engine.run("ticks(0, 1, 4)") == [0, 0.5, 1]
    assert engine.run("ticks(1, 1 + 2e-16, 4)") == []
    assert engine.run("ticks(0, 5e-324, 4)") == []
    assert engine.run("ticks(-1e300, 1e300, 4).length") < 10
    assert engine.run("span([[2, 2 + 1e-15]], 0.06)") == pytest.approx([1.8, 2.2])
    assert engine.run("span([[0, 0]], 0.06)") == [-1, 1]
    assert engine.run("span([[NaN, Infinity]], 0.06)") == [0, 0]
    assert engine.run("pretty('theta12')") == "θ₁₂"
    names = ["constructor", "toString", "__proto__", "valueOf", "hasOwnProperty"]
    assert engine.run(f"{names}.map((name) => pretty(name))") == names
    numbers = "[0, -0.5, 62.831853, 1.25e-6, -3.14159265e-5, 6.02214076e23, 36525, 1234567]"
    assert engine.run(f"{numbers}.map(boxed)") == [
        "0", "-0.5", "62.8319", "1.25e-6", "-3.14159e-5", "6.02214e23", "36525", "1234570",
    ]  # fmt: skip


REACHING = """
var count = 0, scene = { dimension: 2, scale: 100, onPaper: ([x, y]) => [100 * x, 100 * y] };
var points = {
  free: (t, q) => {
    count++;
    return Float64Array.from(q.map((value, i) => i % 2 ? value : Math.sin(value)));
  },
  chain: (t, q) => {
    count++;
    const found = [];
    let [x, y] = [0, 0];
    for (const angle of q) found.push(x += Math.cos(angle), y += Math.sin(angle));
    return Float64Array.from(found);
  },
};
var reached = (kind, n, point, goal) => {
  const from = Array.from({ length: n }, (_, k) => 0.3 * Math.sin(k)), before = from.slice();
  count = 0;
  const paper = goal.map((one) => 100 * one);
  const q = reaching(scene, { place: points[kind] }, point, paper, 0, from), evaluated = count;
  const there = Array.from(points[kind](0, q).slice(2 * point, 2 * point + 2));
  return [there, evaluated, q.map((one, k) => one !== before[k] ? k : -1).filter((k) => k >= 0)];
};
"""


def test_a_drag_moves_what_the_point_depends_on_in_few_evaluations():
    v8 = MiniRacer()
    v8.eval(asset("start.js") + REACHING)
    place, count, moved = json.loads(v8.eval('JSON.stringify(reached("free", 2000, 700, [0.5, 0.7]))'))
    np.testing.assert_allclose(place, [0.5, 0.7], atol=0.004)
    assert moved == [1400, 1401] and count < 60
    place, _, moved = json.loads(v8.eval('JSON.stringify(reached("chain", 9, 5, [3.0, 3.5]))'))
    np.testing.assert_allclose(place, [3.0, 3.5], atol=0.004)
    assert moved == [*range(6)]
