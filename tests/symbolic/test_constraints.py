"""Equations of motion with multipliers, as printed and as verified."""

from __future__ import annotations

import json

import pytest
import sympy

from lagrange_cli.errors import NotLinear, UsageError
from lagrange_cli.integrate.single_state import compiled_values
from lagrange_cli.records import replace
from lagrange_cli.run import verification
from lagrange_cli.run.equations import as_data, as_written, derive
from lagrange_cli.run.verification import verify_system
from lagrange_cli.symbolic.direct import directly
from lagrange_cli.symbolic.hamilton import vakonomic_form
from lagrange_cli.symbolic.states import State, admissible
from lagrange_cli.symbolic.verify import DIRECT, verify
from tests.support.motion import residual_of, spec_of, values_of
from tests.support.systems import derived

PENDULUM = """
name: pendulum
parameters: {m: 1.5, l: 2, g: 9.81}
coordinates: {x: {initial: l, velocity: 0}, y: {initial: 0, velocity: 0}}
masses: {bob: m}
embedding: {bob: [x, y]}
potential: m*g*bob.y
constraints: {rod: x**2 + y**2 - l**2}
"""
KNIFE = """
name: knife edge on an incline
parameters: {m: 1, J: 0.5, g: 9.81, alpha: 0.3}
coordinates: {x: {initial: 0}, y: {initial: 0}, phi: {initial: 0, velocity: 1}}
lagrangian: m*(x_dot**2 + y_dot**2)/2 + J*phi_dot**2/2 + m*g*sin(alpha)*x
nonholonomic: {edge: y_dot*cos(phi) - x_dot*sin(phi)}
"""
DRIVEN = """
parameters: {m: 1, l: 1, g: 9.81, A: 0.1, w: 3, c: 0.2}
coordinates: {x: {initial: l}, y: {initial: 0}}
masses: {bob: m}
embedding: {bob: [x, y]}
potential: m*g*bob.y
dissipation: c*(x_dot**2 + y_dot**2)/2
constraints: {rod: (x - A*sin(w*t))**2 + y**2 - l**2}
"""
FOUR_BAR = """
parameters: {m: 1, l1: 1, l2: 2, l3: 1.5, d: 2, g: 9.81}
coordinates: {a: {initial: 1.2, velocity: 0.5}, b: {initial: 0.273413889460298}, c: {}}
masses: {p: m, q: m}
embedding:
  p: [l1*cos(a), l1*sin(a)]
  q: [l1*cos(a) + l2*cos(b), l1*sin(a) + l2*sin(b)]
potential: m*g*p.y + m*g*q.y
constraints:
  closed: l1*cos(a) + l2*cos(b) - l3*cos(c) - d
  level: l1*sin(a) + l2*sin(b) - l3*sin(c)
"""
CHAIN = """
parameters: {m: 1, l: 1, g: 9.81}
sizes: {N: 3}
coordinates: {"x[i in range(N)]": {initial: (i + 1)*l}, "y[i in range(N)]": {initial: 0}}
masses: {"p[i in range(N)]": m}
embedding: {"p[i in range(N)]": "[x[i], y[i]]"}
potential: sum(m*g*p[i].y for i in range(N))
constraints:
  "link[i in range(N)]": "(x[i] - where(i > 0, x[i-1], 0))**2 + (y[i] - where(i > 0, y[i-1], 0))**2 - l**2"
"""
ROLLING_UPHILL = """
parameters: {m: 1, g: 9.81, u: 0.4}
coordinates: {x: {initial: 0}, y: {initial: -0.1}, s: {initial: 0}}
lagrangian: m*(x_dot**2 + y_dot**2)/2 + s_dot**2/4 - m*g*y - max(0, x)**2
constraints: {hill: y - x**2/5 - u/2 + 0.3}
nonholonomic: {rolling: s_dot - (1 + x**2)*x_dot - u*cos(t)}
"""
MASSLESS = """
parameters: {m: 1, l: 2, g: 9.81}
coordinates: {x: {initial: l}, y: {initial: 0}, s: {initial: l**2}}
masses: {bob: m}
embedding: {bob: [x, y]}
potential: m*g*bob.y + s**2
constraints: {rod: s - x**2 - y**2}
"""
TWICE = PENDULUM.replace("constraints: {", "constraints: {again: sqrt(x**2 + y**2) - l, ")
BALL_ON_AN_INCLINE = """
parameters: {a: 0.1, g: 9.81, slope: 0.3, I: 2*a**2/5}
coordinates:
  x: {initial: 0}
  y: {initial: 0}
  z: {initial: a}
  qw: {initial: 0.9}
  qx: {initial: 0.3}
  qy: {initial: -0.1}
  qz: {initial: 0.3}
definitions:
  n: [2*(qx*qz - qw*qy), 2*(qy*qz + qw*qx), qw**2 - qx**2 - qy**2 + qz**2]
  p: -a*n/norm(n)
bodies:
  ball: {mass: 1, inertia: [I, I, I], position: [x, y, z], orientation: {quaternion: [qw, qx, qy, qz]}}
potential: g*(ball.z*cos(slope) - ball.x*sin(slope))
constraints: {touch: z - a*norm(n)}
nonholonomic: {along: "ball.at(p.x, p.y, p.z).vx", across: "ball.at(p.x, p.y, p.z).vy"}
"""  # y_ddot is 0, as terms cancel that are not
SYSTEMS = {
    "pendulum": PENDULUM,
    "knife edge": KNIFE,
    "driven": DRIVEN,
    "four-bar linkage": FOUR_BAR,
    "chain": CHAIN,
    "rolling uphill": ROLLING_UPHILL,
    "massless": MASSLESS,
}


