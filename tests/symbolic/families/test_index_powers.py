"""Equations with powers of indices, in places, conditions and ranges."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from lagrange_cli.symbolic.families.source import as_python
from tests.symbolic.families.test_equations import holds, printed

pytestmark = pytest.mark.usefixtures("however_small")


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize(
    "condition", ["2**i < 9", "i**2 != 4", "3**(N - 1 - i)//2 >= 1", "N**2 - i**2 > 7*i"]
)
def test_conditions_with_powers_hold_for_the_same_members_as_by_hand(condition: str) -> None:
    derived = printed(f"""\
sizes: {{N: 6}}
coordinates: {{x[i in range(N)]: {{initial: 0.1*i}}}}
masses: {{p[i in range(N)]: 1}}
embedding: {{p[i in range(N)]: [x[i]]}}
potential: sum(x[i]**4 + x[i]*x[i**2 % N] for i in range(N) if {condition})
""")
    holds(derived)
    module: dict[str, Any] = {}
    exec(as_python(derived.equations, {}), module)
    x, expected = [0.3, -0.7, 1.1, 0.2, -0.4, 0.9], np.zeros(6)
    for i in range(6):
        if eval(condition, {"i": i, "N": 6}):
            expected[i] -= 4.0 * x[i] ** 3 + x[i**2 % 6]
            expected[i**2 % 6] -= x[i]
    assert np.allclose(module["accelerations"](0.0, x, [0.0] * 6), expected, rtol=0.0, atol=1e-14)
