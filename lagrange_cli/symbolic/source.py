"""The equations as a Python module of plain functions over ``math``."""

from __future__ import annotations

import re
from collections.abc import Mapping

import sympy

from lagrange_cli.errors import UsageError
from lagrange_cli.expression.vocabulary import CONSTANTS, FUNCTIONS, velocity_name
from lagrange_cli.records import replace
from lagrange_cli.symbolic.constraints import BENT
from lagrange_cli.symbolic.equations import Equations
from lagrange_cli.symbolic.hamilton import hamilton_form, linear_in_velocities, vakonomic_form
from lagrange_cli.symbolic.module_writer import ModuleWriter, sequence
from lagrange_cli.symbolic.notations import identifiers

SIGN = '''
def sign(x):
    """-1, 0 or 1."""
    return int(x > 0) - int(x < 0)
'''.strip()

ELIMINATION = '''
def accelerations(t, q, v, parameters=PARAMETERS):
    """q_ddot(t, q, v), from M a = f."""
    matrix, right = mass_matrix(t, q, v, parameters), force(t, q, v, parameters)
    return solution([[*row, f] for row, f in zip(matrix, right)])
'''

BORDERED = '''
def accelerations(t, q, v, parameters=PARAMETERS):
    """q_ddot(t, q, v), from M a - A^T lambda = f and A a = b."""
    return unknowns(t, q, v, parameters)[: len(COORDINATES)]


def multipliers(t, q, v, parameters=PARAMETERS):
    """lambda(t, q, v), likewise."""
    return unknowns(t, q, v, parameters)[len(COORDINATES) :]


def unknowns(t, q, v, parameters):
    """Accelerations and multipliers."""
    slopes = constraint_matrix(t, q, v, parameters)
    matrix, right = mass_matrix(t, q, v, parameters), force(t, q, v, parameters)
    columns = COLUMNS
    rows = [[*row, *border, f] for row, border, f in zip(matrix, columns, right)]
    zeros, rates = [0.0] * len(slopes), constraint_rates(t, q, v, parameters)
    return solution([*rows, *([*row, *zeros, b] for row, b in zip(slopes, rates))])
'''

COLUMNS = "[[-slope for slope in column] for column in zip(*slopes)]"
PUSHED_COLUMNS = """[
        [-slope - push for slope, push in zip(column, pushes)]
        for column, pushes in zip(zip(*slopes), multiplier_forces(t, q, v, parameters))
    ]"""

LINEAR = '''
def velocities(t, q, p, parameters=PARAMETERS):
    """q_dot(t, q, p), from M q_dot = p - dL/dq_dot at rest."""
    rest = [0.0] * len(COORDINATES)
    matrix, offsets = mass_matrix(t, q, rest, parameters), momenta(t, q, rest, parameters)
    return solution([[*row, own - offset] for row, own, offset in zip(matrix, p, offsets)])
'''

NEWTON = '''
def velocities(t, q, p, parameters=PARAMETERS):
    """q_dot(t, q, p), from dL/dq_dot = p by Newton's method, from rest: M is the derivative of dL/dq_dot."""

    def missing(v):
        return [own - found for own, found in zip(p, momenta(t, q, v, parameters))]

    v = (0.0,) * len(COORDINATES)
    left, part = missing(v), 1.0
    while part:
        step = solution([[*row, own] for row, own in zip(mass_matrix(t, q, v, parameters), left)])
        part = 1.0
        while part:  # halved where it leads away, or to where L has no value
            try:
                new = tuple(x + part * change for x, change in zip(v, step))
                rest = missing(new)
                if sum(x * x for x in rest) < sum(x * x for x in left):
                    v, left = new, rest
                    break
            except (ArithmeticError, TypeError, ValueError):
                pass
            part = part / 2 if part > 1e-9 else 0.0
    if max(map(abs, step)) > 1e-9 * max(map(abs, v)):
        raise ArithmeticError("no velocities with these momenta were found")
    return v
'''

IN_STEPS = '''
def hamiltonian(t, q, p, parameters=PARAMETERS):
    """H(t, q, p)."""
    return energy_function(t, q, velocities(t, q, p, parameters), parameters)


def momentum_rates(t, q, p, parameters=PARAMETERS):
    """p_dot_k = -dH/dq_k + Q_k."""
    return torques(t, q, velocities(t, q, p, parameters), parameters)
'''

