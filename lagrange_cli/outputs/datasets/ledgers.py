"""The balances of work and energy, and of force and momentum: zero for an exact solution."""

from __future__ import annotations

from collections.abc import Mapping

from lagrange_cli.expression.node import Node
from lagrange_cli.mechanics.energetics import Energetics
from lagrange_cli.mechanics.gauge import acting
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.variables import graph_of, variables
from lagrange_cli.model.model import Model
from lagrange_cli.outputs.planner import Planner, of_family
from lagrange_cli.outputs.recording import Dataset, Making
from lagrange_cli.records import replace


def plan(planner: Planner) -> None:
    """dh/dt = -dL/dt + sum Q_k q_dot_k and dp_k/dt = dL/dq_k + Q_k, integrated from the start."""
    energetics, mark = balanced(planner)
    text = "h(t) - h(0) + int dL/dt - int sum Q_k q_dot_k: 0 for an exact solution"
    source = planner.observe(f"{mark}h", energetics.energy_function)
    rate = energetics.power - energetics.lagrangian_rate(planner.model.time)
    planner.add_balance(Dataset("diagnostics/ledger/h", (), text, Making.BALANCE, (source,)), [rate])
    momenta = dict(zip(planner.model.coordinates, energetics.momenta))
    torques = dict(zip(planner.model.coordinates, energetics.torques))
    for name in held(planner.model, momenta):
        torques[name] = graph_of(planner.model).zero
    for family in planner.coordinates:
        text = f"p(t) - p(0) - int (dL/d{family.label} + Q): 0 for an exact solution"
        names = tuple(planner.observe(f"{mark}p_{name}", momenta[name]) for name in family.members)
        dataset = of_family("diagnostics/ledger/p/", text, Making.BALANCE, family, names)
        planner.add_balance(dataset, [torques[name] for name in family.members])


def held(model: Model[Node], momenta: Mapping[str, Node]) -> list[str]:
    """The coordinates whose momenta are constant wherever the constraints hold, as those without mass have:
    the forces on these cancel to the last bit, and rounding would be all there is to integrate."""
    moving, values = variables(model), list(momenta.values())
    if model.constraints:
        from lagrange_cli.mechanics.conserved.noether import Noether

        values = [*substituted(graph_of(model), values, Noether(model).eliminated)]
    return [name for name, value in zip(momenta, values) if not value.symbols & moving]


def balanced(planner: Planner) -> tuple[Energetics, str]:
    """The energies whose balances are drawn up, and how what is observed of them is marked.

    Terms of a given L that are a total time derivative dF/dt are left out: what they add to p is dF/dq, and
    what they add to its rate is the rate of that, so they balance identically, except for rounding that is
    large where F is steep.
    """
    model, given = planner.model, planner.model.lagrangian
    if given is None:
        return planner.energetics, ""
    left = acting(model, graph_of(model), given)
    if left is given:
        return planner.energetics, ""
    return Energetics(replace(model, lagrangian=left)), "acting "
