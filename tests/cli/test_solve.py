"""``lagrange solve`` as a user runs it; what it wrote is read back through h5py."""

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
import yaml

from lagrange_cli.cli.main import main
from lagrange_cli.run import motion
from tests.support.command import PATIENCE, SYSTEMS, environment, lagrange, lagrange_process, wait_until

PENDULUM = SYSTEMS / "pendulum.yaml"
JSON_KEYS = {"name", "output", "status", "message", "method", "tolerance", "steps", "t", "h_drift", "p_drift"}
STAGES = {"import", "cache", "parse", "derive", "compile", "integrate", "write", "total"}
ROOT_ATTRIBUTES = [
    "generator",
    "name",
    "spec",
    "parameters",
    "method",
    "tolerance",
    "run",
    "steps",
    "status",
    "message",
    "h_drift",
    "p_drift",
    "final",
]


def datasets(file: h5py.File) -> dict[str, tuple[int, ...]]:
    """The shapes of all datasets by path (soft links are not followed)."""
    found: dict[str, tuple[int, ...]] = {}
    file.visititems(lambda path, item: found.update({path: item.shape}) if hasattr(item, "shape") else None)
    return found


def solve_json(*arguments: str | Path, cwd: Path) -> dict:
    run = lagrange("solve", "--json", *arguments, cwd=cwd)
    assert (run.returncode, run.stderr) == (0, "")
    return json.loads(run.stdout)


@pytest.mark.exhaustive(keep=0.65)
def test_the_main_job(tmp_path):
    run = lagrange_process("solve", PENDULUM, cwd=tmp_path)
    assert (run.returncode, run.stderr) == (0, "")
    assert run.stdout.startswith("pendulum: 1 degree of freedom")
    assert "drift: h " in run.stdout and "wrote pendulum.h5" in run.stdout
    assert os.listdir(tmp_path) == ["pendulum.h5"]
    defaults = yaml.safe_load(PENDULUM.read_text(encoding="utf-8"))["solve"]
    with h5py.File(tmp_path / "pendulum.h5") as file:
        n = len(file["t"])
        assert datasets(file) == dict.fromkeys(
            ("t", "q/theta", "v/theta", "diagnostics/p/theta", "diagnostics/h"), (n,)
        )
        assert (file["t"][0], file["t"][-1]) == (0.0, defaults["stop"])
        assert list(file.attrs) == sorted(ROOT_ATTRIBUTES)  # h5py lists them by name
        assert file.attrs["status"] == "complete"
        assert file.attrs["spec"] == PENDULUM.read_text(encoding="utf-8")
        assert json.loads(file.attrs["parameters"]) == {"m": 1.0, "l": 1.0, "g": 9.81}
        assert file["q/theta"].attrs["unit"] == "rad"
        assert all(file[path].attrs["long_name"] for path in datasets(file))
        assert file["q/theta"][0] == math.radians(170)
        h = file["diagnostics/h"][()]
        assert np.abs(h - h[0]).max() <= 1e-12 * 9.81


def test_the_json_object_says_what_the_file_says(tmp_path):
    answer = solve_json(SYSTEMS / "central_force.yaml", cwd=tmp_path)
    assert set(answer) >= JSON_KEYS | {"seconds"}
    assert set(answer["seconds"]) == STAGES
    assert all(seconds >= 0 for seconds in answer["seconds"].values())
    assert list(answer["p_drift"]) == ["theta"]
    with h5py.File(tmp_path / answer["output"]) as file:
        for key in ("name", "status", "message", "method", "tolerance", "steps", "h_drift"):
            assert file.attrs[key] == answer[key]
        assert json.loads(file.attrs["p_drift"]) == answer["p_drift"]
        assert file["t"][-1] == answer["t"]
        h, p = file["diagnostics/h"][()], file["diagnostics/p/theta"][()]
        assert np.abs(h - h[0]).max() <= answer["h_drift"] * (1 + 1e-12)
        assert np.abs(p - p[0]).max() <= answer["p_drift"]["theta"] * (1 + 1e-12)


