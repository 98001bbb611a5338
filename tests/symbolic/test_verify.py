"""``--verify`` sees a wrong equation and forgives rounding."""

import math

import mpmath
import pytest

from lagrange_cli.errors import UsageError
from lagrange_cli.expression.build import build
from lagrange_cli.expression.parse import parse
from lagrange_cli.expression.symbolic import SympyAlgebra
from lagrange_cli.expression.syntax import ExpressionError
from lagrange_cli.integrate.single_state import compiled_values
from lagrange_cli.model.build import build_model
from lagrange_cli.run.equations import derive
from lagrange_cli.spec.values import resolve_values
from lagrange_cli.symbolic.derive import derive_equations
from lagrange_cli.symbolic.direct import directly
from lagrange_cli.symbolic.measured import Measured, MeasuredAlgebra, solve_measured
from lagrange_cli.symbolic.printed import evaluate, read_back
from lagrange_cli.symbolic.source import as_python
from lagrange_cli.symbolic.states import State, sides
from lagrange_cli.symbolic.verify import BOUND, DIRECT, verify
from tests.support.motion import model_of, residual_of, values_of
from tests.support.motion import spec_of as system_of
from tests.support.systems import NAMES, derived, equations_of, spec_of


def stand_in(equations, change=lambda name, value: value):
    """What a compiled program would give, from the Python module; ``change`` may spoil it."""
    module: dict = {}
    exec(as_python(equations, "lagrange", {}), module)

    def values(parameters, t, q, v):
        known = dict(zip(equations.parameters, parameters, strict=True))
        a = [change("a", x) for x in module["accelerations"](t, q, v, known)]
        p = [change("p", x) for x in module["momenta"](t, q, v, known)]
        h = change("h", module["energy_function"](t, q, v, known))
        bound = {"multipliers": (), "constraints": ()}
        if equations.constraints:
            bound = {name: [change(name, x) for x in module[name](t, q, v, known)] for name in bound}
        return a, p, h, bound["multipliers"], bound["constraints"]

    return values


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("name", NAMES)
def test_double_precision_agrees(name):
    values = resolve_values(spec_of(name))
    equations = equations_of(name)
    found = verify(
        equations, stand_in(equations), State(values.parameters, 0.0, tuple(values.q), tuple(values.v))
    )
    assert found.agrees and 0 < found.difference < 1e-15
    assert "agree" in str(found)


WALLS = """
parameters: {k: 30, mu: 0.3, a: 0.2}
coordinates: {x: {initial: 0.1}, y: {initial: 0.2, velocity: 0.1}}
masses: {p: 1 + a, q: where(a > 0, 1, 2)}
embedding: {p: [x, abs(y) + x], q: [max(x, y/2), x*y]}
potential:
  walls: k*max(0, x - a)**2/2 + min(x, y)*a + sqrt(y**2)**3
  inside: where(0 < x <= 1 and not y > x, x*(y - x)*(1 - x), 0)
generalized_forces: {x: -mu*sign(x_dot), y: "where(t < 1/2 or x > y, x_dot, y)"}
dissipation: abs(x_dot)
"""


KINKED = """
parameters: {k: 0.3}
definitions: {u: "max(k + cosh(x), 6*k, 0.2**x)"}
coordinates: {x: {initial: -1, velocity: 0.1}, y: {initial: 0.1}}
masses: {p: 1, q: 1}
embedding: {p: [y, sqrt(u)], q: [x, y]}
potential: (1/(1 + t)*y/u)**3
"""


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("text", [WALLS, KINKED])
def test_printed_and_compiled_forces_agree_on_both_sides_of_every_kink(text):
    """The compiled program as well as the Python module."""
    values = values_of(text)
    equations = derive_equations(build_model(system_of(text), SympyAlgebra()))
    for compiled in (compiled_values(residual_of(text)), stand_in(equations)):
        found = verify(equations, compiled, State(values.parameters, 0.0, tuple(values.q), tuple(values.v)))
        assert found.agrees, str(found)


FADING = """
parameters: {k: 2, a: 0.7}
coordinates: {x: {initial: 150, velocity: 0.1}}
masses: {p: 1}
positions: {p: x}
potential: -k/cosh(a*x)**2
"""


def test_a_force_that_has_faded_agrees_though_its_exponentials_are_held():
    """Compiled, it ends where its argument is 80 (``saturation``); as printed, it fades further, to 1e-91."""
    values = values_of(FADING)
    equations = derive_equations(build_model(system_of(FADING), SympyAlgebra()))
    start = State(values.parameters, 0.0, tuple(values.q), tuple(values.v))
    compiled = compiled_values(residual_of(FADING))
    found = verify(equations, compiled, start)
    assert found.agrees, str(found)

    def spoiled(*given):
        a, p, h, *rest = compiled(*given)
        return a * 1.01, p, h, *rest

    assert not verify(equations, spoiled, start).agrees


