"""Members that stick to one another move as one: their velocities follow from those of their anchors.

Where u = A v stays 0, and A has slopes c of a coordinate and b of its anchor, a = r a' with r = -b/c. By
d'Alembert's principle a force F and a mass m act on the anchor as r F and r^2 m, and on the ground as
nothing. So the forces that hold members are not in the equations of their motion, nor is their rounding.
(Forces that hold more than two coordinates leave several of them free: they are, as multipliers.)
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from lagrange_cli.expression.index_arrays import Places
from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Array, Domain, Source, Term, Total
from lagrange_cli.families.bonds import Bonds
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.switching.anchors import anchors_of
from lagrange_cli.families.switching.friction import gate
from lagrange_cli.native.families.constraints.restraint import Bonded
from lagrange_cli.native.families.tables import Tables, place_at
from lagrange_cli.native.families.vectors import Vectors
from lagrange_cli.native.llvm.vector import Pointer

PAIR = 2
"""The coordinates that most forces hold together."""


class Rubbing(Bonded):
    """What is computed of forces of friction, which hold members where their ``modes`` are 0."""

    slopes: Sequence[Sequence[Array]]
    """A, of each bound a column for each of its coordinates."""

    def bonds_of(self, system: FamilySystem) -> Bonds:
        assert system.modes is not None and system.modes.sticking is not None
        self.modes = system.modes
        return system.modes.sticking

    def lasting_column(self, domain: Domain, slope: Node) -> Array:
        """A column of A, which is constant."""
        return self.lasting.arranged(Total(Source.TOTAL, domain.count, (Term(domain, slope, domain.every),)))

    def slips(self, domain: Domain, numbers: Places) -> Node:
        """1 where a mode is not 0."""
        return gate(self.slots, domain, self.modes.signs, self.modes.holding[numbers])

    def hold(self, domain: Domain, first: Places, second: Places) -> Node:
        """1 where two forces hold."""
        stuck: Node = 1.0 - self.slips(domain, first)
        return stuck if np.array_equal(first, second) else stuck * (1.0 - self.slips(domain, second))


class Anchoring:
    """Totals in the order of ``families.switching.anchors``: whether a force holds (``sticks``), the
    ``ratios`` of velocities to those of the anchors, and the ``shares`` that anchors have of forces."""

    def __init__(self, restraint: Rubbing) -> None:
        self.restraint, self.anchors = restraint, anchors_of(restraint.bonds, restraint.size)
        self.count, self.width = self.anchors.others.shape
        sticks, shares, others = list[Term](), list[Term](), list[Term]()
        for b, one in enumerate(restraint.bounds):
            places = self.anchors.places[one.numbers]
            sticks.append(Term(one.domain, restraint.hold(one.domain, one.numbers, one.numbers), places))
            ratios = shares if len(one.rows) <= PAIR else others
            for own, rows in enumerate(one.rows):
                members = np.flatnonzero(rows == self.anchors.held[places])
                if len(members):
                    ratios += self._ratios(b, own, Domain(len(members)), members)
        self.sticks = self._lasting(self.count, sticks)
        self.shares = self._lasting(self.count * self.width, shares)
        self.ratios = self._lasting(self.count * self.width, [*shares, *others]) if others else self.shares

    def _ratios(self, b: int, own: int, domain: Domain, members: Places) -> list[Term]:
        """Those of some members of a bound that hold the coordinate of its column ``own``."""
        restraint, one = self.restraint, self.restraint.bounds[b]
        numbers, found = one.numbers[members], list[Term]()
        slopes = [restraint.slots.symbol(domain, column, members) for column in restraint.slopes[b]]
        holds = restraint.hold(domain, numbers, numbers)
        for place, other in enumerate([a for a in range(len(slopes)) if a != own]):
            targets = self.anchors.places[numbers] * self.width + place
            found.append(Term(domain, -holds * slopes[other] / slopes[own], targets))
        return found

    def _lasting(self, count: int, terms: Sequence[Term]) -> Total:
        return self.restraint.lasting.arranged(Total(Source.TOTAL, count, tuple(terms)))


class AnchorLoops:
    """The loops over these; ``at`` gives the places of the totals. The forces that hold, and their number,
    are ``listed``."""

    def __init__(
        self,
        anchoring: Anchoring,
        vectors: Vectors,
        tables: Tables,
        at: Callable[[Total], Pointer],
        listed: Pointer,
    ) -> None:
        self.f, self.vectors, self.anchoring, self.listed = vectors.f, vectors, anchoring, listed
        anchors = anchoring.anchors
        own = np.broadcast_to(anchors.held[:, None], anchors.others.shape)
        self.held = tables.of_array(anchors.held)
        self.others = tables.of_array(np.where(anchors.others < 0, own, anchors.others).ravel())
        self.sticks, self.shares, self.ratios = map(
            at, (anchoring.sticks, anchoring.shares, anchoring.ratios)
        )

    def list(self) -> None:
        """Find the forces that hold."""
        f, vectors, count = self.f, self.vectors, self.anchoring.count
        found = f.variable(f.count(0))
        with f.loop(0, count, tested=False) as i:
            f.store(i, self.listed, found.get())
            sticks = vectors.high(vectors.load(self.sticks, i)) > 0.0
            found.set(found.get() + f.select(sticks, f.count(1), f.count(0)))
        f.store(found.get(), self.listed, count)

    def gather(self, numbers: Pointer, power: int = 1) -> None:
        """Add those of all that is held to those of its anchors, multiplied by powers of ratios."""
        f, vectors, width = self.f, self.vectors, self.anchoring.width
        count = f.load_integer(self.listed, self.anchoring.count)
        with f.loop(0, count) as done:
            i = f.load_integer(self.listed, count - 1 - done)
            held, anchor = place_at(f, i + self.held), place_at(f, i * width + self.others)
            share, added = vectors.load(self.shares, i * width), vectors.load(numbers, held)
            for _ in range(1, power):
                added = vectors.fused(added, share, vectors.constant(0.0))
            vectors.store(vectors.fused(added, share, vectors.load(numbers, anchor)), numbers, anchor)

    def spread(self, velocities: Pointer) -> None:
        """Let all that is held have the velocities of its anchors."""
        f, vectors, width = self.f, self.vectors, self.anchoring.width
        with f.loop(0, f.load_integer(self.listed, self.anchoring.count)) as done:
            i, total = f.load_integer(self.listed, done), vectors.constant(0.0)
            for k in range(width):
                anchor = place_at(f, i * width + (self.others + k))
                ratio = vectors.load(self.ratios, i * width + k)
                total = vectors.fused(vectors.load(velocities, anchor), ratio, total)
            vectors.store(total, velocities, place_at(f, i + self.held))
