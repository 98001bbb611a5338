"""``lagrange section`` as a user runs it: what it writes, says and refuses."""

from __future__ import annotations

import json
import math
import os
import re
from pathlib import Path

import h5py
import mpmath
import numpy as np
import pytest
import xarray

from lagrange_cli.integrate.methods import stepper
from tests.cli.test_solve import datasets
from tests.support.command import SYSTEMS, lagrange, lagrange_process

HENON = SYSTEMS / "henon_heiles.yaml"
SPRING = """
parameters: {w: {value: 1.0, unit: 1/s}}
coordinates: {x: {initial: 0.0, velocity: w}}
definitions: {both: x + x_dot}
lagrangian: x_dot**2/2 - w**2*x**2/2
time: {unit: s}
solve: {stop: 2*pi/w, step: 0.1}
"""


FLOOR = """
name: a ball between springs that change, above a floor
parameters: {g: 1, e: 1.0, k: 1}
coordinates: {y: {initial: 1}, x: {initial: 0, velocity: 1.3}}
masses: {ball: 1}
embedding: {ball: [x, y]}
potential: g*y + k*x**2/2
events:
  floor: {when: y, direction: falling, action: {set: {y_dot: -e*y_dot}}}
  stiffer: {when: x_dot - 0.1, direction: rising, action: {set: {k: 2.5 - k}}}
solve: {outputs: [q, v, h, ledger]}
"""


def section(*arguments: str | Path, cwd: Path, status: int = 0) -> dict:
    run = lagrange("section", "--json", *arguments, cwd=cwd)
    assert run.returncode == status, run.stderr
    return json.loads(run.stdout)


@pytest.fixture
def spring(tmp_path) -> Path:
    path = tmp_path / "spring.yaml"
    path.write_text(SPRING)
    return path


@pytest.mark.exhaustive(keep=0.3)
def test_one_motion_has_a_file_like_that_of_solve(tmp_path):
    run = lagrange_process("section", HENON, "--where", "x", "--crossings", "7", cwd=tmp_path)
    assert (run.returncode, run.stderr) == (0, "")
    assert run.stdout.startswith("Henon-Heiles: section where x = 0, rising\n  7 crossings\n")
    assert os.listdir(tmp_path) == ["henon_heiles_section.h5"]
    with h5py.File(tmp_path / "henon_heiles_section.h5") as file:
        names = ("q/x", "q/y", "v/x", "v/y", "diagnostics/p/x", "diagnostics/p/y", "diagnostics/h", "t")
        assert datasets(file) == dict.fromkeys(names, (7,))
        x, y, u, v = (file[name][()] for name in ("q/x", "q/y", "v/x", "v/y"))
        assert np.abs(x).max() < 1e-15 and (u > 0).all()
        assert np.abs((u**2 + v**2 + y**2) / 2 - y**3 / 3 - 1 / 8).max() < 1e-15
        said = dict(file.attrs)
        assert (said["where"], said["direction"], said["crossings"]) == ("x", "rising", 7)
        assert said["t_end"] == file["t"][-1] and said["method"] == "taylor"
        assert "sweep" not in said and "members" not in said
    with xarray.open_dataset(tmp_path / "henon_heiles_section.h5", group="q", engine="h5netcdf") as q:
        assert q.x.dims == ("t",)


