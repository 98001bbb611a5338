"""What is printed of arms in relative angles, whose places are sums of functions of sums."""

from __future__ import annotations

import random

import pytest
import sympy

from lagrange_cli.symbolic.indexed.conditions import Loop
from lagrange_cli.symbolic.indexed.members import Loops, Summed, member, renamed
from lagrange_cli.symbolic.indexed.whole import named, number
from tests.families.test_relative_joints import ANGLES, FORCES, MASSES, text
from tests.symbolic.families.test_chains import holds, lines_of

pytestmark = pytest.mark.usefixtures("however_small")


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize("masses", MASSES)
@pytest.mark.parametrize("angles", ANGLES)
def test_what_is_printed_is_what_the_file_says(angles: str, masses: str, pytestconfig: pytest.Config) -> None:
    chance = random.Random(f"{pytestconfig.option.seed} {angles} {masses}")
    holds(text(3, angles, masses, "driven", chance.choice([*FORCES]), 0.5))


def test_an_index_is_not_caught_by_a_sum_within() -> None:
    """k called j in the sum of cos(phi[j] + a[k]) over j < k + 1."""
    body = sympy.cos(member("phi", [named("j")]) + member("a", [named("k")]))
    inner = Summed(body, Loops([Loop("j", number(0), named("k") + number(1))]))
    found = renamed(sympy.cos(inner), {"k": named("j")}, {"j": (0, 5)})
    (changed,) = found.atoms(Summed)
    (loop,) = changed.loops
    assert loop.index != "j"
    assert loop.stop == named("j") + number(1)
    assert changed.body == sympy.cos(member("phi", [named(loop.index)]) + member("a", [named("j")]))


def test_a_sum_in_a_sum_of_the_same_index_is_a_double_sum() -> None:
    """sum_i b[i] (sum_i cos(phi[i])): b has the index of the sum around."""
    loops = Loops([Loop("i", number(0), number(3))])
    inner = Summed(sympy.cos(member("phi", [named("i")])), loops)
    found = Summed(member("b", [named("i")]) * inner, loops)
    (outer, other) = (one.index for one in found.loops)
    assert outer == "i" != other
    assert found.body == member("b", [named("i")]) * sympy.cos(member("phi", [named(other)]))


@pytest.mark.exhaustive(keep=0.15)
def test_an_arm_is_that_of_a_textbook() -> None:
    """One sum of cos(th[k] - th[n]) for all momenta, with the first link like all others, and no index called
    like the length l."""
    given = """
sizes: {N: 3}
parameters: {m: 1, l: 0.2, g: 9.81}
coordinates: {"phi[i in range(N)]": {initial: 0.1}}
definitions:
  th[0]: phi[0]
  th[i in range(1, N)]: th[i - 1] + phi[i]
  x[0]: l*cos(th[0])
  x[i in range(1, N)]: x[i - 1] + l*cos(th[i])
  y[0]: l*sin(th[0])
  y[i in range(1, N)]: y[i - 1] + l*sin(th[i])
masses: {"b[i in range(N)]": m}
embedding: {"b[i in range(N)]": "[x[i], y[i]]"}
potential: sum(m*g*b[i].y for i in range(N))
"""
    holds(given)
    lines = "\n".join(lines_of(given))
    assert "p_phi[i] = m*l**2*sum(cos(" in lines
    assert "p_phi[0]" not in lines
    assert "for l in" not in lines
