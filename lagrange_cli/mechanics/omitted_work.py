"""How the equations of a system are integrated, in sentences for the user."""

from __future__ import annotations

from collections.abc import Sequence

from lagrange_cli.expression.node import Kind, Node, reachable, union
from lagrange_cli.expression.zero import is_zero
from lagrange_cli.mechanics.energetics import Energetics
from lagrange_cli.mechanics.residual import Residual

IN_TURN = "some constraints follow from others in turn: each step leaves out those that are best left out"


def has_forces(residual: Residual) -> bool:
    """Whether there are forces besides those in L."""
    return not all(map(is_zero, set(Energetics(residual.model).forces)))


def engine(residual: Residual) -> tuple[str, ...]:
    """How the equations are integrated, a sentence for each fact.

    These are facts of the equations as they are integrated: their mass matrix is that of the formulation.
    """
    model = residual.model
    matrix = "the mass matrix after Routh's reduction" if residual.cyclic_momenta else "the mass matrix"
    if model.constraints:
        matrix = "the matrix of masses and constraints"
    names = (*model.coordinates, *(one.name for one in model.constraints))
    said = [f"formulation: {formulation(residual)}"]
    once = "once per run"
    if any(event.changes for event in model.events):
        once += " and after each event that sets something"
    if residual.constant_mass_matrix:
        said.append(f"{matrix} contains parameters only: it is factored {once}, not once per step")
    size, blocks = len(names), residual.blocks
    if size > 1 and len(blocks) == size:
        said.append(f"{matrix} is diagonal: it is inverted by one division per coordinate")
    elif len(blocks) > 1:
        listed = in_short(["{" + in_short([names[k] for k in block]) + "}" for block in blocks])
        said.append(f"{matrix} is block-diagonal, {listed}: each block is factored separately")
    if residual.surplus:
        said.append(IN_TURN)
    if not any(node.symbols & model.time.symbols for node in residual.residual):
        said.append("the equations do not depend on t: no Taylor series of t is computed")
    count = len(_parameter_nodes(residual))
    if count:
        noun = "subexpression" if count == 1 else "subexpressions"
        said.append(f"{count} {noun} of parameters alone: computed {once}, not once per step")
    said.append("sympy and scipy are not imported: the derivation and the Taylor method do not need them")
    return tuple(said)


def formulation(residual: Residual) -> str:
    """Which formulation was chosen, and why."""
    model, cost = residual.model, residual.costs[residual.formulation]
    dearer = [f"{other} ({name})" for name, other in residual.costs.items() if other > cost]
    said = f"{residual.formulation}, {cost} convolution{'' if cost == 1 else 's'} per order"
    if dearer:
        said += f" instead of {' or '.join(dearer)}"
    names = [
        name
        for name, v in zip(model.coordinates, model.v)
        if v in {one.velocity for one in residual.cyclic_momenta}
    ]
    if names:
        verb, momenta = ("is", "its momentum is") if len(names) == 1 else ("are", "their momenta are")
        said += f": {in_short(names)} {verb} cyclic, {momenta} constant"
    return said


def in_short(words: Sequence[str], most: int = 6) -> str:
    """The words with commas between them, cut off when there are many."""
    return ", ".join([*words[:most], "..."] if len(words) > most else words)


def _parameter_nodes(residual: Residual) -> set[Node]:
    """The largest expressions that hold parameters and nothing that moves, below the equations."""
    entries = [entry for row in residual.entries for entry in row.values()]
    moving = residual.variables | union(one.symbol for one in residual.cyclic_momenta)
    found: set[Node] = set()
    for node in reachable([*residual.residual, *entries]):
        inner = node.arguments if node.symbols & moving else ()
        found.update(a for a in inner if not a.symbols & moving and a.kind not in (Kind.NUMBER,))
    return found
