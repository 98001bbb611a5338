"""The equations of motion of a system of families, and what else is shown with them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from functools import partial

import numpy as np
import sympy

from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.syntax import ExpressionError, Sum, Tree
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.written_events import events_alike
from lagrange_cli.records import replace
from lagrange_cli.spec.event import Event
from lagrange_cli.spec.spec import Family, Spec, grouped
from lagrange_cli.symbolic.families.balance import balance
from lagrange_cli.symbolic.families.derivatives import spans_within
from lagrange_cli.symbolic.families.dynamics import FORCE, PULL, Dynamics
from lagrange_cli.symbolic.families.equations import Change, EventLine, FamilyEquations
from lagrange_cli.symbolic.families.frames import Frame, Kind, Split
from lagrange_cli.symbolic.families.kinds import LETTERS, loop_of
from lagrange_cli.symbolic.families.linear import blocks_of, pairs_of, solution_of
from lagrange_cli.symbolic.families.lines import Line
from lagrange_cli.symbolic.families.places import NamedPlace
from lagrange_cli.symbolic.families.sums import finished
from lagrange_cli.symbolic.indexed.conditions import Loop
from lagrange_cli.symbolic.indexed.members import KNOWN, member
from lagrange_cli.symbolic.indexed.whole import Whole, named, whole_of
from lagrange_cli.symbolic.order import Role
from lagrange_cli.symbolic.work import attempt, size_of

AS_SUMS = 5_000_000
"""Steps of work for the equations in which places are sums: there are others."""

LONGER = 1.25
"""Equations in which places are sums are preferred to those with names of places if they are not longer by
this factor."""


def family_equations(system: FamilySystem, spec: Spec | None = None) -> FamilyEquations | None:
    """The equations, with the constraints of ``spec`` if it is given; None where the conditions of a family
    are too irregular to be written with indices.

    Places along chains are written as the sums that they are, or by name, where that is much shorter.
    """
    with suppress(Unsuited, Split, ExpressionError, ArithmeticError):
        if system.joints is None:
            return equations_of(system, spec, naming=False)
        by_name = equations_of(system, spec, naming=True)
        if not by_name.places:
            return by_name
        closed = attempt(AS_SUMS, partial(equations_of, system, spec, naming=False))
        return by_name if closed is None or length(closed) > LONGER * length(by_name) else closed
    return None


def with_matrix(
    equations: FamilyEquations, system: FamilySystem, spec: Spec, *, driving: bool
) -> FamilyEquations:
    """Equations with M and f in M a = f + A^T lambda, however members are coupled, and with the rates of
    momenta if ``driving``.

    Raises ``UsageError`` where M is too large, and else as ``equations_of``.
    """
    deriver = _Deriver(system, spec, naming=bool(equations.places))
    return deriver.with_matrix(equations, driving=driving)


def equations_of(system: FamilySystem, spec: Spec | None = None, *, naming: bool) -> FamilyEquations:
    """The equations; if ``naming``, with names of places along chains. Raises ``Unsuited``, ``Split``,
    ``ExpressionError`` or ``ArithmeticError`` where they cannot be written with indices."""
    return _Deriver(system, spec, naming=naming).equations()


def length(equations: FamilyEquations) -> int:
    """Terms and factors of everything."""
    found = [one for one in (equations.T, equations.U, equations.h) if one is not None]
    found += [one.expression for one in equations.momenta]
    found += [one.expression for one in equations.places]
    found += [one.expression for one in equations.constraints]
    found += [line.expression for line, _ in equations.equations]
    return sum(size_of(one) for one in found)


class _Deriver(Dynamics):
    def equations(self) -> FamilyEquations:
        """All of them."""
        spec, order, families = self.spec, self.order, self.builder.coordinates
        kinetic, potential = self.given_energies
        lagrangian, constraints = self.lagrangian, self.bonds
        moving = {one.name: self.momentum(one) for one in families}
        motion = {one.name: self.motion(one) for one in families}
        of_momenta = {one.name: self.lines.of(one, moving[one.name]) for one in families}
        of_motion = {one.name: self.lines.of(one, motion[one.name]) for one in families}
        momenta = [line.of(self.total(own)) for one in of_momenta.values() for line, own in one]
        forces = [
            line
            for one in families
            for line in self.summed(one, {FORCE: motion[one.name][FORCE]}, -1)
            if line.expression != 0
        ]
        equations = []
        for line, own in (pair for one in of_motion.values() for pair in one):
            equation = self.equation(sympy.Add(*own.values()))
            equations.append((line.of(equation.left), equation))
        blocks = blocks_of(self.lines, families, moving, of_momenta, Role.VELOCITY)
        solution = None
        if blocks is not None and not constraints:
            of_rates = blocks_of(self.lines, families, motion, of_motion, Role.ACCELERATION)
            solution = solution_of(of_rates, families, order)
        masses = None if blocks is None else tuple(one for block in blocks for one in block.entries())
        bound = [one.of(self.of_members(one.expression, one.loops)) for one, _ in constraints]
        written = [one.expression for one in (*momenta, *forces, *bound, *(line for line, _ in equations))]
        drawn = -self.with_multipliers((one, self.drift(one.expression, own)) for one, own in constraints)
        if kinetic is None:
            h = self.energy(lagrangian if self.system.vector is None else self.even(lagrangian))
        else:
            at_rest = potential if self.system.vector is None else self.at_rest(potential)
            h = self.kinetic(moving=True) + at_rest
        h = self.neat(h)
        conserved, changing = balance(self, lagrangian, momenta, forces, drawn, h)
        found = FamilyEquations(
            name=spec.name,
            degrees_of_freedom=spec.degrees_of_freedom,
            sizes=spec.sizes,
            tables=spec.tables,
            coordinates=self.builder.coordinates,
            parameters=grouped([one.name for one in spec.parameters], spec.families.get("parameters", {})),
            order=order,
            T=None if kinetic is None else self.neat(kinetic),
            U=None if kinetic is None else self.neat(potential),
            L=self.neat(lagrangian),
            h=h,
            momenta=tuple(momenta),
            forces=tuple(forces),
            equations=tuple(equations),
            accelerations=solution,
            blocks=blocks,
            masses=masses,
            rates=None,
            conserved=tuple(conserved),
            changing=tuple(changing),
            paths=tuple(self.builder.paths),
            constraints=tuple(bound),
            nonholonomic=frozenset(one.family.name for one, holonomic in constraints if not holonomic),
            pulls=(),
            driving=None,
            first_order=0 if self.system.first_order is None else len(self.system.first_order.rows),
            allowed=tuple(
                one.of(self.of_members(self.second_rate(one.expression, own), one.loops))
                for one, own in constraints
            ),
            places=tuple(self.places(lagrangian, h, *written)),
            events=tuple(self.events()),
        )
        return self.printed(found if blocks is None else self.with_forces(found))

    def with_matrix(self, found: FamilyEquations, *, driving: bool) -> FamilyEquations:
        """The equations with M, f and A^T lambda, and with dL/dq + Q + A^T lambda if ``driving``. Raises
        ``UsageError`` where M is too large, or two of its blocks have one name."""
        families = self.builder.coordinates
        pairs_of(families)
        if found.masses is None:
            found = self.with_forces(replace(found, masses=tuple(self.entries())))
        if driving:
            found = replace(found, driving=tuple(line for one in families for line in self.driving(one)))
        return self.printed(found)

    def with_forces(self, found: FamilyEquations) -> FamilyEquations:
        """The equations with f and A^T lambda."""
        rates, pulls = list[Line](), list[Line]()
        for family in self.builder.coordinates:
            parts = self.motion(family)
            pull = {PULL: parts.pop(PULL)}
            pulls += self.summed(family, pull, -1) if self.bonds else ()
            still = {
                key: [replace(one, factor=self.unaccelerated(one.factor)) for one in listed]
                for key, listed in parts.items()
            }
            rates += self.summed(family, still, -1)
        return replace(found, rates=tuple(rates), pulls=tuple(pulls))

    def events(self) -> Iterator[EventLine]:
        """The events of the file."""
        spec = self.spec
        for family in grouped(spec.events, spec.families.get("events", {})):
            for one, kind in self.pieces(family):
                build = partial(self.happening, one, kind.tree)
                for loops, (when, changes) in self.builder.kinds(kind.loops, kind.frame, build):
                    shown = (
                        replace(each, value=self.of_members(each.value, (*loops, *each.loops)))
                        for each in changes
                    )
                    line = Line(family, kind.indices, loops, self.of_members(when, loops))
                    yield EventLine(line, one.direction, one.stops, tuple(shown))

    def pieces(self, family: Family) -> Iterator[tuple[Event, Kind]]:
        """The events of a family that are written alike: what is written, and all together."""
        for alike in events_alike(self.spec):
            if alike.name != family.name:
                continue
            one, order = alike.event, np.argsort(alike.numbers)
            if one.key is None:
                raise Unsuited
            places = [alike.indices[axis.index][order] if axis.index else order for axis in one.key.axes]
            yield one, self.builder.keyed(one.key.axes, places, one.when.tree)

    def happening(self, event: Event, tree: Tree, frame: Frame) -> tuple[sympy.Expr, list[Change]]:
        """What becomes 0 at some events, and what these set."""
        changes = []
        for one in event.sets:
            key, value = one.key, one.value.tree
            inside, loops, wholes = frame, list[Loop](), list[Whole]()
            for axis in key.axes:
                if axis.index:
                    index = self.builder.fresh(axis.index, inside)
                    loops.append(loop_of(index, axis, inside.names))
                    names = {**inside.names, axis.index: named(index)}
                    each = Sum(value, axis.index, axis.bounds, axis.conditions, axis.span, axis.span)
                    inside = self.builder.rounds(each, inside, index, names)
                wholes.append(named(index) if axis.index else whole_of(axis.bounds[0], inside.names))
            symbol = member(key.name, map(self.builder.settled, wholes)) if wholes else sympy.Symbol(key.name)
            changes.append(Change(symbol, self.builder.value(value, inside), tuple(loops)))
        return self.builder.value(tree, frame), changes

    def of_members(self, expression: sympy.Expr, loops: Sequence[Loop]) -> sympy.Expr:
        """An expression of members in textbook form."""
        return self.neat(expression, spans_within(loops, self.lines.sizes))

    def printed(self, found: FamilyEquations) -> FamilyEquations:
        """The equations as they are printed."""
        paths = {one.name for one in self.builder.paths}
        letters = [one for one in LETTERS if one not in self.builder.taken]

        def shown(expression: sympy.Expr, around: Sequence[Loop] = ()) -> sympy.Expr:
            used = {one.index for one in around}
            return finished(expression, [one for one in letters if one not in used], paths)

        def lines(listed: Sequence[Line]) -> tuple[Line, ...]:
            return tuple(one.of(shown(one.expression, one.loops)) for one in listed)

        return replace(
            found,
            T=None if found.T is None else shown(found.T),
            U=None if found.U is None else shown(found.U),
            L=shown(found.L),
            h=shown(found.h),
            momenta=lines(found.momenta),
            forces=lines(found.forces),
            equations=tuple(
                (line, replace(one, left=shown(one.left, line.loops), right=shown(one.right, line.loops)))
                for line, one in found.equations
            ),
            accelerations=None if found.accelerations is None else lines(found.accelerations),
            masses=None if found.masses is None else lines(found.masses),
            rates=None if found.rates is None else lines(found.rates),
            constraints=lines(found.constraints),
            pulls=lines(found.pulls),
            driving=None if found.driving is None else lines(found.driving),
            allowed=lines(found.allowed),
            conserved=tuple(replace(one, expression=shown(one.expression)) for one in found.conserved),
            changing=tuple(replace(one, rate=shown(one.rate)) for one in found.changing),
            places=tuple(replace(one, expression=shown(one.expression, one.loops)) for one in found.places),
            events=tuple(
                replace(
                    one,
                    line=one.line.of(shown(one.line.expression, one.line.loops)),
                    changes=tuple(
                        replace(each, value=shown(each.value, (*one.line.loops, *each.loops)))
                        for each in one.changes
                    ),
                )
                for one in found.events
            ),
        )

    def places(self, *expressions: sympy.Expr) -> Iterator[NamedPlace]:
        """What the names of places in expressions stand for."""
        symbols = [symbol.name for one in expressions for symbol in one.free_symbols]
        used = {KNOWN[name][0] for name in symbols if name in KNOWN}
        for one in self.builder.written_places(used):
            expression = self.lines.shown(one.expression, {}, one.loops)
            yield replace(one, expression=expression)
