"""Enclosures of sums whose terms cancel: against mpmath at complex times, and by the steps of motions."""

from __future__ import annotations

import ctypes
import random
from functools import cache

import mpmath
import numpy as np
import pytest

from benchmarks.motions.cancelling import BALL, GAS, TIPPE_TOP
from lagrange_cli.expression.build import build
from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.node import Node
from lagrange_cli.expression.parse import parse
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.method import Start
from lagrange_cli.integrate.prepare import prepare_system
from lagrange_cli.integrate.times import Times
from lagrange_cli.mechanics.cancellation import singular_sums
from lagrange_cli.native.compilation.llvm import compile_text
from lagrange_cli.native.compilation.machine import load
from lagrange_cli.native.functions.elementary import definitions
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Index, Integer, Real
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.native.recurrences.disk import Disks
from lagrange_cli.native.recurrences.disk_arithmetic import Disk
from lagrange_cli.native.recurrences.evaluation import Constants, emit_values
from lagrange_cli.native.stepping.cancelling import StateSeries, Sums, Tail
from lagrange_cli.native.stepping.lengths import Lengths
from lagrange_cli.native.stepping.proof import RATIOS, radii
from lagrange_cli.run.derive import derive_system
from lagrange_cli.spec.read import read_spec
from tests.support.motion import FULL, Motion, follow, values_of

MP = mpmath.mp.clone()
MP.prec = 120
ORDER = 20
COMBINED = ["x - y", "2*x - 3*y + x*y", "x_dot - y_dot + sin(t)"]
OWN = ["(x - y)**2 + sin(x)*cos(y) - cos(x)*sin(y)", "x_dot*cos(y) - y_dot*cos(x)"]
WORDS = {"sin": MP.sin, "cos": MP.cos}


class RowSeries(StateSeries):
    """Rows one after the other: x, y, their velocities, and integrals of sums."""

    def __init__(self, f: Function, time: Node, symbols: list[Node], sums: list[Node]) -> None:
        self.f, self.time, self.lengths = f, time, Lengths(2, 4 + len(sums), 8, ORDER, 1, 1, ORDER + 1, 1)
        self.variables = time.symbols
        for one in symbols:
            self.variables |= one.symbols
        rows: list[Index] = [0, 1, 2, 3]
        self.places, self.speeds = dict(zip(symbols[:2], rows)), dict(zip(symbols[2:], rows[2:]))
        self.sums = {node: i for i, node in enumerate(sums, 4)}
        self.rows = {**self.places, **self.speeds, **self.sums}

    def coefficient(self, node: Node, m: Integer) -> Real:
        m = m + 1 if node in self.sums else m
        found = self.f.load("%work", m + int(self.rows[node]) * (ORDER + 1))
        return found * m.to_real() / Real(self.f, "%unit") if node in self.sums else found

    def late(self, symbol: Node) -> Real:
        return self.f.load("%state", int(self.rows[symbol]) + 4)


@cache
def compiled():
    """A function of t, a state, series, h and a unit: centre and radii of each sum."""
    times = "double %h, double %unit, double %beyond"
    f = Function(f"define void @run(double %t, ptr %state, ptr %work, {times}, ptr %out) #0")
    emitter = Emitter(f)
    disks, algebra = Disks(f, emitter, LANES), GraphAlgebra()
    symbols = [algebra.symbol(name) for name in ("x", "y", "x_dot", "y_dot")]
    time = algebra.symbol("t")
    combined, own = (
        [build(parse(text), algebra.symbol, algebra) for text in part] for part in (COMBINED, OWN)
    )
    series = RowSeries(f, time, symbols, own)
    h = radii(f, Real(f, "%h"))
    known: dict[Node, Disk | None] = {time: Disk("%t", h)}
    for i, one in enumerate(symbols):
        known[one] = Disk(emitter.load("%state", i), f.load_row("%out", LANES * i, LANES))
    Sums(disks, [*combined, *own], series, known, Constants(), Tail(f)).enclose()
    emit_values(disks, [*combined, *own], known, Constants())
    for i, node in enumerate([*combined, *own]):
        made = known[node]
        f.store(Real(f, emitter.written(made.centre), 1), "%out", i * (LANES + 1))
        f.store_row(disks.radius(made), "%out", i * (LANES + 1) + 1)
    f.give()
    text = f.text()
    code = load(compile_text(text + definitions(text), 1))
    pointer, real = ctypes.c_void_p, ctypes.c_double
    return code, ctypes.CFUNCTYPE(None, real, pointer, pointer, real, real, real, pointer)(
        code.address("run")
    )


