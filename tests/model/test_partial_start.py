"""A start of which only some values are given, and these do not fit: the nearest states by other methods."""

from __future__ import annotations

import math
import re
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import minimize, minimize_scalar

from lagrange_cli.errors import SpecError
from lagrange_cli.model.start import closures
from lagrange_cli.run.start import consistent_values
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_long_values
from tests.model.test_start import SLIDER_CRANK, numbers, refused, start

CRANK = """
coordinates:
  x: {initial: 0.2}
  y: {}
  s: {initial: 1}
masses: {pin: 1, slider: 2}
positions: {pin: [x, y], slider: [s, 0]}
constraints:
  crank: x**2 + y**2 - 0.25
  rod: (x - s)**2 + y**2 - 1.44
"""


def nearest_of_crank(x: float, s: float) -> tuple[float, float, float]:
    """Without y: x = (s**2 - 1.19)/(2 s), as far as the crank reaches."""

    def moved(to: float) -> float:
        return ((to**2 - 1.19) / (2 * to) - x) ** 2 + 2 * (to - s) ** 2

    best = minimize_scalar(moved, bounds=(0.7, 1.7), method="bounded", options={"xatol": 1e-12}).x
    at = (best**2 - 1.19) / (2 * best)
    return at, math.sqrt(max(0.0, 0.25 - at**2)), best


@pytest.mark.exhaustive(keep=0.45)
@pytest.mark.parametrize(("x", "s"), [(0.2, 1.0), (-0.4, 1.0), (0.45, 1.1)])
def test_closures_on_both_sides_are_equally_near_and_each_may_be_copied(x, s):
    known = nearest_of_crank(x, s)
    with pytest.raises(SpecError) as caught:
        start(CRANK, forced=True, x=x, s=s)
    (problem,) = caught.value.problems
    assert (problem.line, "are equally near" in problem.message) == (4, True)
    listed = numbers(r"x = (\S+), y = (\S+), s = (\S+)", problem.message)
    np.testing.assert_allclose(listed, [(known[0], side * known[1], known[2]) for side in (-1, 1)], rtol=1e-6)
    options = dict(re.findall(r"--set (\w+)=(\S+)", problem.hint))
    found = start(CRANK, **{name: float(text) for name, text in options.items()})
    assert found.q == pytest.approx(listed[0], rel=1e-15)


@pytest.mark.exhaustive(keep=0.45)
def test_where_both_sides_meet_the_nearest_closure_is_taken_to_all_digits():
    found = start(CRANK, forced=True, x=-0.9)
    assert found.q == pytest.approx((-0.5, 0.0, 0.7), rel=1e-15)
    assert {one.name: (one.given, one.by) for one in found.changed if one.given is not None} == {
        "x": (-0.9, pytest.approx(0.4)),
        "s": (1.0, pytest.approx(-0.3)),
    }
    assert [one.name for one in found.changed if one.given is None] == ["y"]


def test_from_the_centre_where_constraints_depend_on_each_other_the_nearest_are_found():
    """At x = s = 0 both constraints turn with y alone. Before, places where one of them holds were nearer."""
    with pytest.raises(SpecError) as caught:
        start(CRANK, forced=True, x=0.0, s=0.0)
    listed = numbers(r"x = (\S+), y = (\S+), s = (\S+)", caught.value.problems[0].message)
    np.testing.assert_allclose(listed, [(-0.5, 0, 0.7), (0.5, 0, -0.7)], atol=1e-12)


@pytest.mark.exhaustive(keep=0.2)
def test_without_being_asked_for_it_is_refused_with_each_residual_at_its_line():
    missing, crank, rod = refused(CRANK, x=-0.4)
    assert (missing.line, crank.line, rod.line) == (4, 9, 10)
    best = float(re.search(r"no value of y .*; the best is y = (\S+)", missing.message)[1])
    for problem, value in (crank, 0.16 + best**2 - 0.25), (rod, 1.96 + best**2 - 1.44):
        shown = float(re.search(r"it is (\S+), not 0", problem.message)[1])
        assert shown == pytest.approx(value, rel=1e-2)
    assert "several consistent states are equally near" in missing.hint
    assert "--project-initial takes the nearest consistent state (x = -0.5," in refused(CRANK, x=-0.9)[0].hint


