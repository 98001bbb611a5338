"""What solves for the forces of resting contacts of joints, in a jet (see ``joint_contacts``).

If contacts do not push each other, each force is a quotient. Otherwise the contacts that hold are listed at
the beginning of a step, and the equations for their forces, which need not be symmetric, are eliminated with
row interchanges in doubles. Numbers of more parts are refined.
"""

from __future__ import annotations

from collections.abc import Sequence

from lagrange_cli.families.arrays import Array, Total
from lagrange_cli.native.families.corrected import CorrectedJet
from lagrange_cli.native.families.evaluation import Evaluation, room
from lagrange_cli.native.families.joints.contacts import JointContacts
from lagrange_cli.native.families.joints.sweeps import Sweeps
from lagrange_cli.native.families.tables import place_at
from lagrange_cli.native.linear.lu import factor_general, solve_general
from lagrange_cli.native.llvm.vector import Bit, Index, Integer, Pointer
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.records import dataclass

FACTOR, SOLVE = "factor_general", "solve_general"
"""The functions of ``linear.lu``."""
REFINED = 2
"""Solutions of numbers of two parts, in doubles, of what the ones before have left."""


@dataclass(frozen=True)
class Places:
    """Where the place of each contact among those that hold is in ``%work``, and their list, their number,
    their matrix and their right side."""

    order: int
    listed: int
    number: int
    matrix: int
    right: int


def eliminations(text: str) -> str:
    """The functions of eliminations that a program's text calls."""
    return "".join(
        f(Emitter) for f, name in ((factor_general, FACTOR), (solve_general, SOLVE)) if name in text
    )


