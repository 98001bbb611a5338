"""``Scene``: a difficult motion, its reference, and the other programs that can integrate it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

Exact = Callable[[Mapping[str, Any], tuple[Any, ...], tuple[Any, ...], Any], tuple[Any, ...]]
"""q at a time, from the parameters and the initial q and v, all numbers of mpmath."""

QUADRUPLE = "quadruple"
"""The printed equations, which sympy derives, integrated by heyoka in quadruple precision."""


@dataclass(frozen=True)
class Scene:
    """A system file, its stop time and its reference.

    ``reference`` is a closed form, ``QUADRUPLE``, or None if the motion is not known and only conserved
    quantities can be judged. ``peers`` are the programs that can integrate it. ``error`` is the largest error
    of q, relative to its size, that counts as right if one rounding of the initial values explains less.
    ``size`` is the size of the terms of h and p, where T, U and p do not show it. ``quick`` scenes are in the
    fast subset. ``known`` explains why a scene is wrong, if it is.
    """

    name: str
    what: str
    text: str
    stop: float
    reference: Exact | str | None = QUADRUPLE
    start: float = 0.0
    samples: int = 201
    peers: tuple[str, ...] = ("heyoka", "DOP853", "Radau")
    settings: tuple[str, ...] = ()
    error: float = 1e-11
    size: float = 0.0
    known: str = ""
    quick: bool = False


def particle(potential: str, *, x: str = "1", v: str = "0", more: str = "", **parameters: str) -> str:
    """The file of a particle of mass 1 on a line, with ``more`` lines at its end."""
    listed = "".join(f"  {name}: {value}\n" for name, value in parameters.items())
    return (
        (f"parameters:\n{listed}" if listed else "")
        + f"coordinates:\n  x: {{initial: {x}, velocity: {v}}}\n"
        + f"masses: {{p: 1}}\nembedding: {{p: [x]}}\npotential: {potential}\n{more}"
    )


def bodies(masses: str, x: str, y: str, u: str, v: str, constant: str = "1") -> str:
    """The file of point masses in a plane, which attract one another; lists of numbers."""
    count = len(masses.split(","))
    return f"""\
parameters:
  G: {constant}
  m: [{masses}]
  x0: [{x}]
  y0: [{y}]
  u0: [{u}]
  v0: [{v}]
coordinates:
  x[i in range({count})]: {{initial: "x0[i]", velocity: "u0[i]"}}
  y[i in range({count})]: {{initial: "y0[i]", velocity: "v0[i]"}}
masses:
  body[i in range({count})]: m[i]
embedding:
  body[i in range({count})]: [x[i], y[i]]
potential: -sum(G*m[i]*m[j]/norm(body[i] - body[j]) for i in range({count}) for j in range(i))
"""
