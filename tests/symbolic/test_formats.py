"""Every format of every system: read back, imported, or looked at once."""

import math

import pytest
import sympy

import lagrange_cli as lagrange
from lagrange_cli.errors import UsageError
from lagrange_cli.expression.build import build
from lagrange_cli.expression.parse import parse
from lagrange_cli.expression.symbolic import SympyAlgebra
from lagrange_cli.run.equations import FORMS
from lagrange_cli.spec.values import resolve_values
from lagrange_cli.symbolic.data import as_data
from lagrange_cli.symbolic.layouts import WIDTH, as_text, as_unicode
from lagrange_cli.symbolic.source import as_python
from tests.support.systems import (
    NAMES,
    agree_at_random,
    derived,
    equations_of,
    equations_with,
    expression,
    has_form,
    renamed,
    spec_of,
)


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize("name", NAMES)
def test_data_is_read_back_by_sympy_and_by_the_file_grammar(name):
    equations = equations_of(name)
    data = as_data(equations, "hamilton", {})
    pairs = [
        (data["L"], equations.L),
        (data["h"], equations.h),
        *zip(data["momenta"].values(), equations.momenta, strict=True),
        *zip(data["accelerations"].values(), equations.accelerations, strict=True),
        *zip(data["equations"].values(), (e.left - e.right for e in equations.equations), strict=True),
        *(
            (c["expression"], own.expression)
            for c, own in zip(data["conserved"], equations.conserved, strict=True)
        ),
    ]
    for text, value in pairs:
        own = renamed(equations, value)
        assert agree_at_random(expression(text), own, digits=14)
        written = text.replace("Max(", "max(").replace("Min(", "min(")  # as files have them
        built = build(parse(written), sympy.Symbol, SympyAlgebra())
        assert agree_at_random(built, own)


@pytest.mark.exhaustive(keep=3)
@pytest.mark.parametrize("name", NAMES)
def test_data_has_the_keys_of_the_contract(name):
    data = as_data(equations_of(name), "lagrange", {"g": 9.81})
    keys = {"name", "coordinates", "parameters", "T", "U", "L", "momenta", "equations", "accelerations", "h"}
    assert keys | {"conserved"} <= set(data)
    assert data["parameters"] == {"g": 9.81}
    assert list(data["equations"]) == data["coordinates"]
    assert (data["T"] is None) == (name in ("gauge_oscillator", "kicked_rotor", "lattice"))
    for each in data["conserved"]:
        assert set(each) - {"broken_by"} == {"quantity", "expression", "because"}


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("form", ["lagrange", "hamilton"])
@pytest.mark.parametrize("name", NAMES)
def test_the_python_module_runs_and_agrees(name, form):
    equations = equations_of(name)
    values = resolve_values(spec_of(name))
    module: dict = {}
    exec(as_python(equations, form, values.parameters), module)
    q = [x + 0.1 * (k + 1) for k, x in enumerate(values.q)]
    v = [x + 0.2 for x in values.v]
    t = 0.3
    known = dict(zip(equations.q, q, strict=True)) | dict(zip(equations.v, v, strict=True))
    known |= {symbol: values.parameters[key] for key, symbol in equations.parameters.items()}
    known[equations.time] = t

    def close(found, expected):
        assert found == pytest.approx([float(e.subs(known)) for e in expected], rel=1e-12, abs=1e-13)

    assert module["COORDINATES"] == equations.coordinates
    close([module["lagrangian"](t, q, v), module["energy_function"](t, q, v)], [equations.L, equations.h])
    close(module["momenta"](t, q, v), equations.momenta)
    close(module["accelerations"](t, q, v), equations.accelerations)
    close(
        [x for row in module["mass_matrix"](t, q, v) for x in row],
        [x for row in equations.mass_matrix for x in row],
    )
    if form == "hamilton":
        p = module["momenta"](t, q, v)
        assert module["velocities"](t, q, p) == pytest.approx(v, rel=1e-12, abs=1e-13)
        if name != "gauge_oscillator":
            assert module["hamiltonian"](t, q, p) == pytest.approx(float(equations.h.subs(known)), rel=1e-12)


CONSTANTS = [
    "pi*x",
    "(2 + x)**pi",
    "pi**x",
    "acos(-1)*x",
    "exp(1)*x",
    "(pi + x)**(pi - 1)",
    "log(2)*x",
    "x**sqrt(2)",
]


@pytest.mark.parametrize("potential", CONSTANTS)
def test_constants_are_read_back(potential):
    system = "coordinates: {x: {initial: 1}}\nmasses: {a: 1}\nembedding: {a: [x]}\n"
    equations = derived(f"{system}potential: {potential}\n")
    assert agree_at_random(expression(as_data(equations, "hamilton", {})["U"]), equations.U, digits=14)
    module: dict = {}
    exec(as_python(equations, "lagrange", {}), module)
    expected = equations.accelerations[0].subs({equations.q[0]: 0.7})
    assert module["accelerations"](0, [0.7], [0]) == pytest.approx([float(expected)], rel=1e-13)


