"""``lagrange sweep`` as a user runs it; what it wrote is read back and compared with single solves."""

import json
import math
import os
import resource
import signal
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray

from tests.cli.test_solve import datasets
from tests.support.command import PATIENCE, SYSTEMS, environment, lagrange, lagrange_process, wait_until

HOOP = SYSTEMS / "rotating_hoop.yaml"
FALL = """
parameters: {G: 1.0}
coordinates: {r: {initial: 1.0}}
masses: {stone: 1}
embedding: {stone: [r]}
potential: -G/r
solve: {stop: 3, samples: 31}
"""
"""A stone above a point mass: it falls onto it unless it is fast enough to escape, at r_dot = sqrt(2)."""

ROUNDING = 1e-12
"""An engine that works on several members at once may round otherwise than one that works on one."""


def sweep_json(*arguments: str | Path, cwd: Path, status: int = 0) -> dict:
    run = lagrange("sweep", "--json", *arguments, cwd=cwd)
    assert run.returncode == status, run.stderr
    return json.loads(run.stdout)


@pytest.mark.exhaustive(keep=0.35)
def test_a_grid_from_the_command_to_the_file(tmp_path):
    grid = ("--over", "omega=0:10:5", "--over", "theta=-1,0.5")
    run = lagrange_process("sweep", HOOP, *grid, cwd=tmp_path)
    assert (run.returncode, run.stderr) == (0, "")
    assert run.stdout.startswith("bead on a rotating hoop: 10 members (5 omega x 2 theta)\n")
    assert "10 reached the end" in run.stdout and "wrote rotating_hoop_sweep.h5" in run.stdout
    assert os.listdir(tmp_path) == ["rotating_hoop_sweep.h5"]
    with h5py.File(tmp_path / "rotating_hoop_sweep.h5") as file:
        assert datasets(file) == {"omega": (5,), "theta_0": (2,)} | dict.fromkeys(
            (
                "member", "initial/q/theta", "initial/v/theta", "t_end", "steps",
                "status", "message", "q/theta", "v/theta", "diagnostics/p/theta", "diagnostics/h",
                "diagnostics/drift/h",
            ),
            (5, 2),
        )  # fmt: skip
        assert file["parameters/omega"][()].tolist() == [0, 2.5, 5, 7.5, 10]
        assert file["member"][()].tolist() == [[0, 1], [2, 3], [4, 5], [6, 7], [8, 9]]
        assert file["initial/q/theta"][()].tolist() == [[-1, 0.5]] * 5
        assert set(file["t_end"][()].flat) == {20.0} and set(file["status"][()].flat) == {b"complete"}
        assert set(file["message"][()].flat) == {b"reached the end"} and file["steps"][()].min() > 0
        assert json.loads(file.attrs["parameters"]) == {"m": 0.2, "g": 9.81, "a": 0.5}
        assert json.loads(file.attrs["sweep"]) == {
            "shape": {"omega": 5, "theta": 2},
            "over": {"omega": "0:10:5", "theta": "-1,0.5"},
        }
        assert file.attrs["spec"] == HOOP.read_text(encoding="utf-8")
        assert all(file[path].attrs["long_name"] for path in datasets(file))
        assert file["q/theta"].attrs["unit"] == file["initial/q/theta"].attrs["unit"] == "rad"
        assert file["parameters/omega"].attrs["unit"] == "rad/s"
        assert file.attrs["h_drift"] == file["diagnostics/drift/h"][()].max() < 1e-13


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize(
    ("system", "name", "sets"),
    [
        ("double_pendulum", "theta1", {"l1": "0.7"}),
        ("driven_damped_pendulum", "theta", {}),
        ("lattice", "u[1,1]", {}),
        ("central_force", "r_dot", {}),
        ("gauge_oscillator", "m", {}),
    ],
)
def test_each_member_is_the_single_motion_that_set_would_give(tmp_path, system, name, sets):
    values = ["0.8", "1.1", "1.3"]
    given = [x for pair in sets.items() for x in ("--set", "=".join(pair))] + ["--stop", "5"]
    file = SYSTEMS / f"{system}.yaml"
    over = ["--over", f"{name}={','.join(values)}", *given]
    sampled = ["--outputs", "all", "--samples", "11"]
    ends = sweep_json(file, *over, "-o", "ends.h5", cwd=tmp_path)
    ways = sweep_json(file, *over, *sampled, "-o", "ways.h5", cwd=tmp_path)
    for member, value in enumerate(values):
        run = lagrange(
            "solve",
            file,
            "--set",
            f"{name}={value}",
            *given,
            *sampled,
            "-o",
            f"{member}.h5",
            "--json",
            cwd=tmp_path,
        )
        alone = json.loads(run.stdout)
        with (
            h5py.File(tmp_path / f"{member}.h5") as one,
            h5py.File(tmp_path / "ways.h5") as many,
            h5py.File(tmp_path / "ends.h5") as last,
        ):
            series = {path: shape for path, shape in datasets(one).items() if shape[0] == 11}
            assert set(series) - {"t"} == {
                path for path, shape in datasets(many).items() if shape[1:2] == (11,)
            }
            np.testing.assert_array_equal(many["t"], one["t"])
            for path in set(series) - {"t"}:
                scale = ROUNDING * max(1.0, np.abs(one[path][()]).max())
                np.testing.assert_allclose(many[path][member], one[path][()], rtol=0, atol=scale)
                if path in last:
                    np.testing.assert_allclose(last[path][member], one[path][-1], rtol=0, atol=scale)
            assert many["t_end"][member] == alone["t"] == 5
            assert ends["status"] == ways["status"] == alone["status"] == "complete"
            for path in ("initial/q", "initial/v"):
                for each, dataset in many[path].items():
                    if isinstance(many[path].get(each, getlink=True), h5py.HardLink):
                        np.testing.assert_array_equal(dataset[member], one[f"{path[-1]}/{each}"][0])