@pytest.mark.exhaustive(keep=0.55)
def test_the_final_state_is_that_of_the_last_sample(tmp_path):
    answer = solve_json(SYSTEMS / "n_pendulum.yaml", "--stop", "1", "--outputs", "q,v", cwd=tmp_path)
    with h5py.File(tmp_path / "n_pendulum.h5") as file:
        assert answer["final"]["t"] == file["t"][-1] == 1
        for kind in "qv":
            values = answer["final"][kind]
            assert list(values) == [f"theta[{i}]" for i in range(5)]
            assert list(values.values()) == file[f"{kind}/theta"][-1].tolist()
        assert json.loads(file.attrs["final"]) == answer["final"]
    run = lagrange("solve", SYSTEMS / "n_pendulum.yaml", "--stop", "1", "--outputs", "h", cwd=tmp_path)
    assert run.returncode == 5  # it was made with other outputs
    run = lagrange("solve", SYSTEMS / "n_pendulum.yaml", "--stop", "1", "-o", "h.h5", cwd=tmp_path)
    line = next(line for line in run.stdout.splitlines() if "at t = 1: " in line)
    assert f"theta_dot[1] = {answer['final']['v']['theta[1]']:.6g} (and 3 more coordinates)" in line


@pytest.mark.exhaustive(keep=0.15)
def test_what_is_conserved_without_a_cyclic_coordinate(tmp_path):
    """It is written, its drift is reported, and check tells the same names."""
    system = SYSTEMS / "figure_eight.yaml"
    answer = solve_json(system, "--stop", "2", "--samples", "5", "--outputs", "conserved", cwd=tmp_path)
    names = ["P_x", "P_y", "L_z", "K_x", "K_y"]
    assert list(answer["p_drift"]) == [f"conserved/{name}" for name in names]
    assert max(answer["p_drift"].values()) < 1e-14
    with h5py.File(tmp_path / "figure_eight.h5") as file:
        assert set(file["diagnostics/conserved"]) >= {"h", *names}
        assert file["diagnostics/conserved/L_z"].attrs["long_name"] == "L_z = sum of x*m*vy - y*m*vx"
    told = json.loads(lagrange("check", "--json", system, cwd=tmp_path).stdout)
    assert [each["quantity"] for each in told["conserved"]] == ["h", *names]
    options = ("--over", "x_dot[0]=0.3,0.4", "--stop", "2", "--samples", "3", "--outputs", "conserved")
    run = lagrange("sweep", system, *options, cwd=tmp_path)
    assert run.returncode == 0 and ", L_z " in run.stdout


@pytest.mark.exhaustive(keep=0.6)
def test_reactions_are_refused_where_the_force_is_not_known(tmp_path):
    """Unless they are only among all."""
    system = tmp_path / "a.yaml"
    system.write_text(
        "coordinates: {a: {initial: 1}}\nmasses: {bob: 1}\npositions: {bob: [sin(a), -cos(a)]}\n"
        "potential: -9.81*cos(a)\nsolve: {stop: 1}\n"
    )
    run = lagrange("solve", system, "--outputs", "reactions", cwd=tmp_path)
    assert run.returncode == 2 and not (tmp_path / "a.h5").exists()
    assert run.stderr == (
        "Error: no output 'reactions': the force on 'bob' is not known, since U contains the coordinate 'a'; "
        "write it in positions, such as bob.x\n"
    )
    assert lagrange("solve", system, "--outputs", "all", cwd=tmp_path).returncode == 0
    with h5py.File(tmp_path / "a.h5") as file:
        assert "reactions" not in file and "positions" in file


def test_all_outputs_of_a_system_of_particles(tmp_path):
    solve_json(PENDULUM, "--outputs", "all", "--samples", "5", cwd=tmp_path)
    with h5py.File(tmp_path / "pendulum.h5") as file:
        expected = {
            "t", "q/theta", "v/theta", "diagnostics/p/theta", "diagnostics/h", "diagnostics/T",
            "diagnostics/U", "diagnostics/energy", "diagnostics/ledger/h", "diagnostics/ledger/p/theta",
            "diagnostics/action", "positions/bob", "reactions/bob",
            "diagnostics/conserved/h",
        }  # fmt: skip
        found = datasets(file)
        assert set(found) - {"x", "xy", "xyz"} == expected
        assert found["positions/bob"][0] == 5
        np.testing.assert_allclose(
            file["diagnostics/T"][()] + file["diagnostics/U"][()], file["diagnostics/energy"][()], atol=1e-14
        )


