"""Arithmetic of a thousand digits, for what doubles cannot tell from nothing."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import mpmath

from lagrange_cli.expression.evaluate import evaluate
from lagrange_cli.expression.node import Node

DIGITS = 1000


def vanish(nodes: Sequence[Node], values: Mapping[str, float]) -> dict[Node, bool | None]:
    """Whether each expression is nothing beside the terms that it is the sum of; None: it has no value there.

    Only identities of its terms make it so, or a scale of 1e-500.
    """
    with mpmath.workdps(DIGITS):
        exact = {name: mpmath.mpf(x) for name, x in values.items()}
        value, size = evaluate(nodes, exact, power, function)
        least = mpmath.mpf(10) ** (-DIGITS // 2)
        return {
            node: bool(abs(value[node]) <= least * size[node]) if mpmath.isfinite(value[node]) else None
            for node in nodes
        }


def power(base: mpmath.mpf, exponent: mpmath.mpf) -> mpmath.mpf:
    """``base ** exponent`` in real arithmetic."""
    try:
        return real(mpmath.power(base, exponent))
    except ZeroDivisionError:
        return mpmath.inf


def function(name: str, arguments: Sequence[mpmath.mpf]) -> mpmath.mpf:
    """An elementary function in real arithmetic."""
    return real(getattr(mpmath, name)(*arguments))


def real(number: mpmath.mpf | mpmath.mpc) -> mpmath.mpf:
    """The number, or nan if it is complex."""
    return number if isinstance(number, mpmath.mpf) else math.nan
