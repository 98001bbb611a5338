"""``Case``: a system file with random numbers, and what is true of its motion."""

from __future__ import annotations

import random
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import mpmath

MP = mpmath.mp.clone()
MP.dps = 40
"""Digits of all references."""
Number = Any
"""A number of ``MP``."""
Numbers = Any
"""Those of a case, as attributes by name."""


@dataclass(frozen=True)
class Truth:
    """What is true at the times asked for: ``values`` by path in the output, None where nothing is checked.

    ``ends`` is when the motion ends, if it does. ``events`` are complete lists by path: ``events/hit/t``.
    ``steady`` tells that what ends it is an event with ``action: stop``, no failure. ``sizes`` by path are
    those of what a value is a difference of, which may be small itself.
    """

    values: Mapping[str, Sequence[Number | None]]
    ends: Number | None = None
    events: Mapping[str, Sequence[Number]] = field(default_factory=dict)
    steady: bool = False
    sizes: Mapping[str, Number] = field(default_factory=dict)


Reference = Callable[[Numbers, Sequence[Number]], Truth]


@dataclass
class System:
    """What a system file says, by coordinate; every part is a text in the names of ``numbers``.

    ``lagrangian`` are further terms of L, which make the file one with the key ``lagrangian``.
    """

    coordinates: dict[str, tuple[str, str]] = field(default_factory=dict)
    masses: dict[str, str] = field(default_factory=dict)
    potential: list[str] = field(default_factory=list)
    lagrangian: list[str] = field(default_factory=list)
    forces: dict[str, list[str]] = field(default_factory=dict)
    dissipation: list[str] = field(default_factory=list)
    events: dict[str, str] = field(default_factory=dict)

    def merged(self, other: System) -> System:
        """Both, side by side."""
        return System(
            {**self.coordinates, **other.coordinates}, {**self.masses, **other.masses},
            self.potential + other.potential, self.lagrangian + other.lagrangian,
            {**self.forces, **other.forces}, self.dissipation + other.dissipation,
            {**self.events, **other.events},
        )  # fmt: skip

    def renamed(self, names: Mapping[str, str]) -> System:
        """With other names of coordinates and numbers."""

        def new(text: str) -> str:
            return replaced(text, names)

        return System(
            {new(name): (new(q), new(v)) for name, (q, v) in self.coordinates.items()},
            {new(name): new(mass) for name, mass in self.masses.items()},
            [*map(new, self.potential)], [*map(new, self.lagrangian)],
            {new(name): [*map(new, terms)] for name, terms in self.forces.items()},
            [*map(new, self.dissipation)],
            {new(name): new(text) for name, text in self.events.items()},
        )  # fmt: skip

    def written(self, numbers: Mapping[str, str], draw: random.Random, keep: str) -> str:
        """The file: some numbers, drawn at random, stand where they are used, the others (``keep`` among
        them) are parameters; L stands for T - U in some."""
        listed = {name for name in numbers if name == keep or draw.random() < 0.5}
        inline = {
            name: f"({value})" if value.startswith("-") else value
            for name, value in numbers.items()
            if name not in listed
        }

        def put(text: str) -> str:
            return replaced(text, inline)

        lines = []
        if listed:
            lines += ["parameters:", *(f"  {name}: {numbers[name]}" for name in numbers if name in listed)]
        lines += ["coordinates:"]
        for name, (q, v) in self.coordinates.items():
            lines.append(f"  {name}: {{initial: {put(q)}, velocity: {put(v)}}}")
        if self.lagrangian or draw.random() < 0.3:
            kinetic = [f"{put(mass)}*{name}_dot**2/2" for name, mass in self.masses.items()]
            terms = [*kinetic, *map(put, self.lagrangian), *(f"-({put(each)})" for each in self.potential)]
            lines += ["lagrangian: >-", *(f"  {'+ ' if k else ''}{term}" for k, term in enumerate(terms))]
        else:
            lines += ["masses:", *(f"  p_{name}: {put(mass)}" for name, mass in self.masses.items())]
            lines += ["embedding:", *(f"  p_{name}: [{name}]" for name in self.masses)]
            lines += ["potential: >-", *([f"  {'+ ' if k else ''}{put(each)}"
                                          for k, each in enumerate(self.potential)] or ["  0"])]  # fmt: skip
        if self.forces:
            lines.append("generalized_forces:")
            for name, terms in self.forces.items():
                lines += [f"  {name}: >-", *(f"    {'+ ' if k else ''}{put(t)}" for k, t in enumerate(terms))]
        if self.dissipation:
            lines.append(f"dissipation: {' + '.join(map(put, self.dissipation))}")
        if self.events:
            lines += ["events:", *(f"  {name}: {put(text)}" for name, text in self.events.items())]
        return "\n".join(lines) + "\n"