@pytest.mark.exhaustive(keep=0.6)
def test_a_sweep_has_its_dimensions_and_the_crossings(tmp_path, spring):
    grid = ("--over", "w=1,2,4", "--over", "x=0,0.5")
    told = section(spring, "--where", "both", "--direction", "either", "--crossings", "5", "--stop", "6",
                   *grid, cwd=tmp_path)  # fmt: skip
    assert (told["status"], told["members"], told["complete"]) == ("complete", 6, 6)
    assert told["where"] == "both" and told["direction"] == "either" and "every" not in told
    with h5py.File(tmp_path / "spring_section.h5") as file:
        assert file["t"].shape == file["q/x"].shape == (3, 2, 5)
        assert [dim[0].name for dim in file["t"].dims] == ["/w", "/x_0", "/crossing"]
        assert file["t"].attrs["unit"] == "s"
        count, t = file["crossings"][()], file["t"][()]
        assert count.tolist() == [[2, 2], [4, 4], [5, 5]] and told["crossings"] == 22
        assert (np.isnan(t).sum(axis=2) == 5 - count).all()
        first = [(math.pi - math.atan(w)) / w for w in (1, 2, 4)]  # x = sin(w t): tan(w t) = -w
        assert np.abs(t[:, 0, 0] - first).max() < 1e-14
        assert file["t_end"][0, 0] == 6.0 and file["t_end"][2, 0] == t[2, 0, 4]
    assert told["message"] == "22 crossings by 6 members; 4 of them reached the stop time before 5 crossings"


LENGTHS = """
parameters: {m: {value: 1, unit: kg}, k: {value: 3, unit: KUNIT}}
coordinates: {x: {initial: 1, unit: m}}
time: {unit: s}
masses: {p: m}
embedding: {p: [x]}
potential: k*x**2/2
"""


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(
    ("unit", "where", "said"),
    [
        ("N/m", "x", ""),
        (
            "m",
            "x",
            "u.yaml: warning: the potential is in m^3, other energies in kg*m^2/s^2; nothing is converted, "
            "'lagrange check' shows the place\n",
        ),
        ("N/m", "x + x_dot", "--where x + x_dot: warning: m and m/s are added; nothing is converted\n"),
    ],
)
def test_units_that_contradict_each_other_are_said(tmp_path, unit, where, said):
    (tmp_path / "u.yaml").write_text(LENGTHS.replace("KUNIT", unit))
    run = lagrange("section", "u.yaml", "--where", where, "--crossings", "3", cwd=tmp_path)
    assert (run.returncode, run.stderr) == (0, said)


def test_a_stroboscopic_section_has_the_periods_of_its_members(tmp_path, spring):
    told = section(spring, "--every", "pi/(2*w)", "--crossings", "4", "--over", "w=1,3", cwd=tmp_path)
    assert told["every"] == "pi/(2*w)" and "where" not in told and told["crossings"] == 8
    with h5py.File(tmp_path / "spring_section.h5") as file:
        assert file.attrs["every"] == "pi/(2*w)" and "where" not in file.attrs
        periods = math.pi / 2 / np.array([1.0, 3.0])
        assert np.abs(file["t"][()] - periods[:, None] * np.arange(1, 5)).max() < 1e-14
        assert np.abs(file["q/x"][()] - [[1, 0, -1, 0]] * 2).max() < 1e-14


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("method", ["taylor", "ias15", "DOP853", "Radau"])
def test_a_section_is_taken_with_the_method_that_the_file_or_an_option_asks_for(tmp_path, spring, method):
    """x = sin(w t)/w from x = 0: crossings after each period."""
    asked = spring.with_name("asked.yaml")
    asked.write_text(spring.read_text().replace("step: 0.1", f"step: 0.1, method: {method}"))
    for file, option in ((asked, ()), (spring, ("--method", method))):
        for cut in (("--where", "x"), ("--every", "2*pi/w")):
            more = *cut, "--crossings", "5", "--over", "w=1,2", "-o", "a.h5", "--force"
            section(file, *more, *option, cwd=tmp_path)
            with h5py.File(tmp_path / "a.h5") as found:
                assert found.attrs["method"] == method
                period = 2 * np.pi / np.array([[1], [2]])
                first = 0 if cut[0] == "--where" and found["t"][0, 0] == 0 else 1
                assert found["t"][()] == pytest.approx(period * (first + np.arange(5)), abs=1e-7)
                assert np.abs(found["q/x"][()]).max() < 1e-7


def test_the_same_section_has_the_same_bytes_whatever_the_jobs(tmp_path):
    draws = ("--where", "x", "--random", "y0=uniform(-0.2,0.4)", "--members", "30", "--crossings", "20")
    for name, jobs in (("a.h5", "1"), ("b.h5", "3")):
        section(HENON, *draws, "--jobs", jobs, "-o", name, cwd=tmp_path)
    assert (tmp_path / "a.h5").read_bytes() == (tmp_path / "b.h5").read_bytes()