def test_a_pendulum_reads_as_in_a_textbook():
    text = as_written(derive(spec_of(PENDULUM)), "text", "lagrange", {})
    for line in (
        "pendulum: 1 degree of freedom",
        "Constraints\n  x**2 + y**2 - l**2 = 0   [rod]",
        "  m*x_ddot = 2*lambda_rod*x   [x]",
        "  m*y_ddot = 2*lambda_rod*y - m*g   [y]",
        "Multipliers\n  lambda_rod = m*(-x_dot**2 - y_dot**2 + g*y)/(2*(x**2 + y**2))",
        "and the forces of constraint do no work; h = T + U",
        "  dp_x/dt = 2*lambda_rod*x\n    x is cyclic, but a force of constraint acts on it",
    ):
        assert line in text


@pytest.mark.exhaustive(keep=0.7)
def test_every_notation():
    derivation = derive(spec_of(KNIFE))
    assert r"m \ddot{y} &= \lambda_{\mathrm{edge}} \cos \phi" in as_written(
        derivation, "latex", "lagrange", {}
    )
    assert r"\text{(edge, nonholonomic)}" in as_written(derivation, "latex", "lagrange", {})
    assert " = λ_edge cos(φ)   [y]" in as_written(derivation, "unicode", "lagrange", {})
    data = json.loads(json.dumps(as_data(derivation, "hamilton", {})))
    (constraint,) = data["constraints"]
    assert constraint["kind"] == "nonholonomic" and constraint["multiplier"] == "lambda_edge"
    assert constraint["slopes"] == {"x": "-sin(phi)", "y": "cos(phi)", "phi": "0"}
    assert data["equations"]["y"] == "m*y_ddot - lambda_edge*cos(phi)"
    assert set(data["multipliers"]) == {"edge"}
    assert data["canonical_equations"]["momentum_rates"]["y"] == "lambda_edge*cos(phi)"
    assert data["canonical_equations"]["constraints"]["edge"] == "-sin(phi)*p_x/m + cos(phi)*p_y/m"


def test_the_linear_system():
    text = as_written(derive(spec_of(DRIVEN)), "text", "matrix", {})
    for line in (
        "  M a = f + A^T lambda\n  A a = b\n",
        "  lambda = [lambda_rod]",
        "  A = [[2*x - 2*A*sin(w*t), 2*y]]",
    ):
        assert line in text
    assert r"M a &= f + A^{T} \lambda" in as_written(derive(spec_of(DRIVEN)), "latex", "matrix", {})


def test_forces_of_constraint_in_hamiltons_equations():
    text = as_written(derive(spec_of(PENDULUM)), "text", "hamilton", {})
    assert "p_y_dot = 2*lambda_rod*y - m*g" in text and "x**2 + y**2 - l**2 = 0   [rod]" in text
    with pytest.raises(UsageError, match="no Hamiltonian: the mass matrix is singular"):
        as_written(derive(spec_of(MASSLESS)), "text", "hamilton", {})


