"""A system in other coordinates, which its file gives under ``transformations``.

Lagrange's equations keep their form under a point transformation q = q(Q, t) (Goldstein, Poole and Safko,
Classical Mechanics, 3rd ed., derivation 10 of chapter 1). With E_k = d/dt dL/dq_dot_k - dL/dq_k - Q_k,

    E'_j = sum_k dq_k/dQ_j E_k.

This is compared with numbers: E' are the equations derived in the new coordinates, E those of the file
differentiated directly in its own.
"""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from lagrange_cli.decimals import scientific
from lagrange_cli.errors import SpecError, UsageError
from lagrange_cli.expression.near import known_hint, near_hint
from lagrange_cli.expression.vocabulary import family_name
from lagrange_cli.records import dataclass, replace

if TYPE_CHECKING:
    from lagrange_cli.spec.spec import Spec, Transformation
    from lagrange_cli.spec.values import Values
    from lagrange_cli.symbolic.direct import Dual
    from lagrange_cli.symbolic.equations import Equations
    from lagrange_cli.symbolic.states import State

STATES, ATTEMPTS, STEPS = 8, 60, 60
"""States that are compared, attempts to find each, and steps of Newton's method for the initial one."""
SETTLED = 1e-13
SINGULAR = 1e-10
"""A Jacobian whose condition is worse is that of a singular place."""
AGREES = 1e-15
"""Equations that differ by more, of 30 digits, are not the same."""


@dataclass(frozen=True)
class Covariance:
    """The largest relative ``difference`` of E'_j and sum_k dq_k/dQ_j E_k over ``states`` states."""

    difference: float
    states: int
    old: tuple[str, ...]

    @property
    def agrees(self) -> bool:
        """Whether they are the same."""
        return self.difference <= AGREES

    def __str__(self) -> str:
        verdict = "keep their form" if self.agrees else "DIFFER"
        return (
            f"the equations {verdict}: compared with those in {', '.join(self.old)} at {self.states} random "
            f"states, largest relative difference {scientific(self.difference)}"
        )


def in_coordinates(spec: Spec, name: str) -> Spec:
    """The system in the coordinates of one of its transformations.

    Raises ``UsageError`` where it has none of this name.
    """
    given = spec.transformations
    if name not in given:
        hint = near_hint(name, given) or known_hint(given)
        raise UsageError(
            f"--coordinates {name}: the file has no such transformation; "
            + (
                hint
                or "write 'transformations: {polar: {coordinates: [r, phi], replace: {x: r*cos(phi), ...}}}'"
            )
        )
    new = given[name]
    stay = tuple(one for one in spec.coordinates if one.name not in new.replaced)
    kept = {one.name.partition("[")[0] for one in stay}
    families = {key: one for key, one in spec.coordinate_families.items() if key in kept}
    return replace(
        spec,
        coordinates=(*new.coordinates, *stay),
        families={**spec.families, "coordinates": {**new.families, **families}},
        replaced=new.replaced,
        solve=replace(spec.solve, outputs=None),
        draw=None,
    )


def old_state(spec: Spec, state: State, a: Sequence[float], exact: bool = False) -> dict[str, Dual]:
    """Each coordinate of the file along a motion with the accelerations ``a``, by name."""
    from lagrange_cli.model.scope import Scope
    from lagrange_cli.symbolic.direct import algebra_at

    bare = replace(spec, definitions={}, embedding={}, constraints={}, nonholonomic={}, bodies={})
    algebra = algebra_at(bare, state.parameters, state.t, state.q, state.v, a, exact)
    scope = Scope(bare, algebra)
    stay = {one.name: scope.values[one.name] for one in spec.coordinates}
    return {**stay, **scope.replaced}


