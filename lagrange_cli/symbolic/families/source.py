"""The equations of a system of families as a Python module: loops over the members, over ``math``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import prod

import numpy as np

from lagrange_cli.expression.vocabulary import CONSTANTS, FUNCTIONS
from lagrange_cli.families.groups import places_of
from lagrange_cli.spec.spec import Family
from lagrange_cli.symbolic.families import event_source
from lagrange_cli.symbolic.families.data import refuse_names, without
from lagrange_cli.symbolic.families.equations import FamilyEquations
from lagrange_cli.symbolic.families.hamilton import hamilton_form
from lagrange_cli.symbolic.families.module_writer import MULTIPLIERS, PLACES, ModuleWriter
from lagrange_cli.symbolic.notations import python_name
from lagrange_cli.symbolic.source import IN_STEPS, LINEAR, SOLUTION, with_sign

TOGETHER = '''
def accelerations(t, q, v, parameters=PARAMETERS):
    """q_ddot(t, q, v), of which the equations of motion are linear functions."""
    n = len(COORDINATES)
    rest = equations(t, q, v, [0.0] * n, parameters)
    columns = [equations(t, q, v, [float(i == k) for i in range(n)], parameters) for k in range(n)]
    return solution([[*(column[i] - rest[i] for column in columns), -rest[i]] for i in range(n)])
'''

BORDERED = '''
def accelerations(t, q, v, parameters=PARAMETERS):
    """q_ddot(t, q, v), of which the equations of motion and the rates of constraints are linear functions."""
    return unknowns(t, q, v, parameters)[: len(COORDINATES)]


def multipliers(t, q, v, parameters=PARAMETERS):
    """lambda(t, q, v), likewise."""
    return unknowns(t, q, v, parameters)[len(COORDINATES) :]


def unknowns(t, q, v, parameters):
    """Accelerations and multipliers."""
    n = len(COORDINATES)

    def left(x):
        return *equations(t, q, v, x[:n], x[n:], parameters), *constraint_rates(t, q, v, x[:n], parameters)

    count = n + len(CONSTRAINTS)
    rest = left([0.0] * count)
    columns = [left([float(i == k) for i in range(count)]) for k in range(count)]
    return solution([[*(column[i] - rest[i] for column in columns), -rest[i]] for i in range(count)])
'''

PATHS = '''
def paths(parents):
    """The matrix, row by row, with 1 where j is i, the parent of i, and so on to the root."""
    values = []
    for i in range(len(parents)):
        row = [0.0] * len(parents)
        while i >= 0:
            row[i] = 1.0
            i = parents[i]
        values += row
    return values
'''


def as_python(equations: FamilyEquations, parameters: Mapping[str, float], form: str = "lagrange") -> str:
    """The module's source: T, U, L, momenta, h, forces and accelerations as functions of (t, q, v). With the
    form ``matrix`` also M and f, and with ``hamilton`` H and the canonical equations as functions of (t, q,
    p). With constraints these too, and their multipliers."""
    refuse_names(equations)
    writer = ModuleWriter(equations)
    functions = []
    if equations.T is not None and equations.U is not None:
        functions.append(writer.scalar("kinetic_energy", "T(t, q, v).", equations.T))
        functions.append(writer.scalar("potential_energy", "U(t, q, v).", equations.U))
    functions += [
        writer.scalar("lagrangian", "L(t, q, v).", equations.L),
        writer.vector("momenta", "p_k = dL/dq_dot_k.", equations.momenta),
        writer.scalar("energy_function", "h = sum_k p_k q_dot_k - L.", equations.h),
        writer.vector("generalized_forces", "Q_k(t, q, v).", equations.forces),
    ]
    if equations.accelerations is not None:
        functions.append(writer.vector("accelerations", "q_ddot(t, q, v).", equations.accelerations))
    else:
        functions += linear_functions(equations, writer)
    if form == "matrix":
        purpose = "The diagonal of M in M a = f."
        diagonal = equations.diagonal
        functions.append(writer.matrix() if diagonal is None else writer.vector("masses", purpose, diagonal))
        functions.append(writer.vector("force", "f of M a = f.", equations.rates or ()))
    canonical = hamilton_form(equations) if form == "hamilton" else None
    pulled, pull = ((MULTIPLIERS,), " + (A^T lambda)_k") if equations.constraints else ((), "")
    if canonical is not None and not canonical.solved:
        found = writer.vector("torques", f"dL/dq_k + Q_k{pull}.", canonical.rates, ("q", "v", *pulled))
        functions += [writer.matrix(), found, in_steps(pulled)]
        functions += [] if SOLUTION.strip() in functions else [SOLUTION.strip()]
    elif canonical is not None:
        writer.order, of_p = canonical.order, ("q", "p")
        functions += [
            writer.scalar("hamiltonian", "H(t, q, p).", canonical.H, of_p),
            writer.vector("velocities", "q_dot_k = dH/dp_k.", canonical.velocities, of_p),
            writer.vector(
                "momentum_rates", f"p_dot_k = -dH/dq_k + Q_k{pull}.", canonical.rates, (*of_p, *pulled)
            ),
        ]
    if equations.events:
        functions += event_source.functions(equations, writer)
    title = " ".join(equations.name.split()).replace("\\", "/").replace('"', "'")
    used = sorted({*FUNCTIONS, *CONSTANTS} & writer.used)
    head = [f'"""{title}: the equations of motion. Coordinates are in the order of COORDINATES."""', ""]
    head += [f"from math import {', '.join(used)}", ""] if used else []
    head += [f"{python_name(name)} = {size}" for name, size in equations.sizes.items()]
    names = [name for family in equations.coordinates for name in family.members]
    head += [f"{python_name(table.name)} = {table.by_place!r}" for table in equations.tables.values()]
    free = without(parameters, equations.tables)
    head += [f"COORDINATES = {tuple(names)!r}", f"PARAMETERS = {free!r}"]
    if equations.constraints:
        head.append(f"CONSTRAINTS = {tuple(k for one in equations.bound for k in one.members)!r}")
        if not all(one.complete for one in equations.bound):
            head.append(f"{PLACES} = {grid_places(equations.bound)!r}")
    if equations.events:
        head += event_source.constants(equations, grid_places(event_source.families_of(equations)))
    if equations.paths:
        functions.insert(0, PATHS.strip())
        listed = (f"{one.name} = paths({tuple(one.table.tolist())!r})" for one in equations.paths)
        functions.append("\n".join(listed))
    return "\n".join(head) + "\n\n\n" + with_sign("\n\n\n".join(functions))


def in_steps(pulled: Sequence[str]) -> str:
    """H and the canonical equations by velocities that are computed, with multipliers if there are any."""
    more = "".join(f"{one}, " for one in pulled)
    rates = "\n\n\n".join([LINEAR.strip(), IN_STEPS.strip()]).replace(
        "momentum_rates(t, q, p, ", f"momentum_rates(t, q, p, {more}"
    )
    return rates.replace(
        "torques(t, q, velocities(t, q, p, parameters), parameters)",
        f"torques(t, q, velocities(t, q, p, parameters), {more}parameters)",
    )


def grid_places(families: Sequence[Family]) -> tuple[int, ...]:
    """The places that members of families would have, if no member were missing."""
    found: list[int] = []
    first = 0
    for one in families:
        found += (np.flatnonzero(places_of(one) >= 0) + first).tolist()
        first += prod(one.shape)
    return tuple(found)


def linear_functions(equations: FamilyEquations, writer: ModuleWriter) -> list[str]:
    """The equations of motion and constraints, and how accelerations and multipliers follow from them."""
    left = [line.of(one.left - one.right) for line, one in equations.equations]
    purpose = "The equations of motion, left minus right side, with accelerations a."
    if not equations.constraints:
        found = [writer.vector("equations", purpose, left, ("q", "v", "a")), TOGETHER.strip()]
        return [*found, SOLUTION.strip()]
    bound, values = equations.bound, "f(t, q), or g(t, q, v), of CONSTRAINTS."
    rates = "What CONSTRAINTS say of accelerations a: this is 0."
    return [
        writer.vector("equations", purpose, left, ("q", "v", "a", MULTIPLIERS)),
        writer.vector("constraints", values, equations.constraints, among=bound),
        writer.vector("constraint_rates", rates, equations.allowed, ("q", "v", "a"), bound),
        BORDERED.strip(),
        SOLUTION.strip(),
    ]
