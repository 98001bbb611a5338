"""Ways across u = 0 that are as long as their error allows.

Behind the branch point of u^1.5 the radius of convergence is the distance to it, and steps grow in
proportion to that. So the farther a way across leads, the fewer they are. The path without the change dv of
velocities by the force is known, and the force along this path gives dv. The error is what dv changes of the
force: dv/v may be the square root of what velocities are rounded by.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from math import frexp, inf, ldexp
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from lagrange_cli.integrate.guards.gauss import gauss
from lagrange_cli.integrate.guards.trial_states import TrialStates
from lagrange_cli.native.guards import COSTLY, EVENTS, Role
from lagrange_cli.native.state import Clock
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.integrate.arrays import Array

Ways: TypeAlias = "tuple[list[int], Array, Array]"
"""Guards, and their modes before and after their arguments are 0."""
EXACT, QUICK = (16, 6), (8, 4)
"""Rules: the nodes of Gauss's, and the power of s in the time."""
QUADRATURE, ROUGH = 2.0**-46, 2.0**-26
"""Their errors for powers from t^0.1 on; that of the quick rule is 2^-50 for t^0.5, t^1.5 and t^2."""
FELT = 2.0**-50, 2.0**-98
"""A negligible error of velocities for such a passage."""
LONGEST = 2.0**-12
"""The longest way, as a part of the time in which coordinates change by their size."""
AHEAD = 2.0**-2
"""A way is this part of the time until something else may happen."""
WORTH = 2.0**4
"""A way that is not so many times as long is not worth its evaluations."""
LENGTHS, SLOWEST = 4, 3.0
"""So many lengths are tried; errors grow with at least this power of them: with 2 p + 2 after u^p."""


@dataclass(frozen=True)
class Path:
    """A way from the memory ``origin``, where the rows have these ``rates``: the arguments of ``guards`` are
    0 after the time ``left``; until then, these have the modes ``begin``, and after that, ``mode``."""

    origin: Array
    rates: Array
    guards: Sequence[int]
    left: float
    begin: Array
    mode: Array