class Pressing:
    """The forces of contacts in a ``jet``."""

    def __init__(self, jet: CorrectedJet, touch: JointContacts) -> None:
        self.jet, self.touch, self.vectors = jet, touch, jet.vectors
        self.sweeps: Sweeps | None = None
        count, taken = touch.count, jet.take
        self.regular: Bit | None = None
        if not touch.alone:
            sizes = (count, count, 1, count * (count + 1), count)
            self.places = Places(*(taken(room(size)) for size in sizes))

    def press(self, evaluation: Evaluation, *, first: bool) -> list[Bit]:
        """Their forces, and accelerations with these; in the ``first`` order, whether the equations are
        regular."""
        touch, found = self.touch, list[Bit]()
        if first:
            evaluation.write([touch.square])
            if not touch.alone:
                found.append(self._factor(evaluation))
        self._write(evaluation, touch.reaching.early, [touch.early], [touch.known])
        if touch.reaching.any:
            self._carry(evaluation, touch.ahead)
        evaluation.write([touch.right])
        if touch.divided is not None:
            evaluation.write([touch.divided])
        else:
            self._solve(evaluation)
        self._write_newest(evaluation)
        self._write(evaluation, touch.reaching.whole, [touch.pushed], [touch.rates])
        if touch.of_sums:
            self._write(evaluation, [touch.on_joints], [touch.of_joints], touch.of_sums)
        return found

    def move_nodes(self, evaluation: Evaluation) -> None:
        """What contacts add to the accelerations of nodes."""
        self._carry(evaluation, self.touch.moved, self.touch.balance.accelerations)

    def _write(self, evaluation: Evaluation, *several: Sequence[Total]) -> None:
        """Compute some totals after others."""
        for some in several:
            evaluation.write(self.jet.moving(some))

    def _write_newest(self, evaluation: Evaluation) -> None:
        """What the newest forces add."""
        reaching = self.touch.reaching
        self._write(evaluation, *reaching.pulls, reaching.newest, [self.touch.newest])

    def _carry(
        self, evaluation: Evaluation, steps: Sequence[Total], moved: Sequence[Array | None] = ()
    ) -> None:
        """Add steps of nodes up along trees, and to what is ``moved``."""
        assert self.sweeps is not None
        self._write(evaluation, steps)
        self.sweeps.carry(steps, moved or [None] * len(steps))

    def _write_column(self, evaluation: Evaluation) -> None:
        """dg/dq d N."""
        self._write_newest(evaluation)
        if self.touch.reaching.any:
            self._carry(evaluation, self.touch.swings)
        evaluation.write([self.touch.column])

    def _at(self, place: int) -> Pointer:
        return self.jet.f.place("%work", place, "double")

    def _held(self) -> Integer:
        """How many contacts hold."""
        return self.jet.f.load_integer(self._at(self.places.number))

    def _listed(self, i: Index) -> Integer:
        """The contact number ``i`` of those that hold."""
        return self.jet.f.load_integer(self._at(self.places.listed), i)

    def _factor(self, evaluation: Evaluation) -> Bit:
        """List the contacts that hold, and factor their matrix; whether it is regular."""
        f, vectors, touch, places = self.jet.f, self.vectors, self.touch, self.places
        modes, held = evaluation.where(touch.contact.signs), f.variable(f.count(0))
        order, listed, matrix = (self._at(one) for one in (places.order, places.listed, places.matrix))
        with f.loop(0, touch.count, tested=False) as i:
            f.store(f.count(touch.count), order, i)
            with f.when(f.magnitude(vectors.high(vectors.load(modes, i))) > 0.0):
                f.store(held.get(), order, i)
                f.store(i, listed, held.get())
                held.set(held.get() + 1)
        number, regular = held.get(), f.variable(Bit(f, "true", 1))
        f.store(number, self._at(places.number))
        with f.when(number > 0):
            with f.loop(0, number * number, tested=False) as at:
                f.store(f.constant(0.0), matrix, at)
            if touch.reaching.any:
                self._by_columns(evaluation, number, matrix)
            else:
                self._by_entries(evaluation, number, matrix)
            regular.set(f.call(Bit, FACTOR, matrix, number, lanes=1))
        return regular.get()

    def _by_entries(self, evaluation: Evaluation, number: Integer, matrix: Pointer) -> None:
        """The matrix, where most entries are 0."""
        f, vectors, touch = self.jet.f, self.vectors, self.touch
        tables = [self.jet.tables.of_array(one) for one in touch.pairs]
        square, order = evaluation.where(touch.square), self._at(self.places.order)
        with f.loop(0, touch.pairs.shape[1], tested=False) as e:
            row, column = (f.load_integer(order, place_at(f, e + table)) for table in tables)
            with f.when(row < touch.count), f.when(column < touch.count):
                f.store(vectors.high(vectors.load(square, e)), matrix, row * number + column)

    def _by_columns(self, evaluation: Evaluation, number: Integer, matrix: Pointer) -> None:
        """The matrix, by what each force does alone."""
        f, vectors, touch = self.jet.f, self.vectors, self.touch
        forces, column = (evaluation.where(one) for one in (touch.multipliers, touch.column))
        with f.loop(0, number, tested=False) as k:
            self._clear(forces)
            vectors.store(vectors.constant(1.0), forces, self._listed(k))
            self._write_column(evaluation)
            with f.loop(0, number, tested=False) as i:
                value = vectors.high(vectors.load(column, self._listed(i)))
                f.store(value, matrix, i * number + k)

    def _clear(self, forces: Pointer) -> None:
        with self.jet.f.loop(0, self.touch.count, tested=False) as i:
            self.vectors.store(self.vectors.constant(0.0), forces, i)

    def _solve(self, evaluation: Evaluation) -> None:
        """The forces, which are 0 where contacts do not hold."""
        f, vectors, touch = self.jet.f, self.vectors, self.touch
        forces, right = evaluation.where(touch.multipliers), evaluation.where(touch.right)
        self._clear(forces)
        number = self._held()
        with f.when(number > 0):
            self._add_solution(number, right, forces)
            for _ in range(REFINED * (vectors.parts - 1)):
                self._write_column(evaluation)
                evaluation.write([touch.left])
                self._add_solution(number, evaluation.where(touch.left), forces)

    def _add_solution(self, number: Integer, right: Pointer, forces: Pointer) -> None:
        f, vectors = self.jet.f, self.vectors
        matrix, to = self._at(self.places.matrix), self._at(self.places.right)
        with f.loop(0, number, tested=False) as i:
            f.store(vectors.high(vectors.load(right, self._listed(i))), to, i)
        f.call(None, SOLVE, matrix, to, number)
        with f.loop(0, number, tested=False) as i:
            at = self._listed(i)
            vectors.store(vectors.load(forces, at) + vectors.at(f.load(to, i)), forces, at)
