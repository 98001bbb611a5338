"""Whether constraints on velocities are integrable after all: Frobenius' theorem, at random states.

A constraint sum_k a_k dq_k + b dt = 0 is a differential form w. Forms w_i are integrable together if every
dw_i vanishes on all pairs of directions on which all w_i vanish (H. Flanders, Differential Forms, 1963, sec.
7.3). Then they hold along with functions F_i(q, t) that keep their values: they are holonomic. Directions
that leave a holonomic constraint do not count.

The forms and their derivatives are exact; states are random. What vanishes at several of these vanishes
everywhere, for functions are analytic between their branches.
"""

from __future__ import annotations

import random
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from lagrange_cli.expression.evaluate import evaluate
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.expression.text import joined, text_of
from lagrange_cli.mechanics.constraints import Constraints
from lagrange_cli.mechanics.variables import graph_of
from lagrange_cli.model.model import Model
from lagrange_cli.records import dataclass

Form = Mapping[int, Node]
"""The coefficients of dq_k, and of dt behind them."""

Array = np.ndarray[Any, Any]

DRAWS, TRIES = 3, 20
VANISHING = 1e-9
"""Sums smaller than this, relative to their terms, are 0."""
MOST = 60
"""The number of coordinates and time up to which this is examined."""
WORTH = 1_000_000
"""Steps of work that the search for combinations may take."""


@dataclass(frozen=True)
class Combination:
    """An integrable combination of the ``constraints``, with these constant ``factors`` (None where they are
    functions of q and t), and the coefficients of dq_k and dt in it. Its ``name`` says what it is."""

    name: str
    constraints: tuple[str, ...]
    factors: tuple[Node, ...] | None
    form: Form


@dataclass(frozen=True)
class Integrability:
    """Which constraints on velocities are integrable, each ``alone``, by name; and all of them ``together``.

    ``combinations`` are integrable together with those that are so alone, if not all are together.
    ``functions`` of coordinates and t stay constant in all, those of holonomic constraints among them.
    Nothing of this is known (None) of large systems, or where nothing has a value.
    """

    alone: Mapping[str, bool | None]
    together: bool | None
    combinations: tuple[Combination, ...] = ()
    functions: int | None = None


def integrable_forms(model: Model[Node], found: Integrability) -> dict[str, Form]:
    """What is integrable, by names: constraints, and combinations of them."""
    given = {one.name: form for one, form in zip(model.constraints, forms_of(model))}
    forms = {name: given[name] for name, alone in found.alone.items() if alone}
    return forms | {each.name: each.form for each in found.combinations}


def integrability(model: Model[Node], parameters: Mapping[str, float]) -> Integrability:
    """The result of Frobenius' theorem for the nonholonomic constraints of a model with these parameters."""
    graph, forms = graph_of(model), forms_of(model)
    moving = [k for k, one in enumerate(model.constraints) if not one.holonomic]
    variables = (*model.q, model.time)
    names = [model.constraints[k].name for k in moving]
    if len(variables) > MOST:
        return Integrability(dict.fromkeys(names), None)
    turning = {
        k: {
            (i, j): graph.diff(a, x)
            for i, a in forms[k].items()
            for j, x in enumerate(variables)
            if i != j and a.symbols & x.symbols
        }
        for k in moving
    }
    nodes = [a for form in forms for a in form.values()]
    nodes += [derivative for one in turning.values() for derivative in one.values()]
    states = [*draws(nodes, parameters)]
    if not states:
        return Integrability(dict.fromkeys(names), None)
    bound = [k for k in range(len(forms)) if k not in moving]
    size = len(variables)

    def judged(together: Sequence[int], judging: Sequence[int]) -> bool:
        return all(vanishes(size, forms, turning, values, together, judging) for values in states)

    alone = {k: judged([*bound, k], [k]) for k in moving}
    found = {name: alone[k] for name, k in zip(names, moving)}
    if judged([*bound, *moving], moving):
        return Integrability(found, True, functions=rank(size, forms, states[0]))
    known = [*bound, *(k for k in moving if alone[k])]
    others = [k for k in moving if not alone[k]]
    kept = rank(size, [forms[k] for k in known], states[0])
    if len(others) == 1:
        return Integrability(found, False, functions=kept)
    combined = graph.work.attempt(WORTH, lambda: combinations(model, forms, known, others, parameters))
    if combined is None:
        return Integrability(found, False)
    return Integrability(found, False, combined, kept + len(combined))


def forms_of(model: Model[Node]) -> list[Form]:
    """The constraints of a model as differential forms."""
    constraints = Constraints(model)
    return [
        {**slopes, **({} if drift.is_zero else {len(model.q): drift})}
        for slopes, drift in zip(constraints.slopes, constraints.drifts)
    ]


