"""The rounds that satisfy conditions are those of Python's loops, and are found without going through all."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lagrange_cli.expression import index_loops
from lagrange_cli.expression.build import Builder
from lagrange_cli.expression.index_arrays import TooMany, Unsuited, Whole
from lagrange_cli.expression.index_bounds import answer, bounds_of
from lagrange_cli.expression.index_loops import inner
from lagrange_cli.expression.numbers import NumberAlgebra
from lagrange_cli.expression.parse import parse
from lagrange_cli.expression.syntax import Sum
from tests.support.draws import examples


def rounds_of(text: str, sizes: dict[str, int]) -> list[tuple[int, ...]]:
    """The indices in all rounds of a sum, loop after loop."""
    tree = parse(text)
    found: dict[str, Whole] = {**sizes}
    names, count = list[str](), 1
    while isinstance(tree, Sum):
        found, owners = inner(tree, found, count)
        names.append(tree.index)
        count, tree = len(owners), tree.body
    columns = [np.broadcast_to(found[name], count).tolist() for name in names]
    return [*zip(*columns)]


def whole(inside: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    return (
        st.builds("({} {} {})".format, inside, st.sampled_from("+-*"), inside)
        | st.builds(
            "({} {} {})".format, inside, st.sampled_from(["//", "%"]), st.sampled_from(["3", "N", "(-2)"])
        )
        | st.builds("{}({}, {})".format, st.sampled_from(["min", "max"]), inside, inside)
        | st.builds("abs({})".format, inside)
        | st.builds("({}**{})".format, inside, st.sampled_from("012"))
    )


WHOLE = st.recursive(st.sampled_from(["i", "j", "k", "N", "1", "2"]), whole, max_leaves=5)
COMPARED = st.builds("{} {} {}".format, WHOLE, st.sampled_from(["==", "!=", "<", "<=", ">", ">="]), WHOLE)
CONDITIONS = st.recursive(
    COMPARED | st.builds("{} <= {} < {}".format, WHOLE, WHOLE, WHOLE) | WHOLE,
    lambda one: (
        st.builds("({} {} {})".format, one, st.sampled_from(["and", "or"]), one)
        | st.builds("not ({})".format, one)
    ),
    max_leaves=3,
)
THIRD = st.sampled_from(["range(4)", "range(j)", "range(i, N)", "range(N, j, -1)", "range(0, N, 2)"])


@pytest.mark.exhaustive(keep=0.2)
@given(CONDITIONS, THIRD, st.sampled_from(["range(N)", "range(N - 1, -1, -1)", "range(i + 1)"]))
@examples(150)
def test_rounds_are_those_of_python(condition: str, third: str, second: str) -> None:
    loops = f"for i in range(N) for j in {second} for k in {third} if {condition}"
    expected = eval(f"[(i, j, k) {loops}]", {"N": 7})
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(index_loops, "FEW", 0)
        assert rounds_of(f"sum(x {loops})", {"N": 7}) == expected


@pytest.mark.exhaustive(keep=0.2)
@given(CONDITIONS, *3 * [st.tuples(st.integers(-4, 9), st.integers(0, 4))])
@examples(150)
def test_bounds_hold_for_all_indices_between_theirs(
    condition: str, i: tuple[int, int], j: tuple[int, int], k: tuple[int, int]
) -> None:
    tree = parse(f"sum(x for i in range(1) if {condition})")
    assert isinstance(tree, Sum)
    between = [(low, low + more) for low, more in (i, j, k)]
    known = {**dict(zip("ijk", between)), "N": (7, 7)}
    may, must = answer(tree.conditions[0], known)
    found = [
        bool(eval(condition, {"i": a, "j": b, "k": c, "N": 7}))
        for a in range(between[0][0], between[0][1] + 1)
        for b in range(between[1][0], between[1][1] + 1)
        for c in range(between[2][0], between[2][1] + 1)
    ]
    assert may or not any(found)
    assert all(found) or not must


BANDS = {
    "i == j + 1": lambda n: n - 1,
    "abs(i - j) == 1": lambda n: 2 * (n - 1),
    "0 < j - i <= 3": lambda n: 3 * n - 6,
    "(i - j) % N == 1": lambda n: n,
    "min(abs(i - j), N - abs(i - j)) == 1": lambda n: 2 * n,
    "j == i + 2 and i % 2 == 0": lambda n: (n - 1) // 2,
    "i - j == 1 or j - i == 1": lambda n: 2 * (n - 1),
    "not abs(i - j) > 1": lambda n: 3 * n - 2,
    "i // 10 == j // 10 and i < j": lambda n: 45 * (n // 10),
    "j*j == i": lambda n: math.isqrt(n - 1) + 1,
}


@pytest.mark.exhaustive(keep=0.4)
@pytest.mark.parametrize("condition", BANDS)
def test_bands_of_pairs_take_work_in_proportion_to_their_number(condition: str) -> None:
    """There are 10^10 pairs in all, and 2 million may be looked at."""
    count = 100_000
    found = rounds_of(f"sum(x for i in range(N) for j in range(N) if {condition})", {"N": count})
    assert len(found) == BANDS[condition](count)


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(
    "condition",
    [
        "abs(i - k) + abs(j - l) == 1",
        "k == i and (l == j + 1 or l == j - 1) or l == j and (k == i + 1 or k == i - 1)",
        "max(abs(i - k), abs(j - l)) == 1 and min(abs(i - k), abs(j - l)) == 0",
    ],
)
def test_conditions_of_inner_loops_narrow_those_around_them(condition: str) -> None:
    """Neighbours in a lattice of 150 x 150, among 5*10^8 pairs."""
    loops = "for i in range(N) for j in range(N) for k in range(N) for l in range(N)"
    assert len(rounds_of(f"sum(x {loops} if {condition})", {"N": 150})) == 4 * 150 * 149
    chain = "for i in range(N) for j in range(N) for k in range(N) if j == i + 1 and k == j + 1"
    assert len(rounds_of(f"sum(x {chain})", {"N": 10_000})) == 9998


@pytest.mark.exhaustive(keep=0.2)
def test_pairs_that_are_too_many_are_refused_at_once() -> None:
    for condition in ("i < j", "i != j", "(i - j) % 2 == 0"):
        with pytest.raises(TooMany):
            rounds_of(f"sum(x for i in range(N) for j in range(N) if {condition})", {"N": 100_000})


def test_sums_that_are_written_out_look_at_few_rounds() -> None:
    """All 250,000 rounds are more than may be written out."""
    builder = Builder(lambda name: 1.0, NumberAlgebra(), {"N": 500})
    tree = parse("sum(x[i]*x[j] for i in range(N) for j in range(N) if abs(i - j) == 1)")
    assert builder.build(tree) == 998.0


def test_what_is_too_large_for_bounds_is_unsuited() -> None:
    product = "N*N*N*N*N*N"
    tree = parse(f"sum(x for i in range(1) if {product} == i)")
    assert isinstance(tree, Sum)
    with pytest.raises(Unsuited):
        bounds_of(parse(f"sum(x for i in range({product}))").bounds[0], {"N": (10**5, 10**5)})  # type: ignore[union-attr]
    with pytest.raises(Unsuited):
        answer(tree.conditions[0], {"N": (10**5, 10**5), "i": (0, 1)})
