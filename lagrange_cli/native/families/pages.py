"""What a page calls besides the program of a system of families: where what is drawn is at states, and the
initial values for other parameters.

The functions come beside a program, so the names in their texts are their own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Array, Source, Total
from lagrange_cli.families.values import Described
from lagrange_cli.native.families.evaluation import Evaluation, room
from lagrange_cli.native.families.everywhere import put_scalars
from lagrange_cli.native.families.loops import needed
from lagrange_cli.native.families.tables import Tables
from lagrange_cli.native.families.vectors import DoubleVectors
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Integer, Pointer
from lagrange_cli.native.recurrences.evaluation import Constants
from lagrange_cli.native.state import whole_vectors
from lagrange_cli.spec.content import names_of

PLACES = "@places"
"""The table of a program, which has another name here."""


def write_placing(system: Described, axes: Sequence[Total]) -> tuple[str, int]:
    """``@place`` and ``@prepare_place``, and the doubles of constants that they take.

    ``@place(constants, times, states, results, stride, count)`` puts the components of all points, one point
    after the other, into rows of ``results``, a column for each of ``count`` samples; states have rows, too.
    """
    writer = _Writer(system, axes, "points")
    return writer.text([writer.place(), writer.prepare()]), writer.room


def write_deriving(
    system: Described, parameters: Mapping[str, Node], given: Sequence[Node], state: Sequence[Total]
) -> tuple[str, int]:
    """``@derive``, and the doubles that it fills: what is ``given`` of each parameter, as an expression in
    ``parameters``, and the ``state`` behind it; the rest is scratch."""
    writer = _Writer(system, state, "state")
    before = whole_vectors(len(given) + sum(one.count for one in state))
    return writer.text(writer.derive(parameters, given, before)), before + writer.room


class _Writer:
    """The functions that compute some totals, and where their arrays are: behind the constants."""

    def __init__(self, system: Described, roots: Sequence[Total], name: str) -> None:
        self.system, self.roots, self.name = system, roots, name
        self.scratch = f"@scratch_of_{name}"
        self.tables = Tables(Constants())
        self.totals = needed(roots, system.slots)
        whole = [one for one in system.slots.of.values() if one.array.source is Source.WHOLE]
        self.largest = 1 + max((int(one.table.max()) for one in whole), default=0)
        self.places: dict[Array, int] = dict.fromkeys((one.array for one in whole), 0)
        self.size = room(self.largest)
        for array in (system.given, system.q, *self.totals):
            self.places[array] = self.size
            self.size += room(array.count)

    @property
    def room(self) -> int:
        """Doubles for all."""
        return self.tables.scalars + self.size

    def text(self, functions: Sequence[str]) -> str:
        """The text of functions, with their tables."""
        text = "".join([*functions, self.tables.text()])
        for end in (",", " "):
            text = text.replace(f"{PLACES}{end}", f"{PLACES}_of_{self.name}{end}")
        return f"{text}{self.scratch} = private constant i64 {self.tables.scalars}\n"

    def arrays(self, vectors: DoubleVectors, constants: Pointer | str) -> dict[Array, Pointer]:
        """Where arrays are."""
        base = vectors.place(constants, vectors.f.load_integer(self.scratch))
        return {array: vectors.place(base, first) for array, first in self.places.items()}

    def place(self) -> str:
        """``@place``."""
        system, degrees = self.system, self.system.q.count
        head = "ptr noalias %constants, ptr noalias %times, ptr noalias %states, ptr noalias %results"
        f = Function(f"define void @place({head}, i64 %stride, i64 %count) #0")
        stride, vectors = Integer(f, "%stride", 1), DoubleVectors(f)
        at = self.arrays(vectors, "%constants")
        with f.loop(0, Integer(f, "%count", 1)) as sample:
            with f.loop(0, degrees, tested=False) as i:
                f.store(f.load("%states", stride * i + sample), at[system.q], i)
            time = vectors.operand(vectors.splat(f.load("%times", sample), LANES))
            evaluation = Evaluation(vectors, system.slots, at.__getitem__, self.tables, {system.time: time})
            evaluation.write(self.totals)
            for k, axis in enumerate(self.roots):
                with f.loop(0, axis.count, tested=False) as i:
                    row = stride * (i * len(self.roots) + k) + sample
                    f.store(f.load(at[axis], i), "%results", row)
        f.give()
        return f.text()

    def prepare(self) -> str:
        """``@prepare_place``."""
        f = Function("define void @prepare_place(ptr noalias %parameters, ptr noalias %constants) #0")
        self.begin(DoubleVectors(f), f.pointer("%constants"))
        f.give()
        return f.text()

    def begin(self, vectors: DoubleVectors, constants: Pointer) -> None:
        """Fill in parameters, whole numbers, and constants that are no arrays."""
        f, system = vectors.f, self.system
        base = vectors.place(constants, f.load_integer(self.scratch))
        given = vectors.place(base, self.places[system.given])
        with f.loop(0, system.given.count) as i:
            f.store(f.load("%parameters", i), given, i)
        with f.loop(0, self.largest, tested=False) as i:
            f.store(vectors.whole(i), base, i)
        self.put(vectors, system.parameters, [*self.tables.constants.slots.items()], constants)

    def put(
        self,
        vectors: DoubleVectors,
        parameters: Mapping[str, Node],
        nodes: Sequence[tuple[Node, int]],
        target: Pointer,
    ) -> None:
        """Compute expressions in parameters, each for its place."""
        symbols = [parameters.get(name) for name in names_of(self.system.spec.parameters)]
        put_scalars(vectors, symbols, self.system.given.count, nodes, target)

    def derive(self, parameters: Mapping[str, Node], given: Sequence[Node], before: int) -> list[str]:
        """``@derive``; constants are ``before`` doubles behind its results."""
        inner = Function("define internal void @derive_state(ptr noalias %constants) #0")
        one = DoubleVectors(inner)
        at = self.arrays(one, "%constants")
        Evaluation(one, self.system.slots, at.__getitem__, self.tables, {}).write(self.totals)
        inner.give()
        f = Function("define void @derive(ptr noalias %parameters, ptr noalias %results) #0")
        vectors = DoubleVectors(f)
        constants = vectors.place("%results", before)
        self.begin(vectors, constants)
        f.call(None, "derive_state", constants)
        at, first = self.arrays(vectors, constants), len(given)
        for total in self.roots:
            with f.loop(0, total.count, tested=False) as i:
                f.store(f.load(at[total], i), "%results", i + first)
            first += total.count
        self.put(vectors, parameters, [(node, i) for i, node in enumerate(given)], f.pointer("%results"))
        f.give()
        return [inner.text(), f.text()]