FOUR = """
    parameters: {g: 9.81}
    coordinates: {q: {initial: 1}, v: {initial: 1}, b: {initial: 1}, c: {initial: 1}}
    masses: {one: 1, two: 2, three: 3, four: 4}
    embedding:
      one: [sin(q), -cos(q)]
      two: [sin(q) + sin(v), -cos(q) - cos(v)]
      three: [sin(q) + sin(v) + sin(b), -cos(q) - cos(v) - cos(b)]
      four: [sin(q) + sin(v) + sin(b) + sin(c), -cos(q) - cos(v) - cos(b) - cos(c)]
    potential: g*(one.y + 2*two.y + 3*three.y + 4*four.y)
"""


def test_python_eliminates_where_the_solution_is_too_long():
    equations = derived(FOUR)
    assert equations.accelerations is None
    module: dict = {}
    exec(as_python(equations, "lagrange", {"g": 9.81}), module)
    state = 0.0, [0.3, 0.5, 0.9, 1.4], [0.1, 0.2, 0.3, 0.4]
    a = module["accelerations"](*state)
    for row, force in zip(module["mass_matrix"](*state), module["force"](*state), strict=True):
        assert math.fsum(m * x for m, x in zip(row, a, strict=True)) == pytest.approx(force, rel=1e-12)


def test_text_says_where_the_accelerations_are():
    assert "--form matrix" in as_text(derived(FOUR), "lagrange")


def test_text_of_the_pendulum():
    assert as_text(equations_of("pendulum"), "lagrange") == (
        """\
pendulum: 1 degree of freedom

Lagrangian
  T = m*l**2*theta_dot**2/2
  U = -m*g*l*cos(theta)
  L = m*l**2*theta_dot**2/2 + m*g*l*cos(theta)

Momenta
  p_theta = m*l**2*theta_dot

Equations of motion
  l*theta_ddot + g*sin(theta) = 0   [theta, divided by m*l]

Accelerations
  theta_ddot = -g*sin(theta)/l

Energy function
  h = m*l**2*theta_dot**2/2 - m*g*l*cos(theta)

Conserved
  h: L does not contain t explicitly; h = T + U (no t in the embedding, no velocities in U)"""
    )


def test_unicode_of_the_pendulum():
    text = as_unicode(equations_of("pendulum"), "hamilton")
    assert "  H = p_θ²/(2 m l²) − m g l cos(θ)" in text
    assert "  θ̇ = p_θ/(m l²)" in text


def test_matrix_form():
    text = as_text(equations_of("double_pendulum"), "matrix")
    assert (
        "  M = [[(m1 + m2)*l1**2, m2*l1*l2*cos(theta1 - theta2)],\n"
        "       [m2*l1*l2*cos(theta1 - theta2), m2*l2**2]]"
    ) in text


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("name", NAMES)
def test_every_form_is_shown(name, form):
    equations = equations_with(name, form)
    if not has_form(equations, form):
        with pytest.raises(UsageError):
            as_text(equations, form)
        return
    plain = as_text(equations, form)
    assert plain.isascii()
    assert plain.startswith(equations.name)
    assert all(ord("\\") not in map(ord, line) for line in plain.splitlines())
    assert as_unicode(equations, form).count("(") == as_unicode(equations, form).count(")")


def test_long_sums_are_broken_between_their_terms():
    text = as_text(equations_of("double_pendulum"), "lagrange")
    assert max(map(len, text.splitlines())) <= WIDTH
    joined = " ".join(text.split())
    assert "theta2_dot**2/2 + m2*l1*l2*cos(theta1 - theta2)*theta1_dot*theta2_dot" in joined


@pytest.mark.parametrize("form", ["lagrange", "matrix"])
def test_no_line_is_wider_than_the_page(form):
    """Rows of matrices, words, and roots within roots are broken, and nothing is lost."""
    text = (
        "coordinates: {a: {initial: 0.1}, b: {initial: 0.2}, c: {initial: 0.3}}\n"
        "lagrangian: >\n"
        "  (a_dot**2*sqrt(a + sin(b)*sqrt(c + 2*a*cos(b)*sqrt(b + cos(a + c)**2) + sin(a)**2) + b**2)\n"
        "  + a_dot*b_dot*cos(a)*cos(b) + a_dot*c_dot*(a + cos(b)) + b_dot**2*(1 + cos(c)**2) + c_dot**2)/2\n"
    )
    equations = lagrange.equations(text)
    page = equations.write("text", form)
    assert max(map(len, page.splitlines())) <= WIDTH
    if form == "matrix":
        shown = page.partition("f = [")[2].replace("\n", "").replace(" ", "")
        data = ",".join(equations.as_data("matrix")["force"]).replace(" ", "")
        assert shown == data + "]"
