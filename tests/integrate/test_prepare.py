"""Compiled programs from the cache: for which runs one serves, and that it is the same program."""

import json
import math
import subprocess
import sys
import threading

import numpy as np
import pytest

from lagrange_cli import GraphAlgebra, build_model, derive, prepare, read_spec, resolve_values
from lagrange_cli.integrate import prepare as module
from lagrange_cli.integrate.background import concurrently
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.ensemble.follow import ensemble_method
from lagrange_cli.integrate.ensemble.method import Starts
from lagrange_cli.integrate.methods import compiled
from lagrange_cli.integrate.methods.table import METHODS
from lagrange_cli.integrate.prepare import key_of, pack, prepare_system, unpack
from lagrange_cli.integrate.program import write_run
from lagrange_cli.integrate.run import integrate
from lagrange_cli.integrate.times import Times
from lagrange_cli.native.compilation import fingerprint
from lagrange_cli.native.compilation.cache import Cache
from lagrange_cli.records import fields_of, replace
from lagrange_cli.spec.spec import Spec
from lagrange_cli.spec.structure import NUMBERS, OUTSIDE, structure
from tests.support.command import PATIENCE, SYSTEMS, environment
from tests.support.motion import NAMES
from tests.support.systems import SIZES

PENDULUM = (SYSTEMS / "pendulum.yaml").read_text()
RUN = Compilation("taylor", 2.0**-52, frozenset({"q", "v", "p", "h"}))
MANY = frozenset({"q", "v", "p", "h", "ledger", "action"})


def residual_of(spec):
    return derive(build_model(spec, GraphAlgebra()))


def never(spec):
    raise AssertionError("nothing is derived where a compiled program is at hand")


def samples(spec, prepared):
    chunks = []
    times = Times(0.0, 2.0, 21, 0.1)

    def emit(chunk):
        chunks.append({path: series.tobytes() for path, series in chunk.items()})

    return integrate(prepared, resolve_values(spec), times, emit, lambda: False), chunks


@pytest.fixture
def cache(tmp_path):
    return Cache(str(tmp_path / "cache"))


@pytest.mark.exhaustive(keep=0.2, most=30)
@pytest.mark.parametrize(
    ("path", "method"),
    [
        pytest.param(path, method, id=f"{path.stem}-{method}")
        for path in sorted({*SYSTEMS.glob("*.yaml")} - {SYSTEMS / "bicycle.yaml"})
        for method, row in METHODS.items()
        if method in ("taylor", "DOP853", "Radau") and (row.constrains or path.stem in NAMES)
    ],
)
def test_the_same_numbers_come_out_to_the_last_bit(path, method, cache, monkeypatch):
    # better code for long runs is derived anew; on a busy machine any of these may be long
    monkeypatch.setattr(compiled, "PATIENCE", math.inf)
    spec = read_spec(path.read_bytes(), path.name, SIZES.get(path.stem))
    outputs = MANY if spec.lagrangian else MANY | {"positions", "energy"}
    run = Compilation(method, RUN.tolerance if method == "taylor" else 1e-8, outputs)
    plain = prepare(residual_of(spec), run)
    first = prepare_system(spec, residual_of, cache, run)
    second = prepare_system(spec, never, cache, run)
    assert (plain.cached, first.cached, second.cached) == (False, False, True)
    assert plain.datasets == first.datasets == second.datasets
    assert samples(spec, plain) == samples(spec, first) == samples(spec, second)


@pytest.mark.exhaustive(keep=0.65)
@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("m: {value: 1.0", "m: {value: 2.5"),
        ("g: {value: 9.81", "g: {value: 1.62"),
        ("unit: kg", "unit: g"),
        ("initial: ", "initial: 1 + "),
        ("name: ", "name: another "),
        ("stop: 20", "stop: 7"),
    ],
)
def test_numbers_and_words_make_no_new_program(old, new, cache):
    assert old in PENDULUM
    prepare_system(read_spec(PENDULUM, "a.yaml"), residual_of, cache, RUN)
    other = read_spec(PENDULUM.replace(old, new), "b.yaml")
    assert prepare_system(other, never, cache, RUN).cached
    program, _ = write_run(residual_of(other), RUN)
    assert program.text == write_run(residual_of(read_spec(PENDULUM, "a.yaml")), RUN)[0].text


