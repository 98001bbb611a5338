"""Families that follow from one another in turn: as many numbers by going from member to member."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

import lagrange_cli as lagrange
from lagrange_cli.errors import SpecError
from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.model.quantity import UNKNOWN
from lagrange_cli.model.scope import Scope
from lagrange_cli.model.survey import Survey
from lagrange_cli.model.unit_text import read_unit
from lagrange_cli.spec import circles
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_values
from tests.support.draws import examples
from tests.support.files import problems, underlined

REST = """
coordinates: {q: {initial: 0.1}}
masses: {ball: 1}
positions: {ball: [q]}
potential: q**2
"""
Vector = tuple[float, float]
NAMES = "abcd"


def defined(text: str) -> dict[str, object]:
    """The numbers that definitions are, by the names of members."""

    def number(value: object) -> object:
        return tuple(map(number, value)) if isinstance(value, tuple) else value.data  # type: ignore[attr-defined]

    return {
        name: number(one)
        for name, one in Scope(read_spec(text, "file"), GraphAlgebra()).values.items()
        if "[" in name
    }


class Ring:
    """Families of plane vectors, each of which follows from those before it of the same index, and the first
    from the ``last`` one of the index before."""

    def __init__(self, data: st.DataObject) -> None:
        draw = data.draw
        self.count, self.families = draw(st.integers(1, 5)), draw(st.integers(2, 4))
        self.downwards, self.summed = draw(st.booleans()), draw(st.booleans())
        self.guarded = draw(st.booleans())
        weight = st.integers(-3, 3)
        self.weights = [[draw(weight) for _ in range(k)] for k in range(self.families)]
        self.weights = [[*one[:-1], one[-1] or 1] if one else one for one in self.weights]
        self.turned = [draw(st.booleans()) for _ in range(self.families)]
        self.order = draw(st.permutations(range(self.families)))

    def text(self) -> str:
        """The definitions of a file."""
        last, end = NAMES[self.families - 1], self.count - 1 if self.downwards else 0
        lines = list[str]()
        for k in self.order:
            name, own = NAMES[k], f"({k + 1} + i, i - {k})"
            terms = [f"{w}*{self._turned(NAMES[j], k)}" for j, w in enumerate(self.weights[k]) if w]
            if k:
                lines.append(f'"{name}[i in range({self.count})]": {own} + {" + ".join(terms)}')
                continue
            before = f"{last}[i + 1]" if self.downwards else f"{last}[i - 1]"
            if self.summed:
                loop = f"range(i + 1, {self.count})" if self.downwards else "range(i)"
                sums = ", ".join(f"sum({last}[k].{axis} for k in {loop})" for axis in "xy")
                lines.append(f'"a[i in range({self.count})]": {own} + ({sums})')
            elif self.guarded:
                inside = f"i < {end}" if self.downwards else "i > 0"
                lines.append(f'"a[i in range({self.count})]": {own} + where({inside}, {before}, (0, 0))')
            else:
                others = f"range({end})" if self.downwards else f"range(1, {self.count})"
                lines.append(f'"a[{end}]": {own.replace("i", str(end))}')
                lines += [f'"a[i in {others}]": {before} + {own}'] if self.count > 1 else []
        return "definitions:\n" + "".join(f"  {one}\n" for one in lines)

    def _turned(self, name: str, k: int) -> str:
        return f"({name}[i].y, -{name}[i].x)" if self.turned[k] else f"{name}[i]"

    def numbers(self) -> dict[str, Vector]:
        """The same by going from member to member."""
        found: dict[str, Vector] = {}
        indices = range(self.count)
        last, done = NAMES[self.families - 1], list[Vector]()
        for i in indices[::-1] if self.downwards else indices:
            for k in range(self.families):
                x, y = float(k + 1 + i), float(i - k)
                for j, weight in enumerate(self.weights[k]):
                    u, v = found[f"{NAMES[j]}[{i}]"]
                    u, v = (v, -u) if self.turned[k] else (u, v)
                    x, y = x + weight * u, y + weight * v
                for u, v in () if k else done if self.summed else done[-1:]:
                    x, y = x + u, y + v
                found[f"{NAMES[k]}[{i}]"] = x, y
            done.append(found[f"{last}[{i}]"])
        return found


@given(data=st.data())
@examples(60)
def test_rings_of_families_have_the_numbers_of_their_members(data: st.DataObject) -> None:
    ring = Ring(data)
    assert defined(ring.text() + REST) == ring.numbers()


def test_families_of_two_indices_that_take_turns() -> None:
    """Where each row begins another part is used."""
    text = """
