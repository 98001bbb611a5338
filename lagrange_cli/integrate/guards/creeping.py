"""Motions that slide slowly along vectors, under forces that hardly exceed the limit of friction.

Friction F turns a vector u at the rate F/(m |u|), towards the direction in which it is pushed. If u is small
that is fast, and the motion is stiff: explicit steps are no longer than some multiple of m |u|/F, which takes
1/(4 e) of them at the pull F (1 + e). Collocation at Gauss's nodes is stable for all steps (E. Hairer, G.
Wanner, Solving ODEs II, sec. IV.5), so the motion goes on as it has begun (see ``onset``), until u is larger.
Newton's method begins with what friction would be if it held the vectors.
"""

from __future__ import annotations

import numpy as np

from lagrange_cli.integrate.guards.sliding import LEAST, LONGEST, SHORTER, Sliding

STIFF = 2.0**11
"""How often a vector turns in a way that is worth its evaluations, which take as long as some thousand steps:
else, these lead on."""
LONGER = 16.0
"""A way is at most that much longer than the one before it."""


class Creeping(Sliding):
    """The rest of the ways on which sliding begins."""

    resumed = False
    """Whether the motion may have been on such a way when it was interrupted."""

    def creeps(self) -> bool:
        """Go on a way as sliding has just begun on one, if steps would be far shorter."""
        way, which, resumed = self.onset, self.machine.program.parts - 1, self.resumed
        self.resumed = False
        usual = np.inf if way is None else way.turning * LONGEST[which] * min(way.scale, self.span)
        if usual <= STIFF or (way is None and not resumed):
            return False
        memory = self.memory.copy()
        vectors = [j for j in self.vectors() if self.modes[j] > 0.0 and self._turns_round(j)]
        if not vectors:
            return False
        now, sizes = float(memory[self._layout.time]), self._sizes(vectors)
        self._take_rounding(vectors)
        self.modes[vectors] = 0.0
        held, rest = self.held(vectors, vectors), self.memory.copy()
        self.memory[:] = memory
        rate = max(held.friction[j].rate / size for j, size in zip(vectors, sizes.tolist()))
        length = LONGEST[which] * min(held.scale, self.span)
        if way is not None:
            length = min(length, LONGER * way.length)
        while rate * length > STIFF and length >= LEAST[which] * max(abs(now), self.span):
            until = min(length, self.end - now)
            if until > 0.0 and self._collocated(length, until, held, dict.fromkeys(vectors, 1.0), rest) == {}:
                self._take_rounding([j for j in self.vectors() if self.modes[j] == 0.0])
                self.begin_steps()
                self.prepare()
                return True
            self.memory[:] = memory
            length *= SHORTER
        self.memory[:] = memory
        self.prepare()
        return False

    def _turns_round(self, j: int) -> bool:
        """Whether friction acts along a vector: its parts are 1 else."""
        self._series()
        guard = self._rows.guards[j]
        parts = self._coefficients_of(guard.beside, guard.beside + guard.parts)
        return bool(np.any(parts[:, 1:]) or np.any(parts[:, 0] != 1.0))
