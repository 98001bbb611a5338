"""``solve --jobs``: several systems at a time, each in a process of its own."""

import json
import os
import pickle
import signal
import subprocess
import sys
import time
from functools import partial

import h5py
import pytest

from lagrange_cli.cli.commands.solve import solve_system
from lagrange_cli.cli.console import INTERRUPTED, INTERRUPTION
from lagrange_cli.cli.jobs import run_side_by_side
from lagrange_cli.cli.output import Invocation
from lagrange_cli.run.request import Request
from lagrange_cli.spec.spec import SolveDefaults
from tests.support.command import PATIENCE, SYSTEMS, environment, lagrange_process, wait_until

NAMES = ("double_pendulum", "pendulum", "harmonic_oscillator")
"""The first one takes longest."""


@pytest.mark.exhaustive(keep=0.15)
def test_what_is_said_and_written_is_that_of_one_after_the_other(tmp_path):
    (tmp_path / "wrong.yaml").write_text("coordinates: [x]\n")
    systems = [*(SYSTEMS / f"{name}.yaml" for name in NAMES), "wrong.yaml", "nosuch.yaml", "-"]
    stdin = (SYSTEMS / "rotating_hoop.yaml").read_text(encoding="utf-8")
    told = []
    for jobs in ("1", "3"):
        (tmp_path / jobs).mkdir()
        (tmp_path / jobs / "wrong.yaml").write_text("coordinates: [x]\n")
        run = lagrange_process("solve", *systems, "--json", "--jobs", jobs, cwd=tmp_path / jobs, input=stdin)
        objects = [json.loads(line) for line in run.stdout.splitlines()]
        told.append(([{**each, "seconds": None} for each in objects], run.stderr, run.returncode))
    assert told[0] == told[1]
    objects, errors, status = told[1]
    assert status == 5 and errors.splitlines()[-1] == "Error: nosuch.yaml: no such file"
    assert [each["status"] for each in objects] == [*["complete"] * 3, "failed", "failed", "complete"]
    for name in (*NAMES, "stdin"):
        one, other = (tmp_path / jobs / f"{name}.h5" for jobs in ("1", "3"))
        assert one.read_bytes() == other.read_bytes()


@pytest.mark.exhaustive(keep=0.3)
def test_the_summaries_stay_in_their_order_where_processes_begin_anew(tmp_path):
    """On Windows and macOS a process is not copied: what it is given is pickled."""
    program = (
        "import multiprocessing, sys; from lagrange_cli.cli import jobs; "
        "from lagrange_cli.cli.main import main; jobs.CONTEXT = multiprocessing.get_context('spawn'); "
        "sys.exit(main(sys.argv[1:]))"
    )
    systems = [str(SYSTEMS / f"{name}.yaml") for name in NAMES[:2]]
    run = subprocess.run(
        [sys.executable, "-c", program, "solve", *systems, "--jobs", "2", "--set", "g=9.8"],
        cwd=tmp_path, env=environment(), capture_output=True, text=True,
    )  # fmt: skip
    assert (run.returncode, run.stderr) == (0, "")
    assert [line for line in run.stdout.splitlines() if line[0] != " "] == [
        "double pendulum: 2 degrees of freedom",
        "pendulum: 1 degree of freedom",
    ]


def test_a_request_can_be_sent_to_a_process():
    request = Request(SolveDefaults(samples=5), {"stop": "3"}, {"g": "1"}, checkpoint_count=5)
    asked = Invocation(request, as_json=True)
    action = partial(solve_system, asked=asked, demand=None)
    assert pickle.loads(pickle.dumps(action)).keywords == {"asked": asked, "demand": None}


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_an_interrupt_ends_all_and_keeps_what_was_computed(tmp_path, number):
    """As Ctrl-C does, for which the terminal tells the whole group; where the one that waits is killed, its
    processes end by themselves."""
    names = ("driven_damped_pendulum", "double_pendulum", "pendulum")
    process = subprocess.Popen(
        [sys.executable, "-m", "lagrange_cli", "solve", *(str(SYSTEMS / f"{name}.yaml") for name in names),
         "--jobs", "2", "--stop", "1e7", "--step", "100", "--checkpoint", "1000"],
        cwd=tmp_path, env=environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        start_new_session=True,
    )  # fmt: skip
    wait_until(lambda: len(list(tmp_path.glob(".*.h5.part"))) == 2, process)
    os.killpg(process.pid, number)
    out, err = process.communicate(timeout=PATIENCE)
    outputs = [tmp_path / f"{name}.h5" for name in names[:2]]
    if number == signal.SIGKILL:
        assert process.returncode == -number
        wait_until(lambda: all(path.exists() for path in outputs))
    else:
        assert process.returncode == 130, err
        assert out.count("interrupted; ") == 2 and len(err.splitlines()) == 2
        assert [line.split(":")[0] for line in err.splitlines()] == [
            "driven damped pendulum",
            "double pendulum",
        ]
    assert sorted(tmp_path.glob("*.h5")) == sorted(outputs)  # the third has not begun
    for path in outputs:
        with h5py.File(path) as file:
            assert file.attrs["status"] == "interrupted"


def interrupted(system, folder):
    """What ``solve`` does before there is anything to keep: it ends where the interrupt comes. Here that is
    in the first process, when the others have begun."""
    (folder / system).touch()
    until = time.monotonic() + PATIENCE
    while time.monotonic() < until:
        if system == "first" and len(list(folder.iterdir())) == 3:
            raise KeyboardInterrupt
        time.sleep(0.01)


def test_an_interrupt_that_cuts_all_short_is_told_of_once(tmp_path, capfd):
    names, action = ["first", "second", "last"], partial(interrupted, folder=tmp_path)
    assert run_side_by_side(names, action, 3, as_json=False, quiet=True) == INTERRUPTED
    assert len(list(tmp_path.iterdir())) == 3
    assert capfd.readouterr() == ("", f"{INTERRUPTION}\n")


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.skipif(sys.platform != "linux", reason="/proc tells which process is the child")
def test_a_process_that_is_killed_is_told_of(tmp_path):
    slow = ["--stop", "1e7", "--step", "100"]
    process = subprocess.Popen(
        [sys.executable, "-m", "lagrange_cli", "solve", str(SYSTEMS / "double_pendulum.yaml"), "nosuch.yaml",
         "--jobs", "2", *slow],
        cwd=tmp_path, env=environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    wait_until(lambda: list(tmp_path.glob(".*.h5.part")), process)
    with open(f"/proc/{process.pid}/task/{process.pid}/children", encoding="ascii") as file:
        child, *_ = map(int, file.read().split())  # in the order in which they were started
    os.kill(child, signal.SIGKILL)
    _, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 5
    assert err.splitlines()[0].endswith("double_pendulum.yaml: its process was killed by signal 9")