@pytest.mark.exhaustive(keep=0.8)
@pytest.mark.parametrize("text", [PENDULUM, KNIFE, CHAIN])
def test_python_solves_for_accelerations_and_multipliers(text):
    """Explicitly or by elimination; what Hamilton's equations say is the same."""
    module: dict = {}
    exec(as_written(derive(spec_of(text)), "python", "hamilton", dict(values_of(text).parameters)), module)
    n = len(module["COORDINATES"])
    q, v = [0.3 + 0.4 * k * k for k in range(n)], [0.1 - 0.3 * k for k in range(n)]
    a, bound = module["accelerations"](0.2, q, v), module["multipliers"](0.2, q, v)
    slopes = module["constraint_matrix"](0.2, q, v)
    for row, rate in zip(slopes, module["constraint_rates"](0.2, q, v), strict=True):
        assert sum(x * y for x, y in zip(row, a, strict=True)) == pytest.approx(rate)
    for k, (row, f) in enumerate(
        zip(module["mass_matrix"](0.2, q, v), module["force"](0.2, q, v), strict=True)
    ):
        pull = sum(one * slope[k] for one, slope in zip(bound, slopes, strict=True))
        assert sum(x * y for x, y in zip(row, a, strict=True)) == pytest.approx(f + pull)
    p = module["momenta"](0.2, q, v)
    rates = module["momentum_rates"](0.2, q, p)
    step = 1e-6
    later = [[x + step * y for x, y in zip(*pair, strict=True)] for pair in ((q, v), (v, a))]
    moved = [(x - y) / step for x, y in zip(module["momenta"](0.2 + step, *later), p, strict=True)]
    assert rates == pytest.approx(moved, rel=1e-4, abs=1e-4)


@pytest.mark.exhaustive(keep=0.45)
def test_what_hamiltons_principle_would_give_is_shown_beside_the_equations_of_motion():
    text = as_written(derive(spec_of(KNIFE)), "text", "vakonomic", {})
    assert "J*phi_ddot = -mu_edge*cos(phi)*x_dot - mu_edge*sin(phi)*y_dot   [phi]" in text
    assert "phi_ddot = 0   [phi, divided by J]" in text
    assert "unless the constraints on velocities are integrable, these are not the equations" in text
    for system, format_ in ((KNIFE, "python"), (PENDULUM, "text")):
        with pytest.raises(UsageError, match="no --f"):
            as_written(derive(spec_of(system)), format_, "vakonomic", {})


@pytest.mark.parametrize("text", [KNIFE, ROLLING_UPHILL.replace(" - max(0, x)**2", "")])
def test_it_is_the_variation_of_the_action(text):
    """Against derivatives of functions of time."""
    equations = derived(text)
    form = vakonomic_form(equations)
    t, here = equations.time, {}
    for symbol, name in zip(equations.q, equations.coordinates, strict=True):
        here[symbol] = sympy.Function(name)(t)
    for symbol, v, a in zip(equations.q, equations.v, equations.a, strict=True):
        here |= {v: here[symbol].diff(t), a: here[symbol].diff(t, 2)}
    for mu, rate in zip(form.multipliers, form.rates, strict=True):
        here |= {mu: sympy.Function(f"{mu}")(t), rate: sympy.Function(f"{mu}")(t).diff(t)}
    for k, equation in enumerate(form.equations):
        slope, own = form.lagrangian.diff(equations.v[k]), form.lagrangian.diff(equations.q[k])
        bound = sum(each.multiplier * each.slopes[k] for each in equations.constraints if each.holonomic)
        expected = slope.subs(here).diff(t) - (own + bound).subs(here)
        found = (equation.factor * (equation.left - equation.right)).subs(here)
        assert sympy.expand(found - expected).simplify() == 0


def test_a_constraint_that_can_be_integrated_gives_the_same_motion():
    """Then mu_dot is -lambda."""
    equations = derived("""
        coordinates: {x: {initial: 0}, y: {initial: 0}}
        lagrangian: x_dot**2 + y_dot**2 - y
        nonholonomic: {slope: y*x_dot + (x + 2*y)*y_dot}
        """)
    form = vakonomic_form(equations)
    (rate,), (multiplier,) = form.rates, [each.multiplier for each in equations.constraints]
    for one, other in zip(equations.equations, form.equations, strict=True):
        assert sympy.expand(other.right.xreplace({rate: -multiplier}) - one.right) == 0


