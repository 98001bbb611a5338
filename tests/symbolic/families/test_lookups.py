"""Equations with indices that are looked up are printed with them."""

from __future__ import annotations

import random
from typing import Any

import numpy as np
import pytest

from lagrange_cli.symbolic.families.as_sympy import as_sympy
from lagrange_cli.symbolic.families.data import as_data
from lagrange_cli.symbolic.families.source import as_python
from tests.spec.test_lookups import network, pairs
from tests.symbolic.families.test_equations import holds, printed

pytestmark = pytest.mark.usefixtures("however_small")


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("way", ["lists", "a table", "definitions"])
@pytest.mark.parametrize("count", [2, 3, 30])
def test_what_is_printed_is_integrated(count: int, way: str, pytestconfig: pytest.Config) -> None:
    """Read back, and as a module of Python beside forces that are computed here."""
    chance = random.Random(f"{pytestconfig.getoption('seed')} {count} {way}")
    ends = pairs(chance, count)
    derived = printed(network(ends, count, way))
    holds(derived)
    module: dict[str, Any] = {}
    exec(as_python(derived.equations, {"k": 2.0}), module)
    q, v = (np.array([chance.uniform(-1.0, 1.0) for _ in range(2 * count)]) for _ in range(2))
    found = module["accelerations"](0.0, [*q], [*v])
    places, force = q.reshape(2, count), np.zeros((2, count))
    for a, b in ends:
        apart = places[:, a] - places[:, b]
        length = np.linalg.norm(apart)
        pull = 2.0 * (length - (1.0 + a / 9.0)) * apart / length + [0.01 * (v[a] - v[b]), 0.0]
        force[:, a] -= pull
        force[:, b] += pull
    expected = force / (1.0 + np.arange(count) / 7.0)
    assert np.allclose(np.reshape(found, (2, count)), expected, rtol=0.0, atol=1e-12 * np.abs(expected).max())


@pytest.mark.exhaustive(keep=0.5)
def test_tables_are_apart_from_parameters() -> None:
    equations = printed(network([(1, 0), (2, 1)], 3, "lists")).equations
    data = as_data(equations, {"k": 2.0, "a[0]": 1.0, "a[1]": 2.0, "b[0]": 0.0, "b[1]": 1.0})
    assert data["tables"] == {"a": [1, 2], "b": [0, 1]} and data["parameters"] == {"k": 2.0}
    assert "x[a[" in str(data["equations"])


@pytest.mark.exhaustive(keep=0.5)
def test_sympy_has_indices_of_indices() -> None:
    equations = printed(network([(1, 0), (2, 1)], 3, "lists")).equations
    assert equations.U is not None
    text = str(as_sympy(equations.U, tuple(equations.sizes)))
    assert "x[a[n]]" in text and "x[b[n]]" in text


def test_equations_depend_on_the_numbers_of_their_own_system_alone() -> None:
    """Sympy remembers what it has computed: sums of systems read before have the same text."""
    x = [0.3, -0.7, 1.1, 0.2, -0.4]
    for kind in ([1, 1], [1, 2, 1, 2, 1], [2, 1, 1, 1, 2], [0, 1, 2, 3, 4], [1, 1, 1, 1, 1]):
        count = len(kind)
        derived = printed(f"""\
sizes: {{N: {count}}}
parameters: {{kind: {kind}}}
coordinates: {{x[i in range(N)]: {{initial: 0.1*i}}}}
masses: {{p[i in range(N)]: 1}}
embedding: {{p[i in range(N)]: [x[i]]}}
potential: >-
  sum(x[i]**2 for i in range(N)) + sum(x[i]*x[j] for i in range(N) for j in range(i) if kind[i] == kind[j])
""")
        module: dict[str, Any] = {}
        exec(as_python(derived.equations, {}), module)
        alike = [sum(x[j] for j in range(count) if j != i and kind[i] == kind[j]) for i in range(count)]
        expected = [-2.0 * x[i] - alike[i] for i in range(count)]
        assert np.allclose(module["accelerations"](0.0, x[:count], [0.0] * count), expected), kind
