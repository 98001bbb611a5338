"""The equations of a scene as ``lagrange equations`` prints them, derived independently of those that
``solve`` integrates."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import sympy
from sympy.parsing.sympy_parser import parse_expr

from benchmarks.stress.scene import Scene
from lagrange_cli import read_spec, resolve_values


@dataclass(frozen=True)
class Equations:
    """Symbols and expressions of sympy, and the numbers that a run begins with."""

    q: tuple[Any, ...]
    v: tuple[Any, ...]
    parameters: Mapping[Any, float]
    accelerations: tuple[Any, ...]
    h: Any
    conserved: bool
    initial: tuple[float, ...]


TIME = sympy.Symbol("t")


def values_of(scene: Scene) -> Any:
    """Parameters and the initial state, as doubles."""
    settings = dict(setting.split("=", 1) for setting in scene.settings)
    return resolve_values(read_spec(scene.text, scene.name), settings)


def equations_of(scene: Scene) -> Equations:
    """What the command prints, read back by sympy."""
    command = [sys.executable, "-m", "lagrange_cli", "equations", "-", "--json"]
    printed = subprocess.run(command, input=scene.text, stdout=subprocess.PIPE, text=True, check=True)
    found = json.loads(printed.stdout)
    values, called = values_of(scene), found.get("symbols", {})
    known: dict[str, Any] = {"t": TIME}

    def symbol(name: str) -> Any:
        short = called.get(name, name)
        return known.setdefault(short, sympy.Symbol(short))

    q = tuple(symbol(name) for name in found["coordinates"])
    v = tuple(symbol(velocity(name)) for name in found["coordinates"])
    parameters = {symbol(name): value for name, value in values.parameters.items()}
    accelerations = tuple(parse_expr(text, known) for text in found["accelerations"].values())
    conserved = any(each["quantity"] == "h" for each in found["conserved"])
    h = parse_expr(found["h"], known)
    return Equations(q, v, parameters, accelerations, h, conserved, (*values.q, *values.v))


def velocity(name: str) -> str:
    """``theta_dot[0]`` of ``theta[0]``."""
    stem, bracket, index = name.partition("[")
    return f"{stem}_dot{bracket}{index}"
