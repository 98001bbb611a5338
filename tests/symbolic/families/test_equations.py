"""Equations of families as they are printed with indices, beside the same systems as they are followed."""

from __future__ import annotations

import random
from typing import Any

import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from lagrange_cli.families.values import FamilyValues
from lagrange_cli.limits import Work
from lagrange_cli.run.equations import derive
from lagrange_cli.run.family_equations import (
    DerivedFamilies,
    derive_families,
    families_as_data,
    families_as_written,
)
from lagrange_cli.run.verification import verify_families
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_values
from lagrange_cli.symbolic.families.verify import verify
from lagrange_cli.symbolic.indexed.whole import named, number, operation, reduced
from lagrange_cli.symbolic.source import as_python
from tests.families.test_systems import drawn
from tests.support.motion import SYSTEMS

BODIES = """
name: bodies
sizes: {N: 4}
parameters: {G: 1.0, "m[i in range(N)]": 1 + i/2}
coordinates:
  x[i in range(N)]: {initial: cos(i)}
  y[i in range(N)]: {initial: sin(2*i)}
masses: {"body[i in range(N)]": "m[i]"}
embedding: {"body[i in range(N)]": ["x[i]", "y[i]"]}
potential: -sum(G*m[i]*m[j]/norm(body[i] - body[j]) for i in range(N) for j in range(i))
solve: {stop: 1}
"""
TWO = """
sizes: {{N: {N}, M: {M}}}
parameters: {{c: 1.5, "g[i in range(N), j in range(M)]": "0.3 + 0.1*sin(i + 2*j)"}}
coordinates:
  u[i in range(N), j in range(M)]: {{initial: "0.5*sin(3 + i + j)"}}
  w[j in range(M)]: {{initial: "0.2*cos(2*j)", velocity: 0.1}}
  z: {{initial: 0.3}}
lagrangian: >-
  sum(u_dot[i, j]**2/2 for i in range(N) for j in range(M)) + sum(w_dot[j]**2*(j + 1) for j in range(M))
  + z_dot**2/2 - z*sum(w[j] for j in range(M)) - {pieces}
generalized_forces: {{"u[0, j in range(M)]": "-u_dot[0, j]*j", z: cos(t)}}
"""
PIECES = (
    "sum((u[(i + {a}) % N, (j + {b}) % M] - u[i, j])**2/2 + cos(u[i, (j + {b}) % M])"
    " for i in range(N) for j in range(M) {condition})",
    "sum((u[i, j] - u[i - 1, j])**2*w[j] for i in range(1, N) for j in range(M) {condition})",
    "sum(u[(2*i + j) % N, j]*u[i, (M - 1 - j) % M]*(i - 2*j) for i in range(N) for j in range(M)"
    " {condition})",
    "c*sum(sin(u[i, j] - u[k, l])*g[i, j] for i in range(N) for j in range(M) for k in range(i + 1)"
    " for l in range(M) if i != k or j != l)",
    "sum(w[j]**3*u[i//2, j]/7 for i in range(0, N, 2) for j in range(M))",
    "sum(cos(u[max(i - 1, 0), j] - u[i, abs(j - M//2)]) for i in range(N) for j in range(M) {condition})",
    "sum(where(i == 0, 2.5, where(j < 1 and i > 1, i, 1/3))*u[i, j]**4 for i in range(N) for j in range(M)"
    " {condition})",
)
KINKS = (
    "sum(max(0, u[i, j] - 0.3)**2*(j + 1) for i in range(N) for j in range(M))",
    "sum(where(u[i, j] > w[j] and i > 0, (u[i, j] - w[j])**3, where(i == 0, 0, 0)) for i in range(N)"
    " for j in range(M))",
    "sum(abs(u[(i + {a}) % N, j] - u[i, j])**3 for i in range(N) for j in range(M))",
    "sum(where(not u[i, j]**2 + w[k]**2 >= 0.2, (0.2 - u[i, j]**2 - w[k]**2)**2*g[i, j], 0)"
    " for i in range(N) for j in range(M) for k in range(j))",
    "c*sum(min(z, w[j])**2*sign(z - w[j])*(z - w[j])**3 for j in range(M))",
    "sum(where(t < 1, 2, 3)*u[i, j]**2 for i in range(N) for j in range(M))",
)
RUBBING = '"-c*sign(u_dot[0, j])*j"', '"-u_dot[0, j]*abs(u_dot[0, j])"', '"-max(u_dot[0, j], w_dot[j])*j"'
CONDITIONS = (
    "", "if i != j", "if (i + j) % 2", "if i < N - 1 and j > 0", "if not (i == 1 or j == 0)",
    "if i <= j < i + 2", "if abs(i - j) < 2",
)  # fmt: skip