def test_what_is_complex_is_not_compared():
    with mpmath.workdps(20):
        for text in ("max(x**0.5, 1)", "where(x**0.5 > 1, 1, 2)"):
            with pytest.raises((ArithmeticError, ExpressionError)):
                measured(text, x=-2.0)


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("quantity", ["a", "p", "h"])
def test_a_small_mistake_is_seen(quantity):
    values = resolve_values(spec_of("double_pendulum"))
    equations = equations_of("double_pendulum")
    spoiled = stand_in(equations, lambda name, x: x * (1 + 1e-9) if name == quantity else x)
    found = verify(equations, spoiled, State(values.parameters, 0.0, tuple(values.q), tuple(values.v)))
    assert not found.agrees and found.difference > BOUND
    assert "DIFFER" in str(found)
    assert found.quantity == {"a": "theta1_ddot", "p": "p_theta1", "h": "h"}[quantity] or quantity != "h"


def test_nan_is_no_agreement():
    values = resolve_values(spec_of("pendulum"))
    spoiled = stand_in(equations_of("pendulum"), lambda name, x: math.nan)
    found = verify(
        equations_of("pendulum"), spoiled, State(values.parameters, 0.0, tuple(values.q), tuple(values.v))
    )
    assert not found.agrees


def test_states_outside_the_domain_are_drawn_again():
    system = "parameters: {k: 1}\ncoordinates: {x: {initial: 0.2}}\nlagrangian: x_dot**2/2 + k*log(x)\n"
    equations = derived(system)
    assert verify(equations, stand_in(equations), State({"k": 1.0}, 0.0, (0.2,), (0.0,))).agrees


def test_states_with_a_complex_mass_are_drawn_again():
    """Beyond the speed of light, where this failed."""
    equations = derived("coordinates: {x: {initial: 0}}\nlagrangian: -sqrt(1 - x_dot**2) - x**2/2\n")
    assert verify(equations, stand_in(equations), State({}, 0.0, (0.0,), (0.95,))).agrees


def test_no_state_at_all():
    equations = derived("coordinates: {x: {initial: 0.2}}\nlagrangian: x_dot**2/2 + log(x)\n")
    with pytest.raises(UsageError, match="no finite values at random states"):
        verify(equations, stand_in(equations), State({}, 0.0, (-5.0,), (0.0,)))


WALL = """
parameters: {{k: 1000}}
coordinates: {{x: {{initial: 0.3, velocity: 0.1}}}}
lagrangian: x_dot**2/2 - x**2/2 - k*({kink})**2
solve: {{stop: 10}}
"""
KINKS = ["(x - 5 + sqrt((x - 5)**2))/2", "max(0, x - 5)", "where(x > 5, x - 5, 0)"]


def directly_of(spec):
    return lambda state, a, bound, exact: directly(
        spec, state.parameters, state.t, state.q, state.v, a, bound, exact
    )


@pytest.mark.parametrize("kink", KINKS)
def test_states_lie_on_both_sides_of_a_branch(kink):
    """The motion does not come there, nor do random states near its start."""
    text = WALL.format(kink=kink)
    start = State({"k": 1000.0}, 0.0, (0.3,), (0.1,))
    found = sides(model_of(text), [start])
    assert any(state.q[0] < 5 for state in found) and any(state.q[0] > 5 for state in found)
    assert {state.where for state in found} == {"before a switch or pole", "beyond a switch or pole"}


@pytest.mark.exhaustive(keep=1.5)
@pytest.mark.parametrize("kink", KINKS)
@pytest.mark.parametrize("lost", ["nothing", "by the compiler", "by both"])
def test_a_force_that_is_lost_beyond_a_branch_is_missed(kink, lost):
    text = WALL.format(kink=kink)
    right, wrong = derived(text), derived(WALL.format(kink="0*x"))
    start = State({"k": 1000.0}, 0.0, (0.3,), (0.1,))
    others = sides(model_of(text), [start])
    printed, compiled = (wrong if lost == "by both" else right), (right if lost == "nothing" else wrong)
    found = verify(printed, stand_in(compiled), start, others, directly_of(system_of(text)))
    assert found.agrees == (lost == "nothing")
    assert (found.routes == DIRECT) == (lost == "by both") or found.agrees
    assert verify(printed, stand_in(compiled), start).agrees


