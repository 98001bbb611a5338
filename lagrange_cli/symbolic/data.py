"""The equations as data: strings that sympy and system files accept."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import sympy

from lagrange_cli.model.events import DIRECTIONS, action_of
from lagrange_cli.symbolic.equations import Equations
from lagrange_cli.symbolic.hamilton import hamilton_form
from lagrange_cli.symbolic.notations import Sympy, identifiers
from lagrange_cli.symbolic.render import render
from lagrange_cli.symbolic.report import plain


def as_data(equations: Equations, form: str, parameters: Mapping[str, float]) -> dict[str, Any]:
    """Everything for ``--json``; each expression is a string, each equation an expression that is zero.

    ``momenta``, ``equations`` and ``accelerations`` are mappings by coordinate. Missing quantities (T and U
    of a given L, explicit accelerations that are too long to print) are None. ``parameters`` are by name.
    sympy has its own meaning for some names, such as E or gamma: give sympify
    ``locals={name: Symbol(name), ...}`` for the coordinates and parameters. Members of families, such as
    ``theta[0]``, have other names in the expressions, such as ``theta_0``: ``symbols`` maps them. What an
    event sets is by name, too.
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
        "T": text(equations.T),
        "U": text(equations.U),
        "L": text(equations.L),
        "momenta": by_coordinate(equations.momenta),
        "equations": by_coordinate(each.left - each.right for each in equations.equations),
        "generalized_forces": by_coordinate(equations.generalized_forces),
        "accelerations": None if equations.accelerations is None else by_coordinate(equations.accelerations),
        "mass_matrix": [[text(entry) for entry in row] for row in equations.mass_matrix],
        "force": [text(entry) for entry in equations.force],
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
    if form == "hamilton":
        canonical = hamilton_form(equations)
        order = canonical.order
        notation = Sympy(identifiers(map(str, order.ranks)))
        data["hamiltonian"] = text(canonical.H)
        data["canonical_equations"] = {
            "velocities": by_coordinate(canonical.velocities),
            "momentum_rates": by_coordinate(canonical.rates),
        }
    return data
