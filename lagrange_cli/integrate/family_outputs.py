"""What the planner of outputs asks of a system whose families are not expanded: places in totals."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any, cast

from lagrange_cli.families.arrays import Total
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.reactions import reactions
from lagrange_cli.families.turning import Bodies
from lagrange_cli.integrate.family_quantities import Element
from lagrange_cli.mechanics.conservation import Conserved
from lagrange_cli.model.model import Constraint, Model, Particle
from lagrange_cli.outputs.planner import Planner
from lagrange_cli.outputs.recording import Dataset
from lagrange_cli.records import dataclass
from lagrange_cli.spec.content import names_of
from lagrange_cli.spec.spec import grouped


class FamilyPlanner(Planner):
    """Plans with families: quantities are places in totals."""

    def further(self) -> Sequence[tuple[Conserved, Any]]:
        """Conserved quantities besides h and momenta of cyclic coordinates."""
        from lagrange_cli.families.conserved.conservation import constants_of
        from lagrange_cli.families.conserved.currents import elements

        system = self.residual.system  # type: ignore[attr-defined]
        known = {one.quantity for one in self.residual.conserved}
        found = [one for one in constants_of(system).conserved if one.quantity not in known]
        return [*zip(found, elements(system, [one.quantity for one in found]))]

    def kept_by_constraints(self) -> Sequence[tuple[Conserved, Any]]:
        """Whether constraints are integrable is looked at in smaller systems only."""
        return ()

    @property
    def bodies(self) -> BodiesOfFamilies:
        return BodiesOfFamilies(self.residual.system)  # type: ignore[attr-defined]

    def observables(self) -> Mapping[str, Any]:
        """Places in totals; none contains multipliers."""
        return self.model.observables

    def balanced(self) -> tuple[Any, str]:
        """No term of L is a total time derivative of velocities."""
        return self.energetics, ""

    def continuous_energy(self, energetics: Any) -> tuple[str, Any, Any]:
        """h and its rate, or T and its rate where the potential may jump at times; and the name."""
        if energetics.may_jump_at_times:
            return "T", energetics.kinetic_energy, energetics.kinetic_rate
        return "h", energetics.energy_function, energetics.energy_rate(None)

    def torques(self, energetics: Any) -> Mapping[str, Any]:
        """dL/dq_k + Q_k."""
        return dict(zip(self.model.coordinates, energetics.torques))

    def add_balance(self, dataset: Dataset, integrands: Iterable[Any]) -> None:
        for source, (total, index) in zip(dataset.sources, integrands):
            if source not in self.conserved and total.terms:
                self.integrands[dataset.quadrature(source)] = cast("Any", (total, index))
        self.made.append(dataset)

    def reactions(self) -> tuple[Mapping[str, tuple[Any, ...]], Mapping[str, str]]:
        forces, found = reactions(self.residual.system), {}  # type: ignore[attr-defined]
        assert forces is not None
        for family in self.families("embedding", [one.name for one in self.model.particles]):
            for i, name in enumerate(family.members if family.name in forces.known else ()):
                found[name] = tuple((one, i) for one in forces.known[family.name])
        return found, forces.unknown


@dataclass(frozen=True)
class BodiesOfFamilies:
    """What rigid bodies do, as places in totals."""

    system: FamilySystem

    def _of_each(self, arrays: Callable[[Bodies], Sequence[Total]]) -> dict[str, list[Element]]:
        """The numbers of each body in several arrays, by its name."""
        found = {}
        for family in grouped(self.system.spec.bodies, self.system.spec.families.get("bodies", {})):
            totals = arrays(self.system.bodies[family.name])
            for i, name in enumerate(family.members):
                found[name] = [(one, i) for one in totals]
        return found

    @property
    def spins(self) -> Mapping[str, Sequence[Element]]:
        """Angular velocities."""
        return self._of_each(lambda one: one.spin)

    @property
    def orientations(self) -> Mapping[str, Sequence[Element]]:
        """R."""
        return self._of_each(lambda one: [axis[row] for row in range(3) for axis in one.axes])

    @property
    def momenta(self) -> Mapping[str, Sequence[Element]]:
        """Angular momenta."""
        return self._of_each(lambda one: one.momentum)

    @property
    def energies(self) -> Mapping[str, Sequence[Element]]:
        """The energies of rotation."""
        return self._of_each(lambda one: [one.energy])


@dataclass(frozen=True)
class Described:
    """What the planner asks of a residual."""

    system: FamilySystem

    @property
    def contacts(self) -> tuple[()]:
        """Bodies that may rest on each other: none."""
        return ()

    bent = False
    """Whether forces depend on multipliers."""

    @property
    def conserved(self) -> tuple[Conserved, ...]:
        """h, and momenta of cyclic coordinates."""
        from lagrange_cli.families.conserved.conservation import constants_of

        found = constants_of(self.system).conserved
        return tuple(one for one in found if one.quantity == "h" or one.quantity.startswith("p_"))

    @cached_property
    def model(self) -> Model[Any]:
        """Names and families, with places in totals in place of expressions."""
        system, spec = self.system, self.system.spec
        return Model(
            name=spec.name,
            algebra=cast("Any", None),
            coordinates=cast("Any", names_of(spec.coordinates)),
            time=None,
            q=(),
            v=(),
            parameters={},
            particles=cast("Any", Particles(self.particles())),
            potential=None,
            lagrangian=None if spec.lagrangian is None else spec.lagrangian,
            generalized_forces=(),
            dissipation=None,
            observables=dict(system.observables),
            families=spec.families,
            constraints=tuple(self.constraints()),
        )

    def constraints(self) -> Iterator[Constraint[Any]]:
        """What should be 0, and the multipliers."""
        bonds = self.system.bonds
        for i, name in enumerate(bonds.names if bonds else ()):
            assert bonds is not None
            holonomic = i < bonds.holonomic
            yield Constraint(name, (bonds.values, i), (bonds.multipliers, i), holonomic=holonomic)

    def particles(self) -> list[tuple[tuple[Total, ...], Sequence[str]]]:
        """The positions of each family of particles, and the members' names."""
        from lagrange_cli.families.groups import particle_families

        families = grouped(self.system.spec.embedding, particle_families(self.system.spec))
        return [(tuple(self.system.positions[one.name]), one.members) for one in families]


class Particles(Sequence[Particle[Any]]):
    """The particles of families, whose positions are in totals."""

    def __init__(self, families: Sequence[tuple[tuple[Total, ...], Sequence[str]]]) -> None:
        self._families = families

    def __len__(self) -> int:
        return sum(len(names) for _, names in self._families)

    def __iter__(self) -> Iterator[Particle[Any]]:
        for arrays, names in self._families:
            for i, name in enumerate(names):
                yield Particle(name, None, tuple((one, i) for one in arrays), (), ())

    def __getitem__(self, number: Any) -> Any:
        return tuple(self)[number]
