"""``equations`` of systems whose equations of motion are too long to print: what can be printed of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lagrange_cli.run.derive import graph_model, located

if TYPE_CHECKING:
    from lagrange_cli.mechanics.conservation import Conserved
    from lagrange_cli.run.equations import Begun

FORMATS = ("text", "unicode")
"""What people read: an incomplete module or JSON would be of no use."""


def written_in_part(begun: Begun, format_: str) -> str:
    """The energies, constraints and momenta that are short enough, and what is conserved, in one of the
    ``FORMATS``; what is ``begun`` of the equations is not derived again.

    Raises ``SpecError`` where that takes too much work, too.
    """
    from lagrange_cli.expression.exact import ExactGraphAlgebra
    from lagrange_cli.mechanics.conservation import conservation
    from lagrange_cli.mechanics.conserved.symmetries import symmetries
    from lagrange_cli.spec.spec import freedom
    from lagrange_cli.symbolic.parts import parts_as_written
    from lagrange_cli.symbolic.work import counting

    spec = begun.spec
    with located(spec), counting():
        model = graph_model(spec, ExactGraphAlgebra())
        known = conservation(model)[1]
        every = (*known, *(one.conserved for one in symmetries(model, known)))
        kept = [(kept_quantity(one), one.because) for one in every]
        free = freedom(spec.degrees_of_freedom, spec.of_first_order)
        return parts_as_written(begun.model, begun.noted, free, kept, format_)


def kept_quantity(one: Conserved) -> str:
    """What is conserved, with its expression unless it is listed with the momenta."""
    return one.quantity if one.quantity.startswith("p_") else f"{one.quantity} = {one.expression}"
