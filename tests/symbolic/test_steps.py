"""What deriving the printed equations does not do: it is counted, not timed."""

from __future__ import annotations

import random
from fractions import Fraction

import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

from lagrange_cli.expression import symbolic
from lagrange_cli.expression.symbolic import Slopes
from lagrange_cli.run.equations import as_data, as_written, derive
from lagrange_cli.symbolic import canonical, grouping, slopes, textbook
from lagrange_cli.symbolic.canonical import multiply, to_terms
from lagrange_cli.symbolic.grouping import group, is_irreducible
from lagrange_cli.symbolic.monomials import (
    ONE,
    Terms,
    TooLargeError,
    common_factor,
    divide,
    from_terms,
    ratio,
    term,
)
from lagrange_cli.symbolic.order import Order, Role
from lagrange_cli.symbolic.perfect_powers import may_be_power
from lagrange_cli.symbolic.textbook import neat
from lagrange_cli.symbolic.work import size_of
from tests.support.draws import examples
from tests.support.motion import spec_of

a, b, c, x, y, z, u, v, w = SYMBOLS = sympy.symbols("a b c x y z u v w")
ORDER = Order(
    {
        symbol: (role, rank)
        for role, symbols in (
            (Role.PARAMETER, (a, b, c)),
            (Role.COORDINATE, (x, y, z)),
            (Role.VELOCITY, (u, v, w)),
        )
        for rank, symbol in enumerate(symbols)
    }
)
SEEDS = st.integers(0, 10**6)
STONE = """
parameters: {m: 1, g: 9.81, a: 0.2, b: 0.1, c: 0.3, J: 0.1}
coordinates:
  x: {initial: 0}
  y: {initial: 0}
  z: {initial: c}
  qw: {initial: 1}
  qx: {initial: 0}
  qy: {initial: 0}
  qz: {initial: 0}
bodies:
  stone: {mass: m, inertia: [J, J, 2*J], position: [x, y, z], orientation: {quaternion: [qw, qx, qy, qz]}}
potential: m*g*z
constraints: {touch: z - c*(qw**2 + qz**2)}
nonholonomic: {along: "stone.at(a, b, -c).vx", across: "stone.at(a, b, -c).vy"}
"""


def random_terms(source: random.Random, bases: tuple[sympy.Expr, ...], most: int = 5) -> Terms:
    """A sum of a few products."""
    terms: Terms = {}
    for _ in range(source.randint(1, most)):
        powers = {base: source.choice((0, 0, 1, 1, 2, 3)) for base in bases}
        terms[frozenset((base, e) for base, e in powers.items() if e)] = source.choice((-6, -2, -1, 1, 3, 4))
    return terms


