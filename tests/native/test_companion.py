"""The constants of a companion's program: with larger rounding errors than those of the run."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from lagrange_cli.integrate.arrays import aligned
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.native.interface import CONSTANTS
from lagrange_cli.native.numbers.beside import beside
from lagrange_cli.run.derive import derive_system
from tests.support.motion import prepare, spec_of

SPRING = """
parameters: {m: 4.1, k: 4.2}
coordinates: {x: {initial: 1}}
lagrangian: m*x_dot**2/2 - k*x**2/2
"""


def constants(system: str, factor: int | None, parameters: list[float]) -> list[float]:
    """Those of its program for such parameters."""
    compilation = Compilation("taylor", 2.0**-52, frozenset({"q", "v"}), order=26, factor=factor)
    machine = prepare(derive_system(spec_of(system), exact=factor is not None), compilation).machine
    found = aligned(machine.program.constants)
    given = np.array(parameters)
    machine.prepare(given.ctypes.data, found.ctypes.data)
    return [float(x) for x in found]


@pytest.mark.parametrize("factor", [0, 8])
def test_what_is_computed_has_a_larger_rounding_error(factor):
    """m and k as they are written exceed their doubles by so much."""
    rest = [float(Fraction(text) - Fraction(float(text))) for text in ("4.1", "4.2")]
    given = [4.1, 4.2, *(factor / CONSTANTS * x for x in rest)]
    m, k = (Fraction(x) + Fraction(y) for x, y in zip(given[:2], given[2:]))
    exact = {float(x): x for x in (-k / m, k / m, 1 / m, -k, k, m, -m)}
    plain, beside_it = constants(SPRING, None, [4.1, 4.2]), constants(SPRING, factor, given)
    assert len(plain) == len(beside_it) and plain
    moved = 0
    for one, other in zip(plain, beside_it):
        value = min(exact.values(), key=lambda x: abs(x - Fraction(one)))
        wanted = Fraction(one) + CONSTANTS * (value - Fraction(one))
        assert abs(Fraction(other) - wanted) <= Fraction(np.spacing(abs(one)))
        moved += other != one
    assert moved


@pytest.mark.parametrize("factor", [0, 1, 8])
def test_numbers_are_beside_theirs(factor):
    tenth = Fraction(1, 10)
    assert beside(tenth, factor) - Fraction(0.1) == factor * (tenth - Fraction(0.1))
    assert beside(0.1, factor) == 0.1 and beside(Fraction(3, 8), factor) == Fraction(3, 8)