@pytest.mark.exhaustive(keep=0.45)
def test_the_same_section_has_the_same_bytes_however_fast_the_machine(tmp_path, monkeypatch):
    """Compiled code returns when some time has passed; where a motion ends must not depend on that."""
    run = (SYSTEMS / "spherical_pendulum.yaml", "--where", "theta_dot", "--crossings", "20")
    for seconds in (1e-9, 1.0):
        monkeypatch.setattr(stepper, "POLL_SECONDS", seconds)
        section(*run, "--outputs", "action", "-o", f"{seconds}.h5", cwd=tmp_path)
    assert (tmp_path / "1e-09.h5").read_bytes() == (tmp_path / "1.0.h5").read_bytes()


@pytest.mark.exhaustive(keep=0.35)
def test_a_motion_that_crosses_no_more_ends(tmp_path, spring, monkeypatch):
    monkeypatch.setenv("LAGRANGE_LIMITS", "patience=100")
    told = section(spring, "--where", "x - 2", "--outputs", "q", cwd=tmp_path, status=4)
    assert told["status"] == "failed" and told["crossings"] == 0
    assert told["message"].startswith("0 crossings; the search for a further crossing ended at t = ")
    told = section(spring, "--where", "x - 2", "--force", "--over", "w=1,2", cwd=tmp_path, status=4)
    assert (
        "2 of 2 members failed; the first is member 0 (w = 1): the search for a further crossing ended"
        in told["message"]
    )
    told = section(spring, "--where", "x - 2", "--force", "--stop", "9", cwd=tmp_path)
    assert told["message"] == "0 crossings; the motion reached the stop time before 1000 crossings"


@pytest.mark.parametrize("sweep", [(), ("--over", "x=1,2")])
def test_a_pole_too_weak_to_be_felt_is_not_passed(tmp_path, sweep):
    system = "parameters: {e: 1e-18}\ncoordinates: {x: {initial: 1, velocity: -1}}\n"
    (tmp_path / "weak.yaml").write_text(system + "lagrangian: x_dot**2/2 - e/x\n")
    told = section("weak.yaml", "--where", "x + 1/2", "--direction", "either", "--stop", "5", *sweep,
                   cwd=tmp_path)  # fmt: skip
    assert (told["status"], told["crossings"]) == ("complete", 0)


def test_an_energy_that_jumps_with_these_parameters_is_refused(tmp_path):
    system = "parameters: {a: 1, b: 1}\ncoordinates: {x: {initial: 2, velocity: -2}}\n"
    (tmp_path / "jump.yaml").write_text(system + "lagrangian: x_dot**2/2 - where(x > a, x - b, 0)\n")
    asked = ("section", "jump.yaml", "--where", "x - 1/2", "--direction", "either", "--stop", "3")
    assert lagrange(*asked, cwd=tmp_path).returncode == 0
    for change in ("--set", "--over"):
        run = lagrange(*asked, change, "b=0.5", "-o", "out.h5", cwd=tmp_path)
        assert run.returncode == 3 and "'lagrangian' has a jump, where the force is infinite" in run.stderr
        assert not (tmp_path / "out.h5").exists()


FOLLOWED_ALONE = {
    "a switch": ("abs(x) - 1/2", [1 / 6, 7 / 6, 13 / 6, 19 / 6]),
    "switches": ("max(x, 0) - min(x, 0) - 1/2", [1 / 6, 7 / 6, 13 / 6, 19 / 6]),
}
"""Surfaces for which motions are not followed in lanes, and their rising zeros on sin(t), in units of pi."""


