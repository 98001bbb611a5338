"""``lagrange solve --resume``: runs that are cut off in every way, and what they come to."""

import errno
import json
import os
import random
import resource
import signal
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import lagrange_cli.cli.commands.solve as solving
import lagrange_cli.cli.commands.sweep as sweeping
from lagrange_cli.cli.main import main
from lagrange_cli.errors import FileError
from lagrange_cli.integrate.ensemble.lanes import LanesMethod
from lagrange_cli.integrate.ensemble.one_by_one import OneByOne
from lagrange_cli.integrate.methods import stepper, taylor
from lagrange_cli.run.interrupts import Interrupts
from lagrange_cli.store.find_target import find_target
from lagrange_cli.store.output import Output
from lagrange_cli.store.resume import find_earlier, read_output
from tests.fuzzing.soak import OFTEN, Scene, disturbed, undisturbed
from tests.support.command import PATIENCE, ROOT, SYSTEMS, environment, lagrange_process, wait_until

DOUBLE = str(SYSTEMS / "double_pendulum.yaml")
RUN = (DOUBLE, "--stop", "800", "--samples", "70001", "-o", "out.h5")
"""A run that takes a while, with samples in two chunks of the file."""
CONTINUED = ("--outputs", "q,v,p,h,ledger,action,positions")


class Nervous(Interrupts):
    """Interrupts the run when it is asked for the ``patience``-th time."""

    patience = 0

    def __call__(self) -> bool:
        type(self).patience -= 1
        return type(self).patience <= 0


@pytest.fixture
def interrupted_after(monkeypatch):
    """A function that lets the next runs be interrupted after so many looks; after 0, never."""

    def after(patience: int) -> None:
        monkeypatch.setattr(Nervous, "patience", patience)
        monkeypatch.setattr(solving, "Interrupts", Nervous if patience else Interrupts)

    return after


def solve(*arguments: str) -> int:
    return main(["solve", *arguments])


UNDISTURBED: dict[tuple[str, ...], bytes] = {}


def whole(folder: Path, *arguments: str) -> bytes:
    """What the run writes if nothing disturbs it, computed once for all tests."""
    if arguments not in UNDISTURBED:
        command = arguments if arguments[0] == "sweep" else ("solve", *arguments)
        assert main([*command, "-o", "whole.h5", "--quiet"]) == 0
        UNDISTURBED[arguments] = (folder / "whole.h5").read_bytes()
        (folder / "whole.h5").unlink()
    return UNDISTURBED[arguments]


KILLED = """
import os, signal, sys
from lagrange_cli.cli.main import run
from lagrange_cli.integrate.methods import stepper, taylor
from lagrange_cli.store.output import Output

stepper.POLL_SECONDS = 0.002  # so that there are checkpoints between any two writes of samples
size, keep = int(sys.argv.pop(1)), Output.keep

def keep_and_die(self, checkpoint):
    keep(self, checkpoint)
    if checkpoint.head["reached"] > 0 and os.path.getsize(".out.h5.part") >= size:
        os.kill(os.getpid(), signal.SIGKILL)

Output.keep = keep_and_die
run()
"""


def killed(folder: Path, *arguments: str, size: int = 0, every: int = 1) -> list[str]:
    """What a run leaves that is killed as soon as it has written a checkpoint and so many bytes."""
    arguments = arguments if arguments[0] == "sweep" else ("solve", *arguments)
    command = [sys.executable, "-c", KILLED, str(size), *arguments, "--checkpoint-count", str(every)]
    run = subprocess.run(command, cwd=folder, env=environment(), stdout=subprocess.DEVNULL, timeout=PATIENCE)
    assert run.returncode == -signal.SIGKILL
    return sorted(os.listdir(folder))


