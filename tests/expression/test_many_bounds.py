"""Long sums are looked at as a whole, and what is wrong with a term is said as for short ones."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lagrange_cli.expression.index_arrays import Unsuited, holding, integers
from lagrange_cli.expression.index_loops import inner
from lagrange_cli.expression.indices import counted, holds, integer
from lagrange_cli.expression.parse import parse
from lagrange_cli.expression.syntax import ExpressionError, Sum, Tree
from lagrange_cli.spec.read import examine
from tests.support.draws import examples

FILE = """
sizes: {{N: {count}}}
parameters: {{"k[i in range(N)]": "1 + i"}}
coordinates: {{"u[i in range(N)]": {{initial: "i"}}}}
definitions: {{"d[i in range(N)]": "u[i]**2"}}
lagrangian: sum(u_dot[i]**2/2 for i in range(N)) - sum({term} for i in range(N))
"""
WRONG = {
    "1/(i - 3)*u[i]": "division by zero, for i = 3",
    "u[i + 1]": "no member",
    "u[i]*k[i - 1]": "no member",
    "u[i]**(i - 100)": "exponent -100 is out of bounds",
    "sqrt(2 - i)*u[i]": "not a real number",
    "u[i]*(1e150*1e150)**(i - 47)": "number too large",
    "d[2*i]": "no member",
    "log(i)*u[i]": "log",
    "sum(u[j]/(j - 2) for j in range(i))": "division by zero",
    "u[i // 0]": "division by zero",
}


@pytest.mark.parametrize("term", WRONG)
def test_what_is_wrong_with_a_term_is_said_of_a_long_sum_as_of_a_short_one(term: str) -> None:
    found = []
    for count in (50, 250):
        _, problems = examine(FILE.format(count=count, term=term), "system.yaml")
        (problem,) = problems.found
        found.append((problem.line, problem.message, problem.hint))
    short, long = found
    assert short[0] == long[0]
    assert WRONG[term] in long[1] or WRONG[term] in long[2]
    if "no member" not in WRONG[term]:  # there is one more where the family is longer
        assert short[1] == long[1]


@pytest.mark.parametrize(
    "term",
    [
        "u[i]*k[N - 1 - i]",
        "u[i]*sin(pi*i/N)",
        "d[(3*i) % N]",
        "u[i]**(2 + i % 3)",
        "u[i]*(-1)**i",
        "u[i]*0.9**(-i)",
        "u[i]*(1 + i/N)**i",
    ],
)
def test_right_ones_pass(term: str) -> None:
    _, problems = examine(FILE.format(count=250, term=term), "system.yaml")
    assert problems.found == []


def wholes(inside: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    operators = st.sampled_from(["+", "-", "*", "//", "%"])
    return st.tuples(inside, operators, inside).map(lambda one: f"({one[0]} {one[1]} {one[2]})")


WHOLE = st.recursive(st.sampled_from(["i", "j", "N", "2", "3", "7"]), wholes, max_leaves=6)
COMPARED = st.tuples(WHOLE, st.sampled_from(["==", "!=", "<", "<=", ">", ">="]), WHOLE).map(" ".join)


def sum_of(text: str, condition: str = "") -> Sum:
    tree: Tree = parse(f"sum(({text})*x for i in range(N) for j in range(i){condition})")
    assert isinstance(tree, Sum)
    return tree


@pytest.mark.exhaustive(keep=0.65)
@given(WHOLE, COMPARED)
@examples(100)
def test_arrays_of_whole_numbers_are_those_of_each_member(text: str, compared: str) -> None:
    outer = sum_of(text, f" if {compared}")
    body = outer.body
    assert isinstance(body, Sum)
    try:
        every = [
            {"N": 5, "i": i, "j": j}
            for i in counted(outer, {"N": 5})
            for j in counted(body, {"N": 5, "i": i})
            if all(holds(one, {"N": 5, "i": i, "j": j}) for one in body.conditions)
        ]
        factor = body.body.left
        values = [integer(factor, one) for one in every]
    except ExpressionError:
        every = None
    try:
        first, owners = inner(outer, {"N": 5}, 1)
        found, _ = inner(body, first, len(owners))
        numbers = integers(factor, found) if every is not None else integers(body.body.left, found)
    except Unsuited:
        assert not every or any(abs(value) > 2**30 for value in values)  # else they are asked one by one
        return
    assert every is not None
    count = len(every)
    for name in ("i", "j"):
        listed = [found[name]] * count if isinstance(found[name], int) else found[name].tolist()
        assert listed == [one[name] for one in every]
    assert ([numbers] * count if isinstance(numbers, int) else numbers.tolist()) == values
    for condition in body.conditions:
        kept = holding(condition, found)
        assert kept is True or bool(kept.all()) if count else True
