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


@pytest.mark.exhaustive(keep=0.8)
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


@pytest.mark.exhaustive(keep=0.2)
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


CHAIN = SYSTEMS / "fpu_chain.yaml"


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("count", [4, 8, 9])
def test_equations_with_indices_are_those_of_the_members(count):
    whole = lagrange.equations(CHAIN, size={"N": count}, indexed=True)
    apart = lagrange.equations(CHAIN, size={"N": count}, indexed=False)
    u, N, i = sympy.IndexedBase("u"), sympy.Symbol("N", integer=True), sympy.Symbol("i", integer=True)
    assert isinstance(whole.h.atoms(sympy.Sum).pop(), sympy.Sum) and u[i] in whole.force["u[i]"].free_symbols

    def members(expression, **values):
        found = expression.subs({N: count, **{sympy.Symbol(k, integer=True): x for k, x in values.items()}})
        return found.doit().replace(
            lambda one: isinstance(one, sympy.Indexed),
            lambda one: sympy.Symbol(f"{one.base.label}[{','.join(map(str, one.indices))}]"),
        )

    for one, other in ((whole.L, apart.L), (whole.T, apart.T), (whole.U, apart.U), (whole.h, apart.h)):
        assert sympy.expand(members(one) - other) == 0
    rates = {"u[0]": ("u[0]", {}), f"u[{count - 1}]": ("u[N - 1]", {})}
    rates |= {f"u[{k}]": ("u[i]", {"i": k}) for k in range(1, count - 1)}
    for name, (line, values) in rates.items():
        assert sympy.expand(members(whole.accelerations[line], **values) - apart.accelerations[name]) == 0
        equation, expected = (one.equations[key] for one, key in ((whole, line), (apart, name)))
        assert sympy.expand(members(equation.lhs - equation.rhs, **values) - expected.lhs + expected.rhs) == 0
    assert whole.masses == {"u[i]": sympy.Symbol("m")} and whole.members["equations"]["u[0]"] == ""
    assert whole.members["masses"] == {"u[i]": "for i in range(N)"}
    assert {*whole.conserved} == {*apart.conserved} == {"h"} and whole.sizes["N"] == count
    shown = whole._repr_latex_()
    assert shown.startswith("$$") and r"\ddot{u}_{i}" in shown


@pytest.mark.exhaustive(keep=0.2)
def test_large_families_have_indices_as_the_command_prints_them(capsys):
    found = lagrange.equations(CHAIN, size={"N": 200})
    for form in ("lagrange", "hamilton"):
        assert main(["equations", str(CHAIN), "--size", "N=200", "--form", form]) == 0
        assert capsys.readouterr().out == found.write(form=form) + "\n"
    assert found.as_data("hamilton")["canonical_equations"]["velocities"] == {"u[i]": "p_u[i]/m"}
    pendulum = lagrange.equations(SYSTEMS / "n_pendulum.yaml", size={"N": 30})
    assert pendulum.accelerations is None and pendulum.masses is None
    assert [*pendulum.momenta] == ["theta[i]"] and pendulum.momenta["theta[i]"].has(sympy.Sum)
    rods = lagrange.equations(SYSTEMS / "chain.yaml", indexed=True)
    assert [*rods.constraints] == ["rod[0]", "rod[i]"] and [*rods.masses] == ["x[i]", "y[i]"]
    with pytest.raises(lagrange.UsageError, match="no equations with indices: no coordinate has an index"):
        lagrange.equations(SYSTEMS / "bouncing_ball.yaml", indexed=True)
