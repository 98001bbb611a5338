"""The forces of contacts that hold, if contacts may meet most others: equations of these alone.

Entries are added up contact by contact for those that hold: what others would have is never looked at.
"""

from __future__ import annotations

import numpy as np

from lagrange_cli.families.bonds import CoupledMembers
from lagrange_cli.native.families.constraints.contact_restraint import ContactRestraint
from lagrange_cli.native.families.constraints.dense import Dense
from lagrange_cli.native.families.evaluation import Evaluation
from lagrange_cli.native.families.tables import place_at
from lagrange_cli.native.llvm.flow import Variable
from lagrange_cli.native.llvm.vector import Bit, Integer
from lagrange_cli.native.state import whole_vectors


class HeldDense(Dense):
    """What solves for them, and for the multipliers of constraints."""

    def factor_held(self, motion: ContactRestraint, evaluation: Evaluation, regular: Variable[Bit]) -> None:
        """L and D of those that hold, and whether they are regular."""
        f, vectors = self.f, self.vectors
        self._list_held(motion, evaluation)
        number = self._number
        width = self.begin(number)
        self.clear("alone", f.count(whole_vectors(self.tabled.count)))
        for pair in motion.bonds.pairs[0]:
            self._add(motion, evaluation, pair, number, width)
        with f.loop(0, number) as k:
            vectors.store(vectors.load(self.row(k, width), k), self.place("diagonal"), k)
        self.eliminate(number, width, regular)

    def _list_held(self, motion: ContactRestraint, evaluation: Evaluation) -> None:
        f, order, listed = self.f, self.integers("order"), self.integers("listed")
        modes, fixed, number = evaluation.where(motion.contact.signs), motion.contact.fixed, f.count(0)
        if fixed:
            with f.loop(0, fixed, tested=False) as i:
                f.store(i, order, i)
                f.store(i, listed, i)
        found = f.variable(number + fixed)
        with f.loop(0, motion.contact.count, tested=False) as i:
            f.store(f.count(self.tabled.count), order, i + fixed)
            with f.when(~self.vectors.high(self.vectors.load(modes, i)).equals(0.0)):
                f.store(found.get(), order, i + fixed)
                f.store(i + fixed, listed, found.get())
                found.set(found.get() + 1)
        f.store(found.get(), self.integers("number"))

    def _add(
        self, motion: ContactRestraint, evaluation: Evaluation, pair: CoupledMembers, number: Integer,
        width: Integer,
    ) -> None:  # fmt: skip
        """The products of two slopes of those that hold."""
        f, vectors, order = self.f, self.vectors, self.integers("order")
        slots = pair.first, pair.second
        both = [motion.bounds[b].numbers[some] for (b, _), some in zip(slots, pair.members)]
        each = np.arange(self.tabled.count)
        first = np.argsort(both[0], kind="stable")
        numbers = both[0][first]
        begin, end = (np.searchsorted(numbers, each, side) for side in ("left", "right"))
        listed = begin, end, both[1][first], pair.rows[first], *(some[first] for some in pair.members)
        begins, ends, others, rows, *members = map(self.tables.of_array, listed)
        slopes = [evaluation.where(motion.slopes[b][a]) for b, a in slots]
        inverses = evaluation.where(motion.lasting.inverses)
        with f.loop(0, number) as k:
            i = self._listed(k)
            with f.loop(place_at(f, i + begins), place_at(f, i + ends)) as t:
                other = f.load_integer(order, place_at(f, t + others))
                with f.when(other < self.tabled.count):
                    value = self.everywhere(vectors.load(inverses, place_at(f, t + rows)))
                    for slope, member in zip(slopes, members):
                        one = vectors.load(slope, place_at(f, t + member))
                        value = vectors.kind.mul(value, self.everywhere(one))
                    place = self.place("matrix", other * width + k)
                    total = vectors.kind.add(value, self.everywhere(vectors.load(place)))
                    vectors.store(vectors.lane(vectors.number(total), 0), place)