LONG = (DOUBLE, "--stop", "8000", "--samples", "80001", "-o", "out.h5")
LEFT = [".out.h5.checkpoint", ".out.h5.lock", ".out.h5.part"]


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("patience", [1, 2, 3])
def test_what_ctrl_c_has_ended_goes_on_to_the_same_bytes(folder, interrupted_after, patience, capsys):
    run = (*RUN, *CONTINUED)
    expected = whole(folder, *run)
    interrupted_after(patience)
    assert solve(*run) == 130
    with h5py.File("out.h5") as file:
        assert file.attrs["status"] == "interrupted"
        reached = len(file["t"])
        assert 0 < reached < 70001
    for group in (None, "q", "diagnostics/ledger/p", "positions"):
        with xarray.open_dataset("out.h5", group=group, engine="h5netcdf") as data:
            assert data.sizes["t"] == reached
    interrupted_after(2)
    assert solve(*run, "--resume") == 130
    interrupted_after(0)
    assert solve(*run, "--resume", "--json") == 0
    assert (folder / "out.h5").read_bytes() == expected
    answer = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert 0 < answer["resumed_from"] < answer["t"] == 800
    assert os.listdir(folder) == ["out.h5"]


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize(
    "method",
    [
        ("--stop", "-800"),
        ("--stop", "-200", "--method", "ias15"),
        ("--stop", "-200", "--method", "DOP853"),
        ("--stop", "-200", "--method", "Radau", "--tolerance", "1e-6"),
    ],
)
def test_a_run_backward_in_time_goes_on_to_the_same_bytes(folder, interrupted_after, method):
    run = (DOUBLE, *method, "--step", "0.01", "-o", "out.h5", *CONTINUED)
    expected = whole(folder, *run)
    interrupted_after(2)
    assert solve(*run) == 130
    interrupted_after(0)
    assert solve(*run, "--resume") == 0
    assert (folder / "out.h5").read_bytes() == expected
    with h5py.File("out.h5") as file:
        assert file["t"][-1] == float(method[1]) and np.all(np.diff(file["t"][:]) < 0)


CREEPING = """
parameters: {F: 2, e: 1e-7}
coordinates: {x: {initial: 0}, y: {initial: 0}}
masses: {puck: 1}
positions: {puck: [x, y]}
potential: 0
dissipation: F*norm((x_dot, y_dot))
forces: {puck: "((F + e)*cos(t), (F + e)*sin(t))"}
"""


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.parametrize("patience", [1, 5, 20])
def test_a_run_that_slides_slowly_goes_on_to_the_same_bytes(folder, interrupted_after, patience):
    """Most of it is no steps of compiled code (``integrate.guards.creeping``)."""
    (folder / "puck.yaml").write_text(CREEPING)
    run = ("puck.yaml", "--stop", "3", "--samples", "301", "-o", "out.h5")
    expected = whole(folder, *run)
    interrupted_after(patience)
    assert solve(*run) == 130
    with h5py.File("out.h5") as file:
        assert 0 < len(file["t"]) < 301
    interrupted_after(0)
    assert solve(*run, "--resume") == 0
    assert (folder / "out.h5").read_bytes() == expected
    with h5py.File("out.h5") as file:
        assert file.attrs["steps"] < 200


