"""Many motions, and sections, in Python: the files of the commands, as arrays."""

import gc
import os
import signal
from pathlib import Path

import h5py
import numpy as np
import pytest

import lagrange_cli as lagrange
import lagrange_cli.integrate.ensemble.follow as following
from lagrange_cli.cli.main import main
from tests.support.command import SYSTEMS

PENDULUM = SYSTEMS / "pendulum.yaml"
HENON = SYSTEMS / "henon_heiles.yaml"


@pytest.mark.exhaustive(keep=0.45)
def test_a_sweep_is_saved_to_the_bytes_of_the_command(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    options = [
        "--over",
        "l=1.0,1.5",
        "--over",
        "theta=0:3:4",
        "--stop",
        "2",
        "--outputs",
        "q",
        "--samples",
        "11",
    ]
    assert main(["sweep", str(PENDULUM), *options, "-o", "command.h5", "--quiet"]) == 0
    swept = lagrange.sweep(
        PENDULUM, over={"l": [1, 1.5], "theta": "0:3:4"}, stop=2, outputs=["q"], samples=11
    )
    swept.save("python.h5")
    assert Path("python.h5").read_bytes() == Path("command.h5").read_bytes()
    assert swept.q["theta"].shape == (2, 4, 11) and swept.t.shape == (11,)
    assert (swept.members, swept.status, {*swept.statuses.flat}) == (8, "complete", {"complete"})
    assert np.array_equal(swept.dims["l"], [1, 1.5]) and "8 members (2 l x 4 theta)" in repr(swept)
    one = lagrange.solve(PENDULUM, set={"l": 1.5, "theta": 3}, stop=2, samples=11)
    assert np.allclose(swept.q["theta"][1, 3], one.q["theta"], rtol=0, atol=1e-13)
    tree = swept.to_xarray()
    assert tree["q"].theta.dims == ("l", "theta_0", "t")
    with pytest.raises(AttributeError, match="'v' was not computed"):
        swept.v  # noqa: B018
    with pytest.raises(lagrange.FileError, match="already exists"):
        swept.save("python.h5")
    with pytest.raises(lagrange.UsageError, match="a name that ends in"):
        swept.save("python.csv")


@pytest.mark.exhaustive(keep=0.55)
def test_members_are_drawn_and_listed(tmp_path):
    draws = {"theta": ("normal", 0, 0.1)}
    drawn = lagrange.sweep(PENDULUM, random=draws, members=5, seed=7, stop=1)
    again = lagrange.sweep(PENDULUM, random={"theta": "normal(0,0.1)"}, members=5, seed=7, stop=1)
    assert np.array_equal(drawn.q["theta"], again.q["theta"]) and drawn.q["theta"].shape == (5,)
    columns = {"theta": np.array([0.1, 0.2]), "l": [1, 2]}
    table = tmp_path / "runs.csv"
    table.write_text("theta,l\n0.1,1\n0.2,2\n")
    listed, read = (lagrange.sweep(PENDULUM, table=one, stop=1) for one in (columns, table))
    assert np.array_equal(listed.q["theta"], read.q["theta"])
    assert listed.dims == {"member": 2} and listed.attributes["sweep"]["table"] == "theta,l"
    many = lagrange.sweep(PENDULUM, over={"theta": np.linspace(0, 1, 200)}, stop=0.1)
    assert many.attributes["sweep"]["over"]["theta"] == "200 values from 0.0 to 1.0"


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({}, "no members given: add over={"),
        ({"over": ["l"]}, "over must be a mapping"),
        ({"over": {"l": "many"}}, "l=many"),
        ({"over": {"l": ["a"]}}, "over: l must be a sequence of numbers"),
        ({"over": {"l": [[1, 2]]}}, "over l: values along one dimension"),
        ({"over": {"l": [1, np.inf]}}, "over l: inf is not a finite number"),
        ({"over": {"nosuch": [1]}}, "over nosuch: unknown name"),
        ({"random": {"l": ("cauchy", 0, 1)}, "members": 2}, "random: l must be a distribution"),
        ({"random": {"l": "uniform(1,2)"}, "members": 0}, "members must be a whole number"),
        ({"table": {}}, "no columns"),
        ({"table": [[1, 2]]}, "table must be the name of a CSV file, or columns by name"),
        ({"table": {"l": [1, 2], "theta": [1]}}, "its columns must have the same length"),
        ({"over": {"l": [1, 2]}, "samples": 10}, "without outputs"),
        ({"over": {"l": [1, 2]}, "set": {"l": 1}}, "more than once"),
        ({"over": {"l": [1]}, "seed": -1}, "seed must be a whole number"),
        ({"over": {"l": [1]}, "jobs": 0}, "jobs must be a whole number"),
    ],
)  # fmt: skip
def test_members_that_make_no_sense_are_refused(given, message):
    with pytest.raises(lagrange.UsageError, match=message):
        lagrange.sweep(PENDULUM, **given)