SMOOTH = (
    "sin(x) cos(x) tan(x) asin(x) acos(x) atan(x) sinh(x) cosh(x) tanh(x) exp(x) log(x) sqrt(x) x**3 x**-2 "
    "1/x x**x x**1.5 2**x atan2(x,2) atan2(2,x) atan2(x-1,-x)"
)
KINKED = "abs(x-1) sign(x-1)*(x-1) max(x,x**2) min(x,x**2) where(x<y,x**2,x*y)"


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize("text", [*SMOOTH.split(), *KINKED.split()])
def test_direct_differentiation_is_that_of_the_printed_equations(text):
    """With the function in T, where it may stand there, in U and in a force."""
    spec = system_of(f"""
        parameters: {{m: 1.5}}
        coordinates: {{x: {{initial: 0.4}}, y: {{initial: 0.7}}}}
        masses: {{ball: m}}
        embedding: {{ball: [x + y*t, y + ({"x**2" if text in KINKED.split() else text})]}}
        potential: ({text})*y
        forces: {{ball: [0.1*y_dot, -0.2*ball.vx]}}
        dissipation: ({text})**2*y_dot**4
        """)
    equations = derive(spec).equations
    state = {"x": 0.4, "y": 0.7, "x_dot": -0.3, "y_dot": 1.1, "t": 0.2, "m": 1.5}
    with mpmath.workdps(30):
        known = {name: Measured(mpmath.mpf(value), abs(mpmath.mpf(value))) for name, value in state.items()}
        right = dict(evaluate(equations, read_back(equations), known).all)
        a = [right["x_ddot"].value, right["y_ddot"].value]
        for exact, within in ((False, 1e-11), (True, 1e-24)):
            found = directly(spec, {"m": 1.5}, 0.2, (0.4, 0.7), (-0.3, 1.1), a, (), exact)
            assert max(map(abs, found.residual)) < within
            assert abs(found.momenta[1] - right["p_y"].value) < within
            assert abs(found.h - right["h"].value) < within


def measured(text: str, **values: float) -> Measured:
    known = {name: Measured(mpmath.mpf(value), abs(mpmath.mpf(value))) for name, value in values.items()}
    result: Measured = build(parse(text), known.__getitem__, MeasuredAlgebra())
    return result


def test_cancellation_raises_the_scale_and_not_the_value():
    difference = measured("x - y", x=1.0, y=1.0 - 2.0**-40)
    assert difference.value == 2.0**-40
    assert difference.scale == pytest.approx(2)


SHAPES = (
    "sin(x) cos(x) tan(x) asin(x) acos(x) atan(x) sinh(x) cosh(x) tanh(x) exp(x) log(x) sqrt(x) "
    "x**3 x**-2 1/x x**x atan2(x,2) atan2(2,x)"
)


@pytest.mark.parametrize("text", SHAPES.split())
def test_a_scale_covers_what_a_change_of_the_argument_does(text):
    here, there = measured(text, x=0.3), measured(text, x=0.3 * (1 + 1e-6))
    assert abs(here.value) <= here.scale
    assert abs(there.value - here.value) <= 1.001e-6 * here.scale


def test_solving_a_matrix():
    entry = Measured(mpmath.mpf(2), mpmath.mpf(2))
    zero = Measured(mpmath.mpf(0), mpmath.mpf(0))
    one, two = solve_measured([[entry, zero], [zero, entry]], [entry, zero])
    assert (one.value, one.scale, two.value, two.scale) == (1, 2, 0, 0)


def test_near_a_singular_mass_matrix_the_scale_is_that_of_solving():
    """The printed accelerations of a top are harmless where M, which the compiled side solves, is not."""
    equations = derived(
        """
        parameters: {A: 1, C: 2}
        coordinates: {phi: {initial: 0}, theta: {initial: 0}, psi: {initial: 0}}
        lagrangian: A/2*(theta_dot**2 + phi_dot**2*sin(theta)**2) + C/2*(psi_dot + phi_dot*cos(theta))**2
        """
    )
    state = {"phi": 0.1, "theta": 1e-4, "psi": 0.2, "phi_dot": 1.0, "theta_dot": 1.0, "psi_dot": 1.0}
    known = {
        name: Measured(mpmath.mpf(x), mpmath.mpf(x)) for name, x in (state | {"A": 1, "C": 2, "t": 0}).items()
    }
    measured_values = dict(evaluate(equations, read_back(equations), known).all)
    phi = measured_values["phi_ddot"]
    assert phi.scale > 1e6 * abs(phi.value)


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("force", ["where(x_dot > 0, -0.3, 0.5)", "where(t > 1, 1, 0)", "max(0, x_dot)"])
def test_forces_are_not_compared_where_they_have_a_jump_or_a_kink(force):
    """There friction may hold the motion, and the printed force has the value of one side."""
    text = "coordinates: {x: {initial: 0.1}}\nlagrangian: x_dot**2/2\n"
    text += f"generalized_forces: {{x: '{force}'}}\n"
    compiled, direct = compiled_values(residual_of(text)), directly_of(system_of(text))
    others = [State({}, 1.0, (0.1,), (0.0,), "at the jump"), State({}, 1.1, (0.1,), (0.2,), "beyond it")]
    found = verify(derived(text), compiled, State({}, 0.0, (0.1,), (0.0,)), others, direct)
    assert found.agrees and found.counted == {"near the initial one": 12, "beyond it": 1}