@pytest.mark.parametrize("method", ["taylor", "DOP853"])
def test_a_run_goes_on_to_the_same_bytes_where_a_step_has_many_samples(
    folder, interrupted_after, monkeypatch, method
):
    """Chunks end within steps, also within the last one. If other ones do when the run goes on, rates within
    a step are counted otherwise, or no state is kept from which a longer run goes on."""
    monkeypatch.setattr(taylor, "chunk_size", lambda width: 37)
    monkeypatch.setattr(stepper, "POLL_SECONDS", 0)  # it may be interrupted at each step
    (folder / "spring.yaml").write_text("coordinates: {x: {initial: 1}}\nlagrangian: (x_dot**2 - x**2)/2\n")
    run = ("spring.yaml", "--stop", "8", "--samples", "1001", "--method", method, "--outputs", "q,action")
    run = (*run, "--tolerance", "1e-12", "-o", "out.h5", "--quiet")
    assert solve(*run) == 0
    expected = (folder / "out.h5").read_bytes()
    patience, status = 0, 130
    while status:
        patience += 1
        os.remove("out.h5")
        interrupted_after(patience)
        status = solve(*run)
        interrupted_after(0)
        assert not status or solve(*run, "--resume") == 0
        assert (folder / "out.h5").read_bytes() == expected, f"interrupted when asked {patience} times"
    assert patience > 4


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("number", [2, 3])
def test_an_implicit_run_goes_on_to_the_same_bytes(folder, interrupted_after, number):
    """Its matrices are made once more, from the state that their derivatives were taken at."""
    (folder / "stiff.yaml").write_text(
        "coordinates: {x: {initial: 2}, y: {initial: 1}}\nlagrangian: (x_dot**2 + y_dot**2 - x**2 - y**2)/2\n"
        "generalized_forces: {x: 100*(1 - x**2)*x_dot + y, y: 10*(1 - y**2)*y_dot}\n"
    )
    run = ("stiff.yaml", "--method", "Radau", "--tolerance", "1e-6", "--stop", "2000", "--step", "0.01")
    run = (*run, "-o", "out.h5", "--outputs", "q,v,h,ledger,action")
    expected = whole(folder, *run)
    interrupted_after(number)
    assert solve(*run) == 130
    interrupted_after(0)
    assert solve(*run, "--resume") == 0
    assert (folder / "out.h5").read_bytes() == expected


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("method", ["ias15", "DOP853", "Radau"])
def test_a_run_with_events_goes_on_to_the_same_bytes(folder, interrupted_after, method):
    """Steps that were taken again to end at events, on a state that is moved back to constraints."""
    (folder / "a.yaml").write_text(
        "coordinates: {x: {initial: 1}, y: {initial: 0}}\nmasses: {b: 1}\npositions: {b: [x, y]}\n"
        "potential: b.y\nconstraints: {rod: x**2 + y**2 - 1}\nevents:\n"
        "  wall: {when: x + 0.5, direction: falling, action: {set: {x_dot: -x_dot, y_dot: -y_dot}}}\n"
    )
    run = ("a.yaml", "--method", method, "--tolerance", "1e-7", "--stop", "500", "--step", "0.002")
    run = (*run, "-o", "out.h5", "--outputs", "q,v,h,ledger")
    expected = whole(folder, *run)
    interrupted_after(3)
    assert solve(*run) == 130
    interrupted_after(0)
    assert solve(*run, "--resume") == 0
    assert (folder / "out.h5").read_bytes() == expected


@pytest.mark.parametrize(("method", "steps"), [("taylor", 3), ("ias15", 15)])
def test_a_run_goes_on_to_the_same_bytes_after_an_impact(
    folder, interrupted_after, monkeypatch, method, steps
):
    """It knows of the last step what it knew: no more, although steps were taken since the impact."""
    for name in ("FIRST", "MOST_STEPS"):  # it may be interrupted after any step
        monkeypatch.setattr(stepper, name, 1)
    (folder / "a.yaml").write_text(
        "coordinates: {x: {initial: 0, velocity: 1}, a: {initial: 0.3, velocity: 0.7}}\n"
        "masses: {cart: 1.2, bob: 0.45}\npositions: {cart: [x, 0], bob: [x + sin(a), -cos(a)]}\n"
        "potential: x**2/16 + 4*bob.y\nevents:\n"
        "  stop: {when: a + 0.3, direction: falling, action: {set: {a_dot: -a_dot/4}}}\n"
    )
    run = ("a.yaml", "--method", method, "--stop", "2", "--samples", "7")
    run = (*run, "-o", "out.h5")
    expected = whole(folder, *run)
    for _ in range(3):
        interrupted_after(steps)
        assert solve(*run, "--resume") == 130
    interrupted_after(0)
    assert solve(*run, "--resume") == 0
    assert (folder / "out.h5").read_bytes() == expected


