"""Members of a family in blocks, and how they are named in short."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

import lagrange_cli as lagrange
from lagrange_cli.run.shortened import in_short
from lagrange_cli.spec.blocks import FEWEST, blocks, several
from lagrange_cli.spec.read import read_spec

GRID = """
sizes: {N: 7, K: 6}
coordinates: {"u[i in range(N), j in range(K)]": {initial: 0}}
lagrangian: sum(u_dot[i,j]**2/2 for i in range(N) for j in range(K))
"""
ROW = """
sizes: {N: 60}
coordinates: {"x[i in range(N)]": {initial: sin(i)}, "y[i in range(N)]": {initial: 0, velocity: 1}}
masses: {"b[i in range(N)]": 1 + i/N}
positions: {"b[i in range(N)]": ["x[i]", "y[i]"]}
potential: sum(x[i]**2/2 for i in range(N) if i % 3) + sum((y[i + 1] - y[i])**2/2 for i in range(N//2))
"""


@given(st.sets(st.tuples(st.integers(0, 6), st.integers(0, 5))))
def test_blocks_have_all_members_but_few(chosen: set[tuple[int, int]]) -> None:
    """Each once, and those in the ranges alone."""
    (family,) = read_spec(GRID, "grid.yaml").coordinate_families.values()
    present = {f"u[{i},{j}]" for i, j in chosen}
    found = list[str]()
    for ranges, members in blocks(family, present):
        assert [*members] == [f"u[{i},{j}]" for i in ranges[0] for j in ranges[1]]
        assert len(members) >= FEWEST
        found += members
    assert len({*found}) == len(found) and present.issuperset(found)
    spec = read_spec(GRID, "grid.yaml")
    assert in_short(sorted(present), spec) == ["u[0..6,0..5]"] if len(present) == 42 else True


def test_several_indices() -> None:
    assert several(range(151, 300)) == "151, ..., 299" and several(range(0, 28, 3)) == "0, 3, ..., 27"


def test_momenta_of_some_members_are_in_one_line() -> None:
    """Also in the printed equations."""
    spec = read_spec(ROW, "row.yaml")
    names = [f"x[{i}]" for i in range(0, 60, 3)] + [f"y[{i}]" for i in range(31, 60)] + ["y[2]"]
    assert in_short(names, spec) == ["x[0], x[3], ..., x[57]", "y[31..59]", "y[2]"]
    shown = " ".join(lagrange.equations(ROW, indexed=True).write().split())
    assert "p_x[i]: x[i] is cyclic for i = 0, 3, ..., 57: L does not contain it" in shown
    assert "p_y[i]: y[i] is cyclic for i = 31, ..., 59: L does not contain it" in shown
    checked = lagrange.check(ROW)
    assert {f"p_y[{i}]" for i in range(31, 60)} <= {*checked.conserved}
