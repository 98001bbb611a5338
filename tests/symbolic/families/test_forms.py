"""Hamilton's form and M a = f with indices, beside those of the same systems written out."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np
import pytest
import sympy

from lagrange_cli.errors import TooLargeSystem, UsageError
from lagrange_cli.families import system as systems
from lagrange_cli.limits import Work
from lagrange_cli.run.equations import Derived, derive
from lagrange_cli.run.family_equations import (
    DerivedFamilies,
    derive_families,
    derive_printed,
    families_as_data,
    families_as_written,
    in_form,
    written,
)
from lagrange_cli.run.verification import verify_families
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_values
from lagrange_cli.symbolic.direct import directly
from lagrange_cli.symbolic.families.lines import Line
from lagrange_cli.symbolic.families.readback import ReadBack
from lagrange_cli.symbolic.source import as_python
from tests.support.motion import SYSTEMS
from tests.symbolic.families.test_equations import BODIES
from tests.symbolic.families.test_particles import SYSTEM

DAMPED = """
sizes: {N: 4}
parameters: {c: 0.7, "m[i in range(N)]": "1 + i/3"}
coordinates: {"u[i in range(N)]": {initial: "sin(i)", velocity: "cos(i)"}}
lagrangian: >-
  sum(m[i]*u_dot[i]**2/2 - cos(u[i])*t for i in range(N)) - sum(u[i]*u[i - 1]**2 for i in range(1, N))
dissipation: sum(c*(u_dot[i] - u_dot[i - 1])**2/2 for i in range(1, N))
"""
GIVEN = SYSTEM.format(
    count=4,
    potential="sum(near[i]**4 for i in range(N)) + mean**3/5",
    forces='forces: {"p[i in range(N)]": ["-p[i].vx", "t*w[i]"]}',
    place='"p[0]": ["u[0]", "w[0]"], "p[i in range(1, N)]": ["3*u[i]", "w[i] - m[i]"]',
    mass="m[i]*(1 + i)",
)
CHARGED = SYSTEM.format(
    count=4,
    potential="sum(u[i]**2/2 - (1 + i)*w[i]*u_dot[i] + sin(u[i])*w_dot[i]*t for i in range(N))",
    forces="",
    place='"p[i in range(N)]": ["3*u[i]", "w[i] - m[i]"]',
    mass="m[i]*(1 + i)",
)
RUBBED = """
sizes: {N: 3}
parameters: {m: 2, k: 3}
coordinates: {"x[i in range(N)]": {initial: 0}}
masses: {"b[i in range(N)]": m}
positions: {"b[i in range(N)]": "(x[i], 0)"}
potential: sum(k*abs(x[i])**3 + k*max(0, x[i], min(1, 2*x[i]))**2 for i in range(N))
generalized_forces:
  x[i in range(N)]: -sign(x_dot[i]) + where(x[i] > 0 and t < 1, atan2(x[i], pi), -tanh(x[i]))
"""
"""Functions with kinks and jumps, not all of which Python knows."""
TEXTS = {
    "charged": CHARGED,
    "bodies": BODIES,
    "damped": DAMPED,
    "given": GIVEN,
    "fpu_chain": (SYSTEMS / "fpu_chain.yaml").read_text(),
    "lattice": (SYSTEMS / "lattice.yaml").read_text(),
}


@pytest.fixture(autouse=True)
def however_small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Small systems are families, too."""
    monkeypatch.setattr(systems, "FEWEST", 0)


