"""Where the functions of a program of families have their arrays: those that last, and room for others."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

from lagrange_cli.families.arrays import Array, Source
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.native.families.constraints.equations import Pulled
from lagrange_cli.native.families.constraints.restraint import AtAState
from lagrange_cli.native.families.constraints.together import TogetherAtAState
from lagrange_cli.native.families.evaluation import Evaluation, room
from lagrange_cli.native.families.tables import Tables
from lagrange_cli.native.families.vectors import Numbers, Vectors
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Pointer
from lagrange_cli.native.recurrences.evaluation import Constants


class Scratch:
    """The arrays behind the constants of a ``system``, so many doubles (``size``)."""

    def __init__(self, system: FamilySystem) -> None:
        self.system, self.slots, self.degrees = system, system.slots, system.q.count
        self.tables = Tables(Constants())
        self.size = 0
        self.places: dict[Array, int] = {}
        """Where arrays are that last, from the beginning of scratch in ``%constants``."""

    def place(self, array: Array, count: int) -> None:
        """Find a place for an array that lasts."""
        self.places[array] = self.size
        self.size += room(count)

    @property
    def largest(self) -> int:
        """How many whole numbers are needed."""
        listed = [one.table for one in self.slots.of.values() if one.array.source is Source.WHOLE]
        return 1 + max((int(table.max()) for table in listed), default=0)

    def scratch(self, vectors: Vectors) -> Pointer:
        """Where arrays begin in ``%constants``."""
        return vectors.place("%constants", vectors.f.load_integer("@scratch"))

    def taken(self, vectors: Vectors, base: Pointer, doubles: int) -> Pointer:
        """The next doubles of scratch, which begins at ``base``."""
        self.size += doubles
        return vectors.place(base, self.size - doubles)

    def spare(self, doubles: int) -> Callable[[Vectors], Pointer]:
        """Room for so many doubles that callers do not clear: where it is."""
        self.size += doubles
        at = self.size - doubles
        return lambda vectors: vectors.place(self.scratch(vectors), at)

    def arrays(self, vectors: Vectors, base: Pointer, listed: Iterable[Array]) -> dict[Array, Pointer]:
        """Places for these, the next ones."""
        return {one: self.taken(vectors, base, room(one.count)) for one in listed}

    def state(self, f: Function) -> dict[Array, Pointer]:
        """Where coordinates and velocities of a state are."""
        return {self.system.q: f.pointer("%state"), self.system.v: f.place("%state", self.degrees, "double")}

    def evaluation(self, vectors: Vectors, arrays: Mapping[Array, Pointer], time: Numbers) -> Evaluation:
        """What computes totals, where some arrays are besides those that last."""
        base = self.scratch(vectors)
        places = {array: vectors.place(base, at) for array, at in self.places.items()}
        places.update(arrays)
        return Evaluation(
            vectors, self.slots, places.__getitem__, self.tables,
            {self.system.time: vectors.operand(vectors.splat(time, LANES))},
        )  # fmt: skip

    def placed_together(
        self, vectors: Vectors, base: Pointer, pulled: Pulled | None
    ) -> Mapping[Array, Pointer]:
        """Where accelerations and multipliers are that are found together: the next arrays of scratch."""
        if pulled is None or isinstance(pulled, AtAState):
            return {}
        solution = self.taken(vectors, base, room(pulled.solution.count))
        places = solution, solution, vectors.place(solution, self.degrees)
        backs = pulled.backs.values() if isinstance(pulled, TogetherAtAState) else ()
        return {**dict(zip((pulled.solution, *pulled.found), places)), **dict.fromkeys(backs, solution)}
