"""``@prepare`` of a system of families: constants of the motion, and arrays of what lasts.

A companion has them with larger rounding errors (``numbers.beside``): computed once in doubles and once to
many digits, whose difference is made larger.
"""

from __future__ import annotations

from functools import cached_property

from lagrange_cli.families.arrays import Total
from lagrange_cli.native.companion import LONG, ONCE, put_beside
from lagrange_cli.native.families.arrangement import Arrangement
from lagrange_cli.native.families.double_double import BEHIND_CONSTANTS, BEHIND_WORK, beside_double_doubles
from lagrange_cli.native.families.everywhere import put_scalars
from lagrange_cli.native.families.series_places import JetSetting
from lagrange_cli.native.families.sharing import Parts
from lagrange_cli.native.families.vectors import DoubleVectors, Vectors
from lagrange_cli.native.functions.double_double import functions
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Pointer
from lagrange_cli.native.numbers.double_double import operations

BOARD = "@board"
"""Where the board is in scratch."""


class Preparation(Arrangement):
    """The functions that compute what lasts."""

    @cached_property
    def parts(self) -> Parts | None:
        """What threads share, if numbers are doubles and those of the run."""
        return Parts(self.board_of) if self.kind is DoubleVectors else None

    def setting(self, order: int) -> JetSetting:
        """What jets of this order need to know."""
        common = self.system, self.lasting, self.places, self.tables, self.layout
        # companions copy what is in scratch
        return JetSetting(*common, order, self.kind, self.spare if self.factor is None else None)

    def board_of(self, f: Function, constants: Pointer | None = None) -> Pointer:
        """Where the board is."""
        before = f.load_integer("@scratch") + f.load_integer(BOARD)
        return f.place(constants or "%constants", before, "double")

    def prepare(self) -> str:
        """``@prepare``: constants, and arrays that last."""
        if self.factor is None:
            texts = self.prepared("void @prepare", "@arrays", self.kind)
        else:
            once = self.prepared(f"internal void @{ONCE}", "@arrays", DoubleVectors)
            long = self.prepared(f"internal void @{LONG}", "@long_arrays", beside_double_doubles(self.factor))
            texts = [*operations(), *functions(), *once, *long, self.prepare_companion()]
        return "".join(texts)

    def prepare_companion(self) -> str:
        """``@prepare`` of a companion: constants to many digits are behind those that it needs."""
        f = Function("define void @prepare(ptr noalias %parameters, ptr noalias %constants) #0")
        size = f.load_integer(BEHIND_CONSTANTS)
        long = f.place("%constants", size, "double")
        f.call(None, ONCE, f.pointer("%parameters"), f.pointer("%constants"))
        f.call(None, LONG, f.pointer("%parameters"), long)
        with f.loop(0, f.count(self.tables.scalars + self.size), tested=False) as i:
            low = f.load(long, i + size)
            put_beside(f, i, f.load("%constants", i), f.load(long, i), low)
        f.give()
        return f.text()

    def prepared(self, name: str, arrays: str, kind: type[Vectors]) -> list[str]:
        """A function that computes constants and arrays that last, and the one of the ``arrays``."""
        f = Function(f"define {name}(ptr noalias %parameters, ptr noalias %constants) #0")
        vectors, count = kind(f), self.settings
        base = self.scratch(vectors)
        given = vectors.place(base, self.places[self.system.given])
        whole = vectors.place(base, self.places[self.system.whole])
        for part in range(vectors.parts):
            target = vectors.parts_at(given, part)
            with f.loop(0, self.system.given.count) as i:
                f.store(f.load("%parameters", i + part * count if part else i), target, i)
        with f.loop(0, self.largest, tested=False) as i:
            vectors.store(vectors.whole(i), whole, i)
        kept = [] if self.modes is None else [(self.modes.signs, len(self.parameters))]
        kept += [] if self.contact is None else [(self.contact.signs, self.sides)]
        for modes, first in kept:
            signs = vectors.place(base, self.places[modes])
            with f.loop(0, modes.count, tested=False) as i:
                vectors.store(vectors.at(f.load("%parameters", i + first)), signs, i)
        # arrays may need further constants, which are computed before them
        inner = Function(f"define internal void {arrays}(ptr noalias %constants) #0")
        one = kind(inner)
        evaluation = self.evaluation(one, {}, one.at(inner.constant(0.0)))
        evaluation.write([one for one in self.lasting.fixed if isinstance(one, Total)])
        if self.factors is not None:
            self.factors.factor(evaluation)
        inner.give()
        symbols = [self.system.parameters.get(name) for name in self.parameters]
        scalars = [*self.tables.constants.slots.items()]
        put_scalars(vectors, symbols, self.settings, scalars, "%constants")
        f.call(None, arrays[1:], f.pointer("%constants"))
        if self.strips:
            board = self.board_of(f)
            with f.loop(0, self.lines, LANES, tested=False) as i:
                f.store_row(f.zero(LANES), board, i)
        f.give()
        return [inner.text(), f.text()]


def low_parts(work: int, constants: int) -> str:
    """How far the low parts of numbers are behind."""
    behind = ((BEHIND_WORK, work), (BEHIND_CONSTANTS, constants))
    return "".join(f"{name} = private constant i64 {count}\n" for name, count in behind)