pytestmark = pytest.mark.usefixtures("however_small")


def printed(text: str, sizes: dict[str, str] | None = None) -> DerivedFamilies:
    """The equations of a system of families."""
    derived = derive_families(read_spec(text, "system.yaml", sizes), small=True)
    assert derived is not None, text
    return derived


def holds(derived: DerivedFamilies) -> None:
    """Read the printed equations back, and compare them with what is integrated."""
    system = derived.system

    def accelerations(t: float, q: Any, v: Any, parameters: Any) -> Any:
        values = FamilyValues(system, t, q, v, parameters)
        return values.of(system.forces) / values.of(system.masses)

    found = verify(system, derived.equations, accelerations, resolve_values(system.spec, {}))
    assert found.difference <= 1e-12, (str(found), system.spec.text)


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize("case", range(60))
def test_what_is_printed_of_families_is_integrated(case: int, pytestconfig: pytest.Config) -> None:
    holds(printed(drawn(random.Random(f"{pytestconfig.option.seed} printed {case}"))))


@pytest.mark.exhaustive(keep=0)
@settings(max_examples=6, deadline=None)
@given(
    st.sampled_from([1, 2, 3, 5]), st.sampled_from([1, 2, 4]),
    st.lists(
        st.tuples(
            st.sampled_from(PIECES), st.integers(-2, 2), st.integers(-2, 2), st.sampled_from(CONDITIONS)
        ),
        min_size=1, max_size=2,
    ),
)  # fmt: skip
def test_two_indices_rings_and_conditions(
    rows: int, columns: int, pieces: list[tuple[str, int, int, str]]
) -> None:
    listed = [piece.format(a=a, b=b, condition=condition) for piece, a, b, condition in pieces]
    holds(printed(TWO.format(N=rows, M=columns, pieces="\n    - ".join(listed))))


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize("case", range(30))
def test_kinks_and_conditions_on_the_state(case: int, pytestconfig: pytest.Config) -> None:
    chance = random.Random(f"{pytestconfig.option.seed} kinks {case}")
    listed = [one.format(a=chance.randint(-2, 2)) for one in chance.sample(KINKS, chance.choice([1, 2, 3]))]
    rows, columns = chance.choice([1, 2, 3, 5]), chance.choice([1, 2, 4])
    text = TWO.format(N=rows, M=columns, pieces="\n    - ".join(listed))
    holds(printed(text.replace('"-u_dot[0, j]*j"', chance.choice(RUBBING))))


SHARES = (
    ("i in range(N) if i % 2 == 0", "i in range(N) if i % 2"),
    ("i in range(N) if i != N//2", "N//2"),
    ("i in range(0, N, 3)", "i in range(N) if i % 3"),
    ("i in range(N - 1, 0, -2)", "i in range(N - 2, 0, -2)", "0"),
    ("i in range(N) if i < 2 or i == N - 1", "i in range(2, N - 1)"),
)


