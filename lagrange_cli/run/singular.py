"""Places where constraints become dependent along a motion, and the messages about them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.errors import LagrangeError
from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.method import Cause
from lagrange_cli.records import replace
from lagrange_cli.run.start_notes import in_short

if TYPE_CHECKING:
    from lagrange_cli.integrate.method import End
    from lagrange_cli.mechanics.conditioning import Conditioning
    from lagrange_cli.spec.source import Place
    from lagrange_cli.spec.spec import Spec

CLOSE = 1e-4
"""The sine of the angle between slopes of constraints at which a motion that ends is close to where they
depend on each other."""
MOST, MOST_IN_FAMILIES = 100, 1000
"""Coordinates of systems whose mass matrix is looked at, and of those whose families have a constant one."""
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
        if len(spec.all_constraints) == 1:
            text = f"the derivatives of the constraint {names[0]} {verb} 0: a singular configuration"
        return Cause(text, end.t)
    return Cause(MATRIX, end.t) if end.ending is Ending.SINGULAR_MASS_MATRIX else None


def singular_angles(spec: Spec, parameters: Mapping[str, float], start: float, end: End) -> Cause | None:
    """The same of the angles of a body: about the first and the last axis it turns the same way there."""
    if end.ending not in STUCK:
        return None
    for name, function in angles_at(spec, parameters, end.t, end.state.tolist()).items():
        verb = "are" if end.t == start else "become"
        pose = f"the {function} of the second one is 0; a quaternion has no such singularity"
        return Cause(f"the angles of body '{name}' {verb} singular ({pose})", end.t)
    return None


def angles_at(
    spec: Spec, parameters: Mapping[str, float], t: float, state: Sequence[float]
) -> dict[str, str]:
    """The bodies whose three angles, which all may change, are singular at a state, and the function of the
    second one that is 0 there."""
    from lagrange_cli.model.scope import Scope
    from lagrange_cli.model.start.equations import Equations

    count, found = len(spec.coordinates), dict[str, str]()
    algebra = Equations(spec, parameters).algebra(t, state[:count], state[count : 2 * count])
    scope = Scope(spec, algebra)
    for name, body in spec.bodies.items():
        how = body.orientation
        if how.form != "euler":
            continue
        angles = [*map(scope.scalar, how.entries)]
        proper, middle = how.sequence[0] == how.sequence[2], float(angles[1].value)
        small = abs(math.sin(middle) if proper else math.cos(middle)) < CLOSE
        if small and all(any(slot and x for slot, x in angle.slopes.items()) for angle in angles):
            found[name] = "sine" if proper else "cosine"
    return found


def singular_masses(
    spec: Spec, parameters: Mapping[str, float], start: float, end: End, *, long: bool = False
) -> Cause | None:
    """The same of a state at which no kinetic energy depends on some velocities, or at which the mass matrix
    is too ill-conditioned for doubles, or even for ``long`` numbers."""
    if end.ending not in STUCK:
        return None
    found = conditioning_at(spec, parameters, end.t, end.state.tolist())
    if found is None or not found.lost:
        return None
    verb, singular = "is" if end.t == start else "becomes", Ending.SINGULAR_MASS_MATRIX
    if not found.graded:
        names = idle_ways(spec, found)
        text = f"the mass matrix {verb} singular: {idle(names)} (line {place_of(spec, names[0]).line})"
        return Cause(text, end.t, singular)
    if spec.all_constraints or end.ending is not singular:
        return None
    from lagrange_cli.mechanics.conditioning import told

    numbers = "double-double numbers, too" if long else "doubles"
    text = f"the mass matrix {verb} too ill-conditioned for {numbers}: its condition is "
    text += f"{told(found.condition)},"
    return Cause(text, end.t, singular if long else Ending.ILL_CONDITIONED)


def idle(names: Sequence[str]) -> str:
    """That these coordinates are ``without_mass``."""
    if len(names) == 1:
        return f"no kinetic energy depends on {velocity_name(names[0])}"
    return f"{in_short([*map(velocity_name, names)])} may change together, and no momentum changes"


def place_of(spec: Spec, name: str) -> Place:
    """Where a coordinate is written."""
    return next(one.place for one in spec.coordinates if one.name == name)


def without_mass(
    spec: Spec, parameters: Mapping[str, float], t: float, state: Sequence[float]
) -> tuple[str, ...]:
    """The coordinates whose velocities may change at a state, in a way that the constraints allow, without a
    change of any momentum: those of one such way."""
    found = conditioning_at(spec, parameters, t, state)
    return () if found is None or not found.lost or found.graded else idle_ways(spec, found)


def idle_ways(spec: Spec, found: Conditioning) -> tuple[str, ...]:
    """Those coordinates of a matrix that is singular."""
    moves = np.abs(found.ways[-1])
    return tuple(one.name for one, move in zip(spec.coordinates, moves) if move > CLOSE * moves.max())


def conditioning_at(
    spec: Spec, parameters: Mapping[str, float], t: float, state: Sequence[float]
) -> Conditioning | None:
    """That of the masses, with the constraints below. Systems of many coordinates are not looked at, but for
    families without constraints, nor those of first order."""
    if spec.first_order:
        return None
    from lagrange_cli.mechanics.conditioning import conditioning
    from lagrange_cli.model.start.equations import Equations

    count = len(spec.coordinates)
    if count > MOST:
        return conditioning_of_families(spec, parameters, t, state) if count <= MOST_IN_FAMILIES else None
    q, v = state[:count], state[count : 2 * count]
    try:
        equations = Equations(spec, parameters)
        masses, rows = equations.masses(t, q, v).rows, equations.at(t, q, v).rows
    except (LagrangeError, ArithmeticError):
        return None
    matrix = np.zeros((count + len(rows), count))
    for j, row in (*masses.items(), *enumerate(rows, count)):
        matrix[j, [*row]] = [float(x) for x in row.values()]
    return conditioning(matrix)


def conditioning_of_families(
    spec: Spec, parameters: Mapping[str, float], t: float, state: Sequence[float]
) -> Conditioning | None:
    """The same of a large system without constraints."""
    from lagrange_cli.families.system import any_family_system
    from lagrange_cli.families.values import FamilyValues
    from lagrange_cli.mechanics.conditioning import conditioning

    system = any_family_system(spec)
    if system is None or system.coupled_masses is None or system.bonds is not None:
        return None
    count = system.q.count
    q, v = (np.array(one) for one in (state[:count], state[count : 2 * count]))
    given = np.array([parameters[one.name] for one in spec.parameters])
    values = FamilyValues(system, t, q, v, given)
    matrix = np.zeros((count, count))
    with np.errstate(all="ignore"):
        for j, row in enumerate(system.coupled_masses.matrix(values.of(system.coupled_masses.entries))):
            matrix[j, [*row]] = [*row.values()]
    return conditioning(matrix)


def dependent(spec: Spec, parameters: Mapping[str, float], end: End) -> tuple[str, ...]:
    """The constraints that depend on others where a motion ended, besides those that do so everywhere."""
    from lagrange_cli.model.start.dependence import independent
    from lagrange_cli.model.start.equations import Equations
    from lagrange_cli.model.start.linear import scales
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
