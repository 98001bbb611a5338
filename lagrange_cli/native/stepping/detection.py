"""Functions that hide a narrow force: exp, tanh and high powers. They may vanish, or be constant to the last
bit, at both ends of a step and in its series, but not between.

Their arguments are watched instead, since these have convergent series. Where an argument changes much within
a step, the accelerations are computed at the places where such a function shows most: where its argument
crosses 0, is greatest, or nearest to 0. If they differ from those that the step's series predicts there, the
step goes at most half of the way."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from lagrange_cli.native.functions.correctly_rounded import exponential
from lagrange_cli.native.llvm.template import fill_in
from lagrange_cli.native.numbers.double import literal, operand

CLOSE = 3.0
"""An argument may change by this much: no such function then grows by more than e^6."""
TAIL, BASE_TAIL = 0.1, 1e-9
"""The largest sum of the last two terms of an argument's series; for a base, relative to its size."""
PARTS = 16
"""Places of the step at which the argument is computed at first."""
BISECTIONS = 50
"""Bisections by which an extremum or a zero is found between neighbours."""
SHARP, ARGUMENT_SHARP = 2.0**-40, 2.0**6
"""Where a base is so small a part of what its series adds up, or such a part of what an argument's adds up
exceeds the other, their values are computed in place: the series has cancelled."""
MAJOR = (5**0.5 - 1) / 2
"""The larger part of the golden section,"""
SECTIONS = 70
"""and how often it is repeated: to the resolution of doubles."""
TRIES = 1100
"""Any number halved this many times is 0."""
SEEN = 2.0**-40
"""The error with which an acceleration must be predicted, relative to its size, to its change and to what
would change the velocity in a step."""

NOTHING_WATCHED = """
define internal double @watched(ptr %a, double %t, ptr %b, ptr %c, ptr %d, double %h) #0 {
  ret double %h
}
"""


def watch(values: Mapping[str, object], first: int, powers: Sequence[float]) -> str:
    """IR of ``@watched``, which shortens a step; the rows of the state from ``first`` on are the quadratures
    of what is followed, with such ``powers`` (see ``mechanics.hidden_forces``); ``values`` are those of
    ``stepper``."""
    if not powers:
        return NOTHING_WATCHED
    growths = [exponential(2 * CLOSE / abs(power)) if power else 0.0 for power in powers]
    tables = "".join(
        f"@watched_{name} = private constant [{len(powers)} x double] "
        f"[{', '.join(f'double {operand(literal(x))}' for x in row)}]\n"
        for name, row in (("powers", powers), ("growths", growths))
    )
    reals = {"close": CLOSE, "tail": TAIL, "base_tail": BASE_TAIL, "part": 1.0 / PARTS, "seen": SEEN}
    reals |= {"sharp": SHARP, "argument_sharp": ARGUMENT_SHARP, "major": MAJOR, "minor": 1 - MAJOR}
    whole = {"parts": PARTS, "bisections": BISECTIONS, "tries": TRIES, "sections": SECTIONS}
    numbers = {name: operand(literal(value)) for name, value in reals.items()}
    ends = {"first": first, "beyond": first + len(powers)}
    return tables + fill_in("watch", {**values, **whole, **numbers, **ends})
