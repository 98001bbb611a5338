"""Motions of one coordinate in a potential, whose time is an integral: t = int dx / v."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

from benchmarks.truth.case import MP, Number

Potential = Callable[[Number], Number]


def integral(
    f: Callable[[Number], Number], low: Number, high: Number, marks: Sequence[Number] = ()
) -> Number:
    """The integral of f, in parts that end at the ``marks`` between."""
    a, b = min(low, high), max(low, high)
    ways = [a, *sorted(mark for mark in marks if a < mark < b), b]
    places = [*ways, *((x + y) / 2 for x, y in pairwise(ways))]
    size = max(abs(f(x)) for x in places) or 1  # the rule stops at an absolute error
    found = size * MP.quad(lambda x: f(x) / size, ways)
    return found if low <= high else -found


class Course:
    """A motion with one coordinate, m x'' = -U'(x), from x with velocity v, up to its second turn.

    It is followed along a path parameter: where it turns at ``turn`` that is s in x = turn - s^2, of which
    time is a smooth function on both sides; else it is x itself. ``marks`` are places where U changes
    quickly: integrals are divided there.
    """

    def __init__(
        self,
        potential: Potential,
        x: Number,
        v: Number,
        *,
        marks: Sequence[Number] = (),
        mass: Number = 1,
        turn: Number | None = None,
        towards: int = 0,
    ) -> None:
        self.potential, self.x, self.v, self.mass, self.turn = potential, x, v, mass, turn
        self.towards = towards or (1 if v > 0 else -1)
        self.begin = self.end = MP.mpf(0)
        if turn is None:
            ways = sorted(self.towards * (mark - x) for mark in marks)
        else:
            self.end = 2 * (root := MP.sqrt(abs(turn - x)))
            depths = [MP.sqrt(self.towards * (turn - m)) for m in marks if self.towards * (turn - m) > 0]
            ways = sorted([root, *(root - s for s in depths), *(root + s for s in depths)])
        self.energies: dict[int, Number] = {}
        self.nodes: list[tuple[Number, Number]] = [(MP.mpf(0), MP.mpf(0))]
        self.ways = [way for way in ways if way > 0]

    def place(self, s: Number) -> Number:
        """x at the path parameter s."""
        if self.turn is None:
            return self.x + self.towards * s
        return self.turn - self.towards * (self.end / 2 - s) ** 2

    def speed(self, x: Number) -> Number:
        """|v| at x."""
        if MP.prec not in self.energies:
            u = 2 * self.potential(self.x if self.turn is None else self.turn) / self.mass
            self.energies[MP.prec] = u if self.turn is not None else u + self.v**2
        return MP.sqrt(abs(self.energies[MP.prec] - 2 * self.potential(x) / self.mass))

    def slowness(self, s: Number) -> Number:
        """dt/ds; where the motion turns with many digits, as v^2 is a small difference."""
        if self.turn is None:
            return 1 / self.speed(self.place(s))
        apart = abs(self.end / 2 - s) or MP.mpf(10) ** -30
        with MP.workdps(2 * MP.dps + 10):
            return 2 * apart / self.speed(self.turn - self.towards * apart**2)

    def time(self, x: Number) -> Number:
        """How long it takes from the start to x, before any turn."""
        if self.turn is None:
            return self.until(self.towards * (x - self.x))
        return self.until(self.end / 2 - MP.sqrt(abs(self.turn - x)))

    def time_to_turn(self) -> Number:
        """How long it takes from the start to the turn."""
        return self.until(self.end / 2)

    def until(self, s: Number) -> Number:
        """The time at s."""
        low, found = self.nodes[-1]
        for way in sorted([*self.ways, s]):
            if low < way <= s:
                found += MP.quad(self.slowness, [low, way])
                low = way
                self.nodes.append((low, found))
        low, found = next(each for each in reversed(self.nodes) if each[0] <= s)
        return found if low == s else found + MP.quad(self.slowness, [low, s])

    def at(self, t: Number) -> tuple[Number, Number]:
        """Position and velocity at time t."""
        ways = [way for way in self.ways if way > self.nodes[-1][0]]
        step = (ways[-1] if ways else MP.mpf(1)) / 4
        while self.nodes[-1][1] < t:
            low = self.nodes[-1][0]
            self.until(ways.pop(0) if ways else low + step)
            step *= 2
        k = next(k for k, node in enumerate(self.nodes) if node[1] >= t)
        if not k:
            return self.x, self.v
        (low, before), (high, after) = self.nodes[k - 1], self.nodes[k]
        left, right = low, high
        s, reached = (high, after) if after - t < t - before else (low, before)
        for _ in range(100):
            miss = t - reached
            left, right = (max(left, s), right) if miss > 0 else (left, min(right, s))
            new = s + miss / self.slowness(s)
            if not left <= new <= right:
                new = (left + right) / 2
            reached += MP.quad(self.slowness, [s, new]) if new != s else 0
            small = abs(new - s) <= MP.mpf(10) ** (6 - MP.dps) * (high + abs(self.x))
            s = new
            if small:
                break
        else:
            raise ArithmeticError("the time is not reached")
        x = self.place(s)
        back = self.turn is not None and s > self.end / 2
        return x, (-self.towards if back else self.towards) * self.speed(x)
