"""Scales of unknowns that are 0 but for rounding, as others cancel in them."""

from __future__ import annotations

import random

import mpmath
import pytest

from lagrange_cli.integrate.single_state import compiled_values
from lagrange_cli.symbolic.measured import Measured
from lagrange_cli.symbolic.norms import by_norms
from lagrange_cli.symbolic.printed import evaluate, read_back
from lagrange_cli.symbolic.states import State
from lagrange_cli.symbolic.verify import verify
from tests.support.motion import residual_of
from tests.support.systems import derived

WATT = """
name: Watt linkage
parameters: {{a: 1, b: 0.5, g: 9.81, m: 1}}
coordinates: {{t1: {{initial: 0.3}}, t2: {{initial: -0.17489199706934308}}, t3: {{initial: -0.3}}}}
masses: {{p: m, q: m}}
positions: {{p: [a*cos(t1), a*sin(t1)], q: [2*a - a*cos(t3), b - a*sin(t3)]}}
potential: m*g*(p.y + q.y)
constraints:
  x: {scale}*(a*cos(t1) - b*sin(t2) - 2*a + a*cos(t3))
  y: {scale}*(a*sin(t1) + b*cos(t2) - b + a*sin(t3))
"""
PARAMETERS = {"a": 1.0, "b": 0.5, "g": 9.81, "m": 1.0}
PLACE = {"t1": -4.295863128415678e-4, "t2": -3.690887948083751e-7, "t3": 4.295863128756511e-4}
SPEED = {"t1_dot": -2.3940991658205126, "t2_dot": -0.00411388880717086, "t3_dot": 2.3940991665797076}
"""Where the middle link is vertical. It has no mass, so that the force on it is, too."""


def measured(*numbers: float) -> list[Measured]:
    return [Measured(mpmath.mpf(x), abs(mpmath.mpf(x))) for x in numbers]


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("scale", [1, 1000])
def test_a_multiplier_that_cancels_is_measured_by_all_forces(scale):
    equations = derived(WATT.format(scale=scale))
    known = {**PARAMETERS, **PLACE, **SPEED, "t": 0.0}
    with mpmath.workdps(30):
        values = dict(zip(known, measured(*known.values()), strict=True))
        found = dict(evaluate(equations, read_back(equations), values).multipliers)
    (across,) = (one for name, one in found.items() if name.endswith("_x"))
    assert abs(across.value) * scale < 1e-11
    assert 1 < across.scale * scale < 100


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.parametrize("error", [0.0, 1e-9])
def test_a_linkage_with_a_link_without_mass(error):
    """At that place the equations agree, and a mistake as small as 1e-9 of the weights is seen there."""
    text = WATT.format(scale=1)
    compiled = compiled_values(residual_of(text))

    def spoiled(*state):
        a, p, h, multipliers, constraints = compiled(*state)
        return a, p, h, [one + error * 9.81 for one in multipliers], constraints

    there = State(PARAMETERS, 0.0, tuple(PLACE.values()), tuple(SPEED.values()), "there")
    found = verify(derived(text), spoiled, there, [there], admissible=lambda state: there)
    assert found.agrees == (not error), str(found)


def test_norms_bound_the_solutions_of_random_systems(source):
    """With masses that are regular or not, whatever the forces: of each component, and for other units."""
    for _ in range(20):
        n = source.randint(2, 5)
        count = source.randint(1, n - 1)
        half = [[source.gauss(0, 1) for _ in range(n)] for _ in range(source.choice([n, n - count]))]
        slopes = [[source.gauss(0, 1) for _ in range(n)] for _ in range(count)]
        with mpmath.workdps(30):
            root, a = mpmath.matrix(half), mpmath.matrix(slopes)
            m = root.T * root
            f, b = ([source.gauss(0, 1) for _ in range(size)] for size in (n, count))
            whole = mpmath.zeros(n + count)
            whole[:n, :n], whole[:n, n:], whole[n:, :n] = m, -a.T, a
            exact = mpmath.lu_solve(whole, mpmath.matrix([*f, *b]))
            rows = [measured(*a[i, :]) for i in range(count)]
            masses = [measured(*m[i, :]) for i in range(n)]
            plain = [Measured(x, abs(x)) for x in exact]
            none = [Measured(x, mpmath.mpf(0)) for x in exact]
            sizes = by_norms(masses, measured(*f), rows, rows, measured(*(-x for x in b)), none)
            assert all(one.scale >= own.scale * (1 - 1e-9) for one, own in zip(sizes, plain, strict=True))
            wide = [measured(*(7 * x for x in a[i, :])) for i in range(count)]
            less = [Measured(x.value / (7 if i >= n else 1), x.scale) for i, x in enumerate(none)]
            other = by_norms(masses, measured(*f), wide, wide, measured(*(-7 * x for x in b)), less)
            for i, (one, two) in enumerate(zip(sizes, other, strict=True)):
                assert float(two.scale * (7 if i >= n else 1)) == pytest.approx(float(one.scale), rel=1e-9)


@pytest.fixture
def source(request) -> random.Random:
    return random.Random(request.config.option.seed)
