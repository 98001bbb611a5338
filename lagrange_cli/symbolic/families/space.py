"""Places, velocities and orientations as quantities of their own, whatever coordinates make of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import sympy

from lagrange_cli.expression.vocabulary import AXES_COMPONENTS, AXES_RATES, BODY_SPIN, SPACE_SPIN
from lagrange_cli.families.groups import Group
from lagrange_cli.model.orientation import Turning
from lagrange_cli.spec.spec import Spec
from lagrange_cli.symbolic.families.builder import Oriented
from lagrange_cli.symbolic.families.frames import Frame
from lagrange_cli.symbolic.families.places import RATES, WrittenPlaces
from lagrange_cli.symbolic.indexed.members import KNOWN, member
from lagrange_cli.symbolic.indexed.whole import Whole


class InSpace(WrittenPlaces):
    """A builder for which every component of a particle's place is a quantity of its own, and so are the
    orientations of bodies."""

    def __init__(self, spec: Spec, components: Mapping[str, int]) -> None:
        super().__init__(spec, naming=False)
        self.components = components

    def of_group(self, group: Group, wholes: Sequence[Whole], values: Sequence[Any], frame: Frame) -> Any:
        name = group.family.name
        if name not in self.components:
            return super().of_group(group, wholes, values, frame)
        found = tuple(placed(name, k, 0, wholes) for k in range(self.components[name]))
        return found if len(found) > 1 else found[0]

    def oriented(self, name: str, wholes: Sequence[Whole], values: Sequence[Any], frame: Frame) -> Oriented:
        def symbols(names: Sequence[str]) -> tuple[sympy.Expr, ...]:
            return tuple(member(f"{name}.{one}", wholes) for one in names)

        axes, rates = (
            tuple(symbols(names[k::3]) for k in range(3)) for names in (AXES_COMPONENTS, AXES_RATES)
        )
        return Oriented("", Turning(axes, rates, symbols(SPACE_SPIN), symbols(BODY_SPIN)), (), {})

    def rate(self, expression: sympy.Expr) -> sympy.Expr:
        """The velocity of a component, by its name."""
        base, wholes = KNOWN.get(expression.name, ("", ())) if expression.is_Symbol else ("", ())
        name, _, axis = base.partition(".")
        if name in self.components and axis in RATES[0]:
            return placed(name, RATES[0].index(axis), 1, wholes)
        if axis in AXES_COMPONENTS:
            return member(f"{name}.v{axis}", wholes)
        return super().rate(expression)


def placed(name: str, axis: int, rate: int, wholes: Sequence[Whole]) -> sympy.Symbol:
    """The symbol of a component of a place (``rate`` 0) or a velocity (1)."""
    base = f"{name}.{RATES[rate][axis]}"
    return member(base, wholes) if wholes else sympy.Symbol(base)