@pytest.mark.exhaustive(keep=0.65)
@pytest.mark.parametrize(
    "change",
    [
        {"tolerance": 1e-9},
        {"outputs": RUN.outputs | {"action"}},
        {"outputs": RUN.outputs - {"p"}},
        {"method": "DOP853"},
        {"method": "Radau"},
        {"ensemble": True},
    ],
    ids=["tolerance", "one output more", "one output less", "DOP853", "Radau", "ensemble"],
)
def test_another_kind_of_run_is_another_program(change, cache):
    spec = read_spec(PENDULUM, "pendulum.yaml")
    prepare_system(spec, residual_of, cache, RUN)
    assert not prepare_system(spec, residual_of, cache, replace(RUN, **change)).cached
    assert len(cache.entries()) == 2


def test_an_ensemble_gives_the_same_from_the_cache(cache):
    spec = read_spec(PENDULUM, "pendulum.yaml")
    values = resolve_values(spec)
    parameters = np.tile([*values.parameters.values()], (3, 1))
    states = np.array([[0.1, 0.0], [1.0, 0.0], [2.0, 1.0]])
    found = []
    for source in (residual_of, never):
        method = ensemble_method(prepare_system(spec, source, cache, replace(RUN, ensemble=True)), never)
        batches = []
        times = Times(0.0, 2.0, 21, 0.1)
        method.follow(Starts(parameters, states, times, True), batches.append, lambda done: False, 2)
        found.append({i: x.tobytes() for each in batches for i, x in zip(each.index, each.samples)})
    assert found[0] == found[1] and len(found[0]) == 3


def test_methods_of_a_kind_share_a_program_whatever_the_tolerance(cache):
    spec = read_spec(PENDULUM, "pendulum.yaml")
    prepare_system(spec, residual_of, cache, replace(RUN, method="LSODA", tolerance=1e-6))
    prepared = prepare_system(spec, never, cache, replace(RUN, method="BDF", tolerance=1e-8))
    assert (prepared.compilation.method, prepared.compilation.tolerance) == ("BDF", 1e-8)
    assert (prepared.follower.name, prepared.follower.tolerance) == ("BDF", 1e-8)


EXPRESSIONS = {
    "masses": ("bob: m", "bob: 2*m"),
    "embedding": ("l*sin(theta)", "l*sin(2*theta)"),
    "potential": ("m*g*bob.y", "m*g*bob.y + theta"),
    "coordinates": ("theta", "phi"),
    "parameters": ("parameters:\n", "parameters:\n  another: 1\n"),
}


@pytest.mark.parametrize(("old", "new"), EXPRESSIONS.values(), ids=EXPRESSIONS)
def test_another_system_is_another_program(old, new):
    assert old in PENDULUM
    spec, other = read_spec(PENDULUM, "a.yaml"), read_spec(PENDULUM.replace(old, new), "a.yaml")
    assert key_of(spec, RUN) != key_of(other, RUN)


def test_families_of_other_sizes_or_indices_are_other_programs():
    text = """
sizes: {{N: 2}}
coordinates:
  w[i in range(N), j in range(N)]: {{initial: 0}}
masses:
  p[i in range(N), j in range(N)]: 1
embedding:
  p[{} in range(N), {} in range(N)]: (1 + i)*w[i, j]
"""
    keys = {key_of(read_spec(text.format(*axes), "a.yaml"), RUN) for axes in ("ij", "ij", "ji")}
    assert len(keys | {key_of(read_spec(text.format(*"ij"), "a.yaml", {"N": "3"}), RUN)}) == 3


def test_whatever_a_spec_holds_is_part_of_its_structure_or_known_to_be_none():
    spec = read_spec(PENDULUM, "pendulum.yaml")
    assert set(structure(spec)) == set(fields_of(Spec)) - OUTSIDE
    assert set(structure(spec)) > NUMBERS
    json.dumps(structure(spec))
    with pytest.raises(TypeError, match="has no place"):
        structure(replace(spec, forces=object()))


def test_the_key_holds_code_llvm_and_processor(monkeypatch):
    spec = read_spec(PENDULUM, "pendulum.yaml")
    known = fingerprint.fingerprint()
    assert {"version", "code", "llvm", "processor", "python"} == set(known)
    assert all(known.values())
    key = key_of(spec, RUN)
    for name in known:
        with monkeypatch.context() as patched:
            patched.setattr(fingerprint, "fingerprint", lambda name=name: {**known, name: "another"})
            assert key_of(spec, RUN) != key


