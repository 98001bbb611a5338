"""Equations of chains and trees as they are printed with indices, beside the file itself differentiated."""

from __future__ import annotations

import random
from fractions import Fraction
from math import prod
from typing import Any

import numpy as np
import pytest
import sympy
from hypothesis import example, given
from hypothesis import strategies as st

from lagrange_cli.errors import UsageError
from lagrange_cli.expression.symbolic_switches import Extremum, Largest
from lagrange_cli.families import system as systems
from lagrange_cli.integrate.family_program import compiled_accelerations
from lagrange_cli.limits import Work
from lagrange_cli.run.family_equations import (
    DerivedFamilies,
    derive_families,
    derive_printed,
    families_as_data,
    families_as_written,
)
from lagrange_cli.run.verification import verify_families
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.spec import Spec
from lagrange_cli.spec.values import resolve_values
from lagrange_cli.symbolic.direct import directly
from lagrange_cli.symbolic.families.derive import equations_of
from lagrange_cli.symbolic.families.readback import ReadBack
from lagrange_cli.symbolic.families.sums import exchanged, telescoped
from lagrange_cli.symbolic.families.verify import verify
from lagrange_cli.symbolic.indexed.conditions import Loop, relation
from lagrange_cli.symbolic.indexed.conditions import holds as condition_holds
from lagrange_cli.symbolic.indexed.members import KNOWN, Loops, Summed, member
from lagrange_cli.symbolic.indexed.whole import Whole, named, number
from lagrange_cli.symbolic.work import size_of
from tests.families.test_chains import SPACE, drawn, pendulum
from tests.families.test_closed_chains import CASES, chain
from tests.families.test_nonholonomic import drawn_on_trees
from tests.support.draws import examples
from tests.support.motion import SYSTEMS

N_PENDULUM = (SYSTEMS / "n_pendulum.yaml").read_text()
SIZES = 1, 2, 3, 8, 9
RODS = """
sizes: {{N: {count}}}
parameters: {{g: 9.81, k: 2.0, "m[i in range(N)]": 1 + i/3, "l[i in range(N)]": 1 + i/5}}
coordinates:
  th[i in range(N)]: {{initial: "0.5 + 0.3*sin(i)", velocity: 0.1*i}}
definitions: {{{definitions}}}
masses: {{"bob[i in range(N)]": "m[i]"}}
embedding: {{"bob[i in range(N)]": ["x[i]", "y[i]"]}}
potential: "{potential}"
{forces}
"""
LINKS = {
    "where": '"x[i in range(N)]": "where(i > 0, x[i - 1], 0) + {x}", '
    '"y[i in range(N)]": "where(i > 0, y[i - 1], 0) - {y}"',
    "reversed": '"x[N - 1]": "{x0}", "y[N - 1]": "-{y0}", '
    '"x[i in range(N - 1)]": "x[i + 1] + {x}", "y[i in range(N - 1)]": "y[i + 1] - {y}"',
    "two roots": '"x[i in range(2)]": "{x} + i", "y[i in range(2)]": "-{y}", '
    '"x[i in range(2, N)]": "x[i - 2] + {x}", "y[i in range(2, N)]": "y[i - 2] - {y}"',
    "other steps": '"x[0]": "l[0]*sin(th[0])", "y[0]": "-l[0]*cos(th[0])", '
    '"x[1]": "x[0] + 2*l[1]*sin(th[1])", "y[1]": "y[0] - 2*l[1]*cos(th[1])", '
    '"x[i in range(2, N)]": "x[i - 1] + {x}", "y[i in range(2, N)]": "y[i - 1] - {y}"',
    "alternating": '"x[i in range(N)]": "where(i > 0, x[i - 1], 0) + where(i % 2 == 0, 1, 1.5)*{x}", '
    '"y[i in range(N)]": "where(i > 0, y[i - 1], 0) - where(i % 2 == 0, 1, 1.5)*{y}"',
}  # fmt: skip
POTENTIALS = (
    "sum(m[i]*g*y[i] for i in range(N))",
    "sum(k*(norm(bob[i] - bob[i - 1]) - 1.5*l[i])**2/2 for i in range(1, N)) + bob[0].y**2",
    "sum(k*(x[i] - x[i - 1])**2 for i in range(1, N)) + k*(th[N - 1] - th[0])**2/2",
)
FORCES = (
    "",
    "dissipation: sum((bob[i].vx - bob[i - 1].vx)**2/2 for i in range(1, N))"
    " + sum(th_dot[i]**2/5 for i in range(N))",
    'generalized_forces: {"th[i in range(N)]": "where(i == 0, sin(t), -0.1*th_dot[i])"}',
)


