"""Conserved quantities with the reason in words, and others with their rates of change."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import sympy

from lagrange_cli.expression.symbolic_switches import Sign, Switch
from lagrange_cli.model.constraints import without_force, without_work
from lagrange_cli.model.events import between_events, changes_of
from lagrange_cli.model.model import Model
from lagrange_cli.records import replace
from lagrange_cli.symbolic.constraints import forces_of
from lagrange_cli.symbolic.equations import Changing, Conserved, Constraint
from lagrange_cli.symbolic.grouping import tidy
from lagrange_cli.symbolic.order import Order
from lagrange_cli.symbolic.slopes import gradient, slope

Energies = tuple[sympy.Expr | None, sympy.Expr | None, sympy.Expr, sympy.Expr]
"""T, U (None where L is given), L, h."""

SINGLE_VALUED = (sympy.sin, sympy.cos, sympy.tan, sympy.exp, sympy.sinh, sympy.cosh, sympy.tanh)


def balance(
    model: Model[sympy.Expr],
    order: Order,
    energies: Energies,
    rows: tuple[Sequence[sympy.Expr], Sequence[sympy.Expr], Sequence[sympy.Expr]],
    accelerations: Sequence[sympy.Expr] | None,
    constraints: Sequence[Constraint] = (),
) -> tuple[tuple[Conserved, ...], tuple[Changing, ...]]:
    """The conserved quantities and those that are not; ``rows`` are p_k, dL/dq_k and Q_k for every k, without
    forces of constraint in Q_k."""
    momenta, slopes, forces = rows
    conserved: list[Conserved] = []
    changing: list[Changing] = []
    lagrangian = energies[2]
    bound, held = forces_of(constraints, len(model.q)), any(each.acts for each in constraints)
    for name, q, momentum, rate, force, own in zip(
        model.coordinates, model.q, momenta, slopes, forces, bound, strict=True
    ):
        if rate != 0 or branches_on(lagrangian, q, order):
            continue
        if force == own == 0:
            because = f"`{name}` is cyclic: `L` does not contain it, and {without_force(held)}"
            conserved.append(Conserved(f"p_{name}", momentum, because))
        else:
            kinds = "a generalized force" * (force != 0), "a force of constraint" * (own != 0)
            acting = " and ".join(filter(None, kinds))
            because = f"`{name}` is cyclic, but {acting} {'act' if all(kinds) else 'acts'} on it"
            changing.append(Changing(f"p_{name}", rate_of(force + own, order), because))
    balance_energy(model, order, energies, forces, accelerations, constraints, conserved, changing)
    changes, surfaces = changes_of(model), surfaces_of_events(model)
    return tuple(broken(each, changes, surfaces, order) for each in conserved), tuple(changing)


def surfaces_of_events(model: Model[sympy.Expr]) -> dict[str, dict[sympy.Expr, sympy.Expr]]:
    """By event, a coordinate that its argument is linear in, or of second degree, with the value at which it
    happens."""
    found, moving = dict[str, dict[sympy.Expr, sympy.Expr]](), [*model.q, *model.v, model.time]
    for event in model.events:
        slopes = {q: slope(event.argument, q) for q in model.q if event.changes}
        for q, rate in slopes.items():
            if rate != 0 and not depends_on(rate, moving):
                found[event.name] = {q: sympy.expand(q - event.argument / rate)}
                break
        else:
            for q, rate in slopes.items():
                second = slope(rate, q)
                if second != 0 and not depends_on(second, moving):
                    b, c = (sympy.expand(one.xreplace({q: sympy.S.Zero})) for one in (rate, event.argument))
                    found[event.name] = {q: (sympy.sqrt(sympy.expand(b**2 - 2 * second * c)) - b) / second}
                    break
    return found


def broken(
    each: Conserved,
    changes: Mapping[str, dict[sympy.Expr, sympy.Expr]],
    surfaces: Mapping[str, dict[sympy.Expr, sympy.Expr]],
    order: Order,
) -> Conserved:
    """A conserved quantity with the events that may change it; ``changes`` are what each of them sets, and
    ``surfaces`` a coordinate's value where it happens."""
    jumps = {name: each.expression.xreplace(values) - each.expression for name, values in changes.items()}
    breaks = tuple(
        name
        for name, jump in jumps.items()
        if tidy(jump, order) != 0 and tidy(jump.xreplace(surfaces.get(name, {})), order) != 0
    )
    because = f"{each.because}; {between_events(breaks)}" if breaks else each.because
    return replace(each, because=because, breaks=breaks)


