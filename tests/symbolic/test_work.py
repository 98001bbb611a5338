"""Work is counted where it is done: no part of sympy keeps busy without a step being counted."""

import sys

import pytest
import sympy

from lagrange_cli.errors import TooLarge
from lagrange_cli.expression.symbolic import SympyAlgebra
from lagrange_cli.limits import Work
from lagrange_cli.model.build import build_model
from lagrange_cli.spec.read import read_spec
from lagrange_cli.symbolic import grouping, kinks
from lagrange_cli.symbolic.derive import derive_equations
from lagrange_cli.symbolic.grouping import tidy
from lagrange_cli.symbolic.latex import as_latex
from lagrange_cli.symbolic.layouts import as_text
from lagrange_cli.symbolic.order import Order, Role
from lagrange_cli.symbolic.work import VISITS, counting
from tests.support.systems import derived

CALLS_A_STEP = 20
"""Calls of functions, Python's and C's, that take about a microsecond and a half."""
PARTICLE = """
parameters: {a: 1, b: 2, c: 3, d: 4}
coordinates: {x: {initial: 1}, y: {initial: 2}}
masses: {bead: a}
embedding: {bead: [x, y]}
"""
ARM = """
sizes: {N: 3}
coordinates: {"q[i in range(N)]": {initial: 0.1*i}}
masses: {"b[i in range(N)]": 1}
embedding:
  b[i in range(N)]: [sum(sin(q[j]) for j in range(i + 1)), sum(cos(q[j]) for j in range(i + 1))]
potential: sum(b[i].y for i in range(N))
"""
FIELD = """
sizes: {N: 4}
coordinates: {"x[i in range(N)]": {initial: 0.1*i}}
lagrangian: sum(x_dot[i]**2/2 for i in range(N)) - sum(1/sqrt((x[i]-x[j])**2+1) for i in range(N) for j in range(i))
"""  # noqa: E501
SYSTEMS = {
    "nested functions": PARTICLE + f"potential: {'tanh(x + ' * 2}x{')' * 2}\n",
    "nested roots": PARTICLE + f"potential: {'sqrt(x*y + ' * 5}x{')' * 5}\n",
    "a long sum": PARTICLE + f"potential: {' + '.join(f'sin({i}*x + y)' for i in range(1, 9))}\n",
    "a long product": PARTICLE + f"potential: {'*'.join(f'(x + {i}*y)' for i in range(1, 9))}\n",
    "parameters": PARTICLE + "potential: (a + b)**2*(b + 2*c)**2*(c + d)*x\n",
    "numbers": PARTICLE + f"potential: x*{'sin(1 + sqrt(' * 3}2{'))' * 3}\n",
    "an arm": ARM,
    "a field": FIELD,
}


@pytest.mark.exhaustive(keep=0.55)
@pytest.mark.parametrize("system", SYSTEMS.values(), ids=SYSTEMS)
def test_no_work_is_left_uncounted(system):
    spec, work, calls = read_spec(system, "system.yaml"), Work(), 0

    def count(frame, event, argument):
        nonlocal calls
        calls += event in ("call", "c_call")

    with counting(work):
        sys.setprofile(count)
        try:
            equations = derive_equations(build_model(spec, SympyAlgebra()))
            as_text(equations, "lagrange")
            as_latex(equations, "lagrange")
        finally:
            sys.setprofile(None)
    assert calls < CALLS_A_STEP * work.spent


def test_sympy_is_left_as_it_was():
    before = [vars(owner)[name] for owner, name, _ in VISITS]
    with pytest.raises(TooLarge), counting(work := Work()):
        work.most = 100
        sympy.cos(sympy.Symbol("x") ** 2 + 1)
    assert [vars(owner)[name] for owner, name, _ in VISITS] == before


def test_polynomials_of_parameters_are_factored_where_that_is_quick(monkeypatch):
    """A high degree takes minutes: it is left as it is."""
    factored = []
    monkeypatch.setattr(sympy, "factor", lambda sum_: factored.append(sum_) or sum_)
    derived(PARTICLE + "potential: (a**2 + 2*a*b + b**2)*x + (a**40*b**20 + c**31*d**30 + b*c + d**3)*y\n")
    a, b = sympy.symbols("a b")
    assert factored and all(sum_.free_symbols == {a, b} for sum_ in factored)


def test_fractions_of_high_degree_are_not_cancelled():
    """The greatest common divisor of such sums takes minutes."""
    coupled = (
        "(x**30*y**31 + x**7*y**40 + 1)*x_dot**2 + (y**33*x**30 + x*y + 2)*y_dot**2 + x**31*y**29*x_dot*y_dot"
    )
    with counting(work := Work()):
        found = derived(f"coordinates: [x, y]\nlagrangian: {coupled} - x**35*y**30 - x*y\n")
    assert found.accelerations is not None and work.spent < 10**6


def test_the_sign_of_a_maximum_is_examined_once(monkeypatch):
    """The same maxima occur in many terms: as do their opposites."""
    examined = []
    count = kinks.minus_signs
    monkeypatch.setattr(kinks, "minus_signs", lambda one: examined.append(one) or count(one))
    with counting():
        derived(
            "coordinates: [x, y]\nlagrangian: x_dot**2*(1 + max(0, x)*y)/2 + y_dot**2*(2 + max(0, -x))/2\n"
        )
    assert examined and len(examined) == len(set(examined))


def test_what_is_too_much_work_to_group_is_printed_as_it_is(monkeypatch):
    x, y = sympy.symbols("x y")
    order = Order({x: (Role.COORDINATE, 0), y: (Role.COORDINATE, 1)})
    long = sympy.Add(*((x + k) * (y + k**2) for k in range(1, 20)))
    with counting():
        grouped = tidy(long, order)
    monkeypatch.setattr(grouping, "MOST_WORK", 100)
    with counting(work := Work()):
        assert tidy(long, order) == long != grouped
    assert 100 < work.spent < 1000
    assert (long - grouped).expand() == 0