def test_only_what_is_asked_for_is_written(tmp_path):
    solve_json(PENDULUM, "--outputs", "T, positions", "--samples", "5", cwd=tmp_path)
    with h5py.File(tmp_path / "pendulum.h5") as file:
        assert set(datasets(file)) - {"x", "xy", "xyz"} == {"t", "diagnostics/T", "positions/bob"}


@pytest.mark.exhaustive(keep=3)
@pytest.mark.parametrize(
    ("options", "times"),
    [
        (["--samples", "5", "--stop", "2"], [0, 0.5, 1, 1.5, 2]),
        (["--step", "0.3", "--stop", "1"], [0, 0.3, 0.6, 0.9, 1]),
        (["--step", "0.3", "--stop", "1", "--method", "DOP853"], [0, 0.3, 0.6, 0.9, 1]),
        (["--step", "0.3", "--stop", "1", "--precision", "double-double"], [0, 0.3, 0.6, 0.9, 1]),
        (["--step", "0.1", "--stop", "0.3"], [0, 0.1, 0.2, 0.3]),
    ],
)
def test_samples_are_where_they_were_asked_for(tmp_path, options, times):
    solve_json(PENDULUM, *options, cwd=tmp_path)
    with h5py.File(tmp_path / "pendulum.h5") as file:
        np.testing.assert_allclose(file["t"], times, rtol=1e-15)


def test_set_changes_parameters_and_the_initial_state(tmp_path):
    options = ["--set", "l=2*m", "--set", "theta=pi/6", "--set", "theta_dot=0.5", "--set", "m=1.5"]
    solve_json(PENDULUM, *options, "--samples", "2", cwd=tmp_path)
    with h5py.File(tmp_path / "pendulum.h5") as file:
        assert json.loads(file.attrs["parameters"]) == {"m": 1.5, "l": 3.0, "g": 9.81}
        assert (file["q/theta"][0], file["v/theta"][0]) == (math.pi / 6, 0.5)


@pytest.mark.exhaustive(keep=0.4)
def test_the_same_run_gives_the_same_bytes(tmp_path):
    for name in ("first", "second"):
        (tmp_path / name).mkdir()
        run = lagrange_process("solve", SYSTEMS / "double_pendulum.yaml", cwd=tmp_path / name)
        assert run.returncode == 0
    first, second = (tmp_path / name / "double_pendulum.h5" for name in ("first", "second"))
    assert first.read_bytes() == second.read_bytes()


def test_standard_input_is_a_system_file_too(tmp_path):
    run = lagrange("solve", "-", cwd=tmp_path, input=PENDULUM.read_text(encoding="utf-8"))
    assert (run.returncode, os.listdir(tmp_path)) == (0, ["stdin.h5"])


def test_an_existing_output_is_kept_and_reported_before_any_work(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "pendulum.h5").write_text("precious")
    monkeypatch.setattr(motion, "prepare_run", None)
    assert main(["solve", str(PENDULUM)]) == 5
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err == "Error: pendulum.h5 already exists: --force replaces it, --output names another\n"
    assert (tmp_path / "pendulum.h5").read_text() == "precious"


FIRST = {
    "no such file": (["p.yaml"], 5, "p.yaml: no such file"),
    "an output": (["p.h5"], 3, "not text"),
    "a mistake in the file": (["broken.yaml"], 3, "broken.yaml:1:"),
    "an option": (["pendulum.yaml", "--samples", "0"], 2, "at least 2 samples"),
    "a name": (["pendulum.yaml", "--set", "nosuch=1"], 2, "nosuch"),
}


@pytest.mark.parametrize(("arguments", "status", "message"), FIRST.values(), ids=FIRST)
def test_a_mistake_is_said_before_an_existing_output(
    tmp_path, monkeypatch, capsys, arguments, status, message
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "broken.yaml").write_text("nonsense: [")
    (tmp_path / "pendulum.yaml").write_text(PENDULUM.read_text(encoding="utf-8"))
    for name in ("p.h5", "broken.h5", "pendulum.h5"):
        (tmp_path / name).write_bytes(b"\x89HDF precious")
    assert main(["solve", *arguments]) == status
    said = capsys.readouterr().err
    assert message in said and "exists" not in said


