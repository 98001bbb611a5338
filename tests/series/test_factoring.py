"""Products of many factors from products of two."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Node
from lagrange_cli.series.factoring import associate, factors_of, reciprocals, steps
from tests.support.draws import examples

POWERS = st.dictionaries(st.sampled_from("abcdef"), st.sampled_from([1, 2, 3, 4, 7, -1, -2, 0.5]), min_size=2)


def products_of(graph: Graph, powers: list[dict[str, float]]) -> list[Node]:
    made = (graph.product([(graph.symbol(name), e) for name, e in one.items()]) for one in powers)
    return list(dict.fromkeys(made))


@pytest.mark.exhaustive(keep=0.55)
@examples(40)
@given(st.lists(POWERS, min_size=1, max_size=12))
def test_every_product_is_made_from_two_that_make_it(powers: list[dict[str, float]]) -> None:
    graph = Graph()
    products = products_of(graph, powers)
    plan = associate(graph, products)
    assert set(products) <= set(plan)
    made: set[Node] = set()
    pending = list(products)
    while pending:
        node = pending.pop()
        if node in plan and node not in made:
            made.add(node)
            a, b = plan[node]
            assert graph.product([(a, 1), (b, 1)]) is node
            pending += [a, b]
    assert len(made) <= sum(factors_of(graph, product).total() - 1 for product in products)


def test_what_products_share_is_made_once() -> None:
    """r^2 w and r w^2: r w, and one product more for each."""
    graph = Graph()
    plan = associate(graph, products_of(graph, [{"r": 2, "w": 1}, {"r": 1, "w": 2}]))
    assert len(plan) == 3


@given(st.sets(st.integers(1, 40), min_size=1, max_size=4))
def test_powers_are_made_from_two_halves(exponents: set[int]) -> None:
    made = steps(exponents)
    assert exponents <= made
    assert all(one == 1 or {one // 2, one - one // 2} <= made for one in made)
    assert len(made) <= 2 * sum(1 + math.log2(one) for one in exponents)


def test_reciprocals_are_taken_where_they_cost_less() -> None:
    """r^-2 and r^-3 take three convolutions from 1/r, four as powers; r^-7 and r^-13 seven and four."""
    graph = Graph()
    r = graph.symbol("r")
    for powers, cheaper in (((2, 3), True), ((1, 2), True), ((2,), False), ((3,), False), ((7, 13), False)):
        products = [graph.product([(r, -power), (graph.symbol("x"), 1)]) for power in powers]
        assert reciprocals(products) == ({r} if cheaper else set())


@pytest.mark.exhaustive(keep=0.5)
def test_the_derivative_of_a_long_product_shares_its_parts() -> None:
    """n products of n - 1 factors: n log2 n products of two, found without looking at every pair."""
    graph, count = Graph(), 200
    x = graph.symbol("x")
    factors = [x + float(i) for i in range(count)]
    products = [graph.product([(f, 1) for f in factors if f is not left_out]) for left_out in factors]
    before = graph.work.spent
    plan = associate(graph, products)
    assert set(products) <= set(plan)
    assert all(graph.product([(a, 1), (b, 1)]) is both for both, (a, b) in plan.items())
    assert len(plan) <= count * math.ceil(math.log2(count))
    assert graph.work.spent - before < 3_000_000
