"""What a program follows besides the motion: integrals, what guards watch, and what shows hidden forces."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from lagrange_cli.expression.node import Node, union
from lagrange_cli.mechanics.cancellation import singular_sums
from lagrange_cli.mechanics.defect import may_hide
from lagrange_cli.mechanics.guards.equations import guarded
from lagrange_cli.mechanics.guards.guard import Guarded
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.mechanics.switching.saturation import saturated_each
from lagrange_cli.records import dataclass


@dataclass(frozen=True)
class FollowedEquations:
    """The ``smooth`` equations, and the ``integrands`` of all that is integrated beside them, by name: the
    ``arguments`` of guards, ``multipliers`` and ``sums`` that proofs look at, quadratures, and cyclic momenta
    that are ``stored``.

    Steps are ``proven``, of the motion, and of the integrands ``proven_too`` and the arguments that are
    ``doubtful``. It ``hides`` if a force may hide, or proofs were asked for: whether there are any or not.
    """

    smooth: Guarded
    integrands: Mapping[str, Node]
    arguments: Sequence[Node]
    multipliers: int
    sums: Sequence[Node]
    stored: int
    hides: bool
    hiding: bool
    """Whether anything is proven."""
    proven: bool
    proven_too: Sequence[Node]
    doubtful: Sequence[Node]

    @property
    def shown(self) -> tuple[int, int]:
        """How many integrals of multipliers, and of sums, there are."""
        return self.multipliers, len(self.sums)

    @property
    def quadratures(self) -> Mapping[int, Node]:
        """The integrands that are asked for, by their numbers among all."""
        return dict(enumerate(self.smooth.integrands.values(), len(self.arguments) + sum(self.shown)))


def followed(
    residual: Residual,
    integrands: Mapping[str, Node],
    *,
    stepping: bool,
    store_momenta: bool,
    proven: bool,
    unproven: bool,
) -> FollowedEquations:
    """What follows from equations and the quadratures that are asked for, if steps are taken by series."""
    stored = [str(one.symbol.data) for one in residual.cyclic_momenta] if store_momenta else []
    saturated = saturated_each(residual.graph, [*integrands.values()], residual.variables)
    given = dict(zip(integrands, saturated))
    smooth = guarded(residual, given) if stepping else Guarded(residual, given)
    residual = smooth.residual
    hides = proven or may_hide(residual) or may_hide(residual, smooth.integrands.values())
    # Newton's method gives no bound for the error of multipliers
    provable = stepping and not (residual.bent or unproven)
    hiding = provable and hides
    proven = provable and (proven or may_hide(residual))
    proven_too = [*smooth.integrands.values()] if hiding else []
    arguments = [*(one.argument for one in smooth.guards), *smooth.events, *smooth.limits, *smooth.breaks]
    arguments += smooth.parts
    doubtful = arguments if provable and (proven or may_hide(residual, arguments)) else []
    hiding = hiding or bool(doubtful)
    named = {f"guard {i}": argument for i, argument in enumerate(arguments)}
    shown = {str(one.data): one for one in residual.multipliers} if hiding else {}
    sums: list[Node] = []
    if hiding:
        seen = [*residual.residual, *proven_too, *doubtful]
        sums = singular_sums(seen, residual.variables, union(residual.multipliers))
    summed = {f"sum {i}": one for i, one in enumerate(sums)}
    every = {**named, **shown, **summed, **smooth.integrands, **dict.fromkeys(stored, residual.graph.zero)}
    followed = smooth, every, arguments, len(shown), sums, len(stored)
    return FollowedEquations(*followed, hides, hiding, proven, proven_too, doubtful)