def test_force_replaces_it_only_by_something_whole(tmp_path):
    (tmp_path / "pendulum.h5").write_text("precious")
    assert lagrange("solve", PENDULUM, "--force", "--set", "m=0", cwd=tmp_path).returncode == 2
    assert (tmp_path / "pendulum.h5").read_text() == "precious"
    assert lagrange("solve", PENDULUM, "--force", cwd=tmp_path).returncode == 0
    assert h5py.is_hdf5(tmp_path / "pendulum.h5")


def test_quiet_says_nothing(tmp_path):
    run = lagrange("solve", "--quiet", PENDULUM, cwd=tmp_path)
    assert (run.returncode, run.stdout, run.stderr) == (0, "", "")


def test_several_systems_the_others_still_run_and_the_highest_status_counts(tmp_path):
    (tmp_path / "wrong.yaml").write_text("potential: 1")
    run = lagrange(
        "solve", "--json", PENDULUM, "wrong.yaml", "missing.yaml", SYSTEMS / "incline.yaml", cwd=tmp_path
    )
    answers = [json.loads(line) for line in run.stdout.splitlines()]
    assert run.returncode == 5
    assert [(answer["name"], answer["status"]) for answer in answers][:3] == [
        ("pendulum", "complete"),
        ("wrong", "failed"),
        ("missing", "failed"),
    ]
    assert answers[3]["status"] == "complete"
    assert {path.name for path in tmp_path.glob("*.h5")} == {"pendulum.h5", "incline.h5"}


BAD = {
    "missing file": (["missing.yaml"], 5, "missing.yaml: no such file"),
    "a shipped system's name": (["pendulum"], 5, "lagrange systems pendulum > pendulum.yaml"),
    "directory as input": (["."], 5, "is a directory"),
    "empty file": (["empty.yaml"], 3, "empty.yaml"),
    "binary file": (["binary.yaml"], 3, "binary.yaml"),
    "an output as input": (["out.h5"], 3, "the file is an HDF5 file, not a system file"),
    "no name of an output": ([PENDULUM, "-o", ""], 5, "the output has no name"),
    "several names in a set": ([PENDULUM, "--set", "m=1,l=2"], 2, "for each name: --set m=1 --set l=2"),
    "a long step": ([PENDULUM, "--step", "100"], 2, "give a shorter step"),
    "directory as output": ([PENDULUM, "-o", "folder"], 5, "is a directory"),
    "output in no directory": ([PENDULUM, "-o", "no/where.h5"], 5, "no directory"),
    "output in a file": ([PENDULUM, "-o", "empty.yaml/out.h5"], 5, "no directory"),
    "output to a device": ([PENDULUM, "-o", "/dev/null", "--force"], 5, "not a regular file"),
    "output to standard output": ([PENDULUM, "-o", "-"], 2, "standard output"),
    "output over the input": (
        ["pendulum.yaml", "-o", "pendulum.yaml", "--format", "hdf5"],
        2,
        "is read by this",
    ),
    "one output for two": ([PENDULUM, SYSTEMS / "atwood.yaml", "-o", "x.h5"], 2, "several systems"),
    "two systems with one name": (["pendulum.yaml", PENDULUM], 2, "two of the systems"),
    "set of an unknown name": ([PENDULUM, "--set", "nosuch=1"], 2, "nosuch"),
    "set without a value": ([PENDULUM, "--set", "m"], 2, "NAME=VALUE"),
    "set twice": ([PENDULUM, "--set", "m=1", "--set", "m=2"], 2, "'m' is given twice, as 1 and as 2"),
    "a member set twice": (
        [SYSTEMS / "n_pendulum.yaml", "--set", "theta[N - 1]=1", "--set", "theta[4]=2"],
        2,
        "'theta[4]' is given twice, as 1 and as 2",
    ),
    "set to no number": ([PENDULUM, "--set", "m=nan"], 2, "nan"),
    "a mass of zero": ([PENDULUM, "--set", "m=0"], 2, "mass"),
    "a negative mass": ([PENDULUM, "--set", "m=-1"], 2, "mass"),
    "stop is no number": ([PENDULUM, "--stop", "nan"], 2, "finite"),
    "stop is no word": ([PENDULUM, "--stop", "soon"], 2, "soon"),
    "zero samples": ([PENDULUM, "--samples", "0"], 2, "at least 2 samples"),
    "step of zero": ([PENDULUM, "--step", "0"], 2, "positive"),
    "samples and step": ([PENDULUM, "--samples", "5", "--step", "1"], 2, "one of them"),
    "unknown output": ([PENDULUM, "--outputs", "q,enrgy"], 2, "did you mean 'energy'"),
    "no output": ([PENDULUM, "--outputs", ","], 2, "expected a comma-separated list"),
    "an output after a space": ([PENDULUM, "--outputs", "q,"], 2, "write the list without spaces"),
    "an empty name": ([""], 2, "the name of the file is empty"),
    "unknown method": ([PENDULUM, "--method", "rk4"], 2, "taylor"),
    "tolerance out of range": ([PENDULUM, "--tolerance", "7"], 2, "tolerance"),
    "sizes": ([PENDULUM, "--size", "N=3"], 2, "unknown size 'N'; the file has no 'sizes'"),
    "a wrong size": ([SYSTEMS / "n_pendulum.yaml", "--size", "N=0"], 2, "sizes are whole numbers greater"),
    "another size": ([SYSTEMS / "n_pendulum.yaml", "--size", "M=2"], 2, "unknown size 'M'; known: N"),
    "no size": ([SYSTEMS / "n_pendulum.yaml", "--size", "N"], 2, "as in --size N=50"),
    "no such member": ([SYSTEMS / "n_pendulum.yaml", "--set", "theta[5]=1"], 2, "theta[0] to theta[4]"),
    "samples": ([PENDULUM, "--samples", "1.5"], 2, "'1.5' is not a whole number"),
    "digits": ([PENDULUM, "--digits", "30"], 2, "'30' is not a number from 1 to 15"),
    "no number of digits": ([PENDULUM, "--digits", "nan"], 2, "'nan' is not a finite number"),
    "jobs": ([PENDULUM, "--jobs", "0"], 2, "'0' is not a whole number of at least 1"),
    "no systems": ([], 2, "SYSTEM.yaml"),
}


