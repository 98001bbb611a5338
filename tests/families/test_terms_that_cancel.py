"""Integrands of large systems in which terms cancel: steps do not follow their rounding errors."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest

from lagrange_cli.native.stepping import division
from tests.motions.test_double_double import solved
from tests.support.command import lagrange_process
from tests.support.families import followed

TURNING = """
sizes: {N: 16}
parameters: {b: 0.7}
coordinates:
  "x[i in range(N)]": {initial: i, velocity: 1}
  "y[i in range(N)]": {initial: 0}
masses: {"p[i in range(N)]": 1 + i/7}
embedding: {"p[i in range(N)]": ["x[i]", "y[i]"]}
definitions: {"s[i in range(N)]": sqrt(p[i].vx**2 + p[i].vy**2 + 1)}
forces: {"p[i in range(N)]": ["-b*p[i].vy*s[i]", "b*p[i].vx*s[i]"]}
"""
"""Forces across the velocities turn these at the rates b s/m."""
DRAG = """
generalized_forces:
  "x[i in range(N)]": where(t > 1, -x_dot[i]/2, 0)
  "y[i in range(N)]": where(t > 1, -y_dot[i]/2, 0)
"""
ATTRACTED = """
sizes: {N: 8}
parameters: {b: 0.1}
coordinates:
  "x[i in range(N)]": {initial: i}
  "y[i in range(N)]": {initial: 0, velocity: i}
masses: {"p[i in range(N)]": 1}
embedding: {"p[i in range(N)]": ["x[i]", "y[i]"]}
forces: {"p[i in range(N)]": ["-b*y_dot[i]*(1 + x[i]**2)", "b*x_dot[i]*(1 + x[i]**2)"]}
potential: >
  sum(-1/sqrt((x[i] - x[j] - 1 + 3*(i - j))**2 + (y[i] - y[j])**2 + 1) for i in range(N) for j in range(i))
solve: {stop: 5, samples: 2, outputs: [q, h, ledger]}
"""
FEW = 2**10
"""Parts of a step: where rounding errors are not known, there are many more, and integrals are lost."""


def test_the_work_of_forces_across_velocities_is_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(division, "MOST", FEW)
    _, motion = followed(TURNING, frozenset({"q", "h", "ledger"}), 10.0, 11)
    rate = 0.7 * np.sqrt(2.0) / (1.0 + np.arange(16) / 7.0)
    turned = np.outer(motion.t, rate)
    assert np.max(np.abs(motion.data["q/x"] - np.arange(16) - np.sin(turned) / rate)) < 1e-13
    assert np.max(np.abs(motion.data["q/y"] - (1.0 - np.cos(turned)) / rate)) < 1e-13
    assert np.max(np.abs(motion.data["diagnostics/ledger/h"])) < 1e-13
    assert motion.outcome.steps < 100


@pytest.mark.parametrize("method", ["taylor", "ias15"])
def test_work_that_begins_later_is_known_to_all_digits(method: str) -> None:
    """Until t = 1 the power is nothing but rounding errors, then it is that of the drag."""
    _, motion = followed(TURNING + DRAG, frozenset({"q", "h", "ledger"}), 3.0, 13, method)
    masses = 1.0 + np.arange(16) / 7.0
    left = np.exp(-np.outer(np.maximum(motion.t - 1.0, 0.0), 1.0 / masses))
    energy = left @ masses / 2.0
    assert np.max(np.abs(motion.data["diagnostics/h"] - energy)) < 1e-13 * energy[0]
    assert np.max(np.abs(motion.data["diagnostics/ledger/h"])) < 1e-13 * energy[0]


def test_steps_with_series_are_not_divided_without_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(division, "MOST", FEW)
    _, motion = followed(ATTRACTED, frozenset({"h", "ledger"}), 5.0, 2)
    assert motion.outcome.steps < 100
    assert np.max(np.abs(motion.data["diagnostics/ledger/h"])) < 1e-12


def test_nor_are_those_in_double_double(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(division, "MOST", FEW)
    _, data = solved(tmp_path, ATTRACTED, "--stop", "0.3", "--precision", "double-double", "--no-cache")
    assert max(map(abs, data["diagnostics/ledger/h"])) < 1e-28


def test_steps_on_rates_are_not_shorter_and_shorter(tmp_path: Path) -> None:
    """They were 1e-10 of what they should be, from t = 0.0087 on."""
    (tmp_path / "attracted.yaml").write_text(ATTRACTED)
    done = lagrange_process("solve", "attracted.yaml", "--method", "ias15", "--no-cache", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    with h5py.File(tmp_path / "attracted.h5") as file:
        assert file.attrs["steps"] < 500
        assert np.max(np.abs(file["diagnostics/ledger/h"][()])) < 1e-12
