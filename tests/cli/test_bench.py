"""``lagrange bench``: its table, its object, its picture, and what it says where something is wrong."""

import json
import re
import xml.etree.ElementTree as ElementTree

import pytest

from lagrange_cli.cli.commands import bench as module
from lagrange_cli.cli.main import main
from lagrange_cli.integrate.methods.table import METHODS
from lagrange_cli.integrate.precision import FULL_PRECISION
from lagrange_cli.native.interface import HIGHEST_ORDER
from lagrange_cli.native.orders import order_for
from lagrange_cli.run.bench import entries_of
from lagrange_cli.work_precision import measure as work_precision
from tests.support.command import SYSTEMS

HOOP = str(SYSTEMS / "rotating_hoop.yaml")
FEW = ["--methods", "taylor,dop853", "--tolerances", "1e-4,1e-9", "--runs", "1"]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """An empty cache, and a directory to write to."""
    monkeypatch.setenv("LAGRANGE_CACHE_DIR", str(tmp_path / "cache"))
    (tmp_path / "work").mkdir()
    monkeypatch.chdir(tmp_path / "work")
    return tmp_path / "work"


def run(capsys, *arguments, system=HOOP):
    status = main(["bench", system, *arguments])
    captured = capsys.readouterr()
    return status, captured.out, captured.err


@pytest.mark.exhaustive(keep=0.15)
def test_the_table_has_a_line_for_each_method_and_tolerance(capsys, folder):
    status, out, err = run(capsys, *FEW, "--stop", "5", "--error", "1e-7")
    assert (status, err) == (0, "")
    head, reference, _, header, *rows, _, recommended = out.splitlines()
    assert head == "bead on a rotating hoop: 1 degree of freedom, t = 0 to 5, 1001 samples"
    assert reference.startswith(f"  reference: Taylor series of order {HIGHEST_ORDER}, ")
    assert order_for(FULL_PRECISION) < HIGHEST_ORDER
    assert header.split() == [
        "method",
        "tolerance",
        "steps",
        "evaluations",
        "ms",
        "error",
        "drift",
        "of",
        "h",
    ]
    cells = [row.split() for row in rows]
    assert [cell[:2] for cell in cells] == [
        ["taylor", "0.0001"], ["taylor", "1e-09"], ["DOP853", "0.0001"], ["DOP853", "1e-09"],
    ]  # fmt: skip
    assert all(len(cell) == 7 and float(cell[4]) > 0 and float(cell[5]) > 0 for cell in cells)
    assert re.match(r"  for an error of 1e-07: (taylor|DOP853) at 1e-09 \(the fastest of 2 ", recommended)
    assert not list(folder.iterdir())


@pytest.mark.exhaustive(keep=0.25)
def test_the_object_says_all_of_it_and_what_is_recommended_reaches_the_error(capsys):
    status, out, _ = run(capsys, *FEW, "--stop", "5", "--error", "1e-7", "--json")
    found = json.loads(out)
    assert status == 0 and out.count("\n") == 1
    assert set(found) == {
        "name", "degrees_of_freedom", "start", "stop", "asked_stop", "samples", "reference", "contenders",
        "wanted_error", "recommended", "because",
    }  # fmt: skip
    assert set(found["reference"]) == {"method", "order", "steps", "error", "shortened_because"}
    assert (found["stop"], found["asked_stop"], found["reference"]["shortened_because"]) == (5, 5, None)
    keys = {
        "method", "tolerance", "status", "message", "steps", "evaluations", "seconds", "runs", "error",
        "error_is_bound", "h_drift",
    }  # fmt: skip
    assert all(set(each) == keys for each in found["contenders"])
    best = found["recommended"]
    assert best in found["contenders"] and best["error"] <= found["wanted_error"] == 1e-7
    reaching = [each for each in found["contenders"] if each["error"] <= 1e-7]
    assert best["seconds"] == min(each["seconds"] for each in reaching)


@pytest.mark.exhaustive(keep=0.15)
def test_constraints_take_degrees_of_freedom(capsys, tmp_path):
    system = tmp_path / "rod.yaml"
    system.write_text(
        "coordinates: {x: {initial: 1}, y: {initial: 0}, z: {initial: 0, velocity: 1}}\nmasses: {a: 1}\n"
        "positions: {a: [x, y, z]}\nconstraints: {rod: norm(a) - 1}\n"
    )
    few = ["--methods", "taylor", "--tolerances", "1e-6", "--runs", "1", "--stop", "1"]
    _, out, _ = run(capsys, *few, system=str(system))
    assert out.startswith("rod: 2 degrees of freedom")


@pytest.mark.exhaustive(keep=0.2)
def test_a_chaotic_motion_is_compared_as_far_as_it_is_known(capsys):
    arguments = ["--methods", "taylor", "--tolerances", "1e-6", "--runs", "1"]
    system = str(SYSTEMS / "double_pendulum.yaml")
    _, out, _ = run(capsys, *arguments, system=system)
    shortened = out.splitlines()[2]
    assert shortened.startswith("  compared up to t = ")
    assert shortened.endswith(" instead of 60: the error of the reference exceeds 1e-11 beyond this time")
    assert "none (no method reaches this accuracy; the smallest error is " in out
    _, out, _ = run(capsys, *arguments, "--json", system=system)
    assert json.loads(out)["stop"] < 15 and json.loads(out)["recommended"] is None


