"""Terms of conserved polynomials of a body that turns: in its angular velocity omega along its own axes, and
in a direction gamma that is fixed in space, such as that of a field.

Where the potential energy is a function of gamma, the equations of Euler and Poisson contain gamma and omega
alone. In a field of second degree, U = k gamma . I gamma/2, such as the gradient of gravity,
|I omega|^2 - k gamma . adj(I) gamma is constant (F. Brun, 1893; A. Clebsch, Math. Ann. 3, 238, 1870).
"""

from __future__ import annotations

from collections.abc import Iterator

from lagrange_cli.expression.node import Node
from lagrange_cli.expression.vocabulary import COMPONENTS
from lagrange_cli.expression.zero import is_zero
from lagrange_cli.mechanics.conserved.ansatz import Term, Variables, powers
from lagrange_cli.mechanics.conserved.displacements import displacements
from lagrange_cli.mechanics.conserved.noether import Noether
from lagrange_cli.mechanics.embedding import Embedding
from lagrange_cli.model.model import Model
from lagrange_cli.model.scope import Scope

DEGREES = {0: 3, 1: 2, 2: 2}
"""Degrees in omega, and for each the highest degree in gamma."""


def variables_of_body(model: Model[Node], noether: Noether) -> Iterator[Variables]:
    """Gamma and omega of the only body. Gamma is an axis of space about which everything may be turned
    without a change of L."""
    spec = model.spec
    if spec is None or len(spec.bodies) != 1:
        return
    (body,) = spec.bodies
    turning = Scope(spec, model.algebra).turning(body)
    numbers = range(1, len(COMPONENTS) + 1)
    speeds = [f"{body}.w{i}" for i in numbers]
    for one in displacements(model, Embedding(model)):
        up = next((i for i, axis in enumerate(COMPONENTS) if one.name == f"L_{axis}"), None)
        if up is None or not is_zero(noether.conditions([one.change])[0][0]):
            continue
        gamma = [axis[up] for axis in turning.axes]
        yield Variables(gamma, turning.in_body, [f"{body}.R{up + 1}{i}" for i in numbers], speeds)


def terms_of_body(*, odd: bool) -> list[Term]:
    """The terms; those of an odd degree in omega only if forces are ``odd``: they change when all velocities
    are reversed."""
    n = len(COMPONENTS)
    degrees = [degree for degree in DEGREES if odd or degree % 2 == 0]
    found = [
        Term(speeds, places)
        for degree in degrees
        for speeds in powers(n, degree)
        for most in range(DEGREES[degree] + 1)
        for places in powers(n, most)
    ]
    return [one for one in found if any((*one.speeds, *one.places))]
