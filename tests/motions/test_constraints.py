"""Motions with constraints, against the same motions in independent coordinates and closed forms."""

from __future__ import annotations

import json
import math
import random
from fractions import Fraction

import h5py
import numpy as np
import pytest

from lagrange_cli import solve
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.method import End
from lagrange_cli.integrate.methods import passing, stepper
from lagrange_cli.integrate.methods.passing import lengths
from lagrange_cli.integrate.workspace import Workspace
from lagrange_cli.run.singular import singular_constraints
from tests.support.command import lagrange
from tests.support.motion import follow, spec_of

PENDULUM = """
parameters: {m: 1.0, l: 1.3, g: 9.81}
coordinates:
  x: {initial: l}
  y: {initial: 0}
masses: {bob: m}
positions: {bob: [x, y]}
potential: m*g*y
constraints: {rod: x**2 + y**2 - l**2}
"""
IN_THE_ANGLE = """
parameters: {m: 1.0, l: 1.3, g: 9.81}
coordinates: {theta: {initial: pi/2}}
masses: {bob: m}
positions: {bob: [l*sin(theta), -l*cos(theta)]}
potential: m*g*bob.y
observables: {x: bob.x, y: bob.y, tension: m*l*theta_dot**2 + m*g*cos(theta)}
"""


@pytest.mark.exhaustive(keep=0.4)
@pytest.mark.parametrize("stop", [10.0, -10.0])
def test_a_pendulum_in_cartesian_coordinates(stop):
    outputs = ("q", "v", "h", "multipliers", "constraints", "ledger")
    motion = follow(PENDULUM, stop, 101, outputs=outputs)
    angle = follow(IN_THE_ANGLE, stop, 101, outputs=("observables",))
    for name in "xy":
        assert np.abs(motion[f"q/{name}"] - angle[f"observables/{name}"]).max() < 1e-13
    tension = -2 * 1.3 * motion["multipliers/rod"]
    assert np.abs(tension - angle["observables/tension"]).max() < 3e-13
    assert np.abs(motion["diagnostics/constraints/rod"]).max() < 4e-15
    for name in ("h", "p/x", "p/y"):
        assert np.abs(motion[f"diagnostics/ledger/{name}"]).max() < 1e-13


SWUNG = """
parameters: {m: 1.0, l: 1.3, g: 9.81, A: 0.4, w: 1.7}
coordinates:
  x: {initial: A + l*sin(1)}
  y: {initial: -l*cos(1)}
masses: {bob: m}
positions: {bob: [x, y]}
potential: m*g*y
constraints: {rod: (x - A*cos(w*t))**2 + y**2 - l**2}
"""
SWUNG_IN_THE_ANGLE = """
parameters: {m: 1.0, l: 1.3, g: 9.81, A: 0.4, w: 1.7}
coordinates: {theta: {initial: 1}}
masses: {bob: m}
positions: {bob: [A*cos(w*t) + l*sin(theta), -l*cos(theta)]}
potential: m*g*bob.y
observables: {x: bob.x, y: bob.y}
"""


@pytest.mark.exhaustive(keep=0.3)
@pytest.mark.parametrize("stop", [10.0, -10.0])
def test_a_pendulum_with_a_moving_pivot(stop):
    """Backward, too, the state is moved to where the rod is then."""
    motion = follow(SWUNG, stop, 101, outputs=("q", "constraints", "ledger"))
    angle = follow(SWUNG_IN_THE_ANGLE, stop, 101, outputs=("observables",))
    for name in "xy":
        assert np.abs(motion[f"q/{name}"] - angle[f"observables/{name}"]).max() < 1e-12
    assert np.abs(motion["diagnostics/constraints/rod"]).max() < 4e-15
    assert np.abs(motion["diagnostics/ledger/h"]).max() < 1e-12


