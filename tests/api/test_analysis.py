"""Equations, classifications and comparisons in Python."""

import json

import pytest
import sympy

import lagrange_cli as lagrange
from lagrange_cli.cli.main import main
from tests.support.command import SYSTEMS

PENDULUM = SYSTEMS / "pendulum.yaml"


@pytest.fixture(scope="module")
def pendulum():
    return lagrange.equations(PENDULUM)


def test_equations_are_expressions_of_sympy(pendulum):
    theta, v, a = sympy.symbols("theta theta_dot theta_ddot")
    m, g, l = sympy.symbols("m g l")  # noqa: E741
    assert sympy.simplify(pendulum.L - (m * l**2 * v**2 / 2 + m * g * l * sympy.cos(theta))) == 0
    assert pendulum.momenta["theta"] == pendulum.L.diff(v)
    equation = pendulum.equations["theta"]
    assert sympy.solve(equation, a) == [pendulum.accelerations["theta"]] == [-g * sympy.sin(theta) / l]
    assert pendulum.mass_matrix.shape == (1, 1) and {*pendulum.conserved} == {"h"}
    assert pendulum.q["theta"] == theta and pendulum.parameters["g"] == 9.81 and pendulum.constraints == {}
    with pytest.raises(lagrange.UsageError, match="unknown form 'newton'"):
        pendulum.write(form="newton")


def test_a_notebook_shows_formulas(pendulum):
    shown = pendulum._repr_latex_()
    assert shown.startswith("$$") and shown.endswith("$$") and r"\ddot{\theta}" in shown
    assert shown.count(r"\begin") == shown.count(r"\end") and "&" in shown


def test_what_is_printed_is_what_the_command_prints(pendulum, capsys):
    for format in ("text", "latex", "python", "json"):
        assert main(["equations", str(PENDULUM), "--format", format]) == 0
        assert capsys.readouterr().out == pendulum.write(format) + "\n"
    found = lagrange.check(PENDULUM)
    assert main(["check", str(PENDULUM)]) == 0
    assert capsys.readouterr().out == f"{found}\n"
    assert main(["check", str(PENDULUM), "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == json.loads(json.dumps(found.as_data()))


def test_a_system_is_classified():
    found = lagrange.check(SYSTEMS / "spherical_pendulum.yaml")
    assert (found.degrees_of_freedom, found.coordinates, found.cyclic) == (2, ("theta", "phi"), ("phi",))
    assert found.scleronomic and "p_phi" in found.conserved and "spherical" in repr(found)
    with pytest.raises(lagrange.SpecError) as caught:
        lagrange.check({"coordinates": ["x"], "masses": {"a": "m"}, "embedding": {"a": ["y"]}})
    assert len(caught.value.problems) > 1
    lengths = {"x": {"initial": 1, "unit": "m"}}
    wrong = {"coordinates": lengths, "masses": {"a": 1}, "embedding": {"a": ["sin(x)"]}}
    with pytest.warns(lagrange.LagrangeWarning, match="warning: "):
        lagrange.check(wrong)


def test_methods_are_compared():
    found = lagrange.bench(PENDULUM, stop=1, methods="taylor", tolerances=[1e-6, 1e-9], runs=1, error=1e-3)
    assert [one.status for one in found.results] == ["complete", "complete"]
    assert (
        found.recommended in found.results and "taylor" in str(found) and "bench of pendulum" in repr(found)
    )
    with pytest.raises(lagrange.UsageError, match="error must be from"):
        lagrange.bench(PENDULUM, error=1)
    with pytest.raises(lagrange.UsageError, match="unknown method 'euler'"):
        lagrange.bench(PENDULUM, methods=["euler"])
