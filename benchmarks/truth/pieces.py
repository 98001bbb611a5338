"""Motions in pieces, each by a linear equation that is solved."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.truth.case import MP, Number, Truth
from benchmarks.truth.roots import bracketed

GRID = 4000
"""At how many times within a piece the sign of a guard is looked up."""
PIECES = 3000


class InFloats:
    """The functions that ``Linear`` needs, of arrays of doubles."""

    exp, cosh, sinh, cos, sin = np.exp, np.cosh, np.sinh, np.cos, np.sin
    sqrt = staticmethod(np.lib.scimath.sqrt)


@dataclass(frozen=True)
class Linear:
    """x'' = f + g t - k x - c x' + a cos(w t + phi), solved."""

    f: Number = 0
    k: Number = 0
    c: Number = 0
    a: Number = 0
    w: Number = 0
    phi: Number = 0
    g: Number = 0

    def at(self, q: Number, v: Number, t0: Number, t: Any, m: Any = MP) -> tuple[Any, Any]:
        """Position and velocity at ``t`` from those at ``t0``, by the functions of ``m``."""
        f, k, c, a, w, phi, g = (
            (each if m is MP else float(each))
            for each in (self.f, self.k, self.c, self.a, self.w, self.phi, self.g)
        )
        q, v, t0 = (q, v, t0) if m is MP else (float(q), float(v), float(t0))
        s = t - t0

        def particular(t: Any) -> tuple[Any, Any]:
            x, u = 0 * t, 0 * t
            if a:
                d, e = k - w * w, c * w
                cosine, sine = m.cos(w * t + phi), m.sin(w * t + phi)
                scale = a / (d * d + e * e)
                x, u = x + scale * (d * cosine + e * sine), u + scale * w * (e * cosine - d * sine)
            if k:
                x, u = x + (f + g * t - c * g / k) / k, u + g / k
            elif c:
                x, u = x + (f / c - g / c**2) * t + g / c * t**2 / 2, u + f / c - g / c**2 + g / c * t
            else:
                x, u = x + f * t**2 / 2 + g * t**3 / 6, u + f * t + g * t**2 / 2
            return x, u

        x0, u0 = particular(t0)
        x1, u1 = particular(t)
        q, v = q - x0, v - u0
        if not k and not c:
            return x1 + q + v * s, u1 + v + 0 * s
        root = m.sqrt(c * c / 4 - k)
        half, decay = c / 2, m.exp(-c / 2 * s)
        even = m.cosh(root * s)
        odd = m.sinh(root * s) / root if root else s
        x = decay * (q * even + (v + half * q) * odd)
        u = decay * (v * even - (k * q + half * v) * odd)
        return x1 + x.real, u1 + u.real


Guard = Callable[[Sequence[Any], Sequence[Any], Any], Any]
"""A function of q, v and t, positive as long as the mode lasts."""


@dataclass(frozen=True)
class Exit:
    """Where ``guard`` ceases to be positive ``then`` gives the next mode and the state with which it begins;
    ``name`` is that of an event."""

    guard: Guard
    then: Callable[[Any, list[Number], list[Number], Number], tuple[Any, list[Number], list[Number]]]
    name: str = ""


def to(mode: Any) -> Callable[..., tuple[Any, list[Number], list[Number]]]:
    """Goes on in ``mode`` with the state as it is."""
    return lambda _, q, v, t: (mode, q, v)


@dataclass(frozen=True)
class Pieces:
    """A motion in pieces: (t, mode, q, v, laws) at the beginning of each; and events (name, t, q, v)."""

    starts: list[tuple[Number, Any, list[Number], list[Number], Sequence[Linear]]]
    events: list[tuple[str, Number, list[Number], list[Number]]]

    def at(self, t: Number) -> tuple[list[Number], list[Number]]:
        """The state at time ``t``."""
        start = next(each for each in reversed(self.starts) if each[0] <= t)
        return state(start[4], start[2], start[3], start[0], t)

    def truth(self, times: Sequence[Number], names: Sequence[str] = ("x",)) -> Truth:
        """Of coordinates with these names."""
        states = [self.at(t) for t in times]
        values = {f"q/{name}": [q[k] for q, _ in states] for k, name in enumerate(names)}
        values |= {f"v/{name}": [v[k] for _, v in states] for k, name in enumerate(names)}
        events: dict[str, list[Number]] = {}
        for name, t, q, v in self.events:
            if name:
                events.setdefault(f"events/{name}/t", []).append(t)
                for k, each in enumerate(names):
                    events.setdefault(f"events/{name}/q/{each}", []).append(q[k])
                    events.setdefault(f"events/{name}/v/{each}", []).append(v[k])
        return Truth(values, events=events)


