"""Which expressions are known to be convex: none of them lies above its chords."""

from __future__ import annotations

import random

import pytest

from lagrange_cli.expression.curvature import Curvature, curvature
from lagrange_cli.expression.evaluate import evaluate
from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Node, union

GRAPH = Graph()
X, Y, R = (GRAPH.symbol(name) for name in "xyr")
D = X - 2.0 * Y + 0.3
CASES: dict[str, tuple[Node, Curvature]] = {
    "a line": (3.0 * D - R**3, Curvature.LINEAR),
    "a line, times what may have either sign": (R * D, Curvature.LINEAR),
    "squares": (D**2 + 2.0 * (X + R) ** 4 - 4.0 * R**2, Curvature.CONVEX),
    "a length": (((X - R) ** 2 + Y**2 + R**2) ** 0.5 - Y, Curvature.CONVEX),
    "the other way": (1.0 - R**2 * D**2, Curvature.CONCAVE),
    "a saddle": (D**2 - Y**2, Curvature.ANY),
    "a product": (X * Y, Curvature.ANY),
    "a cube": (D**3, Curvature.ANY),
    "what may have either sign": (R * D**2, Curvature.ANY),
    "the root of a line": ((X + R) ** 0.5, Curvature.ANY),
    "a wave": (GRAPH.function("sin", [X]), Curvature.ANY),
}


@pytest.mark.parametrize("case", CASES)
def test_no_convex_expression_lies_above_its_chords(case: str) -> None:
    node, expected = CASES[case]
    assert curvature(node, union([X, Y])) == expected
    chance = random.Random(1)
    for _ in range(20):
        r, *ends = (chance.uniform(-1.5, 1.5) for _ in range(5))
        middle = (ends[0] + ends[2]) / 2, (ends[1] + ends[3]) / 2
        a, b, c = (value(node, x, y, r) for x, y in (ends[:2], ends[2:], middle))
        if expected & Curvature.CONVEX:
            assert c <= (a + b) / 2 + 1e-12
        if expected & Curvature.CONCAVE:
            assert c >= (a + b) / 2 - 1e-12


def value(node: Node, x: float, y: float, r: float) -> float:
    """The value of an expression, nan where it has none."""
    return float(evaluate([node], {"x": x, "y": y, "r": r})[0][node])
