"""``lagrange solve --resume --stop 200``: a finished or interrupted run that is followed farther."""

import json
import os
from pathlib import Path

import h5py
import numpy as np
import pytest

from lagrange_cli.cli.main import main
from lagrange_cli.integrate.methods.stepper import Stepper
from lagrange_cli.native.interface import Stop
from tests.cli.test_resume import Nervous, interrupted_after  # noqa: F401 - fixture
from tests.support.command import SYSTEMS

PENDULUM, DOUBLE = (str(SYSTEMS / f"{name}.yaml") for name in ("pendulum", "double_pendulum"))
DRIVEN, ATWOOD = (str(SYSTEMS / f"{name}.yaml") for name in ("driven_damped_pendulum", "atwood"))
MOTIONS = {
    "kink.yaml": "x_dot**2/2 - sqrt(x**2)",
    "free.yaml": "x_dot**2/2 - 3*x",
    "wall.yaml": "x_dot**2/2 - tanh(1e3*(x - 2))",
    "fall.yaml": "x_dot**2/2 + 1/x",
    "touch.yaml": "x_dot**2/2 - 200*max(0, x)**2.5",
}


@pytest.fixture(autouse=True)
def systems(folder):
    for name, lagrangian in MOTIONS.items():
        text = f"coordinates: {{x: {{initial: 0.3, velocity: 1}}}}\nlagrangian: {lagrangian}\n"
        Path(name).write_text(text, encoding="utf-8")


def solve(system: str, *options: str, output: str = "out.h5") -> int:
    return main(["solve", system, "-o", output, *options])


def content(name: str = "out.h5") -> bytes:
    return Path(name).read_bytes()


def at_once(system: str, *options: str) -> bytes:
    """What the whole run writes if nobody disturbs it."""
    assert solve(system, *options, "--quiet", output="whole.h5") == 0
    return content("whole.h5")


LONGER = {
    "the step is a whole part": (PENDULUM, [], "20", "30"),
    "the step is none": (PENDULUM, ["--step", "0.3"], "10", "30"),
    "chaos, in several chunks": (DOUBLE, ["--step", "1e-3"], "70", "150"),
    "everything is written": (DRIVEN, ["--outputs", "all", "--step", "0.1"], "50", "300"),
    "backward": (PENDULUM, ["--step", "0.1"], "-10", "-30"),
    "portable": (PENDULUM, ["--portable"], "10", "30"),
    "a series without end": (ATWOOD, ["--step", "0.1"], "1", "2"),
    "no series goes on": ("free.yaml", ["--step", "0.1"], "1.3", "30"),
    "kinks": ("kink.yaml", ["--step", "0.1"], "1.3", "30"),
}


@pytest.mark.exhaustive(keep=0.8)
@pytest.mark.parametrize(("system", "options", "stop", "later"), LONGER.values(), ids=LONGER)
def test_a_finished_run_goes_on_to_the_bytes_of_the_longer_one(system, options, stop, later, capsys):
    expected = at_once(system, *options, "--stop", later)
    assert solve(system, *options, "--stop", stop) == 0
    capsys.readouterr()
    assert solve(system, *options, "--stop", later, "--resume") == 0
    said = capsys.readouterr()
    assert "continued from t = " in said.out and "replaced" not in said.out and said.err == ""
    assert content() == expected
    assert solve(system, *options, "--stop", later, "--resume") == 0
    assert "is finished already" in capsys.readouterr().out


ANEW = {
    "a kink in the step over the end": (
        "kink.yaml",
        ["--step", "0.01", "--tolerance", "1e-8"],
        "-19.8713669184668",
        "-39.320969027292406",
    ),
    "a wall ahead": ("wall.yaml", ["--step", "0.1"], "1.3", "30"),
    "a wall at the end": ("wall.yaml", ["--step", "0.1"], "1.69", "30"),
    "a touch at the start": ("touch.yaml", ["--set", "x=0", "--step", "0.05"], "0.15", "0.3"),
    "31 digits": (PENDULUM, ["--precision", "double-double"], "1", "2"),
    "scipy": (PENDULUM, ["--method", "LSODA"], "1", "2"),
}


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize(("system", "options", "stop", "later"), ANEW.values(), ids=ANEW)
def test_where_nothing_is_kept_the_run_starts_at_the_beginning_and_says_so(
    system, options, stop, later, capsys
):
    expected = at_once(system, *options, "--stop", later)
    assert solve(system, *options, "--stop", stop) == 0
    assert solve(system, *options, "--stop", later, "--resume") == 0
    assert "the run starts at the beginning" in capsys.readouterr().err
    assert content() == expected