def test_what_depends_on_what_is_swept_differs_too(tmp_path):
    (tmp_path / "spring.yaml").write_text(
        "parameters: {m: 2.0, w: 3.0, k: m*w**2}\ncoordinates: {x: {initial: w/m}}\nmasses: {b: m}\n"
        "embedding: {b: [x]}\npotential: k*x**2/2\nsolve: {stop: 1}\n"
    )
    sweep_json("spring.yaml", "--over", "m=1,4", "--set", "w=2", cwd=tmp_path)
    with h5py.File(tmp_path / "spring_sweep.h5") as file:
        assert file["parameters/k"][()].tolist() == [4, 16]
        assert file["initial/q/x"][()].tolist() == [2, 0.5]
        np.testing.assert_allclose(file["q/x"], np.array([2, 0.5]) * math.cos(2), rtol=1e-14)
        assert json.loads(file.attrs["parameters"]) == {"w": 2.0}


def test_xarray_reads_members_times_and_families(tmp_path):
    options = [
        "--over",
        "alpha=0,0.25",
        "--size",
        "N=4",
        "--size",
        "modes=4",
        "--stop",
        "2",
        "--samples",
        "3",
    ]
    sweep_json(SYSTEMS / "fpu_chain.yaml", *options, "--outputs", "q,h", cwd=tmp_path)
    with xarray.open_dataset(tmp_path / "fpu_chain_sweep.h5", group="q", engine="h5netcdf") as data:
        (name,) = data.data_vars
        assert data[name].dims == ("alpha", "t", "N")
        assert data[name].shape == (2, 3, 4)
        assert data["t"].values.tolist() == [0, 1, 2] and data["alpha"].values.tolist() == [0, 0.25]


GRID = [HOOP, "--over", "omega=4:5:11", "--over", "theta=0:1:5", "--stop", "1", "--samples", "3"]


@pytest.mark.exhaustive(keep=0.45)
def test_what_is_swept_are_the_dimensions(tmp_path):
    sweep_json(*GRID, "--outputs", "q", "-o", "all.h5", cwd=tmp_path)
    with xarray.open_dataset(tmp_path / "all.h5", group="q", engine="h5netcdf") as q:
        theta = q.theta.load()
    assert theta.dims == ("omega", "theta_0", "t") and theta.shape == (11, 5, 3)
    np.testing.assert_array_equal(theta.omega, np.linspace(4, 5, 11))
    np.testing.assert_array_equal(theta.isel(t=0), np.tile(theta.theta_0, (11, 1)))
    one = theta.sel(omega=4.4, theta_0=0.5, method="nearest")
    assert one.member == 4 * 5 + 2
    sweep_json(*GRID[:1], "--over", "omega=4.4", "--set", "theta=0.5", *GRID[5:], "--outputs", "q", "-o",
               "one.h5", cwd=tmp_path)  # fmt: skip
    with h5py.File(tmp_path / "one.h5") as file:
        assert file["q/theta"].shape == (1, 3)
        np.testing.assert_allclose(one, file["q/theta"][0], atol=ROUNDING)
    flat = theta.stack(run=("omega", "theta_0")).swap_dims(run="member")
    np.testing.assert_array_equal(flat.member, np.arange(55))
    assert (flat.sel(member=22, t=0), flat.omega[22]) == (0.5, theta.omega[4])
    tree = xarray.open_datatree(tmp_path / "all.h5", engine="h5netcdf")
    assert tree["q"]["theta"].sel(omega=5, theta_0=1).member == tree["status"].member[-1, -1] == 54
    assert tree["initial/v/theta"].dims == tree["t_end"].dims == ("omega", "theta_0")
    tree.close()


