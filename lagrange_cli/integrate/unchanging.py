"""Whether what becomes 0 at an event may be the same all along a motion, as a momentum is: its rate of change
at random states, which constraints allow."""

from __future__ import annotations

import numpy as np

from lagrange_cli.families.accelerations import NEAR, Accelerations
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.native.families.loops import needed

STATES = 1, 2
"""Random states at which rates are looked at."""
UNCHANGED, CANCELLED = 5e-5, 1e-6
"""What changes so slowly may be conserved, and so may what is left of a rate whose parts cancel."""


def may_be_conserved(system: FamilySystem) -> bool:
    """Whether the argument of the last event may be constant."""
    assert system.events is not None
    arguments = system.events.arguments
    terms = [one for total in needed([arguments], system.slots) for one in total.terms]
    fast = any(system.slots.moving(one.node, {system.v}) for one in terms)
    if system.bonds is None and not fast:
        return False
    return not any(changes(system, seed) for seed in STATES)


def changes(system: FamilySystem, seed: int) -> bool:
    """Whether it clearly changes at a random state."""
    assert system.events is not None
    arguments, count, chance = system.events.arguments, system.q.count, np.random.default_rng(seed)
    q, v, t = chance.uniform(0.2, 1.2, count), chance.uniform(-1.0, 1.0, count), chance.uniform(0.2, 1.2)
    motion = Accelerations(system, chance.uniform(0.5, 1.5, system.given.count))
    with np.errstate(all="ignore"):
        allowed = motion.allowed(t, q, v)
        a = None if allowed is None else motion.at(t, q, allowed)
        if allowed is None or a is None or not np.all(np.isfinite(a)):
            return False

        def argument(by_places: float, by_speeds: float) -> float:
            places, speeds = q + by_places * allowed, allowed + by_speeds * a
            return float(motion.values(t + by_places, places, speeds).of(arguments)[arguments.count - 1])

        brief = NEAR / max(1.0, float(np.max(np.abs(a), initial=0.0)))
        slow = (argument(NEAR, 0.0) - argument(-NEAR, 0.0)) / (2 * NEAR)
        fast = (argument(0.0, brief) - argument(0.0, -brief)) / (2 * brief)
        least = max(UNCHANGED * (1.0 + abs(argument(0.0, 0.0))), CANCELLED * (abs(slow) + abs(fast)))
    return abs(slow + fast) > least
