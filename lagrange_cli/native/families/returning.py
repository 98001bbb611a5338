"""``@project`` of a system of families: its arrays, and what writes it (see ``projection``)."""

from __future__ import annotations

from collections.abc import Sequence

from lagrange_cli.families.arrays import Array, Total
from lagrange_cli.families.contacts import Coupled
from lagrange_cli.native.families.constraints.impulses import HEAD as PUSHES
from lagrange_cli.native.families.constraints.impulses import Impulse, Impulses
from lagrange_cli.native.families.constraints.moves import Moves, MovesTogether
from lagrange_cli.native.families.constraints.projection import Projection
from lagrange_cli.native.families.evaluation import Evaluation, LowParts, room
from lagrange_cli.native.families.first_order import project_velocities
from lagrange_cli.native.families.joints.closed import ClosedJet
from lagrange_cli.native.families.joints.closed_projection import ClosedProjection, Residuals
from lagrange_cli.native.families.loops import needed
from lagrange_cli.native.families.resting import AtRest
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Pointer
from lagrange_cli.native.state import Clock
from lagrange_cli.native.stepping.projection import HEAD
from lagrange_cli.records import replace


class Returning(AtRest):
    """The function that takes the state back to the constraints."""

    def projection(self) -> str:
        """``@project``, if the state has to satisfy something; its arrays are the next ones."""
        if self.residuals is not None:
            return self.closed_projection(self.residuals)
        if self.velocities is not None:
            return self.first_order_projection(self.velocities)
        if self.moves is None:
            return ""
        evaluation, scratch = self.at_a_place(Function(HEAD), self.moves, self.moves.arrays)
        return Projection(self.moves, evaluation, self.layout, self.tabled, self.factors, scratch).text()

    @property
    def joined(self) -> tuple[int, ...]:
        """What moves together after simple actions, if compiled code follows impacts at one time
        (``Interface.joined``): what constraints couple that have impulses then, or each coordinate alone."""
        if self.impulses is not None:
            return self.impulses.joined
        touches = isinstance(self.contact, Coupled) and self.motion is not None and self.nearing
        simple = self.events is not None and self.events.simple.any()
        return tuple(range(self.degrees)) if touches and simple else ()

    def push(self) -> str:
        """``@push``, if compiled code carries out impacts after which constraints have impulses; its arrays
        are the next ones."""
        if self.impulses is None or self.events is None:
            return ""
        evaluation, scratch = self.at_a_place(Function(PUSHES), self.impulses, self.impulses.arrays)
        changed = self.events.changed
        return Impulse(self.impulses, evaluation, self.layout, self.tabled, changed, scratch).text()

    def at_a_place(
        self, f: Function, moves: Moves | MovesTogether | Impulses, listed: Sequence[Array]
    ) -> tuple[Evaluation, Pointer]:
        """What computes totals of constraints at a state, with room for what is ``listed``; and room for
        what solves with them."""
        layout, vectors = self.layout, self.kind(f)
        base = self.scratch(vectors)
        state = self.state(f)
        arrays = {array: vectors.in_state(place, layout.width) for array, place in state.items()}
        arrays |= self.arrays(vectors, base, listed)
        if isinstance(moves, MovesTogether):
            arrays[moves.multipliers] = vectors.place(arrays[moves.moved], self.degrees)
            arrays |= {back: arrays[one] for one, back in moves.backs.items()}
        time, low = (f.load("%state", layout.at(one)) for one in (Clock.TIME, Clock.TIME_LOW))
        evaluation = self.evaluation(vectors, arrays, vectors.at(time, low))
        lower = {array: f.place(place, layout.width, "double") for array, place in state.items()}
        parts = LowParts(lower, f.splat(low, LANES).name, evaluation.where)
        scratch = self.taken(vectors, base, room(self.tabled.size))
        return replace(evaluation, low=parts), scratch

    def first_order_projection(self, velocities: Total) -> str:
        """The same where velocities follow from places."""
        assert self.system.first_order is not None
        f, layout = Function(HEAD), self.layout
        vectors, state = self.kind(f), self.state(f)
        base = self.scratch(vectors)
        totals = needed([velocities], self.slots, self.lasting.fixed)
        arrays = {array: vectors.in_state(place, layout.width) for array, place in state.items()}
        arrays |= self.arrays(vectors, base, totals)
        time, low = (f.load("%state", layout.at(one)) for one in (Clock.TIME, Clock.TIME_LOW))
        evaluation = self.evaluation(vectors, arrays, vectors.at(time, low))
        rows = self.system.first_order.rows.tolist()
        return project_velocities(evaluation, totals, velocities, rows, layout)

    def closed_projection(self, residuals: Residuals) -> str:
        """The same of chains and trees."""
        jet, _ = self.at_a_state
        assert isinstance(jet, ClosedJet)
        f, layout = Function(HEAD), self.layout
        vectors = self.kind(f)
        base = self.scratch(vectors)
        places = self.system.q, self.system.v, residuals.low_q, residuals.low_v
        rows = 0, self.degrees, layout.width, layout.width + self.degrees
        arrays = {one: f.place("%state", row, "double") for one, row in zip(places, rows)}
        for one in places[:2]:
            arrays[one] = vectors.in_state(arrays[one], layout.width)
        for array in residuals.arrays:
            if array not in self.lasting.fixed:
                arrays[array] = self.taken(vectors, base, room(array.count + 1))
        work = self.taken(vectors, base, jet.work)
        time, low = (f.load("%state", layout.at(one)) for one in (Clock.TIME, Clock.TIME_LOW))
        evaluation = self.evaluation(vectors, arrays, vectors.at(time, low))
        fixed = frozenset(self.lasting.fixed)
        projection = ClosedProjection(residuals, evaluation, layout, jet, work, time, low, fixed)
        return projection.text()