@pytest.mark.exhaustive(keep=0.65)
def test_what_is_too_long_and_what_is_not_determined():
    chain, twice = derive(spec_of(CHAIN)), derive(spec_of(TWICE))
    assert chain.equations.accelerations is None
    assert "too long to print; --form matrix shows M a = f + A^T lambda" in as_written(
        chain, "text", "lagrange", {}
    )
    with pytest.raises(UsageError, match="the explicit accelerations and multipliers are too long to print"):
        as_written(chain, "text", "explicit", {})
    written = as_written(twice, "text", "explicit", {})
    assert len(twice.equations.constraints) == 1 and "which depends on the others]" in written


def test_names_of_multipliers_are_those_of_nothing_else():
    equations = derived("""
        parameters: {lambda_rod: 2}
        coordinates: {x: {initial: 0}, y: {initial: 0}}
        masses: {p: lambda_rod}
        embedding: {p: [x, y]}
        constraints: {rod: x, v_dot: y}
        """)
    assert [str(each.multiplier) for each in equations.constraints] == ["lambda_rod_", "lambda_v_dot_"]


@pytest.mark.exhaustive(keep=0)
def test_the_multiplier_of_a_quaternion():
    derivation = derive(
        spec_of("""
        parameters: {I1: 1, I2: 2, I3: 3}
        coordinates:
          {w: {initial: 1}, x: {initial: 0, velocity: 0.1}, y: {initial: 0, velocity: 1}, z: {initial: 0}}
        bodies:
          top:
            mass: 1
            inertia: [I1, I2, I3]
            position: [0, 0, 0]
            orientation: {quaternion: [w, x, y, z]}
        """)
    )
    data = as_data(derivation, "lagrange", {})
    assert data["constraints"][0]["multiplier"] == "lambda_top_norm"
    module: dict = {}
    exec(as_written(derivation, "python", "lagrange", {"I1": 1.0, "I2": 2.0, "I3": 3.0}), module)
    state = 0.0, (1, 0, 0, 0), (0, 0.1, 0.2, 0.3)
    (multiplier,) = module["multipliers"](*state)  # by Euler's theorem, as T is quadratic in the quaternion
    assert multiplier == pytest.approx(-2 * module["kinetic_energy"](*state))
    assert verify_system(derivation, {}).agrees


def test_a_constraint_that_is_not_linear_in_the_velocities():
    with pytest.raises(NotLinear, match="'speed' is not linear"):
        derived("""
            coordinates: {x: {initial: 0, velocity: 1}, y: {initial: 0}}
            masses: {p: 1}
            embedding: {p: [x, y]}
            nonholonomic: {speed: x_dot**2 + y_dot**2 - 1}
            """)


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("text", [PENDULUM, KNIFE, DRIVEN, FOUR_BAR, ROLLING_UPHILL, MASSLESS])
def test_what_is_conserved_is_what_the_engine_says(text):
    equations, residual = derived(text), residual_of(text)
    assert {each.quantity for each in equations.conserved} == {
        each.quantity for each in residual.conserved if each.quantity[0] in "hp"
    }


def test_moving_constraints_do_work():
    (changing,) = [each for each in derived(DRIVEN).changing if each.quantity == "h"]
    assert changing.because.startswith("generalized forces or friction and forces of constraint do work")
    assert "lambda_rod" in str(changing.rate)


@pytest.fixture
def patient(monkeypatch):
    """However busy the machine is, the motion is followed to its end."""
    monkeypatch.setattr(verification, "PATIENCE", 600.0)


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("text", [*SYSTEMS.values(), BALL_ON_AN_INCLINE], ids=[*SYSTEMS, "ball"])
def test_three_routes_agree_at_states_that_satisfy_the_constraints(text, patient):
    found = verify_system(derive(spec_of(text)), {})
    assert found.agrees and found.directly and found.difference > 0, str(found)
    assert found.counted["near the initial one"] == 12 and found.counted["along the motion"] == 8


@pytest.mark.exhaustive(keep=0.2)
def test_branches_are_looked_at_on_both_sides():
    found = verify_system(derive(spec_of(ROLLING_UPHILL)), {})
    assert found.counted["before a switch or pole"] and found.counted["beyond a switch or pole"]


