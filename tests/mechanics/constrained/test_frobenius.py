"""Which combinations of constraints on velocities are integrable: the last system of their derived flag."""

import itertools
import random

import numpy as np
import pytest
import sympy

from lagrange_cli.run.check import classify
from lagrange_cli.run.classification import as_object, as_text
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_values
from tests.support.motion import follow

CARRIAGE = """
parameters: {M: 3, r: 0.2, w: 0.4, b: 0.1}
coordinates:
  {x: {initial: 0}, y: {initial: 0}, th: {initial: 0, velocity: 0.7}, p1: {initial: 0}, p2: {initial: 0}}
masses: {body: M, left: 1, right: 1}
positions:
  body: [x, y]
  left: [x - w*sin(th), y + w*cos(th)]
  right: [x + w*sin(th), y - w*cos(th)]
nonholonomic:
  side: y_dot*cos(th) - x_dot*sin(th)
  l: left.vx*cos(th) + left.vy*sin(th) - r*p1_dot
  rr: right.vx*cos(th) + right.vy*sin(th) - r*p2_dot
"""


def classified(text):
    spec = read_spec(text, "a.yaml")
    return classify(spec, values=resolve_values(spec))


def of_forms(*forms, names="xyzuvw", coordinates=""):
    """A system of free particles with these constraints."""
    given = ", ".join(f"{q}: {{initial: 0.3}}" for q in names)
    lines = "\n".join(f"  c{k}: {form}" for k, form in enumerate(forms))
    squares = " + ".join(f"{q}_dot**2" for q in names)
    return f"coordinates: {{{given}}}\nlagrangian: {squares}\nnonholonomic:\n{lines}\n"


def kept(text):
    return classified(text).integrability.functions


@pytest.mark.exhaustive(keep=0.5)
def test_the_difference_of_the_rolling_constraints_of_a_carriage_is_integrable():
    found = classified(CARRIAGE)
    answer = as_object(found)
    assert answer["combinations"] == {"l - rr": {"constraints": ["l", "rr"], "factors": ["1", "-1"]}}
    assert answer["integrals"] == {"l - rr": "-p1*r + p2*r - 2*th*w"}
    assert answer["integrable"] == {"together": False, "side": False, "l": False, "rr": False}
    assert answer["reachable"] == 4
    lines = [line.strip() for line in as_text(found, verbose=False).splitlines()]
    assert "l - rr is integrable (Frobenius): -p1*r + p2*r - 2*th*w is constant" in lines
    assert "so the configurations that a motion reaches have at most 4 dimensions of 5" in lines


def test_a_motion_keeps_the_integral_of_a_combination():
    motion = follow(CARRIAGE, 20.0, 21, outputs=("q",), sets={"x_dot": 1.0, "p1_dot": 3.6, "p2_dot": 6.4})
    p1, p2, th = (motion[f"q/{name}"] for name in ("p1", "p2", "th"))
    integral = 0.2 * (p2 - p1) - 0.8 * th
    assert np.abs(th).max() > 10
    assert np.abs(integral - integral[0]).max() < 1e-13


@pytest.mark.exhaustive(keep=0.35)
def test_factors_may_be_parameters_and_integrals_may_depend_on_time():
    text = (
        CARRIAGE.replace("- r*p1_dot", "- r*p1_dot - b*t")
        .replace("  rr: ", "  rr: b*(")
        .replace("r*p2_dot", "r*p2_dot)")
    )
    answer = as_object(classified(text))
    (one,) = answer["combinations"].values()
    assert one["constraints"] == ["l", "rr"]
    (integral,) = answer["integrals"].values()
    p1, p2, r, th, w, t, b = sympy.symbols("p1 p2 r th w t b")
    ratio = sympy.sympify(integral) / (2 * w * th + r * (p1 - p2) + b * t**2 / 2)
    assert sympy.simplify(ratio).free_symbols <= {b}


