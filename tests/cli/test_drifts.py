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


def test_a_section_without_crossings_knows_no_drift(capsys):
    command = ["section", "huge.yaml", "--where", "x - 1e60", "--stop", "1", "--set", "k=1", "-o", "out.h5"]
    for options in ([], ["--over", "x=1,2", "--force"]):
        assert main([*command, *options]) == 0
        out, error = capsys.readouterr()
        assert "  largest drift: not known, as there are no samples\n" in out and not error
    assert main([*command, "--json", "--force"]) == 0
    assert json.loads(capsys.readouterr().out)["h_drift"] is None