@pytest.mark.exhaustive(keep=0.3)
@pytest.mark.parametrize("count", [2, 3, 4, 9])
@pytest.mark.parametrize("shares", SHARES)
def test_members_in_pieces_between_each_other(shares: tuple[str, ...], count: int) -> None:
    masses = ", ".join(
        f'"b[{one}]": {k} + 1/(1 + {"i" if "in" in one else 0})' for k, one in enumerate(shares)
    )
    places = ", ".join(
        f'"r[{one}]": "{k + 1}*x[{"i" if "in" in one else one}] + x[0]"' for k, one in enumerate(shares)
    )
    text = f"""
sizes: {{N: {count}}}
coordinates: {{"x[i in range(N)]": {{initial: sin(i + 1)}}}}
masses: {{{masses}}}
definitions: {{{places}}}
embedding: {{"b[i in range(N)]": ["x[i]"]}}
potential: sum((r[(i + 1) % N] - r[i])**2 + cos(r[i]*b[i].x) for i in range(N) if i != 2)
"""
    holds(printed(text))


@pytest.mark.exhaustive(keep=0.25)
def test_contacts_of_pairs_as_in_a_textbook() -> None:
    attraction, contact = "-sum(G*m[i]*m[j]/{}", "sum(G*max(0, 1 - {})**2"
    text = BODIES.replace(*(one.format("norm(body[i] - body[j])") for one in (attraction, contact)))
    found = "".join(families_as_written(printed(text), "text", "explicit", {}).split())
    distance = "sqrt((x[i] - x[j])**2 + (y[i] - y[j])**2)"
    force = f"sum((x[i] - x[j])*max(0, 1 - {distance})/{distance} for j in range(N) if j != i)"
    assert f"x_ddot[i] = 2*G*{force}/m[i]".replace(" ", "") in found
    assert str(verify_families(printed(text), {})).count("further away") == 1


@pytest.mark.exhaustive(keep=0.15)
def test_a_ring_with_conditions_and_two_indices() -> None:
    listed = [piece.format(a=1, b=-1, condition=CONDITIONS[2]) for piece in PIECES]
    holds(printed(TWO.format(N=3, M=2, pieces="\n    - ".join(listed))))


def test_bodies_as_in_a_textbook() -> None:
    text = " ".join(families_as_written(printed(BODIES), "text", "lagrange", {}).split())
    assert text.startswith("bodies: 8 degrees of freedom Sizes N = 4 ")
    for formula in (
        "T = sum(m[i]*(x_dot[i]**2 + y_dot[i]**2) for i in range(N))/2",
        "U = -G*sum(m[i]*m[j]/sqrt((x[i] - x[j])**2 + (y[i] - y[j])**2) for i in range(N) for j in range(i))",
        "p_x[i] = m[i]*x_dot[i] [for i in range(N)]",
        "x_ddot[i] + G*sum(m[j]*(x[i] - x[j])/((x[i] - x[j])**2 + (y[i] - y[j])**2)**(3/2)"
        " for j in range(N) if j != i) = 0 [x[i], divided by m[i], for i in range(N)]",
        "x_ddot[i] = -G*sum(m[j]*(x[i] - x[j])/((x[i] - x[j])**2 + (y[i] - y[j])**2)**(3/2)"
        " for j in range(N) if j != i) [for i in range(N)]",
        "P_x = sum(m[i]*x_dot[i] for i in range(N))",
    ):
        assert formula in text, formula


@pytest.mark.exhaustive(keep=0.8)
def test_the_ends_of_a_chain_are_apart() -> None:
    text = (SYSTEMS / "fpu_chain.yaml").read_text()
    lines = families_as_written(printed(text), "text", "explicit", {}).splitlines()
    assert [line.partition(" =")[0].strip() for line in lines if "_ddot" in line] == [
        "u_ddot[0]", "u_ddot[i]", "u_ddot[N - 1]",
    ]  # fmt: skip
    assert "[for i in range(1, N - 1)]" in "\n".join(lines)


