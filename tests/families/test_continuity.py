"""What must not jump in families: their templates, beside their members one by one."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lagrange_cli.errors import InfiniteForce, SpecError
from lagrange_cli.families.continuity import continuous
from lagrange_cli.mechanics.switching.jumps import refuse_jumps, refuse_jumps_in_numbers
from lagrange_cli.run.jumps import check_energies, known, symbolic
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.spec import Spec
from lagrange_cli.spec.values import resolve_values
from tests.support.draws import examples

PLANE = """
sizes: {{N: 12}}
parameters: {{a: 1, k: 2, c: 2, "d[i in range(N)]": 0.2 + i/3, "e[i in range(N)]": 0.4 + 2*i/3}}
coordinates:
  x[i in range(N)]: {{initial: 0.3 + i}}
  y[i in range(N)]: {{initial: 0.2}}
masses: {{"b[i in range(N)]": 1}}
embedding: {{"b[i in range(N)]": [{x}, "y[i]"]}}
potential: sum(x[i]**2 for i in range(N)) + {potential}
"""
ALONE = [
    "where(x[i] > a, k*(x[i] - a)**2, 0)", "max(0, x[i] - a)*y_dot[i]", "abs(y[i])", "where(x[i] > a, k, 0)",
    "where(x[i] > 1, k*x[i], c)", "where(x[i] > d[i], k*x[i], e[i])", "where(x[i] > d[i], x[i], e[i])",
    "where(x[i] > a, k*x[i], 3)", "sign(x[i])*x[i]", "where(x[i] > 0 and y[i] > 0, x[i]*y[i], 0)",
    "where(t > 1, x[i], 0)", "where(t > 1, x[i], 0)*y_dot[i]", "where(x[i]**2 + y[i]**2 < c, 0, a - k/2)",
    "where(x[i] > i, x[i], i)", "where(x[i] > i, x[i], 0)", "where(x[i] > a, (k - c)*y[i], 0)",
]  # fmt: skip
PAIRS = [
    "max(0, a - abs(x[i] - x[j]))**2", "where(x[i] > x[j], a, 0)", "1/abs(x[i] - x[j])",
    "where(x[i] - x[j] < d[i], x[i] - x[j], d[i])", "where(x[i] - x[j] < a, d[i], d[j])",
    "where(norm(b[i] - b[j]) < a, (norm(b[i] - b[j]) - a)**3, 0)", "sign(x[i] - x[j])*y_dot[i]",
]  # fmt: skip


def jumps(spec: Spec) -> bool:
    """Whether something jumps, member by member."""
    try:
        refuse_jumps(symbolic(spec))
        refuse_jumps_in_numbers(known(spec, parameters(spec)))
    except InfiniteForce:
        return True
    return False


def parameters(spec: Spec) -> dict[str, float]:
    return {**resolve_values(spec, {}).parameters}


@pytest.mark.exhaustive(keep=0.15)
@examples(12)
@given(
    st.lists(st.sampled_from(ALONE), max_size=2),
    st.lists(st.sampled_from(PAIRS), max_size=1),
    st.sampled_from(
        ["x[i]", "x[i] + max(0, y[i])", "abs(x[i])", "x[i] + max(0, y[i])**2", "x[i]*where(t < 1, 1, 2)"]
    ),
    st.booleans(),
)
def test_the_verdict_is_that_of_the_members(alone: list[str], pairs: list[str], x: str, outer: bool) -> None:
    sums = [f"sum({one} for i in range(N))" for one in alone]
    sums += [f"sum({one} for i in range(N) for j in range(i))" for one in pairs]
    if outer:
        sums = [f"max(0, {' + '.join(sums) or 0} - a)"]
    spec = read_spec(PLANE.format(potential=" + ".join(sums) or "0", x=x), "plane.yaml")
    found = jumps(spec)
    assert not (continuous(spec) and found)
    assert not (continuous(spec, parameters(spec)) and found)
    if found:
        with pytest.raises(SpecError):
            check_energies(spec, parameters(spec))
    else:
        check_energies(spec, parameters(spec))


@pytest.mark.parametrize("k", [*range(3), *range(4, 6), 8, 9, 10, 13])
def test_members_that_do_not_jump_are_not_looked_at(k: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """The same templates serve any number of members."""
    monkeypatch.setattr("lagrange_cli.run.jumps.symbolic", None)
    text = PLANE.format(potential=f"sum({ALONE[k]} for i in range(N))", x="x[i]")
    spec = read_spec(text, "plane.yaml", {"N": "300"})
    check_energies(spec, parameters(spec))