pytestmark = pytest.mark.usefixtures("however_small")


def spec_of(text: str, count: int | None = None) -> Spec:
    return read_spec(text, "system.yaml", None if count is None else {"N": str(count)})


def printed(text: str, count: int | None = None) -> DerivedFamilies:
    """The equations of a chain."""
    derived = derive_families(spec_of(text, count))
    assert derived is not None and derived.system.joints is not None, text
    return derived


def lines_of(text: str, count: int | None = None, form: str = "text") -> list[str]:
    written = families_as_written(printed(text, count), form, "lagrange", {})
    return [line.strip() for line in written.splitlines()]


def holds(text: str) -> None:
    """Read the equations back, with places as sums and by name, and compare both with the file."""
    spec = spec_of(text)
    system = systems.without_constraints(spec)
    assert system is not None, text
    for naming in (False, True):
        equations = equations_of(system, spec, naming=naming)
        found = verify(system, equations, None, resolve_values(spec, {}), spec)
        assert found.difference <= 1e-13, (str(found), text)


@pytest.mark.exhaustive(keep=0, most=20)
@pytest.mark.parametrize("case", range(100))
def test_what_is_printed_of_chains_and_trees_is_what_the_file_says(
    case: int, pytestconfig: pytest.Config
) -> None:
    chance = random.Random(f"{pytestconfig.option.seed} printed {case}")
    holds(drawn(chance, chance.choice(SIZES)))


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("count", [4, 9])
@pytest.mark.parametrize("case", CASES)
def test_constraints_on_chains_are_those_of_the_file(case: str, count: int) -> None:
    holds(chain(case, count))


@pytest.mark.exhaustive(keep=0, most=20)
@pytest.mark.parametrize("case", range(100))
def test_constraints_on_velocities_of_trees_are_those_of_the_file(
    case: int, pytestconfig: pytest.Config
) -> None:
    holds(drawn_on_trees(random.Random(f"{pytestconfig.option.seed} bound {case}")))


@pytest.mark.exhaustive(keep=0.15)
def test_a_chain_between_two_pins_is_that_of_a_textbook() -> None:
    """Both ends at rest: a multiplier for each component of the last one's place."""
    text = N_PENDULUM + "constraints: {right: bob[N - 1].x - l, level: bob[N - 1].y}\n"
    for form in ("lagrange", "reactions"):
        derived = derive_printed(spec_of(text, 1000), form)
        assert isinstance(derived, DerivedFamilies)
        for format_ in ("text", "unicode", "latex"):
            assert families_as_written(derived, format_, form, {}).count("\n") < 70
    lines = lines_of(text, 1000)
    for line in (
        "l*sum(sin(theta[j]) for j in range(N)) - l = 0   [right]",
        "+ m*g*(N - i)*sin(theta[i]) = lambda_right*cos(theta[i])",
        "+ lambda_level*sin(theta[i])   [theta[i], divided by l, for i in range(N)]",
    ):
        assert line in lines, line
    data = families_as_data(printed(text, 100), {})
    assert [one["multiplier"] for one in data["constraints"]] == ["lambda_right", "lambda_level"]
    assert data["constraints"][0]["second_derivative"].startswith("l*Sum(cos(theta[j])*theta_ddot[j] - ")


