"""The parts of the state: side by side, in order, and all of it."""

from hypothesis import given
from hypothesis import strategies as st

from lagrange_cli.native.state import CLOCK, LANES, Clock, StateLayout

LAYOUTS = st.builds(
    StateLayout,
    st.integers(1, 40),
    st.integers(0, 9),
    cyclic=st.integers(0, 5),
    multipliers=st.integers(0, 5),
)


@given(LAYOUTS)
def test_parts_fill_the_rows(layout):
    rows = list(range(layout.rows))
    parts = [layout.q, layout.v, layout.lagrange_multipliers, layout.integrals]
    assert [row for part in parts for row in rows[part]] == rows
    assert rows[layout.motion] == rows[layout.q] + rows[layout.v]
    assert rows[layout.rates] == rows[layout.degrees :]
    assert len(rows[layout.integrals]) == layout.quadratures + layout.cyclic
    assert rows[layout.integrals][layout.quadratures :] == rows[layout.cyclic_momenta]


@given(LAYOUTS)
def test_memory_holds_all_parts_apart(layout):
    places = list(range(layout.memory))
    high, low, clock = (places[one] for one in (layout.part(0), layout.part(1), layout.clock))
    third = places[layout.third : layout.third + layout.rows]
    assert len({*high, *low, *clock, *third}) == 3 * layout.rows + CLOCK
    assert max(high) < min(low) < min(clock) < min(third)
    assert [layout.at(number) for number in Clock] == clock[: len(Clock)]
    assert places[layout.remembered] == clock[Clock.STEP :]
    # what is stored and loaded as whole vectors is whole
    assert layout.width in (2, 4) or layout.width % LANES == 0
