"""A kind of numbers in one file: intervals, whose Taylor coefficients enclose those of compiled code."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
import pytest
from mpmath.ctx_iv import MPIntervalContext

from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.native.linear.blocks import Factorization
from lagrange_cli.native.numbers.kind import Number, NumberKind
from lagrange_cli.native.recurrences.evaluation import Constants, emit_values
from lagrange_cli.native.recurrences.expansion import Expansion
from lagrange_cli.native.recurrences.unrolled import Unrolled
from lagrange_cli.series.lowering import lower
from tests.support.jets import coefficients
from tests.support.motion import residual_of, values_of

Interval: TypeAlias = Any
ORDER = 12
ROWS = {"definite": 9, "general": 9}

IV = MPIntervalContext()
IV.prec = 50
"""Three digits less than a double's: wide enough for sums in another order, too."""


class Intervals(NumberKind[Interval]):
    """mpmath's intervals as a kind of numbers that computes at once."""

    unit = 2.0**-50
    one = IV.mpf(1)

    def __init__(self, memory: dict[str, list[Any]]) -> None:
        self.memory = memory

    def number(self, value: Number) -> Interval | None:
        return None if value == 0 else IV.mpf(value)

    def function(self, name: str, *arguments: Interval | None) -> Interval:
        given = [IV.mpf(0) if a is None else a for a in arguments]
        return given[0] ** given[1] if name == "pow" else getattr(IV, name)(*given)

    def load(self, pointer: str, index: int | str, beyond: int | str = 0) -> Interval:
        return self.memory[pointer][int(index)]

    def store(self, value: Any, pointer: str, index: int | str, beyond: int | str = 0) -> None:
        self.memory[pointer][int(index)] = value

    def compare(self, relation: str, a: Interval | None, b: Interval | None) -> bool:
        first, second = (0 if x is None else x.mid for x in (a, b))
        return bool({"ogt": first > second, "olt": first < second, "one": first != second}[relation])

    def both(self, a: bool, b: bool) -> bool:
        return a and b

    def select(self, condition: bool, yes: Interval | None, no: Interval | None) -> Interval:
        return yes if condition else no


class Computed(Constants):
    """Constants of the motion, from the parameters at once."""

    def __init__(self, known: dict[Any, Interval | None]) -> None:
        super().__init__()
        self.known = known

    def value(self, kind: Any, node: Any) -> Interval | None:
        emit_values(kind, [node], self.known, None)
        return self.known[node]


def enclosures(residual: Residual, parameters: dict[str, float], state: list[float]) -> list[list[Interval]]:
    """Rows q and q_dot; column m holds coefficient m."""
    model = residual.model
    series = lower(residual.graph, residual.variables, model.q, model.v, model.time, residual.residual, [])
    kind = Intervals({"%state": [IV.mpf(x) for x in state]})
    constants = Computed({node: IV.mpf(parameters[name]) for name, node in model.parameters.items()})
    factorization: Any = Factorization(kind, 0, ROWS)
    expansion = Expansion(residual, series, kind, constants, factorization, IV.mpf(0), 0)
    for k in range(-2, ORDER - 1):
        Unrolled(expansion, k).write()
    assert expansion.regular
    rows = (*series.coordinates, *series.velocities)
    return [[expansion.table[i].get(m) or IV.mpf(0) for m in range(ORDER)] for i in rows]


def drawn(seed: int) -> str:
    """A system of two coordinates with forces of many kinds and masses that depend on the place."""
    source = np.random.default_rng(seed)
    pieces = [
        "sin(x + {a}*y)",
        "exp(-{a}*x)*cos(y)",
        "1/(x**2 + y**2 + {a})",
        "sqrt({a} + y**2)",
        "x*y**3",
        "t*x",
    ]
    chosen = source.choice(pieces, 3, replace=False)
    potential = " + ".join(piece.format(a=round(source.uniform(0.5, 2), 3)) for piece in chosen)
    return (
        f"coordinates: {{x: {{initial: 0.3, velocity: 0.2}}, y: {{initial: -0.4, velocity: 0.7}}}}\n"
        f"parameters: {{m: {source.uniform(0.5, 2):.3f}}}\n"
        f"lagrangian: m*x_dot**2 + (1 + cos(x)**2/3)*y_dot**2/2 + x_dot*y_dot/4 - ({potential})\n"
    )


SYSTEMS = {
    **{name: name for name in ("double_pendulum", "charged_particle", "spherical_pendulum", "figure_eight")},
    **{f"drawn {seed}": drawn(seed) for seed in range(2)},
}


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("name", SYSTEMS)
def test_coefficients_of_doubles_lie_in_their_enclosures(name: str) -> None:
    system = SYSTEMS[name]
    values, residual = values_of(system), residual_of(system)
    source = np.random.default_rng(1)
    q, v = ([x + 0.1 * source.uniform(-1, 1) for x in start] for start in (values.q, values.v))
    compiled = coefficients(system, q, v)
    for row, enclosed in zip(compiled, enclosures(residual, dict(values.parameters), [*q, *v])):
        for m, (number, interval) in enumerate(zip(row, enclosed)):
            assert number in interval, (name, m, number, interval)
            assert interval.delta <= 1e-7 * max(1.0, abs(interval).b), (name, m, interval)