@pytest.mark.exhaustive(keep=0.3)
def test_dependent_constraints_are_no_difference():
    derivation = derive(spec_of(TWICE))
    assert derivation.equations.degrees_of_freedom == 1
    assert verify_system(derivation, {}).agrees


LINKAGES = {
    "three cranks": """
        parameters: {m: 1.0, l: 1.0, g: 9.81}
        coordinates: {a: {initial: 0.7}, b: {initial: 0.7}, c: {initial: 0.7}}
        masses: {p: m, q: m, r: m}
        embedding: {p: [l*cos(a), l*sin(a)], q: [2 + l*cos(b), l*sin(b)], r: [4 + l*cos(c), l*sin(c)]}
        potential: m*g*(p.y + q.y + r.y)
        constraints: {pq: "dot(p - q, p - q) - 4", qr: "dot(q - r, q - r) - 4", pr: "dot(p - r, p - r) - 16"}
        """,
    "a swing": """
        parameters: {m: 1.0, l: 1.0, g: 9.81}
        coordinates: {a: {initial: 0.7}, b: {initial: 0.7}, x: {}, y: {}}
        masses: {p: m, q: m}
        embedding: {p: [l*cos(a), l*sin(a)], q: [x, y]}
        potential: m*g*(p.y + q.y)
        constraints:
          x: 2 + l*cos(b) - x
          y: l*sin(b) - y
          bar: dot(q - p, q - p) - 4
          middle: (x + l*cos(a))/2 - 1 - l*cos((a + b)/2)
        """,
    "a plane pendulum": """
        parameters: {m: 1.0, l: 1.0, g: 9.81}
        coordinates: {x: {initial: 0.6}, y: {initial: 0}, z: {initial: -0.8}}
        masses: {p: m}
        embedding: {p: [x, y, z]}
        potential: m*g*z
        constraints: {a: dot(p, p) - l**2, b: y, c: (dot(p, p) - l**2)*(1 + x)}
        """,
}


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize("text", LINKAGES.values(), ids=LINKAGES)
def test_constraints_that_depend_on_others_only_where_they_hold(text, patient):
    """Elsewhere they are independent, so that a formal solution exists: it is 0/0 where the motion is."""
    derivation = derive(spec_of(text))
    assert derivation.equations.degrees_of_freedom == 1 and len(derivation.equations.redundant) == 1
    found = verify_system(derivation, {})
    assert found.agrees and found.counted["along the motion"] == 8, str(found)


@pytest.mark.exhaustive(keep=0.3)
def test_states_after_an_event_has_changed_a_length_satisfy_the_constraints_again(patient):
    text = """
parameters: {l: 1}
coordinates: {r: {initial: l}, th: {initial: 1}}
masses: {b: 1}
positions: {b: [r*sin(th), -r*cos(th)]}
potential: 9.81*b.y
constraints: {rope: r - l}
events: {winch: {when: th, action: {set: {l: 0.9*l}}}}
solve: {stop: 10}
"""
    found = verify_system(derive(spec_of(text)), {})
    assert found.agrees and found.counted["along the motion"] == 8, str(found)


INVERSOR = """
parameters: {L: 3, s: 1.5, a: 1.9, bx: (L**2 - s**2 + a**2)/(2*a)}
coordinates:
  x: {initial: a}
  u: {initial: bx}
  v: {initial: sqrt(L**2 - bx**2)}
  w: {initial: bx}
  z: {initial: -sqrt(L**2 - bx**2)}
  p: {initial: (L**2 - s**2)/a}
  q: {initial: 0}
masses: {A: 1, B: 1, C: 1, P: 1}
positions: {A: [x, 0], B: [u, v], C: [w, z], P: [p, q]}
potential: 9.81*(B.y + C.y + P.y) + 2*x**2
constraints:
  ob: norm(B) - L
  oc: norm(C) - L
  ab: norm(A - B) - s
  ac: norm(A - C) - s
  pb: norm(P - B) - s
  pc: norm(P - C) - s
"""


@pytest.mark.exhaustive(keep=0.25)
def test_states_in_which_a_linkage_is_folded_are_not_compared(patient):
    """Where B is at C, P turns freely, and the accelerations are 0/0."""
    found = verify_system(derive(spec_of(INVERSOR)), {})
    assert found.agrees, str(found)
    assert found.counted["near the initial one"] == 12


