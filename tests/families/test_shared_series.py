"""Taylor series of large systems that several threads share: the same bits, however many there are."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

from lagrange_cli.families import system as systems
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.native.families import chunks, jets, shared_work, strips, tiling
from tests.families.test_blocks import LATTICE, SYSTEMS, TOLERANCE
from tests.families.test_threads import Stopped, followed, ready, started
from tests.support.command import PATIENCE, environment, lagrange

NEVER = 2**60
RING = LATTICE.format(40, 9)
FAR = SYSTEMS["chain"](5).replace("u[0]**2", "u[0]**2 + sum(u[i] for i in range(N))**2/N")


@pytest.fixture(autouse=True)
def of_any_size(monkeypatch: pytest.MonkeyPatch) -> None:
    """Families stay families, and are shared, however few their members are."""
    monkeypatch.setattr(systems, "FEWEST", 0)
    monkeypatch.setattr(tiling, "PART", 1)
    monkeypatch.setattr(shared_work, "HEIGHT", 16)
    monkeypatch.setattr(strips, "WORTH", 0)
    share(monkeypatch, 0)


def share(monkeypatch: pytest.MonkeyPatch, least: int) -> None:
    """From how much work on it is shared, from here on."""
    for module in (tiling, shared_work):
        monkeypatch.setattr(module, "SHARED", least)


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("name", SYSTEMS)
@pytest.mark.parametrize("more", range(8))
@pytest.mark.parametrize("block", [2**8, 2**12])
@pytest.mark.parametrize("many", [0, 2**40])
def test_rounds_of_blocks(
    name: str, more: int, block: int, many: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Those of one thread that computes one order after the other, where a row or the whole ends, too."""
    text = SYSTEMS[name](more)
    monkeypatch.setattr(jets.SeriesJet, "many", many)
    monkeypatch.setattr(tiling, "STRIDES", 1)
    monkeypatch.setattr(tiling, "LONG", block)
    monkeypatch.setattr(tiling, "MANY", NEVER)
    share(monkeypatch, NEVER)
    alone = ready(text, "taylor", TOLERANCE)
    assert alone.machine.program.strips == 0
    monkeypatch.setattr(tiling, "MANY", 0)
    share(monkeypatch, 0)
    together = ready(text, "taylor", TOLERANCE)
    assert together.machine.program.strips == tiling.FLIGHT
    plain = followed(text, alone, 1, stop=1.0)
    for threads in (1, 2, 3):
        end = followed(text, together, threads, stop=1.0)
        assert (end.ending, end.steps) == (Ending.COMPLETE, plain.steps)
        assert end.state.tobytes() == plain.state.tobytes(), threads


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("method", ["taylor", "ias15", "DOP853"])
@pytest.mark.parametrize("count", [1, 2, 4])
@pytest.mark.parametrize("size", [(40, 9), (41, 8), (47, 25)])
def test_chunks_of_rows(
    method: str, count: int, size: tuple[int, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Sums at the ends of chunks have another order than without them, but one that stays the same."""
    text = LATTICE.format(*size)
    monkeypatch.setattr(chunks, "CHUNKS", count)
    monkeypatch.setattr(tiling, "MANY", NEVER)
    together = ready(text, method, TOLERANCE)
    ends = [followed(text, together, threads, stop=1.0) for threads in (1, 2, 3)]
    share(monkeypatch, NEVER)
    monkeypatch.setattr(strips, "WORTH", NEVER)
    alone = ready(text, method, TOLERANCE)
    plain = followed(text, alone, 1, stop=1.0)
    assert (alone.machine.program.strips, together.machine.program.strips > 0) == (0, True)
    for end in ends:
        assert (end.ending, end.steps) == (Ending.COMPLETE, plain.steps)
        assert end.state.tobytes() == ends[0].state.tobytes()
    assert np.max(np.abs(ends[0].state - plain.state)) < 1e-13


def test_what_all_members_act_on_has_no_chunks() -> None:
    """A force on all of them: its rows add to the same places."""
    assert ready(FAR, "ias15").machine.program.strips == 0


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("text", [SYSTEMS["chain"](3), RING])
def test_threads_end_with_the_motion(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Between two steps or by an exception, as many are left as were there before."""
    monkeypatch.setattr(tiling, "MANY", 0)
    found, before = started(monkeypatch), threading.active_count()
    prepared = ready(text, "taylor", TOLERANCE)

    def fail(t: float) -> bool:
        assert sum(one.is_alive() for one in found) == 2
        raise Stopped

    assert followed(text, prepared, 2, lambda t: True, 1e6).ending is Ending.INTERRUPTED
    assert len(found) == 1
    found.clear()
    with pytest.raises(Stopped):
        followed(text, prepared, 3, fail, 1e6)
    assert len(found) == 2
    assert threading.active_count() == before


KILLED = """
import os, signal, threading, time
from lagrange_cli.cli.main import run
from lagrange_cli.families import system
from lagrange_cli.native.families import shared_work, tiling
from lagrange_cli.store.output import Output

system.FEWEST = tiling.MANY = tiling.SHARED = shared_work.SHARED = 0
tiling.PART = 1
keep = Output.keep

def die():
    time.sleep(0.002)
    os.kill(os.getpid(), signal.SIGKILL)

def keep_and_die(self, checkpoint):
    keep(self, checkpoint)
    threading.Thread(target=die, daemon=True).start()

Output.keep = keep_and_die
run()
"""


@pytest.mark.exhaustive(keep=0.2)
def test_a_motion_goes_on_after_its_threads_were_killed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In the middle of a step of two threads; one thread continues it, to the same bytes. The summary says
    how many there were."""
    monkeypatch.setattr(tiling, "MANY", 0)
    monkeypatch.setattr(shared_work, "HEIGHT", 1024)
    (tmp_path / "ring.yaml").write_text(RING)
    command = ["solve", "ring.yaml", "--stop", "60", "--samples", "3", "--no-cache"]
    command += ["--method", "taylor", "--tolerance", str(TOLERANCE), "--outputs", "q,v"]
    kept = ["-o", "out.h5", "--checkpoint-count", "2"]
    run = subprocess.run(
        [sys.executable, "-c", KILLED, *command, *kept, "--threads", "2"],
        cwd=tmp_path, env=environment(), capture_output=True, timeout=PATIENCE,
    )  # fmt: skip
    assert run.returncode == -signal.SIGKILL
    assert lagrange(*command, *kept, "--threads", "1", "--resume", cwd=tmp_path).returncode == 0
    whole = lagrange(*command, "-o", "whole.h5", "--threads", "2", cwd=tmp_path)
    assert whole.returncode == 0
    assert "steps on 2 threads, method taylor" in whole.stdout
    assert (tmp_path / "out.h5").read_bytes() == (tmp_path / "whole.h5").read_bytes()
