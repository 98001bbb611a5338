"""Systems of many members: the work of the search for conserved quantities grows as they do."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

import pytest

from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.node import Node
from lagrange_cli.mechanics.conservation import conservation
from lagrange_cli.mechanics.conserved.noether import Noether
from lagrange_cli.mechanics.conserved.separation import coordinates_together, separate_energies
from lagrange_cli.mechanics.conserved.symmetries import symmetries
from lagrange_cli.mechanics.embedding import Embedding
from lagrange_cli.mechanics.matrices import united
from lagrange_cli.mechanics.switching.jumps import refuse_jumps
from lagrange_cli.mechanics.variables import graph_of
from lagrange_cli.model.build import build_model
from lagrange_cli.model.model import Model
from lagrange_cli.spec.read import read_spec
from tests.support.motion import SYSTEMS

OSCILLATORS = """
sizes: {N: 4}
coordinates: {x[i in range(N)]: {initial: 1}}
masses: {p[i in range(N)]: 1}
positions: {p[i in range(N)]: ['x[i]']}
potential: sum((1 + i)*x[i]**2 for i in range(N))
dissipation: 0
"""
LINKS = """
sizes: {N: 3}
parameters: {l: 0.5}
coordinates:
  x[i in range(N)]: {initial: (i + 0.5)*l}
  y[i in range(N)]: {initial: 0}
  z[i in range(N)]: {initial: 0}
  a[i in range(N)]: {initial: 1}
  b[i in range(N)]: {initial: 0}
  c[i in range(N)]: {initial: 0}
  d[i in range(N)]: {initial: 0, velocity: 1}
bodies:
  link[i in range(N)]: {mass: 1, solid: {box: [l, 0.1, 0.2]}, position: ['x[i]', 'y[i]', 'z[i]'],
    orientation: {quaternion: ['a[i]', 'b[i]', 'c[i]', 'd[i]']}}
potential: sum(9.81*link[i].z for i in range(N))
constraints:
  jx[0]: link[0].at(-l/2, 0, 0).x
  jy[0]: link[0].at(-l/2, 0, 0).y
  jz[0]: link[0].at(-l/2, 0, 0).z
  jx[i in range(1, N)]: link[i].at(-l/2, 0, 0).x - link[i - 1].at(l/2, 0, 0).x
  jy[i in range(1, N)]: link[i].at(-l/2, 0, 0).y - link[i - 1].at(l/2, 0, 0).y
  jz[i in range(1, N)]: link[i].at(-l/2, 0, 0).z - link[i - 1].at(l/2, 0, 0).z
"""
LINEAR = 2.2
"""Twice as many members take at most so many times the steps."""


def model_of(text: str | bytes, size: int) -> Model[Node]:
    return build_model(read_spec(text, "system.yaml", {"N": str(size)}), GraphAlgebra())


def steps(function: Callable[[], Any]) -> int:
    """Instructions of the interpreter, those inside of comprehensions included."""
    count = 0

    def trace(frame: Any, event: str, argument: Any) -> Any:
        nonlocal count
        frame.f_trace_opcodes, frame.f_trace_lines = True, False
        count += event == "opcode"
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        function()
    finally:
        sys.settrace(before)
    return count


STAGES: dict[str, Callable[[Model[Node]], Any]] = {
    "parts": coordinates_together,
    "energies of parts": lambda model: separate_energies(model, ()),
    "blocks": lambda model: Embedding(model).blocks,
    "cyclic coordinates": conservation,
    "jumps": refuse_jumps,
    "velocities by others": lambda model: Noether(model).eliminated,
}


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize("stage", STAGES)
def test_twice_as_many_members_take_twice_the_steps(stage):
    text = (SYSTEMS / "chain.yaml").read_bytes()
    if "energies" in stage:
        text = OSCILLATORS
    small, large = (model_of(text, size) for size in (12, 24))
    first, second = (steps(lambda model=model: STAGES[stage](model)) for model in (small, large))
    assert second < LINEAR * first


@pytest.mark.exhaustive(keep=0.6)
def test_the_search_is_linear_in_the_number_of_links():
    spent = []
    for size in (24, 48):
        model = model_of((SYSTEMS / "chain.yaml").read_bytes(), size)
        known, work = conservation(model)[1], graph_of(model).work
        before = work.spent
        assert symmetries(model, known) == ()
        spent.append(work.spent - before)
    assert spent[1] < LINEAR * spent[0]


@pytest.mark.exhaustive(keep=0.15)
def test_a_hanging_chain_of_bodies_keeps_its_angular_momentum_about_the_vertical():
    """The search is not given up for many links: it takes so many steps for each."""
    model = model_of(LINKS, 16)
    known, work = conservation(model)[1], graph_of(model).work
    before = work.spent
    assert [one.conserved.quantity for one in symmetries(model, known)] == ["L_z"]
    assert work.spent - before < 70_000 * 16


def test_united():
    """Sets that overlap, directly or not, make one block."""
    assert united(6, [(4, 2), (5, 3), (3, 0)]) == ((0, 3, 5), (1,), (2, 4))
    assert united(5, [(3, 2), (1, 0), (0, 4, 2), ()]) == ((0, 1, 2, 3, 4),)
    assert united(0, []) == ()