FEWEST = {"given": 2, "lattice": 2, "fpu_chain": 2}
"""The fewest members of these files, if it is not one."""


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize(
    ("name", "count"),
    [(name, count) for name in TEXTS for count in (1, 2, 3, 8, 9) if count >= FEWEST.get(name, 1)],
)
def test_the_forms_are_those_of_the_members(name: str, count: int) -> None:
    spec = read_spec(
        TEXTS[name], "system.yaml", {"N": str(count)} | ({"M": "2"} if name == "lattice" else {})
    )
    parameters = dict(resolve_values(spec, {}).parameters)
    families, members = derive_families(spec), derive(spec)
    assert families is not None
    one: dict[str, Any] = {}
    other: dict[str, Any] = {}
    exec(written(in_form(families, "hamilton"), "python", "hamilton", parameters), one)
    exec(as_python(members.equations, "hamilton", parameters), other)
    matrix: dict[str, Any] = {}
    exec(written(in_form(families, "matrix"), "python", "matrix", parameters), matrix)
    chance = np.random.default_rng(count)
    q, p = chance.normal(size=(2, len(spec.coordinates))).tolist()
    for function in ("hamiltonian", "velocities", "momentum_rates"):
        assert np.allclose(one[function](0.3, q, p), other[function](0.3, q, p), rtol=1e-12, atol=1e-13)
    found = np.diag(matrix["masses"](0.3, q, p))
    assert np.allclose(found, other["mass_matrix"](0.3, q, p), rtol=1e-14, atol=0)
    assert np.allclose(matrix["force"](0.3, q, p), other["force"](0.3, q, p), rtol=1e-12, atol=1e-13)


def test_functions_that_python_does_not_know() -> None:
    spec = read_spec(RUBBED, "system.yaml")
    parameters = dict(resolve_values(spec, {}).parameters)
    families = derive_families(spec, small=True)
    assert families is not None
    one: dict[str, Any] = {}
    other: dict[str, Any] = {}
    exec(written(families, "python", "lagrange", parameters), one)
    exec(as_python(derive(spec).equations, "lagrange", parameters), other)
    for q, v in np.random.default_rng(3).normal(size=(5, 2, 3)).tolist():
        for function in ("lagrangian", "generalized_forces", "accelerations"):
            assert np.allclose(one[function](0.3, q, v), other[function](0.3, q, v), rtol=1e-12, atol=1e-13)


def test_hamilton_as_in_a_textbook() -> None:
    derived = derive_printed(read_spec(BODIES, "system.yaml"), "hamilton")
    assert isinstance(derived, DerivedFamilies)
    text = " ".join(families_as_written(derived, "text", "hamilton", {}).split())
    for formula in (
        "H = sum(p_x[i]**2/m[i] + p_y[i]**2/m[i] for i in range(N))/2"
        " - G*sum(m[i]*m[j]/sqrt((x[i] - x[j])**2 + (y[i] - y[j])**2) for i in range(N) for j in range(i))",
        "x_dot[i] = p_x[i]/m[i] [for i in range(N)]",
        "p_x_dot[i] = -G*m[i]*sum(m[j]*(x[i] - x[j])/((x[i] - x[j])**2 + (y[i] - y[j])**2)**(3/2)"
        " for j in range(N) if j != i) [for i in range(N)]",
        "p_x[i] = m[i]*x_dot[i] [for i in range(N)]",
    ):
        assert formula in text, formula
    matrix = " ".join(families_as_written(derived, "text", "matrix", {}).split())
    assert "M a = f" in matrix and "M_x[i] = m[i] [for i in range(N)]" in matrix
    latex = families_as_written(derived, "latex", "hamilton", {})
    assert r"\dot{x}_{i}" in latex and r"H" in latex


def test_sympy_reads_the_canonical_equations_back() -> None:
    derived = derive_printed(read_spec(DAMPED, "system.yaml"), "hamilton")
    assert isinstance(derived, DerivedFamilies)
    data = families_as_data(derived, {}, "hamilton")
    bases = {name: sympy.IndexedBase(name) for name in ("u", "m", "p_u")}
    names = {name: sympy.Symbol(name, integer=True) for name in "ijN"}
    rate = sympy.sympify(data["canonical_equations"]["momentum_rates"]["u[0]"], locals=bases | names)
    u, m, p = bases["u"], bases["m"], bases["p_u"]
    c, t = sympy.symbols("c t")
    expected = t * sympy.sin(u[0]) - 2 * u[1] * u[0] - c * (p[0] / m[0] - p[1] / m[1])
    assert sympy.simplify(rate - expected) == 0
    assert data["canonical_equations"]["velocities"] == {"u[i]": "p_u[i]/m[i]"}
    assert data["masses"] == {"u[i]": "m[i]"}


