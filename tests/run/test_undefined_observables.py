"""Observables with multipliers that are not functions of the state: left out with a warning, unless they are
asked for by name."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import h5py
import pytest

ROD = """
name: a rod over a floor
parameters: {m: 1, g: 9.81, l: 1}
coordinates: {x: {initial: 0.6}, y: {initial: 0.8}}
masses: {b: m}
positions: {b: [x, y]}
potential: m*g*y
constraints: {rod: x**2 + y**2 - l**2}
observables: {tension: rod.multiplier*l, height: y}
events: {floor: {when: y, direction: falling, action: {set: {x_dot: -FACTOR*x_dot, y_dot: -FACTOR*y_dot}}}}
solve: {stop: 0.6, samples: 11}
"""


def run(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "lagrange_cli", *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


@pytest.fixture
def rod(tmp_path: Path) -> Path:
    (tmp_path / "rod.yaml").write_text(ROD.replace("FACTOR", "0.5"))
    (tmp_path / "elastic.yaml").write_text(ROD.replace("FACTOR", "1"))
    return tmp_path


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize(
    "arguments",
    [
        ("solve", "rod.yaml"),
        ("solve", "rod.yaml", "--outputs", "all"),
        ("sweep", "rod.yaml", "--over", "g=9:10:2"),
    ],
)
def test_they_are_left_out_of_what_no_one_asked_for(rod, arguments):
    done = run(rod, *arguments, "-o", "out.h5")
    assert done.returncode == 0, done.stderr
    assert "warning: left out of the observables: 'tension', as the motion may come to rest" in done.stderr
    with h5py.File(rod / "out.h5") as file:
        assert "tension" not in file["observables"] and "height" in file["observables"]
        assert "'tension'" in file.attrs["warning"]


@pytest.mark.exhaustive(keep=0.65)
def test_asked_for_by_name_they_are_refused(rod):
    done = run(rod, "solve", "rod.yaml", "--outputs", "q,observables")
    assert done.returncode == 2
    assert "no output 'observables'" in done.stderr and "choose outputs without it" in done.stderr


@pytest.mark.exhaustive(keep=0.25)
def test_where_they_are_defined_all_are_written(rod):
    done = run(rod, "solve", "elastic.yaml")
    assert (done.returncode, done.stderr) == (0, "")
    with h5py.File(rod / "elastic.h5") as file:
        assert {"tension", "height"} <= set(file["observables"])


@pytest.mark.exhaustive(keep=0.15)
def test_pictures_do_without_them(rod):
    assert run(rod, "plot", "rod.yaml").returncode == 0
    assert run(rod, "plot", "rod.yaml", "--what", "observables", "-o", "named.png").returncode == 2
