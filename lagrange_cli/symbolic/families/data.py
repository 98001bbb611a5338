"""The equations of a system of families as data: by line, with the members for which each line holds."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any

import sympy

from lagrange_cli.errors import UsageError
from lagrange_cli.expression.vocabulary import family_name
from lagrange_cli.model.events import DIRECTIONS, action_of
from lagrange_cli.symbolic.families.equations import EventLine, FamilyEquations
from lagrange_cli.symbolic.families.given import multiplier_name
from lagrange_cli.symbolic.families.hamilton import hamilton_form
from lagrange_cli.symbolic.families.linear import pairs_of
from lagrange_cli.symbolic.families.lines import Line, symbol_of
from lagrange_cli.symbolic.indexed.conditions import Loop
from lagrange_cli.symbolic.notations import IndexedSympy
from lagrange_cli.symbolic.render import render
from lagrange_cli.symbolic.statements import plain


def as_data(
    equations: FamilyEquations, parameters: Mapping[str, float], form: str = "lagrange"
) -> dict[str, Any]:
    """The equations for ``--json``: as of other systems, but by line. Keys are the names of members, such as
    ``x[i]``; ``members_of`` says for which indices a line of a quantity holds, ``members`` of an equation, or
    where there is no equation of this name of something else. ``masses`` are the diagonal of M, where that is
    diagonal, ``mass_matrix`` its entries from the diagonal on, where it is known and not diagonal, and
    ``force`` is f in M a = f. Minv in the form ``hamilton`` is the inverse of M."""
    refuse_names(equations)
    notation = IndexedSympy()

    def text(expression: sympy.Expr | None) -> str | None:
        return None if expression is None else render(expression, notation, equations.order)

    def by_line(lines: Sequence[Line] | None) -> dict[str, str | None] | None:
        return None if lines is None else {one.name(): text(one.expression) for one in lines}

    motion = {line.name(): text(one.left - one.right) for line, one in equations.equations}
    factors = {line.name(): text(one.factor) for line, one in equations.equations}
    lines = [
        *equations.momenta, *(equations.accelerations or ()), *equations.forces, *(equations.diagonal or ()),
        *(line for line, _ in equations.equations),
    ]  # fmt: skip
    loops = {one.name(): one.loops for one in lines} | {
        one.symbol.name: one.loops for one in equations.places
    }
    entries = entries_of(equations)
    tables = {one.name: one.listed for one in equations.tables.values()}
    data: dict[str, Any] = {
        "name": equations.name,
        "coordinates": [name for family in equations.coordinates for name in family.members],
        "parameters": without(parameters, tables),
        "sizes": dict(equations.sizes),
        **({"tables": tables} if tables else {}),
        "families": {
            one.name: list(one.shape) for one in (*equations.coordinates, *equations.parameters) if one.shape
        },
        "members": {name: spoken(own) for name, own in loops.items()},
        "members_of": members_of(equations),
        "T": text(equations.T),
        "U": text(equations.U),
        "L": text(equations.L),
        **({"constraints": constraint_data(equations, text)} if equations.constraints else {}),
        "momenta": by_line(equations.momenta),
        "generalized_forces": by_line(equations.forces),
        "positions": {one.symbol.name: text(one.expression) for one in equations.places},
        "paths": {one.name: parents(one.table) for one in equations.paths},
        "equations": motion,
        "factors": factors,
        "accelerations": by_line(equations.accelerations),
        "masses": by_line(equations.diagonal),
        **({"mass_matrix": by_line(entries)} if entries else {}),
        "force": by_line(equations.rates),
        **({"constraint_force": by_line(equations.pulls)} if equations.pulls else {}),
        "h": text(equations.h),
        "conserved": [
            {
                "quantity": each.quantity,
                "expression": text(equations.h if each.quantity == "h" else each.expression),
                "because": plain(each.because),
                **({"broken_by": list(each.breaks)} if each.breaks else {}),
            }
            for each in equations.conserved
        ],
        **({"events": [event_data(one, text) for one in equations.events]} if equations.events else {}),
        "not_conserved": [
            {"quantity": each.quantity, "rate": text(each.rate), "because": plain(each.because)}
            for each in equations.changing
        ],
    }  # fmt: skip
    if form == "hamilton":
        canonical = hamilton_form(equations)
        if canonical.offsets:
            data["momenta_at_rest"] = by_line(canonical.offsets)
        data["hamiltonian"] = render(canonical.H, notation, canonical.order)
        data["canonical_equations"] = {
            name: {one.name(): render(one.expression, notation, canonical.order) for one in lines}
            for name, lines in (("velocities", canonical.velocities), ("momentum_rates", canonical.rates))
        }
    if equations.reactions is not None:
        found = equations.reactions
        data["reactions"] = by_line(found.lines)
        data["members_of"] |= {"reactions": {one.name(): spoken(one.loops) for one in found.lines}}
        data["positions"] |= {one.symbol.name: text(one.expression) for one in found.places}
        data["members"] |= {one.symbol.name: spoken(one.loops) for one in found.places}
        data["paths"] |= {one.name: parents(one.table) for one in found.paths}
    return data


def entries_of(equations: FamilyEquations) -> Sequence[Line] | None:
    """The entries of M that are not 0, where it is not diagonal. Raises ``UsageError`` where two have one
    name."""
    if equations.diagonal is not None or equations.masses is None:
        return None
    pairs_of(equations.coordinates)
    return [one for one in equations.masses if one.expression != 0]


def constraint_data(
    equations: FamilyEquations, text: Callable[[sympy.Expr], str | None]
) -> list[dict[str, str | None]]:
    """The constraints with their multipliers."""
    return [
        {
            "name": one.name(),
            **kind_and_rate(text(allowed.expression), one.family.name not in equations.nonholonomic),
            "expression": text(one.expression),
            "multiplier": text(symbol_of(one, multiplier_name(one.family.name))),
            "members": spoken(one.loops),
        }
        for one, allowed in zip(equations.constraints, equations.allowed)
    ]


def event_data(each: EventLine, text: Callable[[sympy.Expr], str | None]) -> dict[str, Any]:
    """Events that are alike; of what is set for several members, ``of`` says which."""
    changes = {one.symbol.name: one.value for one in each.changes}
    of = {one.symbol.name: spoken(one.loops) for one in each.changes if one.loops}
    return {
        "name": each.line.name(),
        "when": text(each.line.expression),
        "direction": DIRECTIONS[each.direction],
        "action": action_of(each.stops, changes),
        "set": {name: text(value) for name, value in changes.items()},
        **({"of": of} if of else {}),
        "members": spoken(each.line.loops),
    }


def kind_and_rate(rate: str | None, holonomic: bool) -> dict[str, str | None]:
    """The kind of a constraint, and what it says of the accelerations."""
    if holonomic:
        return {"kind": "holonomic", "second_derivative": rate}
    return {"kind": "nonholonomic", "derivative": rate}


def spoken(loops: Sequence[Loop]) -> str:
    """``for i in range(N) for j in range(M)``."""
    return " ".join(loop.text for loop in loops)


def members_of(equations: FamilyEquations) -> dict[str, dict[str, str]]:
    """For which indices the lines of each quantity hold."""
    quantities = {
        "momenta": equations.momenta,
        "generalized_forces": equations.forces,
        "equations": tuple(line for line, _ in equations.equations),
        "accelerations": equations.accelerations,
        "masses": equations.diagonal,
        "mass_matrix": entries_of(equations),
        "force": equations.rates,
        "constraint_force": equations.pulls,
    }
    return {
        name: {one.name(): spoken(one.loops) for one in lines} for name, lines in quantities.items() if lines
    }


def without(parameters: Mapping[str, float], tables: Collection[str]) -> dict[str, float]:
    """Parameters that are free: those in tables are part of the equations."""
    return {name: value for name, value in parameters.items() if family_name(name) not in tables}


def refuse_names(equations: FamilyEquations) -> None:
    """Raise ``UsageError`` where a name of the file is that of a place, as data and Python have it."""
    for place in equations.places:
        if any(one.name == place.base for one in (*equations.coordinates, *equations.parameters)):
            raise UsageError(f"{place.base} is the name of {place.symbol.name} in this format: rename yours")


def parents(table: Any) -> list[int | None]:
    """The parent of each member of a tree."""
    return [None if one < 0 else int(one) for one in table]
