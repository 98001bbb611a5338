"""Windows and macOS as far as they can be imitated (``tests.support.platforms``): every command works."""

import os
import signal
import subprocess
import sys
import time
from types import SimpleNamespace

import h5py
import pytest

from lagrange_cli.cli.console import INTERRUPTED
from lagrange_cli.cli.main import COMMANDS, main
from lagrange_cli.limits import limit_time
from tests.support.command import ROOT, SYSTEMS, environment

PENDULUM, DOUBLE = str(SYSTEMS / "pendulum.yaml"), str(SYSTEMS / "double_pendulum.yaml")
LONG = ["solve", DOUBLE, "-o", "cut.h5", "--stop", "2000", "--samples", "1001"]
EVERYTHING = [
    *([command, "--help"] for command in COMMANDS),
    ["systems"],
    ["systems", "pendulum"],
    ["check", PENDULUM],
    ["equations", PENDULUM, "--verify"],
    ["solve", PENDULUM],
    ["solve", PENDULUM, "--force", "--outputs", "all"],
    ["solve", PENDULUM, "--resume", "--outputs", "all"],
    ["solve", PENDULUM, "-o", "radau.h5", "--method", "Radau", "--stop", "1"],
    ["solve", PENDULUM, "-o", "long.h5", "--precision", "double-double", "--stop", "0.1"],
    ["solve", PENDULUM, "-o", "certified.h5", "--certify", "--stop", "1"],
    ["solve", PENDULUM, DOUBLE, "--jobs", "2", "--force", "--stop", "1"],
    ["sweep", PENDULUM, "--over", "theta=0:1:9", "--stop", "1"],
    ["bench", PENDULUM, "--stop", "1", "--methods", "taylor,LSODA", "--tolerances", "1e-6"],
    ["section", PENDULUM, "--where", "theta", "--crossings", "5"],
    ["section", PENDULUM, "--every", "0.5", "--crossings", "5", "--force"],
    ["plot", "pendulum.h5"],
    ["plot", PENDULUM, "--terminal", "--stop", "1"],
    ["animate", PENDULUM, "-o", "pendulum.gif", "--stop", "0.1", "--speed", "0.5"],
    ["view", PENDULUM],
    ["schema"],
    *(["completion", shell] for shell in ("bash", "zsh", "fish")),
    ["cache", "info"],
    ["cache", "clear"],
    ["interrupted", *LONG, "--checkpoint", "0"],
    [*LONG, "--resume"],
    ["check", "."],
]


def on(system, *commands, cwd):
    """Commands on that platform, one after the other in one process."""
    words = [word for command in commands for word in (*command, "+")][:-1]
    return subprocess.run(
        [sys.executable, "-m", "tests.support.platforms", system, *words],
        cwd=cwd,
        env={**environment(), "PYTHONPATH": str(ROOT), "LAGRANGE_CACHE_DIR": str(cwd / "cache")},
        capture_output=True,
        text=True,
    )


@pytest.mark.exhaustive(keep=0)
@pytest.mark.parametrize("system", ["win32", "darwin"])
def test_every_command_does_its_job(system, tmp_path):
    at_work = {command[0] for command in EVERYTHING if "--help" not in command}
    assert at_work == {*COMMANDS, "interrupted"}
    run = on(system, *EVERYTHING, cwd=tmp_path)
    assert run.stderr.count("\n") == 2, run.stderr
    interrupted, refused = run.stderr.splitlines()
    assert run.returncode == INTERRUPTED and interrupted.startswith("double pendulum: interrupted at t = ")
    assert refused == "Error: . is a directory, not a system file"
    names = ("pendulum", "radau", "long", "certified", "cut", "double_pendulum", "pendulum_sweep",
             "pendulum_section")  # fmt: skip
    outputs, drawn = {f"{name}.h5" for name in names}, {"pendulum.png", "pendulum.gif", "pendulum.html"}
    assert {*os.listdir(tmp_path)} == {"cache", *outputs, *drawn}
    for name in outputs:
        with h5py.File(tmp_path / name) as file:
            assert file.attrs["status"] == "complete"


def test_where_no_signal_tells_of_the_time_a_thread_does(monkeypatch):
    """Windows has no SIGALRM."""
    monkeypatch.delattr(signal, "SIGALRM")
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            limit_time(0.01)
            while True:
                time.sleep(0.01)
    finally:
        signal.signal(signal.SIGINT, before)


def refuse(*arguments):
    raise ValueError("current limit exceeds maximum limit")


@pytest.mark.parametrize("module", [None, SimpleNamespace(), SimpleNamespace(
    RLIMIT_AS=0, RLIM_INFINITY=-1, getrlimit=lambda kind: (-1, -1), setrlimit=refuse)])  # fmt: skip
def test_where_memory_cannot_be_limited_that_is_said(module, monkeypatch, capsys):
    """Windows has no module ``resource``, and macOS refuses."""
    monkeypatch.setitem(sys.modules, "resource", module)
    monkeypatch.setenv("LAGRANGE_LIMITS", "memory=3000")
    assert main(["check", PENDULUM]) == 2
    assert "the memory of a process cannot be limited on this platform" in capsys.readouterr().err
