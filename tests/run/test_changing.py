"""``--method auto`` changes the method on the way, where a motion becomes stiff or is so no more."""

from __future__ import annotations

import json
import math
from itertools import pairwise
from pathlib import Path

import h5py
import numpy as np
import pytest

import lagrange_cli
import lagrange_cli.cli.commands.solve as solving
from lagrange_cli.cli.main import main
from lagrange_cli.integrate import changing, stiffness
from lagrange_cli.integrate.methods import stepper
from lagrange_cli.integrate.stiffness import LONG, Stiffness, Trial
from lagrange_cli.run.interrupts import Interrupts

DRIVEN = """
name: driven
parameters: {k: 1e5}
coordinates: {x: {initial: 0, velocity: 1}}
lagrangian: x_dot**2/2
generalized_forces: {x: -k*(t/10)**4*(x_dot - cos(t)) - sin(t)}
solve: {stop: 20, samples: 21, tolerance: 1e-6}
"""
"""x = sin(t), whatever k is: a damper that follows it becomes harder and harder."""
COUPLED = """
name: coupled
coordinates: {x: {initial: 1}, s: {initial: 0.5}, y: {initial: 1}}
lagrangian: (x_dot**2 + s_dot**2 + y_dot**2 - y**2)/2 - 50*(t/20)**4*(s - y)**2
generalized_forces: {s: -1e4*(t/20)**4*(s_dot - y_dot), y: 1e4*(t/20)**4*(s_dot - y_dot), x: 0}
solve: {stop: 60, samples: 31, tolerance: 1e-7}
"""
"""Two masses between which a spring and a damper become hard; x stays where it is."""
CHAIN = """
name: chain
sizes: {N: 30}
coordinates: {"x[i in range(N)]": {initial: "sin(3*i)/10"}}
masses: {"bead[i in range(N)]": 1}
embedding: {"bead[i in range(N)]": "x[i]"}
potential: 1e2*(x[0]**2 + sum((x[i] - x[i - 1])**2 for i in range(1, N)))/2
dissipation: 1e4*(t/20)**4*(x_dot[0]**2 + sum((x_dot[i] - x_dot[i - 1])**2 for i in range(1, N)))/2
solve: {stop: 40, samples: 11, tolerance: 1e-6}
"""
BETWEEN = """
name: between
coordinates: {x: {initial: 1}, y: {initial: 0.5, velocity: 1}}
lagrangian: (x_dot**2 + y_dot**2 - x**2 - y**2)/2
generalized_forces: {x: "-3e4*(1 - cos(t/500))**2*x_dot/4"}
solve: {stop: 4000, samples: 101, tolerance: 1e-7}
"""
"""Damping that comes and goes; y = cos(t)/2 + sin(t)."""
RING = """
name: ring
coordinates: {x: {initial: 1}, y: {initial: 0, velocity: 3}, z: {initial: 0, velocity: 1}}
constraints: {ring: x**2 + y**2 - 1}
lagrangian: (x_dot**2 + y_dot**2 + z_dot**2)/2 - y
dissipation: 5e3*(t/20)**4*(x_dot**2 + y_dot**2)/2
solve: {stop: 40, samples: 11, tolerance: 1e-6}
"""
"""A bead on a ring; z is cyclic."""

FLOOR = """
name: floor
parameters: {k: 1e6, c: 1e5}
coordinates: {y: {initial: 20}, z: {initial: 1}}
masses: {ball: 1, bob: 1}
embedding: {ball: [0, y], bob: [z, 0]}
potential: 9.81*y + z**2/2 + k*max(0, -y)**2/2
generalized_forces: {y: "where(y < 0, -c*y_dot, 0)"}
solve: {stop: 40, samples: 21, tolerance: 1e-6}
"""
"""A ball that falls on a hard floor with strong damping, where it stays; z = cos(t)."""
STICKING = """
name: sticking
coordinates: {x: {initial: 1}, y: {initial: 0}}
masses: {a: 1, b: 2}
embedding: {a: [x], b: [y]}
potential: 10*(x - y - sin(t))**2 + y**2
generalized_forces: {x: -2*sign(x_dot), y: -3*sign(y_dot)}
solve: {stop: 40, samples: 41, tolerance: 1e-8}
"""
SWINGING = """
name: swinging
parameters: {k: 1e8, c: 1e4}
coordinates: {x: {initial: 0.8}, y: {initial: -0.6}}
masses: {bob: 1}
embedding: {bob: [x, y]}
potential: 9.81*y + k*(norm(bob) - 1)**2/2
dissipation: c*((x*x_dot + y*y_dot)/norm(bob))**2/2
solve: {stop: 20, samples: 11, tolerance: 1e-6}
"""
ORBIT = """
name: orbit
coordinates: {r: {initial: 1}, phi: {initial: 0, velocity: 1.2}}
lagrangian: (r_dot**2 + r**2*phi_dot**2)/2 + 1/r
dissipation: 1e-3*r_dot**2/2
solve: {stop: 20, samples: 21, tolerance: 1e-8}
"""
"""Its angular momentum is kept in a row of the state."""


