"""A step that is divided very often for its integrals is left when a signal comes, and taken anew later."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import lagrange_cli.integrate.methods.stepper as stepping
import lagrange_cli.integrate.workspace as workspace
from lagrange_cli.cli.main import main
from lagrange_cli.integrate.hearing import ENDING, _steppers, asked_by
from lagrange_cli.native.guards import HALTED, INFO
from lagrange_cli.native.interface import Stop
from tests.support.command import PATIENCE, environment, wait_until

SHAKEN = """
sizes: {N: 12}
coordinates: {"x[i in range(N)]": {initial: 0.1*i + 0.01}}
lagrangian: sum(x_dot[i]**2/2 for i in range(N)) + cos(3000000*t)
  + sum(cos(x[i] - x[j]) for i in range(N) for j in range(i))
solve: {stop: 1, samples: 2}
"""
"""The action of each step takes a hundred thousand parts, half a minute in all."""
FREE = """
coordinates: {x: {initial: 0, velocity: 1}}
lagrangian: x_dot**2/2 - cos(20*t)
solve: {stop: 9, samples: 99}
"""
"""One step, of which the action takes many parts."""


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.skipif(os.name != "posix", reason="no signals")
def test_ctrl_c_ends_a_step_of_many_parts(tmp_path):
    (tmp_path / "a.yaml").write_text(SHAKEN)
    command = [sys.executable, "-m", "lagrange_cli", "solve", "a.yaml", "--outputs", "all"]
    running = subprocess.Popen(
        command, cwd=tmp_path, env=environment(), stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    try:
        wait_until((tmp_path / ".a.h5.part").exists, running)
        time.sleep(0.3)  # so that it has very probably begun; if it has not, it stops before
        running.send_signal(signal.SIGINT)
        _, errors = running.communicate(timeout=PATIENCE)
    finally:
        running.kill()
    assert running.returncode == 130 and "interrupted at t = 0" in errors


@pytest.mark.exhaustive(keep=0.3)
@pytest.mark.parametrize("precision", ["double", "double-double"])
def test_a_step_that_was_left_is_taken_anew_with_the_same_bits(tmp_path, monkeypatch, precision):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.yaml").write_text(FREE)
    run = ["solve", "a.yaml", "--outputs", "q,v,action,ledger", "--precision", precision, "--quiet", "-o"]
    assert main([*run, "whole.h5"]) == 0
    advance, left = workspace.Workspace.advance, []

    def halted(self: workspace.Workspace, *given: float) -> Stop:
        self.info[HALTED] = not left or left[-1][1] > 0  # at every other call
        stop = advance(self, *given)
        left.append((stop, int(self.info[1])))
        return stop

    monkeypatch.setattr(workspace.Workspace, "advance", halted)
    monkeypatch.setattr(stepping, "HEEDED", 0)
    assert main([*run, "left.h5"]) == 0
    assert (Stop.PAUSE, 0) in left
    assert (tmp_path / "left.h5").read_bytes() == (tmp_path / "whole.h5").read_bytes()


def test_a_signal_asks_all_that_run_and_nothing_is_left_behind():
    infos = [np.zeros(INFO, dtype=np.int64) for _ in range(2)]
    handler = signal.signal(signal.SIGINT, lambda *given: None)
    try:
        with asked_by(infos[0]), asked_by(infos[1]):
            signal.raise_signal(signal.SIGINT)
            while not all(one[HALTED] for one in infos):
                time.sleep(0.001)
        assert signal.SIGINT in ENDING and not _steppers
        assert signal.set_wakeup_fd(-1) == -1
    finally:
        signal.signal(signal.SIGINT, handler)


def test_where_python_refuses_to_tell_of_signals_nothing_else_changes(monkeypatch):
    """On Windows, before Python 3.12, no pipe can be made one that does not block."""
    monkeypatch.delattr(os, "set_blocking")
    with asked_by(np.zeros(INFO, dtype=np.int64)):
        pass
    assert signal.set_wakeup_fd(-1) == -1