def values_in(old: Spec, new: Spec, values: Values, transformation: Transformation) -> Values:
    """The initial state in the new coordinates, found by Newton's method.

    Raises ``SpecError`` where none is found.
    """
    from lagrange_cli.spec.source import Source

    source = random.Random(0)
    begin = guesses(new, values)
    for attempt in range(ATTEMPTS):
        guess = [x + (source.gauss(0, 1) if attempt else 0) * (1 + abs(x)) for x in begin]
        with suppress(ArithmeticError, ValueError, SpecError):
            found = settled(old, new, values, guess)
            if found is not None:
                return replace(values, q=found[0], v=found[1], remainder=None)
    names = ", ".join(one.name for one in transformation.coordinates)
    raise Source(old.filename, old.text).error(
        transformation.place,
        f"no {names} are found that give the initial state, or the transformation is singular there",
        "give initial values nearby, as in 'coordinates: {r: {initial: 1}}'",
    )


def start_in(old: Spec, new: Spec, overrides: Mapping[str, str]) -> tuple[Spec, Values]:
    """The system in new coordinates without redundant constraints and events, and its initial state.

    Raises ``SpecError`` where the file has no consistent one, or it is not found in the new coordinates.
    """
    from lagrange_cli.run.start import consistent_values
    from lagrange_cli.spec.values import resolve_values

    given = resolve_values(old, overrides)
    whole, values, _ = consistent_values(old, given, old.solve.start or 0.0, overrides)
    transformation = next(one for one in old.transformations.values() if one.replaced == new.replaced)
    known = {name: getattr(whole, name) for name in ("left_out", "in_turn", "tied", "faint")}
    bare = replace(new, **known, events={})
    return bare, values_in(old, bare, values, transformation)


def guesses(new: Spec, values: Values) -> list[float]:
    """Where the search begins: at the initial values that the file gives for them, or at 1."""
    from lagrange_cli.expression.numbers import NumberAlgebra
    from lagrange_cli.spec.values import evaluate_run

    found = next(iter(new.replaced.values()))
    open_ = replace(new, constraints={"": found}, masses={})  # with a constraint none need be given
    texts = {
        name: repr(x) for name, x in values.parameters.items() if family_name(name) not in new.tables
    }  # those in tables are not set
    _, q, _, _ = evaluate_run(open_, texts, NumberAlgebra(), {})
    return [x if one.initial is not None else 1.0 for x, one in zip(q, new.coordinates)]


def settled(
    old: Spec, new: Spec, values: Values, guess: Sequence[float]
) -> tuple[tuple[float, ...], tuple[float, ...]] | None:
    """Q and V that give the old state; None where Newton's method does not arrive, or V is not unique."""
    import numpy as np

    from lagrange_cli.symbolic.states import State

    q, zero = np.array(guess), [0.0] * len(guess)
    names = [one.name for one in old.coordinates]
    t = new.solve.start or 0.0
    for _ in range(STEPS):
        state = State(values.parameters, t, tuple(q.tolist()), tuple(zero))
        given = old_state(new, state, zero)
        rows = jacobian(given, names)
        left = np.array([given[name].value[0] for name in names], dtype=float) - np.array(values.q)
        step = np.linalg.lstsq(rows, left, rcond=SINGULAR)[0]
        q = q - step / max(1.0, float(np.abs(step).max()))
        if not np.all(np.isfinite(q)):
            return None
        if np.abs(step).max() <= SETTLED * (1 + np.abs(q).max()):
            break
    else:
        return None
    if np.abs(left).max() > 1e3 * SETTLED * (1 + np.abs(values.q).max()) or singular(rows):
        return None
    drift = np.array([given[name].value[1] for name in names], dtype=float)
    v = np.linalg.solve(rows, np.array(values.v) - drift)
    return tuple(q.tolist()), tuple(v.tolist())


def jacobian(given: Mapping[str, Dual], names: Sequence[str]) -> Any:
    """dq_k/dQ_j (n, n)."""
    import numpy as np

    n = len(names)
    rows = [(np.zeros(2 * n) + given[name].varied[0])[:n] for name in names]
    return np.array([[float(x) for x in row] for row in rows])


