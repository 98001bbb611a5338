"""Motions in Python: what the command computes, with the same bytes, messages and limits, as arrays."""

import os
import pickle
import signal
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import h5py
import numpy as np
import pytest
import yaml

import lagrange_cli as lagrange
import lagrange_cli.integrate.program as program
import lagrange_cli.integrate.run as running
import lagrange_cli.spec.read as reading
from lagrange_cli.api import kept
from lagrange_cli.api.system import content_of
from lagrange_cli.cli.main import main
from lagrange_cli.run.derive import read_run
from lagrange_cli.spec.structure import structure
from lagrange_cli.spec.values import resolve_values
from lagrange_cli.spec.whole import WrittenFamily
from tests.support.command import SYSTEMS

PENDULUM = SYSTEMS / "pendulum.yaml"
COLLISION = """
coordinates: {x: {initial: 1}}
lagrangian: x_dot**2/2 + 1/x
solve: {stop: 2}
"""
"""A fall into a centre: x = 0 at t = pi/sqrt(8) = 1.11."""


@pytest.mark.exhaustive(keep=0.7)
def test_a_motion_has_what_the_file_has(tmp_path):
    motion = lagrange.solve(PENDULUM, set={"l": 2}, stop=2, outputs="all")
    motion.save(tmp_path / "a.h5")
    with h5py.File(tmp_path / "a.h5") as file:
        assert np.array_equal(motion.t, file["t"]) and motion.t[-1] == 2
        assert np.array_equal(motion.q["theta"], file["q/theta"])
        assert np.array_equal(motion.v["theta"], file["v/theta"])
        assert np.array_equal(motion.p["theta"], file["diagnostics/p/theta"])
        assert np.array_equal(motion.h, file["diagnostics/h"])
        assert np.array_equal(motion.ledger["p"]["theta"], file["diagnostics/ledger/p/theta"])
        assert np.array_equal(motion.positions["bob"], file["positions/bob"])
        assert motion.attributes["h_drift"] == file.attrs["h_drift"]
    assert (motion.name, motion.status, motion.message) == ("pendulum", "complete", "reached the end, t = 2")
    assert motion.parameters["l"] == 2 and motion.certificate is None and "energy" in dir(motion)
    with pytest.raises(ValueError, match="read-only"):
        motion.t[0] = 1