def test_a_dimension_has_a_name_of_its_own(tmp_path):
    (tmp_path / "spring.yaml").write_text(
        "parameters: {q: 2.0, member: 1.0, message: 1.0, k: 2*q}\ncoordinates: {x: {initial: 1}}\n"
        "masses: {b: member}\nembedding: {b: [x]}\npotential: message*k*x**2/2\nsolve: {stop: 1}\n"
    )
    swept = ["q=1,2", "x=1,2,3", "x_dot=0,1", "member=1,2", "message=1,2"]
    options = [x for text in swept for x in ("--over", text)]
    sweep_json("spring.yaml", *options, cwd=tmp_path)
    with h5py.File(tmp_path / "spring_sweep.h5") as file:
        assert [scale.keys()[0] for scale in file["q/x"].dims] == [
            "q_", "x_0", "x_dot_0", "member", "message_",
        ]  # fmt: skip
        assert file["parameters/q"][()].tolist() == file["parameters/message"][()].tolist() == [1, 2]
        assert file["parameters/k"][:, 0, 0, 0, 0].tolist() == [2, 4]
        assert file["member_"].shape == file["message"].shape == (2, 3, 2, 2, 2)
    with xarray.open_dataset(tmp_path / "spring_sweep.h5", group="q", engine="h5netcdf") as q:
        assert q.x.sel(q_=2, x_0=3, x_dot_0=0, member=1, message_=2).member_ == 24 + 16 + 1


@pytest.mark.exhaustive(keep=3)
@pytest.mark.parametrize(
    ("options", "dimensions"),
    [
        (["--table", "runs.csv"], {"member": 2}),
        (["--random", "m=uniform(1,2)", "--members", "3"], {"member": 3}),
        (["--table", "runs.csv", "--random", "m=uniform(1,2)"], {"member": 2}),
        (["--table", "runs.csv", "--random", "m=uniform(1,2)", "--members", "3"], {"row": 2, "draw": 3}),
        (["--random", "m=uniform(1,2)", "--over", "a=1,2,3"], {"a": 3}),
        (["--members", "2", "--random", "m=uniform(1,2)", "--over", "a=1,2,3", "--table", "runs.csv"],
         {"row": 2, "a": 3, "draw": 2}),
    ],
)  # fmt: skip
def test_rows_and_draws_are_dimensions_of_a_grid(tmp_path, options, dimensions):
    (tmp_path / "runs.csv").write_text("theta\n0.5\n-0.25\n")
    sweep_json(HOOP, *options, "--stop", "1", cwd=tmp_path)
    with xarray.open_dataset(tmp_path / "rotating_hoop_sweep.h5", group="q", engine="h5netcdf") as q:
        assert dict(q.theta.sizes) == dimensions
        np.testing.assert_array_equal(np.ravel(q.member), np.arange(q.theta.size))


def test_random_members_are_the_same_for_the_same_seed(tmp_path):
    def drawn(*options):
        sweep_json(HOOP, "--random", "theta=normal(0,0.1)", "--force", "--stop", "1", *options, cwd=tmp_path)
        with h5py.File(tmp_path / "rotating_hoop_sweep.h5") as file:
            return file["q/theta"][()].tolist(), json.loads(file.attrs["sweep"])

    few, said = drawn("--members", "4")
    assert said == {"shape": {"draws of --random": 4}, "random": {"theta": "normal(0,0.1)"}, "seed": 0}
    assert drawn("--members", "12", "--seed", "0")[0][:4] == few
    assert not set(drawn("--members", "4", "--seed", "7")[0]) & set(few)
    summary = lagrange("sweep", HOOP, "--random", "theta=normal(0,0.1)", "--members", "2", "--stop", "1",
                       "-o", "said.h5", cwd=tmp_path).stdout  # fmt: skip
    assert "2 members (2 draws of --random, seed 0)" in summary