def test_members_that_fail_are_warned_of():
    fall = "coordinates: {x: {initial: 1}}\nlagrangian: x_dot**2/2 + 1/x\nsolve: {stop: 2}\n"
    with pytest.warns(lagrange.LagrangeWarning, match="1 of 2 members failed"):
        swept = lagrange.sweep(fall, over={"x": [1, 10]})
    assert swept.statuses.tolist() == ["failed", "complete"]


def test_a_sweep_that_is_interrupted_keeps_the_members_that_ended(monkeypatch):
    follow = following.follow_ensemble

    def interrupting(prepared, method, values, families, times, write, interrupted, **rest):
        os.kill(os.getpid(), signal.SIGINT)
        return follow(prepared, method, values, families, times, write, interrupted, **rest)

    monkeypatch.setattr(following, "follow_ensemble", interrupting)
    with pytest.raises(lagrange.Interrupted) as caught:
        lagrange.sweep(PENDULUM, over={"l": np.linspace(1, 2, 64)}, stop=1e5, jobs=1)
    assert caught.value.result.status == "interrupted"


@pytest.mark.exhaustive(keep=0.3)
def test_a_section_is_saved_to_the_bytes_of_the_command(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    options = ["--where", "x", "--crossings", "5", "--direction", "either"]
    assert main(["section", str(HENON), *options, "-o", "command.h5", "--quiet"]) == 0
    found = lagrange.section(HENON, where="x", crossings=5, direction="either")
    found.save("python.h5")
    assert Path("python.h5").read_bytes() == Path("command.h5").read_bytes()
    assert found.crossings == 5 and np.abs(found.q["x"]).max() < 1e-14 and "5 crossings" in repr(found)
    many = lagrange.section(HENON, every="2*pi", crossings=3, over={"y": [0.1, 0.2]})
    assert many.q["y"].shape == (2, 3) and many.t.shape == (2, 3)
    for given, message in (
        ({}, "give either where"),
        ({"where": "x", "direction": "up"}, "direction must be one of rising"),
        ({"every": 1, "direction": "rising"}, "direction belongs to where"),
        ({"where": 3}, "where must be an expression"),
        ({"where": ""}, "where must be an expression"),
        ({"where": "x", "crossings": np.int32(0)}, "crossings must be a whole number"),
    ):
        with pytest.raises(lagrange.UsageError, match=message):
            lagrange.section(HENON, **given)


def test_an_output_is_loaded(tmp_path):
    swept = lagrange.sweep(PENDULUM, over={"l": [1, 2]}, stop=1)
    swept.save(tmp_path / "a.h5")
    loaded = lagrange.load(tmp_path / "a.h5")
    assert np.array_equal(loaded.q["theta"], swept.q["theta"]) and loaded.attributes == swept.attributes
    assert (loaded.name, loaded.status) == ("pendulum", "complete") and "a.h5" in repr(loaded)
    (tmp_path / "text.h5").write_text("text")
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["x"] = [1, 2]
    for name, message in (("none", "no such file"), ("text", "not an output"), ("other", "not an output")):
        with pytest.raises(lagrange.FileError, match=message):
            lagrange.load(tmp_path / f"{name}.h5")


def test_the_file_of_a_result_goes_with_it():
    swept = lagrange.sweep(PENDULUM, over={"l": [1, 2]}, stop=1)
    folder = swept.path.parent
    assert folder.is_dir()
    del swept
    gc.collect()
    assert not folder.exists()


def test_examples_are_systems():
    assert lagrange.solve(lagrange.example("pendulum"), stop=1).name == "pendulum"
    with pytest.raises(lagrange.UsageError, match="did you mean 'pendulum'"):
        lagrange.example("pendlum")


def test_members_that_actions_change_need_not_be_observed():
    """A ball between walls at 0 and 1/2, with q alone in the output: nothing is computed of its states."""
    text = """
    name: a ball
    coordinates: {x: {initial: 0.1, velocity: 1}}
    lagrangian: x_dot**2/2
    events: {wall: {when: x*(x - 1/2), action: {set: {x_dot: -x_dot}}}}
    """
    swept = lagrange.sweep(text, over={"x": [0.1, 0.3]}, stop=1, samples=3, outputs=["q"])
    assert np.asarray(swept.q["x"]) == pytest.approx(np.array([[0.1, 0.4, 0.1], [0.3, 0.2, 0.3]]))


COINCIDING = """
name: coinciding
parameters: {a: 1.0}
coordinates: {x: {initial: 0.6}, y: {initial: -0.8}, z: {initial: 0}}
masses: {p: 1}
positions: {p: [x, y, z]}
potential: 9.81*p.y - 0.3*p.z
constraints: {rod: x**2 + y**2 - 1, second: a*(x**2 + y**2 - 1) + (a - 1)*z}
"""


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.filterwarnings("ignore::lagrange_cli.LagrangeWarning")
def test_constraints_may_depend_on_each_other_in_some_members_only():
    """For a = 1 the second constraint is the first; else it keeps z at 0."""
    outputs = ["q", "multipliers", "h"]
    swept = lagrange.sweep(COINCIDING, over={"a": [2, 1, 1, 0.5]}, stop=2, samples=11, outputs=outputs)
    assert {*swept.statuses.flat} == {"complete"}
    assert np.abs(swept.q["z"][[0, 3]]).max() < 1e-15
    assert swept.q["z"][1] == pytest.approx(0.15 * swept.t**2, abs=1e-14)
    for i, a in enumerate([2, 1]):
        alone = lagrange.solve(COINCIDING, set={"a": a}, stop=2, samples=11, outputs=outputs)
        for path in ("q/x", "q/z", "multipliers/rod", "multipliers/second"):
            assert swept.datasets[path][i] == pytest.approx(alone.datasets[path], abs=1e-12)


@pytest.mark.exhaustive(keep=0.6)
def test_of_members_whose_constraints_depend_on_each_other_it_is_said_how_many():
    with pytest.warns(lagrange.LagrangeWarning, match="in 2 members the constraint second depends on"):
        lagrange.sweep(COINCIDING, over={"a": [2, 1, 1, 0.5]}, stop=1)


@pytest.mark.exhaustive(keep=0.45)
@pytest.mark.filterwarnings("ignore::lagrange_cli.LagrangeWarning")
def test_members_that_conserve_something_else_are_refused():
    """Only for a = 1 the momentum along z is conserved."""
    text = COINCIDING.replace(" - 0.3*p.z", "")
    swept = lagrange.sweep(text, over={"a": [2, 1]}, stop=1, outputs=["p"])
    assert swept.statuses.tolist() == ["complete", "failed"]
    assert "depend on each other differently" in swept.message


TOP = """
parameters: {I: 2.0, s: 0.4}
coordinates: {w: {initial: 1}, x: {initial: 0}, y: {initial: 0, velocity: 0.5}, z: {initial: 0}}
bodies:
  top: {mass: 1, inertia: [I, 2, 2.5], position: [0, 0, 0], orientation: {quaternion: [w, x, y, z]}}
  box: {mass: 1, solid: {box: [s, 0.3, 0.2]}, position: [0, 0, 0], orientation: {euler: [x, 1, z]}}
solve: {stop: 1, samples: 3}
"""


@pytest.mark.exhaustive(keep=0.2)
def test_moments_of_inertia_and_sizes_of_solids_may_differ_between_members():
    swept = lagrange.sweep(TOP, over={"I": [1, 2, 4], "s": [0.4, 0.7]}, outputs=["q"])
    for i, moment in enumerate((1, 2, 4)):
        for k, size in enumerate((0.4, 0.7)):
            alone = lagrange.solve(TOP, set={"I": moment, "s": size}, outputs=["q"])
            assert swept.q["y"][i, k] == pytest.approx(alone.q["y"], rel=1e-14)


@pytest.mark.parametrize(
    ("over", "message"),
    [
        ({"I": [1, 5, 6]}, r"member 1 \(and 1 more\) cannot be run: set I=5.0: the value 5 exceeds 2 \+ 2.5"),
        ({"s": [1, -1]}, "member 1 cannot be run: set s=-1.0: the value -1 is not positive in box of body"),
    ],
)
def test_a_member_with_impossible_moments_of_inertia_is_named(over, message):
    with pytest.raises(lagrange.UsageError, match=message):
        lagrange.sweep(TOP, over=over)


def test_a_group_of_arrays_outlives_its_sweep():
    """The file of the results is there as long as anything may be read from it."""
    system = "coordinates: {x: {initial: 1}}\nlagrangian: x_dot**2/2 - 2*x**2\nsolve: {stop: 1, samples: 3}\n"
    group = lagrange.sweep(system, over={"x": [1, 2]}, outputs="q").q
    gc.collect()
    assert group["x"].shape == (2, 3)
