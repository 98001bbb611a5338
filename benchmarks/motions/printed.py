"""The equations of a system file as ``lagrange equations`` prints them, derived independently of those that
``solve`` integrates."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray
from sympy.parsing.sympy_parser import parse_expr

from lagrange_cli import read_spec, resolve_values

TIME = sympy.Symbol("t")


@dataclass(frozen=True)
class Printed:
    """Symbols and expressions of sympy, the values of the parameters by symbol and by name, and the initial
    state (2 n,)."""

    q: tuple[Any, ...]
    v: tuple[Any, ...]
    accelerations: tuple[Any, ...]
    values: Mapping[Any, float]
    parameters: Mapping[str, float]
    initial: NDArray[np.float64]


def printed_equations(text: str, name: str, settings: Mapping[str, str]) -> Printed:
    """What the command prints of a file, read back by sympy; ``settings`` are those of ``--set``."""
    command = [sys.executable, "-m", "lagrange_cli", "equations", "-", "--json"]
    printed = subprocess.run(command, input=text, stdout=subprocess.PIPE, text=True, check=True)
    found = json.loads(printed.stdout)
    values, called = resolve_values(read_spec(text, name), dict(settings)), found.get("symbols", {})
    known: dict[str, Any] = {"t": TIME}

    def symbol(name: str) -> Any:
        short = called.get(name, name)
        return known.setdefault(short, sympy.Symbol(short))

    q = tuple(symbol(name) for name in found["coordinates"])
    v = tuple(symbol(velocity(name)) for name in found["coordinates"])
    by_symbol = {symbol(name): value for name, value in values.parameters.items()}
    accelerations = tuple(parse_expr(text, known) for text in found["accelerations"].values())
    initial = np.array([*values.q, *values.v])
    return Printed(q, v, accelerations, by_symbol, values.parameters, initial)


def velocity(name: str) -> str:
    """``theta_dot[0]`` of ``theta[0]``."""
    stem, bracket, index = name.partition("[")
    return f"{stem}_dot{bracket}{index}"
