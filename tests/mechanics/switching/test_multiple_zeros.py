"""Expressions of events without multiple zeros have the signs that they had, and touch 0 nowhere."""

from __future__ import annotations

import random

import pytest

from lagrange_cli.expression.build import build
from lagrange_cli.expression.evaluate import evaluate
from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.parse import parse
from lagrange_cli.expression.signs import unbroken
from lagrange_cli.mechanics.switching.multiple_zeros import with_simple_zero

TOUCHED = "({})**2", "({})**4", "abs({})", "abs({})**3", "sqrt(({})**2)", "max({0}, -({0}))"
CROSSED = "({})", "({})**3", "({})**5"
FACTORS = "x - 0.5", "x + 2", "x*y", "sin(x) - y", "y - 0.25", "x - y"


def drawn(chance: random.Random) -> tuple[str, list[str]]:
    """An expression, and what in it is 0 where it is touched."""
    factors = chance.sample(FACTORS, 4)
    some = chance.randint(1, 3)
    made = [chance.choice(TOUCHED).format(one) for one in factors[:some]]
    made += [chance.choice(CROSSED).format(one) for one in factors[some:]]
    chance.shuffle(made)
    if chance.random() < 0.3:  # factors that terms share
        made = [f"({'*'.join(made)}*(x + 3) + 2*{'*'.join(made)})"]
    return "*".join([repr(chance.uniform(-3, 3)), *made]), factors[:some]


@pytest.mark.parametrize("case", range(20))
def test_signs_stay_and_touched_zeros_go(case: int, request: pytest.FixtureRequest) -> None:
    chance = random.Random(f"{request.config.option.seed} {case}")
    text, touched = drawn(chance)
    algebra = GraphAlgebra()
    node, *inner = (build(parse(one), algebra.symbol, algebra) for one in (text, *touched))
    simple = with_simple_zero(algebra.graph, node)
    for _ in range(20):
        values = {name: chance.uniform(-3.0, 3.0) for name in "xy"}
        found, _ = evaluate([node, simple, *inner], values)
        assert found[node] * found[simple] > 0.0, (text, values)
    for y in (0.125, -1.5):  # x - 0.5 is 0 here, and others are not
        found, _ = evaluate([node, simple], {"x": 0.5, "y": y})
        if "x - 0.5" in touched:
            assert found[node] == 0.0 != found[simple], text


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("x**3 + abs(y) - exp(x)/m", True),
        ("x/(1 + y**2)", True),
        ("1/y**2 - x", True),
        ("1/y - x", False),
        ("tan(x)", False),
        ("atan2(y, x) - m", False),
        ("where(x > 0, y, 2*y)", False),
        ("x - lam", False),
    ],
)
def test_what_may_come_to_its_other_side_without_being_0(text: str, expected: bool) -> None:
    algebra = GraphAlgebra()
    node = build(parse(text), algebra.symbol, algebra)
    moving = algebra.symbol("x").symbols | algebra.symbol("y").symbols
    assert unbroken(node, moving | algebra.symbol("m").symbols, moving) is expected
