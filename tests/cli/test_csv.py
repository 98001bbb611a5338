"""``lagrange solve -o run.csv``, ``--format csv`` and ``-o -``."""

import csv
import json
import os
import resource
import subprocess
import sys

import h5py
import numpy as np
import pytest

import lagrange_cli.cli.commands.solve as solving
from lagrange_cli.cli.main import main
from lagrange_cli.store.csv_file import column_names
from lagrange_cli.store.layout import Series
from tests.cli.test_resume import Nervous
from tests.support.command import SYSTEMS, environment, lagrange_process

PENDULUM = str(SYSTEMS / "pendulum.yaml")
RUN = ("solve", PENDULUM, "--stop", "1", "--step", "0.3")


def table(name: str) -> dict[str, list[float]]:
    """The columns of a CSV file by name."""
    with open(name, newline="", encoding="utf-8") as file:
        names, *rows = csv.reader(file)
    return {name: [float(row[i]) for row in rows] for i, name in enumerate(names)}


pytestmark = pytest.mark.usefixtures("folder")


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize("options", [[], ["--certify"], ["--precision=double-double"], ["--method=LSODA"]])
def test_a_table_has_the_same_numbers_as_the_file(options):
    run = [*RUN, "--outputs", "all", *options]
    assert main([*run, "-o", "run.csv"]) == main([*run, "-o", "run.h5"]) == 0
    found = table("run.csv")
    with h5py.File("run.h5") as file:
        assert found["t"] == file["t"][()].tolist() == pytest.approx([0, 0.3, 0.6, 0.9, 1])
        for column, path in {
            "theta": "q/theta", "theta_dot": "v/theta", "p_theta": "diagnostics/p/theta",
            "h": "diagnostics/h", "energy": "diagnostics/energy", "ledger_h": "diagnostics/ledger/h",
            "ledger_p_theta": "diagnostics/ledger/p/theta",
        }.items():  # fmt: skip
            assert found[column] == file[path][()].tolist()
        assert found["bob.y"] == file["positions/bob"][:, 1].tolist()
        if "--certify" in options:
            assert found["error_theta_dot"] == file["diagnostics/error/v/theta"][()].tolist()
        if "--precision=double-double" in options:
            assert found["low_theta"] == file["low/q/theta"][()].tolist()
    assert sorted(os.listdir()) == ["run.csv", "run.h5"]


def test_members_and_components_are_columns_and_names_are_unique():
    series = [
        Series("q/theta", (2,), axes=("N",)),
        Series("q/h"),
        Series("v/theta", (2,), axes=("N",)),
        Series("diagnostics/h"),
        Series("positions/bob", (2, 2), axes=("N",), components=2),
        Series("observables/u", (1, 2), axes=("N", "M")),
        Series("observables/theta", (1,), axes=("N",)),
    ]
    assert column_names(series) == [
        "t", "theta[0]", "theta[1]", "h", "theta_dot[0]", "theta_dot[1]", "diagnostics/h", "bob[0].x",
        "bob[0].y", "bob[1].x", "bob[1].y", "u[0,0]", "u[0,1]", "observables/theta[0]",
    ]  # fmt: skip


def test_the_name_or_the_option_says_what_is_written():
    assert main([*RUN, "--format", "csv", "--quiet"]) == 0
    assert main([*RUN, "--format", "csv", "--quiet", "-o", "run.dat"]) == 0
    assert main([*RUN, "--format", "hdf5", "--quiet", "-o", "other.csv"]) == 0
    assert [*table("pendulum.csv")] == [*table("run.dat")] == ["t", "theta", "theta_dot", "p_theta", "h"]
    assert h5py.is_hdf5("other.csv")


@pytest.mark.exhaustive(keep=0.7)
def test_it_is_streamed_to_standard_output():
    run = lagrange_process(*RUN, "-o", "-", "--format", "csv", cwd=os.getcwd())
    assert run.returncode == 0 and "wrote to standard output in" in run.stderr
    lines = run.stdout.splitlines()
    assert lines[0] == "t,theta,theta_dot,p_theta,h" and len(lines) == 6 and lines[-1].startswith("1.0,")
    assert os.listdir() == []


@pytest.mark.exhaustive(keep=0.3)
def test_a_reader_that_hangs_up_ends_an_endless_stream_quietly():
    command = [sys.executable, "-m", "lagrange_cli", "solve", PENDULUM, "--stop", "1e9", "--step", "0.1",
               "-o", "-", "--format", "csv"]  # fmt: skip
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen(command, env=environment(), **pipes) as process:
        assert process.stdout.readline() == b"t,theta,theta_dot,p_theta,h\n"
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([*RUN, "-o", "run.csv", "--resume"], "--resume needs an HDF5 output"),
        ([*RUN, "-o", "-"], "add --format csv"),
        ([*RUN, "-o", "-", "--format", "csv", "--json"], "give --output a name"),
        ([*RUN, "-o", "run.mat"], "outputs are HDF5 or CSV, not mat: name the file run.h5 or run.csv"),
        ([*RUN, "-o", "run.csv.gz"], "not gz: name the file run.h5 or run.csv"),
        (["sweep", PENDULUM, "--over", "m=1,2", "-o", "run.csv"], "a sweep is written as HDF5"),
        (["solve", PENDULUM, "pendulum.yaml", "--format", "csv"], "written to pendulum.csv"),
    ],
)
def test_what_cannot_be_is_refused(arguments, message, capsys):
    assert main(arguments) == 2
    assert message in capsys.readouterr().err and os.listdir() == []


def test_it_is_kept_replaced_and_whole_as_any_output(capsys, monkeypatch):
    assert main([*RUN, "-o", "run.csv"]) == 0
    assert main([*RUN, "-o", "run.csv", "--json"]) == 0
    assert json.loads(capsys.readouterr().out.splitlines()[-1])["replaced"] is True
    with open("run.csv", "a", encoding="utf-8") as file:
        file.write("mine\n")
    assert main([*RUN, "-o", "run.csv"]) == 5
    monkeypatch.setattr(solving, "Interrupts", Nervous)
    monkeypatch.setattr(Nervous, "patience", 1)
    assert main(["solve", PENDULUM, "--stop", "1e6", "--samples", "100001", "-o", "cut.csv"]) == 130
    assert "interrupted at t = " in (error := capsys.readouterr().err) and "--resume" not in error
    assert 0 < len(table("cut.csv")["t"]) < 100001
    assert sorted(os.listdir()) == ["cut.csv", "run.csv"]


@pytest.mark.exhaustive(keep=0.25)
def test_a_full_disk_is_one_clear_error_and_leaves_nothing():
    run = lagrange_process(
        "solve", PENDULUM, "--samples", "100000", "-o", "run.csv", cwd=os.getcwd(),
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (1_000_000, 1_000_000)),
    )  # fmt: skip
    assert (run.returncode, run.stdout) == (5, "")
    assert run.stderr == "Error: run.csv could not be written: File too large\n"
    assert os.listdir() == []


def test_numbers_that_are_none_are_written_as_such():
    text = "coordinates: {x: {initial: 0, velocity: 1}}\nlagrangian: x_dot**2/2\n"
    with open("a.yaml", "w", encoding="utf-8") as file:
        file.write(text + "observables: {inverse: 1/x, root: sqrt(-1 - x)}\nsolve: {stop: 1, samples: 2}\n")
    assert main(["solve", "a.yaml", "-o", "a.csv"]) == 0
    assert table("a.csv")["inverse"] == [np.inf, 1.0] and np.isnan(table("a.csv")["root"]).all()