@pytest.mark.exhaustive(keep=0)
@pytest.mark.parametrize("number", range(4))
def test_a_run_survives_being_killed_at_random_moments(tmp_path, number):
    """Other moments each time; by SIGKILL, as an interpreter that is just starting does not heed the rest."""
    seed = int.from_bytes(os.urandom(4), "little")
    print(f"seed {seed}")
    chance, scene = random.Random(seed), Scene(("solve", DOUBLE, *LONG[1:-2], *OFTEN), "double_pendulum.h5")
    expected, seconds = undisturbed(scene, tmp_path)
    kills = list(disturbed(scene, tmp_path, expected, seconds, chance, most=3, signals=(signal.SIGKILL,)))
    assert all(set(kill.left) - {"double_pendulum.h5"} <= PARTS for kill in kills)


SWEEPS = {
    "ends": ("--over", "theta1=1:2:60", "--stop", "1500"),
    "trajectories": ("--random", "theta1=normal(2,1)", "--members", "60", "--stop", "1500",
                     "--outputs", "q,h", "--samples", "51"),
    "one by one": ("--over", "theta1=0:2:7", "--stop", "0.5", "--method", "DOP853"),
}  # fmt: skip


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("arguments", SWEEPS.values(), ids=SWEEPS)
@pytest.mark.parametrize("patience", [2, 3])
def test_an_interrupted_sweep_follows_only_the_members_that_are_missing(
    folder, arguments, patience, monkeypatch, capsys
):
    run = ["sweep", DOUBLE, *arguments, "-o", "out.h5", "--jobs", "1", "--json"]
    assert main(run) == 0
    expected = (folder / "out.h5").read_bytes()
    monkeypatch.setattr(Nervous, "patience", patience)
    monkeypatch.setattr(sweeping, "Interrupts", Nervous)
    assert main([*run, "--force"]) == 130
    monkeypatch.setattr(sweeping, "Interrupts", Interrupts)
    with h5py.File("out.h5") as file:
        ended = (file["status"][()] == b"complete").sum()
        assert (file["status"][()] == b"interrupted").sum() == len(file["status"]) - ended > 0
        assert file.attrs["status"] == "interrupted" and f"after {ended} of" in file.attrs["message"]
    with xarray.open_dataset("out.h5", group="q", engine="h5netcdf") as data:
        assert np.isfinite(data.theta2.values).all(axis=-1).sum() in (ended, 0)
    followed = followed_members(monkeypatch)
    assert main([*run, "--resume"]) == 0
    assert sum(followed) == len(h5py.File("out.h5")["status"]) - ended
    assert (folder / "out.h5").read_bytes() == expected
    assert json.loads(capsys.readouterr().out.splitlines()[-1])["resumed_from"] == ended
    assert main([*run, "--resume"]) == 0
    assert (folder / "out.h5").read_bytes() == expected


def followed_members(monkeypatch) -> list[int]:
    """How many members are followed from now on, in each part of the sweep."""
    counts: list[int] = []
    for kind in (LanesMethod, OneByOne):

        def follow(self, starts, *rest, plain=kind.follow):
            counts.append(len(starts))
            return plain(self, starts, *rest)

        monkeypatch.setattr(kind, "follow", follow)
    return counts