@pytest.mark.exhaustive(keep=0.8)
def test_rounding_does_not_add_up():
    """Moving back to the constraint is canonical: h takes a random walk, without a drift."""
    motion = follow(PENDULUM, 5000.0, 501, outputs=("q", "h", "constraints"))
    assert np.abs(motion["diagnostics/constraints/rod"]).max() < 4e-15
    assert motion.outcome.steps > 30_000
    assert np.abs(motion["diagnostics/h"]).max() < 12.8 * 2e-14


BELOW = "{x: {initial: 0.6}, y: {initial: -0.8}}"
IN_TWO = f"parameters: {{m: 1.0, l: 1.0, g: 9.81, mu: 2.0}}\ncoordinates: {BELOW}\n"
PARTICLE = "masses: {bob: m}\npositions: {bob: [x, y]}\npotential: m*g*y\n"
ROD = "constraints: {rod: x**2 + y**2 - l**2}\n"
IN_ONE = """
parameters: {m: 1.0, l: 1.0, g: 9.81, mu: 2.0}
coordinates: {theta: {initial: "atan2(0.6, 0.8)"}}
masses: {bob: m}
positions: {bob: [l*sin(theta), -l*cos(theta)]}
potential: m*g*bob.y
observables: {x: bob.x, y: bob.y}
"""
TWICE = {
    "a Lagrangian": (IN_TWO + "lagrangian: m*(x_dot**2 + y_dot**2)/2 - m*g*y\n" + ROD, IN_ONE),
    "a narrow force": (
        IN_TWO + PARTICLE.replace("m*g*y", "m*g*y + 3*exp(-400*(x - 0.1)**2)") + ROD,
        IN_ONE.replace("m*g*bob.y", "m*g*bob.y + 3*exp(-400*(bob.x - 0.1)**2)"),
    ),
    "dry friction": (
        IN_TWO + PARTICLE + "generalized_forces: {x: -mu*sign(x_dot)}\n" + ROD,
        IN_ONE + "forces: {bob: [-mu*sign(bob.vx), 0]}\n",
    ),
    "a coordinate without mass": (
        IN_TWO.replace("}}\n", '}, a: {initial: "atan2(0.6, 0.8)"}}\n')
        + PARTICLE
        + "constraints: {across: x - l*sin(a), down: y + l*cos(a)}\n",
        IN_ONE,
    ),
    "a changing length": (
        IN_TWO.replace("x: {initial: 0.6}", "x: {initial: 0.6, velocity: 0.12}").replace(
            "y: {initial: -0.8}", "y: {initial: -0.8, velocity: -0.16}"
        )
        + PARTICLE
        + "constraints: {rod: sqrt(x**2 + y**2) - l - sin(t)/5}\n",
        IN_ONE.replace(
            "l*sin(theta), -l*cos(theta)", "(l + sin(t)/5)*sin(theta), -(l + sin(t)/5)*cos(theta)"
        ),
    ),
    "impacts": (
        IN_TWO + PARTICLE + ROD + "events: {wall: {when: x + 0.3, direction: falling, "
        "action: {set: {x_dot: -0.5*x_dot}}}}\n",
        IN_ONE + "events: {wall: {when: bob.x + 0.3, direction: falling, "
        "action: {set: {theta_dot: -0.5*theta_dot}}}}\n",
    ),
}


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("name", TWICE)
def test_a_constrained_motion_is_that_in_an_independent_coordinate(name):
    constrained, independent = TWICE[name]
    motion = follow(constrained, 3.0, 31, outputs=("q", "constraints", "ledger"))
    other = follow(independent, 3.0, 31, outputs=("observables",))
    for axis in "xy":
        assert np.abs(motion[f"q/{axis}"] - other[f"observables/{axis}"]).max() < 1e-12
    checked = [path for path in motion.data if path.startswith("diagnostics/")]
    assert len(checked) >= 4
    for path in checked:
        assert np.abs(motion[path]).max() < 1e-13