CASES = {
    "pendulum": ({"set": {"l": 2, "theta": "pi/3"}, "stop": "4*pi", "samples": 50},
                 ["--set", "l=2", "--set", "theta=pi/3", "--stop", "4*pi", "--samples", "50"]),
    "bouncing_ball": ({}, []),
    "four_bar": ({"stop": 0.5, "outputs": ["q", "multipliers"]},
                 ["--stop", "0.5", "--outputs", "q,multipliers"]),
    "n_pendulum": ({"size": {"N": 3}, "set": {"theta": [0.1, 0.2, 0.3]}, "stop": 1},
                   ["--size", "N=3", "--set", "theta[0]=0.1", "--set", "theta[1]=0.2",
                    "--set", "theta[2]=0.3", "--stop", "1"]),
}  # fmt: skip


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("name", CASES)
def test_a_motion_is_saved_to_the_bytes_of_the_command(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    given, options = CASES[name]
    system = SYSTEMS / f"{name}.yaml"
    assert main(["solve", str(system), *options, "-o", "command.h5", "--quiet"]) == 0
    lagrange.solve(system, **given).save("python.h5")
    assert Path("python.h5").read_bytes() == Path("command.h5").read_bytes()
    if name == "pendulum":
        assert main(["solve", str(system), *options, "-o", "command.csv", "--quiet"]) == 0
        lagrange.solve(system, **given).save("python.csv")
        assert Path("python.csv").read_bytes() == Path("command.csv").read_bytes()
        with pytest.raises(lagrange.FileError, match=r"python.csv already exists"):
            lagrange.solve(system, **given).save("python.csv")
        with pytest.raises(lagrange.UsageError, match="outputs are HDF5 or CSV, not txt"):
            lagrange.solve(system, **given).save("python.txt")


@pytest.mark.exhaustive(keep=0.55)
def test_a_certified_motion_is_saved_to_the_bytes_of_the_command(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["solve", str(PENDULUM), "--stop", "1", "--digits", "5", "-o", "command.h5", "--quiet"]) == 0
    motion = lagrange.solve(PENDULUM, stop=1, digits=5)
    motion.save("python.h5")
    assert Path("python.h5").read_bytes() == Path("command.h5").read_bytes()
    assert motion.certificate.trusted_until == 1 and motion.error["q/theta"][-1] < 1e-12


def test_a_system_is_a_file_a_text_or_a_mapping():
    text = PENDULUM.read_text(encoding="utf-8")
    content = yaml.safe_load(text)
    content["parameters"]["m"]["value"] = np.float64(1)
    ends = [lagrange.solve(one, stop=1).q["theta"][-1] for one in (str(PENDULUM), PENDULUM, text, content)]
    assert len({*ends}) == 1
    line = "{coordinates: [x], lagrangian: x_dot**2/2}"
    assert lagrange.solve(line, set={"x": np.array(1)}, stop=np.float32(1)).q["x"][-1] == 1
    with pytest.raises(lagrange.SpecError, match="unknown key 'coords'"):
        lagrange.solve("coords: [x]")


@pytest.mark.exhaustive(keep=0.2)
def test_mappings_are_the_systems_that_they_were_read_from():
    found = 0
    for path in sorted(SYSTEMS.glob("*.yaml")):
        text = path.read_text(encoding="utf-8")
        try:
            mapping = yaml.safe_load(text)
        except yaml.YAMLError:  # brackets of indices within a flow mapping, which only our reader takes
            continue
        read = [
            read_run(*content_of(one), None, lambda spec, problems: resolve_values(spec, {}, problems))
            for one in (text, mapping)
        ]
        (spec, values), (other, others) = read
        assert structure(spec) == structure(other)
        assert (values.parameters, values.q, values.v) == (others.parameters, others.q, others.v)
        found += 1
    assert found > 30


@pytest.mark.exhaustive(keep=0.45)
def test_a_motion_goes_to_another_process_and_is_saved_there(tmp_path):
    motion = lagrange.solve(SYSTEMS / "bouncing_ball.yaml", stop=1)
    again = pickle.loads(pickle.dumps(motion))
    for name, one in (("a.h5", motion), ("b.h5", again)):
        one.save(tmp_path / name)
    assert (tmp_path / "a.h5").read_bytes() == (tmp_path / "b.h5").read_bytes()
    for wrong in ({"coordinates": ["x"]}, "nosuch.yaml", COLLISION):
        with pytest.raises(lagrange.LagrangeError) as caught:
            lagrange.solve(wrong)
        error = pickle.loads(pickle.dumps(caught.value))
        assert (type(error), str(error)) == (type(caught.value), str(caught.value))
        assert getattr(error, "problems", ()) == getattr(caught.value, "problems", ())
    assert error.result.status == "failed"
    assert again.units == motion.units and again.units["q/y"] == "m"


@pytest.mark.parametrize("system", [3, None, b"name: x", {"a": object()}])
def test_what_is_no_system_is_refused(system):
    with pytest.raises(lagrange.UsageError, match="system"):
        lagrange.solve(system)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"set": {"nosuch": 1}}, "unknown name 'nosuch'"),
        ({"set": {"l": True}}, "set: l must be a number or an expression, not True"),
        ({"set": {"l": None}}, "set: l must be a number or an expression"),
        ({"set": {"l": [1, 2]}}, "'l' is one number and takes no index"),
        ({"set": ["l=1"]}, "set must be a mapping from names to values"),
        ({"stop": "theta"}, "'theta' is not constant"),
        ({"stop": float("nan")}, "finite times"),
        ({"samples": 1.5}, "samples must be a whole number"),
        ({"tolerance": "tight"}, "tolerance must be a number"),
        ({"outputs": ["q", "nosuch"]}, "unknown output 'nosuch'"),
        ({"outputs": []}, "outputs must be a list of names"),
        ({"precision": "single"}, "precision is 'double' or"),
        ({"certify": True, "portable": True}, "cannot be combined"),
        ({"outputs": 3}, "outputs must be a list of names"),
        ({"digits": "six"}, "digits must be a number"),
        ({"target_error": None, "digits": True}, "digits must be a number"),
        ({"digits": 20}, "digits must be a number from 1 to 15"),
        ({"size": {"N": 2}}, "unknown size 'N'"),
    ],
)  # fmt: skip
def test_an_argument_that_makes_no_sense_is_refused(given, message):
    with pytest.raises(lagrange.UsageError, match=message):
        lagrange.solve(PENDULUM, **given)


