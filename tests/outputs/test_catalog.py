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
"""


@pytest.mark.parametrize("name", OUTPUTS)
def test_an_output_makes_the_datasets_that_its_row_names_and_each_has_a_unit(name):
    spec = read_spec(TEXT, "a.yaml")
    made = [one.path for one in make_plan(residual_of(TEXT), frozenset({name})).recording.datasets]
    owner = {"positions": "bob", "observables": "height"}.get(name, "x")
    patterns = OUTPUTS[name].datasets.replace("NAME", owner).replace("PARTICLE", owner).split()
    assert [f"/{path}" for path in made] == patterns
    assert set(made) <= set(find_units(spec).texts)


def test_the_sets_of_outputs_follow_from_the_rows():
    assert DEFAULT_OUTPUTS == ("q", "v", "p", "h")
    assert {"T", "U", "energy", "positions"} == PARTICLE_OUTPUTS
