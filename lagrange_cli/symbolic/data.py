"""The equations as data: strings that sympy and system files accept."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import sympy

from lagrange_cli.model.events import DIRECTIONS, action_of
from lagrange_cli.symbolic.equations import Equations
from lagrange_cli.symbolic.hamilton import REMARK, hamilton_form, vakonomic_form
from lagrange_cli.symbolic.notations import Sympy, identifiers
from lagrange_cli.symbolic.render import render
from lagrange_cli.symbolic.statements import plain


def as_data(equations: Equations, form: str, parameters: Mapping[str, float]) -> dict[str, Any]:
    """Everything for ``--json``; each expression is a string, each equation an expression that is zero.

    ``momenta``, ``equations`` and ``accelerations`` are mappings by coordinate. Missing quantities (T and U
    of a given L, explicit accelerations that are too long to print) are None. ``parameters`` are by name.
    sympy has its own meaning for some names, such as E or gamma: give sympify
    ``locals={name: Symbol(name), ...}`` for the coordinates and parameters. Members of families, such as
    ``theta[0]``, have other names in the expressions, such as ``theta_0``: ``symbols`` maps them. What an
    event sets is by name, too.

    Constraints are expressions that are zero, each with the symbol of its ``multiplier`` and its ``slopes``
    df/dq_k, or dg/dq_dot_k; ``pushes`` are what applied forces Q_k have in front of it. ``multipliers`` are
    their values by the constraints' names.
    """
    order = equations.order
    notation = Sympy(identifiers(map(str, order.ranks)))

    def text(expression: sympy.Expr | None) -> str | None:
        return None if expression is None else render(expression, notation, order)

    def by_coordinate(expressions: Any) -> dict[str, str | None]:
        return dict(zip(equations.coordinates, map(text, expressions), strict=True))

    renamed = {name: own for name, own in notation.names.items() if name != own}
    data: dict[str, Any] = {
        "name": equations.name,
        "coordinates": list(equations.coordinates),
        "parameters": dict(parameters),
        **({"symbols": renamed} if renamed else {}),
        **(
            {"replaced": {k: text(one) for k, one in equations.replaced.items()}}
            if equations.replaced
            else {}
        ),
        "T": text(equations.T),
        "U": text(equations.U),
        "L": text(equations.L),
        "momenta": by_coordinate(equations.momenta),
        "equations": by_coordinate(each.left - each.right for each in equations.equations),
        "generalized_forces": by_coordinate(equations.generalized_forces),
        "accelerations": None if equations.accelerations is None else by_coordinate(equations.accelerations),
        "mass_matrix": [[text(entry) for entry in row] for row in equations.mass_matrix],
        "force": [text(entry) for entry in equations.force],
        "constraints": [
            {
                "name": each.name,
                "kind": "holonomic" if each.holonomic else "nonholonomic",
                "expression": text(each.expression),
                "multiplier": text(each.multiplier),
                "slopes": by_coordinate(each.slopes),
                "rate": text(each.rate),
                **({"pushes": by_coordinate(each.pushes)} if each.pushes else {}),
            }
            for each in equations.constraints
        ],
        **(
            {"redundant": {name: text(one) for name, one in equations.redundant.items()}}
            if equations.redundant
            else {}
        ),
        "multipliers": None
        if equations.multipliers is None
        else {
            each.name: text(value)
            for each, value in zip(equations.constraints, equations.multipliers, strict=True)
        },
        "h": text(equations.h),
        "conserved": [
            {
                "quantity": each.quantity,
                "expression": text(each.expression),
                "because": plain(each.because),
                **({"broken_by": list(each.breaks)} if each.breaks else {}),
            }
            for each in equations.conserved
        ],
        "not_conserved": [
            {"quantity": each.quantity, "rate": text(each.rate), "because": plain(each.because)}
            for each in equations.changing
        ],
        "events": [
            {
                "name": each.name,
                "when": text(each.when),
                "direction": DIRECTIONS[each.direction],
                "action": action_of(each.stops, each.changes),
                "set": {name: text(value) for name, value in each.changes.items()},
            }
            for each in equations.events
        ],
    }
    if form == "reactions":
        data["reactions"] = {each.particle: [*map(text, each.components)] for each in equations.reactions}
        data["reaction_sizes"] = {each.particle: text(each.size) for each in equations.reactions}
        data["unknown_reactions"] = dict(equations.unknown_reactions)
    if form == "vakonomic":
        wrong = vakonomic_form(equations)
        order, names = (
            wrong.order,
            [each.name for each in equations.constraints if not each.holonomic and each.acts],
        )
        notation = Sympy(identifiers(map(str, order.ranks)))
        data["vakonomic"] = {
            "lagrangian": text(wrong.lagrangian),
            "multipliers": dict(zip(names, map(text, wrong.multipliers), strict=True)),
            "rates": dict(zip(names, map(text, wrong.rates), strict=True)),
            "equations": by_coordinate(each.left - each.right for each in wrong.equations),
            "remark": REMARK,
        }
    if form == "hamilton":
        canonical = hamilton_form(equations)
        order = canonical.order
        notation = Sympy(identifiers(map(str, order.ranks)))
        data["hamiltonian"] = text(canonical.H)
        data["canonical_equations"] = {
            "velocities": by_coordinate(canonical.velocities) if canonical.solved else None,
            "momentum_rates": by_coordinate(canonical.rates),
            "constraints": {
                each.name: text(one)
                for each, one in zip(equations.constraints, canonical.constraints, strict=True)
            },
        }
    return data
