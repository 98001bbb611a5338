"""``Plan``: what a run must compute for the outputs asked for, and how the datasets follow from it.

Only what an output needs is derived: ``observed`` quantities are functions of q, q_dot, t that compiled code
evaluates at the samples, ``integrands`` are carried along as quadratures.
"""

from __future__ import annotations

from collections.abc import Mapping

from lagrange_cli.expression.graph import Node
from lagrange_cli.integrate.recording import Dataset, Making, Recording
from lagrange_cli.mechanics.energetics import Energetics
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.records import dataclass

AXES = "xyz"


@dataclass(frozen=True)
class Plan:
    """Names and expressions of what is computed; the datasets that are made of it."""

    observed: Mapping[str, Node]
    integrands: Mapping[str, Node]
    recording: Recording


def make_plan(residual: Residual, outputs: frozenset[str]) -> Plan:
    """The plan for ``outputs``: names among q, v, p, h, T, U, energy, positions, ledger, action,
    observables."""
    model, energetics = residual.model, Energetics(residual.model)
    observed: dict[str, Node] = {}
    integrands: dict[str, Node] = {}
    made: list[Dataset] = []

    def watch(name: str, node: Node) -> str:
        observed.setdefault(name, node)
        return name

    def add(path: str, long_name: str, *names: str) -> None:
        made.append(Dataset(path, (), long_name, Making.SUM, names))

    def add_ledger(path: str, long_name: str, name: str, integrand: Node) -> None:
        if not integrand.is_zero:
            integrands[path] = integrand
        made.append(Dataset(path, (), long_name, Making.BALANCE, (name,)))

    ledger = "ledger" in outputs
    if outputs & {"p", "ledger"}:
        for name, momentum in zip(model.coordinates, energetics.momenta):
            watch(f"p_{name}", momentum)
            if "p" in outputs:
                add(f"diagnostics/p/{name}", f"generalized momentum dL/d({name}_dot)", f"p_{name}")
    if outputs & {"h", "ledger"}:
        watch("h", energetics.energy_function)
        if "h" in outputs:
            add("diagnostics/h", "energy function sum q_dot_k p_k - L", "h")
    kinetic, potential = energetics.kinetic, energetics.potential
    if kinetic is not None and potential is not None:
        if outputs & {"T", "energy"}:
            watch("T", kinetic)
        if outputs & {"U", "energy"}:
            watch("U", potential)
        if "T" in outputs:
            add("diagnostics/T", "kinetic energy", "T")
        if "U" in outputs:
            add("diagnostics/U", "potential", "U")
        if "energy" in outputs:
            add("diagnostics/energy", "T + U", "T", "U")
    if ledger:
        rate = energetics.power - energetics.lagrangian_rate(model.time)
        add_ledger(
            "diagnostics/ledger/h", "h(t) - h(0) + int dL/dt - int sum Q_k q_dot_k: exactly 0", "h", rate
        )
        for name, torque in zip(model.coordinates, energetics.torques):
            path = f"diagnostics/ledger/p/{name}"
            add_ledger(path, f"p(t) - p(0) - int (dL/d{name} + Q): exactly 0", f"p_{name}", torque)
    if "action" in outputs:
        path = "diagnostics/action"
        integrands[path] = energetics.lagrangian
        made.append(Dataset(path, (), "action int L dt", Making.INTEGRAL))
    if "positions" in outputs:
        for particle in model.particles:
            names = tuple(watch(f"{particle.name}.{a}", x) for a, x in zip(AXES, particle.position))
            path, long_name = f"positions/{particle.name}", f"position of {particle.name}"
            made.append(Dataset(path, (len(names),), long_name, Making.VECTOR, names))
    if "observables" in outputs:
        for name, node in model.observables.items():
            add(f"observables/{name}", f"observable {name}", watch(f"observable {name}", node))
    kept = {each.quantity for each in residual.conserved}
    recording = Recording(
        coordinates=residual.coordinates,
        states=tuple(kind for kind in ("q", "v") if kind in outputs),
        made=tuple(made),
        conserved=tuple(name for name in observed if name in kept),
    )
    return Plan(observed, integrands, recording)
