"""``@observe`` of a system of families, and other functions of quantities at samples."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import product

from lagrange_cli.families.arrays import Total
from lagrange_cli.native.families.arrangement import Element
from lagrange_cli.native.families.constraints.equations import Pulled
from lagrange_cli.native.families.constraints.together_jet import solved_at_a_state
from lagrange_cli.native.families.evaluation import room
from lagrange_cli.native.families.loops import needed
from lagrange_cli.native.families.resting import AtRest
from lagrange_cli.native.families.vectors import beside_doubles
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Integer
from lagrange_cli.native.numbers.beside import RoundedLanes
from lagrange_cli.records import dataclass


@dataclass(frozen=True)
class Run:
    """``count`` observed quantities, every ``step``-th one from number ``row`` on: those from ``start`` on
    in a total."""

    row: int
    step: int
    total: Total
    start: int
    count: int


def runs_of(observed: Iterable[tuple[Total, int]]) -> list[Run]:
    """The runs of quantities, given where each of them is."""
    found: list[tuple[Total, list[int]]] = []
    latest: dict[Total, list[int]] = {}
    for row, (total, index) in enumerate(observed):
        if total in latest:
            first, step, start, count = latest[total]
            step = step if count > 1 else row - first
            if start + count == index and first + count * step == row:
                latest[total][1:] = step, start, count + 1
                continue
        latest[total] = [row, 1, index, 1]
        found.append((total, latest[total]))
    return [Run(row, step, total, start, count) for total, (row, step, start, count) in found]


OBSERVE = "observe"
"""The function that computes outputs."""


class Observation(AtRest):
    """The functions that compute outputs, and what actions need."""

    def values(
        self, name: str, listed: Iterable[Element], roots: Sequence[Total], pulled: Pulled | None = None
    ) -> tuple[str, int]:
        """A function of that name: quantities that are ``listed``, of totals at the ``roots``, at each of
        ``%count`` samples; and its operations. Multipliers are found as they are ``pulled``."""
        head = "ptr noalias %constants, ptr noalias %times, ptr noalias %states, ptr noalias %results"
        f = Function(f"define void @{name}({head}, i64 %stride, i64 %count) #0")
        stride, kind = Integer(f, "%stride", 1), self.kind
        if self.factor is not None and name == OBSERVE:
            kind = beside_doubles(self.factor, RoundedLanes)
        vectors = kind(f)
        base = self.scratch(vectors)
        first = [] if pulled is None else [pulled.square, pulled.right]
        known = needed(first, self.slots, self.lasting.fixed)
        totals = [one for one in needed(roots, self.slots, self.lasting.fixed) if one not in known]
        arrays = self.arrays(vectors, base, (self.system.q, self.system.v, *known, *totals))
        arrays.update(self.placed_together(vectors, base, pulled))
        solved = self.solved(totals)
        resting = self.room_at_rest(vectors, base) if solved else None
        totals = [one for one in totals if one not in solved]
        scratch = vectors.place(base, self.size)
        at = {id(array): place for array, place in arrays.items()}
        changed = self.lasting.changed
        listed = [*listed]
        runs, count = runs_of((changed[total], index) for total, index in listed), len(listed)
        operations = 0
        with f.loop(0, Integer(f, "%count", 1)) as sample:
            for part, k in product(range(vectors.parts), range(2)):
                target = vectors.parts_at(at[id((self.system.q, self.system.v)[k])], part)
                before = k * self.degrees + part * self.sample_rows
                with f.loop(0, self.degrees, tested=False) as i:
                    row = stride * (i + before if before else i) + sample
                    f.store(f.load("%states", row), target, i)
            evaluation = self.evaluation(vectors, arrays, vectors.at(f.load("%times", sample)))
            if pulled is not None:
                evaluation.write(known)
                solved_at_a_state(evaluation, pulled, self.tabled, self.factors, scratch)
                self.size += room(self.tabled.size)
                totals = [one for one in totals if one not in pulled.found]
            if resting is not None:
                self.solve_at_rest(evaluation, resting, sample, stride, solved)
            evaluation.write(totals)
            for part, run in product(range(vectors.parts), runs):
                source = vectors.parts_at(evaluation.where(run.total), part)
                place = run.row + part * count
                with f.loop(0, run.count, tested=False) as i:
                    value = f.load(source, i + run.start if run.start else i)
                    f.store(value, "%results", stride * (i * run.step + place) + sample)
            operations = evaluation.emitter.operations
        f.give()
        return f.text(), operations
