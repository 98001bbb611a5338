"""``solve`` for systems with events: their groups in the output, what is said of them, and runs cut off."""

import json
import os

import h5py
import numpy as np
import pytest
import xarray

import lagrange_cli.cli.commands.solve as solving
import lagrange_cli.cli.commands.sweep as sweeping
from lagrange_cli.cli.main import main
from lagrange_cli.run.interrupts import Interrupts
from lagrange_cli.store import ensemble as ensembles
from tests.cli.test_resume import Nervous, killed

TABLE = """
name: a ball on a table that shakes
parameters: {e: 0.8, A: 0.05, w: 9}
coordinates:
  y: {initial: 1, unit: m}
  u[i in range(2)]: {initial: i, velocity: 1 + i, unit: m}
masses: {p: 2, walker[i in range(2)]: 1}
embedding: {p: [0, y], walker[i in range(2)]: ["u[i]", 0]}
potential: 2*9.81*y
events:
  floor:
    when: y - A*sin(w*t)
    direction: falling
    action: {set: {y_dot: A*w*cos(w*t) - e*(y_dot - A*w*cos(w*t))}}
  post[i in range(3)]: u[1] - 5*(i + 1)
  pushed: {when: sin(5*t), action: {set: {A: 0.05 - A/50, "u_dot[0]": 1 + A}}}
  never: u[0] + 7
"""
REST = """
name: a ball that comes to rest
parameters: {e: 0.5}
coordinates: {y: {initial: 1}}
masses: {p: 2}
embedding: {p: [y]}
potential: 2*9.81*y
events:
  floor: {when: y, direction: falling, action: {set: {y_dot: -e*y_dot}}}
  lifted: {when: "sin(2*t)", direction: falling, action: {set: {y_dot: y_dot + 2}}}
"""
RELEASED = """
name: a ball that rests on a table until that falls faster
parameters: {e: 0.3, A: 0.05, w: 15}
coordinates: {y: {initial: 0.2}}
masses: {p: 2}
embedding: {p: [y]}
potential: 2*9.81*y
events:
  floor:
    when: y - A*sin(w*t)
    direction: falling
    action: {set: {y_dot: A*w*cos(w*t) - e*(y_dot - A*w*cos(w*t))}}
"""
STOPS = """
name: a ball that is caught
coordinates: {y: {initial: 1}}
lagrangian: y_dot**2/2 - 10*y
events: {ground: {when: y, action: stop}}
"""
SYSTEMS = {"table": TABLE, "rest": REST, "released": RELEASED, "stops": STOPS}
FILES = sorted(f"{name}.yaml" for name in SYSTEMS)
ASKED = ("--stop", "20", "--step", "0.01", "-o", "out.h5", "--outputs", "q,v,p,h,ledger")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, text in SYSTEMS.items():
        (tmp_path / f"{name}.yaml").write_text(text)
    return tmp_path


def solve(*arguments: str) -> int:
    return main(["solve", *arguments])


def whole(folder, *arguments: str) -> bytes:
    """What the run writes if nothing disturbs it; the output is removed."""
    assert solve(*arguments) == 0
    content = (folder / "out.h5").read_bytes()
    (folder / "out.h5").unlink()
    return content


@pytest.mark.exhaustive(keep=0.4)
def test_crossings_are_in_groups_of_their_events(folder, capsys):
    assert solve("table.yaml", *ASKED, "--outputs", "h", "--json") == 0
    said = json.loads(capsys.readouterr().out)["events"]
    with h5py.File("out.h5") as file:
        assert "q" not in file
        floor, post = file["events/floor"], file["events/post"]
        assert said["floor"]["count"] == len(floor["t"]) > 20
        assert said["floor"]["last"] == floor["t"][-1]
        assert floor["q/u"].shape == floor["v/u"].shape == (len(floor["t"]), 2)
        np.testing.assert_allclose(floor["q/y"], 0.05 * np.sin(9 * floor["t"][:]), rtol=0.1, atol=0.02)
        assert dict(floor.attrs) == {
            "when": "y - A*sin(w*t)",
            "direction": "falling",
            "action": "set y_dot = A*w*cos(w*t) - e*(y_dot - A*w*cos(w*t))",
        }
        np.testing.assert_array_equal(post["i"], [0, 1, 2])
        np.testing.assert_allclose(post["t"], [2.0, 4.5, 7.0], rtol=1e-14)
        np.testing.assert_allclose(post["q/u"][:, 1], [5.0, 10.0, 15.0], rtol=1e-14)
        assert file["events/never/t"].shape == file["events/never/v/y"].shape == (0,)
        assert json.loads(file.attrs["events"]) == said
        assert "pushed" in said and said["post[2]"] == {
            "count": 1, "last": 7.0, "grazing": 0, "accumulates": None, "error": 0.0,
        }  # fmt: skip


