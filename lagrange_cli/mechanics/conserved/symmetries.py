"""Conserved quantities that do not belong to a cyclic coordinate: found by Noether's theorem, and proven.

The candidates are displacements of all particles (translations, rotations, Galilean boosts), and combinations
of changes of coordinates by constants, by t, or linear ones, in time or along nonholonomic constraints.
Combinations are guessed from values at random states (``relations``). All results are proven (``noether``).
Polynomials of a higher degree in the velocities do not come from such a change (``hidden``, ``tops``,
``polynomial_integrals``).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.expression.text import joined, text_of
from lagrange_cli.expression.zero import is_zero, zeros
from lagrange_cli.mechanics.conservation import Conserved, broken, conservation
from lagrange_cli.mechanics.conserved.displacements import Trial, displacements, rotations_about_the_centre
from lagrange_cli.mechanics.conserved.hidden import candidates, described, is_turning
from lagrange_cli.mechanics.conserved.noether import Change, Noether
from lagrange_cli.mechanics.conserved.reasons import (
    current_text,
    is_constant,
    reason,
    unchanged,
)
from lagrange_cli.mechanics.conserved.separation import separate_energies
from lagrange_cli.mechanics.embedding import Embedding
from lagrange_cli.mechanics.energetics import Energetics
from lagrange_cli.mechanics.gauge import acting
from lagrange_cli.mechanics.relations import Relations, dependent
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.variables import graph_of, variables
from lagrange_cli.model.events import changes_of
from lagrange_cli.model.model import Model
from lagrange_cli.records import dataclass, replace

MOST_LINEAR, MOST_COMBINED, MOST_IN_POLYNOMIALS = 6, 40, 5
"""The largest numbers of coordinates for which linear changes, combinations and polynomials are tried."""
MOST_NAMES = 3
"""Coordinates that are named in one sentence."""
LONGEST_INTEGRAL = 600
"""Characters of its formula."""
WORTH = 2_500_000
"""Steps of work that each stage of the search may take."""
WORTH_OF_POLYNOMIALS = 800_000
"""The same for conserved polynomials, which many systems do not have: half a second."""


@dataclass(frozen=True)
class Symmetry:
    """A conserved quantity and the function of q, q_dot, t that it is."""

    conserved: Conserved
    node: Node


def symmetries(model: Model[Node], known: Sequence[Conserved] = ()) -> tuple[Symmetry, ...]:
    """Conserved quantities beyond those ``known``, which are h and momenta of cyclic coordinates."""
    energy = model.potential if model.lagrangian is None else model.lagrangian
    if any(one.kind is Kind.SWITCH for one in reachable([energy])):
        from lagrange_cli.mechanics.switching.saturation import (
            released,  # loaded where something was saturated
        )

        model = released(model)
    search = _Search(model, known)
    work = graph_of(model).work
    stages = (
        search.displacements,
        search.combinations,
        search.parts,
        search.hidden,
        search.tops,
        search.polynomials,
        search.acting,
    )
    for stage in stages:
        work.attempt(WORTH if stage != search.polynomials else WORTH_OF_POLYNOMIALS, stage)
    return tuple(search.found)


class _Search:
    """The quantities found so far."""

    def __init__(self, model: Model[Node], known: Sequence[Conserved]) -> None:
        self.model, self.noether, self.graph = model, Noether(model), graph_of(model)
        self.embedding = Embedding(model)
        self.found: list[Symmetry] = []
        self.names = {each.quantity for each in known}
        nodes = {f"p_{name}": p for name, p in zip(model.coordinates, self.noether.energetics.momenta)}
        nodes["h"] = self.noether.energy
        breaks = {each.quantity: each.breaks for each in known}
        self.kept = [node for name, node in nodes.items() if name in self.names]
        self.lasting = [node for name, node in nodes.items() if breaks.get(name) == ()]
        """The quantities that no event changes."""
        self.trials: list[Change] = []
        """Displacements of all particles that conserve nothing by themselves."""
        self.relations = Relations(self.graph, (model.time, *model.q, *model.v))

    # ------------------------------------------------------------------ what is found

    def add(self, name: str, text: str, because: str, change: Change) -> bool:
        """Add a conserved current, unless it is a combination of those that are known; whether it is new."""
        node = self.noether.current(change)
        if self._is_known(node, change, self.kept) and not self._outlasts(node, change):
            return False
        self.kept.append(node)
        self._store(Conserved(self._free_name(name), text, because), node)
        return True

    def _store(self, each: Conserved, node: Node) -> None:
        if any(event.changes for event in self.model.events):
            each = broken(self.graph, each, node, changes_of(self.model))
        self.lasting += [] if each.breaks else [node]
        self.found.append(Symmetry(each, node))

    def _outlasts(self, node: Node, change: Change) -> bool:
        """Whether no event changes a current, although events change its parts: the total momentum in a
        collision."""
        if len(self.lasting) == len(self.kept):
            return False
        changes = changes_of(self.model)
        breaks = broken(self.graph, Conserved("", "", ""), node, changes).breaks
        return not breaks and not self._is_known(node, change, self.lasting)

    def _is_known(self, node: Node, change: Change, kept: Sequence[Node]) -> bool:
        """Whether a current is a sum of known ones with constant factors, or a constant."""
        others = [one for one in kept if change.time is not None or one is not self.noether.energy]
        known = substituted(self.graph, [*others, node], self.noether.eliminated)
        columns = [[one] for one in (self.graph.one, *known)]
        rows = self.relations.rows(columns, {})
        return not rows or len(known) in dependent(rows, len(columns))

    def _is_independent(self, node: Node) -> bool:
        """Whether it is no function of those that are known, and of what constraints on velocities with
        constant factors keep, by the gradients at a state."""
        model, graph = self.model, self.graph
        symbols, moving = [*model.q, *model.v], variables(model)
        columns = [[graph.diff(one, s) for s in symbols] for one in self.kept]
        for one, slopes, drift in zip(
            model.constraints, self.noether.constraints.slopes, self.noether.constraints.drifts
        ):
            fixed = not any(a.symbols & moving for a in (*slopes.values(), drift))
            if fixed and not one.holonomic:
                columns.append([slopes.get(k, graph.zero) for k in range(len(symbols))])
        columns.append([graph.diff(node, s) for s in symbols])
        rows = self.relations.rows(columns, {})[: len(symbols)]
        return bool(rows) and len(columns) - 1 not in dependent(rows, len(columns))

    # ------------------------------------------------------------------ displacements of all particles

    def displacements(self) -> None:
        """Translations, rotations and boosts: all are proven at once, as they have most terms in common."""
        trials = [*displacements(self.model, self.embedding)]
        if any(one.body for one in self.model.particles):
            from lagrange_cli.mechanics.conserved.spins import spins

            trials += [Trial(*one) for one in spins(self.model, self.embedding)]
        trials += rotations_about_the_centre(self.model, self.embedding)
        conditions = [self.noether.conditions(one.change) for one in trials]
        kept = zeros([node for nodes in conditions for node in nodes])
        for one, nodes in zip(trials, conditions):
            if kept >= {*nodes}:
                if one.new and not self._is_independent(self.noether.current(one.change)):
                    continue
                because = one.because or f"{one.how} {unchanged(self.noether, one.change)}"
                self.add(one.name, one.text, because, one.change)
            elif one.how:
                self.trials.append(one.change)

    # ------------------------------------------------------------------ combinations

    def combinations(self) -> None:
        """Relations between the conditions for changes of coordinates."""
        model, changes = self.model, [*self._elementary()]
        if not model.q or len(model.q) > MOST_COMBINED:
            return
        columns = [self.noether.conditions(one) for one in changes]
        number = 0
        for relation in self.relations.relations(columns):
            parts = [(factor, changes[i]) for i, factor in relation.items()]
            change = self.noether.together(self._scaled(parts))
            node = self.noether.current(change)
            if not self._is_trivial(change, node) and self.noether.keeps(change):
                name, because = self._momentum_of(change), reason(self.noether, change)
                new = self.add(name or f"C_{number + 1}", current_text(model, change), because, change)
                number += new and not name

    def _elementary(self) -> Iterable[Change]:
        """Changes whose combinations are tried, simple ones first."""
        model, one = self.model, self.graph.one
        small = len(model.q) <= MOST_LINEAR
        yield from (Change({k: one}) for k in range(len(model.q)))
        yield from self._along_constraints()
        if small:
            gains = dict.fromkeys((*model.q, *(x for each in model.particles for x in each.position)))
            yield from (Change(gain=x) for x in gains if any(x.symbols & q.symbols for q in model.q))
            yield Change(gain=model.time)
        yield from self.trials
        if "h" not in self.names:
            yield Change(time=one)
        if small:
            yield from (Change({k: factor}) for factor in (model.time, *model.q) for k in range(len(model.q)))
            yield Change(time=model.time)

    def _along_constraints(self) -> Iterable[Change]:
        """Changes that nonholonomic constraints allow, one for each coordinate that they leave free."""
        model, graph, known = self.model, self.graph, self.noether.eliminated
        if all(one.holonomic for one in model.constraints):
            return
        bound = {k: known[v] for k, v in enumerate(model.v) if v in known}
        for s, v in enumerate(model.v):
            slopes = {k: graph.diff(speed, v) for k, speed in bound.items()} if s not in bound else {}
            slopes = {k: slope for k, slope in slopes.items() if not slope.is_zero}
            if slopes:
                factors = {base: e for slope in slopes.values() for base, e in _factors(slope) if e < 0}
                clearing = graph.product([(base, 1) for base in factors])
                yield Change({s: clearing, **{k: clearing * slope for k, slope in slopes.items()}})

    def _scaled(self, parts: Sequence[tuple[Node, Change]]) -> list[tuple[Node, Change]]:
        """The same with coefficients that have no denominators, the first of them positive."""
        powers: dict[Node, float] = {}
        for factor, _ in parts:
            for base, exponent in _factors(factor):
                powers[base] = min(exponent, powers.get(base, 0))
        common = [(base, -exponent) for base, exponent in powers.items() if exponent]
        sign = -1.0 if self.graph.split_coefficient(parts[0][0])[0] < 0 else 1.0
        return [(sign * self.graph.product([(factor, 1), *common]), change) for factor, change in parts]

    def _is_trivial(self, change: Change, node: Node) -> bool:
        """Whether a current is trivial: a coordinate grows linearly, or the momentum of a constant force
        does; and where it is no momentum, what follows from other currents."""
        model = self.model
        time, places = model.time.symbols, 0
        for q in model.q:
            places |= q.symbols
        if not change.directions and change.time is None:
            return True
        gain = change.gain
        if gain is not None and gain.symbols & time and not gain.symbols & places:
            return True
        rates = [*change.directions.values(), *([] if change.time is None else [change.time])]
        if any(one.symbols & time for one in rates) and len(change.directions) <= 1:
            free = [k for k in change.directions if f"p_{model.coordinates[k]}" in self.names]
            if change.time is None or free or not change.directions:
                return True
        return not is_constant(model, change) and not self._is_independent(node)

    def _momentum_of(self, change: Change) -> str:
        """The name of the momentum that a current is, if it is one."""
        if len(change.directions) != 1 or change.time is not None or change.gain is not None:
            return ""
        ((k, xi),) = change.directions.items()
        return f"p_{self.model.coordinates[k]}" if xi is self.graph.one else ""

    # ------------------------------------------------------------------ parts

    def parts(self) -> None:
        """Energies of parts of the system."""
        for names, node in separate_energies(self.model, self.names):
            listed = ", ".join(names[:MOST_NAMES]) + ", ..." * (len(names) > MOST_NAMES)
            because = f"no other coordinate is in the same terms of L as {listed}, nor is t"
            self._store(Conserved(f"h_{names[0]}", f"the part of h with {listed}", because), node)

    # ------------------------------------------------------------------ hidden symmetries

    def hidden(self) -> None:
        """Conserved quantities that are quadratic in velocities, for one particle or two."""
        given = candidates(self.model, self.noether) if "h" in self.names else []
        number, before = 0, len(self.found)
        for relation in self.relations.relations([[one.rate] for one in given]):
            parts = [(given[i], factor) for i, factor in relation.items()]
            rate = self.graph.sum([(factor * one.rate, 1.0) for one, factor in parts])
            name, text, because, sign = described(given, relation, number + 1, self.model.potential)
            node = self.graph.sum([(factor * one.node, sign) for one, factor in parts])
            if not is_turning(given, relation) and not self._is_made(node) and is_zero(rate):
                number += name[0] == "I"
                if sum(not one.body for one in self.model.particles) > 1:
                    because += "; m, r and v are those of the relative motion"
                self._store(Conserved(self._free_name(name), text, because), node)
        self.found[before:] = sorted(self.found[before:], key=lambda one: one.conserved.quantity)

    def tops(self) -> None:
        """The integral of a heavy top that belongs to no symmetry."""
        if self.model.spec is None or not self.model.spec.bodies or "h" not in self.names:
            return
        from lagrange_cli.mechanics.conserved.tops import kovalevskaya  # and all about bodies

        found = kovalevskaya(self.model, self.noether)
        if found is not None:
            each, node = found
            self._store(replace(each, quantity=self._free_name(each.quantity)), node)

    def polynomials(self) -> None:
        """Other polynomials in the velocities."""
        freedoms = len(self.model.q) - len(self.model.constraints)
        if "h" not in self.names or freedoms < 2 or len(self.model.q) > MOST_IN_POLYNOMIALS:
            return
        from lagrange_cli.mechanics.conserved.polynomial_integrals import (
            PolynomialIntegrals,  # and what it needs
        )

        known = [*self.kept, *(one.node for one in self.found)]
        for one in PolynomialIntegrals(self.model, self.noether, known).found():
            number = sum(name.startswith("I_") for name in self.names) + 1
            text = one.text if len(one.text) <= LONGEST_INTEGRAL else "a long sum"
            because = f"a hidden symmetry, of degree {one.degree} in the velocities: "
            where = "where the constraints hold, " if self.model.constraints else ""
            because += f"{where}it is constant by the equations of motion"
            self._store(Conserved(self._free_name(f"I_{number}"), text, because), one.node)

    # ------------------------------------------------------------------ total time derivatives in L

    def acting(self) -> None:
        """The quantities that L conserves without its terms that are a total time derivative dF/dt, which
        have no effect: in place of h that is h + dF/dt, in place of p_k it is p_k - dF/dq_k (partial
        derivatives)."""
        model, given = self.model, self.model.lagrangian
        lagrangian = -model.potential if given is None else given
        left = acting(model, self.graph, lagrangian)
        if left is lagrangian:
            return
        other = replace(model, potential=-left) if given is None else replace(model, lagrangian=left)
        energetics, (_, known) = Energetics(other), conservation(other)
        plain = {f"p_{name}": p for name, p in zip(model.coordinates, energetics.momenta)}
        nodes = [(each, {**plain, "h": energetics.energy_function}[each.quantity]) for each in known]
        nodes += [(one.conserved, one.node) for one in symmetries(other, known)]
        gone = lagrangian - left
        lacks = {f"p_{name}": -self.graph.diff(gone, v) for name, v in zip(model.coordinates, model.v)}
        (lacks["h"],) = substituted(self.graph, [gone], dict.fromkeys(model.v, self.graph.zero))
        for each, node in nodes:
            if self._is_known(
                node, Change(time=self.graph.one), [*self.kept, *(one.node for one in self.found)]
            ):
                continue
            text = f"{each.quantity} = {each.expression}, of L without dF/dt"
            if each.quantity in lacks:
                text = joined([each.quantity, text_of(lacks[each.quantity])])
            because = f"without the terms of L that are a total time derivative dF/dt, {each.because}"
            self._store(Conserved(self._free_name(f"{each.quantity}_0"), text, because), node)

    def _free_name(self, name: str) -> str:
        """The name, or the next one that nothing else has."""
        while name in self.model.coordinates or name in self.names:
            name += "'"
        self.names.add(name)
        return name

    def _is_made(self, node: Node) -> bool:
        """Whether it is a sum of constants, of what is known, and of products of two of these."""
        known = [*self.kept, *(one.node for one in self.found)]
        known += [
            a * b for i, a in enumerate(self.kept) for b in self.kept[i:] if self.noether.energy not in (a, b)
        ]
        columns = [[one] for one in (self.graph.one, *known, node)]
        rows = self.relations.rows(columns, {})
        return not rows or len(columns) - 1 in dependent(rows, len(columns))


def _factors(node: Node) -> list[tuple[Node, float]]:
    """The factors of a product with their exponents, without a number."""
    if node.kind is Kind.SUM and len(node.arguments) == 1 and node.data[0] == 0:
        return _factors(node.arguments[0])
    return [*zip(node.arguments, node.data)] if node.kind is Kind.PRODUCT else []
