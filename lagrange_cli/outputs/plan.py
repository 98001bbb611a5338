"""``Plan``: what a run must compute for the requested outputs, and how the datasets are made of it.

Only what an output needs is derived: ``observed`` quantities are functions of q, q_dot, t that compiled code
evaluates at the samples, ``integrands`` are carried along as quadratures.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from lagrange_cli.expression.node import Node
from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.mechanics.energetics import Energetics
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.model.model import Model
from lagrange_cli.outputs.recording import Dataset, Making, Recording
from lagrange_cli.records import dataclass, field
from lagrange_cli.spec.spec import Family, grouped

AXES = "xyz"


@dataclass(frozen=True)
class Plan:
    """The names and expressions of what is computed, and the datasets made of it."""

    observed: Mapping[str, Node]
    integrands: Mapping[str, Node]
    recording: Recording


def make_plan(residual: Residual, outputs: frozenset[str]) -> Plan:
    """The plan for ``outputs``: names among q, v, p, h, T, U, energy, positions, ledger, action,
    observables."""
    kept = frozenset(each.quantity for each in residual.conserved)
    planner = _Planner(residual.model, Energetics(residual.model), kept)
    for output, add in (
        ("p", planner.momenta),
        ("h", planner.energy_function),
        ("T", planner.kinetic),
        ("U", planner.potential),
        ("energy", planner.energy),
        ("ledger", planner.ledgers),
        ("action", planner.action),
        ("positions", planner.positions),
        ("observables", planner.observables),
    ):
        if output in outputs:
            add()
    recording = Recording(
        coordinates=residual.coordinates,
        states=planner.states(outputs),
        made=tuple(planner.made),
        conserved=tuple(name for name in planner.observed if name in kept),
    )
    return Plan(planner.observed, planner.integrands, recording)


@dataclass
class _Planner:
    model: Model[Node]
    energetics: Energetics
    kept: frozenset[str]
    """Quantities that are constant along every motion: their rates are taken to be exactly 0."""
    observed: dict[str, Node] = field(default_factory=dict)
    integrands: dict[str, Node] = field(default_factory=dict)
    made: list[Dataset] = field(default_factory=list)

    def states(self, outputs: frozenset[str]) -> tuple[Dataset, ...]:
        kinds = {"q": "coordinate {}", "v": "velocity d{}/dt"}
        return tuple(
            of_family(f"{kind}/", kinds[kind].format(family.label), Making.STATE, family)
            for kind in kinds
            if kind in outputs
            for family in self.coordinates
        )

    @property
    def coordinates(self) -> tuple[Family, ...]:
        return grouped(self.model.coordinates, self.model.families.get("coordinates", {}))

    def watch(self, name: str, node: Node) -> str:
        """Have a quantity observed."""
        self.observed.setdefault(name, node)
        return name

    def add(self, path: str, long_name: str, *names: str) -> None:
        self.made.append(Dataset(path, (), long_name, Making.SUM, names))

    def add_balance(self, dataset: Dataset, integrands: Iterable[Node]) -> None:
        for source, integrand in zip(dataset.sources, integrands):
            if source not in self.kept and not integrand.is_zero:
                self.integrands[dataset.quadrature(source)] = integrand
        self.made.append(dataset)

    def momenta(self) -> None:
        momenta = dict(zip(self.model.coordinates, self.energetics.momenta))
        for family in self.coordinates:
            names = tuple(self.watch(f"p_{name}", momenta[name]) for name in family.members)
            text = f"generalized momentum dL/d({velocity_name(family.label)})"
            self.made.append(of_family("diagnostics/p/", text, Making.STACK, family, names))

    def energy_function(self) -> None:
        text = "energy function sum q_dot_k p_k - L"
        self.add("diagnostics/h", text, self.watch("h", self.energetics.energy_function))

    def kinetic(self) -> None:
        if self.energetics.kinetic is not None:
            self.add("diagnostics/T", "kinetic energy", self.watch("T", self.energetics.kinetic))

    def potential(self) -> None:
        if self.energetics.potential is not None:
            self.add("diagnostics/U", "potential", self.watch("U", self.energetics.potential))

    def energy(self) -> None:
        kinetic, potential = self.energetics.kinetic, self.energetics.potential
        if kinetic is not None and potential is not None:
            self.add("diagnostics/energy", "T + U", self.watch("T", kinetic), self.watch("U", potential))

    def ledgers(self) -> None:
        energetics = self.energetics
        text = "h(t) - h(0) + int dL/dt - int sum Q_k q_dot_k: 0 for an exact solution"
        source = self.watch("h", energetics.energy_function)
        rate = energetics.power - energetics.lagrangian_rate(self.model.time)
        self.add_balance(Dataset("diagnostics/ledger/h", (), text, Making.BALANCE, (source,)), [rate])
        momenta = dict(zip(self.model.coordinates, energetics.momenta))
        torques = dict(zip(self.model.coordinates, energetics.torques))
        for family in self.coordinates:
            text = f"p(t) - p(0) - int (dL/d{family.label} + Q): 0 for an exact solution"
            names = tuple(self.watch(f"p_{name}", momenta[name]) for name in family.members)
            dataset = of_family("diagnostics/ledger/p/", text, Making.BALANCE, family, names)
            self.add_balance(dataset, [torques[name] for name in family.members])

    def action(self) -> None:
        path = "diagnostics/action"
        self.integrands[path] = self.energetics.lagrangian
        self.made.append(Dataset(path, (), "action int L dt", Making.INTEGRAL))

    def positions(self) -> None:
        positions = {particle.name: particle.position for particle in self.model.particles}
        for family in grouped(positions, self.model.families.get("embedding", {})):
            names = tuple(
                self.watch(f"{name}.{axis}", x)
                for name in family.members
                for axis, x in zip(AXES, positions[name])
            )
            text, components = f"position of {family.label}", len(positions[family.members[0]])
            self.made.append(of_family("positions/", text, Making.STACK, family, names, components))

    def observables(self) -> None:
        nodes = self.model.observables
        for family in grouped(nodes, self.model.families.get("observables", {})):
            names = tuple(self.watch(f"observable {name}", nodes[name]) for name in family.members)
            text = f"observable {family.label}"
            self.made.append(of_family("observables/", text, Making.STACK, family, names))


def of_family(
    group: str,
    long_name: str,
    making: Making,
    family: Family,
    sources: tuple[str, ...] = (),
    components: int = 0,
) -> Dataset:
    """The dataset of a quantity that every member of a family has."""
    vector = (components,) if components else ()
    return Dataset(
        group + family.name, (*family.shape, *vector), long_name, making, sources, family.axes, components
    )
