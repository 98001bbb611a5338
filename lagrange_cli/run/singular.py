"""Places where constraints become dependent along a motion, and the messages about them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

from lagrange_cli.errors import LagrangeError
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.method import Cause
from lagrange_cli.records import replace
from lagrange_cli.run.start_notes import in_short

if TYPE_CHECKING:
    from lagrange_cli.integrate.method import End
    from lagrange_cli.spec.spec import Spec

CLOSE = 1e-4
"""The sine of the angle between slopes of constraints at which a motion that ends is close to where they
depend on each other."""
STUCK = Ending.SINGULAR_MASS_MATRIX, Ending.STEP_UNDERFLOW, Ending.NOT_A_NUMBER, Ending.STUCK
MATRIX = "singular matrix of masses and constraints"
"""What is singular where there are constraints, and ``Ending`` has the mass matrix."""


def singular_constraints(spec: Spec, parameters: Mapping[str, float], start: float, end: End) -> Cause | None:
    """Why a motion that began at ``start`` could not go on, if its constraints depend on each other there, or
    the matrix of its equations is singular."""
    if end.ending not in STUCK:
        return None
    names = dependent(spec, parameters, end)
    if names:
        verb = "are" if end.t == start else "become"
        text = f"the constraints {verb} dependent ({in_short(names)} on the others): a singular configuration"
        return Cause(text, end.t)
    return Cause(MATRIX, end.t) if end.ending is Ending.SINGULAR_MASS_MATRIX else None


def singular_angles(spec: Spec, parameters: Mapping[str, float], start: float, end: End) -> Cause | None:
    """The same of the angles of a body: about the first and the last axis it turns the same way there."""
    if end.ending not in STUCK:
        return None
    from lagrange_cli.model.scope import Scope
    from lagrange_cli.model.start.equations import Equations

    count = len(spec.coordinates)
    state = end.state.tolist()
    algebra = Equations(spec, parameters).algebra(end.t, state[:count], state[count : 2 * count])
    for name, body in spec.bodies.items():
        how = body.orientation
        if how.form == "euler":
            middle = float(Scope(spec, algebra).scalar(how.entries[1]).value)
            proper = how.sequence[0] == how.sequence[2]
            if abs(math.sin(middle) if proper else math.cos(middle)) < CLOSE:
                verb, function = "are" if end.t == start else "become", "sine" if proper else "cosine"
                pose = f"the {function} of the second one is 0; a quaternion has no such singularity"
                return Cause(f"the angles of body '{name}' {verb} singular ({pose})", end.t)
    return None


def dependent(spec: Spec, parameters: Mapping[str, float], end: End) -> tuple[str, ...]:
    """The constraints that depend on others where a motion ended, besides those that do so everywhere."""
    from lagrange_cli.model.start.equations import Equations
    from lagrange_cli.model.start.linear import independent, scales
    from lagrange_cli.run.start import of_families

    count = len(spec.coordinates)
    state = end.state.tolist()
    q, v = state[:count], state[count : 2 * count]
    try:
        equations = of_families(replace(spec, left_out=()), parameters) or Equations(spec, parameters)
        masses = equations.masses(end.t, q, v)
        rows = equations.at(end.t, q, v).rows
    except (LagrangeError, ArithmeticError):
        return ()
    kept = [i for i, name in enumerate(spec.all_constraints) if name not in spec.left_out]
    found = independent([rows[i] for i in kept], scales(masses, q, masses.extent), sine=CLOSE)
    names = [*spec.all_constraints]
    return tuple(names[kept[i]] for i in range(len(kept)) if i not in found)


def in_words(spec: Spec, sentence: str) -> str:
    """How a member of an ensemble ended, in words that also fit systems with constraints."""
    return sentence.replace(Ending.SINGULAR_MASS_MATRIX.value, MATRIX) if spec.all_constraints else sentence
