"""What a proof of families encloses: every disk holds the values at complex times, as mpmath finds them."""

from __future__ import annotations

import ctypes
import random
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from typing import Any

import mpmath
import numpy as np
import pytest

from lagrange_cli.expression.node import Kind, Node
from lagrange_cli.families import system as systems
from lagrange_cli.families.arrays import NONE, Array, Chain, Source, Total
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.system import any_family_system
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.method import Start
from lagrange_cli.integrate.prepare import prepare_system
from lagrange_cli.integrate.times import Times
from lagrange_cli.native.compilation.machine import FULL, compile_object, load
from lagrange_cli.native.families import proof
from lagrange_cli.native.families.double_double import DoubleDoubleVectors
from lagrange_cli.native.families.program import FamilyProgram
from lagrange_cli.native.families.vectors import DoubleVectors
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.vector import Real
from lagrange_cli.native.recurrences.evaluation import emit_values
from lagrange_cli.native.stepping.cancelling import Sums
from lagrange_cli.native.stepping.proof import RATIOS, WIDER
from lagrange_cli.run.derive import derive_system
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_values

MP = mpmath.mp.clone()
MP.prec = 150
ORDER, OUT, WIDTH = 18, 4096, 1 + 2 * LANES
"""The order of q's series; where the disks are written, behind the state; the doubles of one: its centre,
radii and lower bounds of sizes."""
BODIES = """
sizes: {{N: {count}}}
parameters:
  w: 0.4
  c[i in range(N)]: 1 + i/10
coordinates:
  x[i in range(N)]: {{initial: "i + sin(7*i)/4", velocity: "{drift} + cos(5*i)"}}
  y[i in range(N)]: {{initial: "sin(3*i)", velocity: "{drift} - sin(4*i)"}}
masses: {{"ball[i in range(N)]": 1 + i}}
embedding: {{"ball[i in range(N)]": ["x[i]", "y[i]"]}}
definitions:
  X: sum(x[j] for j in range(N))/N
  run[0]: x[0]
  run[i in range(1, N)]: run[i - 1] + y[i] - x[i]
potential: {potential}
"""
R2 = "((x[i] - x[j])**2 + (y[i] - y[j])**2)"
POTENTIALS = {
    "pairs": f"sum(exp(-sqrt({R2} + 0.3)/w) for i in range(N) for j in range(i))",
    "neighbours": "sum(1/(1 + ((x[i + 1] - x[i])**2 + y[i]*y[i + 1])**2) for i in range(N - 1))",
    "members": "sum(tanh((x[i]*y[i] - x[i])/w) + 1/(2 + x[i]**2 + sin(t)*y[i]) for i in range(N))",
    "weights": "sum(exp(-((c[i]*x[i] - c[j]*x[j])/w)**2) for i in range(N) for j in range(i))",
    "a mean": "sum(exp(-((x[i] - X)/w)**2) + sqrt((x[i] - X)**2 + y[i]**2 + 0.2) for i in range(N))",
    "a density": f"sum(sqrt(sum(exp(-{R2}) for j in range(N) if j != i)) for i in range(N))",
    "a whole": "1/(1 + sum((x[i] - X)**2 + x[i]*y[i] for i in range(N))**2)",
    "a chain": "sum(exp(-(run[i]/w)**2) + 1/(1 + run[i]**2 + x[i]*y[i]) for i in range(N))",
}
FUNCTIONS = {name: getattr(MP, name) for name in ("exp", "sin", "cos", "tanh", "sqrt", "log", "cosh", "sinh")}


class Looked:
    """The nodes of each member of a loop, with their places, in a program and its proof."""

    def __init__(self) -> None:
        self.loops: list[tuple[Sequence[Node], Sequence[Node], int, int]] = []
        self.end, self.lengths, self.low = OUT, None, 0

    def disks(self, state: Any) -> Iterator[tuple[Any, Sequence[Node], Sequence[Node]]]:
        """The disks that a run has written in each loop, an array of members and nodes; all nodes, and those
        that are enclosed closely."""
        for nodes, closely, first, members in self.loops:
            size = members * len(nodes) * WIDTH
            yield state[first : first + size].reshape(members, len(nodes), WIDTH), nodes, closely


