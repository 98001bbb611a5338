"""Series and values by loops over members, beside straight code for the same equations."""

from __future__ import annotations

import re
from collections.abc import Mapping
from textwrap import dedent

import numpy as np
import pytest
from numpy.typing import NDArray

from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.program import write_run
from lagrange_cli.mechanics.derive import derive
from lagrange_cli.model.build import build_model
from lagrange_cli.native import motions
from lagrange_cli.native.compilation.machine import QUICK, compile_object
from lagrange_cli.native.program import Program, write_program
from lagrange_cli.native.recurrences.batches import arrangement
from lagrange_cli.run.start import consistent_values
from lagrange_cli.series.batches import batches
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_values
from tests.support.motion import prepare, run

WEB = """
sizes: {N: 3}
parameters: {k: 2.0, w: 1.5, G: 0.1, "m[i in range(N)]": "1 + i/7"}
coordinates:
  x[i in range(N)]: {initial: "i + 0.1*i**2", velocity: 0.1}
  y[i in range(N)]: {initial: "sin(i)", velocity: "-0.2*i"}
  u[i in range(N)]: {initial: "0.3*i", velocity: 0.5}
lagrangian: >-
  sum(m[i]*(x_dot[i]**2 + y_dot[i]**2)/2 + u_dot[i]**2/2 for i in range(N))
  - sum(k/2*x[i]**2 + w**2*(1 - cos(u[i])) + (1 + i/3)*y[i]**4/4 for i in range(N))
  - sum(k/2*(u[(i + 1) % N] - u[i])**2 + (y[i] - u[i])**3/50 for i in range(N))
  + sum(G*m[i]*m[j]/sqrt((x[i] - x[j])**2 + (y[i] - y[j])**2) for i in range(N) for j in range(i + 1, N))
generalized_forces: {"x[i in range(N)]": "sin(w*t + i) - 0.01*x_dot[i]"}
"""
"""Rings, pairs, springs, functions, parameters and numbers that differ from member to member, and t."""


NET = """
sizes: {N: 3}
parameters: {g: 9.81, w: 2.0, "l[i in range(N)]": "1 + i/9", "m[i in range(N)]": "1 + i/7"}
coordinates:
  x[i in range(N)]: {initial: "sum(l[j]*cos(0.3*j) for j in range(i + 1))", velocity: "0"}
  y[i in range(N)]: {initial: "sum(l[j]*sin(0.3*j) for j in range(i + 1))", velocity: "0"}
  z[i in range(N)]: {initial: "0.2*i", velocity: 0.1}
  s: {initial: 0}
masses: {"bob[i in range(N)]": "m[i]", slider: 2}
positions: {"bob[i in range(N)]": ["x[i]", "y[i]", "z[i]"], slider: "s"}
potential: sum(m[i]*g*y[i] + z[i]**2/2 for i in range(N)) + x[0]*x[N - 1]/9
constraints:
  rod[0]: (x[0] - 0.1*sin(w*t)**2)**2 + y[0]**2 - l[0]**2
  rod[i in range(1, N)]: (x[i] - x[i - 1])**2 + (y[i] - y[i - 1])**2 - l[i]**2
  all: s - sum(y[i] for i in range(N)) + sum(l[j]*sin(0.3*j) for i in range(N) for j in range(i + 1))
nonholonomic:
  roll[i in range(N - 1)]: z_dot[i + 1] - 0.5*z_dot[i] + 0.1*x[i]*y_dot[i] - 0.05*cos(t)
"""
"""Rods from a moving pivot, a constraint of many terms, and some on velocities."""


def program_and_motion(
    text: str, count: int, *more: str
) -> tuple[Program, Mapping[str, NDArray[np.float64]]]:
    """The program of the system with so many members, and a short motion."""
    spec = read_spec(dedent(text), "system.yaml", {"N": str(count)} if "sizes" in text else None)
    residual = derive(build_model(spec, GraphAlgebra()))
    outputs = frozenset(["q", "v", "h", "p", "observables", *more])
    ready = prepare(residual, Compilation("taylor", 2.0**-52, outputs))
    _, values, _ = consistent_values(spec, resolve_values(spec, {}), 0.0, {}, forced=True)
    motion = run(ready, values, 0.0, 1.5, 4)
    program = ready.machine.program
    assert isinstance(program, Program)
    return program, motion.data