SOLUTION = '''
def solution(rows):
    """x of [matrix | right], by Gaussian elimination with partial pivoting."""
    n = len(rows)
    for i in range(n):
        pivot = max(range(i, n), key=lambda k: abs(rows[k][i]))
        rows[i], rows[pivot] = rows[pivot], rows[i]
        for k in range(i + 1, n):
            factor = rows[k][i] / rows[i][i]
            rows[k] = [x - factor * y for x, y in zip(rows[k], rows[i])]
    a = [0.0] * n
    for i in reversed(range(n)):
        a[i] = (rows[i][n] - sum(rows[i][k] * a[k] for k in range(i + 1, n))) / rows[i][i]
    return tuple(a)
'''


def as_python(equations: Equations, form: str, parameters: Mapping[str, float]) -> str:
    """The module's source: L, momenta, h, mass matrix, force and accelerations as functions of (t, q, v).

    With constraints these too, and their multipliers. With the form ``hamilton`` also H and the canonical
    equations as functions of (t, q, p). Raises ``UsageError`` where there are none, and for ``vakonomic``.
    """
    if form == "vakonomic":
        vakonomic_form(equations)
        raise UsageError("--form vakonomic has no --format python: these are not the equations of motion")
    moved = {*equations.replaced, *map(velocity_name, equations.replaced)}
    for each in equations.events:
        if lost := sorted(moved.intersection(each.changes)):
            raise UsageError(f"no --format python: the event '{each.name}' sets {lost[0]}, which is replaced")
    if not all(each.linear for each in equations.constraints):
        raise UsageError(f"no --format python: {BENT}, which the module would have to solve for")
    writer = ModuleWriter(equations)
    pushed = any(each.pushes for each in equations.constraints)
    none = {each.multiplier: sympy.S.Zero for each in equations.constraints}
    functions = []
    if equations.T is not None and equations.U is not None:
        functions.append(writer.scalar("kinetic_energy", "T(t, q, v).", equations.T))
        functions.append(writer.scalar("potential_energy", "U(t, q, v).", equations.U))
    functions += [
        writer.scalar("lagrangian", "L(t, q, v).", equations.L),
        writer.vector("momenta", "p_k = dL/dq_dot_k.", equations.momenta),
        writer.scalar("energy_function", "h = sum_k p_k q_dot_k - L.", equations.h),
        writer.vector(
            "generalized_forces",
            "Q_k(t, q, v), but for what multipliers add." if pushed else "Q_k(t, q, v).",
            [force.xreplace(none) for force in equations.generalized_forces],
        ),
        writer.matrix("mass_matrix", "M of M a = f: its rows.", equations.mass_matrix),
        writer.vector("force", "f of M a = f.", equations.force),
    ]
    if equations.constraints:
        functions += constraint_functions(equations, writer)
    if equations.accelerations is None:
        columns = PUSHED_COLUMNS if pushed else COLUMNS
        bordered = BORDERED.replace("COLUMNS", columns)
        functions.append((bordered if equations.constraints else ELIMINATION).strip())
        functions.append(SOLUTION.strip())
    else:
        functions.append(writer.vector("accelerations", "q_ddot(t, q, v).", equations.accelerations))
    if form == "reactions":
        rows = [each.components for each in equations.reactions]
        functions.append(writer.matrix("reactions", "R = m a - F on each of PARTICLES.", rows))
    if equations.replaced:
        purpose = f"{', '.join(equations.replaced)}, coordinates of the file, as functions of q and t."
        functions.append(writer.vector("replaced", purpose, [*equations.replaced.values()]))
    if equations.events:
        functions += event_functions(with_known_multipliers(equations), writer)
    if form == "hamilton":
        canonical = hamilton_form(equations)
        if canonical.solved:
            writer = ModuleWriter(equations, canonical.order, canonical.p)
            functions += [
                writer.scalar("hamiltonian", "H(t, q, p).", canonical.H),
                writer.vector("velocities", "q_dot_k = dH/dp_k.", canonical.velocities),
                writer.vector("momentum_rates", "p_dot_k = -dH/dq_k + Q_k.", canonical.rates),
            ]
        else:
            functions.append(writer.vector("torques", "dL/dq_k + Q_k, at (t, q, v).", canonical.rates))
            functions.append((LINEAR if linear_in_velocities(equations) else NEWTON).strip())
            functions.append(IN_STEPS.strip())
            functions += [] if SOLUTION.strip() in functions else [SOLUTION.strip()]
    body = "\n\n\n".join(functions)
    used = sorted(name for name in {*FUNCTIONS, *CONSTANTS} if re.search(rf"\b{name}\b", body))
    body = with_sign(body)
    head = [
        f'"""{plain(equations.name)}: equations of motion.',
        "",
        "t is the time; q, v and p are sequences in the order of COORDINATES; parameters is a mapping",
        'like PARAMETERS."""',
        "",
        *([f"from math import {', '.join(used)}", ""] if used else []),
        f"COORDINATES = {sequence([repr(name) for name in equations.coordinates])}",
        f"PARAMETERS = {dict(parameters)!r}",
    ]
    if equations.constraints:
        head.append(f"CONSTRAINTS = {sequence([repr(each.name) for each in equations.constraints])}")
    if form == "reactions":
        head.append(f"PARTICLES = {sequence([repr(each.particle) for each in equations.reactions])}")
    if equations.events:
        head.append(f"EVENTS = {sequence([repr(each.name) for each in equations.events])}")
        head.append(f"DIRECTIONS = {sequence([str(each.direction) for each in equations.events])}")
    return "\n".join(head) + "\n\n\n" + body


