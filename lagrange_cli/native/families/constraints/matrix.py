"""Constraints and the matrix of the equations with them, from which impulses follow: M, and -A below it
and to its right (see ``integrate.impacts.impulses``)."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from lagrange_cli.expression.index_arrays import Places, distinct
from lagrange_cli.families.arrays import Domain, Term, Total, total_of
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.native.families.constraints.joint_matrices import JointMatrices


class MatrixOfConstraints:
    """What is computed of the constraints of a system."""

    def __init__(self, system: FamilySystem) -> None:
        assert system.bonds is not None
        self.system, self.bonds, self.graph = system, system.bonds, system.slots.graph
        self.degrees = system.q.count

    @property
    def values(self) -> Total:
        """What should be 0; 0 of constraints on velocities."""
        terms = [Term(one.domain, one.node, one.numbers) for one in self.bonds.bounds if one.holonomic]
        return total_of(self.bonds.count, terms, self.graph)

    @property
    def speeds(self) -> Total:
        """Their rates, and those that are constraints themselves."""
        terms = [Term(one.domain, one.speed, one.numbers) for one in self.bonds.bounds]
        return total_of(self.bonds.count, terms, self.graph)

    @cached_property
    def masses(self) -> list[Term]:
        """M, at rows times all coordinates, plus the column."""
        n, everyone = self.degrees, self.system.everyone
        coupled = self.system.coupled_masses
        if coupled is not None:
            i, j = coupled.pairs.T
            below = coupled.below
            both = ((np.arange(len(i)), i * n + j), (below, j[below] * n + i[below]))
            domains = [Domain(len(numbers)) for numbers, _ in both]
            slots = self.system.slots
            return [
                Term(domain, slots.symbol(domain, coupled.entries, numbers), places)
                for domain, (numbers, places) in zip(domains, both)
            ]
        if self.system.joints is None:
            mass = self.system.slots.own(everyone, self.system.masses)
            return [Term(everyone, mass, everyone.every * (n + 1))]
        return [*self._joints.masses()]

    @cached_property
    def _joints(self) -> JointMatrices:
        return JointMatrices(self.system)

    @cached_property
    def slopes(self) -> list[Term]:
        """-A, at constraints times all coordinates, plus the coordinate."""
        found = []
        for b, a in self.bonds.pulls:
            one = self.bonds.bounds[b]
            found.append(Term(one.domain, -one.slopes[a], one.numbers * self.degrees + one.rows[a]))
        return found if self.system.joints is None else [*found, *self._joints.of_holds(self.bonds)]

    @cached_property
    def _places(self) -> tuple[Places, Places]:
        """Where M and A are not 0, each place once."""
        both = [[one.targets for one in terms] for terms in (self.masses, self.slopes)]
        masses, slopes = (distinct(np.concatenate(one)) for one in both)
        return masses, slopes

    @property
    def pattern(self) -> tuple[tuple[int, int], ...]:
        """The rows and columns of the entries."""
        (i, j), (numbers, rows) = (np.divmod(one, self.degrees) for one in self._places)
        below = list(zip((numbers + self.degrees).tolist(), rows.tolist()))
        return (*zip(i.tolist(), j.tolist()), *below, *((k, i) for i, k in below))

    @property
    def entries(self) -> Total:
        """M, and -A twice."""
        masses, slopes = self._places
        first, count = len(masses), len(slopes)
        terms = [Term(t.domain, t.node, np.searchsorted(masses, t.targets)) for t in self.masses]
        for one in self.slopes:
            places = first + np.searchsorted(slopes, one.targets)
            terms += [Term(one.domain, one.node, places + shift) for shift in (0, count)]
        return total_of(first + 2 * count, terms, self.graph)