class LongerWays(TrialStates):
    """Motions along such ways."""

    path: Path | None = None
    """The last one, if it is a longer one."""

    def changes(self, path: Path, t: float, rule: tuple[int, int] = EXACT) -> tuple[Array, Array]:
        """What the change of the rates adds to rows, and to coordinates, until a time."""
        nodes, power = rule
        left, velocities = path.left, np.zeros(len(path.rates))
        places, beyond = np.zeros(len(path.rates)), t >= left
        last = (path.mode, t - left, 1.0) if beyond else (path.begin, t - left, -1.0)
        sides = (path.begin, -left, 1.0), last
        for (side, extent, sign), (node, weight) in product(sides, gauss(nodes)):
            if extent == 0.0:
                continue
            now = left + extent * node**power
            self.memory[:] = path.origin
            self._move(now, path.rates)
            self.modes[path.guards] = side
            self._series()
            change = self._rates_of_rows() - path.rates
            change[~np.isfinite(change)] = 0.0  # so near that rounding decides on which side u is
            change *= sign * weight * abs(extent) * power * node ** (power - 1)
            velocities += change
            places += change * (t - now)
        return velocities, places

    def follow(self, path: Path, t: float) -> Array:
        """Move to where a motion is after a time; the rates there without the change of the path."""
        changes, layout = self.changes(path, t, QUICK), self._layout
        self.memory[:] = path.origin
        self._move(t, path.rates)
        self.modes[path.guards] = path.mode if t >= path.left else path.begin
        self._series()
        straight: Array = self._rates_of_rows().copy()
        self._add(layout.rates, changes[0])
        self._add(layout.q, changes[1][: layout.degrees])
        return straight

    def along(self, origin: Array) -> Path | None:
        """The longer way that began at the time of a memory, if the last one did."""
        times = [self._layout.at(one) for one in (Clock.TIME, Clock.TIME_LOW)]
        path = self.path
        return path if path is not None and np.array_equal(path.origin[times], origin[times]) else None

    def samples_along(self, path: Path, times: Array) -> Array:
        """The states (rows, n) on the way at some times."""
        memory, layout, found = self.memory.copy(), self._layout, []
        begin = path.origin[layout.time], path.origin[layout.at(Clock.TIME_LOW)]
        for t in np.fmax((times - begin[0]) - begin[1], 0.0).tolist():
            self.follow(path, t)
            found.append(self.memory[layout.part(0)] + self.memory[layout.part(1)])
        self.memory[:] = memory
        self.prepare()
        states: Array = np.array(found).reshape(len(times), layout.rows).T
        return states

    def lengthen(self, path: Path, usual: float, short: float) -> None:
        """Go on to the end of the longest way whose error is negligible, from that of a ``short`` one; the
        ``usual`` time is that in which coordinates change by their size."""
        reached, self.path = self.memory.copy(), None
        if self.machine.program.parts > 1 or not self._simple():
            return
        length = min(usual * LONGEST, path.left + self._undisturbed(path) * AHEAD)
        for _ in range(LENGTHS):
            if not length > short * WORTH:
                break
            length = ldexp(1.0, frexp(length)[1] - 1)  # so that velocities times it are exact
            error = self._error(path, length)
            if error <= 1.0:
                self.path = path
                return
            length *= max(error ** (-1.0 / SLOWEST), LONGEST)
        self.memory[:] = reached
        self.prepare()

    def _simple(self) -> bool:
        """Whether all guards are switches and events, and nothing is held; where steps are costly."""
        guards, modes = self._rows.guards, self.modes
        return (
            self._layout.rows >= COSTLY
            and all(one.role in (Role.SWITCH, *EVENTS) for one in guards)
            and bool(np.all(modes != 0.0))
        )

    def together(self, guards: Sequence[int], begin: Array, mode: Array, length: float) -> Ways:
        """The guards whose arguments are 0 before a time, beside those given: with the modes that all have
        before and after that."""
        self.modes[guards] = begin
        u, rate = (self._all_arguments()[: self.count, :2] * self.modes[: self.count, None]).T
        near = (rate < 0.0) & (np.abs(u) <= -rate * length)
        near &= [one.role is Role.SWITCH for one in self._rows.guards[: self.count]]
        near[guards] = False
        own = self.modes[: self.count][near]
        return [*guards, *np.flatnonzero(near).tolist()], np.append(begin, own), np.append(mode, -own)

    def _all_arguments(self) -> Array:
        """The coefficients of the arguments of all guards (guards, orders)."""
        self._series()
        return self._coefficients_of(self._rows.first, self._rows.first + len(self._rows.guards))

    def _undisturbed(self, path: Path) -> float:
        """The time until another argument may be 0, roughly."""
        self.memory[:] = path.origin
        self.modes[path.guards] = path.begin
        u, rate, bend = np.abs(self._all_arguments()[:, :3].T)
        others = self.marks <= 0.0
        others[path.guards] = False
        with np.errstate(divide="ignore", invalid="ignore"):
            times = np.fmin(u / rate, np.sqrt(u / bend))[others]
        return float(np.min(times, initial=inf))

    def _error(self, path: Path, length: float) -> float:
        """Go to the end of a way of this ``length``: its error, in terms of one that is negligible."""
        own, layout = self._layout.degrees, self._layout
        straight = self.follow(path, length)
        arguments = self._all_arguments()[:, 0] * self.modes
        after = self._rates_of_rows().copy()
        values = arguments[path.guards] * self.modes[path.guards]
        if not (np.all(np.isfinite(after)) and np.all(arguments > 0.0) and self.told(path.guards, values)):
            return inf
        missed, felt = (np.max(np.abs(after - one)[:own]) for one in (straight, path.rates))
        speed = np.max(np.abs(self.memory[layout.part(0)][layout.v]))
        with np.errstate(divide="ignore", invalid="ignore"):
            error = float((missed + felt * ROUGH) * length / (FELT[0] * speed))
        return error if error >= 0.0 else inf