@pytest.mark.exhaustive(keep=0.2)
@examples(2)
@given(
    st.sampled_from([*LINKS]), st.sampled_from(SIZES), st.sampled_from(POTENTIALS), st.sampled_from(FORCES)
)
@example("where", 1, POTENTIALS[2], FORCES[0])  # a potential that is 0 at every point
def test_members_that_follow_in_other_ways(links: str, count: int, potential: str, forces: str) -> None:
    if links not in ("where", "alternating"):
        count = max(3, count)
    step = {"x": "l[i]*sin(th[i])", "y": "l[i]*cos(th[i])"}
    step |= {f"{name}0": one.replace("[i]", "[N - 1]") for name, one in step.items()}
    definitions = LINKS[links].format(**step)
    holds(RODS.format(count=count, definitions=definitions, potential=potential, forces=forces))


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize("count", [3, 1000])
def test_the_n_pendulum_is_that_of_a_textbook(count: int) -> None:
    lines = lines_of(N_PENDULUM, count)
    for line in (
        f"N = {count}",
        "U = -m*l*g*sum((N - j)*cos(theta[j]) for j in range(N))",
        "p_theta[i] = m*l**2*sum((N - max(i, j))*cos(theta[i] - theta[j])*theta_dot[j]",
        "for j in range(N))   [for i in range(N)]",
        "l*sum((N - max(i, j))*(cos(theta[i] - theta[j])*theta_ddot[j]",
        "+ sin(theta[i] - theta[j])*theta_dot[j]**2)",
        "+ g*(N - i)*sin(theta[i]) = 0   [theta[i], divided by m*l, for i in range(N)]",
        "the solution of all equations of motion together, which are linear in them; see --form matrix",
    ):
        assert line in lines, line
    assert any(line.startswith("h: ") for line in lines)


def test_one_bob_is_a_pendulum() -> None:
    lines = lines_of(N_PENDULUM, 1)
    assert "p_theta[0] = m*l**2*theta_dot[0]" in lines
    assert "l*theta_ddot[0] + g*N*sin(theta[0]) = 0   [theta[0], divided by m*l]" in lines


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("text", [N_PENDULUM, pendulum(10, "(i - 1)//2"), SPACE])
def test_no_expression_grows_with_the_chain_nor_does_the_work(text: str) -> None:
    def counted(count: int) -> tuple[int, int]:
        derived = printed(text, count)
        own = derived.equations
        found = [own.T, own.U, own.L, own.h, *(one.expression for one in own.places)]
        found += [one.expression for one in own.momenta]
        found += [side for _, one in own.equations for side in (one.left, one.right, one.factor)]
        return sum(size_of(one) for one in found if one is not None), derived.work.spent

    counted(10)  # sympy remembers what it has made
    (size, work), (other, more) = counted(10), counted(100)
    assert size == other
    assert more < 2 * work


@pytest.mark.exhaustive(keep=0.2)
def test_places_that_are_long_have_names() -> None:
    derived = printed(SPACE)

    def written(form: str) -> str:
        return families_as_written(derived, form, "lagrange", {})

    lines = [line.strip() for line in written("text").splitlines()]
    assert "T = sum((1/2 + i/10)*(bob[i].vx**2 + bob[i].vy**2 + bob[i].vz**2) for i in range(N))" in lines
    assert "bob[i].z = -sum(l[j]*path[i,j]*cos(a[j]) for j in range(N))   [for i in range(N)]" in lines
    assert "the parent of i is (i - 1) // 2, for i in range(1, N)" in lines
    assert r"\dot{z}_{\mathrm{bob},i}" in written("latex")
    assert "x_bob_i = sum(l_j path_i_j sin(a_j) cos(b_j) for j in range(N))" in written("unicode")


@pytest.mark.exhaustive(keep=0.5)
def test_springs_between_neighbours_have_the_length_of_the_link() -> None:
    links = LINKS["where"].format(x="(l[i] + th[i])", y="l[i]*cos(th[i])")
    lines = lines_of(RODS.format(count=9, definitions=links, potential=POTENTIALS[2], forces=""))
    (potential,) = [line for line in lines if line.startswith("U = ")]
    assert potential == "U = k*sum((l[i] + th[i])**2 for i in range(1, N)) + k*(th[N - 1] - th[0])**2/2"


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("text", [N_PENDULUM, SPACE])
def test_the_python_module_solves_the_equations_of_the_file(text: str) -> None:
    spec = spec_of(text, 3)
    parameters = dict(resolve_values(spec, {}).parameters)
    module: dict[str, Any] = {}
    exec(families_as_written(printed(text, 3), "python", "lagrange", parameters), module)
    chance = np.random.default_rng(1)
    q, v = chance.normal(size=(2, len(spec.coordinates))).tolist()
    a = module["accelerations"](0.3, q, v)
    direct = directly(spec, parameters, 0.3, q, v, a)
    assert np.max(np.abs(direct.residual)) < 1e-9
    assert np.allclose(module["momenta"](0.3, q, v), direct.momenta, rtol=1e-12, atol=1e-13)
    assert module["energy_function"](0.3, q, v) == pytest.approx(float(direct.h), rel=1e-12)