@cache
def compiled(kind: str, count: int, vectors: type) -> tuple[Any, FamilySystem, Looked, Any]:
    """A program whose ``@proven`` writes all disks behind the state."""
    looked = Looked()

    class Written(Sums):
        """Sums whose disks are written, and those of all that they are in."""

        def enclose(self) -> None:
            super().enclose()
            nodes = [node for node in self.order if node.symbols & self.series.variables]
            emit_values(self.disks, nodes, self.known, self.constants)
            nodes, f, member = [node for node in nodes if self.known.get(node)], self.f, self.series.member
            closely = [*self.combined, *self.own, *self.series.totals]
            members = self.series.count
            looked.loops.append((nodes, closely, looked.end, members))
            for i, node in enumerate(nodes):
                disk = self.known[node]
                place = member * (len(nodes) * WIDTH) + (looked.end + i * WIDTH)
                f.store(Real(f, self.disks.centres.written(disk.centre), 1), "%state", place)
                f.store_row(self.disks.radius(disk), "%state", place + 1)
                f.store_row(self.disks.positive(self.disks.least(disk)), "%state", place + (1 + LANES))
            looked.end += members * len(nodes) * WIDTH

    class Members(proof.MemberSeries):
        """The series of members, which know how many there are."""

        def __init__(self, arrays: Any, used: Any, *given: Any) -> None:
            super().__init__(arrays, used, *given)
            looked.lengths, looked.low = arrays.lengths, arrays.low
            (self.count,) = {slot.domain.count for slot in used.values()}

    system = any_family_system(
        read_spec(BODIES.format(count=count, drift=0, potential=POTENTIALS[kind]), "bodies.yaml")
    )
    assert system is not None
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(proof, "Sums", Written)
        patch.setattr(proof, "MemberSeries", Members)
        patch.setattr(proof, "HEAD", proof.HEAD.replace("internal ", ""))
        program = FamilyProgram(system, {}, 2.0**-52, ORDER, kind=vectors, proven=True).written()
    return program, system, looked, load(compile_object(program, FULL))


class Truth:
    """The values of arrays and of expressions at the complex time ``s`` after the start."""

    def __init__(
        self, system: FamilySystem, given: Mapping[str, float], t: float, s: Any, state: Sequence[Any]
    ) -> None:
        self.system, self.t, self.s = system, t, s
        self.names, self.numbers = [*given], [*given.values()]
        self.state, self.found = state, dict[Any, Any]()

    def value(self, array: Array, i: int) -> Any:
        """A number of an array."""
        if (array, i) not in self.found:
            self.found[array, i] = self._value(array, i)
        return self.found[array, i]

    def _value(self, array: Array, i: int) -> Any:
        if array in (self.system.q, self.system.v):
            return self.state[i + (0 if array is self.system.q else self.system.q.count)]
        if array is self.system.given:
            return self.numbers[i]
        if array.source is Source.WHOLE:
            return i
        assert isinstance(array, Total)
        total = MP.mpf(0)
        for term in array.terms:
            for member in np.flatnonzero(term.targets == i).tolist():
                total += self.at(term.node, member)
        if isinstance(array, Chain):
            parents = array.tree.parents
            others = np.flatnonzero(parents == i).tolist() if array.back else [int(parents[i])]
            total += sum(self.value(array, one) for one in others if one != NONE)
        return total

    def at(self, node: Node, member: int) -> Any:
        """An expression of a member."""
        if (node, member) not in self.found:
            self.found[node, member] = self._at(node, member)
        return self.found[node, member]

    def _at(self, node: Node, member: int) -> Any:
        if node.kind is Kind.NUMBER:
            return MP.mpf(node.data)
        if node is self.system.time:
            return self.t + self.s
        slots = self.system.slots.of
        if node in slots:
            return self.value(slots[node].array, int(slots[node].table[member]))
        if node.kind is Kind.SYMBOL:
            (name,) = (name for name, symbol in self.system.parameters.items() if symbol is node)
            return self.numbers[self.names.index(name)]
        arguments = [self.at(one, member) for one in node.arguments]
        if node.kind is Kind.SUM:
            constant, scales = node.data
            return constant + sum(scale * one for one, scale in zip(arguments, scales))
        if node.kind is Kind.PRODUCT:
            return MP.fprod(one ** MP.mpf(e) for one, e in zip(arguments, node.data))
        assert node.kind in (Kind.FUNCTION, Kind.POWER)
        return arguments[0] ** arguments[1] if node.kind is Kind.POWER else FUNCTIONS[node.data](*arguments)


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("vectors", [DoubleVectors, DoubleDoubleVectors], ids=["doubles", "double-double"])
@pytest.mark.parametrize("form", ["entire", "geometric", "late"])
@pytest.mark.parametrize("count", [3, 10])
@pytest.mark.parametrize("kind", POTENTIALS)
def test_values_lie_in_their_disks(kind: str, count: int, form: str, vectors: type) -> None:
    """Bodies fly side by side, and differ by a part of their motion. Combinations, sums with series of their
    own and totals are enclosed closely where coefficients decrease."""
    chance, (program, system, looked, code) = random.Random(), compiled(kind, count, vectors)
    lengths, degrees = looked.lengths, system.q.count
    unit = 1.0 if lengths.followers else 2.0 ** chance.randint(-3, 3)
    t, h = chance.uniform(-1, 1), unit * chance.uniform(0.03 if form == "late" else 0.005, 0.06)
    near = chance.choice([1.0, 1e-3, 1e-9])

    def drawn(m: int) -> float:
        """A coefficient: they decrease like those of exp, or not at all, or all but the first and the last
        ones are 0."""
        if form == "late" and 0 < m < ORDER - 1:
            return 0.0
        return chance.uniform(-1, 1) / float(mpmath.factorial(m) if form == "entire" else 1)

    common, *own = ([drawn(m) for m in range(ORDER + 1)] for _ in range(degrees + 1))
    q = np.array([[c + near * d for c, d in zip(common, one)] for one in own])
    v = np.zeros_like(q)
    v[:, :-1] = q[:, 1:] * np.arange(1, ORDER + 1) / unit
    if lengths.followers:  # coordinates are what follows from the velocities, as they are rounded
        q[:, 1:] = 0.0
    rows = np.concatenate([q, v])
    work = np.zeros(program.work + 64)
    for m in range(ORDER + 1):
        first = m * lengths.term + lengths.first
        begin = degrees if lengths.followers else 0
        work[first + begin : first + 2 * degrees] = rows[begin:, m]
    state = np.zeros(looked.end + 64)
    state[: 2 * degrees] = rows[:, 0]
    low = 1e-17 * np.array([chance.uniform(-1, 1) for _ in range(2 * degrees)])
    state[looked.low : looked.low + 2 * degrees] = low
    given = resolve_values(system.spec).parameters
    numbers = [float(given[name]) for name in program.parameters]
    assert run(code, program, numbers, t, state, work, h, unit) >= 0.0
    assert looked.loops
    exact = [[MP.mpf(float(c)) for c in row] for row in rows]
    if lengths.followers:
        for place, speed in zip(exact, exact[degrees:]):
            place[1:] = [c / m for m, c in enumerate(speed[:-1], 1)]
    given = dict(zip(program.parameters, numbers))
    for ratio in range(0, LANES, 3):
        most = dict[tuple[int, int, Node], float]()
        for turn in range(0, 7, 2):
            s = MP.expjpi(MP.mpf(turn) / 6) * h * RATIOS[ratio]
            values = [MP.polyval(list(row[::-1]), s / unit) + MP.mpf(float(x)) for row, x in zip(exact, low)]
            truth = Truth(system, given, t, s, values)
            for i, (disks, nodes, closely) in enumerate(looked.disks(state)):
                for member, found in enumerate(disks):
                    for node, (centre, *radii) in zip(nodes, found):
                        if not np.isfinite(radii[ratio]):
                            assert node not in closely
                            continue
                        apart = abs(truth.at(node, member) - MP.mpf(float(centre)))
                        assert abs(truth.at(node, member)) * WIDER >= radii[LANES + ratio], str(node)
                        assert apart <= radii[ratio] * WIDER, (str(node), member, ratio, near)
                        most[i, member, node] = max(most.get((i, member, node), 0.0), float(apart))
        for i, (disks, nodes, closely) in enumerate(looked.disks(state)):
            for member, found in enumerate(disks):
                for node in closely if form == "entire" else ():
                    assert found[nodes.index(node), 1 + ratio] <= 6 * most[i, member, node] + 1e-12