@pytest.mark.exhaustive(keep=0.15)
def test_a_sweep_that_was_killed_is_kept_and_goes_on(folder, capsys):
    sweep = ("sweep", DOUBLE, "--over", "theta1=0:2:801", "--stop", "40", "-o", "out.h5")
    expected = whole(folder, *sweep)
    assert killed(folder, *sweep) == LEFT
    assert main([*sweep]) == 5
    assert main([*sweep, "--over", "m1=1,2", "--resume"]) == 5
    assert "out.h5 cannot be continued: it was made with other" in capsys.readouterr().err
    content = bytearray((folder / ".out.h5.part").read_bytes())
    (folder / ".out.h5.part").write_bytes(content[: len(content) // 2])
    assert main([*sweep, "--resume"]) == 5
    assert "is damaged" in capsys.readouterr().err
    (folder / ".out.h5.part").write_bytes(content)
    assert main([*sweep, "--resume"]) == 0
    assert (folder / "out.h5").read_bytes() == expected
    assert os.listdir(folder) == ["out.h5"]


PARTS = {f".double_pendulum.h5.{name}" for name in ("part", "1.part", "checkpoint", "lock", "checkpoint.new")}


@pytest.mark.exhaustive(keep=0.2)
def test_checkpoints_change_no_byte_and_leave_nothing(folder):
    assert whole(folder, *RUN) == whole(folder, *RUN, "--checkpoint", "0")
    assert whole(folder, *RUN) == whole(folder, *RUN, "--checkpoint-count", "1")
    assert os.listdir(folder) == []


@pytest.mark.exhaustive(keep=0.65)
@pytest.mark.parametrize(
    "options", [("--over", "theta1=1:2:30"), ("--random", "theta1=normal(2,1)", "--members", "30")]
)
def test_checkpoints_change_no_byte_of_a_sweep(folder, options):
    """Nor do they show in space that HDF5 has freed, whatever was written there before."""
    contents = []
    for often in ("1", "7", "1000"):
        sweep = [
            "sweep",
            DOUBLE,
            *options,
            "--stop",
            "20",
            "-o",
            "out.h5",
            "--force",
            "--checkpoint-count",
            often,
        ]
        assert main(sweep) == 0
        contents.append((folder / "out.h5").read_bytes())
    assert contents[0] == contents[1] == contents[2]


def test_a_short_run_writes_no_checkpoint(folder, monkeypatch):
    monkeypatch.setattr(Output, "keep", None)
    assert solve(str(SYSTEMS / "pendulum.yaml")) == 0


@pytest.mark.exhaustive(keep=0.15)
def test_a_run_that_was_killed_is_kept_and_goes_on(folder, capfd):
    expected = whole(folder, *LONG)
    assert killed(folder, *LONG) == LEFT
    assert solve(*LONG) == 5
    assert "--resume continues it, --force starts again" in capfd.readouterr().err
    assert sorted(os.listdir(folder)) == [".out.h5.checkpoint", ".out.h5.part"]
    assert solve(*LONG, "--resume") == 0
    assert "continued from t = " in capfd.readouterr().out
    assert (folder / "out.h5").read_bytes() == expected
    assert os.listdir(folder) == ["out.h5"]


@pytest.mark.exhaustive(keep=0.35)
def test_force_starts_anew(folder, capsys):
    assert killed(folder, *LONG) == LEFT
    assert solve(*RUN, "--force", "--json") == 0
    assert json.loads(capsys.readouterr().out)["resumed_from"] is None
    assert os.listdir(folder) == ["out.h5"]


@pytest.mark.exhaustive(keep=0.35)
def test_an_output_that_was_to_be_replaced_stays_until_the_end_and_is_replaced(folder):
    expected = whole(folder, *LONG)
    (folder / "out.h5").write_text("another's")
    assert killed(folder, *LONG, "--force") == [*LEFT, "out.h5"]
    assert (folder / "out.h5").read_text() == "another's"
    (folder / "out.h5").unlink()
    assert solve(*LONG, "--resume") == 0
    assert (folder / "out.h5").read_bytes() == expected


def test_a_finished_output_is_left_alone(folder, capsys):
    expected = solve(*RUN), (folder / "out.h5").read_bytes()
    capsys.readouterr()
    assert (solve(*RUN, "--resume", "--json"), (folder / "out.h5").read_bytes()) == expected
    answer = json.loads(capsys.readouterr().out)
    assert (answer["status"], answer["t"], answer["name"]) == ("complete", 800, "double pendulum")
    assert solve(*RUN, "--resume") == 0
    assert "is finished already: reached the end" in capsys.readouterr().out


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("others", [False, True])
def test_a_run_that_was_killed_when_its_output_had_just_got_its_name_is_finished(
    folder, remains, others, capsys
):
    """What it had been continued from is still there. What belongs to another run stays."""
    run = RUN if others else LONG
    assert solve(*run) == 0
    for name, content in remains.items():
        (folder / name).write_bytes(content)
    assert solve(*run, "--resume") == 0
    assert sorted(os.listdir(folder)) == (sorted({*remains, "out.h5"} - {LEFT[1]}) if others else ["out.h5"])
    if others:
        assert solve(*LONG, "--resume") == 5
        assert "out.h5 is newer than the interrupted run" in capsys.readouterr().err
        (folder / "out.h5").unlink()
        assert solve(*LONG, "--resume") == 0
        assert (folder / "out.h5").read_bytes() == whole(folder, *LONG)


def test_a_motion_that_could_not_be_followed_needs_nothing_more(folder, capsys):
    (folder / "fall.yaml").write_text(
        "parameters: {G: 1.0}\ncoordinates: {r: {initial: 1.0}}\nmasses: {stone: 1}\n"
        "embedding: {stone: [r]}\npotential: -G/r\nsolve: {stop: 10}\n"
    )
    assert [solve("fall.yaml"), solve("fall.yaml", "--resume")] == [4, 4]
    assert "is finished already: the denominator r reaches 0 in -G/r" in capsys.readouterr().out


def test_the_final_state_of_a_run_that_fails_is_the_last_sample_wherever_it_was_interrupted(
    folder, interrupted_after
):
    run = (str(SYSTEMS / "rotating_rod.yaml"), "--stop", "1e9", "--samples", "2", "-o", "out.h5")
    assert solve(*run) == 4
    expected = (folder / "out.h5").read_bytes()
    interrupted_after(1)
    assert solve(*run, "--force") == 130
    interrupted_after(0)
    assert solve(*run, "--resume") == 4
    assert (folder / "out.h5").read_bytes() == expected


@pytest.mark.parametrize("length", [300, 250, 245, 230])
def test_a_name_that_is_too_long_for_the_hidden_files_is_one_clear_error(folder, length, capsys):
    """Before any work is done; at 230 letters a run that is cut off can be continued."""
    name = "a" * length + ".h5"
    status = solve(DOUBLE, "--stop", "1", "-o", name)
    assert status == (0 if length == 230 else 5)
    error = capsys.readouterr().err
    assert ("its name is too long" in error) is (status == 5) and "report it" not in error
    assert os.listdir(folder) == ([name] if status == 0 else [])


def test_where_there_is_nothing_to_resume_the_run_starts(folder, capsys):
    assert solve(*RUN, "--resume") == 0
    assert "nothing to resume; the run starts at the beginning" in capsys.readouterr().err


@pytest.mark.exhaustive(keep=0.4)
def test_scipys_methods_start_again_and_say_so(folder, interrupted_after, capsys):
    run = (DOUBLE, "--method", "LSODA", "--stop", "5", "-o", "out.h5")
    expected = whole(folder, *run)
    interrupted_after(30)
    assert solve(*run) == 130
    interrupted_after(0)
    assert solve(*run, "--resume") == 0
    assert "LSODA stores no checkpoints; the run starts at the beginning" in capsys.readouterr().err
    assert (folder / "out.h5").read_bytes() == expected


OTHERS = {
    "parameters": (["--set", "m1=3"], "with other parameters"),
    "initial state": (["--set", "theta1=0.5"], "with another initial state"),
    "start": (["--start", "1"], "another --stop"),
    "samples": (["--samples", "70002"], "--samples"),
    "outputs": (["--outputs", "q"], "--outputs"),
    "tolerance": (["--tolerance", "1e-9"], "with another --tolerance"),
    "method": (["--method", "DOP853"], "with another --method"),
}


@pytest.mark.exhaustive(keep=1.5)
@pytest.mark.parametrize("finished", [True, False])
@pytest.mark.parametrize(("options", "message"), OTHERS.values(), ids=OTHERS)
def test_another_run_is_not_continued(folder, interrupted_after, options, message, finished, capsys):
    interrupted_after(0 if finished else 3)
    assert solve(*RUN) == (0 if finished else 130)
    before = (folder / "out.h5").read_bytes()
    interrupted_after(0)
    assert solve(*RUN, *options, "--resume") == 5
    error = capsys.readouterr().err
    assert "out.h5 cannot be continued: it was made" in error and message in error and "--force" in error
    assert (folder / "out.h5").read_bytes() == before and os.listdir(folder) == ["out.h5"]


def test_what_only_an_earlier_run_says_makes_it_another(folder, capsys):
    chain = str(SYSTEMS / "n_pendulum.yaml")
    assert main(["solve", chain, "--size", "N=2", "--stop", "1", "-o", "out.h5"]) == 0
    target = find_target("out.h5", force=False, resume=True)
    attributes = read_output(target).attributes
    run = {name: value for name, value in attributes.items() if name != "sizes"}
    with pytest.raises(FileError, match="it was made with other sizes"):
        find_earlier(target, run)


def test_another_file_of_the_same_name_is_not_continued(folder, capsys):
    for content in (b"", b"what is this?", (SYSTEMS / "pendulum.yaml").read_bytes()):
        (folder / "out.h5").write_bytes(content)
        assert solve(*RUN, "--resume") == 5
        assert "or is not an output of lagrange" in capsys.readouterr().err
        assert (folder / "out.h5").read_bytes() == content
    with h5py.File("other.h5", "w") as file:
        file["t"] = np.arange(3.0)
    (folder / "other.h5").replace("out.h5")
    assert solve(*RUN, "--resume") == 5
    assert "not an output of lagrange" in capsys.readouterr().err


def test_resume_and_force_contradict_each_other(folder, capsys):
    assert solve(*RUN, "--resume", "--force") == 2
    assert "give one of them" in capsys.readouterr().err


@pytest.fixture(scope="module")
def remains(tmp_path_factory):
    """What a killed run has left: the names and contents of the files."""
    folder = tmp_path_factory.mktemp("killed")
    killed(folder, *LONG, size=2_000_000, every=10_000)
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("name", LEFT[::2])
@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(where=st.floats(0, 1), flip=st.integers(1, 255), cut=st.booleans())
def test_damage_is_found_and_nothing_is_lost(folder, remains, name, where, flip, cut, capsys):
    for path, content in remains.items():
        (folder / path).write_bytes(content)
    content = bytearray(remains[name])
    place = int(where * (len(content) - 1))
    if cut:
        del content[place:]
    else:
        content[place] ^= flip
    (folder / name).write_bytes(content)
    status = solve(*LONG, "--resume", "--quiet")
    error = capsys.readouterr().err
    assert "Traceback" not in error and "report it" not in error
    if status == 0:  # a byte of the part file that no sample is made of
        assert name == ".out.h5.part"
        assert (folder / "out.h5").read_bytes() == whole(folder, *LONG)
        (folder / "out.h5").unlink()
    else:
        assert status == 5 and "is damaged: --force starts again" in error
        assert (folder / name).read_bytes() == bytes(content)


def test_two_processes_do_not_write_the_same_output(folder, capsys):
    with find_target("out.h5", force=False).claimed():
        for options in ([], ["--force"], ["--resume"]):
            assert solve(*RUN, *options) == 5
            assert "out.h5 is being written by another process" in capsys.readouterr().err
    assert os.listdir(folder) == []
    assert solve(*RUN) == 0


@pytest.mark.exhaustive(keep=0.25)
def test_a_full_disk_keeps_what_the_last_checkpoint_has(folder):
    expected = whole(folder, *LONG)
    limit = len(expected) * 2 // 3
    for more in ((), ("--resume",)):
        run = lagrange_process(
            "solve", *LONG, "--checkpoint", "0", *more, cwd=folder,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)),
        )  # fmt: skip
        assert run.returncode == 5
        said, way_on = (
            "out.h5 could not be written: File too large",
            "--resume continues from the last checkpoint",
        )
        assert run.stderr == f"Error: {said}; {way_on}\n"
        assert ".out.h5.checkpoint" in os.listdir(folder)
    assert solve(*LONG, "--resume") == 0
    assert (folder / "out.h5").read_bytes() == expected