def test_a_ring_that_is_held_at_a_bead_names_its_neighbours() -> None:
    """-1 % N is N - 1 wherever N is, and what a condition would exclude is said by the range."""
    text = (
        "{sizes: {N: 400}, parameters: {k: 1}, coordinates: {'u[i in range(N)]': {initial: 0}}, "
        "masses: {'b[i in range(N)]': 2}, embedding: {'b[i in range(N)]': 'u[i]'}, "
        "potential: sum(k*(u[(i + 1) % N] - u[i])**2 for i in range(N)) + u[0]**2*u[-1 % N]}"
    )
    found = families_as_written(printed(text), "text", "lagrange", {})
    assert "u[0]**2*u[N - 1]" in found and "for i in range(1, N - 1)]" in found
    assert "%" not in found.replace("u[(i + 1) % N]", "")


@settings(max_examples=50, deadline=None)
@given(st.integers(-9, 9), st.integers(-4, 4), st.integers(1, 6), st.integers(0, 4), st.integers(0, 3))
def test_remainders_that_are_left_out_are_the_same_numbers(
    a: int, b: int, n: int, length: int, more: int
) -> None:
    spans = {"i": (0, length), "N": (n, n + more)}
    shown = operation("%", named("i") * b + number(a), named("N"))
    for i in range(length + 1):
        for size in range(n, n + more + 1):
            values = {"i": i, "N": size}
            assert reduced(shown, spans).value(values) == (a + b * i) % size


@pytest.mark.exhaustive(keep=0.55)
def test_latex_has_signs_of_sums() -> None:
    text = families_as_written(printed(BODIES), "latex", "lagrange", {})
    assert r"\sum_{\substack{j = 0 \\ j \ne i}}^{N - 1} \frac{m_{j} (x_{i} - x_{j})}" in text
    assert r"\text{(for $i = 0, \dots, N - 1$)}" not in text
    assert r"$i = 0, \dots, N - 1$" in text
    ring = families_as_written(printed((SYSTEMS / "lattice.yaml").read_text()), "latex", "explicit", {})
    assert r"u_{(i + 1) \bmod N,j}" in ring


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("name", ["lattice", "fpu_chain", "solar_system", "pieces"])
def test_python_of_families_and_of_members_give_the_same(name: str) -> None:
    pieces = " - ".join(piece.format(a=1, b=-1, condition=CONDITIONS[-1]) for piece in PIECES)
    file = SYSTEMS / f"{name}.yaml"
    text = TWO.format(N=4, M=3, pieces=pieces) if name == "pieces" else file.read_text()
    sizes = {"lattice": {"N": "3", "M": "4"}, "fpu_chain": {"N": "4"}, "solar_system": {"N": "3"}}.get(
        name, {}
    )
    spec = read_spec(text, "system.yaml", sizes)
    parameters = dict(resolve_values(spec, {}).parameters)
    source = families_as_written(printed(text, sizes), "python", "lagrange", parameters)
    one: dict[str, Any] = {}
    other: dict[str, Any] = {}
    exec(source, one)
    exec(as_python(derive(spec).equations, "lagrange", parameters), other)
    chance = np.random.default_rng(1)
    q, v = chance.normal(size=(2, len(spec.coordinates))).tolist()
    assert one["COORDINATES"] == other["COORDINATES"]
    for function in ("momenta", "accelerations", "energy_function", "lagrangian"):
        assert np.allclose(one[function](0.3, q, v), other[function](0.3, q, v), rtol=1e-12, atol=1e-13)


@pytest.mark.exhaustive(keep=0.7)
def test_sympy_reads_the_data_back() -> None:
    data = families_as_data(printed(BODIES), {})
    bases = {name: sympy.IndexedBase(name) for name in ("x", "y", "x_dot", "y_dot", "m")}
    names = {name: sympy.Symbol(name, integer=True) for name in "ijN"} | {"G": sympy.Symbol("G")}
    rate = sympy.sympify(data["accelerations"]["x[i]"], locals=bases | names)
    found = rate.subs({names["N"]: 3, names["i"]: 1}).doit()
    x, y, m = bases["x"], bases["y"], bases["m"]
    expected = -names["G"] * sum(
        m[j] * (x[1] - x[j]) / ((x[1] - x[j]) ** 2 + (y[1] - y[j]) ** 2) ** sympy.Rational(3, 2)
        for j in (0, 2)
    )
    assert sympy.simplify(found - expected) == 0
    assert data["members"]["x[i]"] == "for i in range(N)"
    assert [one["quantity"] for one in data["conserved"]] == ["h", "P_x", "P_y", "L_z", "K_x", "K_y"]