def test_errors_have_the_messages_of_the_command(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    wrong = "coordinates: {x: {initial: 1}}\nlagrangian: x_dot**2/2 + y\n"
    Path("wrong.yaml").write_text(wrong)
    for _ in range(2):  # also when it has been read before
        with pytest.raises(lagrange.SpecError) as caught:
            lagrange.solve("wrong.yaml")
        assert main(["solve", "wrong.yaml"]) == 3
        assert str(caught.value) == capsys.readouterr().err.rstrip("\n")
    with pytest.raises(lagrange.FileError, match=r"lagrange systems pendulum > pendulum\.yaml"):
        lagrange.solve("pendulum.yaml")
    with pytest.raises(
        AttributeError,
        match=r"'energy' was not computed: solve with outputs=\['q', 'v', 'p', 'h', 'energy'\]",
    ):
        lagrange.solve(PENDULUM, stop=1).energy  # noqa: B018
    with pytest.raises(KeyError, match="did you mean 'theta'"):
        lagrange.solve(PENDULUM, stop=1).q["tehta"]


def test_a_motion_that_fails_is_raised_with_what_was_computed(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("fall.yaml").write_text(COLLISION)
    assert main(["solve", "fall.yaml", "-o", "command.h5", "--quiet"]) == 4
    with pytest.raises(lagrange.MotionError) as caught:
        lagrange.solve("fall.yaml")
    motion = caught.value.result
    assert str(caught.value) == capsys.readouterr().err.strip().replace("--stop", "stop")
    assert motion.status == "failed" and 1 < motion.t[-1] < 1.2
    motion.save("python.h5")
    assert Path("python.h5").read_bytes() == Path("command.h5").read_bytes()


def test_warnings_are_pythons():
    spring = {"name": "spring", "coordinates": {"x": {"initial": 1, "unit": "m"}},
              "parameters": {"k": {"value": 1, "unit": "kg"}}, "masses": {"a": "k"},
              "embedding": {"a": ["x + sin(x)"]}, "solve": {"stop": 1}}  # fmt: skip
    with pytest.warns(lagrange.LagrangeWarning, match="nothing is converted"):
        motion = lagrange.solve(spring)
    assert "nothing is converted" in motion.notes[0]


def interrupting(monkeypatch, after):
    """Have the integration of a motion send Ctrl-C to this process after so many looks outside."""
    looks = 0
    integrate = running.integrate

    def slow(prepared, values, times, emit, interrupted, **rest):
        def watched():
            nonlocal looks
            looks += 1
            if looks == after:
                os.kill(os.getpid(), signal.SIGINT)
            return interrupted()

        return integrate(prepared, values, times, emit, watched, **rest)

    monkeypatch.setattr(running, "integrate", slow)


def test_a_motion_that_is_interrupted_keeps_what_was_computed(monkeypatch, tmp_path):
    interrupting(monkeypatch, 3)
    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt) as caught:
        lagrange.solve(PENDULUM, stop=1e9, step=100)
    assert isinstance(caught.value, lagrange.Interrupted)
    motion = caught.value.result
    assert motion.status == "interrupted" and 1 < len(motion.t) < 1e7
    assert signal.getsignal(signal.SIGINT) is before
    motion.save(tmp_path / "a.h5")
    with h5py.File(tmp_path / "a.h5") as file:
        assert len(file["t"]) == len(motion.t) and "checkpoint" in file


def test_handlers_of_the_program_stay(monkeypatch):
    handlers, integrate = [], running.integrate

    def watched(*given, **more):
        handlers.append((signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)))
        return integrate(*given, **more)

    monkeypatch.setattr(running, "integrate", watched)
    own, term = (lambda *_: None), signal.getsignal(signal.SIGTERM)
    before = signal.signal(signal.SIGINT, own)
    try:
        lagrange.solve(PENDULUM, stop=1)
    finally:
        signal.signal(signal.SIGINT, before)
    assert handlers == [(own, term)]


@pytest.fixture
def made(monkeypatch):
    """How often a file is read, and a program written, from now on; nothing is kept from before."""
    kept.SYSTEMS.clear()
    counts = {"read": 0, "write": 0}

    def counting(module, name, what):
        function = getattr(module, name)

        def counted(*given, **named):
            counts[what] += 1
            return function(*given, **named)

        monkeypatch.setattr(module, name, counted)

    counting(reading, "examine", "read")
    counting(program, "write_run", "write")
    return counts