@pytest.mark.exhaustive(keep=0.35)
def test_many_digits_end_at_the_state_that_doubles_have_found():
    spec = read_spec(CRANK.replace("initial: 0.2", "initial: -0.9"), "crank.yaml")
    values = resolve_long_values(spec)
    _, found, begin = consistent_values(spec, values, 0.0, (), forced=True, exact=True)
    assert found.q == (-0.5, 0.0, 0.7)
    assert found.remainder.q[2] == pytest.approx(float(Fraction(7, 10) - Fraction(0.7)), rel=1e-10)
    assert {*begin.moved} == {"x", "s"}


def test_constraints_that_contradict_each_other_are_refused_at_their_lines():
    text = CRANK + "  again: x**2 + y**2 - 0.36\n"
    with pytest.raises(SpecError) as caught:
        start(text, forced=True)
    assert {9, 11} <= {one.line for one in caught.value.problems}


@pytest.mark.exhaustive(keep=0.15)
def test_an_angle_without_a_value_has_no_full_turns():
    """Before, the same state was listed twice, as equally near: with -6.2131 and 0.0701."""
    text = SLIDER_CRANK.replace("{initial: 0.1170928911202160}", "{}").replace("x: {}", "x: {initial: 1.6}")
    phi, psi, x = start(text, forced=True).q
    assert math.sin(psi) == pytest.approx(0.3 * math.sin(phi), rel=1e-14)
    assert x == pytest.approx(0.3 * math.cos(phi) + math.cos(psi), rel=1e-14)
    assert abs(psi) < 0.2


def test_velocities_without_values_do_not_pull_at_given_ones():
    """x + y = 0 for velocities that are given; z follows from them, and has none to be near to."""
    text = """
    coordinates: {x: {velocity: 1}, y: {velocity: 0}, z: {initial: 0}}
    masses: {a: 1, b: 3, c: 50}
    positions: {a: x, b: y, c: z}
    constraints: {pair: x + y, third: x - 2*y + z}
    """
    text = text.replace("x: {", "x: {initial: 0, ").replace("y: {", "y: {initial: 0, ")
    assert start(text, forced=True).v == pytest.approx((0.25, -0.25, -0.75), rel=1e-12)


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize("seed", range(8))
def test_no_other_search_finds_a_nearer_state(seed):
    """Rods between random places with one of their coordinates left out, against minimization by SLSQP from
    many places."""
    chance = np.random.default_rng(seed)
    count = int(chance.integers(2, 4))
    truth = chance.uniform(-1, 1, (count, 2))
    masses = chance.uniform(0.3, 3, count)
    names = [f"{axis}{i}" for i in range(count) for axis in "xy"]
    left_out = int(chance.integers(2 * count))
    ends = [*pairwise([(0.0, 0.0), *truth.tolist(), (1.5, 0.0)])]
    lengths = [math.dist(*pair) for pair in ends]
    given = truth.ravel() + chance.normal(size=2 * count) * 0.3

    def constraints(q: np.ndarray) -> np.ndarray:
        places = [(0.0, 0.0), *q.reshape(-1, 2), (1.5, 0.0)]
        return np.array([math.dist(*pair) - one for pair, one in zip(pairwise(places), lengths)])

    weights = np.repeat(masses, 2)
    weights[left_out] = 0.0

    def gap(q: np.ndarray) -> float:
        return float(weights @ (q - given) ** 2)

    best = math.inf
    for _ in range(30):
        begin = given + chance.normal(size=2 * count) * 0.3
        begin[left_out] = chance.uniform(-3, 3)
        found = minimize(gap, begin, constraints={"type": "eq", "fun": constraints}, method="SLSQP")
        if np.abs(constraints(found.x)).max() < 1e-7:
            best = min(best, found.fun)
    points = [f"({name}, {other})" for name, other in zip(names[::2], names[1::2])]
    rods = pairwise(["(0, 0)", *points, "(1.5, 0)"])
    lines = [f"  r{i}: norm({a} - {b}) - {one!r}" for i, ((a, b), one) in enumerate(zip(rods, lengths))]
    values = [
        f"  {name}: " + ("{}" if k == left_out else f"{{initial: {float(given[k])!r}}}")
        for k, name in enumerate(names)
    ]
    text = "\n".join(
        [
            "coordinates:",
            *values,
            f"masses: {{{', '.join(f'p{i}: {float(m)!r}' for i, m in enumerate(masses))}}}",
            f"positions: {{{', '.join(f'p{i}: [x{i}, y{i}]' for i in range(count))}}}",
            "constraints:",
            *lines,
        ]
    )
    try:
        states = [start(text, forced=True).q]
    except SpecError as error:
        pattern = ", ".join(rf"{name} = ([^,\s]+)" for name in names)
        states = numbers(pattern, error.problems[0].message)
        assert len(states) > 1, error
    for state in states:
        assert np.abs(constraints(np.array(state))).max() < 1e-9
        assert gap(np.array(state)) <= best * (1 + 1e-5) + 1e-9