@pytest.mark.exhaustive(keep=0.4)
def test_what_is_printed_and_the_work_do_not_grow_with_the_size() -> None:
    def counted(count: int) -> tuple[str, int]:
        derived = printed((SYSTEMS / "fpu_chain.yaml").read_text(), {"N": str(count)})
        text = families_as_written(derived, "text", "lagrange", {})
        return text.replace(str(count), "N"), derived.work.spent

    counted(40)  # sympy remembers what it has made
    assert counted(40) == counted(640)


@pytest.mark.exhaustive(keep=0.8)
def test_compiled_and_printed_equations_agree() -> None:
    assert verify_families(printed(BODIES), {}).difference <= 1e-13


@pytest.mark.exhaustive(keep=0.55)
def test_wrong_equations_differ() -> None:
    right, wrong = (
        printed(BODIES),
        printed(BODIES.replace("norm(body[i] - body[j])", "(1 + x[i]**2 + x[j]**2)")),
    )
    mixed = DerivedFamilies(right.system, wrong.equations, Work())
    assert verify_families(mixed, {}).difference > 1e-3


def test_other_systems_are_printed_member_by_member() -> None:
    assert derive_families(read_spec(BODIES + "constraints: {rod: x[0] - 1}\n", "system.yaml")) is None
    scattered = BODIES.replace(
        "potential:", "definitions: {'a[0]': 'x[0]', 'a[1]': '2*x[1]', 'a[2]': 'x[0]'}\npotential:"
    )
    assert derive_families(read_spec(scattered, "system.yaml")) is not None


@pytest.mark.exhaustive(keep=0.65)
def test_driven_and_damped_families_say_how_h_changes() -> None:
    text = BODIES + 'generalized_forces: {"x[i in range(N)]": "sin(t) - G*x_dot[i]"}\n'
    derived = printed(text)
    holds(derived)
    (changing,) = derived.equations.changing
    assert changing.quantity == "h" and "do work" in changing.because


def test_a_power_whose_exponent_is_an_index_has_no_pole() -> None:
    text = """
sizes: {N: 4}
coordinates: {"u[i in range(N)]": {initial: 0.1}}
lagrangian: sum(u_dot[i]**2/2 for i in range(N)) - sum(u[i]**(2 + 2*(i % 2)) for i in range(N))
"""
    derived = printed(text)
    holds(derived)
    lines = families_as_written(derived, "text", "explicit", {}).splitlines()
    assert lines[-1].strip() == "u_ddot[i] = -2*(1 + (i % 2))*u[i]**(1 + 2*(i % 2))   [for i in range(N)]"


TRAP = """
sizes: {N: 60}
parameters: {m: 1, b: 5, K: 1}
coordinates: {"x[i in range(N)]": {initial: "cos(i)*i"}, "y[i in range(N)]": {initial: "sin(i)*i + 1"}}
masses: {"ion[i in range(N)]": m}
positions: {"ion[i in range(N)]": ["x[i]", "y[i]"]}
potential: >-
  sum(K/norm(ion[i] - ion[j]) for i in range(N) for j in range(i))
  - sum(b*(x[i]*y_dot[i] - y[i]*x_dot[i])/2 for i in range(N))
"""


@pytest.mark.exhaustive(keep=0.7)
def test_the_angular_momentum_in_a_magnetic_field_is_one_sum() -> None:
    line = "L_z = sum(-m*y[i]*x_dot[i] + m*x[i]*y_dot[i] + b*x[i]**2/2 + b*y[i]**2/2 for i in range(N))"
    assert f"  {line}\n" in families_as_written(printed(TRAP), "text", "lagrange", {})