def unrolled(expression: sympy.Expr) -> sympy.Expr:
    """With the terms of sums, those of the outermost first."""
    if isinstance(expression, sympy.Sum):
        *inner, (index, low, high) = expression.limits
        body = sympy.Sum(expression.function, *inner) if inner else expression.function
        return sympy.Add(*(unrolled(body.subs(index, k)) for k in range(low, high + 1)))
    return expression.func(*map(unrolled, expression.args)) if expression.has(sympy.Sum) else expression


@pytest.mark.exhaustive(keep=0.15)
def test_sympy_reads_the_data_back() -> None:
    data = families_as_data(printed(N_PENDULUM, 4), {})
    assert data["accelerations"] is None and data["positions"] == {} == data["paths"]
    bases = {name: sympy.IndexedBase(name) for name in ("theta", "theta_dot", "theta_ddot")}
    names = {name: sympy.Symbol(name, integer=True) for name in "ijkN"}
    names |= {name: sympy.Symbol(name) for name in "lmg"}
    found = sympy.sympify(data["equations"]["theta[i]"], locals=bases | names)
    last = unrolled(found.subs({names["N"]: 2, names["i"]: 1}))
    theta, rate, second = bases.values()
    length, g = names["l"], names["g"]
    expected = (
        length * (second[1] + sympy.cos(theta[1] - theta[0]) * second[0])
        + length * sympy.sin(theta[1] - theta[0]) * rate[0] ** 2 + g * sympy.sin(theta[1])
    )  # fmt: skip
    assert sympy.simplify(last - expected) == 0
    tree = families_as_data(printed(SPACE), {})
    assert tree["paths"] == {"path": [None, 0, 0, 1, 1, 2, 2, 3, 3]}
    assert tree["members"]["bob[i].ax"] == "for i in range(N)"
    assert "bob_ax[j]" in tree["equations"]["a[i]"]


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("case", range(20))
def test_h_changes_as_is_printed(case: int) -> None:
    """dh/dt beside a difference of h along the motion."""
    texts = (drawn(random.Random(f"changing {k}"), 4) for k in range(100))
    found = [
        text for text in texts if "sin(t)" in text or "wind" in text or "0.1*t" in text or "cos(2*t)" in text
    ]
    derived = printed(found[case])
    (changing,) = derived.equations.changing
    spec, system = derived.system.spec, derived.system
    start = resolve_values(spec, {})
    parameters = np.array([start.parameters[one.name] for one in spec.parameters])
    t, q, v = 0.4, np.array(start.q), np.array(start.v)
    a = compiled_accelerations(system)(t, q, v, parameters)
    read, step = ReadBack(system, derived.equations), 1e-4

    def h(s: float) -> float:
        moved = t + s, q + v * s + a * s**2 / 2, v + a * s, a, parameters
        return float(read.value(derived.equations.h, {}, 1, moved)[0][0])

    (rate,), (size,) = read.value(changing.rate, {}, 1, (t, q, v, a, parameters))
    difference = (8 * (h(step) - h(-step)) - (h(2 * step) - h(-2 * step))) / (12 * step)
    assert abs(rate - difference) <= 1e-6 * max(1.0, size), found[case]


@pytest.mark.exhaustive(keep=0.35)
def test_compiled_and_printed_equations_agree_and_wrong_ones_do_not() -> None:
    right = printed(N_PENDULUM, 5)
    wrong = printed(N_PENDULUM.replace("m*g*bob[i].y", "m*g*bob[i].y*(1 + 1e-9)"), 5)
    assert verify_families(right, {}).difference <= 1e-14
    mixed = DerivedFamilies(right.system, wrong.equations, Work())
    assert verify_families(mixed, {}).difference > 1e-11


@pytest.mark.exhaustive(keep=0.7)
def test_many_members_are_compared_a_few_at_a_time() -> None:
    found = verify_families(printed(N_PENDULUM, 150), {})
    assert found.agrees and "of each line at a time" in str(found)


