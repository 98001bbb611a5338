"""Displacements of all particles at once: translations, rotations, and Galilean boosts."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cached_property

from lagrange_cli.expression.node import Node
from lagrange_cli.expression.text import joined, text_of
from lagrange_cli.expression.vocabulary import COMPONENTS
from lagrange_cli.expression.zero import is_zero
from lagrange_cli.mechanics.conserved.combinations import MOST_COMBINED
from lagrange_cli.mechanics.conserved.found import Found, Trial
from lagrange_cli.mechanics.conserved.noether import Change, Parts
from lagrange_cli.mechanics.conserved.reasons import (
    current_text,
    is_constant,
    is_plain,
    momentum_text,
    stands_for_all,
    term,
    turning_text,
    unchanged,
)
from lagrange_cli.mechanics.embedding import Component, Embedding
from lagrange_cli.mechanics.variables import graph_of, variables
from lagrange_cli.model.model import Model, Particle
from lagrange_cli.records import dataclass

TURNS = {"z": (0, 1), "x": (1, 2), "y": (2, 0)}
"""The axes that a rotation turns into each other."""


def displacements(model: Model[Node], embedding: Embedding) -> Iterable[Trial]:
    """Translations, rotations and Galilean boosts of all particles, by changes of the coordinates."""
    found = _Displacements(model, embedding)
    return (*found.translations(), *found.rotations(), *found.boosts())


def displaced(found: Found) -> None:
    """Translations, rotations and boosts: all are proven at once, as they have most terms in common."""
    trials = [*displacements(found.model, found.embedding)]
    if any(one.body for one in found.model.particles):
        from lagrange_cli.mechanics.conserved.spins import spins

        trials += [Trial(*one) for one in spins(found.model, found.embedding)]
    kept = found.noether.kept([[(found.graph.one, one.change)] for one in trials])
    for one, proven in zip(trials, kept):
        if proven:
            because = one.because or f"{one.how} {unchanged(found.noether, one.change)}"
            found.add(one.name, one.text, because, one.change)
        elif one.how:
            found.trials.append(one)


def about_the_centre(found: Found) -> None:
    """Turning all particles about their centre of mass, which stays where it is: reported if it is no
    function of known quantities. Changes are multiplied out only once it is proven."""
    turns = [*_Displacements(found.model, found.embedding).rotations_about_the_centre()]
    kept = found.noether.kept([parts for _, parts in turns])
    for (axis, parts), proven in zip(turns, kept):
        if not proven and len(found.model.q) > MOST_COMBINED:
            continue
        change = found.noether.together(parts)
        text = f"angular momentum about the centre of mass, along {axis}"
        how = f"turning {everything(found.model)} about the centre of mass around {axis}"
        if not proven:
            found.trials.append(Trial(f"S_{axis}", change, text, how))
        elif found.is_independent(found.noether.current(change)):
            found.add(f"S_{axis}", text, f"{how} {unchanged(found.noether, change)}", change)


def accelerated(found: Found) -> None:
    """What moves with a constant acceleration: where sum xi_k p_k - F t is conserved with constants xi_k and
    F, so is t sum xi_k p_k - sum_k xi_k M_kl q_l - F t^2/2."""
    model, graph, time = found.model, found.graph, found.model.time
    moving, boosts = variables(model), [*_Displacements(model, found.embedding).boosts()]
    number = sum(name.startswith("C_") for name in found.names)
    for _, change in [*found.currents]:
        gain = graph.zero if change.gain is None else change.gain
        force = graph.diff(gain, time)
        steady = is_constant(model, change) and not force.symbols & moving
        if force.is_zero or not steady or not is_zero(found.noether.rate(gain - force * time)):
            continue
        growing = {k: time * xi for k, xi in change.directions.items()}
        boost = next((one for one in boosts if one.change.directions == growing), None)
        momentum = found.noether.current(Change(change.directions))
        masses = [graph.diff(momentum, v) for v in model.v]
        place = boost.change.gain if boost else None
        if place is None:
            place = graph.sum([(m * q, 1.0) for m, q in zip(masses, model.q)])
        made = Change(growing, gain=place + 0.5 * force * time * time)
        if not found.noether.keeps(made):
            continue
        number += boost is None
        text, what = current_text(model, made), f"{text_of(place, moving=moving)} changes"
        if boost is not None:
            text = joined([boost.text, term(-0.5 * force, "t**2")])
            what = f"the centre of mass moves along {boost.name[-1]}"
        found.add(boost.name if boost else f"C_{number}", text, f"{what} with a constant acceleration", made)


def everything(model: Model[Node]) -> str:
    """What is displaced, in words."""
    if stands_for_all(model):
        return f"the point ({', '.join(model.coordinates)})" if is_plain(model) else "the particle"
    if any(one.body for one in model.particles):
        return "everything"
    return "all particles" if len(model.particles) > 1 else "the particle"


@dataclass(frozen=True)
class _Displacements:
    model: Model[Node]
    embedding: Embedding

    @cached_property
    def _axes(self) -> int:
        return max((len(one.position) for one in self._moving), default=0)

    def translations(self) -> Iterable[Trial]:
        """Moving all particles along an axis."""
        for i, axis in enumerate(COMPONENTS[: self._axes]):
            directions = self._shift(i)
            if directions:
                text, how = momentum_text(self.model, axis), f"moving {everything(self.model)} along {axis}"
                yield Trial(f"P_{axis}", Change(directions), text, how)

    def rotations(self) -> Iterable[Trial]:
        """Turning all particles about an axis, where all have as many components."""
        model, axes = self.model, self._axes
        if len({len(one.position) for one in model.particles}) > 1:
            return
        for axis, (i, j) in TURNS.items():
            if max(i, j) < axes:
                directions = self._turn(i, j)
                about = f"the {axis} axis" if axes == len(COMPONENTS) else "the origin"
                if directions:
                    how = f"turning {everything(self.model)} about {about}"
                    yield Trial(f"L_{axis}", Change(directions), turning_text(model, i, j), how)

    def rotations_about_the_centre(self) -> Iterable[tuple[str, Parts]]:
        """Turning all particles about their centre of mass, which stays where it is: by axis, a sum of
        changes times functions. Where everything can be turned and shifted, it is made of that."""
        model, graph, axes = self.model, graph_of(self.model), self._axes
        if len(self._moving) < 2 or len({len(one.position) for one in model.particles}) > 1:
            return
        whole = graph.sum([(one.mass, 1.0) for one in self._moving])
        centre = [
            graph.sum([(one.mass * one.position[i], 1.0) for one in self._moving]) / whole
            for i in range(axes)
        ]
        for axis, (i, j) in TURNS.items():
            if max(i, j) >= axes:
                continue
            turned, along, across = self._turn(i, j), self._shift(i), self._shift(j)
            if turned and along and across:
                moves = ((graph.one, turned), (centre[j], along), (-centre[i], across))
                yield axis, [(factor, Change(directions)) for factor, directions in moves]
                continue
            turn = dict[Component, Node]()
            for one in model.particles:
                x, y = (one.position[n] - (graph.zero if one.body else centre[n]) for n in (i, j))
                turn |= {(one.name, i): -y, (one.name, j): x}
            directions = self.embedding.change(turn)
            if directions:
                yield axis, [(graph.one, Change(directions))]

    def boosts(self) -> Iterable[Trial]:
        """The motion of the centre of mass, t P - M R; that of a single particle is plain."""
        time = self.model.time
        for i, axis in enumerate(COMPONENTS[: self._axes]):
            places = [(one.mass * one.position[i], 1.0) for one in self._moving if len(one.position) > i]
            directions = self._shift(i) if len(places) > 1 else None
            if directions:
                because = f"the centre of mass moves uniformly along {axis} (Galilean boosts)"
                growing = {k: time * change for k, change in directions.items()}
                change = Change(growing, gain=graph_of(self.model).sum(places))
                yield Trial(f"K_{axis}", change, f"t*P_{axis} - sum of m*{axis}", because=because)

    def _shift(self, i: int) -> Mapping[int, Node] | None:
        """The change of the coordinates that moves everything by 1 along an axis, if there is one."""
        moved = [one.name for one in self._moving if len(one.position) > i]
        return self.embedding.change({(name, i): graph_of(self.model).one for name in moved})

    def _turn(self, i: int, j: int) -> Mapping[int, Node] | None:
        """That which turns everything from axis i to axis j."""
        turn = dict[Component, Node]()
        for one in self.model.particles:
            turn |= {(one.name, i): -one.position[j], (one.name, j): one.position[i]}
        return self.embedding.change(turn)

    @property
    def _moving(self) -> list[Particle[Node]]:
        """The particles, without those that stand for the rotation of a body."""
        return [one for one in self.model.particles if not one.body]