def test_a_knife_edge_slides_down_a_plane_sideways():
    """x = g sin(alpha) sin(wt)^2/(2 w^2), y = g sin(alpha) (wt - sin(wt) cos(wt))/(2 w^2): Yu. I. Neimark and
    N. A. Fufaev, Dynamics of Nonholonomic Systems, 1972, ch. II."""
    text = """
parameters: {m: 1.0, J: 0.5, g: 9.81, alpha: pi/6, w: 2.0}
coordinates: {x: {initial: 0}, y: {initial: 0}, theta: {initial: 0, velocity: w}}
lagrangian: m*(x_dot**2 + y_dot**2)/2 + J*theta_dot**2/2 + m*g*sin(alpha)*x
nonholonomic: {edge: x_dot*sin(theta) - y_dot*cos(theta)}
observables:
  across: g*sin(alpha)*sin(w*t)**2/(2*w**2)
  along: g*sin(alpha)*(w*t - sin(w*t)*cos(w*t))/(2*w**2)
"""
    motion = follow(text, 20.0, 201, outputs=("q", "observables", "constraints", "h"))
    assert np.abs(motion["q/x"] - motion["observables/across"]).max() < 1e-13
    assert np.abs(motion["q/y"] - motion["observables/along"]).max() < 1e-12
    assert np.abs(motion["diagnostics/constraints/edge"]).max() < 1e-14
    h = motion["diagnostics/h"]
    assert np.abs(h - h[0]).max() < 1e-13


LINKAGE = """
parameters: {m: 1.0, g: 9.81}
coordinates:
  x0: {initial: 0, velocity: 1}
  y0: {initial: 1}
  x1: {initial: 1, velocity: 1}
  y1: {initial: 1}
masses: {a: m, b: m}
positions: {a: [x0, y0], b: [x1, y1]}
potential: m*g*(y0 + y1)
constraints:
  left: x0**2 + y0**2 - 1
  right: (x1 - 1)**2 + y1**2 - 1
  bar: (x1 - x0)**2 + (y1 - y0)**2 - 1
"""
AS_AN_ANGLE = """
parameters: {m: 1.0, g: 9.81}
coordinates: {theta: {initial: 0, velocity: 1}}
masses: {a: m, b: m}
positions: {a: [sin(theta), cos(theta)], b: [1 + sin(theta), cos(theta)]}
potential: m*g*(a.y + b.y)
observables: {x0: a.x, y1: b.y}
"""


@pytest.mark.exhaustive(keep=0.6)
def test_a_parallelogram_passes_through_the_horizontal():
    """There its constraints depend on each other, and it could go on as an antiparallelogram."""
    motion = follow(LINKAGE, 6.0, 601, outputs=("q", "h", "constraints"))
    angle = follow(AS_AN_ANGLE, 6.0, 601, outputs=("q", "observables"))
    turns = np.diff(np.signbit(np.cos(angle["q/theta"]))).sum()
    assert 4 <= len(motion.outcome.singular) <= turns == 6  # a step may happen to lead beyond
    for name in ("x0", "y1"):
        assert np.abs(motion[f"q/{name}"] - angle[f"observables/{name}"]).max() < 1e-11
    assert np.abs(motion["diagnostics/constraints/bar"]).max() < 1e-12
    assert motion.outcome.h_drift < 1e-11


CRANKS = """
parameters: {l: LENGTH, g: 9.81}
coordinates:
  a: {initial: START}
  b: {initial: START}
  x: {initial: 2 + l*cos(START)}
  y: {initial: l*sin(START)}
masses: {p: 1, q: 1.5}
embedding: {p: [l*cos(a), l*sin(a)], q: [x, y]}
potential: g*(p.y + 1.5*q.y)
constraints:
  y: l*sin(b) - y
  bar: dot(q - p, q - p) - 4
  middle: (x + l*cos(a))/2 - 1 - l*cos((a + b)/2)
"""
CRANK = """
parameters: {l: LENGTH, g: 9.81}
coordinates: {a: {initial: START}}
masses: {p: 2.5}
embedding: {p: [l*cos(a), l*sin(a)]}
potential: 2.5*g*p.y
"""


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("seed", range(24))
def test_cranks_pass_where_they_are_level_however_near_steps_have_come(seed):
    """Series without a pole before it lead to within rounding errors of a singular configuration. What leads
    beyond must not end as near behind."""
    source = random.Random(seed)
    given = {"START": repr(source.uniform(0.2, 1.4)), "LENGTH": repr(source.uniform(0.5, 1.8))}
    linkage, crank = CRANKS, CRANK
    for name, value in given.items():
        linkage, crank = linkage.replace(name, value), crank.replace(name, value)
    motion = follow(linkage, 6.0, 61, outputs=("q", "h"))
    angle = follow(crank, 6.0, 61, outputs=("q",))
    assert motion.outcome.ending is Ending.COMPLETE, motion.outcome.message
    assert len(motion.outcome.singular) >= 4
    assert np.abs(motion["q/a"] - angle["q/a"]).max() < 1e-10