def test_rates_of_constraints_are_derived_only_if_they_are_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    derived_rates = []
    plain = slopes.along_motion

    def counted(*arguments: object) -> sympy.Expr:
        derived_rates.append(arguments)
        return plain(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr("lagrange_cli.symbolic.constraints.along_motion", counted)
    stone = derive(spec_of(STONE))
    assert "Accelerations and multipliers\n  too long to print" in as_written(stone, "text", "lagrange", {})
    assert not derived_rates
    spent = stone.work.spent
    data = as_data(stone, "lagrange", {})
    rates = [one["rate"] for one in data["constraints"]]
    assert len(derived_rates) == len(rates) == len(stone.equations.constraints)
    assert stone.work.spent > spent
    assert as_data(stone, "lagrange", {}) == data and len(derived_rates) == len(rates)


def test_rates_that_are_derived_later_count_in_the_same_work() -> None:
    stone = derive(spec_of(STONE))
    spent = stone.work.spent
    assert stone.equations.constraints[0].rate != 0  # no work is being counted here
    assert stone.work.spent > spent


@examples(5)
@given(SEEDS)
def test_what_is_seen_to_be_irreducible_is(seed: int) -> None:
    source = random.Random(seed)
    seen = 0
    for _ in range(100):
        terms = random_terms(source, (a, b, c))
        content, number = common_factor(terms)
        terms = divide(terms, content, number)
        if len(terms) > 1 and is_irreducible(terms):
            polynomial, seen = from_terms(terms), seen + 1
            assert sympy.factor(polynomial) == polynomial
    assert seen


def test_quotients_that_are_whole_are_integers() -> None:
    below = Fraction(1, 3)
    for above, divisor, whole in ((3, -1, -3), (6, 4, None), (8, -4, -2), (2, below, 6), (below, -below, -1)):
        found = ratio(above, divisor)
        assert found == Fraction(above) / divisor and (type(found) is int) == (whole is not None)


def test_a_product_is_not_taken_for_irreducible() -> None:
    for product in ((a + b) * (a - c), a**2 + 2 * a * b + b**2, (a + 1) * (b + c), a**2 - b**2):
        assert not is_irreducible(to_terms(product))
    assert not is_irreducible(to_terms(a + sympy.Rational(47, 10)))  # decimals are written in their own way


def test_polynomials_that_are_seen_to_be_irreducible_are_not_factored(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(sympy, "factor", lambda *_: pytest.fail("it is factored"))
    found = group(to_terms((a * b**2 + c - 3 * a) * x + (a - b * c + c**2) * y), ORDER)
    assert sympy.expand(found - (a * b**2 + c - 3 * a) * x - (a - b * c + c**2) * y) == 0


@examples(5)
@given(SEEDS)
def test_monomials_are_sorted_as_terms_are(seed: int) -> None:
    source = random.Random(seed)
    others = sympy.sin(x), sympy.cos(a * y), sympy.exp(x), sympy.exp(y), x + y, a + b, sympy.sqrt(a), x**a
    for _ in range(200):
        chosen = source.sample([*SYMBOLS, *others], source.randint(0, 4))
        powers = [source.choice((1, 1, 2, 3, -1, -2)) for _ in chosen]
        if source.random() < 0.2 and chosen:
            powers[0] = sympy.Rational(source.choice((1, 3, -1)), 2)
        monomial = frozenset(zip(chosen, powers, strict=True))
        assert ORDER.monomial_key(monomial) == ORDER.term_key(term(monomial))


@examples(5)
@given(SEEDS)
def test_a_product_of_factors_is_expanded_as_factor_by_factor(seed: int) -> None:
    source = random.Random(seed)
    factors = [
        x, y**2, a, sympy.sin(x), 1 / b, sympy.sqrt(x), x + y, (a - x) ** 2, 1 / (x + y),
        sympy.Rational(3, 7), sympy.sqrt(x + y), 1 / sympy.sqrt(x + y), sympy.cos(x + y) ** 3,
        sympy.Integer(-2), x**a,
    ]  # fmt: skip
    for _ in range(50):
        chosen = [source.choice(factors) for _ in range(source.randint(0, 5))]
        expected: Terms = {ONE: 1}
        for factor in chosen:
            expected = multiply(expected, to_terms(factor))
        found = canonical.product_of(chosen)
        assert sympy.expand(from_terms(found) - from_terms(expected)) == 0
        assert all(found.values())


def test_a_product_without_sums_takes_no_multiplication(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(canonical, "multiply", lambda *_: pytest.fail("sums are multiplied"))
    product = 3 * a * x**2 * sympy.sin(y) ** 3 / sympy.sqrt(b)
    assert from_terms(to_terms(product)) == product


def test_a_sum_that_is_too_long_is_grouped_no_further(monkeypatch: pytest.MonkeyPatch) -> None:
    terms = to_terms((a * x + b * y + c * x * y) * (u**2 + u * v + v**2 + u * w + v * w + w**2))
    whole = group(terms, ORDER)
    grouped = []
    plain = grouping.with_denominators

    def counted(*arguments: object) -> sympy.Expr:
        grouped.append(arguments)
        return plain(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(grouping, "with_denominators", counted)
    assert group(terms, ORDER, size_of(whole)) == whole and len(grouped) == 6
    grouped.clear()
    with pytest.raises(TooLargeError):
        group(terms, ORDER, size_of(whole) / 3)
    assert 1 < len(grouped) < 4


def test_squares_of_velocities_are_not_shortened_before_they_are_collected(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    settled = []
    plain = textbook.with_settled_sums

    def counted(part: sympy.Expr) -> sympy.Expr | None:
        settled.append(part)
        return plain(part)

    monkeypatch.setattr(textbook, "with_settled_sums", counted)
    spring = a * (x - b) ** 2 / 2
    found = neat((x * u + y * v) ** 2 + c * (u - v) ** 2 + spring, ORDER, Role.COORDINATE)
    assert settled == [spring] and found.has(spring)


def test_terms_of_a_potential_are_expanded_once(monkeypatch: pytest.MonkeyPatch) -> None:
    tidied = []
    plain = grouping.tidy

    def counted(part: sympy.Expr, order: Order) -> sympy.Expr:
        tidied.append(part)
        return plain(part, order)

    monkeypatch.setattr("lagrange_cli.symbolic.textbook.tidy", counted)
    order = Order(ORDER.ranks)
    potential = a * (x - y) ** 4 + b * (y - z) ** 4
    first = neat(potential, order, Role.COORDINATE)
    count = len(tidied)
    assert neat(u**2 + potential, order, Role.COORDINATE) == u**2 + first and len(tidied) == count + 1


@examples(5)
@given(SEEDS)
def test_derivatives_are_those_of_sympy_and_shared_parts_are_differentiated_once(seed: int) -> None:
    source = random.Random(seed)
    nodes: list[sympy.Expr] = [*SYMBOLS]
    for _ in range(12):
        one, other = source.sample(nodes, 2)
        nodes.append(source.choice((one + other, one * other, sympy.sin(one), one**2 / (1 + other**2))))
    chained = []
    plain = symbolic.chained

    def counted(node: sympy.Expr, *arguments: object) -> sympy.Expr:
        chained.append(node)
        return plain(node, *arguments)  # type: ignore[arg-type]

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(symbolic, "chained", counted)
        derivatives = Slopes()
        for node in nodes:
            assert derivatives.slope(node, x) == node.diff(x)
    assert len(chained) == len({*chained})


def test_what_may_be_a_power_does_not_depend_on_the_order_of_sets() -> None:
    squares = to_terms((a + x) ** 2), to_terms((a * x - b) ** 2), to_terms((x + y + z) ** 3)
    assert all(map(may_be_power, squares))
    assert not may_be_power(to_terms(1 + x * y + y**2))  # whichever base comes first