def test_factors_may_be_functions_of_the_configuration():
    # the first two keep x*y + z: (1, exp(y)) times it, and a contact form
    total = "(y*x_dot + x*y_dot + z_dot)"
    contact = "(u_dot - v*w_dot)"
    text = of_forms(f"cos(x)*{total} + {contact}", f"exp(y)*{total} + x*{contact}")
    found = classified(text)
    assert [one.constraints for one in found.integrability.combinations] == [("c0", "c1")]
    assert [one.factors for one in found.integrability.combinations] == [None]
    assert {*found.integrals.values()} == {"x*y + z"}


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize(
    "forms",
    [
        # a rolling disc, Engel's form (its first derived system is not zero), and an n-trailer's
        ("x_dot - w_dot*cos(z)", "y_dot - w_dot*sin(z)"),
        ("y_dot - z*x_dot", "z_dot - u*x_dot"),
        ("y_dot - z*x_dot", "z_dot - u*x_dot", "u_dot - v*x_dot"),
        ("y_dot*cos(z) - x_dot*sin(z)", "y_dot*cos(u) - x_dot*sin(u) - z_dot*cos(u - z)"),
        ("y_dot - z*x_dot", "v_dot - w*u_dot"),
    ],
)
def test_nothing_is_claimed_where_every_configuration_is_within_reach(forms):
    found = classified(of_forms(*forms)).integrability
    assert (found.functions, found.combinations, found.together) == (0, (), False)


def test_constraints_that_are_integrable_together_need_no_combinations():
    # two parallel knife edges on one rigid body, one behind the other, keep its direction
    edges = "y_dot*cos(z) - x_dot*sin(z)", "y_dot*cos(z) - x_dot*sin(z) + 2*z_dot"
    found = classified(of_forms(*edges)).integrability
    assert (found.functions, found.combinations, found.together) == (2, (), True)
    gears = classified(of_forms("x_dot + 2*y_dot", "y_dot + 3*z_dot", "u_dot - t*x_dot"))
    assert [*gears.integrals] == ["c0", "c1"]
    assert gears.integrability.functions == 2


EDGE, CONTACT = "(y_dot*cos(z) - x_dot*sin(z))", "(u_dot - v*w_dot)"


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(
    "forms, told",
    [
        (
            (f"{EDGE} + {CONTACT}", f"{EDGE} + 2*z_dot + x*{CONTACT}", f"{CONTACT}*(1 + y**2) + z_dot"),
            "combination 1 of c0, c1 and combination 2 of c0, c2 are integrable together (Frobenius): "
            "2 functions of q and t are constant",
        ),
        (
            (f"{EDGE} + {CONTACT}", "z_dot", CONTACT),
            "where c1 holds, c0 - c2 is integrable (Frobenius): a function of q and t is constant",
        ),
    ],
)
def test_what_is_integrable_only_together_is_told_in_one_line(forms, told):
    lines = as_text(classified(of_forms(*forms)), verbose=False).splitlines()
    assert f"    {told}" in lines
    assert "    so the configurations that a motion reaches have at most 4 dimensions of 6" in lines


@pytest.mark.exhaustive(keep=0.3)
def test_events_may_lead_to_other_configurations():
    event = "events: {kick: {when: p1 - 1, action: {set: {th: th + 1}}}}\n"
    assert "that a motion reaches between events have at most 4" in as_text(
        classified(CARRIAGE + event), verbose=False
    )


@pytest.mark.exhaustive(keep=0.35)
def test_the_values_of_parameters_count():
    # the difference is the differential of x*y where a = 2*b, and not integrable anywhere else
    difference = "a*x*y_dot + 2*b*y*x_dot + z*(a - 2*b)*x_dot"
    text = of_forms(f"{difference} + {CONTACT}", CONTACT)
    assert [kept(f"parameters: {{a: {a}, b: 0.3}}\n{text}") for a in (0.6, 0.7)] == [1, 0]


COORDINATES = sympy.symbols("x y z u v w")
VELOCITIES = sympy.symbols("x_dot y_dot z_dot u_dot v_dot w_dot")