def replaced(text: str, names: Mapping[str, str]) -> str:
    """``text`` with whole words in place of others; a coordinate's velocity goes with it."""
    if not names:
        return text
    words = {**names, **{f"{old}_dot": f"{new}_dot" for old, new in names.items()}}
    pattern = r"\b(" + "|".join(sorted(map(re.escape, words), key=len, reverse=True)) + r")\b"
    return re.sub(pattern, lambda found: words[found[1]], text)


@dataclass(frozen=True)
class Case:
    """A system, the decimal numbers that it contains by name, and what is true of it.

    It is sampled ``samples`` times up to ``stop``. ``over`` is the number that differs between the members of
    a sweep. ``h`` tells whether the energy function is conserved, ``momenta`` which generalized momenta are:
    nothing else may be said to be.
    """

    family: str
    name: str
    system: System
    numbers: Mapping[str, str]
    reference: Reference
    stop: str
    over: str
    h: bool = False
    momenta: frozenset[str] = frozenset()
    outputs: tuple[str, ...] = ("q", "v", "h")
    samples: int = 5
    text: str = ""

    def truth(self, times: Sequence[Number], changed: Mapping[str, Number] | None = None) -> Truth:
        """What is true at ``times``, where some numbers are ``changed``."""
        given = {name: MP.mpf(value) for name, value in self.numbers.items()}
        return self.reference(SimpleNamespace(**{**given, **(changed or {})}), times)


class Draw:
    """Random numbers of a case, which are remembered by name as they are written, and random spellings."""

    def __init__(self, source: random.Random) -> None:
        self.source = source
        self.numbers: dict[str, str] = {}

    def uniform(self, name: str, low: float, high: float, digits: int = 4) -> str:
        """A decimal number; returns its name."""
        self.numbers[name] = f"{self.source.uniform(low, high):.{digits}f}"
        return name

    def log(self, name: str, low: float, high: float) -> str:
        """A decimal number of four digits, its logarithm evenly distributed."""
        import math

        self.numbers[name] = f"{math.exp(self.source.uniform(math.log(low), math.log(high))):.3e}"
        return name

    def value(self, name: str) -> float:
        """The number of that name."""
        return float(self.numbers[name])

    def fix(self, name: str, value: float) -> str:
        """A number that follows from others, but is written with four digits."""
        self.numbers[name] = f"{value:.4g}"
        return name

    def choice(self, *of: Any) -> Any:
        """One of these."""
        return self.source.choice(of)

    # -- spellings ------------------------------------------------------------------------------------

    def positive(self, u: str) -> str:
        """max(0, u)."""
        return str(self.choice(
            f"max(0, {u})", f"({u} + abs({u}))/2", f"({u} + sqrt(({u})**2))/2", f"where({u} > 0, {u}, 0)",
            f"(-min(0, -({u})))", f"({u})*(1 + sign({u}))/2", f"where({u} <= 0, 0, {u})",
            f"({u} + max({u}, -({u})))/2",
        ))  # fmt: skip

    def step(self, u: str) -> str:
        """1 where u > 0, else 0."""
        return str(self.choice(
            f"where({u} > 0, 1, 0)", f"(1 + sign({u}))/2", f"where({u} <= 0, 0, 1)", f"where({u} >= 0, 1, 0)",
            f"where(not ({u} < 0), 1, 0)", f"max(0, sign({u}))", f"where(0 < {u}, 1, 0)",
        ))  # fmt: skip

    def absolute(self, u: str) -> str:
        """|u|."""
        return str(self.choice(
            f"abs({u})", f"sqrt(({u})**2)", f"max({u}, -({u}))", f"(({u})**2)**0.5",
            f"where({u} < 0, -({u}), {u})", f"({u})*sign({u})", f"(({u})**4)**0.25",
        ))  # fmt: skip

    def sign(self, u: str) -> str:
        """The sign of u, 0 at 0."""
        return str(self.choice(
            f"sign({u})", f"sign({u})", f"where({u} > 0, 1, where({u} < 0, -1, 0))",
            f"where({u} >= 0, 1, -1)", f"(where({u} > 0, 1, 0) - where({u} < 0, 1, 0))",
        ))  # fmt: skip
