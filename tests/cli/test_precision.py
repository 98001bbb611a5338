"""``lagrange solve --precision``: what is written, what is refused, and going on with it."""

import json
import re

import h5py
import pytest

from lagrange_cli.cli.commands import solve as solving
from lagrange_cli.cli.main import main
from lagrange_cli.integrate.precision import DOUBLE_DOUBLE_COST
from lagrange_cli.run.interrupts import Interrupts
from tests.support.command import ROOT, SYSTEMS, lagrange

DOUBLE_PENDULUM = str(SYSTEMS / "double_pendulum.yaml")
LONG = ("--precision", "double-double")


def paths(file):
    found = {}
    file.visititems(lambda path, item: found.update({path: item}) if hasattr(item, "shape") else None)
    return found


@pytest.mark.exhaustive(keep=0.25)
def test_every_dataset_has_a_low_part(folder, capsys):
    assert main(["solve", str(SYSTEMS / "n_pendulum.yaml"), *LONG, "--stop", "1", "--outputs", "all"]) == 0
    assert "drift: h " in capsys.readouterr().out
    with h5py.File("n_pendulum.h5") as file:
        assert file.attrs["precision"] == "double-double"
        assert file.attrs["tolerance"] == 2.0**-104
        found = paths(file)
        whole = {path for path in found if not path.startswith("low/") and len(path.split("/")) > 1}
        assert {path.removeprefix("low/") for path in found if path.startswith("low/")} == whole
        for path in whole:
            assert found[path].shape == found[f"low/{path}"].shape
            assert (found[path][:] + found[f"low/{path}"][:] == found[path][:]).all()
        assert file["low/q/theta"].dims[0][0] == file["t"]


def test_double_is_the_default_and_leaves_no_trace(folder):
    assert main(["solve", DOUBLE_PENDULUM, "--stop", "1", "-o", "a.h5"]) == 0
    assert main(["solve", DOUBLE_PENDULUM, "--stop", "1", "-o", "b.h5", "--precision", "double"]) == 0
    assert (folder / "a.h5").read_bytes() == (folder / "b.h5").read_bytes()
    with h5py.File("a.h5") as file:
        assert "low" not in file and "precision" not in file.attrs


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            ("--method", "DOP853"),
            "--precision double-double needs method taylor, not DOP853: add --method taylor",
        ),
        (("--tolerance", "1e-40"), "the tolerance 1e-40 is out of range; taylor takes 1.23e-32 to 0.1"),
        (("--set", "g=1/0"), "--set g=1/0: division by zero"),
        (("--set", "g=log(-1)"), "--set g=log(-1): log(-1) is not a real number"),
        (("--set", "g=(-1)**0.5"), "--set g=(-1)**0.5: the value is not a finite number"),
        (("--set", "g=1e300*1e300"), "--set g=1e300*1e300: the value is not a finite number"),
        (("--set", "g=exp(exp(exp(9)))"), "--set g=exp(exp(exp(9))): number too large"),
        (("--set", "g=1e-400"), "number too small"),
        (("--set", "theta1=1e-200*1e-200"), "number too small"),
    ],
)
def test_what_is_refused(folder, options, message, capsys):
    assert main(["solve", DOUBLE_PENDULUM, *LONG, "--stop", "1", *options]) == 2
    assert message in capsys.readouterr().err
    assert not list(folder.iterdir())


def test_what_it_costs_is_one_figure():
    cost = f"{DOUBLE_DOUBLE_COST} times"
    assert cost in " ".join(next(p.help for p in solving.solve.params if p.name == "precision").split())
    pages = [ROOT / "README.md", *ROOT.glob("docs/*.md")]
    said = {
        found
        for page in pages
        for found in re.findall(
            r"double-double.{,99}?(\w+ to \w+) times (?:the time|as long)", page.read_text("utf-8")
        )
    }
    assert said == {DOUBLE_DOUBLE_COST}


def test_a_sweep_has_no_such_precision(folder, capsys):
    assert main(["sweep", DOUBLE_PENDULUM, *LONG, "--over", "g=1,2"]) == 2
    assert "there is no option" in capsys.readouterr().err