@pytest.mark.parametrize(
    ("constraint", "function"),
    [("norm(a - b)", "norm"), ("-2*norm(a - b)/k", "norm"), ("d", "sqrt"), ("k*sqrt(x)", "sqrt")],
)
def test_a_length_that_is_to_be_0_is_refused_for_what_it_is(constraint, function):
    """Before: no finite derivative at the initial state, or a coordinate that the constraint leaves free."""
    text = f"""
    parameters: {{k: 2}}
    coordinates: {{x: {{initial: 1}}, y: {{initial: 0}}, u: {{initial: 1}}, w: {{initial: 0}}}}
    definitions: {{d: "sqrt((x - u)**2 + (y - w)**2)"}}
    masses: {{a: 1, b: 2}}
    positions: {{a: [x, y], b: [u, w]}}
    constraints: {{joint: {constraint}}}
    """
    (problem,) = refused(text)
    assert problem.line == 7
    assert problem.message == (
        f"constraint 'joint' has no derivative where it is satisfied: {function}(...) is 0 there"
    )


ARMS = """
parameters: {L: 3, s: 1, d: 1}
coordinates: {ax: {}, ay: {initial: 0.4}, bx: {}, by: {}, cx: {}, cy: {}}
masses: {A: 1, B: 1, C: 1}
positions: {A: [ax, ay], B: [bx, by], C: [cx, cy]}
constraints:
  crank: (ax - d)**2 + ay**2 - d**2
  b: bx**2 + by**2 - L**2
  c: cx**2 + cy**2 - L**2
  ab: norm(B - A) - s
  ac: norm(C - A) - s
"""


@pytest.mark.exhaustive(keep=0.15)
def test_a_linkage_out_of_reach_is_refused_before_its_singular_end_is_approached_from_everywhere(monkeypatch):
    """The only consistent states have A at (2, 0), where both arms are folded, and slopes are dependent."""
    monkeypatch.setenv("LAGRANGE_LIMITS", "work=3000000")
    with pytest.raises(SpecError) as caught:
        start(ARMS)
    first = caught.value.problems[0]
    assert first.line == 3 and "no value of ax, bx, by, cx" in first.message
    (found,) = numbers(r"ax = (\S+), ay = (\S+), bx = (\S+), by = (\S+),", first.hint)
    np.testing.assert_allclose(found, [2, 0, 3, 0], atol=1e-3)


def test_values_may_be_much_larger_than_those_they_follow_from(monkeypatch):
    """Newton's method goes there, and no places are looked at where two closures might meet: that takes long
    for each of many members."""
    monkeypatch.setattr(closures, "near_miss", lambda *_: pytest.fail("a place is looked for otherwise"))
    found = start("""
sizes: {N: 40}
coordinates: {"x[i in range(N)]": {initial: 0.1*cos(i)}, "y[i in range(N)]": {}}
masses: {"bead[i in range(N)]": 1}
positions: {"bead[i in range(N)]": ["x[i]", "y[i]"]}
constraints: {"wire[i in range(N)]": "y[i] - cosh(x[i])"}
""")
    assert found.q[40:] == pytest.approx([math.cosh(x) for x in found.q[:40]], rel=1e-15)
