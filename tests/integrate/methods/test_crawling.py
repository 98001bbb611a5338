"""Motions whose steps become shorter without end: these are ended, and others are not."""

from __future__ import annotations

import math

import h5py
import numpy as np
import pytest

from lagrange_cli.cli.main import main
from lagrange_cli.integrate.methods import crawling
from lagrange_cli.integrate.methods.crawling import crawls, steps_to_mark
from lagrange_cli.native.state import CLOCK, Clock

SHAKEN = """
name: shaken
parameters: {a: 1}
coordinates: {x: {initial: 0}}
lagrangian: x_dot**2/2
generalized_forces: {x: sin(1/(t - a))}
"""
REACHED = "shaken: the denominator t - a reaches 0 in 1/(t - a) (line 6) at t = 1, where"


def ends_after(t, stop=math.inf, most=1 << 30):
    """The number of steps after which a motion is given up that has come to t(n) after n steps, or None."""
    clock, steps = np.zeros(CLOCK), 0
    while steps < most:
        steps += steps_to_mark(steps)
        clock[Clock.TIME] = t(steps)
        if crawls(clock, steps, abs(t(steps) - t(0)), stop):
            return steps
    return None


@pytest.mark.parametrize("start", [0.0, 1000.0, -5.0])
def test_a_way_that_converges_is_given_up(start):
    assert ends_after(lambda n: start + 1.0 - 1 / (1 + n / 6.0)) == crawling.ENOUGH
    assert ends_after(lambda n: start + 1.0 - 1 / math.sqrt(1 + n), 2.0 + start) is not None


def test_it_is_not_where_the_end_comes_before():
    assert ends_after(lambda n: 1.0 - 1 / (1 + n / 6.0), 1 - 1e-7) is None


@pytest.mark.parametrize(
    "way",
    [
        lambda n: n / 1e5,  # even steps
        lambda n: math.log(1 + n),  # a frequency that grows exponentially
        lambda n: math.sqrt(n),
        lambda n: min(n, 10**6) + max(0, n - 10**6) * 1e-7,  # fast from some time on
        lambda n: n - math.sin(n / 1e5) * 9e4,
    ],
)
def test_a_way_that_leads_on_is_not(way):
    assert ends_after(way) is None


@pytest.fixture
def few(monkeypatch, tmp_path):
    """So few steps are enough that a test is short."""
    monkeypatch.setattr(crawling, "FIRST", 1 << 10)
    monkeypatch.setattr(crawling, "ENOUGH", 1 << 13)
    (tmp_path / "shaken.yaml").write_text(SHAKEN)
    monkeypatch.chdir(tmp_path)


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("options", [[], ["--stop", "1"], ["--stop", "-3", "--start", "2"]])
def test_a_force_that_oscillates_ever_faster_ends_the_motion(few, options, capsys):
    assert main(["solve", "shaken.yaml", "--stop", "1.5", "--outputs", "q", *options]) == 4
    out, error = capsys.readouterr()
    assert error.startswith(REACHED) and " in 8192 steps" in out


def test_before_it_the_motion_is_complete(few):
    assert main(["solve", "shaken.yaml", "--stop", "0.9995", "--outputs", "q"]) == 0


@pytest.mark.exhaustive(keep=0.8)
def test_so_do_members_of_a_sweep(few, capsys):
    assert main(["sweep", "shaken.yaml", "--stop", "1.5", "--over", "a=1,2", "--jobs", "1"]) == 4
    told = REACHED.replace("shaken: ", "shaken: 1 of 2 members failed; member 0 (a = 1): ")
    assert capsys.readouterr().err.startswith(told)
    with h5py.File("shaken_sweep.h5") as file:
        assert file["message"][0].startswith(b"the motion changes faster and faster")