def mixed_differentials(source):
    """Constraints that are functions times the differentials of up to three functions and a form that is not
    integrable in general, and how many functions they keep.

    They keep those functions. The last system of the flag has one form more where the rest is integrable
    on their level sets: its exterior derivative is 0 there along all displacements that are allowed
    (Frobenius).
    """
    q, v = COORDINATES, VELOCITIES

    def function():
        a, b, c = source.sample(q, 3)
        return source.choice([a * b + c, sympy.sin(a) * b - c**2, a + sympy.exp(b * c), a * b * c + a])

    many = source.randrange(4)
    forms = [sum(sympy.diff(f, a) * b for a, b in zip(q, v)) for f in (function() for _ in range(many))]
    rest = v[0] + q[1] * q[2] * v[3] - q[4] * v[5] + q[3] ** 2 * v[4]
    at = {one: source.uniform(0.3, 1.2) for one in q}
    rows = sympy.Matrix([[sympy.expand(form).coeff(b) for b in v] for form in [*forms, rest]])
    numbers = np.array(rows.subs(at), dtype=float)
    turning = rows[-1, :].jacobian(q)
    along = np.linalg.svd(numbers)[2][np.linalg.matrix_rank(numbers) :]
    curl = along @ np.array((turning - turning.T).subs(at), dtype=float) @ along.T
    functions = int(np.linalg.matrix_rank(numbers[:-1])) if many else 0
    forms.append(rest)
    size = len(forms)
    for i, j in [*((0, j) for j in range(1, size)), *itertools.permutations(range(size), 2)]:
        forms[i] += source.choice([0, 1, function(), function()]) * forms[j]
    return forms, functions + bool(np.abs(curl).max() < 1e-9)


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize("case", range(200))
def test_mixed_differentials_are_all_found(case, pytestconfig):
    forms, expected = mixed_differentials(random.Random(f"{pytestconfig.option.seed} {case}"))
    assert kept(of_forms(*map(str, forms))) == expected, forms


def test_a_form_is_integrable_where_other_functions_are_constant():
    """Where u and w are, x + u**2*v is."""
    assert kept(of_forms("u_dot", "w_dot", "x_dot + y*z*u_dot - v*w_dot + u**2*v_dot")) == 3


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize(
    ("text", "speeds", "known"),
    [
        (
            CARRIAGE,
            {"x_dot": 1.0, "p1_dot": 3.6, "p2_dot": 6.4},
            lambda q: 0.2 * (q["p1"] - q["p2"]) + 0.8 * q["th"],
        ),
        (
            of_forms("x*y_dot + y*x_dot + z_dot"),
            {"x_dot": 1.0, "y_dot": 1.0, "z_dot": -0.6},
            lambda q: q["x"] * q["y"] + q["z"],
        ),
        (
            of_forms("cos(2*x)*x_dot + z*z_dot"),
            {"x_dot": -0.3 / np.cos(0.6), "z_dot": 1.0},
            lambda q: np.sin(2 * q["x"]) / 2 + q["z"] ** 2 / 2,
        ),
        (  # a differential only if it is divided by y*z
            of_forms("y*z_dot + 2*z*y_dot"),
            {"y_dot": 1.0, "z_dot": -2.0},
            lambda q: np.log(q["z"]) / 2 + np.log(q["y"]),
        ),
        (of_forms("x_dot - y*z_dot"), {"x_dot": 0.3, "z_dot": 1.0}, None),
    ],
)
def test_what_constraints_keep_is_among_what_is_conserved(text, speeds, known):
    motion = follow(text, 0.5, 6, sets=speeds, outputs=("q", "conserved"))
    made = [series for name, series in motion.data.items() if name.startswith("diagnostics/conserved/F_")]
    assert len(made) == (known is not None)
    for series in made:
        q = {name.removeprefix("q/"): row for name, row in motion.data.items() if name.startswith("q/")}
        assert np.abs(np.abs(series) - np.abs(known(q))).max() < 1e-14
        assert np.ptp(series) < 1e-14
        assert max(np.ptp(row) for row in q.values()) > 0.1