def balance_energy(
    model: Model[sympy.Expr],
    order: Order,
    energies: Energies,
    forces: Sequence[sympy.Expr],
    accelerations: Sequence[sympy.Expr] | None,
    constraints: Sequence[Constraint],
    conserved: list[Conserved],
    changing: list[Changing],
) -> None:
    """Append h, with dh/dt = -dL/dt + sum_k Q_k v_k - sum_i lambda_i b_i, and T + U where h is not that.

    Forces of constraint do work where the constraints have drifts b_i: sum_k a_ik v_k = -b_i.
    """
    kinetic, potential, lagrangian, h = energies
    held = any(each.acts for each in constraints)
    slip = tidy(-slope(lagrangian, model.time), order)
    power = tidy(sympy.Add(*(Q * v for Q, v in zip(forces, model.v, strict=True))), order)
    drawn = tidy(-sympy.Add(*(each.multiplier * each.drift for each in constraints)), order)
    identity = describe_energy(model, energies, order)
    branching = branches_on(lagrangian, model.time, order)
    if slip == power == drawn == 0 and not branching:
        because = "`L` does not contain `t` explicitly"
        because += without_work(any(force != 0 for force in forces), held)
        conserved.append(Conserved("h", h, f"{because}{identity}"))
    else:
        working = "generalized forces or friction" * (power != 0), "forces of constraint" * (drawn != 0)
        reasons = ["`L` contains `t` explicitly"] if slip != 0 or branching else []
        if any(working):
            reasons.append(" and ".join(filter(None, working)) + " do work")
        rate = rate_of(slip + power + drawn, order)
        jumps = (slip == 0 and branching) or jumps_at_a_time(model, lagrangian)
        jump = "; where `L` jumps at a time, `h` changes by the opposite" if jumps else ""
        changing.append(Changing("h", rate, " and ".join(reasons) + jump + identity))
    if kinetic is None or potential is None or depends_on(potential, model.v):
        return
    difference = tidy(kinetic + potential - h, order)
    if difference == 0 or accelerations is None:
        return
    *slopes, drift = gradient(difference, [*model.q, *model.v, model.time])
    rates = [one * rate for one, rate in zip(slopes, [*model.v, *accelerations], strict=True)]
    rate = rate_of(sympy.Add(*rates, drift, slip, power, drawn), order)
    because = "the embedding contains `t`, so that the constraint forces do work"
    if rate == 0:
        conserved.append(Conserved("T + U", tidy(kinetic + potential, order), "its rate of change is zero"))
    else:
        changing.append(Changing("T + U", rate, because))


def jumps_at_a_time(model: Model[sympy.Expr], lagrangian: sympy.Expr) -> bool:
    """Whether t alone decides a switch: at a place, where the force would be infinite, L does not jump."""
    decided_by = [node.args[0] for node in lagrangian.atoms(Sign, Switch)]
    return any(depends_on(u, [model.time]) and not depends_on(u, [*model.q, *model.v]) for u in decided_by)


def rate_of(expression: sympy.Expr, order: Order) -> sympy.Expr:
    """A rate of change in textbook form."""
    plain = tidy(expression, order)
    if not plain.is_Add:
        return plain
    from lagrange_cli.symbolic.compact import compact  # of several terms

    return compact(plain, order)


def describe_energy(model: Model[sympy.Expr], energies: Energies, order: Order) -> str:
    """The relation of h to T + U, as the end of a sentence."""
    kinetic, potential, _, h = energies
    if kinetic is None or potential is None:
        return ""
    if tidy(kinetic + potential - h, order) == 0:
        if any(depends_on(component, [model.time]) for p in model.particles for component in p.position):
            return "; `h = T + U` although the embedding contains `t`"
        return "; `h = T + U` (no `t` in the embedding, no velocities in `U`)"
    if depends_on(potential, model.v):
        return "; `h` is not `T + U`, as `U` contains velocities"
    return "; `h` is not `T + U`, as the embedding contains `t`"


def branches_on(expression: sympy.Expr, symbol: sympy.Expr, order: Order) -> bool:
    """Whether ``symbol`` may decide the branch of a function: a derivative does not show a jump."""
    arguments = [
        inner
        for node in expression.atoms(sympy.Pow, sympy.Function)
        for inner in (node.args if node.is_Function else node.args[:1])
        if not (isinstance(node, SINGLE_VALUED) or (node.is_Pow and node.exp.is_Integer))
    ]
    return any(symbol in inner.free_symbols and tidy(slope(inner, symbol), order) != 0 for inner in arguments)


def depends_on(expression: sympy.Expr, symbols: Sequence[sympy.Expr]) -> bool:
    """Whether any of the symbols occurs in the expression."""
    return not expression.free_symbols.isdisjoint(symbols)