def state(
    laws: Sequence[Linear], q: Sequence[Number], v: Sequence[Number], t0: Number, t: Any, m: Any = MP
) -> tuple[list[Any], list[Any]]:
    """Every coordinate by its law."""
    found = [law.at(x, u, t0, t, m) for law, x, u in zip(laws, q, v)]
    return [x for x, _ in found], [u for _, u in found]


def pieces(
    mode: Any,
    q: Sequence[Number],
    v: Sequence[Number],
    laws: Callable[[Any, list[Number], list[Number], Number], Sequence[Linear]],
    exits: Callable[[Any], Sequence[Exit]],
    stop: Number,
) -> Pieces:
    """Follow a motion from mode to mode up to ``stop``; the first exit of each is found on a fine grid, then
    with all digits."""
    t, q, v = MP.mpf(0), [*q], [*v]
    starts, events = [], []
    for _ in range(PIECES):
        law = laws(mode, q, v, t)
        starts.append((t, mode, q, v, law))
        if t >= stop:
            break
        found = first_exit(law, q, v, t, exits(mode), stop)
        if found is None:
            break
        t, way, (q, v) = found
        if way.name:
            events.append((way.name, t, q, v))
        mode, q, v = way.then(mode, q, v, t)
    else:
        raise ArithmeticError("too many pieces")
    return Pieces(starts, events)


def first_exit(
    laws: Sequence[Linear], q: list[Number], v: list[Number], t: Number, ways: Sequence[Exit], stop: Number
) -> tuple[Number, Exit, tuple[list[Number], list[Number]]] | None:
    """When, where, and in what state a mode is left."""
    span = float(stop - t)
    since = span * np.concatenate([np.geomspace(1e-12, 1.0 / GRID, 60), np.arange(2, GRID + 1) / GRID])
    best: tuple[Number, Exit] | None = None
    for way in ways:
        values = guard_on(way, laws, q, v, t, since)
        # between two grid points a guard may dip below 0 and come back: look closer at its small minima
        inner = np.flatnonzero((values[1:-1] < values[:-2]) & (values[1:-1] <= values[2:])) + 1
        grid, signs = since, values
        for k in inner[:200]:
            if values[k] > 0:
                closer = np.linspace(since[k - 1], since[k + 1], 50)
                more = guard_on(way, laws, q, v, t, closer)
                if (more < 0).any():
                    grid, signs = np.concatenate([grid, closer]), np.concatenate([signs, more])
        order = np.argsort(grid, kind="stable")
        grid, signs = grid[order], signs[order]
        below = np.flatnonzero(signs < -1e-13 * np.max(np.abs(signs)))

        def value(s: Number, way: Exit = way) -> Number:
            return way.guard(*state(laws, q, v, t, t + s), t + s)

        # shortly before the end of the motion the grid is so fine that doubles may be below 0 by rounding
        k = next((k for k in below if value(MP.mpf(grid[k])) < 0), None)
        if k is None:
            continue
        low, high = (MP.mpf(grid[k - 1]) if k else MP.mpf(0)), MP.mpf(grid[k])
        while k > 1 and value(low) < 0:  # a point of the grid is the root, but for rounding
            k -= 1
            low = MP.mpf(grid[k - 1])
        root = t + bracketed(value, low, high)
        if root < stop and (best is None or root < best[0]):
            best = root, way
    if best is None:
        return None
    return best[0], best[1], state(laws, q, v, t, best[0])


def guard_on(way: Exit, laws: Any, q: Any, v: Any, t: Number, since: Any) -> Any:
    """The guard in doubles at these times since ``t``."""
    at, speed = state(laws, q, v, t, float(t) + since, InFloats)
    return np.asarray(way.guard(at, speed, float(t) + since), dtype=float) + 0 * since