def singular(rows: Any) -> bool:
    """Whether a Jacobian cannot be inverted."""
    import numpy as np

    sizes = np.linalg.svd(rows / np.maximum(np.abs(rows).max(axis=0), 1e-300), compute_uv=False)
    return bool(sizes[-1] <= SINGULAR * sizes[0])


def covariance(old: Spec, new: Spec, equations: Equations, overrides: Mapping[str, str]) -> Covariance:
    """Compare the ``equations`` of the ``new`` system, in other coordinates, with those in the ``old`` ones,
    near the initial state if it is known.

    Raises ``SpecError`` where the transformation is singular at every random state.
    """
    import mpmath

    from lagrange_cli.spec.source import Source
    from lagrange_cli.spec.values import resolve_parameters
    from lagrange_cli.symbolic.states import State, admissible, near
    from lagrange_cli.symbolic.verify import DIGITS

    source = random.Random(0)
    n = len(new.coordinates)
    start = State(
        resolve_parameters(old, overrides), new.solve.start or 0.0, tuple([1.0] * n), tuple([0.0] * n)
    )
    with suppress(SpecError):
        _, values = start_in(old, new, overrides)
        start = replace(start, q=values.q, v=values.v)
    names = [one.name for one in old.coordinates]
    old, new = old.independent, new.independent
    anywhere = new.without(new.massless)  # where their equations hold, nothing is left of them
    worst, states, regular = 0.0, 0, False
    for attempt in range(ATTEMPTS):
        state = admissible(anywhere, near(start, source, varied=2 * attempt < ATTEMPTS))
        a = [source.uniform(-1, 1) for _ in range(n)]
        multipliers = [source.uniform(-1, 1) if one.acts else 0.0 for one in equations.constraints]
        if state is None:
            continue
        with suppress(ArithmeticError, ValueError, TypeError, SpecError), mpmath.workdps(DIGITS):
            if singular(jacobian(old_state(new, state, a), names)):
                continue
            regular = True
            worst = max(worst, *differences(old, new, equations, state, a, multipliers))
            states += 1
        if states == STATES:
            break
    if not regular:
        place = next(one.place for one in old.transformations.values() if one.replaced == new.replaced)
        message = "the transformation cannot be inverted: the new coordinates do not determine all velocities"
        hint = "let the replaced coordinates be independent functions of the new ones"
        raise Source(old.filename, old.text).error(place, message, hint)
    return Covariance(worst, states, tuple(new.replaced))


def differences(
    old: Spec, new: Spec, equations: Equations, state: State, a: Sequence[float], multipliers: Sequence[float]
) -> list[float]:
    """|E'_j - sum_k dq_k/dQ_j E_k|, relative to their terms, for each new coordinate."""
    import mpmath

    from lagrange_cli.symbolic.direct import directly
    from lagrange_cli.symbolic.expressions import value_of

    n = len(a)
    given = old_state(new, state, a, exact=True)
    symbols = dict(zip((*equations.q, *equations.v, *equations.a), (*state.q, *state.v, *a)))
    path = [given[one.name] for one in old.coordinates]
    q, v, a = ([factor * one.value[i] for one in path] for i, factor in enumerate((1, 1, 2)))
    own = directly(old, state.parameters, state.t, q, v, a, multipliers, exact=True).residual
    symbols |= {one.multiplier: x for one, x in zip(equations.constraints, multipliers) if one.acts}
    symbols |= {symbol: state.parameters[name] for name, symbol in equations.parameters.items()}
    symbols[equations.time] = state.t
    found = []
    for j, one in enumerate(equations.equations):
        left = value_of(one.factor * (one.left - one.right), symbols)
        terms = [own[k] * path[k].varied[0][j] for k in range(n)]
        scale = mpmath.fsum(map(abs, terms)) + abs(left)
        found.append(float(abs(left - mpmath.fsum(terms)) / (scale or 1)))
    return found