def run(code: Any, program: Any, numbers: Sequence[float], *given: Any) -> float:
    """Compute what lasts, and look at a step."""
    t, state, work, h, unit = given
    parts = 2 if program.parts > 1 else 1
    parameters, constants = np.zeros(parts * len(numbers) + 16), aligned(program.constants + 64)
    parameters[: len(numbers)] = numbers
    pointer, real = ctypes.c_void_p, ctypes.c_double
    ctypes.CFUNCTYPE(None, pointer, pointer)(code.address("prepare"))(
        parameters.ctypes.data, constants.ctypes.data
    )
    proven = ctypes.CFUNCTYPE(real, pointer, real, pointer, pointer, real, real, real)(code.address("proven"))
    own = aligned(len(work))
    own[:] = work
    return proven(constants.ctypes.data, t, state.ctypes.data, own.ctypes.data, h, unit, float(ORDER - 1))


def aligned(size: int) -> Any:
    """Zeros, as vectors need them."""
    made = np.zeros(size + LANES)
    skipped = -(made.ctypes.data // 8) % LANES
    return made[skipped : skipped + size]


def steps(text: str, fewest: int) -> int:
    """The proven steps of a motion whose members are followed in loops from so many terms on."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(systems, "FEWEST", fewest)
        spec = read_spec(text, "bodies.yaml")
        asked = Compilation("taylor", 2.0**-52, frozenset(), proven=True)
        ready = prepare_system(spec, derive_system, None, asked)
    assert ready.machine.program.loops == (fewest == 0)
    start = Start.of(ready.machine.program, resolve_values(spec), Times(0.0, 3.0, 2, 3.0))
    return ready.follower.follow(start).steps


@pytest.mark.exhaustive(keep=0.4)
@pytest.mark.parametrize("drift", [0, 100])
@pytest.mark.parametrize("kind", POTENTIALS)
def test_loops_take_the_steps_that_members_take_one_by_one(kind: str, drift: int) -> None:
    text = BODIES.format(count=5, drift=drift, potential=POTENTIALS[kind])
    loops, alone = steps(text, 0), steps(text, 10**9)
    assert loops <= 1.1 * alone + 2, (loops, alone)