SOFT = "+ 30*m*max(0, {0} - 1/2)**2"
"""A spring that acts above y = 1/2."""


@pytest.mark.exhaustive(keep=0.4)
@pytest.mark.parametrize("spring", [False, True])
def test_a_parallelogram_passes_through_the_horizontal_with_events_and_switches(spring):
    """An event a fiftieth of a second before it, and one at an end; a force that is switched on and off."""
    force, own = (SOFT.format(y) if spring else "" for y in ("y0", "a.y"))
    events = "events: {{half: {{when: {0} - 1/10}}, left: {{when: {1} - 1/5, direction: rising}}}}\n"
    linkage = LINKAGE.replace("m*g*(y0 + y1)", f"m*g*(y0 + y1) {force}") + events.format("y0", "x0")
    angle = AS_AN_ANGLE.replace("m*g*(a.y + b.y)", f"m*g*(a.y + b.y) {own}")
    motion = follow(linkage, 4.0, 401, outputs=("q", "h"))
    other = follow(angle + events.format("cos(theta)", "sin(theta)"), 4.0, 401, outputs=("q", "observables"))
    assert len(motion.outcome.singular) >= 2
    assert np.abs(motion["q/x0"] - other["observables/x0"]).max() < 1e-11
    assert motion.outcome.h_drift < 1e-11
    for name in ("half", "left"):
        times = other[f"events/{name}/t"]
        assert len(times) >= 2
        assert np.abs(motion[f"events/{name}/t"] - times).max() < 1e-11


@pytest.mark.exhaustive(keep=0.65)
def test_an_event_where_the_configuration_is_singular_is_not_passed_over():
    """It happens while the polynomial leads beyond: the run ends instead, and what is there is kept."""
    motion = follow(LINKAGE + "events: {level: {when: y0}}\n", 6.0, 601, outputs=("q",))
    assert motion.outcome.ending.status == "failed"
    assert motion.outcome.t == pytest.approx(0.747122756, abs=1e-6)


CUSP = """
parameters: {m: 1.0, g: 9.81}
coordinates: {x: {initial: 1}, y: {initial: 1}}
masses: {a: m}
positions: {a: [x, y]}
potential: m*g*y
constraints: {wire: y**2 - x**3}
"""


def test_a_cusp_is_not_passed():
    motion = follow(CUSP, 10.0, 101, outputs=("q",))
    assert motion.outcome.ending.status == "failed"
    assert 0.6 < motion.outcome.t < 0.61
    assert not motion.outcome.singular


