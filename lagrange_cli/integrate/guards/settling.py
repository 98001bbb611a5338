"""Modes of guards (see ``mechanics.guards``) where compiled code cannot choose them: where a motion begins,
and where more than one may follow.

At u = 0 a mode is right if the motion that it gives leads to its own side: the first derivative of u that is
not 0 has its sign. The motion is held there, with mode 0, if the multiplier is between -1 and 1 (A. F.
Filippov 1988, sec. 4)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.guards.leading import few_or_all
from lagrange_cli.integrate.guards.lifting import Lifting
from lagrange_cli.integrate.guards.modes import ROUNDING
from lagrange_cli.integrate.guards.pivoting import Pivoting
from lagrange_cli.integrate.guards.resting import SOON
from lagrange_cli.native.guards import HELD, RIDES, SMALLEST, TRIED, Role
from lagrange_cli.native.interface import Stop
from lagrange_cli.native.state import Clock

if TYPE_CHECKING:
    from lagrange_cli.integrate.arrays import Array

JUMP = 2.0**-20
"""An argument on the wrong side that is this part of its change in a step has not come through 0."""
ROUNDED = 1e-16
"""The square of a jump that is this part of those of usual changes is rounding."""
JUST = 2.0**-45
"""A change of a mode so short a part of the time ago is one that has just been."""
ATTEMPTS = 8
"""How often modes are chosen at one time, for each guard."""
TOGETHER = 64
"""How often modes are chosen at one time before those of all friction of many members are chosen at once."""
ROUNDS = 8
"""How often all modes are computed again, for each guard, until they agree."""


class Settling(Lifting):
    """The choice of the modes of switches."""

    _attempts, _latest = 0, np.nan
    _due = -1

    def begin(self, parameters: Array) -> None:
        """Choose the modes of all switches where the motion begins."""
        self.set_parameters(parameters)
        self.begin_switches()

    def begin_switches(self) -> None:
        """Choose the modes of all switches, whatever was before."""
        if not self.count:
            self.prepare()
            return
        own = self.modes[: self.count]
        own[:] = 1.0
        values, vectors = np.ones(0), [*self.vectors(), *self.dragged()]
        for _ in range(self.count + 1):  # arguments may depend on other modes
            values = self._arguments()
            signs = np.where(values < 0.0, -1.0, 1.0)
            signs[vectors] = values[vectors] > 0.0
            if np.array_equal(signs, own):
                break
            own[:] = signs
        self.begin_at_rest(values)
        at_zero = [j for j in range(self.count) if values[j] == 0.0 and j not in vectors]
        if at_zero:
            self._choose(at_zero, dict.fromkeys(at_zero, 1.0))
        else:
            self.prepare()
        if len(self.vectors()) > 1:
            self._series()
            self.undetermined = not np.all(np.isfinite(self._rates_of_rows())) and self._shares_unknown()

    def resume(self) -> None:
        """Go on with the modes that are in the memory."""
        self.prepare()

    def goes_on(self, stop: Stop, due: int) -> bool:
        """Whether the motion goes on from where compiled code has stopped."""
        if stop is Stop.PAUSE:
            return self.stands_still()
        if stop is Stop.GUARD and self._rows.guards[due].role is Role.EDGE:
            return False
        if stop is Stop.GUARD and self.hears():
            return True
        if stop is Stop.GUARD and self._rows.guards[due].role is Role.BREAK:
            return not self.breaks(due) and self.passes(due)
        if stop is Stop.GUARD and self._rows.guards[due].parts:
            friction = self._rows.guards[due].multiplier
            return self.slide_or_hold(due) if friction else self.pass_zero(due)
        if stop is Stop.GUARD:
            return self.settle(due) or self.rest() or self.cross()
        if stop is Stop.ROOT:
            return self.rest() or self.cross() or self.tries()
        if stop not in (Stop.UNDERFLOW, Stop.NOT_FINITE, Stop.STUCK) or self.only_edges:
            return False
        if self.stops() or self.rests_on() or self.rest() or self.cross():
            return True
        if self.rests_on() or self.goes_farther() or self.leave_out() or self.blur():
            return True
        return self.goes_in()

    def hears(self) -> bool:
        """Let guards be silent whose modes change nothing from now on, and choose those of guards that are
        loud again (see ``mechanics.guards.silence``); whether there are any."""
        silent = self.machine.program.silent
        if not silent:
            return False
        values = self._arguments()
        turned = [k for k in {k for _, k in silent} if values[k] * self.modes[k] < 0.0]
        if not turned:
            return False
        self.begin_steps()
        self.modes[turned] = -self.modes[turned]
        own = [j for j, k in silent if k in turned]
        self.modes[own] = 1.0
        self.marks[own] = 0.0
        values, vectors = self._arguments(), self.vectors()
        self.modes[own] = np.where(values[own] < 0.0, -1.0, 1.0)
        zero = [j for j in own if values[j] == 0.0]
        self.modes[[j for j in zero if j in vectors]] = 0.0
        at_zero = [j for j in zero if j not in vectors]
        if at_zero:
            return self._choose(at_zero, dict.fromkeys(at_zero, 1.0))
        self.prepare()
        return True

    def tries(self) -> bool:
        """Go on with steps where no way leads across a root."""
        last = self._layout.at(Clock.LAST_PASS)
        self.memory[last] -= max(abs(self.memory[last]) * JUST, SMALLEST)
        rooted = [one.steep for one in self._rows.guards[: self.count]] & (self.marks[: self.count] > 0.0)
        self.marks[: self.count][rooted] = TRIED
        self.prepare()
        return True

    def begins_beyond(self) -> bool:
        """Whether the motion begins at y = 0 and leads below, where an energy jumps."""
        return any(
            guard.role is Role.BREAK and self.marks[j] > 0.0 > self.modes[j] and self.breaks(j)
            for j, guard in enumerate(self._rows.guards[: self.count])
        )

    @property
    def only_edges(self) -> bool:
        """Whether there is nothing that the motion could cross."""
        return all(guard.role is Role.EDGE for guard in self._rows.guards[: self.count])

    def is_beyond_edge(self) -> bool:
        """Whether the state is where an expression of the file has no value."""
        edges = [j for j, guard in enumerate(self._rows.guards[: self.count]) if guard.role is Role.EDGE]
        return bool(edges) and not np.all(self._arguments()[edges] >= 0.0)

    def breaks(self, due: int) -> bool:
        """Whether an energy jumps where the argument of a guard is 0 now."""
        beside = self._rows.guards[due].beside
        x, jump, usual = (one[0] for one in self.coefficients_of(beside, beside + 1, beside + 2))
        return bool(x < 0.0 and not jump <= ROUNDED * usual)

    def passes(self, due: int) -> bool:
        """Go on to the other side of a guard whose mode no equation contains."""
        self.modes[due] = -self.modes[due]
        self.mark([due])
        return True

    def settle(self, due: int) -> bool:
        """Choose the mode of a guard whose argument has become 0, or whose multiplier has reached its bound;
        whether one was found with which the motion goes on."""
        now = float(self.memory[self._layout.time])
        self._attempts = self._attempts + 1 if now == self._latest else 0
        self._again = self._again + 1 if now == self._latest and due == self._due else 0
        self._latest, self._due = now, due
        if self._attempts > ATTEMPTS * (self.count + 1):
            return False
        before, (value, rate) = float(self.modes[due]), self.coefficients_of(self._rows.first + due)[0][:2]
        if before * value < 0.0 and abs(value) > JUMP * abs(rate * self.memory[self._layout.at(Clock.STEP)]):
            self.modes[due] = -before  # it has not come through 0, but jumped
            self.prepare()
            return True
        self.begin_steps()
        fresh = (self.marks[: self.count] > 0.0) & (self.modes[: self.count] != 0.0)
        fresh |= self._bound_at_rest() if self._rows.bound else False
        marked = [j for j in np.flatnonzero(fresh).tolist() if j != due]
        if self._rows.guards[due].multiplier and before and not self._rows.guards[due].explicit:
            self._stop_at(due)
        if before == 0.0 and not self._rows.guards[due].multiplier and not self.has_left(due):
            return True
        if before == 0.0:
            leaving = self._multiplier(due) if self._rows.guards[due].multiplier else self._arguments()[due]
            side = 1.0 if leaving > 0.0 else -1.0
            self.left = self.memory.copy(), due
            bound = marked if self._rows.bound else []
            self._let_go = [due, *bound] if self._rows.guards[due].limited else []
            found = self._choose([due, *marked], {due: side}, held=False)
            self._let_go = []
            return found
        modes = self.modes.copy()
        found = self._choose([due, *marked], {due: -before})
        if not found and self._rows.guards[due].multiplier:  # where forces have roots, rounding may decide
            self.modes[:] = modes
        return found

    def rest(self) -> bool:
        """Let a velocity be 0 that a force has brought to rest which is 0 there, but has no series, such as
        sqrt(|v|); whether there is one that stays 0. What is left of it may be on the other side of 0 than
        the modes that were chosen next."""
        modes, values = self.modes[: self.count].copy(), self._arguments()
        behind = (self.marks[: self.count] > 0.0) & (modes * values < 0.0)
        behind &= [one.rooted for one in self._rows.guards[: self.count]]
        self.modes[: self.count][behind] *= -1.0
        self._series()
        soon = max(abs(self.memory[self._layout.time]), SMALLEST) * SOON
        arguments = self._coefficients_of_arguments()[:, :2]
        for j, (u, rate) in enumerate(arguments.tolist()):
            if self.modes[j] * rate < 0.0 < abs(u) <= abs(rate) * soon and self._rests(j, u):
                return True
        self.modes[: self.count] = modes
        return False

    def _rests(self, j: int, u: float) -> bool:
        """Take away the velocity that is the argument of a guard, and set its mode to 0; whether it stays."""
        layout, memory = self._layout, self.memory.copy()
        row = next((i for i in range(layout.v.start, layout.v.stop) if memory[i] == u), None)
        if row is None:
            return False
        self.memory[layout.part(0)][row] = self.memory[layout.part(1)][row] = 0.0
        self.modes[j] = 0.0
        self._series()
        coefficients = self._coefficients(self._rows.first + j)
        if np.all(np.abs(coefficients) <= ROUNDING * self.scale()[: len(coefficients)]):
            self.marks[j] = 0.0
            self.begin_steps()
            return True
        self.memory[:] = memory
        return False

    def _choose(self, guards: Sequence[int], first: dict[int, float], *, held: bool = True) -> bool:
        """Choose the modes of guards whose arguments are 0: held where that is possible, else the side tried
        ``first``, or the other one."""
        stopped = self._stopped()
        able = [j for j in guards if self._rows.guards[j].multiplier] if held else []
        free = [j for j in guards if j not in able]
        self.marks[: self.count] = np.minimum(self.marks[: self.count], 0.0)
        self.mark(guards)
        for j in free:
            self.modes[j] = first.get(j, self.modes[j])
        self.modes[able] = 0.0
        self.regular(free)
        modes, held_first = self.modes.copy(), [*able]
        at_once = not self._rows.bound or self._attempts % TOGETHER == TOGETHER - 1
        group = self._balanced(guards, stopped) if at_once else []
        found, entered = (True, list[int]()) if group else self._agreed(guards, able, first)
        if self._rows.bound and not found:
            self.modes[:] = modes
            group = self._balanced(guards, stopped)
            found = bool(group)
        if group:
            guards = able = [*dict.fromkeys([*guards, *group])]
            self.mark([j for j in guards if self.modes[j] <= RIDES])
        if self._rows.bound and not found:
            self.modes[:], able = modes, held_first
            found, entered = self._agreed(guards, able, first, again=True)
        still = [j for j in able if self.modes[j] == 0.0]
        values = self._arguments() if still else np.zeros(0)
        for j in still:
            if values[j] != 0.0:
                self._take_to(j, 0.0)
        if still:
            self._move_as_one()
        self.let_rest(free)
        self.let_drift(free)
        entered = [j for j in entered if self.modes[j] != 0.0]
        self.modes[entered] = -self.modes[entered]  # where forces have no series: see ``cross``
        if found:
            self._lead_on([j for j in guards if self._rows.guards[j].multiplier and self.modes[j]])
        self.prepare()
        return found

    def _agreed(
        self, guards: Sequence[int], able: list[int], first: dict[int, float], *, again: bool = False
    ) -> tuple[bool, list[int]]:
        """Change modes until all guards lead to their sides; whether they do, and the guards that lead to a
        side on which series are not finite here. Their modes are left as they are."""
        entered: list[int] = []
        pivoting = Pivoting()
        for turn in range(ROUNDS * (len(guards) + 1)):
            self._series()
            resting = [j for j in able if self.modes[j] == 0.0]
            sizes = self._holding(resting)
            loose = [(size, j) for size, j in zip(sizes.tolist(), resting) if not size <= HELD]
            explicit = [j for _, j in loose if self._rows.guards[j].limited]
            slipping = [j for j in guards if self._rows.guards[j].explicit and self.modes[j] != 0.0]
            sides = self._sides(explicit)
            slipping = slipping if able else [j for j in slipping if self._rows.bound and j not in first]
            misled = self._misled(slipping)
            single = self._rows.bound and pivoting.singly(bool(self._let_go), turn if again else None)
            sides |= dict.fromkeys(misled[:1] if single else misled, 0.0)
            if sides:
                for j in [*sides] if single else pivoting.chosen([*sides]):
                    self.modes[j] = sides[j]
                    able += [j] if j not in able else []
                continue
            if loose:
                _, j = max(loose)
                self.modes[j] = first.get(j) or (1.0 if self._multiplier(j) > 0.0 else -1.0)
                self._series()
                if self._misled([j]):
                    self.modes[j] = -self.modes[j]
                continue
            wrong = self._misled([j for j in guards if self.modes[j] != 0.0])
            if not wrong:
                return True, entered
            for some in few_or_all(wrong):
                self.modes[some] = -self.modes[some]
                infinite = self._infinite()
                touching = set[int]()
                for j in some if infinite else self._misled(some):
                    if self._rows.guards[j].multiplier:
                        self.modes[j] = 0.0
                        able.append(j)
                    else:  # both sides lead back: it touches 0, and rounding decides
                        self.modes[j] = -self.modes[j]
                        touching.add(j)
                        entered += [j] if infinite else []
                guards = [one for one in guards if one not in touching]
        return False, entered

    def _sides(self, guards: Sequence[int]) -> dict[int, float]:
        """Where guards go that are let go: with their velocities if these are not 0, or else as they are
        pushed."""
        if not guards:
            return {}
        rates = self._passing(guards)
        pushes = np.where(rates != 0.0, rates, self._multipliers(guards))
        return {j: 1.0 if one > 0.0 else -1.0 for j, one in zip(guards, pushes.tolist())}
