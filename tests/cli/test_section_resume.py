"""Sections that are interrupted, or killed, go on to the bytes of uninterrupted ones."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

import lagrange_cli.cli.commands.section as command
import lagrange_cli.integrate.ensemble.lanes as lanes
from lagrange_cli.cli.main import main
from lagrange_cli.integrate.ensemble.members import Members
from lagrange_cli.run.interrupts import Interrupts
from lagrange_cli.store.checkpoint import Checkpoint
from tests.cli.test_section import FLOOR
from tests.support.command import SYSTEMS, environment, lagrange, lagrange_process, wait_until

HENON = (SYSTEMS / "henon_heiles.yaml").read_text()
CASES = {
    "a surface, in a lane": (HENON, ("--where", "x")),
    "a period, in a lane": (HENON, ("--every", "40/7")),
    "backward, in a lane": (HENON, ("--where", "x", "--stop", "-1e7")),
    "a surface, with events": (FLOOR, ("--where", "x", "--direction", "either")),
    "a period, with events": (FLOOR, ("--every", "0.3")),
    "by steps on rates": (FLOOR, ("--where", "x", "--direction", "either", "--method", "DOP853")),
    "in double-double": (FLOOR, ("--where", "x", "--direction", "either", "--precision", "double-double")),
}
WANTED, MANY, ENOUGH = 3 * 10**5, 10**6, 300


class Impatient(Interrupts):
    """Interrupts a run when it has been asked some times, which it is at every event."""

    most = 5

    def __init__(self) -> None:
        super().__init__()
        self._asked = 0

    def __call__(self) -> bool:
        self._asked += 1
        return self._asked >= self.most


def contents(path: Path, count: int) -> dict[str, bytes]:
    """The first crossings in a file, by dataset."""
    found: dict[str, bytes] = {}

    def take(name: str, item: object) -> None:
        if isinstance(item, h5py.Dataset) and name != "checkpoint":
            found[name] = item[:count].tobytes()

    with h5py.File(path) as file:
        file.visititems(take)
    return found


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("case", CASES)
def test_a_motion_goes_on_with_the_same_bits_however_often_it_is_interrupted(
    case, tmp_path, monkeypatch, capsys
):
    system, cut = CASES[case]
    monkeypatch.chdir(tmp_path)
    Path("a.yaml").write_text(system)
    monkeypatch.setattr(command, "Interrupts", Impatient)
    asked = ["section", "a.yaml", *cut, "--json"]
    found, steps, resumed = 0, 0, []
    lanes = "lane" in case
    wanted = WANTED if lanes else WANTED // 10
    monkeypatch.setattr(Impatient, "most", 5 if lanes else 150)
    while found < ENOUGH or len(resumed) < 3:
        assert main([*asked, "--crossings", str(wanted), "-o", "cut.h5", "--resume"]) == 130
        said = capsys.readouterr()
        told = json.loads(said.out)
        assert "--resume" in said.err and told["steps"] >= steps and told["crossings"] >= found
        found, steps = told["crossings"], told["steps"]
        resumed.append(told["resumed_from"])
        assert len(resumed) < 200
    assert resumed[0] is None and resumed[-1] > 0
    monkeypatch.undo()
    monkeypatch.chdir(tmp_path)
    assert main([*asked, "--crossings", str(found + 9), "-o", "whole.h5"]) == 0
    assert contents(tmp_path / "cut.h5", found) == contents(tmp_path / "whole.h5", found)


@pytest.mark.parametrize("method", ["taylor", "DOP853"])
def test_ledgers_at_crossings_between_impacts_close(method, tmp_path, monkeypatch):
    """Compiled code tells of many crossings and impacts at once; each of these is before some of the
    crossings, and behind others."""
    monkeypatch.chdir(tmp_path)
    Path("a.yaml").write_text(FLOOR)
    cut = "--where", "x", "--direction", "either", "--method", method
    assert main(["section", "a.yaml", *cut, "--crossings", "200", "-o", "a.h5"]) == 0
    with h5py.File("a.h5") as file:
        ledger, velocity = (file[f"{name}/y"][:] for name in ("diagnostics/ledger/p", "v"))
    assert np.ptp(velocity) > 1.0 and np.abs(ledger).max() < 1e-10


@pytest.mark.exhaustive(keep=0.35)
def test_a_lane_that_was_interrupted_and_does_not_bring_its_motion_to_the_end(tmp_path, monkeypatch, capsys):
    """The motion is then followed by itself, from its start, whatever was kept of the lane."""
    asked = ["section", str(SYSTEMS / "driven_damped_pendulum.yaml"), "--every", "2*pi/Omega"]
    asked += ["--set", "A=1.1", "--crossings", "3000", "-o"]  # A: such that the lane gives up on the way
    monkeypatch.chdir(tmp_path)
    alone = []
    follow, started = lanes.LanesMethod._alone, lanes.started

    def counted(self: lanes.LanesMethod, *given: Any) -> bool:
        alone.append(given)
        return follow(self, *given)

    def under_way(members: Members, count: int) -> list[threading.Thread]:
        workers = started(members, count)
        while not members.steps and workers[0].is_alive():
            pass
        return workers

    monkeypatch.setattr(lanes.LanesMethod, "_alone", counted)
    assert main([*asked, "whole.h5"]) == 0
    assert len(alone) == 1
    with monkeypatch.context() as patched:
        patched.setattr(lanes, "started", under_way)
        patched.setattr(command, "Interrupts", Impatient)
        patched.setattr(Impatient, "most", 1)
        assert main([*asked, "cut.h5", "--resume"]) == 130
    assert main([*asked, "cut.h5", "--resume"]) == 0, capsys.readouterr().err
    assert (tmp_path / "cut.h5").read_bytes() == (tmp_path / "whole.h5").read_bytes()


@pytest.mark.exhaustive(keep=0.75)
def test_of_many_motions_those_that_have_ended_are_not_followed_again(tmp_path, monkeypatch, capsys):
    class Later(Interrupts):
        def __enter__(self) -> Interrupts:
            self.asked = 0
            return self

        def __exit__(self, *given: object) -> None:
            pass

        def __call__(self) -> bool:
            self.asked += 1
            return self.asked > 3

    monkeypatch.chdir(tmp_path)
    Path("a.yaml").write_text(HENON)
    asked = [
        "section",
        "a.yaml",
        "--where",
        "x",
        "--over",
        "y=-0.1:0.3:100",
        "--crossings",
        "300",
        "--jobs",
        "1",
    ]
    assert main([*asked, "-o", "whole.h5"]) == 0
    monkeypatch.setattr(command, "Interrupts", Later)
    capsys.readouterr()
    for _ in range(200):
        if main([*asked, "-o", "cut.h5", "--resume"]) == 0:
            break
    said = capsys.readouterr().out
    assert "30000 crossings by 100 members" in said
    assert (tmp_path / "cut.h5").read_bytes() == (tmp_path / "whole.h5").read_bytes()
    assert main([*asked, "-o", "cut.h5", "--resume"]) == 0
    assert "cut.h5 is finished already: 30000 crossings by 100 members" in capsys.readouterr().out


DAMAGED = {
    "another size": lambda arrays: arrays | {"motion/lanes": arrays["motion/lanes"][:-1]},
    "too many": lambda arrays: arrays | {"motion/states": np.zeros((5, MANY + 1))},
    "no states": lambda arrays: {name: one for name, one in arrays.items() if name != "motion/states"},
    "of no kind": lambda arrays: {name: one for name, one in arrays.items() if name != "motion/lanes"},
    "a time that is none": lambda arrays: {
        "motion/memory": np.zeros(3), "motion/snapshot": np.full(4, np.nan), "motion/counts": np.zeros(2),
        "motion/t": np.zeros(0), "motion/low": np.zeros(0), "motion/states": np.zeros((0, 0)),
    },
    "another memory": lambda arrays: {
        "motion/memory": np.zeros(3), "motion/snapshot": np.zeros(4), "motion/counts": np.zeros(2),
        "motion/t": np.zeros(0), "motion/low": np.zeros(0), "motion/states": np.zeros((0, 0)),
    },
}  # fmt: skip


@pytest.mark.exhaustive(keep=0.25)
def test_a_motion_that_was_killed_is_neither_lost_nor_mistaken(tmp_path):
    (tmp_path / "a.yaml").write_text(HENON)
    asked = ("section", "a.yaml", "--where", "x", "-o", "a.h5")
    begun = [sys.executable, "-m", "lagrange_cli", *asked, "--crossings", str(MANY), "--checkpoint", "0"]
    running, kept = subprocess.Popen(begun, cwd=tmp_path, env=environment()), tmp_path / ".a.h5.checkpoint"
    try:
        wait_until(kept.exists, running)
    finally:
        running.send_signal(signal.SIGKILL)
        running.wait()
    again = lagrange(*asked, cwd=tmp_path)
    assert again.returncode == 5 and "--resume continues it, --force starts again" in again.stderr
    other = lagrange(*asked, "--crossings", "9", "--resume", cwd=tmp_path)
    assert other.returncode == 5 and "with another number of --crossings" in other.stderr
    whole = Checkpoint.unpack(bytearray(kept.read_bytes()), "a.h5")
    for damage in DAMAGED.values():
        kept.write_bytes(Checkpoint(whole.head, damage(dict(whole.arrays))).pack())
        refused = lagrange(*asked, "--crossings", str(MANY), "--resume", cwd=tmp_path)
        assert refused.returncode == 5 and "damaged" in refused.stderr and "Traceback" not in refused.stderr


@pytest.mark.exhaustive(keep=0.65)
def test_the_crossings_of_one_motion_as_a_table(tmp_path):
    (tmp_path / "a.yaml").write_text(HENON)
    asked = ("section", "a.yaml", "--where", "x", "--crossings", "5")
    streamed = lagrange_process(*asked, "-o", "-", "--format", "csv", cwd=tmp_path)
    assert streamed.returncode == 0 and "5 crossings" in streamed.stderr
    assert lagrange(*asked, "-o", "a.csv", cwd=tmp_path).returncode == 0
    assert (tmp_path / "a.csv").read_text() == streamed.stdout
    assert lagrange(*asked, "-o", "a.h5", cwd=tmp_path).returncode == 0
    header, *rows = streamed.stdout.splitlines()
    assert header == "t,x,y,x_dot,y_dot,p_x,p_y,h"
    with h5py.File(tmp_path / "a.h5") as file:
        paths = ("t", "q/x", "q/y", "v/x", "v/y", "diagnostics/p/x", "diagnostics/p/y", "diagnostics/h")
        known = np.column_stack([file[path][()] for path in paths])
    assert np.array_equal([[float(x) for x in row.split(",")] for row in rows], known)
    for more, said in (
        (("--over", "y=0,0.1"), "sections of many motions are written as HDF5"),
        (("--resume",), "--resume needs an HDF5 output"),
    ):
        refused = lagrange(*asked, "-o", "b.csv", *more, cwd=tmp_path)
        assert refused.returncode == 2 and said in refused.stderr


@pytest.mark.parametrize("more", [(), ("--over", "y0=0.1,0.2")], ids=["one motion", "many"])
def test_a_finished_section_is_told_as_it_was_taken(tmp_path, more):
    asked = "section", str(SYSTEMS / "henon_heiles.yaml"), "--where", "x", "--crossings", "3", *more
    first, again = (json.loads(lagrange(*asked, "--resume", "--json", cwd=tmp_path).stdout) for _ in range(2))
    assert {*again} < {*first}
    assert {name for name in again if again[name] != first[name]} == {"seconds"}
    assert (again["where"], again["direction"], again["members"]) == ("x", "rising", 2 if more else 1)
