"""How many convolutions the Taylor series of a system may take: more would take minutes and GB to compile."""

from __future__ import annotations

from lagrange_cli.errors import TooLarge
from lagrange_cli.expression.node import Node
from lagrange_cli.integrate.methods.table import METHODS, Needs
from lagrange_cli.integrate.precision import DOUBLE
from lagrange_cli.limits import chosen, way_out, whole
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.model.model import Model

LONGER, STRAIGHT = 4, 3
"""How many times as much code a convolution of double-doubles takes, and how many times fewer there may be
where members are not computed in batches."""


def foresee_convolutions(model: Model[Node], method: str, precision: str) -> None:
    """Refuse a system before its equations are derived where they are certain to take too many.

    Raises ``TooLarge``; so does ``check_convolutions``, which knows how many they are.
    """
    if METHODS[method].needs is Needs.SERIES:
        from lagrange_cli.mechanics.foresight import least_convolutions

        least = least_convolutions(model, most_convolutions(precision))
        refuse(least, precision, "at least ", bound=bool(model.constraints))


def check_convolutions(residual: Residual, method: str, precision: str) -> None:
    """Refuse a system whose equations take too many."""
    if METHODS[method].needs is Needs.SERIES:
        refuse_like(residual, residual.costs[residual.formulation], precision)


def refuse_like(residual: Residual, found: int, precision: str, least: str = "") -> None:
    """Raise ``TooLarge`` if these are too many for equations like those given."""
    straight = not residual.separate and "convolutions" not in chosen()
    refuse(found, precision, least, straight=straight, bound=bool(residual.model.constraints))


def most_convolutions(precision: str, *, straight: bool = False) -> int:
    """How many an order may take."""
    return whole("convolutions") // (STRAIGHT if straight else 1) // (1 if precision == DOUBLE else LONGER)


def refuse(
    found: int, precision: str, least: str = "", *, straight: bool = False, bound: bool = False
) -> None:
    """Raise ``TooLarge`` if there are too many. Systems that are ``bound`` by constraints have no other
    method."""
    most = most_convolutions(precision, straight=straight)
    if found > most:
        without = next(name for name, row in METHODS.items() if row.needs is not Needs.SERIES)
        another = (
            f"choose --method {without}, which needs none, " if precision == DOUBLE and not bound else ""
        )
        raise TooLarge(
            f"the Taylor series of this system take {least}{found} convolutions per order; "
            f"at most {most} are compiled",
            f"{another}make the system smaller, {way_out('convolutions')}",
        )