@pytest.mark.exhaustive(keep=0.25)
def test_a_name_of_the_file_is_not_taken_for_that_of_a_place() -> None:
    derived = printed(SPACE.replace("g: 2.0", "g: 2.0, bob_vx: 1.0"))
    assert "bob[i].vx" in families_as_written(derived, "text", "lagrange", {})
    for form in (
        lambda: families_as_written(derived, "python", "lagrange", {}),
        lambda: families_as_data(derived, {}),
    ):
        with pytest.raises(UsageError, match="bob_vx is the name of"):
            form()


def test_members_that_follow_otherwise_are_no_chain() -> None:
    """Each is twice the one before: they are written out."""
    links = '"x[0]": "th[0]", "x[i in range(1, N)]": "2*x[i - 1] + th[i]", "y[i in range(N)]": "i"'
    text = RODS.format(count=9, definitions=links, potential=POTENTIALS[0], forces="")
    assert derive_families(spec_of(text)) is None


# sums


BOUND = st.tuples(st.integers(0, 1), st.integers(-2, 3))


def whole(name: str, bound: tuple[int, int]) -> Whole:
    return named(name) * bound[0] + number(bound[1])


def value(expression: sympy.Expr, indices: dict[str, int]) -> Fraction:
    """Sums by brute force, of f[k] = k**3 + 7."""
    if isinstance(expression, Summed):
        (loop, *rest), total = expression.loops, Fraction(0)
        for one in range(loop.start.value(indices), loop.stop.value(indices)):
            inner = Summed(expression.body, Loops(rest), evaluate=False) if rest else expression.body
            total += value(inner, {**indices, loop.index: one})
        return total
    if expression.is_Symbol:
        base, (index,) = KNOWN.get(expression.name, ("", [named(expression.name)]))
        own = Fraction(index.value(indices))
        return own**3 + 7 if base == "f" else own
    if expression.is_Rational:
        return Fraction(int(expression.p), int(expression.q))
    listed = [value(one, indices) for one in expression.args]
    if isinstance(expression, Extremum):
        return max(listed) if isinstance(expression, Largest) else min(listed)
    return sum(listed, Fraction(0)) if expression.is_Add else Fraction(prod(listed))


@examples(60)
@given(BOUND, BOUND, st.integers(0, 4), st.integers(1, 5), st.booleans())
def test_exchanged_sums_are_the_same(
    start: tuple[int, int], stop: tuple[int, int], low: int, size: int, counted: bool
) -> None:
    """Also sums over what is on one side of a number, which are counted by max and min."""
    loops = [
        Loop("i", number(low), named("N") + number(low)), Loop("j", whole("i", start), whole("i", stop)),
    ]  # fmt: skip
    summed = Summed(member("f", [named("i" if counted else "j")]), Loops(loops))
    if isinstance(summed, Summed):
        spans = {"N": (size, size)}
        assert value(exchanged(summed, spans), {"N": size}) == value(summed, {"N": size})


@examples(60)
@given(BOUND, BOUND, BOUND, BOUND, st.integers(0, 3))
def test_telescoped_sums_are_the_same(
    one: tuple[int, int], two: tuple[int, int], three: tuple[int, int], four: tuple[int, int], place: int
) -> None:
    ends = [whole("i", bound) for bound in (one, two, three, four)]
    sums = [
        Summed(member("f", [named(index)]), Loops([Loop(index, *bounds)]))
        for index, bounds in (("j", ends[:2]), ("k", ends[2:]))
    ]
    known = {"i": place}
    apart = sums[0] - sums[1]
    assert value(telescoped(apart, known), known) == value(apart, known)


@examples(60)
@given(
    st.integers(0, 3), BOUND, st.sampled_from(["<", "<=", ">", ">="]), st.integers(0, 4), st.integers(3, 5)
)
def test_what_is_on_one_side_is_counted(
    start: int, bound: tuple[int, int], sign: str, place: int, size: int
) -> None:
    condition = relation(named("k"), sign, whole("i", bound))
    loop = Loop("k", number(start), named("N"), 1, (condition,))
    indices, spans = {"i": place, "N": size}, {"N": (size, size), "i": (0, 4)}
    counted = sum(condition_holds(condition, {**indices, "k": k}) for k in range(start, size))
    (summed,) = Summed(member("f", [named("i")]), Loops([loop])).atoms(Summed)
    found = exchanged(summed, spans)
    if not found.has(Summed):
        assert value(found, indices) == counted
