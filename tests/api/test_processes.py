"""Results of sweeps in other processes, and processes that are forked: each has what it needs."""

import copy
import gc
import os
import pickle
import shutil
import signal
import threading

import numpy as np
import pytest

import lagrange_cli as lagrange
from lagrange_cli.api.folder import Folder
from lagrange_cli.api.kept import WORKING
from tests.support.command import SYSTEMS

PENDULUM = SYSTEMS / "pendulum.yaml"
FORKS = pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork")
PATIENCE = 60


def swept(**more):
    return lagrange.sweep(PENDULUM, over={"l": [1, 2]}, stop=1, jobs=1, **more)


@pytest.mark.parametrize("again", [lambda one: pickle.loads(pickle.dumps(one)), copy.deepcopy])
def test_a_copy_of_a_sweep_outlives_it(again):
    found = swept()
    expected, read, path = found.q["theta"].copy(), found.v["theta"], found.path
    other = again(found)
    del found
    gc.collect()
    assert not path.exists() and other.path.exists() and other.path != path
    assert np.array_equal(other.q["theta"], expected) and np.array_equal(other.v["theta"], read)
    assert not other.q["theta"].flags.writeable and other.dims["l"].tolist() == [1, 2]
    path = other.path
    del other
    gc.collect()
    assert not path.exists()


def test_a_file_that_was_replaced_is_not_taken_for_the_one_that_was_opened(folder):
    lagrange.solve(PENDULUM, stop=1).save("run.h5")
    loaded = lagrange.load("run.h5")
    read = loaded.q["theta"]
    lagrange.solve(PENDULUM, stop=1, set={"l": 2}).save("run.h5", force=True)
    assert loaded.q["theta"] is read
    for use in (lambda: loaded.v["theta"], lambda: loaded.save("copy.h5"), loaded.to_xarray):
        with pytest.raises(lagrange.FileError, match=r"run\.h5 has changed since it was opened"):
            use()
    os.remove("run.h5")
    with pytest.raises(lagrange.FileError, match=r"run\.h5: no such file"):
        loaded.save("copy.h5")


def test_a_loaded_file_stays_the_same_in_another_folder(folder, monkeypatch):
    lagrange.solve(PENDULUM, stop=1).save("run.h5")
    loaded = lagrange.load("run.h5")
    (folder / "other").mkdir()
    monkeypatch.chdir("other")
    assert loaded.q["theta"].shape == (101,)


def ended_well(child):
    """Whether a forked process ends by itself, with status 0."""
    _, status = os.waitpid(child, 0)
    return status == 0


@FORKS
@pytest.mark.filterwarnings("ignore:.*multi-threaded:DeprecationWarning")
def test_a_process_that_is_forked_while_another_thread_works_can_work():
    lagrange.solve(PENDULUM, stop=1)  # what is imported at the first call has locks of its own
    begun, waiting = threading.Event(), threading.Event()

    def work():
        with WORKING:
            begun.set()
            waiting.wait(0.2)

    other = threading.Thread(target=work)
    other.start()
    begun.wait()
    child = os.fork()
    if child == 0:
        signal.alarm(PATIENCE)
        try:
            lagrange.solve(PENDULUM, stop=1, set={"l": 1.25})
        except BaseException:
            os._exit(1)
        os._exit(0)
    other.join()
    assert ended_well(child)
    assert lagrange.solve(PENDULUM, stop=1, set={"l": 1.25}).status == "complete"


@FORKS
@pytest.mark.filterwarnings("ignore:.*multi-threaded:DeprecationWarning")
def test_a_process_that_was_forked_removes_no_folder_of_the_other():
    one = Folder(b"content")
    child = os.fork()
    if child == 0:
        one.remove()
        os._exit(0)
    assert ended_well(child)
    assert one.result.read_bytes() == b"content"


def test_ctrl_c_leaves_no_folder(monkeypatch):
    one, remove, calls = Folder(b"content"), shutil.rmtree, []

    def interrupted(*arguments, **options):
        calls.append(arguments)
        if len(calls) == 1:
            raise KeyboardInterrupt
        remove(*arguments, **options)

    monkeypatch.setattr(shutil, "rmtree", interrupted)
    with pytest.raises(KeyboardInterrupt):
        one.remove()
    assert not one.path.exists()