def test_a_table_of_members(tmp_path):
    (tmp_path / "runs.csv").write_text("theta,omega\n0.5,1\n-0.25,2e0\n")
    answer = sweep_json(HOOP, "--table", "runs.csv", "--set", "a=1", cwd=tmp_path)
    assert answer["members"] == 2
    with h5py.File(tmp_path / "rotating_hoop_sweep.h5") as file:
        assert file["initial/q/theta"][()].tolist() == [0.5, -0.25]
        assert file["parameters/omega"][()].tolist() == [1, 2]
        assert json.loads(file.attrs["sweep"]) == {"shape": {"rows of runs.csv": 2}, "table": "runs.csv"}


@pytest.mark.exhaustive(keep=0)
@pytest.mark.parametrize(
    "outputs", [[], ["--outputs", "all", "--samples", "7"]], ids=["ends", "trajectories"]
)
def test_the_bytes_depend_on_nothing_but_the_ensemble(tmp_path, outputs):
    content = []
    for number, jobs in enumerate((["--jobs", "1"], ["--jobs", "2"], ["--jobs", "5", "--no-cache"], [])):
        (tmp_path / str(number)).mkdir()
        options = ["--over", "theta=-3:3:53", "--over", "omega=1,5", "--stop", "9", *outputs, *jobs]
        sweep_json(HOOP, *options, cwd=tmp_path / str(number))
        content.append((tmp_path / str(number) / "rotating_hoop_sweep.h5").read_bytes())
    assert content.count(content[0]) == 4


@pytest.mark.exhaustive(keep=0.55)
def test_members_that_cannot_be_followed_are_kept_and_named(tmp_path):
    (tmp_path / "fall.yaml").write_text(FALL)
    options = ["fall.yaml", "--over", "r_dot=2,0,1.5,-1"]
    answer = sweep_json(*options, "--outputs", "q", cwd=tmp_path, status=4)
    assert (answer["status"], answer["complete"], answer["failed"]) == ("failed", 2, 2)
    assert answer["message"].startswith(
        "2 of 4 members failed; the first is member 1 (r_dot = 0): the denominator r reaches 0 in -G/r"
    )
    with h5py.File(tmp_path / "fall_sweep.h5") as file:
        assert file["status"][()].tolist() == [b"complete", b"failed"] * 2
        assert file["message"][0] == b"reached the end"
        assert file["message"][1].startswith(b"the step size fell below the resolution of time")
        assert file["t_end"][1] == pytest.approx(math.pi / math.sqrt(8), rel=1e-3)  # free fall
        assert file["t_end"][3] < file["t_end"][1] < file["t_end"][0] == 3
        t, r = file["t"][()], file["q/r"][()]
        assert np.isfinite(r[[0, 2]]).all()
        for member in (1, 3):
            np.testing.assert_array_equal(np.isfinite(r[member]), t <= file["t_end"][member])
        assert file.attrs["status"] == "failed" and file.attrs["message"] == answer["message"]
    run = lagrange("sweep", *options, "-o", "ends.h5", cwd=tmp_path)
    assert run.returncode == 4 and "2 reached the end, 2 failed" in run.stdout
    assert run.stderr == f"fall: {answer['message']}\n"
    with h5py.File(tmp_path / "ends.h5") as file:
        assert 0 <= file["q/r"][1] < 1e-2 and np.isfinite(file["diagnostics/h"]).all()


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_keeps_the_members_that_have_ended(tmp_path, number):
    process = subprocess.Popen(
        [sys.executable, "-m", "lagrange_cli", "sweep", "--json", "--over", "theta=0:3:50000",
         "--stop", "100", "--jobs", "1", str(HOOP)],
        cwd=tmp_path,
        env=environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )  # fmt: skip
    wait_until((tmp_path / ".rotating_hoop_sweep.h5.part").exists, process)
    process.send_signal(number)
    out, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130, err
    assert "interrupted after" in err and "Traceback" not in err
    answer = json.loads(out)
    assert answer["status"] == "interrupted" and answer["failed"] == 0
    assert answer["complete"] + answer["interrupted"] == 50000 and answer["interrupted"] > 0
    assert os.listdir(tmp_path) == ["rotating_hoop_sweep.h5"]
    with h5py.File(tmp_path / "rotating_hoop_sweep.h5") as file:
        done = file["status"][()] == b"complete"
        assert done.sum() == answer["complete"]
        np.testing.assert_array_equal(np.isfinite(file["q/theta"][()]), done)
        assert set(file["message"][~done]) == {b"interrupted"}
        assert np.isfinite(file["initial/q/theta"][()]).all()


