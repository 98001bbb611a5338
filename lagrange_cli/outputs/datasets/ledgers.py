"""The balances of work and energy, and of force and momentum: zero for an exact solution."""

from __future__ import annotations

from lagrange_cli.outputs.planner import Planner, of_family
from lagrange_cli.outputs.recording import Dataset, Making


def plan(planner: Planner) -> None:
    """dh/dt = -dL/dt + sum Q_k q_dot_k and dp_k/dt = dL/dq_k + Q_k, integrated from the start."""
    energetics, mark = planner.balanced()
    text = "h(t) - h(0) + int dL/dt - int sum Q_k q_dot_k: 0 for an exact solution"
    continuous, energy, rate = planner.continuous_energy(energetics)
    source = planner.observe(f"{mark}{continuous}", energy)
    dataset = Dataset("diagnostics/ledger/h", (), text, Making.BALANCE, (source,))
    planner.add_balance(dataset, [rate])
    momenta = dict(zip(planner.model.coordinates, energetics.momenta))
    torques = planner.torques(energetics)
    for family in planner.coordinates:
        text = f"p(t) - p(0) - int (dL/d{family.label} + Q): 0 for an exact solution"
        names = tuple(planner.observe(f"{mark}p_{name}", momenta[name]) for name in family.members)
        dataset = of_family("diagnostics/ledger/p/", text, Making.BALANCE, family, names)
        planner.add_balance(dataset, [torques[name] for name in family.members])
