"""Equations of the shipped systems and of system files written in a test; and random states of them."""

from __future__ import annotations

import random
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from textwrap import dedent

import mpmath
import sympy

from lagrange_cli.errors import UsageError
from lagrange_cli.expression.symbolic import SympyAlgebra
from lagrange_cli.expression.symbolic_switches import Largest, Switch
from lagrange_cli.model.build import build_model
from lagrange_cli.model.model import Model
from lagrange_cli.run.reactions import with_reactions
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.spec import Spec
from lagrange_cli.symbolic.derive import derive_equations
from lagrange_cli.symbolic.equations import Equations
from lagrange_cli.symbolic.notations import identifiers
from tests.support.command import SYSTEMS
from tests.support.motion import NAMES as NAMES

SIZES = {
    "chain": {"N": "2"},
    "n_pendulum": {"N": "2"},
    "fpu_chain": {"N": "2", "modes": "2"},
    "lattice": {"N": "3", "M": "1"},
    "newtons_cradle": {"N": "2"},
    "solar_system": {"N": "3"},
}
"""How many members the families have: few enough for every form of the equations to be written out."""


@cache
def spec_of(name: str) -> Spec:
    """A shipped system."""
    return read_spec((SYSTEMS / f"{name}.yaml").read_bytes(), f"{name}.yaml", SIZES.get(name))


@cache
def model_of(name: str) -> Model[sympy.Expr]:
    """Its model over sympy."""
    return build_model(spec_of(name), SympyAlgebra())


@cache
def equations_of(name: str) -> Equations:
    """Its equations."""
    return derive_equations(model_of(name))


@cache
def equations_with(name: str, form: str) -> Equations:
    """Its equations with what a form needs besides, if there is such."""
    equations = equations_of(name)
    if form == "reactions":
        with suppress(UsageError):
            return with_reactions(spec_of(name), equations)
    return equations


def derived(text: str) -> Equations:
    """The equations of a system file."""
    spec = read_spec(dedent(text), "system.yaml")
    return derive_equations(build_model(spec, SympyAlgebra()))


def renamed(equations: Equations, value: sympy.Expr) -> sympy.Expr:
    """An expression with its symbols called as they are where only identifiers may stand."""
    names = identifiers(map(str, equations.order.ranks))
    return value.xreplace({symbol: sympy.Symbol(names[str(symbol)]) for symbol in value.free_symbols})


def same(left: sympy.Expr, right: sympy.Expr | str) -> bool:
    """Whether two expressions are equal: proved on both sides of every switch, by writing sines and cosines
    as rational functions of the half angle's tangent, which leaves a polynomial that must be zero. Roots
    count as unknowns."""
    return all(map(vanishes, on_each_side(left - expression(right))))


def on_each_side(value: sympy.Expr) -> Iterator[sympy.Expr]:
    """An expression on either side of each maximum of two: there is none in what is yielded, and no
    ``where`` by their difference."""
    found = next(iter(value.atoms(Largest)), None)
    if found is None:
        yield value
        return
    first, second = found.args
    for taken, other in ((first, second), (second, first)):
        sides = {found: taken}
        for switch in value.atoms(Switch):
            for branch, positive in ((1, taken - other), (2, other - taken)):
                if sympy.expand(switch.args[0] - positive) == 0:
                    sides[switch] = switch.args[branch]
        yield from on_each_side(value.xreplace(sides))


def vanishes(difference: sympy.Expr) -> bool:
    """Whether a polynomial in sines, cosines and roots is 0."""
    powers = {one for one in difference.atoms(sympy.Pow) if one.exp.is_Rational and not one.exp.is_Integer}
    bases = {one: sympy.expand(one.base) for one in powers}
    roots = {base: sympy.Dummy() for base in bases.values()}
    difference = difference.xreplace({one: roots[base] ** (2 * one.exp) for one, base in bases.items()})
    difference = sympy.expand_trig(difference)
    halves = {wave.args[0]: sympy.Dummy() for wave in difference.atoms(sympy.sin, sympy.cos)}
    rational = {sympy.sin(x): 2 * u / (1 + u**2) for x, u in halves.items()}
    rational |= {sympy.cos(x): (1 - u**2) / (1 + u**2) for x, u in halves.items()}
    numerator, _ = sympy.fraction(sympy.together(difference.subs(rational)))
    return sympy.expand(numerator) == 0


def expression(text: sympy.Expr | str) -> sympy.Expr:
    """An expression read by sympy, every name in it a plain symbol."""
    if not isinstance(text, str):
        return text
    names = {
        name: sympy.Symbol(name) for name in ("S", "N", "I", "E", "O", "Q", "C", "beta", "gamma", "zeta")
    }
    return sympy.sympify(text, locals=names)


def agree_at_random(left: sympy.Expr, right: sympy.Expr, digits: int = 25) -> bool:
    """Whether two expressions have the same values, to ``digits`` digits, at random points away from zero."""
    generator = random.Random(1)
    symbols = sorted(left.free_symbols | right.free_symbols, key=str)
    switches = {"where": lambda u, above, below, at: above if u > 0 else below}
    both = sympy.lambdify(symbols, [left, right], [switches, "mpmath"])
    with mpmath.workdps(digits + 10):
        for _ in range(3):
            found, known = both(*(mpmath.mpf(generator.uniform(0.4, 1.8)) for _ in symbols))
            if abs(found - known) > max(1, abs(known)) * mpmath.mpf(10) ** -digits:
                return False
    return True


def has_form(equations: Equations, form: str) -> bool:
    """Whether a system has a form of the equations, that of reactions with what ``equations_with`` adds."""
    if form == "explicit":
        return equations.accelerations is not None
    if form == "hamilton":
        return all(any(entry != 0 for entry in row) for row in equations.mass_matrix)
    if form == "reactions":
        return bool(equations.reactions)
    return form != "vakonomic" or any(not each.holonomic for each in equations.constraints)
