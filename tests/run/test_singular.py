"""Mass matrices that are singular where a motion begins or ends: of which coordinates, and at which line."""

from __future__ import annotations

import json

import numpy as np
import pytest

from lagrange_cli import solve
from lagrange_cli.mechanics.conditioning import conditioning, told
from lagrange_cli.run.doubtful import singular_start
from lagrange_cli.run.singular import without_mass
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_values
from tests.support.command import lagrange

PENDULUM = """\
parameters: {m: 1, l: 0.0, g: 9.81}
coordinates:
  theta: {initial: 0.3}
masses: {bob: m}
positions: {bob: [l*sin(theta), -l*cos(theta)]}
potential: m*g*bob.y
"""
SPHERICAL = """\
coordinates: {a: {initial: 0}, b: {initial: 0, velocity: 1}}
masses: {bob: 1e-20}
positions: {bob: [sin(a)*cos(b), sin(a)*sin(b), -cos(a)]}
"""
ENTANGLED = """\
parameters: {k: 1}
coordinates: {a: {initial: 0}, b: {initial: 0}, c: {initial: 0}}
lagrangian: a_dot**2/2 + k*a_dot*b_dot + b_dot**2/2 + 1e9*c_dot**2 - a**2/2 - b**2
"""
CROSSED = "coordinates: {x: {initial: 0}, y: {initial: 0}}\nlagrangian: 1e-9*x_dot*y_dot - x*y\n"
BOUND = """\
coordinates: {x: {initial: 0}, angle: {initial: 0}}
masses: {a: 1}
positions: {a: [x, 0]}
constraints: {cam: x - sin(angle)}
"""


RING = """\
sizes: {N: 120}
parameters: {k: 1}
coordinates: {"x[i in range(N)]": {initial: 0}}
masses: {"b[i in range(N)]": 1}
positions: {"b[i in range(N)]": "x[i] + k*x[(i + 1) % N]"}
"""


def found(text, **sets):
    spec = read_spec(text, "file.yaml")
    values = resolve_values(spec, {name: repr(x) for name, x in sets.items()})
    return without_mass(spec, values.parameters, 0.0, (*values.q, *values.v))


@pytest.mark.parametrize(
    ("text", "sets", "names"),
    [
        (PENDULUM, {}, ("theta",)),
        (PENDULUM, {"l": 1e-9}, ()),
        (SPHERICAL, {}, ("b",)),
        (SPHERICAL, {"a": 1e-6}, ()),
        (ENTANGLED, {}, ("a", "b")),
        (ENTANGLED, {"k": 1.0 + 1e-9}, ()),
        (CROSSED, {}, ()),  # its diagonal is 0, and it is regular
        (BOUND, {}, ()),  # the constraint turns the cam
        (RING, {}, tuple(f"x[{i}]" for i in range(120))),  # in turn forward and backward
        (RING, {"k": 0.5}, ()),
    ],
)
def test_the_coordinates_without_inertia_are_found(text, sets, names):
    assert found(text, **sets) == names


def test_check_warns_at_the_place_of_the_coordinate():
    spec = read_spec(PENDULUM, "file.yaml")
    (problem,) = singular_start(spec, resolve_values(spec))
    assert problem.line == 3
    assert problem.message == (
        "the mass matrix is singular at the start: no kinetic energy depends on theta_dot"
    )
    assert singular_start(spec, resolve_values(spec, {"l": "1"})) == ()


def test_a_coordinate_whose_mass_is_0_is_named():
    text = """\
parameters: {m: 0, J: 1}
coordinates: {x: {initial: 0}, theta: {initial: 0}}
lagrangian: m*x_dot**2/2 + J*theta_dot**2/2
"""
    spec = read_spec(text, "file.yaml")
    (problem,) = singular_start(spec, resolve_values(spec))
    assert problem.message == "the mass matrix is singular at the start: no kinetic energy depends on x_dot"


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("method", ["taylor", "DOP853"])
def test_a_motion_that_cannot_begin_says_so(tmp_path, method):
    (tmp_path / "file.yaml").write_text(PENDULUM)
    done = lagrange("solve", "file.yaml", "--stop", "1", "--method", method, cwd=tmp_path)
    assert done.returncode == 4
    assert (
        "the mass matrix is singular: no kinetic energy depends on theta_dot (line 3) at t = 0" in done.stderr
    )
    assert "overflow" not in done.stderr
    done = lagrange("sweep", "file.yaml", "--over", "l=0:1:3", "--stop", "1", "--json", cwd=tmp_path)
    assert "(l = 0): the mass matrix is singular" in json.loads(done.stdout)["message"]


HILBERT = """\
sizes: {N: 24}
coordinates: {"q[i in range(N)]": {initial: 0.1}}
lagrangian: >-
  sum(q_dot[i]*q_dot[j]/(i + j + 5)/2 for i in range(N) for j in range(N)) - sum(q[i]**2/2 for i in range(N))
"""


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.parametrize("count", [24, 150])
def test_masses_that_are_too_ill_conditioned_are_called_so(tmp_path, count):
    """Those of powers of x in Ritz's method; with many, in loops."""
    (tmp_path / "file.yaml").write_text(HILBERT)
    done = lagrange("solve", "file.yaml", "--stop", "1", "--size", f"N={count}", cwd=tmp_path)
    assert done.returncode == 4
    assert "the mass matrix is too ill-conditioned for doubles: its condition is 1e+16 or more" in done.stderr
    assert "--precision double-double" in done.stderr
    assert "momentum" not in done.stderr


@pytest.mark.exhaustive(keep=0.6)
def test_ill_conditioned_masses_that_can_be_solved_are():
    """Their condition is 1e10; h is conserved."""
    motion = solve(HILBERT, size={"N": 7}, stop=0.1, outputs=["q", "h"])
    assert motion.status == "complete"
    assert np.ptp(motion.h) < 1e-14


@pytest.mark.parametrize("count", [3, 24])
def test_singular_masses_have_a_gap(count):
    """Sums of places of neighbours say nothing of what alternates, whatever the units."""
    scale = 10.0 ** np.linspace(-6, 6, count + 1)
    sums = np.eye(count, count + 1) + np.eye(count, count + 1, 1)
    found = conditioning(scale[:, None] * (sums.T @ sums) * scale)
    assert found is not None and found.lost == 1 and not found.graded


@pytest.mark.parametrize("count", [11, 16, 24, 60])
def test_hilberts_matrices_have_none(count):
    found = conditioning(1 / (np.arange(count)[:, None] + np.arange(count) + 1.0))
    assert found is not None and found.lost and found.graded
    assert told(found.condition) == "1e+16 or more" or count == 11