@pytest.fixture
def always_in_batches(monkeypatch: pytest.MonkeyPatch) -> None:
    """Even one member is a batch."""
    monkeypatch.setattr(motions, "BATCHED", 0)
    monkeypatch.setattr(arrangement, "FEWEST", 0)


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.parametrize("count", [1, 2, 3, 8, 9])
def test_batches_follow_the_same_motion_as_straight_code(
    count: int, monkeypatch: pytest.MonkeyPatch, always_in_batches: None
) -> None:
    rolled, found = program_and_motion(WEB, count)
    monkeypatch.setattr(motions, "BATCHED", 10**9)
    straight, expected = program_and_motion(WEB, count)
    assert rolled.tables > 0
    assert straight.tables == 0
    assert found.keys() == expected.keys()
    for path, values in expected.items():
        size = np.max(np.abs(values), initial=1.0)
        assert np.max(np.abs(found[path] - values)) <= 2.0**-46 * size, path


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize("count", [2, 3, 5, 9, 17])
def test_constraints_in_batches_are_those_of_straight_code(
    count: int, monkeypatch: pytest.MonkeyPatch, always_in_batches: None
) -> None:
    rolled, found = program_and_motion(NET, count, "constraints")
    monkeypatch.setattr(motions, "BATCHED", 10**9)
    straight, expected = program_and_motion(NET, count, "constraints")
    assert rolled.tables > 0
    assert straight.tables == 0
    for path, values in expected.items():
        size = np.max(np.abs(values), initial=1.0)
        assert np.max(np.abs(found[path] - values)) <= 2.0**-42 * size, path
        if "constraints" in path:
            assert np.max(np.abs(found[path])) <= 1e-14 * count, path


def test_a_family_has_the_code_of_its_unrolled_twin(always_in_batches: None) -> None:
    family = """
    coordinates: {"x[i in range(3)]": {initial: "i"}}
    lagrangian: sum(x_dot[i]**2/2 - cos(x[i] - x[i - 1]) for i in range(1, 3)) + x_dot[0]**2/2 - x[0]**4
    """
    twin = """
    coordinates: {x0: {initial: 0}, x1: {initial: 1}, x2: {initial: 2}}
    lagrangian: >-
      x1_dot**2/2 - cos(x1 - x0) + x2_dot**2/2 - cos(x2 - x1) + x0_dot**2/2 - x0**4
    """
    (one, found), (other, expected) = (program_and_motion(text, 3) for text in (family, twin))
    assert one.tables > 0
    assert one.text == other.text
    for row in range(3):
        np.testing.assert_array_equal(found["q/x"][:, row], expected[f"q/x{row}"])


def test_the_number_of_batches_does_not_grow_with_the_family(always_in_batches: None) -> None:
    def counted(count: int) -> tuple[int, int]:
        spec = read_spec(dedent(WEB), "system.yaml", {"N": str(count)})
        residual = derive(build_model(spec, GraphAlgebra()))
        program = write_program(residual, 6, {}, {})
        found = batches(program.series, residual.variables)
        return len(found), program.text.count("\n")

    assert counted(10) == counted(12)


def test_members_in_lanes_are_observed_in_batches(always_in_batches: None) -> None:
    text = """
    coordinates: {"x[i in range(3)]": {initial: "i"}}
    lagrangian: sum(x_dot[i]**2/2 + cos(x[i]) for i in range(3))
    """
    residual = derive(build_model(read_spec(dedent(text), "system.yaml"), GraphAlgebra()))
    for ensemble in (False, True):
        asked = Compilation("taylor", 2.0**-52, frozenset(["q", "h"]), ensemble=ensemble)
        program, _ = write_run(residual, asked)
        assert program.tables > 0
        assert len(re.findall(r"^define .*@sin_cos\.1\(", program.text, re.MULTILINE)) == 1
        compile_object(program, QUICK)
