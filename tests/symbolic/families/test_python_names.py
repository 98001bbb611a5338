"""Modules of Python work whatever sizes, indices, lists and coordinates are called."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import lagrange_cli

SYSTEM = """\
sizes: {{{size}: 3}}
parameters: {{k: [1, 2, 3], {table}: [1, 2, 0]}}
coordinates: {{"{x}[{i} in range({size})]": {{initial: 0.1}}}}
masses: {{"m[{i} in range({size})]": "1 + {i}"}}
embedding: {{"m[{i} in range({size})]": "{x}[{i}]"}}
potential: >-
  sum(k[{i}]*({x}[{i}] - {x}[{table}[{i}]])**2*{table}[{i}]*({i} + 2)**2/{size} for {i} in range({size}))
  + sum({x}[{i}]**2 for {i} in range({size}))**2
events:
  "hit[{i} in range({size})]":
    when: "{x}[{i}] - {table}[{i}]"
    action: {{set: {{"{x}_dot[{i}]": "-{x}_dot[{table}[{i}]]*{size}"}}}}
"""
USUAL = {"size": "N", "table": "of", "x": "x", "i": "i"}
NAMES = ["q", "v", "a", "p", "values", "parameters", "place", "events", "accelerations", "len", "lambda", "n"]


def numbers(names: dict[str, str]) -> list[float]:
    """What the functions of the modules give."""
    equations = lagrange_cli.equations(SYSTEM.format(**names), indexed=True)
    module: dict[str, Any] = {}
    exec(equations.write("python"), module)
    q, v = [0.3, 0.1, -0.4], [0.2, -0.5, 0.6]
    found = [module["accelerations"](0.0, q, v), module["events"](0.0, q, v)]
    found += module["after_hit"]((1,), 0.0, q, v)[:2]
    exec(equations.write("python", form="hamilton"), module)
    found += [[module["hamiltonian"](0.0, q, v)], module["momentum_rates"](0.0, q, v)]
    return [x for one in found for x in one]


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize("which", USUAL)
def test_names_of_the_file_and_of_the_module_do_not_meet(which: str) -> None:
    expected = numbers(USUAL)
    for name in NAMES:
        assert np.allclose(numbers({**USUAL, which: name}), expected, rtol=1e-14, atol=0.0), name
