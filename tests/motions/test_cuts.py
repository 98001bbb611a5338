"""Where atan2(y, x) jumps by 2 pi: a motion ends at the cut if anything jumps with it, and else goes on."""

from __future__ import annotations

import math

import numpy as np
import pytest

from lagrange_cli.integrate.ending import Ending
from tests.support.command import lagrange
from tests.support.motion import FULL, follow

PLANE = """
    coordinates: {{x: {{initial: {x}, velocity: 0.1}}, y: {{initial: 0.5, velocity: -1}}}}
    parameters: {{n: 3}}
    masses: {{p: 1}}
    embedding: {{p: [x, y]}}
    potential: {potential}
    """
WOUND = """
    coordinates:
      x: {initial: 1, velocity: 0}
      y: {initial: 0, velocity: 1}
      s: {initial: 0, velocity: 1}
    masses: {a: 1, b: 1}
    embedding: {a: [x, y], b: [s]}
    constraints: {circle: x**2 + y**2 - 1, angle: "s - atan2(y, x)"}
    """


@pytest.mark.exhaustive(keep=0.65)
@pytest.mark.parametrize("potential", ["0.1*atan2(y, x)", "0.1*sin(atan2(y, x)/2)", "exp(atan2(y, x)/9)"])
def test_a_motion_ends_where_its_energy_jumps(potential):
    motion = follow(PLANE.format(x=-1, potential=potential), 2.0, 201)
    assert motion.outcome.ending is Ending.CUT
    assert abs(motion.outcome.final.q["y"]) <= 1e-16 and motion.outcome.final.q["x"] < 0
    assert np.all(motion["q/y"] >= 0)
    assert motion.outcome.h_drift <= 1e-14


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize(
    "potential", ["0.1*sin(atan2(y, x))", "0.1*cos(n*atan2(y, x))", "atan2(y, x + 9)", "0.1*abs(atan2(y, x))"]
)
def test_it_goes_on_where_nothing_jumps(potential):
    motion = follow(PLANE.format(x=-1, potential=potential), 2.0)
    assert motion.outcome.ending is Ending.COMPLETE
    assert np.any(motion["q/y"] < 0)
    assert motion.outcome.h_drift <= 1e-14


def test_a_motion_that_begins_at_the_cut_goes_up_but_not_down():
    endings = {}
    for y_dot in (1, -1):
        motion = follow(PLANE.format(x=-1, potential="0.1*atan2(y, x)"), 2.0, sets={"y": 0, "y_dot": y_dot})
        endings[y_dot] = motion.outcome.ending
        assert motion.outcome.h_drift <= 1e-14
    assert endings == {1: Ending.COMPLETE, -1: Ending.CUT}


def test_whether_it_jumps_depends_on_parameters():
    text = PLANE.format(x=-1, potential="0.1*sin(n*atan2(y, x))")
    endings = {n: follow(text, 2.0, sets={"n": n}).outcome.ending for n in (0, 1.5, 2, 2.75)}
    assert endings == {0: Ending.COMPLETE, 1.5: Ending.CUT, 2: Ending.COMPLETE, 2.75: Ending.CUT}


@pytest.mark.exhaustive(keep=0.8)
def test_a_constraint_that_jumps_ends_the_motion_once_around():
    motion = follow(WOUND, 6.0)
    assert motion.outcome.ending is Ending.CUT
    assert motion.outcome.final.t == pytest.approx(math.pi, abs=1e-14)
    assert np.max(np.abs(motion["q/s"] - motion.t)) <= 1e-14


@pytest.mark.exhaustive(keep=0.8)
def test_the_state_there_is_that_before_the_jump():
    """A bead falls along a helix: behind the cut it would be moved to another turn."""
    text = """
    name: a helix
    coordinates: {x: {initial: 1}, y: {initial: 0}, z: {initial: 0}}
    masses: {bead: 1}
    embedding: {bead: [x, y, z]}
    potential: 9.81*z
    constraints: {cylinder: x**2 + y**2 - 1, helix: atan2(y, x) - 5*z}
    """
    final = follow(text, 6.0).outcome.final
    assert final.t == pytest.approx(math.sqrt(2 * math.pi * 1.04 / (9.81 * 0.2)), rel=1e-14)
    assert [*final.q.values()] == pytest.approx([-1, 0, -math.pi / 5], abs=1e-14)


def test_an_energy_jumps_where_another_side_of_a_kink_begins():
    """x*angle is below 0 before the cut, where nothing acts, and far above 0 behind it."""
    motion = follow(PLANE.format(x=-1, potential="max(0, x*atan2(y, x) - 0.3)"), 2.0)
    final = motion.outcome.final
    assert motion.outcome.ending is Ending.CUT and motion.outcome.h_drift <= 1e-14
    assert (final.t, final.q["x"], final.q["y"]) == pytest.approx((0.5, -0.95, 0), abs=1e-13)


