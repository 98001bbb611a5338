"""Chunks are handed over in another thread, while the next one is computed."""

import subprocess
import sys
import threading

import numpy as np
import pytest

from lagrange_cli import GraphAlgebra, Times, build_model, derive, prepare, read_spec, resolve_values
from lagrange_cli.integrate.arrays import chunk_size
from lagrange_cli.integrate.background import Pipelined
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.run import integrate
from tests.support.command import SYSTEMS

SPEC = read_spec((SYSTEMS / "pendulum.yaml").read_bytes(), "pendulum.yaml")
COUNT = 4 * chunk_size(4) + 5
"""Samples of a run with several chunks and a part of one."""


def run_of(method, emit):
    tolerance, stop = (2.0**-52, 2.0) if method == "taylor" else (1e-6, 2.0)
    outputs = frozenset({"q", "v", "p", "h"})
    prepared = prepare(
        derive(build_model(SPEC, GraphAlgebra())),
        Compilation(method=method, tolerance=tolerance, outputs=outputs),
    )
    times = Times(0.0, stop, COUNT, stop / (COUNT - 1))
    return integrate(prepared, resolve_values(SPEC), times, emit, lambda: False)


@pytest.mark.exhaustive(keep=0.4)
@pytest.mark.parametrize("method", ["taylor", "DOP853"])
def test_a_chunk_stays_as_it_is_while_the_next_one_is_computed(method, monkeypatch):
    """Each chunk is copied when it is handed over, and again as late as it may be used."""
    early, late, computed = [], [], threading.Event()

    def copies(chunk):
        return {path: series.copy() for path, series in chunk.items()}

    def emit(chunk):
        early.append(copies(chunk))
        computed.wait(10.0)  # the next chunk is there, and waits for this one
        computed.clear()
        late.append(copies(chunk))

    wait = Pipelined.wait

    def noticed(self):
        computed.set()
        wait(self)

    monkeypatch.setattr(Pipelined, "wait", noticed)
    run_of(method, emit)
    assert len(early) > 3
    assert sum(len(chunk["t"]) for chunk in late) == COUNT
    for one, other in zip(early, late):
        for path in one:
            np.testing.assert_array_equal(one[path], other[path])


def test_what_fails_while_a_chunk_is_handed_over_ends_the_run():
    def emit(chunk):
        raise OSError("no space")

    with pytest.raises(OSError, match="no space"):
        run_of("taylor", emit)


def test_calls_behind_are_made_in_order_and_one_at_a_time():
    running, done = threading.Lock(), []

    def call(number):
        assert running.acquire(blocking=False)
        done.append(number)
        running.release()

    with Pipelined() as behind:
        for number in range(50):
            behind.call(lambda number=number: call(number))
    assert done == list(range(50))


def test_the_error_of_the_caller_is_not_hidden_by_one_behind():
    def fail():
        raise ValueError("behind")

    with pytest.raises(KeyError), Pipelined() as behind:
        behind.call(fail)
        raise KeyError


@pytest.mark.exhaustive(keep=0.6)
def test_the_interpreter_waits_for_work_that_nobody_has_waited_for():
    """Better code that is compiled for a run which ends before it is ready: LLVM crashed at exit."""
    script = """
from time import sleep
from lagrange_cli.integrate.background import Work

def late():
    sleep(0.3)
    print("done", flush=True)

Work(late)
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout, done.stderr) == (0, "done\n", "")
