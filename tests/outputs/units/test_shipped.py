"""Units by dimension: of shipped systems."""

from __future__ import annotations

import pytest

from lagrange_cli.expression.vocabulary import family_name
from lagrange_cli.outputs.units import find_units
from tests.support.motion import CONSTRAINED, NAMES, spec_of
from tests.support.units import ANGULAR, ENERGY, LINEAR, units


@pytest.mark.parametrize(
    ("system", "expected"),
    [
        ("pendulum", {"t": "s", "q/theta": "rad", "v/theta": "rad/s", "diagnostics/p/theta": ANGULAR}),
        ("harmonic_oscillator", {"v/x": "m/s", "diagnostics/p/x": LINEAR, "diagnostics/action": ANGULAR}),
        ("charged_particle", {"diagnostics/p/y": LINEAR, "diagnostics/U": ENERGY, "positions/ion": "m"}),
        ("driven_damped_pendulum", {"diagnostics/ledger/p/theta": ANGULAR, "diagnostics/ledger/h": ENERGY}),
        ("gauge_oscillator", {"diagnostics/h": ENERGY, "diagnostics/p/x": LINEAR}),
        ("rotating_hoop", {"diagnostics/h": ENERGY, "diagnostics/energy": ENERGY}),
        (
            "solar_system",
            {
                "t": "d",
                "v/x": "AU/d",
                "diagnostics/p/z": "Msun*AU/d",
                "diagnostics/h": "Msun*AU^2/d^2",
                "positions/body": "AU",
            },
        ),
    ],
)
def test_units_of_shipped_systems(system, expected):
    found = find_units(spec_of(system)).texts
    assert {path: found.get(path) for path in expected} == expected


@pytest.mark.exhaustive(keep=32)
@pytest.mark.parametrize("system", [*NAMES, *CONSTRAINED])
def test_no_shipped_system_contradicts_itself(system):
    found = find_units(spec_of(system))
    assert found.conflicts == ()
    coordinates = {family_name(one.name): one.unit for one in spec_of(system).coordinates}
    known = ("diagnostics/h" in found.texts, "t" in found.texts)
    assert known == (True, True) or not all(coordinates.values()) or system == "lattice"


def test_conserved_quantities_have_units():
    text = "parameters: {m: {value: 1, unit: kg}, k: {value: 2, unit: N*m^2}}\nmasses: {p: m}\n"
    text += "coordinates: {x: {initial: 1, unit: m}, y: {initial: 0, unit: m}}\npositions: {p: [x, y]}\n"
    found = units(text + "potential: -k/norm(p)\n")
    assert found["diagnostics/conserved/A_x"] == "kg*m^3/s^2"
    assert found["diagnostics/conserved/h_x"] == found["diagnostics/conserved/F_xy"] == ENERGY