def test_what_a_method_refuses_is_a_line_with_the_reason(capsys):
    status, out, _ = run(capsys, "--methods", "DOP853", "--tolerances", "1e-4,1e-15", "--stop", "1")
    assert status == 0
    (line,) = [line for line in out.splitlines() if "refused" in line]
    assert line.split()[:2] == ["DOP853", "1e-15"]
    assert line.endswith(" refused: the tolerance 1e-15 is out of range; DOP853 takes 2.22e-14 to 0.1")


def test_what_is_too_slow_is_cut_and_its_tighter_tolerances_are_skipped(capsys):
    _, out, _ = run(capsys, "--methods", "BDF", "--tolerances", "1e-6,1e-9", "--budget", "0.001")
    cut, skipped = (line.split(maxsplit=2) for line in out.splitlines() if "BDF  " in line)
    assert cut[:2] == ["BDF", "1e-06"] and cut[2].startswith("stopped after 0.001 s (--budget) at t = ")
    assert skipped == ["BDF", "1e-09", "skipped: BDF at 1e-06 already exceeded the budget"]
    assert "none (no method reached the end)" in out


@pytest.mark.exhaustive(keep=0)
def test_the_picture_is_drawn_with_every_method(capsys, folder):
    status, out, _ = run(capsys, *FEW, "--stop", "4*a", "--quiet", "--plot", "hoop.svg")
    assert (status, out) == (0, "")
    root = ElementTree.parse(folder / "hoop.svg").getroot()
    texts = {"".join(each.itertext()).strip() for each in root.iter("{http://www.w3.org/2000/svg}text")}
    assert {"bead on a rotating hoop, t = 0 to 2", "taylor", "DOP853"} <= texts


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--methods", "taylor,dop"], "unknown method 'dop'; known: taylor, ias15, DOP853"),
        (["--tolerances", "1e-3,x"], "'1e-3,x' is not a comma-separated list of numbers"),
        (["--error", "1e-16"], "--error must be from 1e-12 to 0.1, not 1e-16"),
        (["--error", "nan"], "'nan' is not a finite number"),
        (["--runs", "0"], "'--runs'"),
        (["--budget", "0"], "'--budget'"),
        (["--plot", "hoop.txt"], "must end in .svg, .pdf or .png"),
        (["--stop", "0"], "the motion stops where it starts"),
        (["--stop", "theta"], "--stop theta: 'theta' is not constant"),
        (["--set", "nosuch=1"], "unknown name 'nosuch'"),
    ],
)
def test_wrong_options_are_refused(capsys, arguments, message):
    status, out, err = run(capsys, *arguments)
    assert (status, out) == (2, "")
    assert message in err and "Traceback" not in err


@pytest.mark.exhaustive(keep=0.25)
def test_a_motion_that_cannot_begin_ends_with_a_message(capsys, folder):
    (folder / "flat.yaml").write_text(
        "coordinates: {r: {initial: 0}}\nlagrangian: r**2*r_dot**2/2\nsolve: {stop: 1}\n"
    )
    status, out, err = run(capsys, system="flat.yaml")
    assert (status, out) == (4, "")
    assert err.startswith("Error: no reference solution to compare with: singular mass matrix at t = 0")


def test_all_methods_are_tried_unless_their_jacobian_is_large():
    entries = entries_of(None, None, 2)
    assert list(entries) == list(METHODS) and module.left_out_of(entries, 2) == []
    assert FULL_PRECISION in entries["taylor"] and FULL_PRECISION not in entries["DOP853"]
    entries = entries_of(None, [1e-5], 500)
    (said,) = module.left_out_of(entries, 500)
    assert entries == {"taylor": [1e-5], "ias15": [1e-5], "DOP853": [1e-5], "Radau": [1e-5]}
    assert "left out: BDF, LSODA" in said and "add them with --methods BDF,LSODA" in said
    assert list(entries_of(["BDF", "taylor"], None, 500)) == ["BDF", "taylor"]


class AfterTwo:
    """An interrupt that comes while the second contender is measured."""

    measured = 0

    def __enter__(self):
        return lambda: AfterTwo.measured == 2

    def __exit__(self, *error):
        pass


def test_an_interrupt_shows_what_was_measured(capsys, monkeypatch):
    measure = work_precision.measure

    def count(*arguments):
        AfterTwo.measured += 1
        return measure(*arguments)

    monkeypatch.setattr(AfterTwo, "measured", 0)
    monkeypatch.setattr(work_precision, "measure", count)
    monkeypatch.setattr(module, "Interrupts", AfterTwo)
    status, out, err = run(capsys, *FEW, "--stop", "1")
    assert (status, err) == (130, "bead on a rotating hoop: interrupted after 1 of 4 measurements\n")
    assert "  taylor     0.0001  " in out and "1e-09  " not in out


def test_an_interrupt_before_there_is_a_reference_ends_at_once(capsys, monkeypatch):
    monkeypatch.setattr(AfterTwo, "measured", 2)
    monkeypatch.setattr(module, "Interrupts", AfterTwo)
    status, out, err = run(capsys, *FEW)
    assert (status, out, err.strip()) == (130, "", "Interrupted.")