@pytest.mark.exhaustive(keep=0.15)
def test_what_happened_is_said_with_the_result(folder, capsys):
    assert solve("rest.yaml", *ASKED) == 0
    out, error = capsys.readouterr()
    assert "\n  events: floor " in out and "lifted 6 (last at t = 17.2788)" in out
    assert "event 'floor': infinitely many accumulate at t = 1.35" in error
    assert solve("rest.yaml", *ASKED, "--resume", "--json") == 0
    assert json.loads(capsys.readouterr().out)["events"]["lifted"]["count"] == 6
    assert solve("table.yaml", *ASKED, "--force") == 0
    assert "event 'never' did not occur" in capsys.readouterr().err
    assert solve("table.yaml", *ASKED, "--force", "--quiet") == 0
    assert capsys.readouterr() == ("", "")


def test_a_table_holds_no_events(folder, capsys):
    assert solve("table.yaml", "--stop", "1", "--format", "csv", "-o", "-") == 0
    out, error = capsys.readouterr()
    assert out.startswith("t,") and "events are written to HDF5 files only" in error


@pytest.mark.exhaustive(keep=0.75)
def test_a_motion_that_an_event_stops_is_done(folder, capsys):
    assert solve("stops.yaml", *ASKED) == 0
    assert "stopped, event 'ground', at t = 0.447213595" in capsys.readouterr().out
    with h5py.File("out.h5") as file:
        assert file.attrs["status"] == "stopped"
        assert file["t"][-1] == 0.44
        assert file["events/ground/t"][:] == pytest.approx(np.sqrt(0.2), rel=1e-15)
    before = (folder / "out.h5").read_bytes()
    for again in ((), ("--resume",), ("--resume", "--stop", "30")):
        assert solve("stops.yaml", *ASKED, *again) == 0
        assert (folder / "out.h5").read_bytes() == before
    assert "is finished already: stopped, event 'ground'" in capsys.readouterr().out


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize(
    ("system", "stop", "patience"), [("table", 3, 1), ("table", 20, 7), ("rest", 20, 5), ("released", 0.9, 1)]
)
def test_a_run_that_is_interrupted_all_the_time_comes_to_the_same_bytes(
    folder, monkeypatch, system, stop, patience
):
    """Every action is a place where a run may be interrupted."""
    run = (f"{system}.yaml", *ASKED, "--stop", str(stop))
    expected = whole(folder, *run)
    monkeypatch.setattr(solving, "Interrupts", Nervous)
    times = 0
    status = 130
    while status:
        monkeypatch.setattr(Nervous, "patience", patience)
        status = solve(*run, *(("--resume",) if times else ()))
        assert status in (0, 130)
        times += 1
        assert times < 1000
    assert times > 3
    assert (folder / "out.h5").read_bytes() == expected


@pytest.mark.exhaustive(keep=0.45)
def test_an_interrupted_run_holds_the_crossings_so_far(folder, monkeypatch):
    monkeypatch.setattr(solving, "Interrupts", Nervous)
    monkeypatch.setattr(Nervous, "patience", 30)
    assert solve("table.yaml", *ASKED) == 130
    with h5py.File("out.h5") as file:
        found, reached = file["events/floor/t"][:], file["t"][-1]
    monkeypatch.setattr(solving, "Interrupts", Interrupts)
    assert solve("table.yaml", *ASKED, "--resume") == 0
    with h5py.File("out.h5") as file:
        np.testing.assert_array_equal(file["events/floor/t"][: len(found)], found)
        assert len(found) > 5 and found[-1] <= file["t"][-1] and reached > 0


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("more", [(), ("--precision", "double-double")])
def test_a_run_that_was_killed_goes_on_to_the_same_bytes(folder, more):
    run = ("table.yaml", *ASKED, *more)
    expected = whole(folder, *run)
    assert killed(folder, *run, every=40) == [
        ".out.h5.checkpoint", ".out.h5.lock", ".out.h5.part", *FILES,
    ]  # fmt: skip
    assert solve(*run, "--resume") == 0
    assert (folder / "out.h5").read_bytes() == expected


@pytest.mark.exhaustive(keep=0.2)
def test_a_run_to_a_later_time_goes_on_to_the_same_bytes(folder):
    later = ("--stop", "31.5")
    expected = whole(folder, "table.yaml", *ASKED, *later)
    assert solve("table.yaml", *ASKED) == 0
    assert solve("table.yaml", *ASKED, *later, "--resume") == 0
    assert (folder / "out.h5").read_bytes() == expected
    assert sorted(os.listdir(folder)) == ["out.h5", *FILES]


