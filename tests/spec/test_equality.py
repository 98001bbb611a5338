"""Equality of numbers that rounding may decide."""

from __future__ import annotations

import pytest

from lagrange_cli.spec.equality import doubtful_equalities
from lagrange_cli.spec.read import read_spec

SYSTEM = """\
parameters: {{k: 0.1 + 0.2, n: 1, two: n + 1, m: [1, 2], r: [1, 0.5], s: 3}}
sizes: {{N: 2}}
coordinates: {{x[i in range(N)]: {{initial: 1}}}}
masses: {{p[i in range(N)]: 1}}
positions: {{p[i in range(N)]: x[i]}}
potential: sum(x[i]**2 for i in range(N) if i != 5)
observables:
  o[i in range(N)]: {value}
events:
  e: {{when: x[0], action: {{set: {{s: s/2}}}}}}
"""


@pytest.mark.parametrize(
    ("value", "doubtful"),
    [
        ("where(k == 0.3, 1, 2)", ["'k == 0.3'"]),
        ("where(k != 1, x[i], 2)", ["'k != 1'"]),
        ("where(n == 1, 1, 2)", []),
        ("where(two - 1 == n, 1, 2)", []),
        ("where(n == 1/2, 1, 2)", ["'n == 1/2'"]),
        ("where(m[i] == 2*N or m[0] == i, 1, 2)", []),
        ("where(r[0] == 1, 1, 2)", ["'r[0] == 1'"]),
        ("sum(where(i == j or j == N - 1, x[j], 0) for j in range(N))", []),
        ("where(s == 3, 1, 2)", ["'s == 3'"]),
        ("where(k < 0.3, 1, 2)", []),
    ],
)
def test_numbers_that_are_not_whole_are_named_once(value, doubtful):
    spec = read_spec(SYSTEM.format(value=value), "file.yaml")
    found = list(doubtful_equalities(spec))
    assert [text for _, text in found] == doubtful
    assert all(place.line == 8 for place, _ in found)