@pytest.mark.exhaustive(keep=0.35)
def test_what_has_no_such_form_is_written_out() -> None:
    spec = read_spec((SYSTEMS / "n_pendulum.yaml").read_text(), "system.yaml", {"N": "2"})
    assert isinstance(derive_printed(spec, "hamilton"), Derived)
    spec = read_spec(BODIES, "system.yaml")
    assert isinstance(derive_printed(spec, "hamilton"), DerivedFamilies)
    assert isinstance(derive_printed(spec, "vakonomic"), Derived)


def test_a_name_of_the_file_is_not_taken_for_a_momentum() -> None:
    spec = read_spec(BODIES.replace("G", "p_x"), "system.yaml")
    with pytest.raises(UsageError, match="p_x is the name of a momentum"):
        derive_printed(spec, "hamilton")


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("form", ["lagrange", "explicit", "hamilton", "matrix"])
def test_what_is_too_long_written_out_has_indices(form: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(systems, "FEWEST", 10**9)
    spec = read_spec(TEXTS["fpu_chain"], "system.yaml", {"N": "9"})
    monkeypatch.setenv("LAGRANGE_LIMITS", "work=250000")
    assert isinstance(derive_printed(spec, form), DerivedFamilies)
    with pytest.raises(TooLargeSystem, match="steps of work"):
        derive_printed(spec, form, indexed=False)
    with pytest.raises(TooLargeSystem, match="--form vakonomic writes out every member"):
        derive_printed(spec, "vakonomic")


def test_what_is_certain_to_take_too_much_work_is_not_begun(monkeypatch: pytest.MonkeyPatch) -> None:
    text = (SYSTEMS / "chain.yaml").read_text()
    text += "events: {e: {when: 'x[0]', action: {set: {'x_dot[0]': 0}}}}\n"
    spec = read_spec(text, "system.yaml", {"N": "400"})
    begun: list[object] = []
    monkeypatch.setattr("lagrange_cli.model.build.build_model", begun.append)
    with pytest.raises(TooLargeSystem, match="events that set something every member is written out"):
        derive_printed(spec, "lagrange")
    assert not begun


ROPES = {
    "chain": (SYSTEMS / "chain.yaml").read_text(),
    "net": """
sizes: {N: 3, M: 2}
parameters: {k: 0.5, "l[i in range(N)]": 1 + i/10}
coordinates:
  u[i in range(N), j in range(M)]: {initial: i + j/3}
  w: {initial: 0.1}
masses: {"p[i in range(N), j in range(M)]": 1 + j, cart: 2}
embedding: {"p[i in range(N), j in range(M)]": "u[i, j]", cart: w}
potential: sum(k*(u[i, j] - w)**2 for i in range(N) for j in range(M))
forces: {"p[i in range(N), j in range(M)]": "-u_dot[i, j]"}
constraints:
  rod[i in range(N)]: sum(u[i, j]**2 for j in range(M)) - l[i]**2
  bar: sum(u[i, 0]*u[(i + 1) % N, M - 1] for i in range(N)) - w**2*l[0]
""",
}


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("count", [2, 3, 8, 9])
@pytest.mark.parametrize("name", ROPES)
def test_constraints_with_indices_are_those_of_the_file(name: str, count: int) -> None:
    spec = read_spec(ROPES[name], "system.yaml", {"N": str(count)})
    derived = derive_families(spec, small=True)
    assert derived is not None and derived.equations.constraints
    found = verify_families(derived, {})
    assert found.difference <= 1e-12
    data = families_as_data(derived, {})
    assert data["accelerations"] is None and data["constraint_force"]
    assert {"lambda_rod[i]", "lambda_rod[1]"} & {one["multiplier"] for one in data["constraints"]}
    for format_, form in product(("text", "unicode", "latex"), ("lagrange", "hamilton", "matrix")):
        assert written(in_form(derived, form), format_, form, {})
    assert_forces(derived)
    assert_module(derived)
    old, new = ("w**2*l[0]", "2*w**2*l[0]") if name == "net" else ("- y[i - 1]", "- 2*y[i - 1]")
    other = derive_families(
        read_spec(ROPES[name].replace(old, new), "system.yaml", {"N": str(count)}), small=True
    )
    assert other is not None
    wrong = DerivedFamilies(derived.system, other.equations, Work(), spec)
    assert verify_families(wrong, {}).difference > 1e-6


def assert_module(derived: DerivedFamilies) -> None:
    """Accelerations and multipliers of the module solve the equations of the file and its constraints."""
    spec, module = derived.spec, dict[str, Any]()
    parameters = dict(resolve_values(spec).parameters)
    exec(families_as_written(derived, "python", "lagrange", parameters), module)
    q, v = np.random.default_rng(1).uniform(-1, 1, (2, len(spec.coordinates))).tolist()
    a, forces = (module[name](0.3, q, v) for name in ("accelerations", "multipliers"))
    direct = directly(spec, parameters, 0.3, q, v, [*a], multipliers=[*forces])
    assert module["CONSTRAINTS"] == tuple(spec.all_constraints)
    assert module["constraints"](0.3, q, v) == pytest.approx(direct.constraints, rel=1e-12, abs=1e-12)
    scale = max(map(abs, (*a, *forces)))
    assert np.max(np.abs([*direct.residual, *direct.rates])) < 1e-12 * (1 + scale)


def assert_forces(derived: DerivedFamilies) -> None:
    """M a - f - A^T lambda is what the equations of motion say, and A a - b the second derivative of the
    constraints."""
    found, chance = derived.equations, np.random.default_rng(0)
    read = ReadBack(derived.system, found)
    q, v, a = chance.uniform(-1, 1, (3, read.count))
    parameters = np.array([*resolve_values(derived.spec).parameters.values()])

    def values(lines: Sequence[Line]) -> Any:
        return read.values(lines, (0.4, q, v, a, parameters), 10**6)[0]

    motion = values([line.of(one.factor * (one.left - one.right)) for line, one in found.equations])
    force, pull = values(found.rates or ()), values(found.pulls)
    assert np.allclose(values(found.diagonal or ()) * a - force - pull, motion, rtol=1e-12, atol=1e-12)
    for line, second in zip(found.constraints, found.allowed, strict=True):
        read.first[line.family.name] = 0
        places, indices = read.members(line)

        def at(s: float, line: Line = line, indices: Any = indices, count: int = len(places)) -> Any:
            moved = 0.4 + s, q + v * s + a * s**2 / 2, v + a * s, a, parameters
            return read.value(line.expression, indices, count, moved)[0]

        expected = (at(1e-3) - 2 * at(0.0) + at(-1e-3)) / 1e-6
        here, _ = read.value(second.expression, indices, len(places), (0.4, q, v, a, parameters))
        assert np.allclose(here, expected, rtol=1e-5, atol=1e-5)


@pytest.mark.exhaustive(keep=0.3)
def test_a_long_chain_of_rods_has_two_constraints() -> None:
    spec = read_spec(ROPES["chain"], "system.yaml", {"N": "1000"})
    derived = derive_printed(spec, "lagrange")
    assert isinstance(derived, DerivedFamilies)
    text = " ".join(families_as_written(derived, "text", "lagrange", {}).split())
    for formula in (
        "chain: 1000 degrees of freedom",
        "x[0]**2 + y[0]**2 - l**2 = 0 [rod[0]]",
        "(x[i] - x[i - 1])**2 + (y[i] - y[i - 1])**2 - l**2 = 0 [rod[i], for i in range(1, N)]",
        "m*x_ddot[i] = -2*lambda_rod[i + 1]*(x[i + 1] - x[i]) - 2*lambda_rod[i]*(x[i - 1] - x[i])",
        "h: L does not contain t explicitly, and the forces of constraint do no work",
    ):
        assert formula in text, formula
    with pytest.raises(UsageError, match="at most 60 coordinates"):
        verify_families(derived, {})
    matrix = derive_printed(spec, "matrix")
    assert isinstance(matrix, DerivedFamilies)
    text = families_as_written(matrix, "text", "matrix", {})
    assert "r_x[N - 1] = 2*lambda_rod[N - 1]*(x[N - 1] - x[N - 2])" in text and text.count("\n") < 50
    explicit = derive_printed(spec, "explicit")
    text = written(explicit, "text", "explicit", {})
    assert "second derivatives of the constraints together\n" in text and "A a = b" in text