@pytest.mark.exhaustive(keep=0.55)
@pytest.mark.parametrize("case", FOLLOWED_ALONE)
def test_surfaces_that_lanes_cannot_have(case, tmp_path, spring):
    where, expected = FOLLOWED_ALONE[case]
    told = section(spring, "--where", where, "--crossings", "4", "--over", "w=1,3", cwd=tmp_path)
    assert told["status"] == "complete" and told["crossings"] == 8 and told["steps"] > 8
    with h5py.File(tmp_path / "spring_section.h5") as file:
        t = file["t"][()] * [[1.0], [3.0]] / math.pi
        assert np.abs(t / expected - 1).max() < 1e-13
        assert (file["t_end"][()] == file["t"][:, -1]).all()
    told = section(spring, "--where", where, "--direction", "falling", "--crossings", "2", "--force",
                   "--stop=-20", cwd=tmp_path)  # fmt: skip
    assert told["crossings"] == 2
    with h5py.File(tmp_path / "spring_section.h5") as file:  # x(-t) = -x(t)
        assert np.abs(file["t"][()] / math.pi / [-1 / 6, -7 / 6] - 1).max() < 1e-13


@pytest.mark.exhaustive(keep=0.4)
def test_systems_with_events(tmp_path):
    ball = SYSTEMS / "bouncing_ball.yaml"
    options = ("--where", "y - 1/2", "--direction", "either", "--stop", "3", "--crossings", "9")
    for more in ((), ("--over", "e=0.8,0.1", "--jobs", "2")):
        told = section(ball, *options, *more, "--force", cwd=tmp_path)
        assert told["status"] == "complete"
        with h5py.File(tmp_path / "bouncing_ball_section.h5") as file:
            g, t = 9.81, file["t"][()].reshape(-1, 9 if more else 3)[0, :3]
            up = 0.8 * math.sqrt(2 * g)
            rest = [(up + sign * math.sqrt(up**2 - g)) / g for sign in (-1, 1)]
            assert np.abs(t - [math.sqrt(1 / g), *(math.sqrt(2 / g) + one for one in rest)]).max() < 1e-14
            if more:
                assert file["crossings"][()].tolist() == [3, 1]
    rotor = SYSTEMS / "kicked_rotor.yaml"
    told = section(rotor, "--every", "0.6*T", "--crossings", "5", cwd=tmp_path)
    assert told["status"] == "complete" and told["crossings"] == 5


@pytest.mark.exhaustive(keep=0.55)
def test_a_motion_that_lanes_leave_ends_as_it_does_alone(tmp_path):
    fall = tmp_path / "fall.yaml"
    fall.write_text("coordinates: {r: {initial: 1.0}}\nlagrangian: r_dot**2/2 + 1/r\n")
    options = ("--where", "r - 1/2", "--direction", "falling", "--over", "r_dot=0,2", "--stop", "10")
    told = section(fall, *options, cwd=tmp_path, status=4)
    assert told["crossings"] == 1 and told["failed"] == 1 and told["complete"] == 1
    assert "the denominator r reaches 0 in 1/r (line 2) at t = 1.11072" in told["message"]
    with h5py.File(tmp_path / "fall_section.h5") as file:
        assert abs(file["t_end"][0] - math.pi / math.sqrt(8)) < 1e-12 and file["t_end"][1] == 10.0
        assert file["crossings"][()].tolist() == [1, 0]


class Impatient:
    """Interrupts the run when it is asked for the third time."""

    def __init__(self) -> None:
        self.asked = 0

    def __enter__(self) -> Impatient:
        return self

    def __exit__(self, *given: object) -> None:
        pass

    def __call__(self) -> bool:
        self.asked += 1
        return self.asked > 2


