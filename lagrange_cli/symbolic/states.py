"""Where equations are compared: near the start, along the motion, and on both sides of every switch and
pole."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from lagrange_cli.errors import SpecError
from lagrange_cli.expression.evaluate import evaluate
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.expression.vocabulary import TIME, velocity_name
from lagrange_cli.expression.zero import branching
from lagrange_cli.model.model import Model
from lagrange_cli.records import dataclass, replace
from lagrange_cli.spec.spec import Spec
from lagrange_cli.symbolic.direct import Bound, algebra_at, bindings

MOST_BORDERS, MOST_SYMBOLS = 12, 4
"""The number of switches and poles that are looked for, and of symbols along which the search goes."""
DISTANCES = [0.1 * 2.0**k for k in range(14)]
"""Distances from a state at which the other side of one is looked for, in units of the state's scale."""


@dataclass(frozen=True)
class State:
    """A state with the values of the parameters; ``where`` says what kind of place it is."""

    parameters: Mapping[str, float]
    t: float
    q: tuple[float, ...]
    v: tuple[float, ...]
    where: str = "near the initial one"


def near(state: State, source: random.Random, *, varied: bool = True) -> State:
    """A random state near this one, by its own scale or by 1; parameters are ``varied`` by up to a tenth."""
    parameters = {name: x * source.uniform(0.9, 1.1) for name, x in state.parameters.items()}
    parameters = parameters if varied else dict(state.parameters)
    wide = source.random() < 0.5

    def moved(x: float) -> float:
        return x + source.uniform(-1, 1) * (1.0 if wide else scale(x))

    t = state.t + source.uniform(0, 1)
    return State(parameters, t, tuple(map(moved, state.q)), tuple(map(moved, state.v)), state.where)


def scale(x: float) -> float:
    """The scale of a value, by which steps away from it are measured."""
    return abs(x) or 1.0


Admissible = Callable[[State], State | None]
"""The state next to a given one that satisfies the constraints, or None."""


def sides(
    model: Model[Node], states: Sequence[State], admissible: Admissible = lambda state: state
) -> list[State]:
    """States on both sides of every border that is found near ``states``: where a function of ``model`` has
    a branch, a kink, a jump or a pole. They are ``admissible``. Borders that contain multipliers, which are
    not known before the equations are solved, are left out."""
    found = []
    names = [TIME, *model.coordinates, *map(velocity_name, model.coordinates)]
    for border in located(model)[:MOST_BORDERS]:
        moving = [symbol.data for symbol in symbols(border) if symbol.data in names]
        found += next(
            (pair for state in states if (pair := across(border, moving, state, names, admissible))), []
        )
    return found


def undecided(model: Model[Node], state: State) -> bool:
    """Whether it takes no more than rounding errors of ``state`` to cross a border. There a force that jumps,
    such as static friction, may have any value between those of both sides, and the printed one means
    nothing."""
    names = [*model.coordinates, *map(velocity_name, model.coordinates)]
    values = {**state.parameters, TIME: state.t, **dict(zip(names, (*state.q, *state.v)))}
    errors = dict(zip(names, (SETTLED * (1.0 + max(map(abs, x))) for x in (state.q, state.v) for _ in x)))
    for border in located(model):
        moving = [one for one in symbols(border) if one.data in errors]
        slopes = [model.algebra.diff(border, one) for one in moving]
        value, _ = evaluate([border, *slopes], values)
        reach = sum(errors[one.data] * abs(value[slope]) for one, slope in zip(moving, slopes))
        if moving and abs(value[border]) <= reach:
            return True
    return False


def located(model: Model[Node]) -> list[Node]:
    """The borders whose places are known before the equations are solved: those without multipliers."""
    unknown = {one.multiplier for one in model.constraints}
    return [border for border in borders(model) if unknown.isdisjoint(symbols(border))]


def borders(model: Model[Node]) -> list[Node]:
    """The expressions that change their signs where the system is not analytic."""
    given = [model.potential, model.dissipation, *model.generalized_forces]
    given += [] if model.lagrangian is None else [model.lagrangian]
    given += [one.expression for one in model.constraints]
    given += [x for p in model.particles for x in (*p.position, *p.velocity, *p.force)]
    found: dict[Node, None] = {}
    for node in reachable(given):
        inner = list(branching(node))
        if node.kind is Kind.FUNCTION and node.data in ("asin", "acos"):
            inner = [1.0 - inner[0] * inner[0]]
        if node.kind is Kind.PRODUCT:
            inner += [base for base, exponent in zip(node.arguments, node.data) if exponent < 0]
        found |= dict.fromkeys(inner)
    return list(found)


