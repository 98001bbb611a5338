"""The messages for an inconsistent start: each constraint that is not satisfied, at its place."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from lagrange_cli.decimals import decimal
from lagrange_cli.errors import SpecError
from lagrange_cli.model.start.linear import steepness
from lagrange_cli.model.start.nearest import ROUND
from lagrange_cli.model.start.unit_quaternions import no_direction
from lagrange_cli.spec.bodies.norms import norm_name
from lagrange_cli.spec.problems import MOST
from lagrange_cli.spec.source import Place, Source
from lagrange_cli.spec.spec import Expression, Spec
from lagrange_cli.spec.values import initial_hint

SATISFIED = 1e-12
"""A constraint that is off by less, relative to its terms, is not listed."""
MOST_SHOWN, MOST_STATES = 4, 2
TOLD_APART = 6
"""Decimals in which the values of a coordinate differ where they are not the same."""
FOUR_COMPONENTS = "let its four components be coordinates, or give the orientation by angles or by a matrix"
"""What to do where a quaternion cannot turn."""


class Refusal:
    """Makes the errors."""

    def __init__(self, spec: Spec) -> None:
        self.spec = spec
        self.source = Source(spec.filename, spec.text)

    def written(self, name: str) -> Expression:
        """A constraint as it stands in the file."""
        return self.spec.all_constraints[name]

    def residuals(
        self, values: Sequence[Any], rows: Sequence[Any], scale: Sequence[float], hint: str, *, speeds: bool
    ) -> SpecError:
        """One problem for each constraint that is not satisfied; one for all members of a family that are
        written alike, with those that are off most, relative to their terms."""
        together: dict[Place, list[tuple[float, str, float]]] = {}
        parts = [
            (abs(float(value)) / steep if steep else math.inf if value else 0.0, name, float(value))
            for name, value, steep in zip(self.spec.all_constraints, values, steepness(rows, scale))
        ]
        for part, name, value in [one for one in parts if one[0] > SATISFIED] or [max(parts)]:
            together.setdefault(self.written(name).place, []).append((part, name, value))
        problems = []
        for place, members in [*together.items()][:MOST]:
            problems.append(self.source.problem(place, self._unsatisfied(members, speeds=speeds), hint))
            hint = ""
        return SpecError(self.spec.filename, problems)

    def _unsatisfied(self, members: Sequence[tuple[float, str, float]], *, speeds: bool) -> str:
        """That constraints which are written alike are not satisfied: by which part of their terms, their
        names, and values."""
        worst = sorted(members, key=lambda one: -one[0])[:MOST_SHOWN]
        names, more = [f"'{name}'" for _, name, _ in worst], len(members) - len(worst)
        when, rates = "velocities" if speeds else "values", speeds and members[0][1] in self.spec.constraints
        if len(members) == 1:
            noun, verb, what = "constraint", "is", "its rate of change is" if rates else "it is"
        else:
            noun, verb, what = "constraints", "are", "their rates of change are" if rates else "they are"
        which = enumerated(names + [f"{more} more"] * (more > 0))
        numbers = ", ".join([decimal(value, 3) for _, _, value in worst] + ["..."] * (more > 0))
        return f"{noun} {which} {verb} not satisfied by the initial {when}: {what} {numbers}, not 0"

    def far_off(
        self,
        values: Sequence[Any],
        rows: Sequence[Any],
        scale: Sequence[float],
        moves: Sequence[Sequence[tuple[str, float]]],
        x: Sequence[Any] = (),
        unknown: Sequence[int] = (),
        *,
        speeds: bool = False,
    ) -> SpecError:
        """Given values are too far from any consistent state. ``moves`` has those of the nearest ones, as far
        as they are known. Coordinates are ``x``, of which the ``unknown`` ones are not given."""

        def shown(one: Sequence[tuple[str, float]]) -> str:
            listed = ", ".join(f"{name} = {decimal(value)}" for name, value in one[:MOST_SHOWN])
            return listed + (", ..." if len(one) > MOST_SHOWN else "")

        hint = "solve --project-initial takes the nearest consistent state"
        if len(moves) == 1:
            hint += f" ({shown(moves[0])})"
        if len(moves) > 1:
            before = {one.name: float(value) for one, value in zip(self.spec.coordinates, x)}
            listed = [shown(one) for one in told_apart(moves, before)[:MOST_STATES]]
            others = [f"one of {len(moves) - MOST_STATES} others"] * (len(moves) > MOST_STATES)
            hint = f"several consistent states are equally near: change to {' or '.join(listed + others)}"
        if not unknown:
            hint += "; or leave a value out, so that it is found"
            return self.residuals(values, rows, scale, hint, speeds=speeds)
        given = sorted({*range(len(scale))}.difference(unknown))
        best = [(self.spec.coordinates[k].name, float(x[k])) for k in unknown]
        missing = self.no_closure(given, unknown, f"; the best is {shown(best)}", hint)
        rest = self.residuals(values, rows, scale, "", speeds=speeds)
        return SpecError(self.spec.filename, [*missing.problems, *rest.problems])

    def contradiction(
        self,
        values: Sequence[Any],
        rows: Sequence[Any],
        scale: Sequence[float],
        flat: Sequence[int] = (),
        *,
        speeds: bool = False,
    ) -> SpecError:
        """No state was found nearby that satisfies all constraints. The derivatives of those with the
        numbers ``flat`` are 0."""
        hint = "the constraints contradict each other: no velocities near these satisfy all of them"
        if not speeds:
            hint = (
                "no values near these satisfy all constraints: leave a value out, so that it is found, or "
                "begin elsewhere; or the constraints contradict each other"
            )
            off = [[*self.spec.all_constraints][i] for i in flat if abs(float(values[i])) > 0]
            if off:
                hint = (
                    f"all derivatives of '{off[0]}' are 0 at these values, as when a chain is stretched, so "
                    "they do not tell which way to go: begin elsewhere"
                )
        return self.residuals(values, rows, scale, hint, speeds=speeds)

    def restricting(self, name: str, *, later: bool) -> SpecError:
        """A constraint depends on others where all hold, and does not follow from them."""
        if later:
            message = f"constraint '{name}' agrees with the others at the start, and contradicts them later"
            return self.source.error(
                self.written(name).place,
                message,
                "leave it out, or make it consistent with them at all times",
            )
        hint = "write an expression that changes its sign where it becomes 0, f in place of f**2"
        depends = f"the gradient of constraint '{name}' is 0 wherever it is satisfied"
        if len(self.spec.all_constraints) > 1:
            depends = f"the gradient of constraint '{name}' is 0, or depends on those of the others, "
            depends += "wherever all are satisfied"
            hint += "; where it only touches what the others allow, fix the coordinates that are left"
        message = f"{depends}, although the constraint restricts the motion"
        if self._bodies(name):
            hint = FOUR_COMPONENTS
        return self.source.error(self.written(name).place, message, hint)

    def check_directions(self, values: Sequence[Any]) -> None:
        """Raise ``SpecError`` at a quaternion that is 0, by the ``values`` of the constraints: whatever it is
        changed to is equally near."""
        for name, value in zip(self.spec.all_constraints, values):
            for body in self._bodies(name):
                if float(value) == -1.0:  # that of its norm is |Q|^2 - 1
                    raise no_direction(self.spec, body)

    def _bodies(self, name: str) -> list[str]:
        """The body whose quaternion a constraint normalizes, if it is such a one."""
        return [body for body in self.spec.bodies if norm_name(body) == name]

    def constant(self, name: str, at: float | None = None) -> SpecError:
        """A constraint is a constant, or one at the time ``at`` only, when the motion begins."""
        if at is not None:
            message = f"constraint '{name}' restricts nothing at t = {decimal(at)}: all its slopes are 0 then"
            return self.source.error(
                self.written(name).place, message, "let the motion start at another time"
            )
        bodies = self._bodies(name)
        if bodies:
            message = f"the length of the quaternion of body '{bodies[0]}' does not depend on any coordinate"
            return self.source.error(self.written(name).place, message, FOUR_COMPONENTS)
        kind, hint = "no coordinate", "write an expression in coordinates that stays 0"
        if name in self.spec.nonholonomic:
            kind, hint = "no velocity", "write an expression in velocities that stays 0"
        message = f"constraint '{name}' does not change with any state: {kind} has an effect on it"
        return self.source.error(self.written(name).place, message, hint)

    def never_negative(self, name: str, function: str) -> SpecError:
        """A constraint is a length or a root, that becomes 0."""
        hint = "write what is under the root"
        if function == "norm":
            hint = "write the vector itself, as in a - b: each of its components is a constraint"
        message = f"constraint '{name}' has no derivative where it is satisfied: {function}(...) is 0 there"
        return self.source.error(self.written(name).place, message, hint)

    def open_coordinate(self, number: int) -> SpecError:
        """A coordinate is not given, and the constraints leave it free."""
        coordinate = self.spec.coordinates[number]
        message = f"coordinate '{coordinate.name}' has no initial value, and the constraints leave it free"
        return self.source.error(coordinate.place, message, initial_hint(coordinate, coordinate.name))

    def no_closure(
        self, given: Sequence[int], unknown: Sequence[int], best: str = "", also: str = ""
    ) -> SpecError:
        """No values of the open coordinates satisfy the constraints. The message ends with the ``best`` that
        was found, and there is ``also`` another way out."""
        names = [self.spec.coordinates[k].name for k in unknown]
        listed = ", ".join(names[:MOST_SHOWN]) + (", ..." if len(names) > MOST_SHOWN else "")
        message = (
            f"no value of {listed} was found that satisfies the constraints with the values that are given"
            f"{best}"
        )
        others = [self.spec.coordinates[k].name for k in given]
        listed = ", ".join(others[:MOST_SHOWN]) + (", ..." if len(others) > MOST_SHOWN else "")
        hint = f"change {listed}, or the parameters" if others else "check the constraints and the parameters"
        hint += f"; {also}" if also else ""
        return self.source.error(self.spec.coordinates[unknown[0]].place, message, hint)

    def several(self, found: Sequence[Mapping[int, float]], *, more: bool) -> SpecError:
        """Several closures are possible."""
        count = f"{len(found)} or more" if more else str(len(found))
        return self._choice(found, f"the constraints allow {count} possible initial states")

    def equally_near(self, found: Sequence[Mapping[int, float]]) -> SpecError:
        """Several states are nearest."""
        return self._choice(
            found, "several states that satisfy the constraints are equally near, such as", whole=True
        )

    def _choice(self, found: Sequence[Mapping[int, float]], said: str, *, whole: bool = False) -> SpecError:
        """One of these states must be chosen: as a ``whole``, or by the values that tell them apart."""

        names = {k: self.spec.coordinates[k].name for k in found[0]}
        telling = distinguishing(found)
        told = [k for k in names if kinds(found, [k]) > 1]
        if len(names) <= MOST_SHOWN:
            told = [*names]
        elif len(told) > MOST_SHOWN:
            told = [*telling, *(k for k in told if k not in telling)]

        def shown(one: Mapping[int, float]) -> str:
            most = max(MOST_SHOWN, len(telling))
            listed = [f"{names[k]} = {digits(one[k])}" for k in told[:most]]
            return ", ".join(listed) + (", ..." if len(told) > most else "")

        first = self.spec.coordinates[telling[0]]
        listed = "".join([":", *(f"\n    {shown(one)}" for one in found)])
        given = [*names] if whole and len(names) <= MOST_SHOWN else telling
        options = " ".join(f"--set {names[k]}={digits(found[0][k])}" for k in given)
        hint = f"give one of them, as in {options}"
        if len(given) == 1:
            hint += f" or {names[telling[0]]}: {{initial: {digits(found[0][telling[0]])}}}"
        return self.source.error(first.place, said + listed, hint)


def told_apart(
    moves: Sequence[Sequence[tuple[str, float]]], before: Mapping[str, float]
) -> list[list[tuple[str, float]]]:
    """These states, each with the coordinates first that tell them apart. Coordinates that are missing have
    the value ``before``."""
    names = [*dict.fromkeys(name for one in moves for name, _ in one)]
    states = [{k: dict(one).get(name, before[name]) for k, name in enumerate(names)} for one in moves]
    telling = {names[k] for k in distinguishing(states)}
    return [sorted(one, key=lambda value: value[0] not in telling) for one in moves]


def distinguishing(states: Sequence[Mapping[int, float]]) -> list[int]:
    """A few coordinates whose values tell these states apart, the earliest ones."""
    telling: list[int] = []
    for k in states[0]:
        if kinds(states, [*telling, k]) > kinds(states, telling):
            telling.append(k)
    return telling


def kinds(states: Sequence[Mapping[int, float]], numbers: Sequence[int]) -> int:
    """How many states these coordinates tell apart; values that differ by rounding are the same."""
    sizes = {k: max(abs(one[k]) for one in states) or 1.0 for k in numbers}
    return len({tuple(round(one[k] / sizes[k], TOLD_APART) for k in numbers) for one in states})


def enumerated(words: Sequence[str]) -> str:
    """``a, b and c``."""
    return " and ".join(filter(None, (", ".join(words[:-1]), words[-1])))


def digits(x: float) -> str:
    """So many digits that it is the same number but for rounding: 15 of them where these are enough."""
    short = decimal(x, 15)
    return short if abs(float(short) - x) <= ROUND * abs(x) else repr(x)