@pytest.mark.exhaustive(keep=0.3)
@pytest.mark.parametrize("sweep", [(), ("--over", "g=1,1.5")])
@pytest.mark.parametrize("cut", [("--every", "0.3"), ("--where", "x", "--direction", "either")])
def test_ledgers_of_a_section_contain_what_actions_have_changed(cut, sweep, tmp_path):
    (tmp_path / "floor.yaml").write_text(FLOOR)
    section("floor.yaml", *cut, *sweep, "--crossings", "40", "-o", "a.h5", cwd=tmp_path)
    with h5py.File(tmp_path / "a.h5") as file:
        found = {path: file[path][()] for path in ("diagnostics/h", "diagnostics/ledger/h", "q/x", "v/x")}
        assert np.ptp(found["diagnostics/h"]) > 0.1
        assert np.abs(found["diagnostics/ledger/h"]).max() < 1e-12
    if cut[0] == "--every" and not sweep:
        solved = lagrange("solve", "floor.yaml", "--stop", "12", "--step", "0.3", "-o", "b.h5", cwd=tmp_path)
        assert solved.returncode == 0, solved.stderr
        with h5py.File(tmp_path / "b.h5") as file:
            for path, values in found.items():
                assert np.abs(values - file[path][1:41]).max() < 1e-12, path


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("where", ["x", "abs(x) - 1/2"])
def test_what_an_interrupted_motion_has_found_is_kept(where, tmp_path, spring, monkeypatch):
    monkeypatch.setattr("lagrange_cli.cli.commands.section.Interrupts", Impatient)
    told = section(spring, "--where", where, "--crossings", "1000000", cwd=tmp_path, status=130)
    assert told["status"] == "interrupted" and told["crossings"] > 0
    assert re.fullmatch(rf"{told['crossings']} crossings?; interrupted", told["message"])
    with h5py.File(tmp_path / "spring_section.h5") as file:
        n = np.arange(told["crossings"])
        expected = math.pi * (n + 1 / 6 if where != "x" else 2 * (n + 1))
        assert np.abs(file["t"][()] / expected - 1).max() < 1e-12
        assert file.attrs["status"] == "interrupted"


def long(file: h5py.File, path: str) -> list[mpmath.mpf]:
    """Numbers of a double-double section."""
    return [mpmath.mpf(float(x)) + float(rest) for x, rest in zip(file[path], file[f"low/{path}"])]


@pytest.mark.exhaustive(keep=0.5)
def test_crossings_with_31_digits(tmp_path):
    """x = A sin(w t + b) with w = 1/3: numbers as they are written, and times with their low parts."""
    text = SPRING.replace("value: 1.0", "value: 1/3").replace("initial: 0.0", "initial: 0.1")
    (tmp_path / "spring.yaml").write_text(text)
    asked = ("spring.yaml", "--precision", "double-double", "--crossings", "20")
    section(*asked, "--where", "x", "-o", "where.h5", cwd=tmp_path)
    section(*asked, "--every", "1.7/w", "-o", "every.h5", cwd=tmp_path)
    with mpmath.workdps(50):
        w, size, b = mpmath.mpf(1) / 3, mpmath.hypot("0.1", 1), mpmath.atan2("0.1", 1)
        with h5py.File(tmp_path / "where.h5") as file:
            known = [(2 * mpmath.pi * (n + 1) - b) / w for n in range(20)]
            assert max(abs(t / s - 1) for t, s in zip(long(file, "t"), known)) < 1e-30
            assert max(map(abs, long(file, "q/x"))) < 1e-30 and file.attrs["h_drift"] < 1e-30
        with h5py.File(tmp_path / "every.h5") as file:
            known = [size * mpmath.sin(w * float(t) + b) for t in file["t"]]
            assert max(abs(x - y) for x, y in zip(long(file, "q/x"), known)) < 1e-29
            assert not file["low/t"][()].any()