def symbols(node: Node) -> list[Node]:
    """The symbols in an expression."""
    return [one for one in reachable([node]) if one.kind is Kind.SYMBOL]


def across(
    border: Node, moving: Sequence[str], state: State, names: Sequence[str], admissible: Admissible
) -> list[State]:
    """The last state before a border and the first one beyond it, on a line from ``state``; or none. Where
    they are not admissible, others next to them on the same side."""
    here = dict(zip(names, (state.t, *state.q, *state.v)))

    def sign(values: Mapping[str, float]) -> float:
        value, _ = evaluate([border], {**state.parameters, **values})
        return math.copysign(1.0, value[border]) if abs(value[border]) > 0.0 else value[border]

    for name in moving[:MOST_SYMBOLS]:
        for sense in (1.0, -1.0):

            def beside(distance: float, name: str = name, sense: float = sense) -> dict[str, float]:
                return {**here, name: here[name] + sense * distance * scale(here[name])}

            before = here if sign(here) else beside(-DISTANCES[0])
            for distance in DISTANCES:
                there = beside(distance)
                if sign(there) * sign(before) < 0:
                    pair = ((before, "before a switch or pole"), (there, "beyond a switch or pole"))
                    found = []
                    for values, where in pair:
                        own = admissible(placed(values, state, where))
                        if own and sign(dict(zip(names, (own.t, *own.q, *own.v)))) == sign(values):
                            found.append(own)
                    return found
                before = there
    return []


def placed(values: Mapping[str, float], state: State, where: str) -> State:
    """The state with these values of t, q and v, in this order."""
    t, *rest = values.values()
    n = len(state.q)
    return State(state.parameters, t, tuple(rest[:n]), tuple(rest[n:]), where)


MOST_STEPS = 50
SETTLED = 1e-13
"""Newton's method has arrived where its step is as small as this beside the coordinates."""
DEPENDENT = 1e-9
"""Directions in which constraints change so little, relative to others, are none."""
FOLDED = 1e-6
"""A state that Newton's method has moved to one where two closures meet is this far from it."""


def admissible(spec: Spec, state: State) -> State | None:
    """``state`` with coordinates, then velocities, projected onto the constraints of ``spec``; None where
    there is no such state that Newton's method finds."""
    if not spec.all_constraints:
        return state
    q, v = np.array(state.q), np.array(state.v)
    try:
        for _ in range(MOST_STEPS):
            holonomic = bound(spec, state, q, v)[: len(spec.constraints)]
            step = shortest(holonomic, [one.value for one in holonomic])
            q = q - step
            if np.abs(step).max(initial=0.0) <= SETTLED * (1.0 + np.abs(q).max()):
                break
        else:
            return None
        every = bound(spec, state, q, v)
        v = v - shortest(every, [one.speed for one in every])
        left = [one.speed for one in bound(spec, state, q, v)]
    except (ArithmeticError, ValueError, SpecError, np.linalg.LinAlgError):
        return None
    worst = max((abs(x) / (1.0 + np.abs(one.slopes).max()) for x, one in zip(left, every)), default=0.0)
    if not worst <= DEPENDENT * (1.0 + np.abs(v).max()):
        return None
    return replace(state, q=tuple(q.tolist()), v=tuple(v.tolist()))


def singular(spec: Spec, state: State) -> bool:
    """Whether the constraints depend on each other at a state, or almost: as where a linkage is folded."""
    if not spec.all_constraints:
        return False
    try:
        slopes = np.array([one.slopes for one in bound(spec, state, np.array(state.q), np.array(state.v))])
        lengths = np.linalg.norm(slopes, axis=1, keepdims=True)
        found = np.linalg.svd(slopes / np.where(lengths, lengths, 1.0), compute_uv=False)
    except (ArithmeticError, ValueError, SpecError, np.linalg.LinAlgError):
        return True
    return len(slopes) > slopes.shape[1] or bool(found.min() <= FOLDED * found.max())


def bound(spec: Spec, state: State, q: np.ndarray, v: np.ndarray) -> list[Bound]:
    """The constraints there."""
    rest = [0.0] * len(q)
    algebra = algebra_at(spec, state.parameters, state.t, q.tolist(), v.tolist(), rest)
    return bindings(spec, algebra, len(q))


def shortest(constraints: Sequence[Bound], values: Sequence[float]) -> np.ndarray:
    """The least x with slopes x = values; of no length where there are no constraints."""
    if not constraints:
        return np.zeros(1)
    slopes = np.array([one.slopes for one in constraints], dtype=float)
    found: np.ndarray = np.linalg.lstsq(slopes, np.array(values, dtype=float), rcond=DEPENDENT)[0]
    return found