@pytest.mark.parametrize(
    ("arguments", "status", "message"),
    [
        ([], 2, "no members given: add --over"),
        (["--over", "omega"], 2, "'omega' is not NAME=VALUE, as in --over omega=0:10:101"),
        (["--over", "omga=1,2"], 2, "did you mean 'omega'?"),
        (
            ["--over", "a=1,0"],
            2,
            "member 1 cannot be run: --set a=0.0: division by zero in parameter 'omega'",
        ),
        (["--over", "m=-1,1"], 2, "member 0 cannot be run: --set m=-1.0: the value -1 is not positive"),
        (["--over", "m=1,2", "--set", "m=3"], 2, "'m' is given more than once"),
        (["--random", "m=normal(0,1)", "--members", "0"], 2, "'0' is not a whole number of at least 1"),
        (
            ["--random", "m=uniform(1,2)", "--members", "3", "--seed", "-1"],
            2,
            "'-1' is not a whole number of at least 0",
        ),
        (["--over", "m=1,2", "--samples", "5"], 2, "add --outputs q,v to write samples"),
        (["--over", "m=1,2", "--outputs", "q", "--samples", "9999999"], 2, "use fewer --samples"),
        (["--over", "m=1,2", "--outputs", "qq"], 2, "unknown output 'qq'"),
        (["--over", "m=1,2", "--jobs", "0"], 2, "'0' is not a whole number of at least 1"),
        (["--over", "m=1,2", "-o", "-"], 2, "cannot be written to standard output"),
        (["--table", "nosuch.csv"], 5, "nosuch.csv could not be read: No such file or directory"),
        (["--over", "m=1,2", "-o", "nowhere/out.h5"], 5, "there is no directory"),
    ],
)
def test_what_makes_no_sense_is_one_clear_message(tmp_path, arguments, status, message):
    run = lagrange("sweep", HOOP, *arguments, cwd=tmp_path)
    assert (run.returncode, run.stdout) == (status, "")
    assert message in " ".join(run.stderr.split()) and "Traceback" not in run.stderr
    assert os.listdir(tmp_path) == []


def test_mistakes_in_the_system_keep_their_place(tmp_path):
    (tmp_path / "fall.yaml").write_text(FALL.replace("-G/r", "-G/rr"))
    run = lagrange("sweep", "fall.yaml", "--over", "G=1,2", cwd=tmp_path)
    assert run.returncode == 3 and run.stderr.startswith("fall.yaml:6:15: unknown name 'rr' in potential")
    answer = sweep_json("fall.yaml", "--over", "G=1,2", cwd=tmp_path, status=3)
    assert (answer["status"], answer["exit_code"]) == ("failed", 3)


def test_the_table_is_not_overwritten_by_another_name(tmp_path):
    (tmp_path / "runs.csv").write_text("m\n1\n2\n")
    (tmp_path / "out.h5").symlink_to("runs.csv")
    for command in (["sweep"], ["section", "--where", "theta"]):
        run = lagrange(*command, HOOP, "--table", "runs.csv", "-o", "out.h5", "--force", cwd=tmp_path)
        assert run.returncode == 2 and "out.h5 is read by this command: give --output" in run.stderr
    assert (tmp_path / "runs.csv").read_text() == "m\n1\n2\n"


def test_an_existing_file_is_kept_unless_forced(tmp_path):
    (tmp_path / "rotating_hoop_sweep.h5").write_text("precious")
    run = lagrange("sweep", HOOP, "--over", "m=1,2", cwd=tmp_path)
    assert run.returncode == 5 and "already exists" in run.stderr
    assert (tmp_path / "rotating_hoop_sweep.h5").read_text() == "precious"
    sweep_json(HOOP, "--over", "m=1,2", "--force", cwd=tmp_path)
    assert h5py.is_hdf5(tmp_path / "rotating_hoop_sweep.h5")


def test_system_and_table_from_standard_input(tmp_path):
    run = lagrange("sweep", HOOP, "--table", "-", "--json", cwd=tmp_path, input="theta\n1\n2\n")
    assert json.loads(run.stdout)["members"] == 2
    text = HOOP.read_text(encoding="utf-8")
    run = lagrange("sweep", "-", "--over", "m=1,2", "--json", cwd=tmp_path, input=text)
    assert json.loads(run.stdout)["output"] == "stdin_sweep.h5"
    run = lagrange("sweep", "-", "--table", "-", "--force", cwd=tmp_path, input=text)
    assert run.returncode == 2 and "cannot both come from standard input" in run.stderr