def test_states_are_moved_to_the_constraints():
    spec = spec_of(ROLLING_UPHILL)
    moved = admissible(
        spec, State(dict(values_of(ROLLING_UPHILL).parameters), 0.3, (0.4, 1.0, 0.2), (1, 2, 3))
    )
    there = directly(spec, moved.parameters, moved.t, moved.q, moved.v, (0, 0, 0), (0, 0))
    assert max(map(abs, there.constraints)) < 1e-14
    assert (
        admissible(
            spec_of(PENDULUM.replace("- l**2", "+ l**2")),
            State({"m": 1.0, "l": 1.0, "g": 1.0}, 0, (1, 1), (0, 0)),
        )
        is None
    )


def spoiled(equations, what):
    """The equations with one sign wrong."""
    (one, *others) = equations.constraints
    if what == "slope":
        one = replace(one, slopes=(-one.slopes[0], *one.slopes[1:]))
    elif what == "rate":
        right = -one.rate
        one = replace(one, derived_rate=lambda: right)
    elif what == "constraint":
        one = replace(one, expression=-one.expression + 2 * equations.q[0])
    elif what == "multiplier":
        return replace(equations, multipliers=(-equations.multipliers[0],))
    elif what == "equation":
        first, *rest = equations.equations
        wrong = replace(first, right=-first.right)
        return replace(equations, equations=(wrong, *rest))
    return replace(equations, constraints=(one, *others))


@pytest.mark.exhaustive(keep=0.6)
@pytest.mark.parametrize("what", ["nothing", "slope", "rate", "constraint", "multiplier", "equation"])
def test_a_wrong_sign_is_seen(what):
    values = values_of(PENDULUM)
    start = State(dict(values.parameters), 0.0, tuple(values.q), tuple(values.v))
    spec, equations = spec_of(PENDULUM), spoiled(derived(PENDULUM), what)

    def direct(state, a, multipliers, exact):
        return directly(spec, state.parameters, state.t, state.q, state.v, a, multipliers, exact)

    compiled = compiled_values(residual_of(PENDULUM))
    for route in (None, direct):
        found = verify(equations, compiled, start, (), route, lambda state: admissible(spec, state))
        assert found.agrees == (what == "nothing"), str(found)


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize("sign", [1, -1])
def test_a_wrong_sign_of_printed_and_compiled_multipliers_is_seen_by_the_third_route(sign):
    """Both take the constraint's force with the other sign."""
    values = values_of(PENDULUM)
    start = State(dict(values.parameters), 0.0, tuple(values.q), tuple(values.v))
    spec, wrong = (
        spec_of(PENDULUM),
        PENDULUM.replace("rod: x**2", "rod: x**2" if sign > 0 else "rod: 2*x*y - x**2"),
    )

    def direct(state, a, multipliers, exact):
        return directly(spec, state.parameters, state.t, state.q, state.v, a, multipliers, exact)

    compiled = compiled_values(residual_of(wrong))
    found = verify(derived(wrong), compiled, start, (), direct, lambda state: admissible(spec, state))
    assert found.agrees == (sign > 0)
    assert found.agrees or found.routes == DIRECT


@pytest.mark.exhaustive(keep=0)
def test_high_powers_of_sines_and_cosines_are_shortened():
    """A rolling disc: the determinant is a constant times sin(theta)**2, and comes as a longer sum."""
    derivation = derive(
        spec_of("""
        parameters: {m: 1, r: 0.5, g: 9.81}
        coordinates:
          {x: {initial: 0}, y: {initial: 0}, phi: {initial: 0}, theta: {initial: 1}, psi: {initial: 0}}
        bodies:
          disc:
            mass: m
            solid: {disc: r}
            position: [x, y, r*sin(theta)]
            orientation: {euler: [phi, theta, psi], sequence: zxz}
        potential: m*g*disc.z
        nonholonomic:
          along: disc.at(-r*sin(psi), -r*cos(psi), 0).vx
          across: disc.at(-r*sin(psi), -r*cos(psi), 0).vy
        """)
    )
    text = as_written(derivation, "text", "explicit", {})
    assert "phi_ddot = 2*theta_dot*psi_dot/sin(theta)\n" in text
    assert "theta_ddot = -sin(theta)*cos(theta)*phi_dot**2 - 6*sin(theta)*phi_dot*psi_dot/5\n" in text
    assert verify_system(derivation, {}).agrees
