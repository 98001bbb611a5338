"""What is said of the drifts of conserved quantities that have no finite value, or no sample."""

from __future__ import annotations

import json

import h5py
import numpy as np
import pytest

from lagrange_cli.cli.main import main

HUGE = """
name: a huge spring
parameters: {k: 1e300}
coordinates: {x: {initial: 1e50}}
lagrangian: k*x_dot**2/2 - k*x**2/2
"""
"""The energy overflows, the motion does not."""
WARNING = "a huge spring: warning: h is not finite at some of the samples (an overflow, or a singularity)"


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    (tmp_path / "huge.yaml").write_text(HUGE)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize(
    "command",
    [
        ["solve", "huge.yaml", "--stop", "1"],
        ["solve", "huge.yaml", "--stop", "1", "--precision", "double-double"],
        ["sweep", "huge.yaml", "--stop", "1", "--over", "k=1,1e300"],
        ["sweep", "huge.yaml", "--stop", "1", "--over", "k=1,1e300", "--outputs", "q,v,h", "--samples", "3"],
        ["section", "huge.yaml", "--where", "x", "--crossings", "2"],
        ["section", "huge.yaml", "--where", "x", "--crossings", "2", "--over", "k=1,1e300"],
    ],
)
def test_a_drift_that_is_not_finite_is_not_0(command, capsys):
    assert main([*command, "-o", "out.h5"]) == 0
    out, error = capsys.readouterr()
    assert "drift: h inf\n" in out and error.startswith(WARNING)
    assert main([*command, "-o", "out.h5", "--force", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["h_drift"] is None
    with h5py.File("out.h5") as file:
        assert file.attrs["h_drift"] == np.inf
        if "diagnostics/drift/h" in file:
            drift = file["diagnostics/drift/h"][:]
            assert np.isfinite(drift[0]) and drift[1] == np.inf


@pytest.mark.exhaustive(keep=0.6)
def test_a_section_without_crossings_knows_no_drift(capsys):
    command = ["section", "huge.yaml", "--where", "x - 1e60", "--stop", "1", "--set", "k=1", "-o", "out.h5"]
    for options in ([], ["--over", "x=1,2", "--force"]):
        assert main([*command, *options]) == 0
        out, error = capsys.readouterr()
        assert "  largest drift: not known, as there are no samples\n" in out and not error
    assert main([*command, "--json", "--force"]) == 0
    assert json.loads(capsys.readouterr().out)["h_drift"] is None


PASSING = """
name: passing
coordinates: {x: {initial: -1, velocity: 1}, y: {initial: 1}}
lagrangian: x_dot**2/2 + y_dot**2/2 - y**2/2
observables: {a: log(x**2 - 0.02), b: sqrt(x**2 - 0.01)}
"""
"""Quantities without a value in the middle of the motion, at t = 1."""
NO_VALUE = "passing: warning: not a finite number at some of the samples: "
OF_EACH = "/observables/a (first {}at t = {}), /observables/b (first {}at t = {})\n"


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize(
    "command, told",
    [
        (["solve"], OF_EACH.format("", 1, "", 1)),
        (["solve", "--precision", "double-double"], OF_EACH.format("", 1, "", 1)),
        (["sweep", "--over", "x=-1.5,-1"], OF_EACH.format(*["in member 0 ", 1.5] * 2)),
        (["section", "--every", "1", "--crossings", "3"], OF_EACH.format("", 1, "", 1)),
        (["section", "--every", "1", "--crossings", "3", "--precision", "double-double"],
         OF_EACH.format("", 1, "", 1)),
        (["section", "--every", "1", "--crossings", "3", "--over", "x=-1.5,-1"],
         OF_EACH.format(*["in member 1 ", 1] * 2)),
    ],
)  # fmt: skip
def test_a_quantity_without_a_value_is_told_wherever_that_is(folder, command, told, capsys):
    (folder / "passing.yaml").write_text(PASSING)
    sampled = [] if command[0] == "section" else ["--stop", "2", "--step", "0.5"]
    arguments = [
        command[0],
        "passing.yaml",
        *command[1:],
        *sampled,
        "--outputs",
        "observables",
        "-o",
        "out.h5",
    ]
    assert main(arguments) == 0
    assert capsys.readouterr().err == NO_VALUE + told
    with h5py.File("out.h5") as file:
        assert NO_VALUE.endswith("warning: " + file.attrs["warning"].partition("/")[0])


def test_of_shares_of_friction_that_are_undetermined_it_is_told_why(folder, capsys):
    """Two blocks on a rod begin to move at t = 1.5, when the force on one exceeds the friction on both."""
    (folder / "pair.yaml").write_text("""
coordinates: {x: {initial: 0}, y: {initial: 1}}
masses: {a: 1, b: 1}
positions: {a: x, b: y}
potential: 0
generalized_forces: {x: t - sign(x_dot), y: -0.5*sign(y_dot)}
constraints: {rod: y - x - 1}
""")
    assert main(["solve", "pair.yaml", "--stop", "3", "--step", "0.5", "--outputs", "q,multipliers"]) == 0
    told = capsys.readouterr().err
    assert "/multipliers/rod (first at t = 0) (where several forces of friction hold" in told
    with h5py.File("pair.h5") as file:
        t, rod = file["t"][:], file["multipliers/rod"][:]
        assert file["q/x"][:] == pytest.approx(np.maximum(t - 1.5, 0) ** 3 / 12, abs=1e-14)
        assert rod[t > 1.5] == pytest.approx(t[t > 1.5] / 2 - 0.25, abs=1e-14)
        assert rod[t < 1.5].tobytes() == np.full(3, np.nan).tobytes()  # whatever code has computed it


def test_it_is_told_again_of_a_run_that_is_continued(folder, capsys):
    (folder / "passing.yaml").write_text(PASSING)
    command = ["solve", "passing.yaml", "--step", "0.5", "--outputs", "q,observables", "-o", "out.h5"]
    for options in (["--stop", "6"], ["--stop", "7", "--resume"]):
        assert main([*command, *options]) == 0
        out, error = capsys.readouterr()
        assert error == NO_VALUE + OF_EACH.format("", 1, "", 1)
    assert "continued from t = 5.9" in out