@pytest.fixture
def restless(monkeypatch: pytest.MonkeyPatch) -> None:
    """The method is changed each time that the motion is looked at."""
    monkeypatch.setattr(changing, "LOOKED", 0.0)
    monkeypatch.setattr(changing, "OFTEN", 8)
    monkeypatch.setattr(Trial, "stiffness", lambda *_: None)
    monkeypatch.setattr(Trial, "later", lambda _, begin, tolerance, known: Stiffness(tolerance, 1e9))
    monkeypatch.setattr(Trial, "replaced", lambda *_: 0.0)


@pytest.fixture
def cheap(monkeypatch: pytest.MonkeyPatch) -> None:
    """Changes are made as if other code were compiled in no time: short motions show them."""
    monkeypatch.setattr(stiffness, "PRICE", 0.0)
    monkeypatch.setattr(changing, "LOOKED", 0.0)


def methods(motion: lagrange_cli.Motion) -> list[str]:
    """The methods of a motion, in turn."""
    told = motion.attributes
    return [told["method"], *(one["method"] for one in json.loads(told.get("methods", "[]")))]


def distance(one: lagrange_cli.Motion, other: lagrange_cli.Motion) -> float:
    """The largest difference between the coordinates of two motions."""
    return max(float(np.max(np.abs(one.q[name] - other.q[name]))) for name in one.q)


def test_a_motion_that_is_known(cheap: None) -> None:
    motion = lagrange_cli.solve(DRIVEN)
    assert methods(motion) == ["taylor", "Radau"]
    assert motion.attributes["steps"] < 3000  # by Taylor series alone 830 thousand
    assert np.max(np.abs(motion.q["x"] - np.sin(motion.t))) < 1e-5
    assert np.max(np.abs(motion.v["x"] - np.cos(motion.t))) < 1e-5


def test_work_that_repays_the_compilation() -> None:
    """No numbers of this test are others than those of a user's run."""
    motion = lagrange_cli.solve(DRIVEN, set={"k": 2e7})
    assert methods(motion) == ["taylor", "Radau"]
    assert motion.attributes["steps"] < 5_000_000  # of 160 million
    assert np.max(np.abs(motion.q["x"] - np.sin(motion.t))) < 1e-5
    assert methods(lagrange_cli.solve(DRIVEN)) == ["taylor"]  # a run of 0.2 s


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("text", [COUPLED, CHAIN, RING, FLOOR])
def test_the_same_motion_as_by_implicit_steps(cheap: None, text: str) -> None:
    motion = lagrange_cli.solve(text)
    assert methods(motion) == ["taylor", "Radau"]
    assert motion.attributes["steps"] < 20000
    assert distance(motion, lagrange_cli.solve(text, method="Radau", tolerance=1e-9)) < 2e-5


def test_there_and_back(cheap: None) -> None:
    motion = lagrange_cli.solve(BETWEEN)
    turns = methods(motion)
    assert len(turns) > 3 and all(one != other for one, other in pairwise(turns))
    assert np.max(np.abs(motion.q["y"] - np.cos(motion.t) / 2 - np.sin(motion.t))) < 1e-3


def test_a_motion_that_seems_stiff_now_and_then(cheap: None) -> None:
    """At its turning points a pendulum on a hard, damped spring is smooth, and a step of Radau replaces some
    hundred Taylor steps; but on the whole three. Once that is known, there is no way back to Radau."""
    motion, series = lagrange_cli.solve(SWINGING), lagrange_cli.solve(SWINGING, method="taylor")
    assert methods(motion) == ["Radau", "taylor"]
    assert motion.attributes["steps"] > 0.6 * series.attributes["steps"] > 0.6 * LONG
    assert distance(motion, series) < 1e-3