SWEPT = (
    "sweep", "table.yaml", "--over", "e=0.5,0.8", "--over", "y=1:2:5", "--stop", "6", "-o", "out.h5",
)  # fmt: skip


@pytest.mark.exhaustive(keep=0.15)
def test_a_sweep_holds_the_crossings_of_each_member(folder, capsys):
    assert main([*SWEPT]) == 0
    out, error = capsys.readouterr()
    assert error == "a ball on a table that shakes: event 'never' did not occur in any member\n"
    with h5py.File("out.h5") as file:
        floor, post = file["events/floor"], file["events/post"]
        member, times = floor["member"][:], floor["t"][:]
        assert list(np.unique(member)) == [*range(10)] and np.all(np.diff(member) >= 0)
        assert file["member"].shape == (2, 5)
        np.testing.assert_array_equal(post["member"], np.repeat(np.arange(10), 2))
        np.testing.assert_array_equal(post["i"], [0, 1] * 10)
        assert floor["q/u"].shape == (len(times), 2) and file["events/never/q/u"].shape == (0, 2)
        assert dict(floor.attrs)["when"] == "y - A*sin(w*t)"
        counts = {name: len(group["t"]) for name, group in file["events"].items()}
        assert json.loads(file.attrs["events"]) == {name: {"count": n} for name, n in counts.items()}
    assert f"\n  events: floor {counts['floor']}, pushed {counts['pushed']}, post 20, never 0\n" in out
    assert main([*SWEPT, "--resume", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["events"]["post"] == {"count": 20}
    assert solve("table.yaml", "--set", "e=0.8", "--set", "y=1.5", "--stop", "6", "-o", "one.h5") == 0
    with h5py.File("one.h5") as file:
        np.testing.assert_allclose(times[member == 7], file["events/floor/t"], rtol=1e-13)
    with xarray.open_dataset("out.h5", group="events/floor", engine="h5netcdf") as data:
        assert data.member.dims == ("t",)
        assert len(data.t) == len(times)


@pytest.mark.exhaustive(keep=0)
@pytest.mark.parametrize(("jobs", "patience"), [("1", 100), ("2", 2)])
def test_a_sweep_that_is_interrupted_all_the_time_comes_to_the_same_bytes(
    folder, monkeypatch, jobs, patience
):
    assert main([*SWEPT, "--jobs", "1"]) == 0
    expected = (folder / "out.h5").read_bytes()
    (folder / "out.h5").unlink()
    monkeypatch.setattr(sweeping, "Interrupts", Nervous)
    times, status = 0, 130
    while status:
        monkeypatch.setattr(Nervous, "patience", patience * 2**times)  # what has not ended starts again
        status = main([*SWEPT, "--jobs", jobs, *(("--resume",) if times else ())])
        assert status in (0, 130)
        times += 1
        assert times < 15
    assert times > 1
    assert (folder / "out.h5").read_bytes() == expected


@pytest.mark.exhaustive(keep=0.15)
def test_a_sweep_that_was_killed_goes_on_to_the_same_bytes(folder):
    assert main([*SWEPT]) == 0
    expected = (folder / "out.h5").read_bytes()
    (folder / "out.h5").unlink()
    assert ".out.h5.checkpoint" in killed(folder, *SWEPT, every=3)
    assert main([*SWEPT, "--resume"]) == 0
    assert (folder / "out.h5").read_bytes() == expected


@pytest.mark.exhaustive(keep=0.15)
def test_a_sweep_with_more_crossings_than_memory_is_refused(folder, monkeypatch, capsys):
    monkeypatch.setattr(ensembles, "MOST_CROSSINGS", 10_000)
    assert main([*SWEPT]) == 2
    assert "sweep fewer members at a time" in capsys.readouterr().err


def test_members_that_events_stop_are_counted(folder, capsys):
    run = ("sweep", "stops.yaml", "--over", "y=1,20", "--stop", "1", "-o", "out.h5")
    assert main([*run, "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert (said["status"], said["complete"], said["stopped"]) == ("complete", 1, 1)
    assert said["message"] == "1 of 2 members reached the end, events stopped 1"
    assert said["events"] == {"ground": {"count": 1}}
    assert main([*run, "--force"]) == 0
    assert "\n  1 reached the end, 1 stopped\n" in capsys.readouterr().out
    with h5py.File("out.h5") as file:
        assert list(file["status"]) == [b"stopped", b"complete"]
        assert list(file["events/ground/member"]) == [0]