@pytest.mark.parametrize("interrupted", [False, True])
def test_the_way_to_a_singular_configuration_is_taken_again_in_pieces(monkeypatch, interrupted):
    """Of so many steps in all; a signal ends the run there, with what it has."""
    pieces, most = list[int](), 100
    advance, again = Workspace.advance, Workspace.again

    def counted(space, stop, wanted, done, count, last, pause):
        found = advance(space, stop, wanted, done, count, last, pause)
        pieces.append(int(space.info[1]))
        return found

    def watched(space, *given):
        with monkeypatch.context() as within:
            within.setattr(Workspace, "advance", counted)
            return again(space, *given)

    monkeypatch.setattr(Workspace, "again", watched)
    monkeypatch.setattr(stepper, "POLL_SECONDS", 0.0)
    monkeypatch.setattr(stepper, "FIRST", 1)
    monkeypatch.setattr(passing, "MOST_REPLAYED", most)
    monkeypatch.setattr(passing, "UNASKED", 0)
    motion = follow(CUSP, 10.0, 101, outputs=("q",), interrupted=lambda: interrupted and len(pieces) >= 5)
    assert motion.outcome.ending.status == ("interrupted" if interrupted else "failed")
    assert 0.6 < motion.outcome.t < 0.61 and len(motion["t"]) == 7
    assert pieces == [1] * (5 if interrupted else most)


TWICE_BARRED = """
coordinates: {x: {initial: 0.6}, y: {initial: -0.8}, u: {initial: 2.6}, w: {initial: -0.8}}
masses: {p: 1, q: 1.5}
positions: {p: [x, y], q: [u, w]}
potential: 9.81*(y + 1.5*w)
constraints:
  left: x**2 + y**2 - 1
  right: (u - 2)**2 + w**2 - 1
  bar: (u - x)**2 + (w - y)**2 - 4
  middle: (x + u - 2)**2 + (y + w)**2 - 4
"""


@pytest.mark.exhaustive(keep=0.45)
def test_a_redundant_constraint_changes_no_motion_and_multipliers_have_the_least_norm(tmp_path):
    without, line = TWICE_BARRED.rsplit("  middle", 1)[0], "  middle"
    assert line in TWICE_BARRED
    found = {}
    for name, text in (("with", TWICE_BARRED), ("without", without)):
        (tmp_path / f"{name}.yaml").write_text(text)
        run = lagrange(
            "solve", f"{name}.yaml", "--stop", "1.3", "--samples", "27", "--outputs",
            "q,multipliers,constraints", cwd=tmp_path,
        )  # fmt: skip
        assert run.returncode == 0, run.stderr
        assert ("the constraint middle depends on the others" in run.stderr) == (name == "with")
        with h5py.File(tmp_path / f"{name}.h5") as file:
            found[name] = {path: file[path][:] for path in ("q/x", "q/y", "q/u", "q/w")}
            groups = file["multipliers"], file["diagnostics/constraints"]
            found[name] |= {one: groups[0][one][:] for one in groups[0]}
            assert max(np.abs(groups[1][one][:]).max() for one in groups[1] if one != "t") < 2e-15
    assert np.abs(found["with"]["q/x"] - found["without"]["q/x"]).max() < 1e-13
    for i in range(27):
        x, y, u, w = (found["with"][f"q/{name}"][i] for name in "xyuw")
        slopes = 2 * np.array(
            [
                [x, y, 0, 0],
                [0, 0, u - 2, w],
                [x - u, y - w, u - x, w - y],
                [x + u - 2, y + w, x + u - 2, y + w],
            ]
        )
        forces = slopes[:3].T @ [found["without"][name][i] for name in ("left", "right", "bar")]
        least = np.linalg.lstsq(slopes.T, forces, rcond=1e-9)[0]
        ours = [found["with"][name][i] for name in ("left", "right", "bar", "middle")]
        assert np.abs(ours - least).max() < 1e-11


