"""Motions that are small beside what a tolerance allows are warned of; other motions and methods, not."""

import json

import pytest

from tests.support.command import lagrange

DAMPED = """
parameters: {{size: {size}, push: {push}}}
coordinates: {{x: {{initial: size}}}}
lagrangian: x_dot**2/2 - x**2/2
dissipation: x_dot**2/4
generalized_forces: {{x: push*exp(-(t - 20)**2)}}
solve: {{stop: 100, samples: 301}}
"""


def warned(tmp_path, method, *options, size=1e-9, push=0.0):
    (tmp_path / "a.yaml").write_text(DAMPED.format(size=size, push=push))
    run = lagrange("solve", "a.yaml", "--method", method, "--json", *options, cwd=tmp_path)
    assert run.returncode == 0
    return json.loads(run.stdout)["warning"] or ""


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("method", ["taylor", "ias15", "DOP853", "Radau", "BDF", "LSODA"])
def test_a_motion_smaller_than_the_errors_that_are_allowed_is_warned_of(tmp_path, method):
    said = f"{method} allows errors of 1.0e-10 in coordinates and velocities smaller than 1, and none"
    assert (said in warned(tmp_path, method)) is (method not in ("taylor", "ias15"))


@pytest.mark.parametrize(("size", "push"), [(1e-3, 0.0), (1e-9, 1.0), (0.0, 0.0)])
def test_others_are_not(tmp_path, size, push):
    """What rests at 0 is followed exactly; what is pushed is large for a time, and small where it ends."""
    assert "allows errors" not in warned(tmp_path, "DOP853", size=size, push=push)


def test_with_a_finer_tolerance_there_is_no_warning(tmp_path):
    assert "allows errors of 1.0e-06" in warned(tmp_path, "DOP853", "--tolerance", "1e-6", size=1e-3)
    assert "allows errors" not in warned(tmp_path, "DOP853", "--tolerance", "1e-9", "--force", size=1e-3)


def test_a_resumed_run_knows_how_large_the_motion_was(tmp_path):
    """The end of one that was large for a time, with the warning of the whole."""
    for options in (("--stop", "60"), ("--resume", "--stop", "100")):
        assert "allows errors" not in warned(tmp_path, "DOP853", *options, push=1.0)
