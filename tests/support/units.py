"""Systems with units, and what is found of these."""

from __future__ import annotations

from collections.abc import Mapping

from lagrange_cli.outputs.units import find_units
from lagrange_cli.spec.read import read_spec

ENERGY = "kg*m^2/s^2"
ANGULAR, LINEAR = "kg*m^2/s", "kg*m/s"


def units(text: str) -> Mapping[str, str]:
    """The units by path; the file must not contradict itself."""
    found = find_units(read_spec(text, "a.yaml"))
    assert found.conflicts == ()
    return found.texts


def conflicts(text: str) -> list[str]:
    return [one.message for one in find_units(read_spec(text, "a.yaml")).conflicts]


def one(potential: str = "k*x**2/2", **changes: str) -> str:
    """A particle on a line, in kg, m and s but for ``changes``."""
    parts = {
        "m": "{value: 1, unit: kg}",
        "k": "{value: 4, unit: N/m}",
        "x": "{initial: 1, unit: m}",
        "mass": "m",
        "position": "[x]",
        "more": "",
        **changes,
    }
    return (
        f"parameters: {{m: {parts['m']}, k: {parts['k']}}}\ncoordinates: {{x: {parts['x']}}}\n"
        f"masses: {{bead: {parts['mass']}}}\nembedding: {{bead: {parts['position']}}}\n"
        f"potential: {potential}\n{parts['more']}"
    )