def test_the_processor_is_described_without_its_speed_of_the_moment(monkeypatch):
    assert not [line for line in fingerprint.described() if "MHz" in line or "processor\t" in line]
    monkeypatch.setattr(fingerprint, "described", list)
    assert len(fingerprint.processor()) == 2  # LLVM's name for it, and what it can do


def test_where_the_code_cannot_be_examined_nothing_is_cached(monkeypatch, cache):
    def fails():
        raise OSError("in an archive")

    monkeypatch.setattr(fingerprint, "fingerprint", fails)
    spec = read_spec(PENDULUM, "pendulum.yaml")
    for _ in range(2):
        assert not prepare_system(spec, residual_of, cache, RUN).cached


@pytest.mark.parametrize(
    "payload", [b"", b"{}\n", b"[1]\n\x7fELF", b'{"interface": {"a": 1}}\ncode', b"\xff\n"]
)
def test_an_entry_that_makes_no_sense_is_rebuilt_in_silence(payload, cache):
    assert unpack(payload) is None
    spec = read_spec(PENDULUM, "pendulum.yaml")
    cache.store(key_of(spec, RUN), payload)
    assert not prepare_system(spec, residual_of, cache, RUN).cached
    assert prepare_system(spec, never, cache, RUN).cached


def test_what_is_packed_is_unpacked(cache):
    program, recording = write_run(residual_of(read_spec(PENDULUM, "a")), replace(RUN, outputs=MANY))
    interface, again, code, level = unpack(pack(program, recording, b"\n\0code", 1))
    assert (again, code, level) == (recording, b"\n\0code", 1)
    assert interface.as_data() == program.as_data()
    assert (interface.rows, interface.trial) == (program.rows, program.trial)


@pytest.mark.parametrize("cached", [False, True])
def test_stages_are_told_apart_and_the_meantime_is_used_once(cached, cache):
    spec = read_spec(PENDULUM, "pendulum.yaml")
    if cached:
        prepare_system(spec, residual_of, cache, RUN)
    seen = []

    def stage(name):
        seen.append(name)
        return module.untimed(name)

    prepare_system(spec, residual_of, cache, RUN, stage=stage, meanwhile=lambda: seen.append("meanwhile"))
    compiling = ["import", "derive", "program", "compile", "import", "meanwhile", "cache"]
    assert seen == ["cache", *(["import", "meanwhile"] if cached else compiling), "import"]


def test_work_in_the_background_gives_its_value_after_both_are_done():
    begun, done = threading.Event(), threading.Event()

    def work():
        begun.set()
        assert done.wait(PATIENCE)
        return 42

    def other():
        assert begun.wait(PATIENCE)
        done.set()

    assert concurrently(work, other) == 42


@pytest.mark.parametrize("error", [RuntimeError("LLVM is out of sorts"), MemoryError(), KeyboardInterrupt()])
def test_work_in_the_background_fails_as_it_would_by_itself(error):
    def fail():
        raise error

    with pytest.raises(type(error)):
        concurrently(fail, lambda: None)
    with pytest.raises(type(error)):
        concurrently(lambda: None, fail)


PROBE = """
import sys
from lagrange_cli.cli.main import main
assert main(sys.argv[1:]) == 0
print(*sys.modules)
"""


@pytest.mark.exhaustive(keep=0.2)
def test_a_run_from_the_cache_loads_neither_llvm_nor_what_derives(tmp_path):
    arguments = ["solve", str(SYSTEMS / "pendulum.yaml"), "--force", "--quiet"]
    loaded = [
        set(
            subprocess.run(
                [sys.executable, "-c", PROBE, *arguments],
                cwd=tmp_path,
                env={**environment(), "LAGRANGE_CACHE_DIR": str(tmp_path / "cache")},
                capture_output=True,
                text=True,
                check=True,
            ).stdout.split()
        )
        for _ in range(2)
    ]
    compiling = {"llvmlite.binding", "lagrange_cli.native.program", "lagrange_cli.mechanics.derive"}
    assert compiling <= loaded[0]
    deriving = ("lagrange_cli.mechanics", "lagrange_cli.model.model", "lagrange_cli.model.build")
    assert not [name for name in loaded[1] if name.startswith(deriving)]
    assert not compiling & loaded[1]
