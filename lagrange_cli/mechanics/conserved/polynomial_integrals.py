"""Conserved polynomials in the velocities, of systems with few degrees of freedom.

The candidate is a sum of terms with unknown coefficients (``ansatz``, ``separable``). Its rate of change
vanishes at every state, which gives a linear equation for them at each of many random states (``columns``).
All this is done modulo a prime, where nothing is rounded, with random values of the parameters: so the
results hold for all values, and their coefficients are functions of the parameters (``recognition``). Each
result is proven again, at other random states modulo a prime of 521 bits (see ``expression.residues``).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from itertools import chain

from lagrange_cli.expression.modular import Equations
from lagrange_cli.expression.node import Node
from lagrange_cli.expression.residues import SMALL
from lagrange_cli.expression.text import joined
from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.mechanics.conserved.ansatz import (
    Material,
    Powers,
    Term,
    Variables,
    has_smooth_forces,
    material_of,
    own_variables,
    powers,
    terms,
    variables_in_space,
)
from lagrange_cli.mechanics.conserved.columns import Columns, conserved_sums, independent, name_of
from lagrange_cli.mechanics.conserved.curved import products_of_symmetries
from lagrange_cli.mechanics.conserved.noether import Noether
from lagrange_cli.mechanics.conserved.reasons import term as term_text
from lagrange_cli.mechanics.conserved.residue_states import States
from lagrange_cli.mechanics.conserved.rolling import terms_along_constraints
from lagrange_cli.mechanics.conserved.separable import functions_of, separable
from lagrange_cli.mechanics.conserved.separation import terms_of_sum
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.variables import variables
from lagrange_cli.model.model import Model
from lagrange_cli.records import dataclass

MOST_PLACES = 5
MOST_TERMS, MOST_FUNCTIONS = 150, 250
"""The largest numbers of variables, and of terms in a sum; before those go that are sums of others."""
DEGREES = {1: 1, 2: 2, 3: 1, 4: 0}
"""Degrees in the velocities that are tried, and for each the highest degree of its leading coefficients in
the coordinates."""
HIGHEST = 4
"""For two coordinates, the coefficients of this degree in the velocities may have one degree more."""
ODD = (1, 2)
"""The degrees that are tried if forces change with the sign of velocities."""
ON_A_SURFACE = (2, 2)
"""The same for particles on surfaces, in three dimensions."""


@dataclass(frozen=True)
class Integral:
    """A conserved function of the state, its formula, and its ``degree`` in the velocities. A ``note`` says
    what names in the formula mean."""

    node: Node
    text: str
    degree: int
    note: str = ""


class PolynomialIntegrals:
    """The integrals of a model, in addition to the ``known`` conserved functions."""

    def __init__(self, model: Model[Node], noether: Noether, known: Sequence[Node]) -> None:
        self.model, self.noether, self.known = model, noether, [*known]
        self.states = States(model, noether)
        self.graph = self.states.graph

    def found(self) -> Iterator[Integral]:
        """The integrals that do not follow from the known ones."""
        model = self.model
        freedoms = len(model.q) - len(model.constraints)
        if self.states.eliminated is None or not has_smooth_forces(model, self.noether):
            return
        self.known += self._uniform()
        for one in self.of_pairs():
            yield one
            if one.degree == freedoms:  # as many as there are degrees of freedom
                return
        rank = self.rank(self.known)
        if rank is None:
            return
        places = len(model.q) - sum(one.holonomic for one in model.constraints)
        for given, ansatz in self._tried(integrable=rank >= freedoms):
            if rank >= places + freedoms - 1:
                return
            for one in self._solutions(given, ansatz):
                now = self.rank([*self.known, one.node])
                if now is not None and now > rank and self.states.conserves(one.node):
                    rank = now
                    self.known.append(one.node)
                    yield one

    def of_pairs(self) -> Iterator[Integral]:
        """Those of many equal particles that act on each other in pairs."""
        if self.states.eliminated is None or not has_smooth_forces(self.model, self.noether):
            return
        if not self.noether.has_constant_masses:
            return
        from lagrange_cli.mechanics.conserved.pairs import sums_of_pairs  # of particles on a line

        for degree, node in sums_of_pairs(self.model, self.noether.matrix):
            if not self.states.conserves(node):
                return
            self.known.append(node)
            text = f"the sum of all products of {degree} velocities of different particles, with "
            yield Integral(node, f"{text}-V_ij/m in place of v_i*v_j, where U = sum of V_ij", degree)

    # ------------------------------------------------------------------ what is tried

    @cached_property
    def _is_odd(self) -> bool:
        """Whether L or the forces change when all velocities are reversed."""
        energetics = self.noether.energetics
        nodes = [energetics.lagrangian, *energetics.applied]
        reversed_ = substituted(self.graph, nodes, {v: -v for v in self.model.v})
        return any(one is not other for one, other in zip(nodes, reversed_))

    def _uniform(self) -> list[Node]:
        """t p_k - sum_l M_kl q_l of coordinates that change uniformly, which need not be reported."""
        if not self.noether.has_constant_masses:
            return []
        model, graph = self.model, self.graph
        moves = [
            model.time * p - graph.sum([(m * q, 1.0) for m, q in zip(row, model.q)])
            for p, row in zip(self.noether.energetics.momenta, self.noether.matrix)
        ]
        return [one for one in moves if self.states.conserves(one)]

    def _tried(self, *, integrable: bool) -> Iterator[tuple[Variables, list[Term]]]:
        """Sums of terms, short ones first. Where as much is known as there are degrees of freedom, only flat
        space may have more to offer than its symmetries show."""
        model = self.model
        if not all(one.holonomic for one in model.constraints):
            for given_here, ansatz in terms_along_constraints(self.states):
                if len(ansatz) <= MOST_TERMS:
                    yield given_here, independent(self.states, given_here, ansatz)
        given = own_variables(model) if self.noether.has_constant_masses else variables_in_space(model)
        if not (given and given.flat):
            for given_here, ansatz in products_of_symmetries(self.states):
                if len(ansatz) <= MOST_FUNCTIONS:
                    yield given_here, independent(self.states, given_here, ansatz)
            if integrable:
                return
        material = None if given is None else material_of(model, self.noether, given)
        if given is not None and material is not None and len(given.places) <= MOST_PLACES:
            for ansatz in self._polynomials(given, material):
                yield given, ansatz
        if (
            not self.noether.has_constant_masses
            and not model.constraints
            and not any(one.body for one in model.particles)
        ):
            functions = functions_of(model, self.noether.matrix)
            if len(functions) <= MOST_TERMS:
                given, _ = separable(model, self.noether, ())
                singles = [Term((0,) * len(model.q), (), (one,)) for one in functions]
                functions = [term.functions[0] for term in independent(self.states, given, singles)]
                given, ansatz = separable(model, self.noether, functions)
                if len(ansatz) <= MOST_TERMS:
                    yield given, ansatz
        if not all(one.holonomic for one in model.constraints):
            yield self._uncoupled()
        if model.spec is not None and model.spec.bodies:
            from lagrange_cli.mechanics.conserved.body_terms import terms_of_body, variables_of_body

            for given in variables_of_body(model, self.noether):
                yield given, independent(self.states, given, terms_of_body(odd=self._is_odd))

    def _polynomials(self, given: Variables, material: Material) -> list[list[Term]]:
        if not given.flat:
            some = terms(given, material, *ON_A_SURFACE) if len(given.places) == 3 else []
            return [independent(self.states, given, some)] if 0 < len(some) <= MOST_TERMS else []
        found = []
        for degree, most in DEGREES.items():
            most += degree == HIGHEST and len(given.places) == 2
            if degree in ODD if material.odd else degree > 1:
                found += [terms(given, material, degree, highest) for highest in range(most + 1)]
        mirrors = self._mirrors(given, material)
        parts = [part for one in found for part in separated(one, mirrors)]
        return sorted((one for one in parts if len(one) <= MOST_TERMS), key=size)

    def _uncoupled(self) -> tuple[Variables, list[Term]]:
        """Energies of coordinates with constant masses, which constraints on velocities may leave alone: that
        of a ball that rolls in a horizontal cylinder, across its axis."""
        model, moving = self.model, variables(self.model)
        rows = zip(model.coordinates, model.v, self.noether.matrix)
        steady = [
            (v, velocity_name(name)) for name, v, row in rows if not any(m.symbols & moving for m in row)
        ]
        given = Variables((), [v for v, _ in steady], (), [name for _, name in steady])
        still = dict.fromkeys(model.v, self.graph.zero)
        (potential,) = substituted(self.graph, [self.noether.energetics.lagrangian], still)
        places = [term for term, _ in terms_of_sum(potential, 1.0) if term.symbols & moving]
        functions = dict.fromkeys(self.graph.split_parameters(term, moving)[1] for term in places)
        ansatz = [Term((0,) * len(steady), (), (one,)) for one in functions]
        ansatz += [Term(one, ()) for one in powers(len(steady), 2)]
        return given, independent(self.states, given, ansatz)

    def _mirrors(self, given: Variables, material: Material) -> list[int]:
        """Coordinates whose sign may be changed without a change of L and the forces, together with those of
        their velocities and forces: conserved sums are even in these or odd."""
        model, graph = self.model, self.graph
        if given.speeds is not model.v:
            return []
        nodes = [self.noether.energetics.lagrangian, *material.functions]
        forces = self.noether.energetics.applied
        found = []
        for k, (q, v) in enumerate(zip(model.q, model.v)):
            mirrored = substituted(graph, [*nodes, *forces], {q: -q, v: -v})
            expected = [*nodes, *(-force if i == k else force for i, force in enumerate(forces))]
            if all(one is other for one, other in zip(mirrored, expected)):
                found.append(k)
        return found

    # ------------------------------------------------------------------ what is found

    def _solutions(self, given: Variables, ansatz: Sequence[Term]) -> Iterator[Integral]:
        """Conserved sums, short ones first."""
        for some, coefficients in conserved_sums(self.states, given, ansatz):
            parts = [*zip(some, coefficients)][::-1]
            texts = [term_text(factor, name_of(term, given)).replace("*1/", "/") for term, factor in parts]
            columns = Columns(self.states, given, some)
            node = self.graph.sum([(factor * columns.node(term), 1.0) for term, factor in parts])
            yield Integral(node, joined(texts), max(sum(term.speeds) for term in some))

    # ------------------------------------------------------------------ proofs

    def rank(self, nodes: Sequence[Node]) -> int | None:
        """How many of them are independent on the states that constraints allow; None if there are none."""
        graph, model = self.graph, self.model
        bound = [one.expression for one in model.constraints if one.holonomic]
        bound += self.noether.constraints.speeds
        rows = [[graph.diff(one, x) for x in (*model.q, *model.v)] for one in (*bound, *nodes)]
        state = next(self.states.random(SMALL, chain.from_iterable(rows), accelerated=False), None)
        if state is None:
            return None
        equations = Equations(2 * len(model.q), SMALL)
        return sum([equations.add([state.values[x] for x in row]) for row in rows]) - len(bound)


def separated(ansatz: Sequence[Term], mirrors: Sequence[int]) -> list[list[Term]]:
    """The terms that are even or odd in the same coordinates."""
    found: dict[Powers, list[Term]] = {}
    for term in ansatz:
        found.setdefault(tuple((term.speeds[k] + term.places[k]) % 2 for k in mirrors), []).append(term)
    return [*found.values()]


def size(ansatz: Sequence[Term]) -> tuple[int, int]:
    """The degree in the velocities, and the number of terms."""
    return max(sum(term.speeds) for term in ansatz), len(ansatz)