@pytest.mark.exhaustive(keep=0.4)
def test_a_folder_that_goes_away_is_one_clear_error(tmp_path, monkeypatch, capsys):
    folder, keep = tmp_path / "folder", Output.keep
    folder.mkdir()

    def keep_and_move(self, checkpoint) -> None:
        keep(self, checkpoint)
        if folder.exists():
            folder.rename(tmp_path / "elsewhere")

    monkeypatch.setattr(Output, "keep", keep_and_move)
    assert solve(*RUN[:-1], str(folder / "out.h5"), "--checkpoint-count", "1") == 5
    error = capsys.readouterr().err
    assert not folder.exists()
    assert "could not be written: No such file or directory" in error and "Traceback" not in error


def test_a_folder_that_becomes_unwritable_keeps_the_result_in_the_hidden_file(folder, monkeypatch, capsys):
    expected = whole(folder, *RUN)

    def refused(*names: Path) -> None:
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(Path, "replace", refused)
    assert solve(*RUN, "--checkpoint", "0") == 5
    error = capsys.readouterr().err
    assert "out.h5 could not be written: Permission denied; the complete result is in" in error
    assert (folder / ".out.h5.part").read_bytes() == expected


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize(
    "name", [".out.h5.part", ".out.h5.checkpoint.new", ".out.h5.lock", ".out.h5.checkpoint"]
)
@pytest.mark.parametrize("kind", ["link", "fifo"])
def test_what_lies_where_the_hidden_files_go_is_neither_followed_nor_waited_for(folder, name, kind, capsys):
    (folder / "precious").write_text("precious")
    if kind == "link":
        (folder / name).symlink_to("precious")
    else:
        os.mkfifo(folder / name)
    status = solve(*RUN, "--checkpoint", "0")
    error = capsys.readouterr().err
    assert status in (0, 5) and "Traceback" not in error and "report it" not in error
    assert (status == 0) is h5py.is_hdf5("out.h5")
    assert (folder / "precious").read_text() == "precious"


