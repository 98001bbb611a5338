"""Linear relations between expressions: those that there are, whatever their sizes, from a few states."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lagrange_cli.expression.graph import Graph
from lagrange_cli.mechanics import relations
from lagrange_cli.mechanics.relations import ENOUGH, SPARE, Relations
from tests.support.draws import examples

NUMBERS = st.integers(1, 9)
SIZES = st.sampled_from([2.0**-40, 2.0**-7, 1.0, 2.0**9, 2.0**40])


@given(NUMBERS, NUMBERS, SIZES)
@examples(15)
def test_a_combination_of_two_columns_is_found(a, b, size):
    """Also beside one of another size, which is none."""
    graph = Graph()
    x, y = graph.symbol("x"), graph.symbol("y")
    one, other, alone = [x, y], [x * y, y**3], [size * x, -size * y]
    both = [a * p + b * q for p, q in zip(one, other)]
    (found,) = Relations(graph).relations([alone, one, other, both])
    assert [float(found[i].data) / float(found[3].data) for i in (1, 2)] == [-a, -b]
    assert Relations(graph).combination([alone, one, other], both) == [0, a, b]
    assert Relations(graph).combination([one, other], alone) is None


def test_a_sum_of_parameters_that_is_0_is_no_factor():
    graph = Graph()
    x, y, z, a, b = (graph.symbol(name) for name in "xyzab")
    nothing = graph.function("tanh", [a + 40.0]) - 1.0  # to the last digit
    columns = [[x * y + nothing * z, x], [(a + b) * x * y, (a + b) * x]]
    (found,) = Relations(graph, [x, y, z]).relations(columns)
    assert found[0] / found[1] is -(a + b)


def test_columns_that_are_zero_are_relations_by_themselves():
    graph = Graph()
    found = Relations(graph).relations([[graph.zero, graph.zero]] * 3)
    assert [sorted(one) for one in found] == [[0], [1], [2]]


@pytest.mark.parametrize("conditions", [1, 30])
def test_states_are_looked_at_until_they_tell_nothing_new(conditions, monkeypatch):
    """Thirty columns with one condition take as many states; with thirty conditions, a few of them do."""
    graph, looked, evaluated = Graph(), [], relations.evaluated
    monkeypatch.setattr(relations, "evaluated", lambda *given: looked.append(given) or evaluated(*given))
    x = [graph.symbol(f"x{i}") for i in range(30)]
    columns = [[x[(i + j) % 30] for j in range(conditions)] for i in range(30)]
    assert Relations(graph).relations(columns) == []
    assert len(looked) == (30 if conditions == 1 else 1)
    looked.clear()
    (found,) = Relations(graph).relations([*columns, columns[0]])
    assert sorted(found) == [0, 30]
    assert len(looked) == (30 + SPARE if conditions == 1 else ENOUGH)
