"""``Planner``: gathers what the requested outputs have computed, and the datasets that are made of it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import prod
from typing import TYPE_CHECKING

from lagrange_cli.errors import NotDefined
from lagrange_cli.expression.node import Node, union
from lagrange_cli.expression.vocabulary import COMPONENTS
from lagrange_cli.mechanics.conservation import Conserved, conservation
from lagrange_cli.mechanics.energetics import Energetics
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.switching.switches import switches
from lagrange_cli.mechanics.variables import graph_of, variables
from lagrange_cli.model.model import Model
from lagrange_cli.outputs.recording import Dataset, Making
from lagrange_cli.records import dataclass, field, replace
from lagrange_cli.spec.spec import Family, grouped

if TYPE_CHECKING:
    from lagrange_cli.outputs.bodies import Bodies


@dataclass
class Planner:
    """The system, and what has been planned so far.

    ``observed`` quantities are functions of q, q_dot, t that compiled code evaluates at the samples, the
    ``integrands`` are carried along as quadratures. ``states`` are datasets of q and v, ``made`` all others.
    ``conserved`` quantities are constant along every motion: their rates are taken to be exactly 0. Observed
    quantities that are ``kept`` are found to be constant besides. Where only states are looked at in which
    friction does not hold (``loose``), forces of constraint follow from the state.
    Of outputs that are ``optional`` what is ``undefined`` is left out, and why it is said.
    """

    residual: Residual
    energetics: Energetics
    conserved: frozenset[str]
    optional: frozenset[str] = frozenset()
    observed: dict[str, Node] = field(default_factory=dict)
    integrands: dict[str, Node] = field(default_factory=dict)
    states: list[Dataset] = field(default_factory=list)
    made: list[Dataset] = field(default_factory=list)
    kept: list[str] = field(default_factory=list)
    undefined: list[str] = field(default_factory=list)
    loose: bool = False

    @property
    def model(self) -> Model[Node]:
        """The system."""
        return self.residual.model

    def further(self) -> Sequence[tuple[Conserved, Node]]:
        """Conserved quantities besides h and momenta of cyclic coordinates, without those that a force of
        resting contact may change."""
        from lagrange_cli.mechanics.conserved.symmetries import symmetries

        model = self.residual.independent
        if not self.residual.contacts:
            return [(one.conserved, one.node) for one in symmetries(model, self.residual.conserved)]
        from lagrange_cli.mechanics.contacts import lasts_in_contact, without_contacts

        model = without_contacts(self.residual)
        found = [(one.conserved, one.node) for one in symmetries(model, conservation(model)[1])]
        return [one for one in found if lasts_in_contact(self.residual, *one)]

    def kept_by_constraints(self) -> Sequence[tuple[Conserved, Node]]:
        """Functions of coordinates and t that constraints on velocities keep constant."""
        from lagrange_cli.mechanics.constrained.potentials import integrals

        return integrals(self.residual.independent)

    @property
    def bodies(self) -> Bodies:
        """What rigid bodies do."""
        from lagrange_cli.outputs.bodies import BodiesOfModel

        return BodiesOfModel(self.model)

    def families(self, section: str, names: Iterable[str]) -> tuple[Family, ...]:
        """The names that a section of the file declares, by family."""
        return grouped(names, self.model.families.get(section, {}))

    def observables(self) -> Mapping[str, Node]:
        """What the file declares, with the multipliers of least norm where these are not unique.

        Those with multipliers that do not follow from the state are left out where observables are optional,
        else ``NotDefined`` is raised.
        """
        model = self.model
        found, constraints = model.observables, (*model.constraints, *model.redundant)
        pulled = union(one.multiplier for one in constraints)
        pulling = {name: node for name, node in found.items() if node.symbols & pulled}
        if not pulling:
            return found
        reason = self.unknown_forces()
        if reason and "observables" in self.optional:
            families = ", ".join(f"'{one.label}'" for one in self.families("observables", pulling))
            self.undefined.append(f"{families}, as {reason}")
            return {name: node for name, node in found.items() if name not in pulling}
        self.need_forces("observables")
        if not model.redundant:
            return found
        from lagrange_cli.mechanics.constrained.redundancy import multipliers_of_least_norm

        least = multipliers_of_least_norm(model)
        values = {one.multiplier: least[one.name] for one in constraints}
        return dict(zip(found, substituted(graph_of(model), [*found.values()], values)))

    def reactions(self) -> tuple[Mapping[str, tuple[Node, ...]], Mapping[str, str]]:
        """The forces of constraint on particles, and why those on others are not known, by name."""
        from lagrange_cli.mechanics.constrained.reactions import Reactions

        found = Reactions(self.model)
        return found.on_particles, found.unknown

    def balanced(self) -> tuple[Energetics, str]:
        """The energies whose balances are drawn up, and how what is observed of them is marked.

        Terms of a given L that are a total time derivative dF/dt are left out: what they add to p is dF/dq,
        and what they add to its rate is the rate of that, so they balance identically, except for rounding
        that is large where F is steep.
        """
        from lagrange_cli.mechanics.gauge import acting

        model, given = self.model, self.model.lagrangian
        if given is None:
            return self.energetics, ""
        left = acting(model, graph_of(model), given)
        if left is given:
            return self.energetics, ""
        return Energetics(replace(model, lagrangian=left)), "acting "

    def continuous_energy(self, energetics: Energetics) -> tuple[str, Node, Node]:
        """h and its rate, without what jumps at times in both of them, if anything does; and its name."""
        from lagrange_cli.mechanics.switching.times import switched_energy

        h, rate = energetics.energy_function, energetics.energy_rate(self.model.time)
        jumping, own = switched_energy(self.model, energetics.lagrangian)
        return ("h", h, rate) if jumping.is_zero else ("h between jumps", h - jumping, rate - own)

    def torques(self, energetics: Energetics) -> Mapping[str, Node]:
        """dL/dq_k + Q_k by coordinate; 0 where p_k is constant wherever the constraints hold, as that of a
        coordinate without mass is: the forces on these cancel to the last bit, and rounding would be all
        there is to integrate."""
        graph, moving = graph_of(self.model), variables(self.model)
        momenta = [*energetics.momenta]
        if self.model.constraints:
            from lagrange_cli.mechanics.conserved.noether import Noether

            momenta = [*substituted(graph, momenta, Noether(self.residual.independent).eliminated)]
        rates = zip(self.model.coordinates, momenta, energetics.torques)
        return {name: rate if p.symbols & moving else graph.zero for name, p, rate in rates}

    @property
    def coordinates(self) -> tuple[Family, ...]:
        """The coordinates by family."""
        return self.families("coordinates", self.model.coordinates)

    @property
    def constraints(self) -> tuple[Family, ...]:
        """The constraints by family."""
        names = [one.name for one in (*self.model.constraints, *self.model.redundant)]
        if self.model.spec is not None:  # in the file's order, whichever depend on others
            order = {name: i for i, name in enumerate(self.model.spec.all_constraints)}
            names.sort(key=order.__getitem__)
        families = self.model.families
        return grouped(names, {**families.get("nonholonomic", {}), **families.get("constraints", {})})

    def need_forces(self, output: str, *, multipliers: bool = False) -> None:
        """Raise ``NotDefined`` where forces of constraint do not follow from a state, as ``output`` needs."""
        if reason := self.unknown_forces(multipliers=multipliers):
            raise NotDefined(f"no output '{output}': {reason}: choose outputs without it, such as q,v,h")

    def unknown_forces(self, *, multipliers: bool = False) -> str:
        """Why forces of constraint do not follow from a state, all of them or those of ``multipliers``; empty
        if they do."""
        if self.loose:
            return ""
        contacts, bent = self.residual.contacts, self.residual.bent
        if not contacts and not (bent and switches(self.residual.residual, self.residual.variables)):
            return ""
        from lagrange_cli.mechanics.contacts import pressing
        from lagrange_cli.mechanics.guards.equations import guarded

        held = guarded(self.residual, {}).auxiliary
        if held > len(contacts):
            what = "a contact or friction" if contacts else "friction that is not linear in multipliers"
            return f"{what} may keep this system at rest, and these forces are not determined by q and v"
        if pressed := pressing(self.residual, contacts) if multipliers else contacts:
            model = self.model
            names = " and ".join(f"'{model.events[one.event].name}'" for one in pressed)
            event, action = ("event", "its action") if len(pressed) == 1 else ("events", "their actions")
            moving = " and the constraint forces with it" if multipliers else ""
            return (
                f"the motion may come to rest at {event} {names}, as {action} may reduce the speed; the "
                f"force of that contact{moving} is not determined by q and v"
            )
        return ""

    def observe(self, name: str, node: Node) -> str:
        """Have a quantity observed; what several outputs need is observed once."""
        self.observed.setdefault(name, node)
        return name

    def add(self, path: str, long_name: str, *names: str) -> None:
        """The dataset of a scalar: the sum of the observed quantities ``names``."""
        self.made.append(Dataset(path, (), long_name, Making.SUM, names))

    def add_family(
        self, group: str, long_name: str, family: Family, names: tuple[str, ...], components: int = 0
    ) -> None:
        """The dataset of a quantity that every member of a family has, observed as ``names``."""
        self.made.append(of_family(group, long_name, Making.STACK, family, names, components))

    def add_vectors(self, group: str, what: str, section: str, vectors: Mapping[str, Sequence[Node]]) -> None:
        """The datasets of a vector that all members of a section's families have, by their names."""
        for family in self.families(section, vectors):
            names = tuple(
                self.observe(f"{what} {name} {axis}", x)
                for name in family.members
                for axis, x in zip(COMPONENTS, vectors[name])
            )
            components = len(vectors[family.members[0]])
            self.add_family(group, f"{what} {family.label}", family, names, components)

    def add_state(self, group: str, long_name: str, family: Family) -> None:
        """The dataset of coordinates or velocities."""
        self.states.append(of_family(group, long_name, Making.STATE, family))

    def add_integral(self, path: str, long_name: str, integrand: Node) -> None:
        """The dataset of a quadrature from the start."""
        self.integrands[path] = integrand
        self.made.append(Dataset(path, (), long_name, Making.INTEGRAL))

    def add_balance(self, dataset: Dataset, integrands: Iterable[Node]) -> None:
        """The dataset of x - x(0) minus the quadrature of what should be the rate of each observed x."""
        for source, integrand in zip(dataset.sources, integrands):
            if source not in self.conserved and not integrand.is_zero:
                self.integrands[dataset.quadrature(source)] = integrand
        self.made.append(dataset)


def of_family(
    group: str,
    long_name: str,
    making: Making,
    family: Family,
    sources: tuple[str, ...] = (),
    components: int = 0,
) -> Dataset:
    """The dataset of a quantity that every member of a family has. Where some members are missing, the others
    are along one axis."""
    vector, path = (components,) if components else (), group + family.name
    shape = (*family.shape, *vector)
    if not sources or len(sources) == prod(shape):
        return Dataset(path, shape, long_name, making, sources, family.axes, components)
    places, axes = tuple(family.places), (f"{family.name}_index",)
    return Dataset(path, (len(places), *vector), long_name, making, sources, axes, components, places)
