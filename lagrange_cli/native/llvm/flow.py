"""``Flow``: control flow written as in a program, and given to LLVM as blocks with phis.

No pass of LLVM that takes variables from memory into registers is run. So this class finds out which value a
variable has where, while the code is written: M. Braun et al., Simple and Efficient Construction of Static
Single Assignment Form, Compiler Construction 2013, algorithms 1 to 4; phis of one value go at the end.
"""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from heapq import heapify, heappop, heappush
from typing import Generic, TypeVar

from lagrange_cli.native.llvm.text import kind
from lagrange_cli.native.llvm.vector import Bit, Index, Instructions, Integer, Value

V = TypeVar("V", bound=Value)
_PHI = re.compile(r"%p\d+(?![\w.])")
"""The names that ``_read`` gives: those of phis, and maybe others."""


class Block:
    """Instructions that follow one another; ``before``: the blocks that end with a jump to it."""

    def __init__(self, label: str) -> None:
        self.label = label
        self.lines: list[str] = []
        self.before: list[Block] = []
        self.sealed = False
        """Whether ``before`` is complete."""
        self.values: dict[Variable[Value], str] = {}
        self.phis: dict[Variable[Value], str] = {}
        self.to: list[Block] = []
        self.condition = ""
        self.ended = False


class Variable(Generic[V]):
    """Something that takes one value after another."""

    def __init__(self, function: Flow, like: V) -> None:
        self._function, self._like = function, like
        self.kind = like.kind
        self.set(like)

    def get(self, block: Block | None = None) -> V:
        """Its value here, or where a block begins in which it has not been set yet."""
        like = self._like
        return type(like)(like.body, self._function.read(self, block), like.lanes)

    def set(self, value: V) -> None:
        """Its value from here on."""
        self._function.here.values[self] = value.name  # type: ignore[index]


class Loop:
    """A loop that is being written."""

    def __init__(self, function: Flow, again: Block, after: Block) -> None:
        self._function, self._again, self._after = function, again, after

    def leave(self) -> None:
        """Go on behind the loop."""
        self._function.jump(self._after)

    def go_on(self) -> None:
        """Begin the next round."""
        self._function.jump(self._again)

    def repeat(self, condition: Bit) -> None:
        """Begin the next round where it holds, and go on behind the loop where not."""
        self._function.branch(condition, self._again, self._after)