def test_a_motion_that_ends_in_a_singular_configuration_says_so():
    spec = spec_of(TWICE_BARRED.rsplit("  middle", 1)[0])
    flat = np.array([1.0, 1e-7, 3.0, 1e-7, 0.0, -1.0, 0.0, -1.0])
    told = singular_constraints(spec, {}, 0.0, End(Ending.SINGULAR_MASS_MATRIX, 0.5, flat, 9, 9))
    assert told.text == "the constraints become dependent (bar on the others): a singular configuration"
    upright = np.array([0.6, 0.8, 2.6, 0.8, 0.0, 0.0, 0.0, 0.0])
    assert singular_constraints(spec, {}, 0.0, End(Ending.NOT_A_NUMBER, 0.5, upright, 9, 9)) is None
    told = singular_constraints(spec, {}, 0.0, End(Ending.SINGULAR_MASS_MATRIX, 0.5, upright, 9, 9))
    assert told.text == "singular matrix of masses and constraints"
    alone = spec_of(
        "coordinates: {x: {initial: 0}, y: {initial: 0}}\nmasses: {p: 1}\npositions: {p: [x, y]}\n"
        "constraints: {cusp: x**3 - y**2}\n"
    )
    told = singular_constraints(alone, {}, 0.0, End(Ending.SINGULAR_MASS_MATRIX, 0.0, np.zeros(4), 9, 9))
    assert told.text == "the derivatives of the constraint cusp are 0: a singular configuration"


def test_times_that_rounding_hides_lead_nowhere():
    """No polynomial is fitted to a motion on a few units in the last place of the time."""
    assert [*lengths(1.0, 2.0**-20, 2.0**-22)] == [2.0**-20, 2.0**-21]
    assert [*lengths(1.0, 2.0**-30, 0.0)] == [2.0**-30, 2.0**-31]
    assert not [*lengths(1.0, 2.0**-40, 0.0)]


@pytest.mark.exhaustive(keep=0.25)
def test_the_start_of_a_solve_is_made_consistent(tmp_path):
    (tmp_path / "pendulum.yaml").write_text(PENDULUM)
    given = ("--stop", "1", "--set", "x=0.5", "--json", "--force")
    run = lagrange("solve", "pendulum.yaml", *given, "--set", "y=-1.21", cwd=tmp_path)
    assert (run.returncode, "'rod' is not satisfied" in run.stderr) == (3, True)
    run = lagrange("solve", "pendulum.yaml", *given, "--set", "y=-1.21", "--project-initial", cwd=tmp_path)
    moved = json.loads(run.stdout)["initial"]["moved"]
    assert np.hypot(moved["x"]["value"], moved["y"]["value"]) == pytest.approx(1.3, rel=1e-15)
    assert "initial values moved to satisfy the constraints: x 0.5 by" in run.stderr
    for kind in (("--precision", "double-double"), ("--portable",)):
        run = lagrange(
            "solve", "pendulum.yaml", *given, "--set", "y=-1.2", "--set", "x_dot=1", *kind, cwd=tmp_path
        )
        assert json.loads(run.stdout)["initial"]["found"] == {"y_dot": 5 / 12}
        with h5py.File(tmp_path / "pendulum.h5") as file:
            begin = {name: Fraction(float(file[name][0])) for name in ("q/x", "q/y", "v/x", "v/y")}
            if "low" in file:
                begin = {name: x + Fraction(float(file[f"low/{name}"][0])) for name, x in begin.items()}
        rate = begin["q/x"] * begin["v/x"] + begin["q/y"] * begin["v/y"]
        assert abs(rate) < (1e-31 if "double-double" in kind else 2e-16)


@pytest.mark.exhaustive(keep=0.5)
def test_members_without_a_consistent_start_fail_alone(tmp_path):
    (tmp_path / "pendulum.yaml").write_text(PENDULUM)
    run = lagrange(
        "sweep", "pendulum.yaml", "--stop", "1", "--set", "x=0.5", "--over", "y=-1.2,-1.3,1.2",
        "--set", "x_dot=1", "-o", "out.h5", cwd=tmp_path,
    )  # fmt: skip
    assert run.returncode == 4
    assert "1 of 3 members failed; member 1 (y = -1.3): constraint 'rod' is not satisfied" in run.stderr
    with h5py.File(tmp_path / "out.h5") as file:
        assert file["status"][:].tolist() == [b"complete", b"failed", b"complete"]
        assert file["initial/v/y"][[0, 2]] == pytest.approx([5 / 12, -5 / 12])