def test_a_kink_by_an_angle_changes_nothing_where_the_motion_does_not_reach_it():
    """Not even where x = 0, where the angle would have no series if y were 0."""
    plain, kinked = (
        follow(PLANE.format(x=-1, potential=one), 2.0) for one in ("2*atan2(y, x)", "max(-9, 2*atan2(y, x))")
    )
    assert plain["q/x"][0] < 0 < plain["q/x"][-1] and kinked.t[-1] == 2.0
    assert np.max(np.abs(plain["q/x"] - kinked["q/x"])) < 1e-12


@pytest.mark.parametrize(("method", "far"), [("taylor", 1e-12), ("ias15", 1e-9), ("DOP853", 1e-6)])
def test_kinks_within_kinks_by_an_angle_are_found_behind_the_cut(method, far):
    """The same energy by the angle from the other side, which has its cut elsewhere."""
    angles = "abs(atan2(y, x))", "pi - abs(atan2(-y, -x))"
    start = "coordinates: {x: {initial: -0.6, velocity: 0.2}, y: {initial: -0.24, velocity: 1.4}}"
    energy = "lagrangian: (x_dot**2 + y_dot**2)/2 - (x**2 + y**2)/3 - abs(%s - 2)"
    tolerance = FULL if method == "taylor" else 1e-10
    found, known = (
        follow(f"{start}\n{energy % one}\n", 1.0, method=method, tolerance=tolerance) for one in angles
    )
    sizes = abs(np.arctan2(found["q/y"], found["q/x"]))
    assert found["q/y"][0] < 0 < found["q/y"][-1] and sizes[-1] < 2 < 3 < max(sizes)
    for name in ("q/x", "q/y"):
        assert np.max(np.abs(found[name] - known[name])) < far


def test_a_method_that_steps_over_it_says_so():
    motion = follow(PLANE.format(x=-1, potential="0.1*atan2(y, x)"), 2.0, method="LSODA", tolerance=1e-9)
    assert "cuts" in motion.outcome.undetected
    motion = follow(PLANE.format(x=-1, potential="0.1*sin(atan2(y, x))"), 2.0, method="LSODA", tolerance=1e-9)
    assert "cuts" not in motion.outcome.undetected


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("method", ["ias15", "DOP853", "Radau"])
def test_steps_on_rates_end_there_too(method):
    text = PLANE.format(x=-1, potential="0.1*atan2(y, x)")
    known, found = follow(text, 2.0), follow(text, 2.0, method=method, tolerance=1e-9)
    assert found.outcome.ending is known.outcome.ending is Ending.CUT and not found.outcome.undetected
    assert found.outcome.final.t == pytest.approx(known.outcome.final.t, abs=1e-9)


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("options", [["solve", "--precision", "double-double"], ["sweep", "--over", "n=1,2"]])
def test_it_is_said_what_jumps(tmp_path, options):
    (tmp_path / "plane.yaml").write_text(PLANE.format(x=-1, potential="0.1*sin(n*atan2(y, x)/2)"))
    ended = lagrange(options[0], "plane.yaml", *options[1:], "--stop", "2", cwd=tmp_path)
    assert ended.returncode == 4 and "jumps with the angle atan2(y, x)" in ended.stderr


RIDGE = """
    parameters: {{s: 0.3}}
    coordinates: {{w: {{initial: s, velocity: -1}}, u: {{initial: 1, velocity: 0}}}}
    lagrangian: w_dot**2/2 + u_dot**2/2 - u**2/2 - {angle}**2/16
    """


@pytest.mark.parametrize("start", [0.35009248175679656, *np.linspace(0.1, 0.8, 8)])
def test_steps_on_rates_pass_a_force_that_jumps_as_precisely_as_time_is_resolved(start):
    """The same energy by the angle from the other side, |angle|: steps end at its kink, which is a switch.

    At the first start the jump was behind the last node of a short step, and 7e-12 of the velocity were
    lost."""
    found, known = (
        follow(RIDGE.format(angle=one), 1.5, sets={"s": start}, method="ias15")
        for one in ("atan2(w, -3 - u**2/9)", "(pi - abs(atan2(w, 3 + u**2/9)))")
    )
    assert found["q/w"][0] > 0 > found["q/w"][-1]
    for name in ("q/w", "v/w", "q/u", "v/u"):
        assert np.max(np.abs(found[name] - known[name])) < 2e-14
