"""Neighbours as pairs that satisfy a condition move as those of sums over neighbours."""

from __future__ import annotations

import pytest

from lagrange_cli.families.system import any_family_system
from tests.support.families import alike, begun, followed

CHAIN = """
sizes: {{N: 3000}}
parameters: {{D: 2.0, a: 0.5, L: 1.1}}
coordinates: {{"x[i in range(N)]": {{initial: i + sin(7*i)/9, velocity: cos(3*i)/5}}}}
masses: {{"bead[i in range(N)]": 1 + i % 2}}
embedding: {{"bead[i in range(N)]": ["x[i]"]}}
{more}
potential: "{potential}"
"""
BOND = "D*(1 - exp(-a*(x[{}] - x[{}] - L)))**2"
NEXT = f"sum({BOND.format('i + 1', 'i')} for i in range(N - 1))"
PAIRS = "for i in range(N) for j in range(N) if"
OUTPUTS = frozenset({"q", "v", "h"})


@pytest.mark.exhaustive(keep=0.45)
@pytest.mark.parametrize(
    ("potential", "more"),
    [
        (f"sum({BOND.format('i', 'j')} {PAIRS} i == j + 1)", ""),
        (f"sum({BOND.format('max(i, j)', 'min(i, j)')} {PAIRS} abs(i - j) == 1)/2", ""),
        (
            "sum(D*(1 - exp(-a*(d[i, j] - L)))**2 for j in range(N - 1) for i in range(N) if i - j == 1)",
            'definitions: {"d[i in range(N), j in range(N) if 0 < abs(i - j) <= 2]": "x[i] - x[j]"}',
        ),
    ],
)
def test_pairs_of_neighbours_move_as_a_chain(potential: str, more: str) -> None:
    _, found = followed(CHAIN.format(potential=potential, more=more), OUTPUTS, stop=0.2, samples=3)
    _, expected = followed(CHAIN.format(potential=NEXT, more=""), OUTPUTS, stop=0.2, samples=3)
    alike(found.data, expected.data, 1e-13)
    assert any_family_system(begun(CHAIN.format(potential=potential, more=more))[0]) is not None