def test_a_ball_comes_to_rest_on_a_hard_floor(cheap: None) -> None:
    motion = lagrange_cli.solve(FLOOR)
    assert methods(motion) == ["taylor", "Radau"]
    assert motion.attributes["steps"] < 5000  # by Taylor series alone 480 thousand
    assert motion.q["y"][-1] == pytest.approx(-9.81e-6, abs=1e-10)
    assert np.max(np.abs(motion.q["z"] - np.cos(motion.t))) < 1e-4
    assert motion.q["y"][0] == 20 and motion.q["y"][1] == pytest.approx(20 - 9.81 * 2, abs=1e-9)


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize(
    "text", [STICKING, ORBIT, FLOOR.replace("1e6", "1e3").replace("1e5", "10"), RING, CHAIN]
)
def test_motions_that_change_again_and_again(restless: None, text: str) -> None:
    """What is handed over makes no difference, nor does it where forces jump, or a motion sticks."""
    asked = {"stop": 12, "tolerance": 1e-8, "outputs": ("q", "v", "p", "action")}
    motion, series = lagrange_cli.solve(text, **asked), lagrange_cli.solve(text, method="taylor", **asked)
    assert len(methods(motion)) > 2
    assert distance(motion, series) < 1e-6
    assert np.max(np.abs(motion.action - series.action)) < 1e-6
    for name in series.p:
        assert np.max(np.abs(motion.p[name] - series.p[name])) < 1e-6


def test_motions_that_are_not_stiff_have_the_same_bits(cheap: None) -> None:
    calm = BETWEEN.replace("3e4", "1e-4")
    motion, series = (lagrange_cli.solve(calm, stop=12000, method=one) for one in ("auto", "taylor"))
    assert motion.attributes["steps"] == series.attributes["steps"] > 4 * changing.OFTEN
    assert methods(motion) == ["taylor"]
    assert all(np.array_equal(motion.q[name], series.q[name]) for name in motion.q)


class Nervous(Interrupts):
    """Interrupts a run when it is asked for the ``patience``-th time."""

    patience = 0

    def __call__(self) -> bool:
        type(self).patience -= 1
        return type(self).patience <= 0


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("text", [DRIVEN, BETWEEN.replace("4000", "800"), RING, FLOOR])
@pytest.mark.parametrize("patience", [2, 5])
def test_interrupted_runs_change_at_the_same_steps(
    cheap: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: str, patience: int
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("motion.yaml").write_text(text)
    asked = ("solve", "motion.yaml", "--outputs", "q,v,action", "--quiet")
    assert main([*asked, "-o", "whole.h5"]) == 0
    monkeypatch.setattr(solving, "Interrupts", Nervous)
    monkeypatch.setattr(stepper, "POLL_SECONDS", 1e-4)
    status, pieces = 130, 0
    while status == 130:
        Nervous.patience, pieces = patience + pieces, pieces + 1
        status = main([*asked, "-o", "pieces.h5", *(["--resume"] if pieces > 1 else [])])
    assert status == 0 and pieces > 2
    assert Path("whole.h5").read_bytes() == Path("pieces.h5").read_bytes()
    with h5py.File("whole.h5") as found:
        assert json.loads(found.attrs["methods"])[0]["method"] == "Radau"


def test_a_longer_run_goes_on_with_the_method_it_has_come_to(
    cheap: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("driven.yaml").write_text(DRIVEN)
    assert main(["solve", "driven.yaml"]) == 0
    assert main(["solve", "driven.yaml", "--stop", "30", "--resume"]) == 0
    with h5py.File("driven.h5") as found:
        told = json.loads(found.attrs["methods"])
        assert [one["method"] for one in told] == ["Radau"] and told[0]["t"] < 10
        assert found["t"][-1] == 30 and found.attrs["steps"] < 4000
        assert math.isclose(found["q/x"][-1], math.sin(30), abs_tol=1e-5)


def test_the_summary_says_where(
    cheap: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("driven.yaml").write_text(DRIVEN)
    assert main(["solve", "driven.yaml"]) == 0
    assert "after 1024 steps, Radau, as a step of Radau replaces some" in capsys.readouterr().out
    assert main(["solve", "driven.yaml", "--json", "--force"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["method"] == "taylor" and told["methods"][0]["method"] == "Radau"


@pytest.mark.parametrize("work", [1, 40, 1000, 10**9])
def test_looks_do_not_depend_on_where_a_run_begins(work: int) -> None:
    class Program:
        pass

    Program.work = work  # type: ignore[attr-defined]
    looks, steps = list[int](), 0
    while len(looks) < 200:
        steps = changing.next_look(Program, steps)  # type: ignore[arg-type]
        looks.append(steps)
    for before, after in pairwise(looks):
        assert changing.is_due(Program, after)  # type: ignore[arg-type]
        for between in (before + 1, (before + after) // 2, after - 1):
            assert changing.next_look(Program, between) == after  # type: ignore[arg-type]
            assert not changing.is_due(Program, between)  # type: ignore[arg-type]
