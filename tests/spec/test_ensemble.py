"""The numbers of an ensemble are, to the last bit, those that each member has alone."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lagrange_cli.errors import SpecError, UsageError
from lagrange_cli.expression.columns import ColumnAlgebra
from lagrange_cli.expression.vocabulary import FUNCTIONS
from lagrange_cli.spec.ensemble import member_values, resolve_ensemble
from lagrange_cli.spec.read import read_spec
from tests.support.command import SYSTEMS
from tests.support.files import changed

PENDULUM = read_spec((SYSTEMS / "pendulum.yaml").read_bytes(), "pendulum.yaml")
REALS = st.floats(-1e3, 1e3) | st.floats(allow_nan=False, allow_infinity=False)
INTRICATE = changed(
    "m: 1", "m: 1 + l**2*(l**0.5 + g/3)/g - 2**l\n  w: -atan2(sin(g), l)*exp(1/l) + tanh(l - g) - log(l)/7"
).replace("initial: 0.1", "initial: w/m + deep*2, velocity: 3 - w*l")
INTRICATE += "definitions: {deep: sqrt(g)*cos(w)}\n"


def bits(numbers: np.ndarray | list[float]) -> bytes:
    return np.asarray(numbers, dtype=float).tobytes()


def test_each_member_has_the_numbers_that_it_would_have_alone() -> None:
    spec = read_spec(INTRICATE, "file.yaml")
    source = np.random.default_rng(1)
    columns = {"l": source.uniform(0.2, 2, 200), "g": source.normal(9.8, 1, 200)}
    ensemble = resolve_ensemble(spec, {"m": "w**2 + 1"}, columns)
    alone = [member_values(spec, {"m": "w**2 + 1"}, columns, i) for i in range(200)]
    for name in ("l", "g", "m", "w"):
        assert bits(ensemble.parameters[name]) == bits([one.parameters[name] for one in alone])
    assert bits(ensemble.q[0]) == bits([one.q[0] for one in alone])
    assert bits(ensemble.v[0]) == bits([one.v[0] for one in alone])


@pytest.mark.parametrize(("column", "usual", "unusual"), [("l", 1.0, 1e-18), ("theta_dot", 0.1, -1e10)])
def test_members_that_are_looked_at_are_the_smallest_and_the_fastest(column, usual, unusual) -> None:
    values = np.full(300, usual)
    values[141] = unusual
    ensemble = resolve_ensemble(PENDULUM, {}, {column: values})
    several = [one.parameters.get(column, one.v[0]) for one in ensemble.several()]
    assert unusual in several and len(several) <= 64


def test_what_does_not_differ_is_one_number() -> None:
    spec = read_spec(INTRICATE, "file.yaml")
    ensemble = resolve_ensemble(spec, {"m": "2"}, {"theta_dot": np.array([1.0, 2.0])})
    assert ensemble.differing == {}
    assert ensemble.common == member_values(spec, {"m": "2"}, {}, 0).parameters
    assert ensemble.members == 2 and bits(ensemble.v[0]) == bits([1, 2])


def test_members_of_families_and_what_depends_on_them() -> None:
    text = (SYSTEMS / "n_pendulum.yaml").read_text(encoding="utf-8").replace("2.0 + 0.1*i", "l*i")
    spec = read_spec(text, "file.yaml")
    ensemble = resolve_ensemble(spec, {}, {"l": np.array([0.5, 2.0]), "theta[1]": np.array([7.0, 8.0])})
    assert bits(ensemble.q[1]) == bits([7, 8]) and bits(ensemble.q[4]) == bits([2, 8])


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("name", sorted(FUNCTIONS))
@given(data=st.data())
def test_functions_are_those_of_single_numbers_wherever_they_have_a_value(name, data) -> None:
    rows = data.draw(st.lists(st.tuples(*[REALS] * FUNCTIONS[name]), min_size=1, max_size=5))
    algebra = ColumnAlgebra(len(rows))
    found = algebra.function(name, [algebra.column(np.array(x)) for x in zip(*rows)])
    for row, value, failed in zip(rows, found.values, algebra.failed):
        try:
            expected = getattr(math, name)(*row)
        except (ValueError, OverflowError):
            assert failed
        else:
            assert failed == (name == "exp" and expected == 0) and bits([expected]) == bits([value])


@pytest.mark.exhaustive(keep=0.6)
@given(rows=st.lists(st.tuples(REALS, REALS), min_size=1, max_size=5), number=REALS)
def test_operators_are_those_of_single_numbers_wherever_they_have_a_value(rows, number) -> None:
    operations = [
        lambda x, y: x + y, lambda x, y: x - y, lambda x, y: x * y, lambda x, y: x / y, lambda x, y: x**y,
        lambda x, y: number + x, lambda x, y: number - x, lambda x, y: number * x, lambda x, y: number / x,
        lambda x, y: number**x, lambda x, y: x - number, lambda x, y: x**number, lambda x, y: -x,
    ]  # fmt: skip
    for operation in operations:
        algebra = ColumnAlgebra(len(rows))
        x, y = (algebra.column(np.array(column)) for column in zip(*rows))
        with np.errstate(all="ignore"):
            found = operation(x, y)
        for row, value, failed in zip(rows, found.values, algebra.failed):
            try:
                expected = operation(*row)
            except ArithmeticError:
                assert failed
            else:
                assert failed == isinstance(expected, complex) or expected == 0  # some underflow
                assert failed or np.array_equal(expected, value, equal_nan=True)


@pytest.mark.parametrize(
    ("column", "values", "message"),
    [
        ("m", [1, -2, 0], "member 1 (and 1 more) cannot be run: --set m=-2.0: the value -2 is not positive"),
        ("l", [1, 1, 0], "member 2 cannot be run: --set l=0.0: division by zero in parameter 'w'"),
        ("l", [-1, 1, 1], "member 0 cannot be run: --set l=-1.0: log(-1) is not a real number"),
        ("l", [1, 1e-9, 1], "member 1 cannot be run: --set l=1e-09: number too large"),
        ("l", [1, 1, -1e-9], "member 2 cannot be run: --set l=-1e-09: number too small"),
        ("m", [1, 1e-200, 1], "member 1 cannot be run: --set m=1e-200: number too small"),
    ],
)
def test_the_first_member_that_cannot_be_run_is_named(column, values, message) -> None:
    text = changed("m: 1", "m: 1\n  w: exp(1/l) + log(l)\n  s: m*m")
    with pytest.raises(UsageError) as raised:
        resolve_ensemble(read_spec(text, "file.yaml"), {}, {column: np.array(values, dtype=float)})
    assert message in str(raised.value)


def test_what_is_wrong_with_the_file_keeps_its_place() -> None:
    text = changed("m: 1", "m: 1\n  w: 1/(g - g)")
    with pytest.raises(SpecError) as raised:
        resolve_ensemble(read_spec(text, "file.yaml"), {}, {"l": np.array([1.0])})
    assert "division by zero" in str(raised.value) and "file.yaml:" in str(raised.value)