@pytest.mark.exhaustive(keep=0.7)
def test_an_event_that_makes_the_constraints_impossible_ends_the_motion():
    change = "events: {end: {when: x, action: {set: {c: 1}}}}\n"
    text = IN_TWO.replace("mu: 2.0", "c: -1") + PARTICLE + "constraints: {rod: x**2 + y**2 + c}\n" + change
    motion = follow(text, 5.0, 51, outputs=("q",))
    assert motion.outcome.ending is Ending.OFF_CONSTRAINTS
    assert "event 'end'" in motion.outcome.message
    assert 0.4 < motion.outcome.t < 0.8
    assert np.all(np.isfinite(motion["q/x"]))


@pytest.mark.exhaustive(keep=0.3)
def test_ledgers_stay_right_where_all_forces_cancel():
    """A damped pendulum that has come to rest: what its ledgers integrate is nothing but rounding errors."""
    text = IN_TWO + PARTICLE + "dissipation: 0.3*(x_dot**2 + y_dot**2)/2\n" + ROD
    motion = follow(text, 200.0, 201, outputs=("q", "v", "ledger"))
    assert np.abs(motion["v/x"][-1]) < 1e-9
    assert not motion.outcome.unknown
    for name in ("h", "p/x", "p/y"):
        assert np.abs(motion[f"diagnostics/ledger/{name}"]).max() < 1e-12


SET = IN_TWO + PARTICLE + ROD + "events: {now: {when: t - 0.3, action: {set: {VALUES}}}}\n"


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("values", ["x: 2*l", "x: l/2, y: 0"])
def test_coordinates_that_an_action_sets_do_not_jump_elsewhere(values):
    """No point of the circle has x = 2 l, nor is (l/2, 0) one: the motion ends before the action."""
    motion = follow(SET.replace("VALUES", values), 1.0, 11, outputs=("q",))
    assert motion.outcome.ending is Ending.OFF_CONSTRAINTS
    assert motion.outcome.t == pytest.approx(0.3, abs=1e-15)


@pytest.mark.exhaustive(keep=0.65)
def test_the_other_coordinates_follow_those_that_an_action_sets():
    text = SET.replace("VALUES", "x: l/2").replace("g: 9.81", "g: 0")
    motion = follow(text, 0.6, 11, outputs=("q", "v"))
    end = [motion[path][-1] for path in ("q/x", "q/y", "v/x", "v/y")]
    assert end == pytest.approx([0.5, -math.sqrt(0.75), 0.0, 0.0], abs=1e-15)


def test_velocities_that_an_action_sets_are_changed_by_impulses_of_the_constraint():
    """Only the part of the velocity along the circle is left, at (0.6, -0.8): 5.05 of (5, 1.75)."""
    text = SET.replace("VALUES", "x_dot: 5, y_dot: 7/4").replace("g: 9.81", "g: 0")
    motion = follow(text, 0.6, 11, outputs=("q",))
    angle = math.atan2(-0.8, 0.6) + 0.3 * (0.8 * 5 + 0.6 * 1.75)
    assert motion["q/x"][-1] == pytest.approx(math.cos(angle), abs=1e-14)
    assert motion["q/y"][-1] == pytest.approx(math.sin(angle), abs=1e-14)


def test_what_rolls_is_moved_as_it_rolls() -> None:
    """An action sets x, and the sphere moves the other coordinates: only in the direction that is allowed."""
    text = """
coordinates: {x: {initial: sqrt(0.98)}, y: {initial: 0.1}, z: {initial: 0.1}}
masses: {bead: 1}
positions: {bead: [x, y, z]}
constraints: {sphere: x**2 + y**2 + z**2 - 1}
nonholonomic: {rolls: z_dot - 3*y_dot}
events: {jump: {when: t - 0.5, action: {set: {x: 0.8}}}}
"""
    motion = solve(text, stop=1, samples=2)
    x, y, z = (motion.q[name][-1] for name in "xyz")
    assert x == 0.8 and z - 0.1 == pytest.approx(3.0 * (y - 0.1), rel=1e-14)
    assert y**2 + z**2 == pytest.approx(0.36, rel=1e-14)
