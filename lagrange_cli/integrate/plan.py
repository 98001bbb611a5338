"""``Plan``: what a run must compute for the outputs asked for, and how the datasets follow from it.

Only what an output needs is derived: ``observed`` quantities are functions of q, q_dot, t that compiled code
evaluates at the samples, ``integrands`` are carried along as quadratures.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lagrange_cli.expression.graph import Node
from lagrange_cli.mechanics.energetics import Energetics
from lagrange_cli.mechanics.residual import Residual

Array = NDArray[np.float64]
Series = Mapping[str, Array]
"""Rows by name, each of shape (c,): observed quantities, or quadratures."""

AXES = "xyz"


@dataclass(frozen=True)
class Dataset:
    """One series of the output: its path, the shape of one sample, and what it is."""

    path: str
    shape: tuple[int, ...]
    long_name: str


@dataclass(frozen=True)
class Made:
    """A dataset that is made from observed quantities and quadratures.

    ``make(observed, integrals, first)`` gives its samples; ``first`` holds the observed quantities at
    the start.
    """

    dataset: Dataset
    make: Callable[[Series, Series, Mapping[str, float]], Array]


@dataclass(frozen=True)
class Plan:
    """Names and expressions of what is computed; the datasets beyond t, q and v."""

    observed: Mapping[str, Node]
    integrands: Mapping[str, Node]
    made: tuple[Made, ...]
    states: tuple[str, ...]
    """Which of ``q`` and ``v`` are written."""

    def datasets(self, coordinates: tuple[str, ...]) -> tuple[Dataset, ...]:
        """Every dataset but ``t``, in the file's order."""
        kinds = {"q": "coordinate {}", "v": "velocity d{}/dt"}
        return tuple(
            Dataset(f"{kind}/{name}", (), kinds[kind].format(name))
            for kind in self.states
            for name in coordinates
        ) + tuple(made.dataset for made in self.made)


def make_plan(residual: Residual, outputs: frozenset[str]) -> Plan:
    """The plan for ``outputs``: names among q, v, p, h, T, U, energy, positions, ledger, action,
    observables."""
    model, energetics = residual.model, Energetics(residual.model)
    observed: dict[str, Node] = {}
    integrands: dict[str, Node] = {}
    made: list[Made] = []

    def watch(name: str, node: Node) -> str:
        observed.setdefault(name, node)
        return name

    def add(path: str, long_name: str, name: str) -> None:
        made.append(Made(Dataset(path, (), long_name), lambda seen, _, __: seen[name]))

    def add_ledger(path: str, long_name: str, name: str, integrand: Node) -> None:
        if integrand.is_zero:
            made.append(Made(Dataset(path, (), long_name), lambda seen, _, first: seen[name] - first[name]))
            return
        integrands[path] = integrand
        made.append(
            Made(
                Dataset(path, (), long_name), lambda seen, past, first: seen[name] - first[name] - past[path]
            )
        )

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
            whole = Dataset("diagnostics/energy", (), "T + U")
            made.append(Made(whole, lambda seen, _, __: seen["T"] + seen["U"]))
    if ledger:
        rate = energetics.power - energetics.lagrangian_rate(model.time)
        add_ledger(
            "diagnostics/ledger/h", "h(t) - h(0) + int dL/dt - int sum Q_k q_dot_k: exactly 0", "h", rate
        )
        for name, torque in zip(model.coordinates, energetics.torques):
            path = f"diagnostics/ledger/p/{name}"
            add_ledger(path, f"p(t) - p(0) - int (dL/d{name} + Q): exactly 0", f"p_{name}", torque)
    if "action" in outputs:
        integrands["diagnostics/action"] = energetics.lagrangian
        whole = Dataset("diagnostics/action", (), "action int L dt")
        made.append(Made(whole, lambda _, past, __: past["diagnostics/action"]))
    if "positions" in outputs:
        for particle in model.particles:
            names = [watch(f"{particle.name}.{a}", x) for a, x in zip(AXES, particle.position)]
            made.append(_position(particle.name, names))
    if "observables" in outputs:
        for name, node in model.observables.items():
            add(f"observables/{name}", f"observable {name}", watch(f"observable {name}", node))
    return Plan(observed, integrands, tuple(made), tuple(kind for kind in ("q", "v") if kind in outputs))


def _position(particle: str, names: list[str]) -> Made:
    dataset = Dataset(f"positions/{particle}", (len(names),), f"position of {particle}")
    return Made(dataset, lambda seen, _, __: np.stack([seen[name] for name in names], axis=1))
