"""Compiled expressions have the values of the graph, which ``test_graph`` holds against exact numbers."""

from __future__ import annotations

import math

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from lagrange_cli.errors import SpecError
from lagrange_cli.expression.evaluate import evaluate
from lagrange_cli.expression.syntax import ExpressionError
from tests.expression.test_graph import conditioned, node_of
from tests.support.draws import examples
from tests.support.expressions import texts
from tests.support.motion import follow, spec_of

NAMES = ("x", "x_dot", "y", "a", "t")


def system_of(expressions: list[str]) -> str:
    """A system at rest or drifting, whose observables are these expressions."""
    listed = "\n".join(f'  o{k}: "{text}"' for k, text in enumerate(expressions))
    return (
        "parameters: {a: 1.0}\ncoordinates: {x: {initial: 1.0}, y: {initial: 1.0}}\nmasses: {p: 1}\n"
        f"embedding: {{p: [x, y]}}\nobservables:\n{listed}\n"
    )


@pytest.mark.exhaustive(keep=0.3)
@examples(6)
@given(
    st.lists(texts(NAMES), min_size=8, max_size=12), st.lists(st.floats(-1.5, 1.5), min_size=5, max_size=5)
)
def test_observables_are_what_they_say(expressions: list[str], numbers: list[float]) -> None:
    values = dict(zip(NAMES, numbers, strict=True))
    nodes = {}
    for text in expressions:
        try:
            spec_of(system_of([text]))  # constants outside a function's domain are refused
            nodes[text] = node_of(text)
        except (SpecError, ExpressionError):
            continue
    assume(nodes)
    start = {name: values[name] for name in ("x", "x_dot", "y", "a")}
    motion = follow(
        system_of(list(nodes)), values["t"] + 1e-3, 2, start=values["t"], sets=start, outputs=("observables",)
    )
    for k, (text, node) in enumerate(nodes.items()):
        found = motion[f"observables/o{k}"][0]
        values_below, sizes = evaluate([node], values)
        if not conditioned(node, values):
            continue
        assert math.isfinite(values_below[node])
        assert abs(found - values_below[node]) <= 1e-13 * max(1.0, sizes[node]), text
