"""Functions that hide a narrow force: exp, tanh and the like, which may be constant to the last bit where a
step begins and ends, and in its series, and not between.

What they are functions of is watched instead, for it has a series that is true. Where it gets far within a
step, the accelerations are computed at the places in between where such a function shows most: where its
argument crosses 0, is greatest, or nearest to 0. If they are not what the step's series foretells there, the
step goes no further than half the way.
"""

from __future__ import annotations

from collections.abc import Mapping

from lagrange_cli.expression.graph import Kind, Node, reachable
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.native.emitter import literal, operand
from lagrange_cli.native.template import fill_in

HIDING = frozenset({"exp", "tanh", "sinh", "cosh"})
"""They change by orders of magnitude, or from one constant to another, where their argument changes."""
CLOSE = 3.0
"""Within so much about its value an argument is free to change: no such function grows by more than e^6."""
TAIL = 0.1
"""What the last two terms of an argument's series may add up to."""
PARTS = 16
"""Places of the step at which an argument is computed, to begin with."""
REFINEMENTS = 6
"""Steps of Newton's method towards where an argument turns."""
BISECTIONS = 50
TRIES = 1100
"""So many halves of any number are 0."""
SEEN = 2.0**-40
"""How closely, relative to its size, to its change and to what would change the velocity in a step, an
acceleration must be foretold."""


NOTHING_WATCHED = """
define internal double @watched(ptr %a, double %t, ptr %b, ptr %c, ptr %d, double %h) #0 {
  ret double %h
}
"""


def watched_arguments(residual: Residual) -> dict[str, Node]:
    """The arguments of such functions in the equations that change along the motion, by the names that their
    quadratures go by."""
    graph = residual.graph
    nodes = reachable(residual.residual)
    arguments = [n.arguments[0] for n in nodes if n.kind is Kind.FUNCTION and n.data in HIDING]
    for node in nodes:
        if node.kind is Kind.POWER:
            base, exponent = node.arguments
            arguments.append(exponent * graph.function("log", [base]))
    moving = [one for one in dict.fromkeys(arguments) if one.symbols & residual.variables]
    return {f"watched {i}": one for i, one in enumerate(moving)}


def watch(values: Mapping[str, object], watched: range) -> str:
    """IR of ``@watched``, which shortens a step; ``watched`` are the rows of the state that are quadratures
    of arguments, ``values`` those of ``stepper``."""
    if not watched:
        return NOTHING_WATCHED
    reals = {"close": CLOSE, "tail": TAIL, "part": 1.0 / PARTS, "seen": SEEN}
    whole = {"parts": PARTS, "refinements": REFINEMENTS, "bisections": BISECTIONS, "tries": TRIES}
    numbers = {name: operand(literal(value)) for name, value in reals.items()}
    return fill_in("watch", {**values, **whole, **numbers, "first": watched.start, "beyond": watched.stop})
