"""The count of what deriving a system takes, and what it is counted for."""

from __future__ import annotations

import pytest
import sympy
from sympy.core.basic import Basic

from lagrange_cli import limits
from lagrange_cli.errors import TooLarge
from lagrange_cli.expression.graph import Graph
from lagrange_cli.mechanics import formulations
from lagrange_cli.mechanics.derive import derive
from lagrange_cli.symbolic.work import check_size, counting, size_of
from tests.support.motion import model_of


def test_work_is_counted_up_to_its_limit(monkeypatch):
    monkeypatch.setenv(limits.VARIABLE, "work=100")
    work = limits.Work()
    work.charge(100)
    with pytest.raises(TooLarge, match="more than 100 steps"):
        work.charge(1)


def test_an_attempt_that_takes_too_much_is_given_up_alone(monkeypatch):
    monkeypatch.setenv(limits.VARIABLE, "work=100")
    work = limits.Work()
    assert work.attempt(10, lambda: work.charge(11)) is None
    assert work.attempt(10, lambda: "done") == "done"
    work.charge(80)
    with pytest.raises(TooLarge):
        work.charge(20)


def test_the_work_of_a_graph_grows_with_what_is_built():
    """A product of n sums and its derivative: n terms of n factors."""
    spent = []
    for count in (50, 100):
        graph = Graph()
        x = graph.symbol("x")
        graph.diff(graph.product([(x + float(i), 1) for i in range(count)]), x)
        spent.append(graph.work.spent)
    assert 3 < spent[1] / spent[0] < 5


def test_a_formulation_that_takes_too_much_is_left_out(monkeypatch):
    model = model_of("spherical_pendulum")
    assert derive(model).formulation == "kinetic energy"
    monkeypatch.setattr(formulations, "PATIENCE", 0)
    monkeypatch.setattr(formulations, "LEAST_ATTEMPT", 10)
    assert derive(model).formulation == "embedding"


@pytest.mark.exhaustive(keep=0.55)
def test_what_sympy_makes_is_counted(monkeypatch):
    monkeypatch.setenv(limits.VARIABLE, "work=100000")
    x, plain = sympy.Symbol("x"), Basic.__new__
    with pytest.raises(TooLarge, match="steps of work"), counting():
        sympy.expand((1 + x) ** 5000)
    assert Basic.__new__ is plain
    sympy.expand((1 + x) ** 500)


def test_a_size_counts_what_is_shared_as_often_as_it_occurs():
    x = sympy.Symbol("x")
    for _ in range(40):
        x = sympy.sin(x) + sympy.cos(x)
    assert size_of(x) == 2**42 - 3  # s -> 3 + 2 s, from 1
    with pytest.raises(TooLarge, match="terms and factors"):
        check_size(x)
