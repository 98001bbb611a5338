"""``solve --certify`` as a user sees it: what is in the file, what is said, and what is refused."""

import json
import re
from pathlib import Path

import h5py
import numpy as np
import pytest

from lagrange_cli.cli.main import main
from tests.support.command import SYSTEMS


def solve(capsys, system, *options):
    status = main(["solve", str(SYSTEMS / f"{system}.yaml"), *options, "--json"])
    said = capsys.readouterr()
    return status, json.loads(said.out) if said.out else None, said.err


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("options", [(), ("--method", "DOP853"), ("--tolerance", "1e-7"), ("--samples", "2")])
@pytest.mark.parametrize("system", ["pendulum", "n_pendulum"])
def test_the_samples_are_those_of_the_plain_run_and_each_has_an_error(
    tmp_path, monkeypatch, capsys, system, options
):
    monkeypatch.chdir(tmp_path)
    options = (*options, "--stop", "3")
    plain = solve(capsys, system, *options, "-o", "plain.h5")[1]
    status, said, _ = solve(capsys, system, *options, "-o", "certified.h5", "--certify")
    assert status == 0 and plain["trusted_until"] is None
    with h5py.File("plain.h5") as before, h5py.File("certified.h5") as after:
        before.visititems(
            lambda path, item: (
                isinstance(item, h5py.Dataset)
                and (item[()].tobytes() == after[path][()].tobytes() or pytest.fail(path))
            )
        )
        assert set(after["diagnostics"]) - set(before["diagnostics"]) == {"error"}
        for kind in "qv":
            for name in before[kind]:
                if isinstance(before[kind].get(name, getlink=True), h5py.HardLink):
                    dims = [list(one) for one in after[kind][name].dims]
                    for folder in ("diagnostics/error", "diagnostics/error/as_run"):
                        error = after[f"{folder}/{kind}/{name}"]
                        assert error.shape == before[kind][name].shape
                        assert [list(one) for one in error.dims] == dims
                        assert np.all(error[1:] > 0) and np.all(np.isfinite(error))
        assert 0 < said["trusted_until"] == after.attrs["trusted_until"] <= after["t"][-1] == 3
        assert after.attrs["digits"] == 6 and "trusted_until" not in before.attrs
        assert said["trusted_until"] <= said["trusted_until_as_run"] == after.attrs["trusted_until_as_run"]
        more = dict.fromkeys(("trusted_until", "trusted_until_as_run", "digits"), 0)
        assert {**before.attrs, **more}.keys() == {**after.attrs}.keys()
        assert before.attrs["steps"] == after.attrs["steps"]
        assert before.attrs["h_drift"] == after.attrs["h_drift"]


@pytest.mark.exhaustive(keep=0.25)
def test_the_same_command_gives_the_same_bytes_where_the_target_is_missed(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    contents = []
    for _ in range(2):
        status, said, error = solve(
            capsys, "double_pendulum", "--target-error", "1e-9", "--force", "-o", "out.h5"
        )
        assert status == 4 and said["status"] == "failed" and 0 < said["trusted_until"] < said["t"] < 60
        assert "the target error can no longer be met at t = " in error
        contents.append(Path("out.h5").read_bytes())
    assert contents[0] == contents[1]


@pytest.mark.exhaustive(keep=0.75)
def test_more_digits_are_trusted_for_less_long(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    ends = [
        solve(capsys, "double_pendulum", "--digits", digits, "-o", f"{digits}.h5")[1]["trusted_until"]
        for digits in ("3", "6", "9", "12")
    ]
    assert 0 < ends[3] < ends[2] < ends[1] < ends[0] < 60


def test_the_summary_says_up_to_when(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["solve", str(SYSTEMS / "pendulum.yaml"), "--certify"]) == 0
    said = capsys.readouterr().out
    assert re.search(r"\n  estimated error: \S+ at the end, 6 digits up to t = 20\n", said)
    assert "certified" not in said and "rounding" not in said


STAYS = (
    "  the motion begins at an unstable equilibrium: as written it stays there; with th rounded to doubles "
    "it leaves after t = "
)
TOP = "coordinates: {th: {initial: pi}}\nlagrangian: th_dot**2/2 + 9.81*cos(th)\n"


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(
    ("system", "options", "line"),
    [
        (TOP, [], STAYS),
        (TOP, ["--set", "th=3"], None),
        (TOP, ["--stop", "1"], None),
    ],
)  # fmt: skip
def test_a_line_says_where_the_rounding_of_inputs_prevails(
    tmp_path, monkeypatch, capsys, system, options, line
):
    monkeypatch.chdir(tmp_path)
    Path("system.yaml").write_text(system)
    assert main(["solve", "system.yaml", "--certify", "--stop", "9", *options]) == 0
    said = capsys.readouterr().out.splitlines()
    found = [one for one in said if "round" in one or "equilibrium" in one]
    assert len(found) == (line is not None) and all(one.startswith(str(line)) for one in found)


@pytest.mark.parametrize(
    ("command", "options"),
    [
        ("solve", ["--certify", "--resume"]),
        ("solve", ["--certify", "--precision", "double-double"]),
        ("solve", ["--digits", "0"]),
        ("solve", ["--target-error", "0"]),
        ("solve", ["--target-error", "nan"]),
        ("sweep", ["--certify"]),
    ],
)
def test_what_there_is_not_is_refused(tmp_path, monkeypatch, capsys, command, options):
    monkeypatch.chdir(tmp_path)
    assert main([command, str(SYSTEMS / "pendulum.yaml"), *options]) == 2
    assert len(capsys.readouterr().err.splitlines()) <= 4
    assert not list(tmp_path.iterdir())
