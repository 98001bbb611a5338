"""``--method auto`` tries a motion that may be stiff, and follows it by implicit steps if it is."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

import lagrange_cli
from lagrange_cli.integrate.methods.table import METHODS
from lagrange_cli.integrate.stiffness import LONG
from lagrange_cli.run.monitor import untimed
from lagrange_cli.run.motion import read_motion
from lagrange_cli.run.prepare import prepare_run
from lagrange_cli.run.request import Request
from lagrange_cli.run.trial import settled
from lagrange_cli.spec.spec import SolveDefaults
from tests.support.command import lagrange
from tests.test_imports import modules_imported_by

SYRUP = """
name: syrup
parameters: {c: 1e4, a: 1}
coordinates: {x: {initial: a}}
lagrangian: (x_dot**2 - x**2)/2
dissipation: c*x_dot**2/2
solve: {stop: 100, samples: 11, tolerance: 1e-6}
"""
"""Of the two rates of decay, one is 1/c and the other c, nearly."""
RELAXING = """
name: relaxing
coordinates: {x: {initial: 2}}
lagrangian: (x_dot**2 - x**2)/2
generalized_forces: {x: 500*(1 - x**2)*x_dot}
solve: {stop: 1000, samples: 11, tolerance: 1e-6}
"""
CHAIN = """
name: chain
sizes: {N: 12}
coordinates: {"x[i in range(N)]": {initial: "sin(3*i)/10"}}
masses: {"bead[i in range(N)]": 1}
embedding: {"bead[i in range(N)]": "x[i]"}
potential: 1e4*(x[0]**2 + sum((x[i] - x[i - 1])**2 for i in range(1, N)))/2
dissipation: 1e3*(x_dot[0]**2 + sum((x_dot[i] - x_dot[i - 1])**2 for i in range(1, N)))/2
solve: {stop: 20, samples: 11, tolerance: 1e-6}
"""
RING = """
name: ring
coordinates: {x: {initial: 1}, y: {initial: 0, velocity: 3}}
constraints: {ring: x**2 + y**2 - 1}
lagrangian: (x_dot**2 + y_dot**2)/2 - y
dissipation: 5e3*(x_dot**2 + y_dot**2)/2
solve: {stop: 100, samples: 11, tolerance: 1e-6}
"""


def decayed(t: np.ndarray, c: float) -> np.ndarray:
    """x of the syrup, from 1 at rest."""
    root = math.sqrt(c * c / 4 - 1)
    fast, slow = c / 2 + root, 1 / (c / 2 + root)
    return (fast * np.exp(-slow * t) - slow * np.exp(-fast * t)) / (fast - slow)


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8])
def test_a_stiff_motion(tolerance: float) -> None:
    motion = lagrange_cli.solve(SYRUP, tolerance=tolerance)
    assert motion.attributes["method"] == "Radau" and motion.attributes["tolerance"] == tolerance
    assert motion.attributes["steps"] < 100
    assert np.max(np.abs(motion.q["x"] - decayed(motion.t, 1e4))) < 10 * tolerance
    asked = lagrange_cli.solve(SYRUP, tolerance=tolerance, method="Radau")
    assert np.array_equal(motion.q["x"], asked.q["x"]) and np.array_equal(motion.v["x"], asked.v["x"])


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize("text", [RELAXING, CHAIN, RING])
def test_stiff_motions_end_where_taylor_series_do(text: str) -> None:
    motion, series = lagrange_cli.solve(text), lagrange_cli.solve(text, method="taylor")
    assert motion.attributes["method"] == "Radau"
    assert series.attributes["steps"] > max(LONG, 10 * motion.attributes["steps"])
    for name, q in series.q.items():
        assert np.max(np.abs(motion.q[name] - q)) < 1e-3


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize(
    ("text", "options"),
    [
        (SYRUP, {"tolerance": 2.0**-52}),
        (SYRUP, {"stop": 3}),  # 4000 steps
        (SYRUP, {"set": {"c": 3}, "stop": 10000}),  # which is not stiff
        (SYRUP, {"method": "taylor"}),
        (SYRUP, {"proven": True}),
        (SYRUP, {"portable": True}),
        (SYRUP, {"certify": True, "stop": 10}),
        (SYRUP.replace("dissipation: c*x_dot**2/2", ""), {"set": {"a": 1e-5}, "stop": 1e4}),
        (SYRUP + "events: {low: {when: sin(100*x)}}", {}),
        (SYRUP + "events: {slow: {when: x_dot}}", {}),
        (SYRUP.replace("- x**2)/2", "- x**2)/2 + exp(-1000*(x**2 - 0.5)**2)/1e6"), {}),
    ],
)
def test_motions_that_are_followed_by_series(text: str, options: dict[str, object]) -> None:
    assert lagrange_cli.solve(text, **options).attributes["method"] == "taylor"


CLUSTER = """
name: cluster
sizes: {N: 8}
parameters: {c: 2e3}
coordinates:
  x[i in range(N)]: {initial: 1.2*(i % 3)}
  y[i in range(N)]: {initial: 1.2*(i//3), velocity: sin(i)/10}
masses: {"atom[i in range(N)]": 1}
embedding: {"atom[i in range(N)]": ["x[i]", "y[i]"]}
potential: >
  sum(4*(norm(atom[i] - atom[j])**-12 - norm(atom[i] - atom[j])**-6) for i in range(N) for j in range(i))
dissipation: c*sum(x_dot[i]**2 + y_dot[i]**2 for i in range(N))/2
solve: {stop: 30, samples: 5, tolerance: 1e-6}
"""
JOINTS = """
name: joints
sizes: {N: 28}
parameters: {eps: 1e-3, mu: 0.5}
coordinates: {"a[i in range(N)]": {initial: 0.3*sin(i)}}
masses: {"m[i in range(N)]": 1}
embedding:
  m[i in range(N)]: "[sum(sin(a[j]) for j in range(i + 1)), -sum(cos(a[j]) for j in range(i + 1))]"
potential: 9.81*sum(m[i].y for i in range(N))
generalized_forces: {"a[i in range(N)]": -mu*tanh(a_dot[i]/eps)}
solve: {stop: 0.3, samples: 4, tolerance: 1e-6}
"""
PADS = """
name: pads
parameters: {k: 1e7, c: 1e5, e: 0.5}
coordinates: {x: {initial: 0.6}, s: {initial: 0.1}, y: {initial: 1}}
masses: {bob: 1, pad: 0.01, ball: 1}
embedding: {bob: [sin(x), -cos(x)], pad: [s], ball: [y]}
potential: 9.81*bob.y + k*s**2/2 + 9.81*y
dissipation: c*s_dot**2/2 + 0.1*x_dot**2
events:
  floor: {when: y, direction: falling, action: {set: {y_dot: -e*y_dot}}}
  middle: {when: x/2}
solve: {stop: 1.2, samples: 7, tolerance: 1e-6}
"""


@pytest.mark.exhaustive(keep=1)
def test_motions_that_other_explicit_steps_would_follow() -> None:
    """A cluster, whose pairs ias15 follows best, in syrup: 50 thousand of its steps."""
    motion, explicit = (lagrange_cli.solve(CLUSTER, method=one) for one in ("auto", "ias15"))
    assert lagrange_cli.solve(CLUSTER, set={"c": 0.1}).attributes["method"] == "ias15"
    assert motion.attributes["method"] == "Radau"
    assert explicit.attributes["steps"] > max(LONG, 100 * motion.attributes["steps"])
    for name in motion.q:
        assert np.max(np.abs(motion.q[name] - explicit.q[name])) < 1e-5


@pytest.mark.exhaustive(keep=1)
def test_narrow_friction_in_a_chain_is_not_written_out(tmp_path) -> None:
    motion, series = (lagrange_cli.solve(JOINTS, method=one) for one in ("auto", "taylor"))
    assert motion.attributes["method"] == "Radau"
    assert np.max(np.abs(motion.q["a"] - series.q["a"])) < 1e-5
    assert lagrange_cli.solve(JOINTS, tolerance=1e-12, stop=0.01).attributes["method"] == "taylor"
    (tmp_path / "joints.yaml").write_text(JOINTS)
    told = lagrange("solve", "joints.yaml", "--stop", "0.01", cwd=tmp_path).stdout
    assert "method Radau, as steps by series would have to be proven, with members written out" in told


def test_events_that_are_linear_in_coordinates() -> None:
    """The times of a ball that falls from 1 and keeps half its speed are known."""
    motion, series = (lagrange_cli.solve(PADS, method=one) for one in ("auto", "taylor"))
    assert motion.attributes["method"] == "Radau"
    assert series.attributes["steps"] > 1000 * motion.attributes["steps"]
    first = math.sqrt(2 / 9.81)
    assert motion.events["floor"]["t"] == pytest.approx([first, 2 * first, 2.5 * first], abs=1e-6)
    assert motion.events["middle"]["t"] == pytest.approx(series.events["middle"]["t"], abs=1e-5)


def test_small_coordinates_are_as_precise() -> None:
    """The tolerance of implicit steps is an absolute one as well, so that it becomes a finer one."""
    motion = lagrange_cli.solve(SYRUP, set={"a": 2e-4})
    assert motion.attributes["method"] == "Radau" and motion.attributes["tolerance"] == 1e-10
    assert np.max(np.abs(motion.q["x"] / 2e-4 - decayed(motion.t, 1e4))) < 1e-5


def test_one_coordinate_that_is_far_smaller() -> None:
    """It would be lost."""
    both = SYRUP.replace("{x: {initial: a}}", "{x: {initial: a}, y: {initial: 1e-7}}")
    both = both.replace("x_dot**2 - x**2", "x_dot**2 + y_dot**2 - x**2 - y**2")
    motion = lagrange_cli.solve(both)
    assert motion.attributes["method"] == "taylor"
    assert motion.q["y"][-1] == pytest.approx(1e-7 * math.cos(100), rel=1e-4)


def test_what_a_trial_has_compiled_is_not_compiled_again() -> None:
    methods = list[str]()

    def prepare(spec, settings, stage, **options):
        methods.append(settings.method)
        return prepare_run(spec, settings, stage, **options)

    for text, expected in ((SYRUP, ["taylor", "Radau"]), (SYRUP.replace("1e4", "3"), ["taylor"])):
        request = Request(cache=False)
        motion = read_motion(text.encode(), "syrup.yaml", request)
        methods.clear()
        found, following = settled(motion, request, untimed, prepare)
        following(found.spec, found.settings, untimed, cached=False)
        assert methods == expected
        assert found.settings.method == expected[-1]


def test_the_summary_says_why(tmp_path) -> None:
    (tmp_path / "syrup.yaml").write_text(SYRUP)
    told = lagrange("solve", "syrup.yaml", cwd=tmp_path)
    assert re.search(
        r"method Radau, as the motion is stiff: at first a step replaces some \d+ Taylor", told.stdout
    )
    again = lagrange("solve", "syrup.yaml", "--force", cwd=tmp_path)
    assert again.stdout.splitlines()[:4] == told.stdout.splitlines()[:4]


@pytest.mark.parametrize(("first", "method"), [("3", "taylor"), ("100", "Radau")])
def test_a_longer_run_goes_on_by_the_same_method(tmp_path, first: str, method: str) -> None:
    (tmp_path / "syrup.yaml").write_text(SYRUP)
    assert lagrange("solve", "syrup.yaml", "--stop", first, cwd=tmp_path).returncode == 0
    told = lagrange("solve", "syrup.yaml", "--stop", "200", "--resume", cwd=tmp_path)
    assert told.returncode == 0, told.stderr
    assert f"method {method}" in told.stdout and "t = 0 to 200" in told.stdout


@pytest.mark.exhaustive(keep=0.6)
def test_runs_at_full_precision_import_nothing_for_it(tmp_path) -> None:
    (tmp_path / "syrup.yaml").write_text(SYRUP.replace(", tolerance: 1e-6", ""))
    imported = modules_imported_by(["solve", "syrup.yaml", "--stop", "1"], tmp_path)
    assert "lagrange_cli.run.solve" in imported
    assert not {"lagrange_cli.run.trial", "lagrange_cli.integrate.stiffness"} & set(imported)


def test_tolerances_beyond_those_of_implicit_steps() -> None:
    finest, _ = METHODS["Radau"].tolerances["double"]
    request = Request(SolveDefaults(tolerance=finest / 2), cache=False)
    assert not read_motion(SYRUP.encode(), "syrup.yaml", request).may_be_stiff
