"""Definitions of pairs that differ in kind are checked together, and mistakes are said as of few."""

from __future__ import annotations

import math

import pytest

from lagrange_cli.expression.numbers import NumberAlgebra
from lagrange_cli.limits import DEFAULTS
from lagrange_cli.model.scope import Scope
from lagrange_cli.spec.draft import Written
from lagrange_cli.spec.families import MAX_DEFINED, MAX_MEMBERS
from lagrange_cli.spec.kinds import Kind
from lagrange_cli.spec.read import examine, read_spec
from lagrange_cli.spec.settling import Settling

FILE = """\
sizes: {{N: {count}}}
coordinates: {{"x[i in range(N)]": {{initial: "3*i"}}}}
masses: {{"bead[i in range(N)]": 1}}
embedding: {{"bead[i in range(N)]": ["x[i]"]}}
definitions: {{{definitions}}}
potential: {potential}
"""
PAIR = '"d[i in range(N), j in range(N)]": '
KINDS = {
    "a number on the diagonal": PAIR + '"where(i == j, 1, sqrt(1 + (x[i] - x[j])**2))"',
    "numbers below it": PAIR + '"where(i > j, 1 + i/7, x[i] + x[j])"',
    "two pieces": '"d[i in range(N), j in range(N) if i != j]": "x[i]*x[j]", "d[i in range(N), i]": 2',
    "three kinds": '"d[i in range(N), j in range(i + 1)]": "where(i == j, 2 + i, x[i])", '
    '"d[i in range(N), j in range(i + 1, N)]": "x[j]**2"',
    "functions of indices": PAIR + '"max(abs(i - j), 1)*x[i] + min(i, j, 3)*atan2(1 + i, 2) + sign(i - 4)"',
    "vectors": PAIR + '"where(i == j, [0, 1], [x[i] - x[j], i])"',
}
USES = {
    "a number on the diagonal": "sum(1/d[i, j] for i in range(N) for j in range(N))",
    "numbers below it": "sum(x[0]**(d[i, j] - (i - j)/7) for i in range(N) for j in range(i) if i - j == i)",
    "two pieces": "sum(x[0]**d[i, i] + d[i, 0] for i in range(N))",
    "three kinds": "sum(d[i, j]/d[i, i] for i in range(N) for j in range(N) if abs(i - j) < 3)",
    "functions of indices": "sum(d[i, j] for i in range(N) for j in range(N))",
    "vectors": "sum(d[i, j].x**2 + d[j, j].y for i in range(N) for j in range(N))",
}


@pytest.mark.parametrize("kinds", KINDS)
def test_members_of_several_kinds_are_checked_together(kinds: str, monkeypatch: pytest.MonkeyPatch) -> None:
    settle, settled = Settling._settle_one, list[str]()

    def counted(self: Settling, one: Written, what: Kind) -> None:
        settled.extend([one.name] if what is Kind.DEFINITION else [])
        settle(self, one, what)

    monkeypatch.setattr(Settling, "_settle_one", counted)
    text = FILE.format(count=20, definitions=KINDS[kinds], potential=USES[kinds])
    _, problems = examine(text, "file.yaml")
    assert problems.found == []
    assert len(settled) <= 20  # a piece with few members


WRONG = {
    (
        PAIR + '"where(i == j, 0, x[i] - x[j])"',
        "sum(1/d[i, j] for i in range(N) for j in range(N))",
    ): "division",
    (PAIR + '"where(i == j, -1, x[i])"', "sum(sqrt(d[i, i])*d[i, 0] for i in range(N))"): "not a real number",
    (
        PAIR + '"where(i == j, 100, 2)"',
        "sum(x[0]**d[i, j] for i in range(N) for j in range(N))",
    ): "exponent 100",
    (PAIR + '"where(i == j, 1/(i - 3), 2)"', "x[0]"): "division by zero",
    (PAIR + '"where(i == j, [1, 2], x[i])"', "x[0]"): "",
    (
        '"d[i in range(N), j in range(N) if i != j]": "x[i]*x[j]", "d[i in range(N), i]": 0',
        "sum(d[i, 0]/d[i, i] for i in range(N))",
    ): "division by zero",
    (
        '"d[i in range(N), j in range(N) if i < j]": "x[i]"',
        "sum(d[i, 1] for i in range(N))",
    ): "no member 'd[1,1]'",
    (
        '"d[i in range(N), j in range(N) if i != j]": "x[i]", "d[i in range(N), i + i % 2]": "x[i]"',
        "x[0]",
    ): "'d[1,2]' is given twice",
}


@pytest.mark.parametrize(("definitions", "potential"), WRONG)
def test_mistakes_are_said_of_many_as_of_few(definitions: str, potential: str) -> None:
    said = []
    for count in (8, 20):
        text = FILE.format(count=count, definitions=definitions, potential=potential)
        _, problems = examine(text, "file.yaml")
        said.append([(one.line, one.column, one.message.partition("[")[0]) for one in problems.found])
        if WRONG[definitions, potential]:
            assert WRONG[definitions, potential] in problems.found[0].message
    assert said[0] == said[1]


DISTANCES = """\
sizes: {N: 1000}
coordinates: {x: {initial: 0.5}, y: {initial: 1.5}}
masses: {a: 1}
embedding: {a: [x, y]}
definitions:
  d[i in range(N), j in range(N)]: where(i == j, 2*x, sqrt(i + j*y**2))
  e[i in range(N), j in range(N)]: 1/d[i, j]
  last: e[N - 1, 1]
potential: e[3, 1] + d[2, 2] + last
"""


def test_large_families_of_definitions_are_built_where_they_are_used() -> None:
    """Of 10^6 distances, three are; what uses them has the values of the formula."""
    spec = read_spec(DISTANCES, "file.yaml")
    scope = Scope(spec, NumberAlgebra({"x": 0.5, "y": 1.5, "x_dot": 0.0, "y_dot": 0.0, "t": 0.0}))
    (potential,) = spec.potential.values()
    expected = 1 / math.sqrt(3 + 1.5**2) + 1.0 + 1 / math.sqrt(999 + 1.5**2)
    assert math.isclose(scope.scalar(potential), expected, rel_tol=1e-15)
    built = ["d[2,2]", "d[3,1]", "d[999,1]", "e[3,1]", "e[999,1]"]
    assert sorted(name for name in scope.values if name[:2] in ("d[", "e[")) == built
    used = [one.indices for one in scope.in_equations if one.indices]
    assert sorted(map(tuple, (one.values() for one in used))) == [(2, 2), (3, 1), (3, 1), (999, 1), (999, 1)]


def test_members_of_definitions_have_a_limit_of_their_own() -> None:
    assert MAX_DEFINED == DEFAULTS["pairs"] > MAX_MEMBERS
    text = FILE.format(count=1000, definitions=PAIR + "1", potential="x[0]")
    assert examine(text, "file.yaml")[1].found == []
    (problem,) = examine(text.replace("1000", "1500"), "file.yaml")[1].found
    assert problem.message == f"more than {MAX_DEFINED} members in all definitions together"
    assert "LAGRANGE_LIMITS=pairs=" in problem.hint
