"""The functions of ``run`` do what the commands do, and need neither click nor a terminal."""

import json
import subprocess
import sys
from contextlib import contextmanager

import numpy as np
import pytest

from lagrange_cli.run.bench import entries_of, rank_methods
from lagrange_cli.run.check import classify
from lagrange_cli.run.ensembles.ensemble import make_ensemble
from lagrange_cli.run.ensembles.members import Axis, Distribution, combine
from lagrange_cli.run.ensembles.sweep import sweep
from lagrange_cli.run.equations import as_written, derive
from lagrange_cli.run.monitor import Monitor
from lagrange_cli.run.motion import Motion, read_motion
from lagrange_cli.run.request import Request
from lagrange_cli.run.solve import solve
from lagrange_cli.run.verification import verify_system
from lagrange_cli.spec.spec import SolveDefaults
from lagrange_cli.store.find_target import find_target
from lagrange_cli.work_precision.measure import Rules
from tests.support.command import SYSTEMS, environment

PENDULUM = (SYSTEMS / "pendulum.yaml").read_bytes()
REQUEST = Request(times={"stop": "2"}, overrides={"l": "2"}, resume=True)


class Watcher:
    """A monitor that remembers what it was told, and stops the run when it is asked so many times."""

    def __init__(self, patience: float = float("inf")) -> None:
        self.stages: list[str] = []
        self.told: list[str] = []
        self.reached: list[float] = []
        self.asked, self.patience, self.cleared = 0, patience, False

    def monitor(self) -> Monitor:
        return Monitor(self.stage, lambda: self, self.told.append, self.interrupts)

    @contextmanager
    def stage(self, name: str):
        self.stages.append(name)
        yield

    @contextmanager
    def interrupts(self):
        yield self.interrupted

    def interrupted(self) -> bool:
        self.asked += 1
        return self.asked > self.patience

    def show(self, reached: float) -> None:
        self.reached.append(reached)

    def clear(self) -> None:
        self.cleared = True


def motion() -> Motion:
    return read_motion(PENDULUM, "pendulum.yaml", REQUEST)


@pytest.mark.parametrize(("asked", "empty"), [("h,multipliers,angular_momenta", 2), ("all", 0)])
def test_what_a_system_has_nothing_of_is_told_if_it_was_asked_for_by_name(tmp_path, asked, empty):
    options = SolveDefaults(stop=2.0, outputs=tuple(asked.split(",")))
    request, watcher = Request(options), Watcher()
    target = find_target(str(tmp_path / "a.h5"), force=False)
    solve(read_motion(PENDULUM, "pendulum.yaml", request), target, request, watcher.monitor())
    lines = [
        "pendulum: warning: output 'angular_momenta' is empty, as the file has no bodies",
        "pendulum: warning: output 'multipliers' is empty, as the file has no constraints",
    ]
    assert watcher.told == lines[:empty]


def test_a_motion_is_solved(tmp_path):
    watcher, target = Watcher(), find_target(str(tmp_path / "a.h5"), force=False, resume=True)
    solved = solve(motion(), target, REQUEST, watcher.monitor())
    assert solved.motion.values.parameters["l"] == 2
    assert (solved.outcome.t, solved.outcome.ending.status) == (2, "complete")
    assert watcher.told == [f"{target.shown}: there is nothing to resume; the run starts at the beginning"]
    assert {"import", "cache", "integrate", "write"} <= {*watcher.stages}
    assert watcher.cleared
    again = solve(motion(), target, REQUEST)
    assert again.outcome is None and again.start.finished.attributes["status"] == "complete"


def test_a_run_that_is_interrupted_says_how_far_it_came(tmp_path):
    request = Request(times={"stop": "1e9", "step": "100"})
    target = find_target(str(tmp_path / "a.h5"), force=False)
    watcher = Watcher(patience=2)
    solved = solve(read_motion(PENDULUM, "pendulum.yaml", request), target, request, watcher.monitor())
    assert solved.outcome.ending.status == "interrupted"
    assert 0 < solved.outcome.t < 1e9 and watcher.reached


def test_many_motions_are_solved(tmp_path):
    spec, values = motion().spec, np.linspace(0, 3, 4)
    axis = Axis("theta", "theta", values, {"theta": values})
    members = combine([axis], {"m": Distribution("uniform", 1, 2)}, 2, 7, {})
    assert [len(column) for column in members.columns.values()] == [8, 8]
    swept = sweep(
        make_ensemble(spec, members, Request(times={"stop": "1"})),
        find_target(str(tmp_path / "many.h5"), force=False),
        Request(),
    )
    assert (swept.outcome.status, swept.outcome.count("complete")) == ("complete", 8)


def test_a_system_is_classified_and_its_equations_written():
    spec = motion().spec
    assert not classify(spec).mechanics.depending
    derived = derive(spec)
    assert "theta_ddot" in as_written(derived, "text", "explicit", {})
    assert verify_system(derived, {}).agrees


@pytest.mark.exhaustive(keep=0.25)
def test_methods_are_ranked():
    ready, told = motion(), []
    entries = entries_of(["taylor"], [1e-6], 1)
    ranking = rank_methods(
        ready.spec, ready.values, "1", 1e-6, entries, Rules(1, 5.0), tell=lambda *what: told.append(what)
    )
    assert [result.status for result in ranking.results] == ["complete"]
    assert [done for done, *_ in told] == [0, 0]


@pytest.mark.exhaustive(keep=0.7)
def test_nothing_of_the_shell_is_imported():
    script = """if True:
        import importlib, json, pkgutil, sys, lagrange_cli.run as run
        for module in pkgutil.iter_modules(run.__path__):
            importlib.import_module(f"lagrange_cli.run.{module.name}")
        print(json.dumps([name for name in sys.modules if name.startswith(("click", "lagrange_cli.cli"))]))
    """
    run = subprocess.run(
        [sys.executable, "-c", script], env=environment(), stdout=subprocess.PIPE, text=True, check=True
    )
    assert json.loads(run.stdout) == []


@pytest.mark.parametrize("name", ["solve", "sweep"])
def test_an_output_that_is_being_written_is_refused(tmp_path, name):
    from lagrange_cli.errors import FileError

    target = find_target(str(tmp_path / "a.h5"), force=False)
    with target.claimed(), pytest.raises(FileError, match="is being written by another process"):
        if name == "solve":
            solve(motion(), target, Request())
        else:
            x = np.array([1.0, 2.0])
            members = combine([Axis("l", "l", x, {"l": x})], {}, None, 0, {})
            sweep(make_ensemble(motion().spec, members, Request(times={"stop": "1"})), target, Request())