@pytest.mark.exhaustive(keep=0.3)
@pytest.mark.parametrize("near", [1.0, 1e-3, 1e-7, 1e-13])
@pytest.mark.parametrize("kind", ["entire", "geometric", "late"])
def test_sums_lie_in_their_disks_which_are_not_much_larger(near: float, kind: str) -> None:
    """Series of two bodies that fly side by side, and differ by a part ``near`` of their motion. Their
    coefficients decrease like those of exp, or not at all; or all but the first and the last ones are 0."""
    chance, (_, run) = random.Random(), compiled()
    t, unit = chance.uniform(-1, 1), 2.0 ** chance.randint(-3, 3)
    h = unit * chance.uniform(0.01, 0.06)

    def drawn(m: int) -> float:
        if kind == "late" and 0 < m < ORDER - 1:
            return 0.0
        return chance.uniform(-1, 1) / (mpmath.factorial(m) if kind == "entire" else 1)

    common = [drawn(m) for m in range(ORDER + 1)]
    x, y = ([float(c + near * drawn(m)) for m, c in enumerate(common)] for _ in range(2))
    v = [[(m + 1) * c / unit for m, c in enumerate(one[1:])] + [0.0] for one in (x, y)]
    rows = np.array([x, y, *v])
    late = [1e-9 * near * chance.uniform(-1, 1) for _ in rows]

    def at(text: str, s: object) -> object:
        """A sum at the complex time t + s, on the polynomials and low parts."""
        values = (MP.polyval(list(row[::-1]), s / unit) + low for row, low in zip(rows, late))
        return eval(text, WORDS, {**dict(zip(("x", "y", "x_dot", "y_dot"), values)), "t": t + s})

    for text in OWN:
        c = MP.taylor(lambda s, text=text: at(text, s * unit), 0, ORDER - 1)
        rows = np.vstack([rows, [0.0, *(float(one) * unit / m for m, one in enumerate(c, 1))]])
    state = np.array([*rows[:4, 0], *late])
    out = np.zeros(len(COMBINED + OWN) * (LANES + 1))
    scaled = h / unit * np.array(RATIOS)
    extents = [sum(abs(c) * scaled**m for m, c in enumerate(row) if m) for row in rows[:4]]
    out[: 4 * LANES] = np.concatenate([one + abs(low) for one, low in zip(extents, late)])
    work = np.ascontiguousarray(rows)
    run(t, state.ctypes.data, work.ctypes.data, h, unit, float(ORDER - 1), out.ctypes.data)
    for text, (centre, *found) in zip(COMBINED + OWN, out.reshape(-1, LANES + 1)):
        for ratio, radius in zip(RATIOS, found):
            turns = [MP.expjpi(MP.mpf(k) / 6) * h * ratio for k in range(12)]
            apart = [abs(at(text, s) - centre) for s in turns]
            assert max(apart) <= radius, (text, ratio)
            if kind == "entire" and text != COMBINED[1]:  # its product is enclosed by its factors
                assert radius <= 4 * max(apart) + 1e-9, (text, ratio)


def steps(text: str, *, unproven: bool = False, stop: float = 2.0) -> int:
    """The steps of its motion by Taylor series."""
    compilation = Compilation("taylor", FULL, frozenset(), unproven=unproven)
    ready = prepare_system(read_spec(text, "system.yaml"), derive_system, None, compilation)
    start = Start.of(ready.machine.program, values_of(text), Times(0.0, stop, 2, stop))
    return ready.follower.follow(start).steps


@pytest.mark.parametrize("count", [3, 40])
def test_what_flies_fast_side_by_side_takes_the_steps_that_it_takes_at_rest(count: int) -> None:
    """Galilei's transformation changes no step, of members written out and in families."""
    rest, fast = (steps(GAS.format(count=count, drift=drift)) for drift in (0, 100))
    assert fast <= 1.2 * rest + 2


RELATIVE = """
parameters: {{V: {drift}}}
coordinates:
  x: {{initial: -1, velocity: V + 0.5}}
  y: {{initial: 0, velocity: V - 0.5}}
lagrangian: x_dot**2 + y_dot**2 - 3/10*exp(-((x - y)/1e-3)**2)
"""


@pytest.mark.parametrize("drift", [0, 100])
def test_a_narrow_force_between_two_is_seen_however_fast_they_fly(drift: int) -> None:
    """u = x - y: u'^2 = 1 - 2 U. Where the potential is passed u is behind by as much time as that costs."""
    motion: Motion = follow(RELATIVE.format(drift=drift), 2.0, 3)
    cost = mpmath.quad(
        lambda u: 1e-3 * (1 / mpmath.sqrt(1 - 0.6 * mpmath.exp(-(u**2))) - 1), np.linspace(-9, 9, 19)
    )
    assert motion["q/x"][-1] - motion["q/y"][-1] == pytest.approx(
        1 - float(cost), abs=1e-15 * (20 + 40 * drift)
    )


@pytest.mark.parametrize("text", [TIPPE_TOP, BALL], ids=["tippe top", "ball"])
def test_friction_by_a_slip_that_is_far_less_than_what_it_is_the_difference_of(text: str) -> None:
    """At the beginning they slip fast; then little, while they move on."""
    assert steps(text, stop=0.3) <= 4 * steps(text, unproven=True, stop=0.3)


RELATIVISTIC = """
coordinates: {x: {initial: 1}, y: {initial: 0, velocity: 0.4}}
lagrangian: -sqrt(1 - x_dot**2 - y_dot**2) + 0.3/sqrt(x**2 + y**2)
"""


def test_a_root_of_what_velocities_change() -> None:
    assert steps(RELATIVISTIC, stop=20.0) <= 2.5 * steps(RELATIVISTIC, unproven=True, stop=20.0)


def test_sums_that_have_series_of_their_own() -> None:
    algebra = GraphAlgebra()
    names = {name: algebra.symbol(name) for name in ("x", "y", "c", "force")}
    variables = names["x"].symbols | names["y"].symbols

    def found(text: str) -> int:
        node = build(parse(text), algebra.symbol, algebra)
        return len(singular_sums([node], variables, names["force"].symbols))

    assert found("1/(x**2 + y**2)") == found("tanh(c*(x*y - y))") == found("(x*y + x)**c") == 1
    assert found("sqrt(x**2 + c) + 1/sin(x)") == 0  # a single term moves
    assert found("sqrt(2 - c*(x**2 + y**2)**2)") == found("acos(1 - c*x*y)") == 1  # what moves in it
    assert found("exp(x - c*y)") == 0  # a combination needs none
    assert found("sin(x*y + x) + (x*y + x)**3") == 0  # nothing is singular
    assert found("1/(x*force + y**2)") == 0