def test_where_checkpoints_cannot_be_written_the_run_goes_on(folder, monkeypatch):
    expected = whole(folder, *RUN)
    (folder / ".out.h5.checkpoint.new").mkdir()  # in its place no file can be made
    assert solve(*RUN, "--checkpoint", "0") == 0
    assert (folder / "out.h5").read_bytes() == expected


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize(
    ("number", "closed"), [(signal.SIGINT, []), (signal.SIGTERM, ["out"]), (signal.SIGHUP, ["out", "err"])]
)
def test_what_asks_a_run_to_end_is_heeded_with_or_without_a_terminal(tmp_path, number, closed):
    command = f"exec {sys.executable} -m lagrange_cli solve {' '.join(LONG)} --stop 1e6"
    command += "".join({"out": " >&-", "err": " 2>&-"}[name] for name in closed)
    process = subprocess.Popen(
        ["sh", "-c", command], cwd=tmp_path, env=environment(), stderr=subprocess.PIPE, text=True,
        preexec_fn=lambda: signal.signal(number, signal.SIG_DFL),  # whatever these tests are run by ignores
    )  # fmt: skip
    wait_until((tmp_path / ".out.h5.part").exists, process)
    process.send_signal(number)
    error = process.communicate(timeout=PATIENCE)[1]
    assert process.returncode == 130
    assert "Traceback" not in error
    assert os.listdir(tmp_path) == ["out.h5"]
    with h5py.File(tmp_path / "out.h5") as file:
        assert file.attrs["status"] == "interrupted" and "interrupted at t = " in file.attrs["message"]


def test_ctrl_c_while_the_command_is_loaded_ends_it_without_a_traceback(tmp_path):
    (tmp_path / "click.py").write_text("import os, signal\nos.kill(os.getpid(), signal.SIGINT)\n")
    run = subprocess.run(
        [sys.executable, "-m", "lagrange_cli", "solve", DOUBLE],
        cwd=tmp_path,
        env={**environment(), "PYTHONPATH": f"{tmp_path}{os.pathsep}{ROOT}"},
        capture_output=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # as above
    )
    assert (run.returncode, run.stdout, run.stderr) == (-signal.SIGINT, b"", b"")
