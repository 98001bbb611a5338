"""Where the coefficients lie in memory, so that convolutions read contiguous vectors.

A convolution sum_j x[j] y[k-j] reads x forwards and y from a row that is stored backwards.
"""

from __future__ import annotations

from dataclasses import dataclass

from lagrange_cli.mechanics.series import SHORT, UNBOUNDED, Op, SeriesProgram, needs

LANES = 8


@dataclass(frozen=True)
class Layout:
    """Where rows lie in ``%work``: all forward rows, q, v and integrals first, then the backward ones."""

    order: int
    forward: dict[int, int]
    backward: dict[int, int]

    @property
    def span(self) -> int:
        """Doubles in a forward row; index m >= 1 is at slot m - 1. A backward row has two spans: m at
        span - m."""
        return LANES * -(-self.order // LANES)

    @property
    def doubles(self) -> int:
        """Size of ``%work``."""
        return self.span * (len(self.forward) + 2 * len(self.backward)) + LANES

    def forward_slot(self, series: int) -> int:
        """Slot of index 0 (not stored) of a forward row."""
        return self.span * self.forward[series] - 1

    def backward_slot(self, series: int) -> int:
        """Slot of index 0 (always 0) of a backward row."""
        return self.span * (len(self.forward) + 2 * self.backward[series]) + self.span


def arrange(program: SeriesProgram, order: int) -> Layout:
    """Choose which operand of each convolution is stored backwards; few rows are stored twice."""
    pairs: list[tuple[int, int]] = []
    backward: dict[int, int] = {}
    forward: dict[int, int] = {}
    for index in (*program.coordinates, *program.velocities, *program.integrals):
        forward[index] = len(forward)
    for index, one in enumerate(program.series):
        if one.op is Op.MULTIPLY:
            pairs.append((one.arguments[0], one.arguments[1]))
        elif one.op is Op.COMPOSE:
            pairs += list(zip(one.rates, one.partials))
        elif one.op is Op.POWER and program.series[one.arguments[0]].degree == UNBOUNDED:
            forward.setdefault(index, len(forward))
            backward.setdefault(one.arguments[0], len(backward))
    long = [p for p in pairs if all(program.series[i].degree == UNBOUNDED for i in p)]
    count: dict[int, int] = {}
    for pair in long:
        for index in pair:
            count[index] = count.get(index, 0) + 1
    for a, b in sorted(long, key=lambda p: -max(count[p[0]], count[p[1]])):
        known = (a in backward, b in backward)
        if known == (True, False) or (known[0] == known[1] and count[a] > count[b]):
            a, b = b, a
        forward.setdefault(a, len(forward))
        backward.setdefault(b, len(backward))
    for index in read_back(program, pairs):
        if index not in backward:
            forward.setdefault(index, len(forward))
    return Layout(order, forward, backward)


def read_back(program: SeriesProgram, pairs: list[tuple[int, int]]) -> list[int]:
    """Series of which a looped stage reads single coefficients that earlier stages have made."""
    series = program.series
    found = [index for index in program.residual if series[index].level > 0]
    for one in series:
        found += [index for index, ahead in needs(one) if series[index].level > one.level + ahead]
    for a, b in pairs:
        if series[a].degree <= SHORT or series[b].degree <= SHORT:
            found += [a, b]
    for index, one in enumerate(series):
        if one.op is Op.POWER and series[one.arguments[0]].degree <= SHORT:
            found.append(index)
    return [index for index in found if series[index].degree == UNBOUNDED]
