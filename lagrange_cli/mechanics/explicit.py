"""The equations with their time derivatives written out, R(q, q_dot, q_ddot, t), and what Newton
iterations need.

Taylor series never need this form; implicit methods do, for the Jacobian of the accelerations
a(q, q_dot, t): from R(q, q_dot, a, t) = 0, M da/dx = -dR/dx at fixed a.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from lagrange_cli.expression.node import Kind, Node, reachable, union
from lagrange_cli.expression.vocabulary import acceleration_name
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.mechanics.substitution import rewritten, substituted
from lagrange_cli.mechanics.variables import graph_of, numbered
from lagrange_cli.model.model import Model
from lagrange_cli.records import dataclass, replace


@dataclass(frozen=True)
class Linearization:
    """``accelerations`` are the symbols q_ddot; ``by_q[j][k]`` = dR_j/dq_k and ``by_v[j][k]`` =
    dR_j/dq_dot_k."""

    accelerations: tuple[Node, ...]
    by_q: tuple[tuple[Node, ...], ...]
    by_v: tuple[tuple[Node, ...], ...]


def expanded(
    residual: Residual, nodes: Sequence[Node] | None = None
) -> tuple[tuple[Node, ...], tuple[Node, ...]]:
    """(symbols of the accelerations, R_k in q, q_dot, q_ddot, t and cyclic momenta without ``ddt`` nodes); or
    other ``nodes`` than R_k."""
    return at_rates(residual.model, residual.residual if nodes is None else nodes)


def at_rates(model: Model[Node], nodes: Sequence[Node]) -> tuple[tuple[Node, ...], tuple[Node, ...]]:
    """(symbols of the accelerations, ``nodes`` with their time derivatives written out)."""
    graph = graph_of(model)
    accelerations = tuple(graph.symbol(acceleration_name(name)) for name in model.coordinates)
    rates = [*zip(model.q, model.v), *zip(model.v, accelerations), (model.time, graph.one)]
    numbers = numbered(symbol for symbol, _ in rates)

    def change(node: Node, arguments: list[Node]) -> Node | None:
        if node.kind is not Kind.DDT:
            return None
        slopes = graph.gradient(arguments[0], numbers).items()
        return graph.sum([(slope * rates[i][1], 1.0) for i, slope in slopes])

    return accelerations, rewritten(graph, nodes, change)


def write_out(residual: Residual) -> tuple[tuple[Node, ...], tuple[Node, ...]]:
    """(symbols of the accelerations, R_k in q, q_dot, q_ddot, t without ``ddt`` nodes)."""
    accelerations, rows = expanded(residual)
    momenta = {one.symbol: one.momentum for one in residual.cyclic_momenta}
    return accelerations, substituted(residual.graph, rows, momenta)


@dataclass(frozen=True)
class Holder:
    """A switch in equations at one state. Its ``mode`` is the sign of the first of its ``arguments``.

    It is 0 where all of them are 0 and the multiplier is between -1 and 1: ``force`` over ``limit``, in
    unknowns of these equations. ``rate`` is that of the last argument. Without such a ``multiplier`` a switch
    does not hold. Friction along a vector has a multiplier for each of its ``parts``, with a value. The
    square of all is in place of the one.
    """

    mode: Node
    arguments: tuple[Node, ...]
    multiplier: Node | None = None
    force: Node | None = None
    limit: Node | None = None
    rate: Node | None = None
    parts: tuple[tuple[Node, Node], ...] = ()


@dataclass(frozen=True)
class Unknowns:
    """Accelerations and multipliers at one state: what they solve, and their ``symbols``.

    ``matrix`` times them is -``rest``: the equations without them, in q, q_dot, t. Where these are not linear
    in multipliers, ``rest`` are the equations without accelerations, and ``quiet`` is what Newton's method
    begins with. The equations may contain the modes of ``holders`` (see ``holding``).
    """

    residual: Residual
    symbols: tuple[Node, ...]
    rest: tuple[Node, ...]
    quiet: Unknowns | None = None
    holders: tuple[Holder, ...] = ()


def unknowns(residual: Residual) -> Unknowns:
    """The equations of motion, to be solved at one state."""
    accelerations, rows = write_out(residual)
    symbols = (*accelerations, *residual.multipliers)
    bent = residual.bent and residual.quiet is not None
    rest = substituted(
        residual.graph, rows, dict.fromkeys(accelerations if bent else symbols, residual.graph.zero)
    )
    return Unknowns(residual, symbols, rest, unknowns(residual.quiet) if bent and residual.quiet else None)


def at_a_state(residual: Residual, nodes: Iterable[Node]) -> tuple[Unknowns | None, tuple[Node, ...]]:
    """Functions of q, q_dot, t, time derivatives and multipliers as functions of a state and of unknowns;
    these are None where none occurs. The forces of contacts are left out: what depends on them is refused
    before."""
    if residual.contacts:
        free = dict.fromkeys((one.rest for one in residual.contacts), residual.graph.zero)
        residual = replace(
            residual, residual=substituted(residual.graph, residual.residual, free), contacts=()
        )
    given, rates = [*nodes], set[Node]()
    accelerations, found = expanded(residual, given)
    for node in reachable(given):
        if node.kind is Kind.DDT or not rates.isdisjoint(node.arguments):
            rates.add(node)
    plain = tuple(new if node in rates else node for node, new in zip(given, found))
    bits = union((*accelerations, *residual.multipliers))
    return unknowns(residual) if any(node.symbols & bits for node in plain) else None, plain


def linearize(residual: Residual) -> Linearization:
    """The derivatives of R at fixed accelerations."""
    graph, model = residual.graph, residual.model
    accelerations, rows = write_out(residual)
    return Linearization(
        accelerations,
        tuple(tuple(graph.diff(row, q) for q in model.q) for row in rows),
        tuple(tuple(graph.diff(row, v) for v in model.v) for row in rows),
    )
