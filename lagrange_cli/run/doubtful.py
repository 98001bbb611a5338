"""Places of a file that are allowed and perhaps not meant: units that contradict each other, equality that
rounding decides, unused names, dissipation that does not brake, and singular masses or angles at the
start."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from lagrange_cli.errors import Problem
    from lagrange_cli.expression.arrays import Array
    from lagrange_cli.spec.spec import Spec
    from lagrange_cli.spec.values import Values

FEW, FAR = 3, 1e-3
"""Coordinates whose mass matrix is factored without numpy, and the part of a diagonal entry below which a
pivot may be rounding."""
MOST = 100
"""Coordinates of systems whose dissipation is looked at."""
STATES, ODD = 32, 1e-9
"""Random states, and the part of its size that an even function changes by rounding."""


def contradicting_units(spec: Spec) -> tuple[Problem, ...]:
    """A warning for each place of the file where units contradict each other."""
    from lagrange_cli.outputs.units import find_units
    from lagrange_cli.spec.source import Source

    conflicts = find_units(spec).conflicts
    if not conflicts:
        return ()
    source = Source(spec.filename, spec.text)
    return tuple(source.problem(one.place, one.message, one.hint) for one in conflicts)


def rounded_equalities(spec: Spec) -> tuple[Problem, ...]:
    """A warning for each comparison of numbers by == or != that are not whole."""
    if "==" not in spec.text and "!=" not in spec.text:
        return ()
    from lagrange_cli.spec.equality import doubtful_equalities
    from lagrange_cli.spec.source import Source

    source, hint = Source(spec.filename, spec.text), "compare whole numbers, or write abs(a - b) < 1e-9"
    return tuple(
        source.problem(place, f"rounding may decide whether {comparison} holds", hint)
        for place, comparison in doubtful_equalities(spec)
    )


def unused_names(spec: Spec) -> tuple[Problem, ...]:
    """A warning for each parameter, definition and size that nothing uses."""
    from lagrange_cli.spec.source import Source
    from lagrange_cli.spec.unused import unused

    source = Source(spec.filename, spec.text)
    return tuple(source.problem(*found) for found in unused(spec))


def odd_dissipation(spec: Spec, parameters: Mapping[str, float]) -> tuple[Problem, ...]:
    """A warning where Rayleigh's function D contains no velocity, is odd in one, or is negative: at random
    states with velocities of all sizes, for systems of up to ``MOST`` coordinates."""
    given = [*spec.forces.get("dissipation", {}).values()]
    if not given or len(spec.coordinates) > MOST:
        return ()
    from random import Random

    import numpy as np

    from lagrange_cli.expression.arrays import evaluate
    from lagrange_cli.expression.graph_algebra import GraphAlgebra
    from lagrange_cli.expression.vocabulary import TIME, velocity_name
    from lagrange_cli.model.scope import Scope
    from lagrange_cli.model.start.equations import with_what_is_used
    from lagrange_cli.spec.source import Source

    scope = Scope(with_what_is_used(spec, given), GraphAlgebra())
    function = scope.scalar(given[0])
    if scope.multipliers:
        return ()
    drawn, places = Random(0), [one.name for one in spec.coordinates]
    speeds = {velocity_name(one.name): v for one, v in zip(spec.coordinates, scope.v)}

    def anywhere() -> Array:
        return np.array([drawn.choice((-1, 1)) * 10 ** drawn.uniform(-3, 6) for _ in range(STATES)])

    there: dict[str, Array | float] = {**parameters, TIME: anywhere()}
    there |= {name: anywhere() for name in places}
    rest = {**there, **dict.fromkeys(speeds, 0.0)}

    def value(state: Mapping[str, Array | float]) -> Array:
        return np.broadcast_to(evaluate([function], state)[0], (STATES,))

    def problem(message: str, name: str) -> tuple[Problem, ...]:
        hint = f"Rayleigh's function is usually a sum of squares, as in c*{name}**2/2"
        return (Source(spec.filename, spec.text).problem(given[0].place, message, hint),)

    if not function.is_zero and not any(v.symbols & function.symbols for v in speeds.values()):
        return problem("the dissipation contains no velocity: it exerts no force", next(iter(speeds)))
    zero, sizes = value(rest), np.logspace(-2, 8, STATES)
    with np.errstate(all="ignore"):
        for name in (name for name, v in speeds.items() if v.symbols & function.symbols):
            ahead, back = value({**rest, name: sizes}) - zero, value({**rest, name: -sizes}) - zero
            scale = np.abs(ahead) + np.abs(back) + np.abs(zero)
            known = np.isfinite(scale)
            if (known & (np.abs(ahead - back) > ODD * scale)).any() and (
                np.abs(ahead + back)[known] <= ODD * scale[known]
            ).all():
                return problem(
                    f"the dissipation is odd in {name}: its force does not change direction with it", name
                )
        change = value({**there, **{name: anywhere() for name in speeds}}) - zero
        change = change[np.isfinite(change)]
        if len(change) and (change < 0).all():
            return problem("the dissipation is negative: its forces drive the motion", next(iter(speeds)))
    return ()


def tell_dissipation(spec: Spec, parameters: Mapping[str, float], tell: Callable[[str], None]) -> None:
    """Report dissipation that does not brake, in one line."""
    for problem in odd_dissipation(spec, parameters):
        tell(f"{spec.filename}: warning: {problem.message}; {problem.hint}")


def singular_poses(spec: Spec, values: Values) -> tuple[Problem, ...]:
    """A warning for each body whose angles are singular at the start."""
    from lagrange_cli.run.singular import angles_at
    from lagrange_cli.spec.source import Source

    source = Source(spec.filename, spec.text)
    hint = "begin elsewhere, or use a quaternion: it has no such pose"
    found = angles_at(spec, values.parameters, spec.solve.start or 0.0, (*values.q, *values.v))
    return tuple(
        source.problem(
            spec.bodies[name].orientation.place,
            f"the angles of body '{name}' are singular at the start: the {function} of the second one is 0",
            hint,
        )
        for name, function in found.items()
    )


def singular_start(spec: Spec, values: Values) -> tuple[Problem, ...]:
    """A warning where the mass matrix is singular at the start."""
    if clearly_regular(spec, values):
        return ()
    from lagrange_cli.run.singular import idle, place_of, without_mass
    from lagrange_cli.spec.source import Source

    names = without_mass(spec, values.parameters, spec.solve.start or 0.0, (*values.q, *values.v))
    if not names:
        return ()
    message = f"the mass matrix is singular at the start: {idle(names)}"
    hint = "begin elsewhere, or use other coordinates or parameters"
    return (Source(spec.filename, spec.text).problem(place_of(spec, names[0]), message, hint),)


def clearly_regular(spec: Spec, values: Values) -> bool:
    """Whether the mass matrix of few coordinates is far from singular at the start, by the pivots of its
    factors: this takes no numpy, and most are."""
    if len(spec.coordinates) > FEW:
        return False
    from lagrange_cli.errors import LagrangeError
    from lagrange_cli.model.start.equations import Equations

    try:
        masses = Equations(spec, values.parameters).masses(spec.solve.start or 0.0, values.q, values.v).rows
    except (LagrangeError, ArithmeticError):
        return False
    if len(masses) < len(spec.coordinates):  # a row is left out
        return False
    rows = [[float(masses[j].get(k, 0.0)) for k in range(len(masses))] for j in range(len(masses))]
    for j, row in enumerate(rows):
        if not row[j] > FAR * float(masses[j].get(j, 0.0)):
            return False
        for below in rows[j + 1 :]:
            factor = below[j] / row[j]
            below[:] = [x - factor * y for x, y in zip(below, row)]
    return bool(rows)