@pytest.mark.exhaustive(keep=18)
@pytest.mark.parametrize(("arguments", "status", "message"), BAD.values(), ids=BAD)
def test_bad_input_gives_one_clear_message_and_leaves_nothing(tmp_path, arguments, status, message):
    (tmp_path / "pendulum.yaml").write_text(PENDULUM.read_text(encoding="utf-8"))
    (tmp_path / "empty.yaml").touch()
    (tmp_path / "binary.yaml").write_bytes(bytes(range(256)))
    (tmp_path / "out.h5").write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(range(256)))
    (tmp_path / "folder").mkdir()
    before = sorted(tmp_path.rglob("*"))
    run = lagrange("solve", *arguments, cwd=tmp_path)
    assert (run.returncode, run.stdout) == (status, "")
    assert message in run.stderr and "Traceback" not in run.stderr and "report it" not in run.stderr
    assert sorted(tmp_path.rglob("*")) == before


def test_no_permission_to_write_is_said_before_any_work(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(os, "access", lambda path, mode: False)  # the superuser may write anywhere
    monkeypatch.setattr(motion, "prepare_run", None)
    assert main(["solve", str(PENDULUM)]) == 5
    assert "no permission to write" in capsys.readouterr().err


@pytest.mark.exhaustive(keep=0.4)
def test_a_full_disk_is_one_clear_error_and_leaves_nothing(tmp_path):
    run = lagrange_process(
        "solve",
        PENDULUM,
        "--samples",
        "100000",
        cwd=tmp_path,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (1_000_000, 1_000_000)),
    )
    assert (run.returncode, run.stdout) == (5, "")
    assert run.stderr == "Error: pendulum.h5 could not be written: File too large\n"
    assert os.listdir(tmp_path) == []


