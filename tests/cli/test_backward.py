"""Motions backward in time, by every way to ask for them: one must give what the others give."""

import h5py
import mpmath
import numpy as np
import pytest

from lagrange_cli.cli.main import main

SYSTEM = """
name: damped and driven
parameters: {c: 0.25, F: 1}
coordinates: {x: {initial: 0.5, velocity: -0.25}}
lagrangian: x_dot**2/2 - x**2/2 + F*x*cos(2*t)/3
dissipation: c*x_dot**2/2
solve: {start: 1, stop: -3, samples: 9, outputs: [q, v, action]}
"""
LONG = ("q/x", "low/q/x", "v/x", "low/v/x")


@pytest.fixture
def written(tmp_path, monkeypatch, capsys):
    """A function that runs a command on the system; the file it writes, by path."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "system.yaml").write_text(SYSTEM)

    def run(command, *options):
        assert main([command, "system.yaml", "--force", "-o", "out.h5", *options]) == 0
        found = {}
        with h5py.File("out.h5") as file:
            file.visititems(
                lambda path, one: found.update({path: one[()]} if isinstance(one, h5py.Dataset) else {})
            )
        return found

    return run


def close(a, b, wrong=1e-14):
    return np.max(np.abs(a - b)) <= wrong


@pytest.mark.exhaustive(keep=0.2)
def test_every_way_to_follow_it_gives_the_same_motion(written):
    plain = written("solve")
    assert plain["t"].tolist() == [1, 0.5, 0, -0.5, -1, -1.5, -2, -2.5, -3]
    series = ("q/x", "v/x", "diagnostics/action")
    for options in (
        ("--portable",),
        ("--precision", "double-double"),
        ("--certify",),
        ("--step", "0.5"),
        ("--step", "-0.5"),
    ):
        other = written("solve", *options)
        assert other["t"].tolist() == plain["t"].tolist()
        assert all(close(other[path], plain[path]) for path in series)
        if "--certify" in options:
            assert np.all(other["diagnostics/error/v/x"] < 1e-14)
        if "double-double" in options:
            assert all(0 < np.max(np.abs(other[f"low/{path}"])) < 1e-15 for path in series)
    assert close(written("solve", "--method", "LSODA")["v/x"], plain["v/x"], 1e-8)


def test_all_31_digits_are_right_backward(written):
    """x = cos(t)/2 - sin(t)/4 and its velocity, with their low parts."""
    plain = ("--set", "c=0", "--set", "F=0", "--start", "0", "--precision", "double-double")
    found = written("solve", *plain)
    with mpmath.workdps(40):
        for t, *parts in zip(found["t"].tolist(), *(found[path].tolist() for path in LONG)):
            x, x_low, v, v_low = map(mpmath.mpf, parts)
            assert abs(x + x_low - (mpmath.cos(t) / 2 - mpmath.sin(t) / 4)) < 1e-29
            assert abs(v + v_low + mpmath.sin(t) / 2 + mpmath.cos(t) / 4) < 1e-29


@pytest.mark.exhaustive(keep=0.4)
def test_a_sweep_gives_what_solve_gives(written):
    ends = written("sweep", "--over", "c=0:0.5:3")
    samples = written("sweep", "--over", "c=0:0.5:3", "--outputs", "q,v,action")
    for member, c in enumerate((0.0, 0.25, 0.5)):
        alone = written("solve", "--set", f"c={c}")
        for path in ("q/x", "v/x", "diagnostics/action"):
            assert close(samples[path][member], alone[path])
            assert close(ends[path][member], alone[path][-1])
        assert ends["t_end"][member] == -3


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--stop", "1"), "the motion stops where it starts, at t = 1"),
        (("--stop", "2", "--step", "-0.1"), "leads away from stop = 2"),
        (("--step", "0"), "must be a positive number, not 0"),
    ],
)
def test_what_leads_nowhere_is_refused(written, capsys, options, message):
    assert main(["solve", "system.yaml", *options]) == 2
    assert message in capsys.readouterr().err


@pytest.mark.exhaustive(keep=0.25)
def test_bench_goes_backward_too(written, capsys):
    assert main(["bench", "system.yaml", "--methods", "taylor,DOP853", "--tolerances", "1e-9"]) == 0
    out = capsys.readouterr().out
    assert "t = 1 to -3" in out and "DOP853" in out
