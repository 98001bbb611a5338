"""The catalog of outputs: what its rows say of the datasets is what a run writes."""

import pytest

from lagrange_cli.outputs.catalog import DEFAULT_OUTPUTS, OUTPUTS, PARTICLE_OUTPUTS
from lagrange_cli.outputs.plan import make_plan
from lagrange_cli.outputs.units import find_units
from lagrange_cli.spec.read import read_spec
from tests.support.motion import residual_of

TEXT = """\
time: s
parameters: {m: {value: 1, unit: kg}, k: {value: 1, unit: N/m}}
coordinates: {x: {initial: 1, unit: m}}
masses: {bob: m}
positions: {bob: [x, 0*x]}
potential: k*x**2/2
observables: {height: 2*x}
constraints: {rod: x**2}
"""
BODY = """\
bodies:
  top: {mass: m, position: [x, 0, 0], solid: {sphere: 0.1}, orientation: {euler: [x, 1, 0]}}
"""


@pytest.mark.parametrize("name", OUTPUTS)
def test_an_output_makes_the_datasets_that_its_row_names_and_each_has_a_unit(name):
    text = TEXT + BODY if OUTPUTS[name].section == "bodies" else TEXT
    spec = read_spec(text, "a.yaml")
    made = [one.path for one in make_plan(residual_of(text), frozenset({name})).recording.datasets]
    owner = {"observables": "height", "multipliers": "rod", "constraints": "rod", "conserved": "h"}.get(
        name, "x"
    )
    patterns = (
        OUTPUTS[name]
        .datasets.replace("NAME", owner)
        .replace("PARTICLE", "bob")
        .replace("BODY", "top")
        .split()
    )
    assert [f"/{path}" for path in made] == patterns
    plain = {"orientations/top"}  # a matrix of numbers without a unit
    assert set(made) - plain <= set(find_units(spec).texts)


def test_the_sets_of_outputs_follow_from_the_rows():
    assert DEFAULT_OUTPUTS == ("q", "v", "p", "h")
    of_bodies = {"angular_velocities", "angular_momenta", "rotational_energies", "orientations"}
    assert {"T", "U", "energy", "positions", "reactions"} | of_bodies == PARTICLE_OUTPUTS