def with_sign(body: str) -> str:
    """The functions of a module, behind that of the sign, which ``math`` does not have, if it is used."""
    return f"{SIGN}\n\n\n{body}" if re.search(r"\bsign\(", body) else body


def constraint_functions(equations: Equations, writer: ModuleWriter) -> list[str]:
    """The constraints, their accelerations, and the multipliers where they are explicit."""
    each = equations.constraints
    found = [
        writer.vector(
            "constraints", "f(t, q), or g(t, q, v), of CONSTRAINTS.", [one.expression for one in each]
        ),
        writer.matrix("constraint_matrix", "A of A a = b: its rows.", [one.slopes for one in each]),
        writer.vector("constraint_rates", "b of A a = b.", [one.rate for one in each]),
    ]
    if any(one.pushes for one in each):
        rows = [[one.pushes[k] for one in each] for k in range(len(equations.q))]
        purpose = "B of M a = f + (A^T + B) lambda: its rows, what multipliers add to Q_k."
        found.append(writer.matrix("multiplier_forces", purpose, rows))
    if equations.multipliers is not None:
        purpose = "lambda(t, q, v): the generalized forces of constraint are A^T lambda."
        found.append(writer.vector("multipliers", purpose, equations.multipliers))
    return found


def event_functions(equations: Equations, writer: ModuleWriter) -> list[str]:
    """The expressions of the events, and for each that sets something the state after it."""
    arguments = [each.when for each in equations.events]
    found = [writer.vector("events", "What becomes 0 at each of EVENTS, in one of DIRECTIONS.", arguments)]
    names = identifiers(each.name for each in equations.events)
    for each in equations.events:
        if each.changes:
            purpose = f"q, v and parameters after the event {each.name!r}, of those before."
            found.append(writer.after(f"after_{names[each.name]}", purpose, each.changes))
    return found


def with_known_multipliers(equations: Equations) -> Equations:
    """The equations with multipliers in events as functions of the state. Raises ``UsageError``."""
    symbols = [each.multiplier for each in equations.constraints]
    written = [one for each in equations.events for one in (each.when, *each.changes.values())]
    if all(one.free_symbols.isdisjoint(symbols) for one in written):
        return equations
    if equations.multipliers is None:
        raise UsageError(f"no --format python: events contain multipliers, and {equations.unsolved}")
    known = dict(zip(symbols, equations.multipliers, strict=True))
    events = tuple(
        replace(
            each,
            when=each.when.xreplace(known),
            changes={name: one.xreplace(known) for name, one in each.changes.items()},
        )
        for each in equations.events
    )
    return replace(equations, events=events)


def plain(name: str) -> str:
    """The name, made safe for a docstring."""
    return " ".join(name.replace("\\", "/").replace('"', "'").split())
