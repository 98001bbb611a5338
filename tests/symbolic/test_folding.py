"""Sums over members are printed with indices; written out again, they are what they were."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

from lagrange_cli.run.equations import as_written, derive
from lagrange_cli.symbolic.indexed.conditions import Loop, holds
from lagrange_cli.symbolic.indexed.folding import FEWEST, Folding
from lagrange_cli.symbolic.indexed.members import KNOWN, Summed
from lagrange_cli.symbolic.order import Order, Role
from tests.support.draws import examples
from tests.support.motion import spec_of

COUNT = 7
NAMES = [f"{name}[{i}]" for name in "xym" for i in range(COUNT)]
ROLES = {"x": Role.COORDINATE, "y": Role.COORDINATE, "m": Role.PARAMETER, "k": Role.PARAMETER}
ORDER = Order({sympy.Symbol(name): (ROLES[name[0]], k) for k, name in enumerate([*NAMES, "k"])})


def symbol(name: str, index: int) -> sympy.Symbol:
    return sympy.Symbol(f"{name}[{index}]")


def rounds(loops: Sequence[Loop], known: dict[str, int]) -> Iterator[dict[str, int]]:
    """The values of the indices of loops."""
    if not loops:
        yield known
        return
    for value in range(loops[0].start.value(known), loops[0].stop.value(known)):
        inner = {**known, loops[0].index: value}
        if all(holds(one, inner) for one in loops[0].conditions):
            yield from rounds(loops[1:], inner)


def written_out(expression: sympy.Expr) -> sympy.Expr:
    """An expression without sums."""

    def term(body: sympy.Expr, indices: dict[str, int]) -> sympy.Expr:
        new = {}
        for one in body.free_symbols:
            base, wholes = KNOWN.get(one.name, ("", ()))
            if base:
                new[one] = symbol(base, wholes[0].value(indices))
        return body.xreplace(new)

    sums = expression.atoms(Summed)
    return expression.xreplace(
        {one: sympy.Add(*(term(one.body, own) for own in rounds(one.loops, {}))) for one in sums}
    )


def over(body: str, start: int, stop: int, shift: int) -> sympy.Expr:
    """The sum of a term over a range, shifted ones at the ring's other end."""
    k, total = sympy.Symbol("k"), sympy.S.Zero
    for i in range(start, stop):
        names = {name: symbol(name, i) for name in "xym"}
        names |= {f"{name}s": symbol(name, (i + shift) % COUNT) for name in "xym"}
        total += sympy.sympify(body, {**names, "k": k})
    return total


BODIES = ["k*x*ys/3", "m*x", "(x - xs)**2", "sin(x)*y", "-m*xs*y", "x**2/2", "m*ms*xs"]
RUNS = st.lists(
    st.builds(over, st.sampled_from(BODIES), st.integers(0, 3), st.integers(3, COUNT), st.integers(0, 6)),
    min_size=1,
    max_size=4,
)


@pytest.mark.exhaustive(keep=0.25)
@given(RUNS, st.booleans())
@examples(60)
def test_folded_sums_are_what_they_were(parts: list[sympy.Expr], product: bool) -> None:
    expression = sympy.Add(*parts)
    if product:  # of sums over all members, as in the angular momentum about the centre of mass
        expression += over("x", 0, COUNT, 0) * over("m*y", 0, COUNT, 0) / 5
    found = Folding(ORDER).folded(expression)
    assert sympy.expand(written_out(found) - expression) == 0
    assert not product or found.atoms(Summed)


def test_short_sums_stay_as_they_are() -> None:
    few = over("m*x", 0, FEWEST - 1, 0) + symbol("y", 0)
    assert Folding(ORDER).folded(few) == few
    assert Folding(ORDER).folded(over("m*x", 0, FEWEST, 0)).atoms(Summed)


BEADS = """
sizes: {N: 6}
parameters: {m: 1, g: 9.81, k: 2}
coordinates: {"x[i in range(N)]": {initial: i}, "y[i in range(N)]": {initial: sin(i)}}
masses: {"bead[i in range(N)]": m}
embedding: {"bead[i in range(N)]": ["x[i]", "y[i]"]}
potential: POTENTIAL
"""
PAIRS = "sum(k*((x[i] - x[j])**2 + (y[i] - y[j])**2) for i in range(N) for j in range(i))"


@pytest.mark.exhaustive(keep=0.15)
def test_conserved_quantities_are_printed_with_indices() -> None:
    falling = BEADS.replace("POTENTIAL", f"sum(m*g*y[i] for i in range(N)) + {PAIRS}")
    text = as_written(derive(spec_of(falling)), "text", "lagrange", {})
    assert "\n  P_x = m*sum(x_dot[i] for i in range(6))\n" in text
    assert "\n  C_1 = m*sum(y_dot[i] for i in range(6)) + 6*m*g*t\n" in text
    free = as_written(derive(spec_of(BEADS.replace("POTENTIAL", PAIRS))), "text", "lagrange", {})
    turning = "-m*sum(y[i]*x_dot[i] for i in range(6)) + m*sum(x[i]*y_dot[i] for i in range(6))\n"
    assert f"\n  L_z = {turning}" in free
    few = as_written(
        derive(spec_of(BEADS.replace("POTENTIAL", PAIRS).replace("N: 6", "N: 3"))), "text", "lagrange", {}
    )
    assert "\n  P_x = m*x_dot[0] + m*x_dot[1] + m*x_dot[2]\n" in few
    assert r"\sum" in as_written(derive(spec_of(falling)), "latex", "lagrange", {})