@pytest.mark.exhaustive(keep=0.7)
def test_a_reader_that_hangs_up_does_not_disturb_the_work(tmp_path):
    reader, writer = os.pipe()
    os.close(reader)
    run = subprocess.run(
        [sys.executable, "-m", "lagrange_cli", "solve", str(PENDULUM), str(SYSTEMS / "incline.yaml")],
        cwd=tmp_path,
        env=environment(),
        stdout=writer,
        stderr=subprocess.PIPE,
        text=True,
    )
    os.close(writer)
    assert (run.returncode, run.stderr) == (0, "")
    assert sorted(os.listdir(tmp_path)) == ["incline.h5", "pendulum.h5"]


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_keeps_what_was_computed(tmp_path, number):
    process = subprocess.Popen(
        [sys.executable, "-m", "lagrange_cli", "solve", "--json", "--stop", "5e7", "--step", "1",
         str(PENDULUM), str(SYSTEMS / "incline.yaml")],
        cwd=tmp_path,
        env=environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )  # fmt: skip
    part = tmp_path / ".pendulum.h5.part"
    wait_until(lambda: part.exists() and part.stat().st_size > 100_000, process)
    process.send_signal(number)
    out, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130
    assert "interrupted" in err and "Traceback" not in err
    answer = json.loads(out)
    assert answer["status"] == "interrupted"
    assert os.listdir(tmp_path) == ["pendulum.h5"]
    with h5py.File(tmp_path / "pendulum.h5") as file:
        assert file.attrs["status"] == "interrupted"
        t = file["t"][()]
        assert 0 < len(t) < 1e9 and t[-1] <= answer["t"]
        np.testing.assert_array_equal(t, np.arange(len(t)))
        assert len(file["q/theta"]) == len(t) and np.isfinite(file["q/theta"]).all()


def test_a_motion_that_cannot_be_continued_is_kept_with_status_4(tmp_path):
    (tmp_path / "fall.yaml").write_text(
        "parameters: {G: 1.0}\n"
        "coordinates: {r: {initial: 1.0, velocity: 0.0}}\n"
        "masses: {stone: 1}\n"
        "embedding: {stone: [r]}\n"
        "potential: -G/r\n"
        "solve: {stop: 10, samples: 1001}\n"
    )
    run = lagrange("solve", "--json", "fall.yaml", cwd=tmp_path)
    assert run.returncode == 4
    answer = json.loads(run.stdout)
    assert answer["status"] == "failed" and answer["message"] in run.stderr
    assert answer["t"] == pytest.approx(math.pi / math.sqrt(8), rel=1e-3)  # free fall onto a point mass
    with h5py.File(tmp_path / "fall.h5") as file:
        assert file.attrs["status"] == "failed"
        assert 100 < len(file["t"]) < 1001 and file["t"][-1] <= answer["t"]
        assert np.isfinite(file["q/r"]).all()


@pytest.mark.exhaustive(keep=0.55)
@pytest.mark.parametrize("method", ["DOP853", "Radau", "BDF", "LSODA"])
def test_scipys_methods_write_the_same_motion(tmp_path, method):
    solve_json(PENDULUM, "--stop", "2", "--samples", "11", cwd=tmp_path)
    options = ["--stop", "2", "--samples", "11", "--method", method, "--tolerance", "1e-8"]
    answer = solve_json(PENDULUM, *options, "-o", "other.h5", cwd=tmp_path)
    assert answer["method"] == method
    with h5py.File(tmp_path / "pendulum.h5") as one, h5py.File(tmp_path / "other.h5") as other:
        assert datasets(one) == datasets(other)
        np.testing.assert_array_equal(one["t"], other["t"])
        np.testing.assert_allclose(one["q/theta"], other["q/theta"], atol=1e-4)


STEP = """
coordinates: {x: {initial: -1, velocity: 2}}
lagrangian: x_dot**2/2 - tanh(1e6*x)/4
solve: {stop: 2, samples: 9}
"""


@pytest.mark.exhaustive(keep=0.7)
@pytest.mark.parametrize("outputs", ["q,v,p,h", "h"])
def test_an_h_that_drifts_though_it_is_conserved_is_warned_of(tmp_path, outputs):
    """DOP853 runs across the step without meeting it; where momenta are not computed there is no size."""
    (tmp_path / "step.yaml").write_text(STEP)
    run = lagrange("solve", "step.yaml", "--method", "DOP853", "--json", "--outputs", outputs, cwd=tmp_path)
    warning = json.loads(run.stdout)["warning"]
    assert run.returncode == 0
    with h5py.File(tmp_path / "step.h5") as file:
        assert file.attrs.get("warning") == warning
    assert f"warning: {warning}" in run.stderr
    assert ("h drifted by 5.0e-1" in warning) is (outputs != "h")


