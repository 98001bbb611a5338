"""Functions of complex numbers in disks, against mpmath at random points of the disks."""

from __future__ import annotations

import ctypes
import math
import random
from functools import cache

import mpmath
import numpy as np
import pytest

from lagrange_cli.expression.build import build
from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.node import Node
from lagrange_cli.expression.parse import parse
from lagrange_cli.native.compilation.llvm import compile_text
from lagrange_cli.native.compilation.machine import load
from lagrange_cli.native.functions.elementary import definitions
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Real
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.native.recurrences.disk import Disks
from lagrange_cli.native.recurrences.disk_arithmetic import Disk
from lagrange_cli.native.recurrences.evaluation import emit_values

MP = mpmath.mp.clone()
MP.prec = 200
FUNCTIONS = {
    name: getattr(MP, name) for name in ("sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh")
}
FUNCTIONS |= {name: getattr(MP, name) for name in ("tanh", "exp", "log", "sqrt")}
FUNCTIONS["atan2"] = lambda y, x: (MP.log(x + 1j * y) - MP.log(x - 1j * y)) / 2j
EXPRESSIONS = [
    "x + y", "x - 3", "x*y", "x/y", "2*x - y/3 + 1", "x**2", "x**3", "x**7", "x**40", "x**64*x**6", "1/x",
    "x**-5", "sqrt(x)", "x**1.5", "x**-0.5", "x**0.3", "x**-2.7", "(1 + x**2)**-1.5", "x**y", "2**x",
    "sin(x)", "cos(x)", "tan(x)", "asin(x)", "acos(x)", "atan(x)", "atan2(y, x)", "sinh(x)", "cosh(x)",
    "tanh(x)", "exp(x)", "log(x)", "1/cosh(x)**2", "sinh(x)/cosh(x)**3", "1/(1 + (10*x)**12)",
    "1/(1 + exp(x))", "exp(-x**2)", "sin(x)**62", "1 - tanh(x)**2", "cos(atan(x))**6",
    "(sqrt(1 + x**4) - x**2)**4", "1/(x**2 + y**2)", "exp(x*y) - y",
]  # fmt: skip
SHARES = 2.0**-30, 1e-4, 0.03, 0.2, 0.5, 0.8, 0.95, 1.2
"""Radii as parts of a length."""


@cache
def compiled():
    """A function of centres (2), radii (2, lanes) and results: centre, radii and least sizes of each
    expression."""
    f = Function("define void @run(ptr %centres, ptr %radii, ptr %out) #0")
    emitter = Emitter(f)
    disks = Disks(f, emitter, LANES)
    algebra = GraphAlgebra()
    nodes = [build(parse(text), algebra.symbol, algebra) for text in EXPRESSIONS]
    known: dict[Node, Disk | None] = {}
    for i, name in enumerate("xy"):
        known[algebra.symbol(name)] = Disk(
            emitter.load("%centres", i), f.load_row("%radii", LANES * i, LANES)
        )
    emit_values(disks, nodes, known, None)
    for i, node in enumerate(nodes):
        made, place = known[node], i * (2 * LANES + 1)
        f.store(Real(f, emitter.written(made.centre), 1), "%out", place)
        f.store_row(disks.radius(made), "%out", place + 1)
        f.store_row(disks.least(made), "%out", place + 1 + LANES)
    f.give()
    text = f.text()
    code = load(compile_text(text + definitions(text), 1))
    pointer = ctypes.c_void_p
    run = ctypes.CFUNCTYPE(None, pointer, pointer, pointer)(code.address("run"))

    def evaluate(centres, radii):
        assert code is not None
        given, sizes = np.array(centres, dtype=float), np.array(radii, dtype=float)
        out = np.empty((len(EXPRESSIONS), 2 * LANES + 1))
        run(given.ctypes.data, sizes.ctypes.data, out.ctypes.data)
        return dict(zip(EXPRESSIONS, out))

    return evaluate


def value(text, x, y):
    """The expression at complex numbers; None where it has none."""
    try:
        return eval(text, dict(FUNCTIONS), {"x": x, "y": y})
    except (ZeroDivisionError, ValueError, OverflowError):
        return None


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("size", [1e-3, 0.3, 0.9, 3.0, 30.0])
def test_values_lie_in_the_disks(size):
    draw = random.Random(repr(size))
    for _ in range(4):
        centres = size * draw.uniform(0.5, 1.5), size * draw.uniform(0.5, 1.5)
        radii = [[share * centre * draw.uniform(0.5, 1) for share in SHARES] for centre in centres]
        found = compiled()(centres, radii)
        for text, (centre, *rest) in found.items():
            exact = value(text, *map(MP.mpf, centres))
            if exact is None or exact.imag or not math.isfinite(centre):
                continue
            for lane in range(LANES):
                radius, least = rest[lane], rest[LANES + lane]
                if not radius < math.inf:
                    continue
                turns = [MP.expjpi(draw.uniform(-1, 1)) * draw.choice([1, 1, draw.random()]) for _ in "xyz"]
                turns += [MP.mpf(1), MP.mpf(-1)]
                for turn in turns:
                    x, y = (MP.mpf(c) + turn * r[lane] for c, r in zip(centres, radii))
                    one = value(text, x, y)
                    assert one is not None, (text, centres, lane)
                    assert abs(one - centre) <= radius * (1 + 2**-40), (text, centres, lane)
                    assert abs(one) >= least * (1 - 2**-40), (text, centres, lane)


@pytest.mark.exhaustive(keep=4)
@pytest.mark.parametrize(
    ("text", "centre", "share", "bound"),
    [
        ("1/(1 + (10*x)**12)", 30.0, 0.5, 1e-20),  # (10 x)^12 is large on all of a disk that contains 0
        ("1/cosh(x)**2", 30.0, 0.8, 1e-4),
        ("1/(1 + exp(x))", 30.0, 0.8, 1e-2),
        ("exp(-x**2)", 9.0, 0.2, 1e-15),
        ("1 - tanh(x)**2", 30.0, 0.5, 1e-10),
        ("sin(x)", 1.0, 0.2, 0.25),
    ],
)
def test_what_is_small_all_around_is_seen_to_be(text, centre, share, bound):
    found = compiled()((centre, 1.0), [[share * centre] * LANES, [0.0] * LANES])[text]
    assert found[1] <= bound


@pytest.mark.parametrize("text", ["1/x", "log(x)", "sqrt(x)", "x**-2.7", "x**y", "atan2(y, x)"])
def test_a_disk_with_a_singularity_has_no_bound(text):
    found = compiled()((1.0, 0.01), [[1.001] * LANES, [0.1] * LANES])[text]
    assert not found[1] < math.inf
