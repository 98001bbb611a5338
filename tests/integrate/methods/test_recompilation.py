"""Code of several levels of optimization: quick to compile or quick to run, and the same bits from all."""

import numpy as np
import pytest

from lagrange_cli import GraphAlgebra, build_model, derive, prepare, read_spec, resolve_values
from lagrange_cli.integrate import prepare as module
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.methods import compiled as code
from lagrange_cli.integrate.methods import stepper
from lagrange_cli.integrate.prepare import key_of, prepare_system, unpack
from lagrange_cli.integrate.run import integrate
from lagrange_cli.integrate.times import Times
from lagrange_cli.native.compilation import blocks, machine
from lagrange_cli.native.compilation.cache import Cache
from tests.support.command import SYSTEMS
from tests.support.systems import SIZES

RUN = Compilation("taylor", 2.0**-52, frozenset({"q", "v", "p", "h", "ledger"}))


def residual_of(spec):
    return derive(build_model(spec, GraphAlgebra()))


def bytes_of(spec, prepared, stop):
    chunks = []

    def emit(chunk):
        chunks.append({path: np.array(series) for path, series in chunk.items()})

    outcome = integrate(
        prepared, resolve_values(spec), Times(0.0, stop, 101, stop / 100), emit, lambda: False
    )
    return outcome, {path: b"".join(chunk[path].tobytes() for chunk in chunks) for path in chunks[0]}


@pytest.mark.exhaustive(keep=0.2, most=12)
@pytest.mark.parametrize(
    "path", sorted({*SYSTEMS.glob("*.yaml")} - {SYSTEMS / "bicycle.yaml"}), ids=lambda path: path.stem
)
def test_every_level_gives_the_same_bits(path, monkeypatch):
    """Also where quickly compiled code is cut into short blocks."""
    monkeypatch.setattr(blocks, "LONGEST", 25)
    spec = read_spec(path.read_bytes(), path.name, SIZES.get(path.stem))
    residual = residual_of(spec)
    quick, full = (
        bytes_of(spec, prepare(residual, RUN, level), 3.0) for level in (machine.QUICK, machine.FULL)
    )
    assert quick == full


@pytest.mark.exhaustive(keep=0.2)
def test_better_code_takes_over_in_a_long_run(tmp_path, monkeypatch):
    """It is asked for once, used as soon as it is there, kept for the next run, and changes no bit."""
    spec = read_spec((SYSTEMS / "double_pendulum.yaml").read_bytes(), "double_pendulum.yaml")
    plain = bytes_of(spec, prepare(residual_of(spec), RUN), 100.0)
    cache = Cache(str(tmp_path))
    monkeypatch.setattr(machine, "LARGE", 0)
    monkeypatch.setattr(code, "PATIENCE", 0.0)
    monkeypatch.setattr(stepper, "FIRST", 1)
    monkeypatch.setattr(stepper, "POLL_SECONDS", 1e-9)
    levels, used = [], []
    compile_object, load_machine = module.compile_object, module.load_machine

    def compiled(program, level):
        levels.append(level)
        return compile_object(program, level)

    def loaded(code, program):
        made = load_machine(code, program)
        advance = made.advance
        number = len(levels)

        def counted(*arguments):
            used.append(number)
            return advance(*arguments)

        object.__setattr__(made, "advance", counted)
        return made

    monkeypatch.setattr(module, "compile_object", compiled)
    monkeypatch.setattr(module, "load_machine", loaded)
    prepared = prepare_system(spec, residual_of, cache, RUN)
    assert levels == [machine.QUICK]
    assert bytes_of(spec, prepared, 100.0) == plain
    prepared.follower.recompilation._work.join()
    assert levels == [machine.QUICK, machine.FULL]
    assert bytes_of(spec, prepared, 100.0) == plain
    assert used[0] == 1
    assert used[-1] == 2
    key = key_of(spec, RUN)
    assert unpack(cache.load(key))[3] == machine.FULL
    again = prepare_system(spec, None, cache, RUN)
    assert again.cached
    assert again.follower.recompilation is None
    assert bytes_of(spec, again, 100.0) == plain


@pytest.mark.exhaustive(keep=0.25)
def test_quick_code_from_the_cache_is_improved_as_well(tmp_path, monkeypatch):
    spec = read_spec((SYSTEMS / "pendulum.yaml").read_bytes(), "pendulum.yaml")
    cache = Cache(str(tmp_path))
    monkeypatch.setattr(machine, "LARGE", 0)
    prepare_system(spec, residual_of, cache, RUN)
    second = prepare_system(spec, residual_of, cache, RUN)
    assert second.cached
    assert second.follower.recompilation is not None
    monkeypatch.setattr(code, "PATIENCE", 0.0)
    assert second.follower.recompilation.after(1.0) is None
    second.follower.recompilation._work.join()
    assert second.follower.recompilation.after(0.0).advance is not None
    assert unpack(cache.load(key_of(spec, RUN)))[3] == machine.FULL
