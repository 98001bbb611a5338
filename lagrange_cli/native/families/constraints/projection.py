"""``@project`` of systems of families: the state back to the constraints (see ``stepping.projection``)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Array, Term
from lagrange_cli.native.families.careful import careful_values
from lagrange_cli.native.families.constraints.coupled_masses import MassFactors
from lagrange_cli.native.families.constraints.dense import SolvingTables
from lagrange_cli.native.families.constraints.moves import Moves, MovesTogether, Offsets
from lagrange_cli.native.families.constraints.together_jet import factored
from lagrange_cli.native.families.evaluation import Evaluation, Writer, added
from lagrange_cli.native.families.tables import place_at
from lagrange_cli.native.families.vectors import Operands, Vectors
from lagrange_cli.native.llvm.flow import Variable
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer
from lagrange_cli.native.state import StateLayout
from lagrange_cli.native.stepping.projection import LOOSE, places_of
from lagrange_cli.records import dataclass


class Residuals(Writer):
    """The loop over the constraints of a bound: what should be 0, from all digits of the state, and whether
    it is, but for rounding."""

    def __init__(self, moves: Offsets, evaluation: Evaluation, number: int, fine: Variable[Bit]) -> None:
        super().__init__(evaluation, moves.loops[number])
        self.moves, self.bound, self.fine = moves, moves.bounds[number], fine

    @property
    def terms(self) -> Sequence[tuple[Term, Array]]:
        return self.loop.terms[: len(self.loop.terms) - len(self.bound.rows)]

    def of_eight(
        self, known: dict[Node, Operands], bases: Sequence[Integer], j: Integer, inside: Bit
    ) -> list[Operands]:
        f, vectors, evaluation, kind = self.f, self.vectors, self.evaluation, self.evaluation.emitter
        system = self.moves.system
        nodes = [term.node for term, _ in self.terms][: 2 + len(self.bound.rows)]
        found = (self.carefully if vectors.parts == 1 else self.plainly)(nodes[:2], known, bases, j)
        slopes = dict(zip(nodes[2:], evaluation.values(nodes[2:], known)))
        slots = self.moves.slots
        offs, sizes = list[Operands](), list[Operands]()
        for off, array in zip(found, (system.q, system.v)):
            total: Any = None
            judged = self.bound.holonomic or array is system.v
            for slope, rows in zip(nodes[2:], self.bound.rows) if judged else ():
                amount = known[slots.symbol(self.bound.domain, array, rows)]
                total = kind.add(total, kind.magnitude(kind.mul(slopes[slope], amount)))
            size = kind.mul(kind.number(LOOSE * kind.unit), total)
            if self.bound.whole:
                most = vectors.high(vectors.number(size))
                small = f.magnitude(vectors.high(vectors.number(off))) <= most
                self.fine.set(self.fine.get() & f.all(small | ~inside))
            offs.append(off)
            sizes.append(size)
        return [*offs, *(slopes[one] for one in nodes[2:]), *(() if self.bound.whole else sizes)]

    def plainly(
        self, nodes: list[Node], known: dict[Node, Operands], bases: Sequence[Integer], j: Integer
    ) -> list[Operands]:
        """What should be 0, in the numbers of the state."""
        return self.evaluation.values(nodes, known)

    def carefully(
        self, nodes: list[Node], known: dict[Node, Operands], bases: Sequence[Integer], j: Integer
    ) -> list[Operands]:
        """The same from doubles and their low parts."""
        return careful_values(self, nodes, known, lambda one: {**one.fixed(bases), **one.changing(bases, j)})


def write_residuals(moves: Offsets, evaluation: Evaluation, fine: Variable[Bit]) -> None:
    """By how much all constraints are off, and their slopes; whether those of one term are ``fine``."""
    slopes = [one for some in moves.columns for one in some]
    sizes = moves.sizes if len(moves.bonds.summed) else ()
    evaluation.clear(added([moves.off, moves.off_speeds, *slopes, *sizes], moves.loops))
    for number, _ in enumerate(moves.bounds):
        Residuals(moves, evaluation, number, fine).write()


@dataclass(frozen=True)
class Projection:
    """Writes ``@project(constants, state)``, in the function of the ``evaluation``. There is room at
    ``scratch``."""

    moves: Moves | MovesTogether
    evaluation: Evaluation
    layout: StateLayout
    tabled: SolvingTables
    factors: MassFactors | None
    scratch: Pointer

    def text(self) -> str:
        """The function's text."""
        moves, evaluation = self.moves, self.evaluation
        f = evaluation.f
        fine = f.variable(Bit(f, "true", 1))
        summed = moves.bonds.summed.tolist()
        write_residuals(moves, evaluation, fine)
        if summed:
            self._judge(summed, fine)
        with f.when(~fine.get()):
            self._move()
        f.give()
        return f.text()

    def _judge(self, summed: Sequence[int], fine: Variable[Bit]) -> None:
        """Whether constraints with several terms are 0, but for rounding."""
        moves, f, where = self.moves, self.evaluation.f, self.evaluation.where
        places, vectors = self.evaluation.tables.of_places(summed), self.evaluation.vectors
        with f.loop(0, len(summed), tested=False) as i:
            number = place_at(f, i + places)
            for off, size in zip((moves.off, moves.off_speeds), moves.sizes):
                value, most = (vectors.high(vectors.load(where(one), number)) for one in (off, size))
                fine.set(fine.get() & (f.magnitude(value) <= most))

    def _move(self) -> None:
        moves, evaluation, f = self.moves, self.evaluation, self.evaluation.f
        at, where = places_of(self.layout), evaluation.where
        if self.factors is None:
            evaluation.write(moves.before if isinstance(moves, MovesTogether) else ())
            evaluation.write([moves.square])
        saddle, regular = factored(moves, evaluation, self.tabled, self.factors, self.scratch)
        with f.when(regular):
            moves.move(evaluation, saddle)
            for total, row in ((moves.moved, at.q), (moves.speeds, at.v)):
                add_to_state(evaluation.vectors, where(total), row, self.layout)
            at.counted(f)


def add_to_state(vectors: Vectors, changes: Pointer, first: int, layout: StateLayout) -> None:
    """The ``changes`` of all coordinates to the rows of the state from ``first`` on."""
    with vectors.f.loop(0, layout.degrees, tested=False) as row:
        vectors.add_to_state(row, first, layout.width, lambda: vectors.load(changes, row))