class Flow(Instructions):
    """The blocks of one function. Instructions after the end of a block are dropped.

    In its ``head``, ``REAL`` and ``BIT`` stand for the types of numbers and conditions in all ``lanes``.
    """

    def __init__(self, head: str, lanes: int = 1) -> None:
        self._blocks: list[Block] = []
        self._open: Block | None = None
        """The block that ends with the condition of a ``when`` that has just been written."""
        self._joined: Block | None = None
        self._phis: list[tuple[Block, Variable[Value]]] = []
        """All phis, in the order in which they have been found necessary."""
        self._labels = 0
        self._entry = Block("entry")
        self._enter(self._entry)
        self._head = head.replace("REAL", kind("double", lanes)).replace("BIT", kind("i1", lanes))
        super().__init__(lanes)

    # blocks

    @property
    def here(self) -> Block:
        """The block that is being written."""
        self._settle()
        return self._current

    @property
    def lines(self) -> list[str]:
        """The instructions of the block that is being written."""
        return self.here.lines

    @lines.setter
    def lines(self, lines: list[str]) -> None:
        assert not lines

    def _enter(self, block: Block, sealed: bool = True) -> None:
        """Go on with a block; ``sealed``, if all jumps to it have been written."""
        self._blocks.append(block)
        self._current, block.sealed = block, sealed

    def _new(self) -> Block:
        self._labels += 1
        return Block(f"L{self._labels}")

    def _alive(self, block: Block) -> bool:
        return not block.ended and (block is self._entry or bool(block.before) or not block.sealed)

    def jump(self, to: Block) -> None:
        """End the block, and go on there."""
        here = self.here
        if self._alive(here):
            here.to = [to]
            to.before.append(here)
        here.ended = True

    def branch(self, condition: Bit, yes: Block, no: Block) -> None:
        """End the block, and go on at one or the other."""
        here = self.here
        if self._alive(here):
            here.to, here.condition = [yes, no], condition.name
            yes.before.append(here)
            no.before.append(here)
        here.ended = True

    # variables

    def variable(self, value: V) -> Variable[V]:
        """A variable with its first value."""
        return Variable(self, value)

    def read(self, variable: Variable[V], block: Block | None = None) -> str:
        """The name of its value here, or in that block so far."""
        return self._read(variable, block or self.here)  # type: ignore[arg-type]

    def _read(self, variable: Variable[Value], block: Block) -> str:
        passed: list[Block] = []
        while variable not in block.values and block.sealed and len(block.before) == 1:
            passed.append(block)
            block = block.before[0]
        name = block.values.get(variable)
        if name is None:
            if block.sealed and not block.before:
                return "poison"  # never reached
            name = f"%p{self._count}"
            self._count += 1
            block.values[variable] = block.phis[variable] = name
            self._phis.append((block, variable))
        for one in passed:
            one.values[variable] = name
        return name

    # control flow

    def _settle(self) -> None:
        """Go on behind a ``when`` to which no ``otherwise`` belongs."""
        if self._open is not None and self._joined is not None:
            joined = self._joined
            self._else(joined)
            self._enter(joined)

    def _else(self, to: Block) -> None:
        """Where the condition of the open ``when`` does not hold, go on there."""
        assert self._open is not None
        tested, self._open, self._joined = self._open, None, None
        if tested.to:
            tested.to[1] = to
            to.before.append(tested)

    @contextmanager
    def when(self, condition: Bit) -> Iterator[None]:
        """The code for where it holds; an ``otherwise`` may follow."""
        inside, joined, tested = self._new(), self._new(), self.here
        if self._alive(tested):
            tested.to, tested.condition = [inside, joined], condition.name
            inside.before.append(tested)
        tested.ended = True
        self._enter(inside)
        yield
        self.jump(joined)
        self._open, self._joined = tested, joined

    @contextmanager
    def otherwise(self) -> Iterator[None]:
        """The code for where the condition of the ``when`` just before does not hold."""
        if self._joined is None:
            raise ValueError("otherwise must follow a when")
        inside, joined = self._new(), self._joined
        self._else(inside)
        self._enter(inside)
        yield
        self.jump(joined)
        self._enter(joined)

    @contextmanager
    def loop(self, first: Index, last: Index, step: int = 1, tested: bool = True) -> Iterator[Integer]:
        """``i`` = first, first + step, .. below last; if not ``tested``, one round is certain."""
        number = self.variable(first if isinstance(first, Integer) else self.count(first))
        head, after = self._new(), self._new()
        if tested:
            self.branch(number.get() < last, head, after)
        else:
            self.jump(head)
        self._enter(head, sealed=False)
        i = number.get()
        yield i
        following = i.operation("add nuw nsw", step)
        number.set(following)
        self.branch(following < last, head, after)
        head.sealed = True
        self._enter(after)

    @contextmanager
    def forever(self) -> Iterator[Loop]:
        """Round after round until it is left."""
        head, after = self._new(), self._new()
        self.jump(head)
        self._enter(head, sealed=False)
        yield Loop(self, head, after)
        self.jump(head)
        head.sealed = True
        self._enter(after)

    @contextmanager
    def section(self) -> Iterator[Loop]:
        """What can be left for what follows it."""
        after = self._new()
        yield Loop(self, after, after)
        self.jump(after)
        self._enter(after)

    # text

    def text(self) -> str:
        """The function's text."""
        self._settle()
        self._complete()
        alive = [block for block in self._blocks if block is self._entry or block.before]
        phis = {
            name: (variable.kind, [(self._read(variable, b), b.label) for b in block.before])
            for block in alive
            for variable, name in block.phis.items()
        }
        same = _superfluous({name: [one for one, _ in listed] for name, (_, listed) in phis.items()})
        lines: list[str] = []
        for block in alive:
            lines.append(f"{block.label}:")
            for name in block.phis.values():
                if name not in same:
                    type, listed = phis[name]
                    ways = ", ".join(f"[ {one}, %{label} ]" for one, label in listed)
                    lines.append(f"  {name} = phi {type} {ways}")
            lines += block.lines
            if len(block.to) == 1:
                lines.append(f"  br label %{block.to[0].label}")
            elif block.to:
                yes, no = (one.label for one in block.to)
                lines.append(f"  br i1 {block.condition}, label %{yes}, label %{no}")
        text = "\n".join(lines)
        if same:
            text = _PHI.sub(lambda found: same.get(found[0], found[0]), text)
        return f"{self._head} {{\n{text}\n}}\n"

    def _complete(self) -> None:
        """Read what every phi needs where its blocks come from, which may take further phis: block after
        block, and round after round for phis of blocks that have been visited."""
        number = {block: k for k, block in enumerate(self._blocks)}
        pending = [(0, number[block], i, block, variable) for i, (block, variable) in enumerate(self._phis)]
        heapify(pending)
        while pending:
            turn, place, _, block, variable = heappop(pending)
            first = len(self._phis)
            for one in block.before:
                self._read(variable, one)
            for i, (other, read) in enumerate(self._phis[first:], first):
                later = turn + (number[other] <= place)
                heappush(pending, (later, number[other], i, other, read))


def _superfluous(phis: dict[str, list[str]]) -> dict[str, str]:
    """Phis of one value beside themselves, and that value (algorithm 3)."""
    same: dict[str, str] = {}
    users: dict[str, list[str]] = {}
    for name, listed in phis.items():
        for one in listed:
            users.setdefault(one, []).append(name)

    def found(name: str) -> str:
        while name in same:
            name = same[name]
        return name

    pending = deque(phis)
    while pending:
        name = pending.popleft()
        if name in same:
            continue
        others = {found(one) for one in phis[name]} - {name}
        if len(others) == 1:
            same[name] = others.pop()
            users.setdefault(same[name], []).extend(users.get(name, ()))
            pending += users.get(name, ())
    return {name: found(name) for name in same}
