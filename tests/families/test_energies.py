"""The energy of a system of families at a state, beside that of its members."""

import math

import numpy as np
import pytest

from lagrange_cli.errors import SpecError
from lagrange_cli.families.energies import energy
from lagrange_cli.run.domains import check_domain
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_values

LOGARITHMIC = """
sizes: {{N: {count}}}
parameters: {{c: 0.5, "k[i in range(N)]": 1 + i/7}}
coordinates:
  x[i in range(N)]: {{initial: 3*sin(17*i)}}
  y[i in range(N)]: {{initial: 3*cos(29*i), velocity: 0.1*i}}
masses: {{"body[i in range(N)]": 1}}
embedding: {{"body[i in range(N)]": ["x[i]", "y[i]"]}}
definitions: {{"d[i in range(N), j in range(i)]": "(x[i] - x[j])**2 + (y[i] - y[j])**2"}}
potential: sum(sum(k[i]*log(d[i,j] + {soft}) for j in range(i)) for i in range(N)) + c*x[0]*t
"""


def logarithmic(count: int, soft: str = "c") -> str:
    return LOGARITHMIC.format(count=count, soft=soft)


@pytest.mark.parametrize("count", [1, 2, 9, 40])
def test_it_is_that_of_the_members(count: int) -> None:
    spec = read_spec(logarithmic(count), "system.yaml")
    values = resolve_values(spec, {})
    x, y = values.q[:count], values.q[count:]
    pairs = [(i, j) for i in range(count) for j in range(i)]
    total = [(1 + i / 7) * math.log((x[i] - x[j]) ** 2 + (y[i] - y[j]) ** 2 + 0.5) for i, j in pairs]
    found = energy(spec, values.parameters, np.array([*values.q, *values.v]), 2.0)
    assert found == pytest.approx(math.fsum(total) + x[0], rel=1e-13, abs=1e-13)


@pytest.mark.exhaustive(keep=0.15)
def test_a_large_system_without_a_value_is_refused_at_its_place_and_one_with_a_value_is_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """No member is written out: the graph of all pairs would have more nodes than this limit allows."""
    monkeypatch.setattr("lagrange_cli.expression.node_table.MAX_NODES", 2000)
    spec = read_spec(logarithmic(300), "system.yaml")
    check_domain(spec, resolve_values(spec, {}), 0.0)
    spec = read_spec(logarithmic(300, "-3"), "system.yaml")
    with pytest.raises(SpecError, match="has no value where the motion begins"):
        check_domain(spec, resolve_values(spec, {}), 0.0)
