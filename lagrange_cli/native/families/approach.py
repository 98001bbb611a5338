"""``@approach``: by how much a step may bring a motion nearer to a pole, or to where a narrow force acts
(``families.poles``)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Array, Source, Term
from lagrange_cli.native.families.arrangement import Arrangement
from lagrange_cli.native.families.evaluation import Evaluation, Writer
from lagrange_cli.native.families.loops import Loop
from lagrange_cli.native.families.tables import before
from lagrange_cli.native.families.vectors import DoubleVectors, Operands
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Integer, Real
from lagrange_cli.records import replace

APPROACH = (
    "define internal double @approach(ptr noalias %constants, double %t, ptr noalias %state, "
    "ptr noalias %bounds, double %h) #0"
)


class _Largest(Writer):
    """A loop of which the largest term counts."""

    def __init__(self, evaluation: Evaluation, loop: Loop) -> None:
        super().__init__(evaluation, loop)
        self.most = self.vectors.variable(self.vectors.zero(LANES))

    def row(self, bases: Sequence[Integer], length: Integer, r: Integer) -> None:
        f, fixed = self.f, self.fixed(bases)
        with f.loop(0, length, LANES, tested=False) as j:
            known = {**self.evaluation.known, **fixed, **self.changing(bases, j)}
            inside = before(f, j, length)
            for value in self.values(known, j):
                number = self.vectors.number(value)
                bound = f.select(number >= number, number, f.splat(f.constant(math.inf), LANES))
                one = f.select(inside, bound, f.zero(LANES))
                self.most.set(f.larger(one, self.most.get()))


def approach(arrangement: Arrangement, terms: Sequence[Term], bounds: Mapping[Array, int], span: Node) -> str:
    """The text of the function, of ``families.poles.nearing`` or ``nearing_alike``: the largest of its terms.
    A step has the length ``%h``, and ``%bounds`` has the ``bounds`` from these numbers on."""
    f = Function(APPROACH)
    vectors = DoubleVectors(f)
    own = {array: f.place("%bounds", place, "double") for array, place in bounds.items()}
    arrays = {**arrangement.state(f), **own}
    evaluation = arrangement.evaluation(vectors, arrays, Real(f, "%t", 1))
    step: Operands = vectors.operand(f.splat(Real(f, "%h", 1), LANES))
    evaluation = replace(evaluation, known={**evaluation.known, span: step})
    domains: dict[int, list[tuple[Term, Array]]] = {}
    for term in terms:
        domains.setdefault(id(term.domain), []).append((term, Array(Source.TOTAL, 1)))
    most = f.variable(f.constant(0.0))
    for listed in domains.values():
        loop = _Largest(evaluation, Loop(listed[0][0].domain, listed, arrangement.slots))
        loop.write()
        most.set(f.larger(most.get(), f.reduce("fmax", loop.most.get())))
    f.give(most.get())
    return f.text()
