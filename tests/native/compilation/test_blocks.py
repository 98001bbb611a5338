"""Straight code cut into blocks: short, however long the series, and with the same results."""

import numpy as np
import pytest

from lagrange_cli.expression.exact import ExactGraphAlgebra
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.methods.selection import follower
from lagrange_cli.integrate.precision import DOUBLE, DOUBLE_DOUBLE
from lagrange_cli.integrate.prepared import Prepared
from lagrange_cli.integrate.program import write_run
from lagrange_cli.mechanics.derive import derive
from lagrange_cli.model.build import build_model
from lagrange_cli.native.compilation import blocks, llvm, machine
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_long_values, resolve_values
from tests.support.motion import run

PRODUCT = """
coordinates: {x: {initial: 0.4, velocity: 0.1}}
masses: {bead: 1}
embedding: {bead: [x]}
potential: FACTORS
"""
OUTPUTS = frozenset({"q", "v", "p", "h", "ledger"})
TOLERANCE = {DOUBLE: 2.0**-52, DOUBLE_DOUBLE: 2.0**-104}


def written(precision, factors):
    """A system of so many factors, what is asked of it, and its program."""
    text = PRODUCT.replace("FACTORS", "*".join(f"sqrt(x**2 + {i}.5)" for i in range(factors)))
    spec = read_spec(text, "product.yaml")
    residual = derive(build_model(spec, ExactGraphAlgebra()))
    asked = Compilation("taylor", TOLERANCE[precision], OUTPUTS, precision=precision)
    return spec, asked, *write_run(residual, asked)


def longest_block(text):
    lengths = [0]
    for line in text.split("\n"):
        lengths.append(0 if line.endswith(":") else lengths[-1] + 1)
    return max(lengths)


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("precision", [DOUBLE, DOUBLE_DOUBLE])
def test_no_block_is_long_at_the_level_whose_time_grows_with_its_square(precision, monkeypatch):
    """200 factors took a minute to compile with double-double, in a block of 170,000 lines; here are 15."""
    compiled = []
    monkeypatch.setattr(llvm, "compile_text", lambda text, *options: compiled.append(text) or b"")
    _, _, program, _ = written(precision, 15)
    machine.compile_object(program, machine.QUICK)
    assert longest_block(program.text) > 5000 and longest_block(compiled[0]) < 1.5 * blocks.LONGEST


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("precision", [DOUBLE, DOUBLE_DOUBLE])
@pytest.mark.parametrize("longest", [7, 100])
def test_short_blocks_give_the_same_bits(precision, longest, monkeypatch):
    monkeypatch.setattr(blocks, "LONGEST", longest)
    spec, asked, program, recording = written(precision, 4)
    resolve = {DOUBLE: resolve_values, DOUBLE_DOUBLE: resolve_long_values}
    motions = []
    for level in (machine.QUICK, machine.FULL):
        loaded = machine.load_machine(machine.compile_object(program, level), program)
        ready = Prepared(recording, loaded, asked, follower(loaded, asked))
        motions.append(run(ready, resolve[precision](spec), 0.0, 1.0, 11))
    for path, series in motions[0].data.items():
        assert np.array_equal(series, motions[1].data[path]), path