@pytest.mark.exhaustive(keep=0.8)
@pytest.mark.parametrize("method", ["DOP853", "LSODA", "Radau"])
@pytest.mark.parametrize(("potential", "warned"), [("tanh(x**3 - x)", True), ("cos(x)", False)])
def test_methods_that_do_not_detect_narrow_forces_say_so(tmp_path, method, potential, warned):
    text = f"coordinates: {{x: {{initial: 0, velocity: 1}}}}\nlagrangian: x_dot**2/2 - {potential}\n"
    (tmp_path / "a.yaml").write_text(text)
    for _ in range(2):  # compiled, and found again
        run = lagrange("solve", "a.yaml", "--method", method, "--stop", "1", "--force", cwd=tmp_path)
        assert run.returncode == 0
        assert (f"{method} does not detect narrow forces" in run.stderr) is warned


@pytest.mark.exhaustive(keep=0.7)
@pytest.mark.parametrize(("method", "warned"), [("LSODA", True), ("DOP853", False), ("taylor", False)])
def test_methods_that_do_not_find_the_zeros_of_switches_say_so(tmp_path, method, warned):
    text = "coordinates: {x: {initial: 1, velocity: 1}}\nlagrangian: x_dot**2/2 - abs(x)\n"
    (tmp_path / "a.yaml").write_text(text)
    run = lagrange("solve", "a.yaml", "--method", method, "--stop", "1", cwd=tmp_path)
    assert run.returncode == 0
    assert (f"{method} does not locate the instants at which abs" in run.stderr) is warned


@pytest.mark.exhaustive(keep=0.6)
def test_a_method_under_which_friction_chatters_comes_to_an_end(tmp_path):
    text = "coordinates: {x: {initial: 0, velocity: 1}}\nlagrangian: x_dot**2/2\n"
    (tmp_path / "a.yaml").write_text(text + "generalized_forces: {x: -0.3*sign(x_dot)}\n")
    run = lagrange("solve", "a.yaml", "--method", "LSODA", "--stop", "50", cwd=tmp_path)
    assert run.returncode == 4
    assert "its steps become too short" in run.stderr


@pytest.mark.exhaustive(keep=0.55)
def test_steps_are_proven_where_it_is_asked_for(tmp_path):
    """A proven step is no longer than its enclosure allows."""
    (tmp_path / "a.yaml").write_text(
        "coordinates: {x: {initial: 1}, y: {initial: 0, velocity: 0.8}}\n"
        "lagrangian: (x_dot**2 + y_dot**2)/2 + 1/sqrt(x**2 + y**2)\n"
    )
    given = ("solve", "a.yaml", "--stop", "5", "--force", "--json")
    plain, run = (lagrange(*given, *more, cwd=tmp_path) for more in ((), ("--proven",)))
    assert plain.returncode == run.returncode == 0
    assert json.loads(run.stdout)["steps"] > json.loads(plain.stdout)["steps"]
    with h5py.File(tmp_path / "a.h5") as file:
        assert file.attrs["proven"] == 1
    run = lagrange(*given, "--proven", "--method", "DOP853", cwd=tmp_path)
    assert run.returncode == 2
    assert "--proven" in run.stderr


@pytest.mark.exhaustive(keep=0.75)
def test_an_h_that_is_kept_is_not_warned_of(tmp_path):
    (tmp_path / "step.yaml").write_text(STEP)
    run = lagrange("solve", "step.yaml", "--json", cwd=tmp_path)
    assert json.loads(run.stdout)["warning"] is None and run.stderr == ""


def test_a_loose_tolerance_is_no_reason_for_a_warning(tmp_path):
    run = lagrange("solve", str(PENDULUM), "--tolerance", "1e-4", "--json", cwd=tmp_path)
    answer = json.loads(run.stdout)
    assert answer["h_drift"] > 1e-9 and answer["warning"] is None