@pytest.mark.exhaustive(keep=0.4)
def test_a_full_disk_is_one_clear_message(tmp_path):
    run = lagrange_process(
        "sweep", HOOP, "--over", "theta=0:1:2000", "--outputs", "q", "--stop", "1", cwd=tmp_path,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (1_000_000, 1_000_000)),
    )  # fmt: skip
    assert (run.returncode, run.stdout) == (5, "")
    assert run.stderr == "Error: rotating_hoop_sweep.h5 could not be written: File too large\n"
    assert os.listdir(tmp_path) == []


MEMORY = """
import resource, sys
from lagrange_cli.cli.main import main
for members in sys.argv[2:]:
    options = ["--over", f"theta=0:3:{members}", "--stop", "1", "--samples", "10001", "--outputs", "q,v"]
    assert main(["sweep", sys.argv[1], *options, "--quiet", "-o", f"{members}.h5"]) == 0
    print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024))
"""


@pytest.mark.exhaustive(keep=0)
def test_memory_does_not_grow_with_members_times_samples(tmp_path):
    run = subprocess.run(
        [sys.executable, "-c", MEMORY, str(HOOP), "300", "3000"],
        cwd=tmp_path, env=environment(), capture_output=True, text=True,
    )  # fmt: skip
    assert (run.returncode, run.stderr) == (0, "")
    few, many = map(int, run.stdout.split())
    size = (tmp_path / "3000.h5").stat().st_size
    assert size > 3000 * 10001 * 2 * 8
    assert many - few < size / 10


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("method", ["DOP853", "LSODA"])
def test_scipys_methods_follow_members_too(tmp_path, method):
    options = ["--over", "theta=0.5,1", "--stop", "2"]
    sweep_json(HOOP, *options, cwd=tmp_path)
    sweep_json(HOOP, *options, "--method", method, "-o", "other.h5", cwd=tmp_path)
    with h5py.File(tmp_path / "rotating_hoop_sweep.h5") as one, h5py.File(tmp_path / "other.h5") as other:
        assert other.attrs["method"] == method
        np.testing.assert_allclose(other["q/theta"], one["q/theta"], rtol=1e-7)


def test_quiet_and_timings(tmp_path):
    assert lagrange("sweep", HOOP, "--over", "m=1,2", "--quiet", cwd=tmp_path).stdout == ""
    said = lagrange("sweep", HOOP, "--over", "m=1,2", "--force", "--timings", cwd=tmp_path).stdout
    assert "integrating the motion" in said and "writing the output" in said


def test_a_step_that_does_not_divide_the_time_is_followed_by_a_sample_at_the_end(tmp_path):
    options = ["--stop", "1", "--step", "0.3", "--over", "theta=1,2", "--outputs", "q", "--quiet"]
    assert lagrange("sweep", SYSTEMS / "pendulum.yaml", *options, cwd=tmp_path).returncode == 0
    with h5py.File(tmp_path / "pendulum_sweep.h5") as file:
        np.testing.assert_allclose(file["t"], [0, 0.3, 0.6, 0.9, 1], rtol=1e-15)
        assert np.isfinite(file["q/theta"]).all()


MISSED = {
    "narrow": ("exp(-10**6*x**2)", "does not detect narrow forces hidden in exp"),
    "kink": ("abs(x)", "does not locate the instants at which abs"),
}


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize("name", MISSED)
@pytest.mark.parametrize("method", ["taylor", "LSODA"])
def test_what_a_method_may_pass_over_is_said(tmp_path, name, method):
    potential, said = MISSED[name]
    system = f"coordinates: {{x: {{initial: -1, velocity: 1}}}}\nlagrangian: x_dot**2/2 - {potential}\n"
    (tmp_path / "x.yaml").write_text(system)
    asked = ("sweep", "x.yaml", "--over", "x=-1,-2", "--method", method, "--stop", "5", "-o", "out.h5")
    run = lagrange(*asked, cwd=tmp_path)
    assert run.returncode == 0 and (f"{method} {said}" in run.stderr) is (method == "LSODA")
    told = sweep_json(*asked[1:], "--force", cwd=tmp_path)["warning"]
    with h5py.File(tmp_path / "out.h5") as file:
        assert file.attrs.get("warning") == told
    assert run.stderr == ("" if told is None else f"x: warning: {told}\n")
