"""Work on one evaluation that several threads share.

It is cut into strips, which threads take in their order; each goes through its columns from the first to the
last, behind the strip before it (a pipelined wavefront). Strips and columns follow from the system alone, and
so does the order in which numbers are added, however many threads there are and whoever is faster.

The thread that steps the motion announces an evaluation on the *board* (``native.board``) in
``%constants``, takes strips as the others do, and goes on when the last one is complete. So it never waits
for a thread that has not begun. The others run ``@help``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

from lagrange_cli.native.board import LINE, Board
from lagrange_cli.native.families.spans import Span, smaller
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.records import dataclass

ARGUMENTS = "ptr %constants, double %t, ptr %state, ptr %work"
STRIP = f"define internal void @strip{{}}({ARGUMENTS}, i64 %strip, i64 %tag) #0"
EVERYWHERE = 1 << 40
"""A column behind all others."""
HALF = 32
"""A number of strips or columns is in the lower bits, that of the evaluation in the upper ones."""
PATIENCE = 2**9
"""Looks at what another thread is doing until the processor is offered to others."""
IDLE = 2**16
"""Looks at an empty board until ``@help`` returns."""


@dataclass(frozen=True)
class Part:
    """Work in so many strips, of use for so many threads. A strip is complete when it has come to the last
    one of its columns; ``all_count`` tells whether each has to be looked at, or the last one is complete
    last."""

    strips: int
    threads: int
    columns: int = 1
    all_count: bool = True


@dataclass(frozen=True)
class Tiles:
    """So many ``rows`` in strips of ``height``, cut into ``columns`` of ``width``. ``@tile`` computes some
    rows between two columns, with so many doubles ``kept`` for each row."""

    rows: int
    height: int
    columns: int
    width: int
    kept: int

    @property
    def part(self) -> Part:
        """As a part of an evaluation."""
        strips = -(-self.rows // self.height)
        return Part(strips, strips, self.columns, all_count=False)


@dataclass(frozen=True)
class Pieces:
    """Strips that do not depend on one another: ``height`` rows each, from ``first`` to before ``last``.
    ``@strip`` computes one, and leaves numbers on its lines of the board."""

    first: int
    last: int
    height: int

    @property
    def strips(self) -> int:
        """How many there are."""
        return -(-(self.last - self.first) // self.height)

    def left(self, f: Function, board: Pointer, strip: Integer) -> Pointer:
        """Where a strip leaves numbers."""
        return f.place(line(f, board, strip), 1, "double")


class Where(Protocol):
    """Gives the place of the board, where constants are ``%constants`` or elsewhere."""

    def __call__(self, f: Function, constants: Pointer | None = None, /) -> Pointer: ...


@dataclass(frozen=True)
class Strip:
    """A strip in the function that computes it; ``at`` is its place on the board, and ``tag`` the number of
    the evaluation."""

    f: Function
    at: Pointer
    strip: Integer
    tag: Integer


class Parts:
    """What threads share in a program; ``board`` gives the place of the board."""

    def __init__(self, board: Where) -> None:
        self.board = board
        self.listed: list[Part] = []
        self.tiles: dict[int, Tiles] = {}
        self.texts: list[str] = []

    def strip(self, f: Function) -> Strip:
        """The strip that such a function computes."""
        strip, tag = (Integer(f, name, 1) for name in ("%strip", "%tag"))
        return Strip(f, line(f, self.board(f), strip), strip, tag)

    def add(self, part: Part | Tiles, text: str) -> int:
        """A further one, with the text of ``@tile`` or ``@strip`` that is given; its number."""
        number = len(self.listed)
        if isinstance(part, Tiles):
            self.tiles[number] = part
        self.listed.append(part.part if isinstance(part, Tiles) else part)
        self.texts.append(text)
        return number

    def add_pieces(self, pieces: Pieces, write: Callable[[Function, Span], Sequence[Real]]) -> int:
        """Pieces, of which some rows are written, with the numbers that they leave; their number among the
        parts."""
        f = Function(STRIP.format(len(self.listed)))
        first = Integer(f, "%strip", 1) * pieces.height + pieces.first
        made = self.strip(f)
        numbers = write(f, (first, smaller(f, first + pieces.height, f.count(pieces.last))))
        assert len(numbers) < LINE
        for i, one in enumerate(numbers, 1):
            f.store(one, made.at, i)
        f.publish(made.tag + 1, made.at)
        f.give()
        return self.add(Part(pieces.strips, pieces.strips), f.text())

    @property
    def threads(self) -> int:
        """How many of them are of use."""
        bounded = [one.threads for one in self.listed if not one.all_count]
        return min(bounded) if bounded else max((one.threads for one in self.listed), default=0)

    def text(self) -> str:
        """All functions."""
        return "".join([*self.texts, *sharing(self)]) if self.listed else ""


def board_size(parts: Sequence[Part]) -> int:
    """Doubles of the board."""
    return Board.STRIPS + LINE * max(part.strips for part in parts)


def line(f: Function, board: Pointer, strip: Integer) -> Pointer:
    """Where the lines of a strip are."""
    return f.place(board, strip * LINE + int(Board.STRIPS), "double")


def sharing(parts: Parts) -> list[str]:
    """The functions, ``@share<i>`` for part i, of which ``@tile<i>`` is given, or ``@strip<i>``."""
    board = parts.board
    texts = [_wait(board), _take(len(parts.listed), board), _help(board)]
    for i, part in enumerate(parts.listed):
        tiles = parts.tiles.get(i)
        if tiles is not None:
            texts.append(_strip(parts, i, tiles))
        texts.append(_share(i, part, tiles, board))
    return texts


def given(f: Function) -> tuple[Pointer, Real, Pointer, Pointer]:
    """The ``ARGUMENTS``."""
    return f.pointer("%constants"), Real(f, "%t", 1), f.pointer("%state"), f.pointer("%work")


def _share(number: int, part: Part, tiles: Tiles | None, board: Where) -> str:
    """``@share``: the whole part, by this thread and by those that help."""
    f = Function(f"define internal void @share{number}({ARGUMENTS}) #0")
    at = board(f)
    if tiles is not None:
        with f.when(f.load_integer(at, Board.HELPERS).equals(0)):
            ends = f.count(0), f.count(tiles.rows), f.count(0), f.count(EVERYWHERE)
            f.call(None, f"tile{number}", *given(f), *ends, Pointer(f, "null", 1))
            f.give()
    _, *job = given(f)
    for place, value in zip((Board.TIME, Board.STATE, Board.WORK), job):
        f.store(value, at, place)
    f.store(f.count(number), at, Board.PART)
    f.store(f.count(part.strips), at, Board.COUNT)
    before = f.load_integer(at, Board.LEFT)
    tag = (before.operation("lshr", HALF) + 1) << HALF
    f.publish(tag + part.strips, at, Board.LEFT)
    f.call(Bit, "take", f.pointer("%constants"))
    first = 0 if part.all_count else part.strips - 1
    with f.loop(first, part.strips, tested=False) as strip:
        f.call(None, "wait", f.pointer("%constants"), line(f, at, strip), tag + part.columns)
    f.give()
    return f.text()


def _take(parts: int, board: Where) -> str:
    """``@take``: compute strips until none is left; whether there was one."""
    f = Function("define internal i1 @take(ptr %constants) #0")
    at, found = board(f), f.variable(Bit(f, "false", 1))
    with f.forever() as strips:
        seen = f.observe(at, Board.LEFT)
        left = seen & ((1 << HALF) - 1)
        with f.when(left.equals(0)):
            f.give(found.get())
        with f.when(~f.replace(seen, seen - 1, at, Board.LEFT)):
            strips.go_on()
        found.set(Bit(f, "true", 1))
        time = f.load(at, Board.TIME)
        state, work = (f.load_pointer(at, one) for one in (Board.STATE, Board.WORK))
        strip = f.load_integer(at, Board.COUNT) - left
        tag = seen.operation("lshr", HALF) << HALF
        which = f.load_integer(at, Board.PART)
        for i in range(parts):
            with f.when(which.equals(i)):
                f.call(None, f"strip{i}", f.pointer("%constants"), time, state, work, strip, tag)
    return f.text()


def _strip(parts: Parts, number: int, part: Tiles) -> str:
    """``@strip``: one strip, column by column."""
    f = Function(STRIP.format(number))
    kept = Pointer(f, f.define(f"alloca double, i64 {max(1, part.height * part.kept)}, align 64"), 1)
    made = parts.strip(f)
    at, strip, tag = made.at, made.strip, made.tag
    first = strip * part.height
    last = f.select(f.count(part.rows) > first + part.height, first + part.height, f.count(part.rows))
    with f.loop(0, part.columns, tested=False) as column:
        done = tag + column + 1
        with f.when(strip > 0):
            f.call(None, "wait", f.pointer("%constants"), f.place(at, -LINE, "double"), done)
        left = column * part.width
        right = f.select(column.equals(part.columns - 1), f.count(EVERYWHERE), left + part.width)
        f.call(None, f"tile{number}", *given(f), first, last, left, right, kept)
        f.publish(done, at)
    f.give()
    return f.text()


def _wait(board: Where) -> str:
    """``@wait``: until a number on the board has become ``%least``."""
    f = Function("define internal void @wait(ptr %constants, ptr %place, i64 %least) #0")
    looks = f.variable(f.count(0))
    with f.forever():
        with f.when(f.observe("%place") >= Integer(f, "%least", 1)):
            f.give()
        looks.set(looks.get() + 1)
        with f.when((looks.get() & (PATIENCE - 1)).equals(0)):
            place = f.place(board(f), Board.YIELD, "ptr")
            f.define(f"call i32 {f.define(f'load ptr, ptr {place.name}, align 8')}()")
    return f.text()


def _help(board: Where) -> str:
    """``@help``: take part in evaluations. Returns 1 if there has been none for a while, or no help is
    wanted, and 0 at the end."""
    f = Function("define i64 @help(ptr %constants) #0")
    at, looks = board(f), f.variable(f.count(0))
    with f.forever():
        with f.when(~f.observe(at, Board.HALT).equals(0)):
            f.give(f.count(0))
        with f.when(f.observe(at, Board.HELPERS).equals(0)):
            f.give(f.count(1))
        worked = f.call(Bit, "take", f.pointer("%constants"))
        looks.set(f.select(worked, f.count(0), looks.get() + 1))
        with f.when(looks.get() > IDLE):
            f.give(f.count(1))
    return f.text()