def test_samples_stay_as_far_apart_as_they_are(capsys):
    assert solve(DOUBLE, "--stop", "10", "--samples", "101") == 0
    assert solve(DOUBLE, "--stop", "25.05", "--resume") == 0
    assert "with a sample every 0.1 as before" in capsys.readouterr().out
    assert content() == at_once(DOUBLE, "--stop", "25.05", "--step", "0.1")
    before = content()
    assert solve(DOUBLE, "--stop", "50", "--samples", "101", "--resume") == 5
    error = capsys.readouterr().err
    assert "out.h5 has a sample every 0.1, not every 0.5" in error and "leave out --samples" in error
    assert content() == before


@pytest.mark.exhaustive(keep=0.35)
def test_a_run_that_was_interrupted_goes_on_to_another_end(interrupted_after):  # noqa: F811
    run = (DOUBLE, "--step", "0.01")
    expected = at_once(*run, "--stop", "1500")
    interrupted_after(2)
    assert solve(*run, "--stop", "1000") == 130
    assert solve(*run, "--stop", "1500", "--resume") == 130  # and once more, on the way
    interrupted_after(0)
    assert solve(*run, "--stop", "1500", "--resume") == 0
    assert content() == expected and sorted(os.listdir())[:2] == ["fall.yaml", "free.yaml"]


@pytest.mark.parametrize("late", [False, True])
def test_a_signal_in_the_last_step_loses_nothing(late, interrupted_after, monkeypatch):  # noqa: F811
    run = (DOUBLE, "--step", "0.01", "--stop", "3", "--outputs", "q,ledger")
    expected, fill = at_once(*run), Stepper.fill
    interrupted_after(10**6)

    def halted(self, wanted, first, last, interrupt, halt):
        """A step that is left because of a signal, or the one after it."""
        if last and Nervous.patience > 0:
            if late:
                self.space.advance(self._stop, np.full(8, np.nan), 0, 0, True, 1)
            monkeypatch.setattr(Nervous, "patience", 1)
            assert interrupt(self.space.t)
            return Stop.PAUSE, 0
        return fill(self, wanted, first, last, interrupt, halt)

    monkeypatch.setattr(Stepper, "fill", halted)
    assert solve(*run) == (0 if late else 130)
    if not late:
        interrupted_after(0)
        assert solve(*run, "--resume") == 0
    assert content() == expected


def test_a_shorter_run_is_refused(capsys):
    assert solve(PENDULUM) == 0
    before = content()
    for stop in ("10", "-10"):
        assert solve(PENDULUM, "--stop", stop, "--resume") == 5
        error = capsys.readouterr().err
        assert "out.h5 contains a run to t = 20: --resume continues to that time or a later one" in error
    assert content() == before


def test_a_motion_that_cannot_be_followed_needs_nothing_more(capsys):
    assert solve("fall.yaml", "--set", "x_dot=0", "--stop", "1") == 4
    assert solve("fall.yaml", "--set", "x_dot=0", "--stop", "2", "--resume") == 4
    assert "is finished already" in capsys.readouterr().out


@pytest.mark.parametrize("path", ["t", "q/theta", "diagnostics/h"])
def test_samples_that_were_changed_are_not_gone_on_with(path, capsys):
    assert solve(PENDULUM) == 0
    with h5py.File("out.h5", "r+") as file:
        file[path][7] += 1
    before = content()
    assert solve(PENDULUM, "--stop", "30", "--resume") == 5
    assert "--force" in capsys.readouterr().err and content() == before


def test_what_a_finished_run_keeps_is_little():
    assert solve(PENDULUM, "--samples", "100001") == 0
    with h5py.File("out.h5") as file:
        assert "checkpoint" not in file and json.loads(file.attrs["run"])["count"] == 100001
        data = sum(file[path].size * 8 for path in ("t", "q/theta", "v/theta", "diagnostics/h"))
    assert len(content()) < 2 * 5 / 4 * data


def test_sweeps_and_certified_runs_are_not_extended_and_not_lost(capsys):
    swept = ["sweep", PENDULUM, "--over", "m=1,2", "-o", "swept.h5", "--quiet"]
    sampled = ["sweep", PENDULUM, "--over", "m=1,2", "-o", "sampled.h5", "--quiet", "--outputs", "q"]
    assert main(swept) == 0 == main(sampled)
    assert solve(PENDULUM, "--certify") == 0
    names = ["swept.h5", "sampled.h5", "out.h5"]
    before = [content(name) for name in names]
    for run, kind in (
        (swept, "swept.h5 contains a sweep to t = 20"),
        (sampled, "sampled.h5 contains a sweep to t = 20"),
        (["solve", PENDULUM, "-o", "out.h5"], "out.h5 contains a run with --certify to t = 20"),
    ):
        capsys.readouterr()
        assert main([*run, "--resume", "--stop", "200"]) == 5
        error = capsys.readouterr().err
        assert f"{kind}, which cannot be extended: " in error and "--force in place of --resume" in error
    assert solve(PENDULUM, "--certify", "--resume", "--stop", "200") == 2
    assert "--force in place of --resume" in capsys.readouterr().err
    assert [content(name) for name in names] == before