sizes: {N: 4}
definitions:
  u[i in range(N), 0]: 10*i
  u[i in range(N), j in range(1, N)]: v[i, j - 1] + 1
  v[0, j in range(N)]: 2*u[0, j]
  v[i in range(1, N), j in range(N)]: u[i, j] - u[i - 1, j]
"""
    found, u, v = defined(text + REST), {}, {}
    for i in range(4):
        for j in range(4):
            u[i, j] = v[i, j - 1] + 1 if j else 10.0 * i
            v[i, j] = u[i, j] - u[i - 1, j] if i else 2 * u[0, j]
    assert found == {f"{name}[{i},{j}]": one[i, j] for name, one in (("u", u), ("v", v)) for i, j in one}


def test_parameters_that_take_turns() -> None:
    """Numerators and denominators of the convergents of the golden ratio."""
    text = """
parameters:
  p[0]: 1
  p[i in range(1, 9)]: s[i - 1]
  s[i in range(9)]: p[i] + where(i > 0, p[i - 1], 0)
"""
    values = resolve_values(read_spec(text + REST, "file"), {}).parameters
    assert [values[f"s[{i}]"] for i in range(9)] == [1, 2, 3, 5, 8, 13, 21, 34, 55]


LEGS = """
sizes: {N: 5}
parameters: {l: {value: 0.5, unit: m}, g: {value: 9.81, unit: m/s^2}, m: {value: 1, unit: kg}}
coordinates:
  th[i in range(N)]: {initial: 0.3 + 0.1*i, unit: rad}
  ph[i in range(N)]: {initial: -0.2, unit: rad}
masses: {knee[i in range(N)]: m, foot[i in range(N)]: 2*m}
positions:
  foot[i in range(N)]: knee[i] + l*[sin(ph[i]), -cos(ph[i])]
  knee[0]: [l*sin(th[0]), -l*cos(th[0])]
  knee[i in range(1, N)]: foot[i - 1] + l*[sin(th[i]), -cos(th[i])]
potential: sum(m*g*knee[i].y + 2*m*g*foot[i].y for i in range(N))
"""


def test_units_of_places_that_take_turns() -> None:
    survey = Survey(read_spec(LEGS, "file"), read_unit("s"))
    assert survey.conflicts == [] and UNKNOWN not in survey.positions.values()
    assert survey.positions["knee"].unit == survey.positions["foot"].unit == read_unit("m")
    wrong = LEGS.replace("l*[sin(ph[i]), -cos(ph[i])]", "[sin(ph[i]), -cos(ph[i])]*m")
    (conflict,) = Survey(read_spec(wrong, "file"), read_unit("s")).conflicts
    line, start = conflict.place.line, conflict.place.column - 1
    assert LEGS.splitlines()[line - 1][start:].startswith("knee[i] + l*[sin(ph")


def test_large_families_are_not_looked_at_one_by_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(circles, "MOST", 10)
    assert read_spec(LEGS, "file", {"N": "20000"}).order == ("knee", "foot")


PIECES = (
    "foot[i]", "knee[i - 1]", "[i + 1]", "i", "N", "+", "*", "(", ")", "[", "]", ".x", ".vx", "where(i > 0, ",
    "sum(", " for k in range(i))", " for k in range())", ", ", "0", "foot", "range(N)", "%", " ",
)  # fmt: skip


@given(data=st.data())
@examples(60)
def test_whatever_is_written_is_read_or_refused(data: st.DataObject) -> None:
    text = LEGS
    for _ in range(data.draw(st.integers(1, 3))):
        at, end = (data.draw(st.integers(LEGS.index("positions"), len(LEGS))) for _ in range(2))
        text = (
            text[:at]
            + data.draw(st.sampled_from(("", *PIECES, LEGS[end : end + 12])))
            + text[max(at, end - 8) :]
        )
    with suppress(SpecError):
        read_spec(text, "file")


def test_a_range_without_bounds_is_all_that_is_wrong() -> None:
    text = LEGS.replace("foot[i - 1] +", "foot[i - 1] + sum(foot[k] for k in range())*0 +")
    (problem,) = problems(text)
    assert "range" in problem.message


def test_a_component_of_numbers_is_no_fault_of_the_program() -> None:
    """One that is not looked at, as another member is wrong."""
    text = """