@pytest.mark.exhaustive(keep=0.4)
def test_a_second_run_finds_the_program_and_gives_the_same_bytes(folder, capsys):
    run = ["solve", DOUBLE_PENDULUM, *LONG, "--stop", "2", "--timings"]
    assert main([*run, "-o", "a.h5", "--no-cache"]) == 0
    assert main([*run, "-o", "b.h5"]) == 0
    assert main([*run, "-o", "c.h5"]) == 0
    assert "storing a new one" in capsys.readouterr().out
    contents = {(folder / name).read_bytes() for name in ("a.h5", "b.h5", "c.h5")}
    assert len(contents) == 1


@pytest.mark.exhaustive(keep=0.6)
def test_samples_do_not_change_the_steps(folder, capsys):
    last = []
    for samples in (2, 5, 1001):
        run = ["solve", DOUBLE_PENDULUM, *LONG, "--stop", "5", "--samples", str(samples), "--force", "--json"]
        assert main(run) == 0
        steps = json.loads(capsys.readouterr().out)["steps"]
        with h5py.File("double_pendulum.h5") as file:
            last.append((steps, file["q/theta1"][-1], file["low/q/theta1"][-1]))
    assert len(set(last)) == 1


def test_a_singularity_ends_the_run(folder, capsys):
    """Two bodies that fall into each other: what was computed is kept."""
    (folder / "fall.yaml").write_text(
        "coordinates: {x: {initial: 1}}\nlagrangian: x_dot**2/2 + 1/x\nsolve: {stop: 5}\n", encoding="utf-8"
    )
    assert main(["solve", "fall.yaml", *LONG]) == 4
    assert "t = 1.1107" in capsys.readouterr().err  # pi/sqrt(8)
    with h5py.File("fall.h5") as file:
        assert file.attrs["status"] == "failed"
        assert file["t"][-1] < 1.11073


@pytest.mark.exhaustive(keep=0.5)
def test_a_singular_mass_matrix_ends_the_run(folder, capsys):
    (folder / "still.yaml").write_text(
        "coordinates: {x: {initial: 0, velocity: 1}}\nlagrangian: x*x_dot**2/2\nsolve: {stop: 5}\n",
        encoding="utf-8",
    )
    assert main(["solve", "still.yaml", *LONG]) == 4
    assert "the mass matrix is singular: no kinetic energy depends on x_dot" in capsys.readouterr().err


@pytest.mark.exhaustive(keep=0.2)
def test_a_run_that_was_interrupted_goes_on_to_the_same_bytes(folder, monkeypatch):
    run = ["solve", DOUBLE_PENDULUM, *LONG, "--stop", "60", "--outputs", "all", "-o", "out.h5"]
    assert main(run) == 0
    expected = (folder / "out.h5").read_bytes()

    class Once(Interrupts):
        def __call__(self) -> bool:
            return True

    monkeypatch.setattr(solving, "Interrupts", Once)
    assert main([*run, "--force"]) == 130
    monkeypatch.setattr(solving, "Interrupts", Interrupts)
    with h5py.File("out.h5") as file:
        assert file.attrs["status"] == "interrupted"
    assert main([*run, "--resume"]) == 0
    assert (folder / "out.h5").read_bytes() == expected


def test_another_precision_is_not_continued(folder, capsys):
    run = ["solve", DOUBLE_PENDULUM, "--stop", "2", "-o", "out.h5"]
    assert main([*run, *LONG]) == 0
    assert main([*run, "--resume"]) == 5


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("potential", ["0.3*exp(-(x/1e-3)**2)", "0.6*sin(3*x)**60", "0.3/(1 + (1e6*x)**4)"])
def test_double_double_does_not_leap_over_narrow_forces(tmp_path, potential):
    (tmp_path / "a.yaml").write_text(
        f"coordinates: {{x: {{initial: -1, velocity: 1}}}}\nlagrangian: x_dot**2/2 - {potential}\n"
    )
    ends = []
    for precision in ("double", "double-double"):
        given = ("--stop", "3", "--samples", "2", "--precision", precision, "--json", "--force")
        run = lagrange("solve", "a.yaml", *given, cwd=tmp_path)
        assert run.returncode == 0
        assert "does not detect" not in run.stderr
        ends.append(json.loads(run.stdout))
    assert ends[1]["h_drift"] <= 1e-29
    assert ends[0]["final"]["q"]["x"] == pytest.approx(ends[1]["final"]["q"]["x"], abs=1e-13)