REFUSED = {
    "members with 31 digits": (
        ("--where", "x", "--over", "w=1,2", "--precision", "double-double"),
        "--precision double-double follows one motion",
    ),
    "neither": ((), "give either --where EXPRESSION"),
    "nothing": (("--where", " "), "give either --where EXPRESSION"),
    "both": (("--where", "x", "--every", "1"), "give either --where EXPRESSION"),
    "a direction of time": (("--every", "1", "--direction", "rising"), "--direction belongs to --where"),
    "unknown": (("--where", "y"), "--where y: unknown name 'y'"),
    "an output": (("--where", "h"), "both; energies and momenta are written with these"),
    "a condition": (("--where", "x > 1"), "--where x > 1: a surface needs an expression that becomes 0"),
    "how to write it": (("--where", "x > 1"), "write --where 'x - 1' and --direction 'rising'"),
    "unfinished": (("--where", "x +"), "--where x +: missing value after '+'"),
    "a vector": (("--where", "(x, x)"), "expected a scalar"),
    "constant": (("--where", "w - 1"), "--where w - 1: this never changes"),
    "zero": (("--where", "x - x"), "--where x - x: this never changes"),
    "touched": (("--where", "x_dot**2"), "--where x_dot**2: this never changes its sign"),
    "touched from below": (("--where", "-x**2*(1 + t**2)"), "this never changes its sign"),
    "a period that moves": (("--every", "x"), "--every x: 'x' is not constant"),
    "a negative period": (("--every", "-w"), "--every -w: a period is a positive number, not -1"),
    "an infinite one": (("--every", "1/(w - 1)"), "--every 1/(w - 1): division by zero"),
    "of a member": (("--every", "w - 1", "--over", "w=2,1"), "a positive number, not 0 for member 1"),
    "too many": (("--where", "x", "--crossings", "10000000000"), "exceed the limit"),
    "a stream": (("--where", "x", "-o", "-"), "HDF5 cannot go to standard output: add --format csv"),
    "what may hide": (
        ("--where", "tanh(50*x)"),
        "zeros of this expression may be missed, as it contains exp",
    ),
    "a narrow one": (
        ("--where", "1/(1 + 100*x**2) - 1/2"),
        "zeros of this expression may be missed, as it contains exp",
    ),
    "conserved": (("--where", "x**2*w**2 + x_dot**2 - w**2"), "no motion crosses this surface"),
    "members of nothing": (("--where", "x", "--members", "3"), "no members given"),
}


@pytest.mark.exhaustive(keep=9)
@pytest.mark.parametrize("case", REFUSED)
def test_what_is_refused(case, tmp_path, spring):
    arguments, message = REFUSED[case]
    run = lagrange("section", spring, *arguments, cwd=tmp_path)
    assert run.returncode == 2 and run.stdout == ""
    assert run.stderr.startswith("Error: ") and message in " ".join(run.stderr.split())
    assert os.listdir(tmp_path) == ["spring.yaml"]


@pytest.mark.exhaustive(keep=0.2)
def test_names_of_families_particles_and_definitions(tmp_path):
    chain = tmp_path / "chain.yaml"
    chain.write_text(
        "sizes: {N: 3}\n"
        "coordinates: {u[i in range(N)]: {initial: 0.1*i, velocity: 1}}\n"
        "definitions: {far[i in range(N)]: u[i] - 1, where_all: (far[0], far[1])}\n"
        "masses: {m[i in range(N)]: 1}\n"
        "embedding: {m[i in range(N)]: [u[i]]}\n"
        "potential: 0\n"
    )
    for where, t in (
        ("u[2] - 1", 0.8), ("far[1]", 0.9), ("m[1].x + m[1].vx - 3", 1.9),
        ("sum(u[i] for i in range(N)) - N", 0.9), ("where_all.y", 0.9),
    ):  # fmt: skip
        told = section(chain, "--where", where, "--crossings", "1", "--force", "-o", "a.h5", cwd=tmp_path)
        assert told["crossings"] == 1
        with h5py.File(tmp_path / "a.h5") as file:
            assert abs(file["t"][0] - t) < 1e-14, where
    run = lagrange("section", chain, "--where", "u", cwd=tmp_path)
    assert run.returncode == 2 and "missing index on the family 'u'" in run.stderr


@pytest.mark.exhaustive(keep=0.45)
def test_a_table_without_crossings_has_its_first_line_only(tmp_path):
    run = lagrange("section", str(HENON), "--where", "x - 9", "--stop", "1", "-o", "none.csv", cwd=tmp_path)
    assert run.returncode == 0 and "0 crossings; the motion reached the stop time" in run.stdout, run.stderr
    [head] = (tmp_path / "none.csv").read_text().splitlines()
    assert head.startswith("t,x,y,")