definitions:
  u[i in range(4)]: v[i] + 1
  v[0]: u[0]
  v[i in range(1, 4)]: u[i - 1] + w[i]
  w[i in range(4)]: where(i > 1, u[i].x, q)
"""
    assert problems(text + REST)


def in_legs(old: str, new: str) -> Callable[[], str]:
    """The file of the legs with something else in it."""
    assert old in LEGS
    return lambda: LEGS.replace(old, new)


@pytest.mark.parametrize(
    ("old", "new", "piece", "message", "hint"),
    [
        ("foot[i - 1] +", "foot[i] +", "foot[i in range(N)]", "foot[1] -> knee[1] -> foot[1]", "one of them"),
        ("foot[i - 1] +", "foot[i - 2] +", "foot[i - 2]", "no member 'foot[-1]', for i = 1", "from 0"),
        ("sin(ph[i])", "sin(pj[i])", "pj[i]", "unknown name 'pj' in position of 'foot[i]'", "ph"),
        ("foot[i - 1] +", "foot[i - 1].q +", "foot[i - 1].q", "'foot' has no component 'q'", ""),
        ("foot[i - 1] +", "foot[i - 1, 0] +", "foot[i - 1, 0]", "2 instead of 1", "write foot[i]"),
        ("knee[i] +", "knee[i] + foot[(i + 1) % N]/2 +", "foot[i in range(N)]", "-> foot[4] -> foot[0]", ""),
    ],
)  # fmt: skip
def test_mistakes_are_said_once_as_they_are_written(
    old: str, new: str, piece: str, message: str, hint: str
) -> None:
    (problem,) = problems(in_legs(old, new)())
    assert message in problem.message and hint in problem.hint
    assert underlined(problem) == piece


def test_families_that_follow_from_themselves_as_well() -> None:
    """None of them can stand in the other; that is what the message says a way out of."""
    (problem,) = problems(
        LEGS.replace("+ l*[sin(th[i])", "+ knee[i - 1]/2 + l*[sin(th[i])").replace(
            "foot[i in range(N)]: knee[i]",
            "foot[0]: knee[0]\n  foot[i in range(1, N)]: foot[i - 1] + knee[i]",
        )
    )
    assert problem.message == "families cannot be computed one after the other: foot -> knee -> foot"
    assert problem.hint.endswith("r[2*i] for foot[i] and r[2*i + 1] for knee[i]")


def test_such_families_may_be_one_whose_members_take_turns() -> None:
    """That way out, by hand: u[3] and v[3] are those of a loop."""
    other = "coordinates: {x: {initial: 1}}\nlagrangian: x_dot**2/2 - x**2/2\nsizes: {N: 4}\n"
    pair = """\
definitions:
  u[0]: 1
  v[0]: 2
  u[i in range(1, N)]: u[i - 1] + v[i - 1]
  v[i in range(1, N)]: u[i]*0.5 + v[i - 1]
observables: {a: u[3] + v[1]}
"""
    (problem,) = problems(other + pair)  # and nothing about what uses them
    assert problem.hint.endswith("r[2*i] for u[i] and r[2*i + 1] for v[i]")
    one = """\
definitions:
  r[0]: 1
  r[1]: 2
  r[k in range(2, 2*N, 2)]: r[k - 2] + r[k - 1]
  r[k in range(3, 2*N, 2)]: r[k - 1]*0.5 + r[k - 2]
observables: {u: "r[6]", v: "r[7]"}
"""
    u, v = 1.0, 2.0
    for _ in range(3):
        u = u + v
        v = u * 0.5 + v
    found = lagrange.solve(other + one, stop=1, samples=2).observables
    assert (found["u"][0], found["v"][0]) == (u, v)