def combinations(
    model: Model[Node],
    forms: Sequence[Form],
    known: Sequence[int],
    others: Sequence[int],
    parameters: Mapping[str, float],
) -> tuple[Combination, ...] | None:
    """The combinations of ``others`` that are integrable together with those ``known`` to be; None where
    nothing is known."""
    from lagrange_cli.expression.residues import NoValue
    from lagrange_cli.mechanics.constrained.closure import State, annihilating, closure, solved

    graph, variables, order = graph_of(model), (*model.q, model.time), [*known, *others]
    for seed in range(TRIES):
        try:
            state = State(graph, parameters, seed)
            system = solved(graph, variables, [forms[k] for k in order], state)
            independent = {order[row]: forms[order[row]] for row in system.rows if order[row] in others}
            fields = closure(system, len(independent), state)
            count = len(independent) - len(fields)
            basis = annihilating(system, independent, fields, state) if count else []
        except NoValue:
            continue
        if len(basis) != count:
            return None
        return tuple(
            combination(model, forms, factors, constant, f" {number}" if count > 1 else "")
            for number, (factors, constant) in enumerate(basis, start=1)
        )
    return None


def combination(
    model: Model[Node], forms: Sequence[Form], factors: Mapping[int, Node], constant: bool, number: str
) -> Combination:
    """The combination with these factors by the numbers of constraints; ``number`` tells it from others."""
    factors = dict(sorted(factors.items()))
    terms: dict[int, list[tuple[Node, float]]] = {}
    for k, factor in factors.items():
        for i, a in forms[k].items():
            terms.setdefault(i, []).append((factor * a, 1.0))
    form = {i: graph_of(model).sum(some) for i, some in terms.items()}
    names = tuple(model.constraints[k].name for k in factors)
    if constant and graph_of(model).split_coefficient(next(iter(factors.values())))[0] < 0:
        return combination(model, forms, {k: -one for k, one in factors.items()}, constant, number)
    if not constant:
        return Combination(f"combination{number} of {', '.join(names)}", names, None, form)
    each = {name: graph_of(model).symbol(name) for name in names}
    name = joined([text_of(factor * each[name]) for factor, name in zip(factors.values(), names)])
    return Combination(name, names, tuple(factors.values()), form)


def draws(nodes: Sequence[Node], parameters: Mapping[str, float]) -> Iterable[Mapping[Node, float]]:
    """Values of expressions at random states where all of them have some."""
    symbols = [str(node.data) for node in reachable(nodes) if node.kind is Kind.SYMBOL]
    source = random.Random(1)
    found = 0
    for _ in range(TRIES):
        chosen = {name: source.uniform(0.2, 1.4) * source.choice((-1, 1)) for name in symbols}
        try:
            values, _ = evaluate(nodes, {**chosen, **parameters})
        except (ArithmeticError, ValueError):
            continue
        if all(np.isfinite(values[node]) for node in nodes):
            found += 1
            yield values
        if found == DRAWS:
            return


def vanishes(
    size: int,
    forms: Sequence[Form],
    turning: Mapping[int, Mapping[tuple[int, int], Node]],
    values: Mapping[Node, float],
    together: Sequence[int],
    judging: Sequence[int],
) -> bool:
    """Whether dw of the forms ``judging`` vanishes at a state, where the forms ``together`` do."""
    matrix = matrix_of(size, [forms[k] for k in together], values)
    _, steep, directions = np.linalg.svd(matrix)
    free = directions[significant(steep) :]
    for k in judging:
        derivative = np.zeros((size, size))
        for (i, j), node in turning[k].items():
            derivative[j, i] += values[node]
            derivative[i, j] -= values[node]
        inside = free @ derivative @ free.T
        whole = max(float(np.abs(derivative).max(initial=0.0)), float(np.abs(matrix).max(initial=0.0)))
        if np.abs(inside).max(initial=0.0) > VANISHING * whole:
            return False
    return True


def matrix_of(size: int, forms: Sequence[Form], values: Mapping[Node, float]) -> Array:
    """The coefficients of forms at a state, a form in a row."""
    matrix = np.zeros((len(forms), size))
    for row, form in zip(matrix, forms):
        for i, a in form.items():
            row[i] = values[a]
    return matrix


def rank(size: int, forms: Sequence[Form], values: Mapping[Node, float]) -> int:
    """How many forms are independent at a state."""
    return significant(np.linalg.svd(matrix_of(size, forms, values), compute_uv=False))


def significant(steep: Array) -> int:
    """How many singular values are not 0."""
    return int((steep > VANISHING * max(steep.max(initial=0.0), 1e-300)).sum())