def test_nothing_is_read_derived_or_compiled_again(made, monkeypatch):
    monkeypatch.setenv("LAGRANGE_NO_CACHE", "1")
    for length in (1, 1.5, 2.0):
        lagrange.solve(PENDULUM, set={"l": length}, stop=1 + length)
    assert made == {"read": 1, "write": 1}
    with pytest.raises(lagrange.UsageError):
        lagrange.solve(PENDULUM, set={"l": "nosuch"})
    lagrange.solve(PENDULUM, outputs=["q"], stop=1)  # another program
    assert made == {"read": 1, "write": 2}


def test_a_file_that_is_changed_is_read_again(made, tmp_path):
    path = tmp_path / "a.yaml"
    for start in (1, 2):
        path.write_text(f"coordinates: {{x: {{initial: {start}}}}}\nlagrangian: x_dot**2/2\n")
        assert lagrange.solve(path, stop=1).q["x"][0] == start
    assert made["read"] == 2


def test_threads_have_the_numbers_of_one(made):
    lengths = np.linspace(1, 2, 12)
    alone = [lagrange.solve(PENDULUM, set={"l": one}, stop=3).q["theta"] for one in lengths]
    kept.SYSTEMS.clear()
    made.update(read=0)
    barrier = threading.Barrier(4)

    def follow(one):
        if one in lengths[:4]:
            barrier.wait(60)
        return lagrange.solve(PENDULUM, set={"l": one}, stop=3).q["theta"]

    with ThreadPoolExecutor(4) as pool:
        together = [*pool.map(follow, lengths)]
    assert made["read"] == 1
    assert all(np.array_equal(a, b) for a, b in zip(alone, together, strict=True))


def test_an_event_that_never_happened_has_no_crossings(tmp_path):
    text = "coordinates: {x: {initial: 1}}\nlagrangian: x_dot**2/2\nevents: {far: {when: x - 5}}\n"
    motion = lagrange.solve(text, stop=1)
    motion.save(tmp_path / "free.h5")
    for found in (motion, lagrange.load(tmp_path / "free.h5")):
        assert found.events["far"]["t"].shape == found.events["far"]["v/x"].shape == (0,)


@pytest.mark.exhaustive(keep=0.45)
def test_a_motion_becomes_a_tree_of_xarray():
    tree = lagrange.solve(
        SYSTEMS / "n_pendulum.yaml", size={"N": 3}, stop=1, outputs="q,v,positions"
    ).to_xarray()
    assert tree["q"].theta.dims == ("t", "N") and tree["positions"].bob.dims == ("t", "N", "xy")
    ball = lagrange.solve(SYSTEMS / "bouncing_ball.yaml").to_xarray()
    assert ball["events/floor/v"].sizes["t"] == len(ball["events/floor/v"].t) > 1
    assert ball["q"].y.attrs["units"] == "m"


def test_without_xarray_the_command_that_installs_it_is_named(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "xarray", None)
    with pytest.raises(lagrange.MissingPackage, match=r"pip install 'lagrange-cli\[xarray\]'"):
        lagrange.solve(PENDULUM, stop=1).to_xarray()


def test_a_family_needs_as_many_values_as_it_has_members():
    chain = lagrange.example("n_pendulum")
    for wrong in ({"theta": [0.1, 0.2]}, {"theta_dot": [0.1]}, {"theta": []}):
        with pytest.raises(lagrange.UsageError, match=r"has 3 members, but (1 value is|. values are) given"):
            lagrange.solve(chain, size={"N": 3}, set=wrong, stop=0.1)
        for other in (lagrange.check, lagrange.equations, lagrange.bench, lagrange.view):
            with pytest.raises(lagrange.UsageError, match=r"has 3 members, but . value"):
                other(chain, size={"N": 3}, set=wrong)


@pytest.mark.exhaustive(keep=0.4)
def test_members_of_large_families_are_not_looked_at_one_by_one(monkeypatch):
    made, make = [], WrittenFamily._make

    def counted(self, *given):
        made.append(given)
        return make(self, *given)

    monkeypatch.setattr(WrittenFamily, "_make", counted)
    motion = lagrange.solve(SYSTEMS / "fpu_chain.yaml", size={"N": 1200}, stop=0.01, samples=2)
    assert motion.status == "complete"
    assert len(made) < 50


def test_a_member_that_is_given_twice_is_refused():
    """Before, the last value held in silence."""
    for name in ("theta[0]", "theta[N - 3]"):
        given = {"theta": [0.1, 0.2, 0.3], name: 2}
        with pytest.raises(lagrange.UsageError, match=r"theta\[0\]'? is given twice, as 0.1 and as 2: leave"):
            lagrange.solve(lagrange.example("n_pendulum"), size={"N": 3}, set=given, stop=1)
