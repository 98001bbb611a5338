"""Starts of chains and trees with constraints: beside the numbers of their members; and what they take."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lagrange_cli import portions
from lagrange_cli.errors import SpecError
from lagrange_cli.expression.exact import context
from lagrange_cli.families import consistency
from lagrange_cli.families.consistency import WholeEquations, equations_of
from lagrange_cli.model.start.equations import Equations
from lagrange_cli.portions import latest
from lagrange_cli.run.start import consistent_values
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_values
from tests.families.test_closed_chains import CASES, chain
from tests.support.command import lagrange

TREE = """
sizes: {N: 9}
parameters: {l: 1, m: 1, g: 9.81}
coordinates:
  s: {initial: 0.1}
  a[i in range(N)]: {initial: 0.2}
  b[i in range(N)]: {initial: 0.3}
definitions:
  x[0]: s + l*sin(a[0])
  x[i in range(1, N)]: x[(i - 1)//2] + l*sin(a[i])
  y[0]: -l*cos(a[0])
  y[i in range(1, N)]: y[(i - 1)//2] - l*cos(a[i])
masses: {"p[i in range(N)]": m*(1 + i/N), "r[i in range(N)]": m/3, "h[i in range(N)]": m/2, cart: 2*m}
embedding:
  p[i in range(N)]: [x[i], y[i]]
  cart: [s, 0]
  r[0]: [s + l*sin(a[0])/2, -l*cos(a[0])/2]
  r[i in range(1, N)]: [x[(i - 1)//2] + l*sin(a[i])/2, y[(i - 1)//2] - l*cos(a[i])/2]
  h[i in range(N)]: [x[i] + l*sin(b[i]), y[i] - l*cos(b[i])]
potential: sum(g*m*p[i].y for i in range(N))
constraints:
  tip: x[N - 1]**2 + y[N - 1]**2 - 5
  other: x[N - 2] - x[N - 4] - 0.3*y[2]*t
"""


@pytest.mark.exhaustive(keep=0.55)
@pytest.mark.parametrize("case", ["tree", *CASES])
@pytest.mark.parametrize("exact", [False, True])
def test_numbers_are_those_of_the_members(case: str, exact: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Constraints, their slopes, M, and M^-1, at a state where nothing is special."""
    monkeypatch.setattr(consistency, "FEWEST", 0)
    spec = read_spec(TREE if case == "tree" else chain(case, 12), "system.yaml")
    count, chance = len(spec.coordinates), np.random.default_rng(3)
    number = context().mpf if exact else float
    parameters = {name: number(x) for name, x in resolve_values(spec, {}).parameters.items()}
    t = number(0.37)
    q, v = ([number(x) for x in chance.uniform(-2, 2, count)] for _ in range(2))
    found = equations_of(spec, parameters, exact=exact)
    members = Equations(spec, parameters, context() if exact else None)
    assert found is not None
    least = 1e-60 if exact else 1e-12
    one, other = found.at(t, q, v), members.at(t, q, v)
    assert [{*row} for row in one.rows] == [{*row} for row in other.rows]
    assert max(map(abs, np.subtract(one.values, other.values))) < least
    assert max(map(abs, np.subtract(one.drifts, other.drifts))) < least
    for row, expected in zip(one.rows, other.rows):
        assert max(abs(a - expected[k]) for k, a in row.items()) < least
    masses, rows = found.masses(t, q, v), members.masses(t, q, v).rows
    matrix = np.array([[rows[i].get(k, number(0)) for k in range(count)] for i in range(count)])
    product = masses.times(v, range(count))
    assert max(map(abs, matrix @ np.array(v) - np.array([*product.values()]))) < least
    doubles = matrix.astype(float)
    assert max(map(abs, np.subtract(masses.diagonal(count), np.diag(matrix)))) < least
    for chosen in (range(count), [1, 3, count - 2]):
        right = chance.normal(size=(len(chosen), 3))
        solver = masses.solver(chosen)
        assert solver is not None
        assert np.allclose(doubles[np.ix_(chosen, chosen)] @ solver(right), right, atol=1e-10)


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize(
    "change, hint",
    [
        (("initial: -A + h*i", "initial: 0"), "all derivatives of 'right' are 0 at these values"),
        (("d: l*sin(N*h/2)/sin(h/2)", "d: 3.5"), "no values near these satisfy all"),
        (("initial: -A + h*i", "initial: -A*1.001 + h*i"), "solve --project-initial takes the nearest"),
    ],
)
def test_a_bad_start_of_a_long_chain_is_refused_soon(
    change: tuple[str, str], hint: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where it is stretched, too short, or off; the constraints are evaluated a few dozen times at most."""
    evaluated: list[Any] = []
    plain = WholeEquations.at
    monkeypatch.setattr(WholeEquations, "at", lambda *given: evaluated.append(1) or plain(*given))
    spec = read_spec(chain("pinned", 300).replace(*change), "system.yaml")
    with pytest.raises(SpecError) as found:
        consistent_values(spec, resolve_values(spec, {}), 0.0, ())
    assert hint in f"{found.value}"
    assert 0 < len(evaluated) < 60


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize("case", ["pinned", "on a rod", "on a bent rail"])
def test_the_nearest_state_of_a_long_chain_is_found_with_few_evaluations(
    case: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From far off, in three searches. The way is perpendicular to the surface in the metric of the masses:
    M (q - q0) = A^T mu, mu by least squares. (Steps along the gradient take two or three times as many.)"""
    evaluated: list[Any] = []
    plain = WholeEquations.at
    monkeypatch.setattr(WholeEquations, "at", lambda *given: evaluated.append(1) or plain(*given))
    spec = read_spec(chain(case, 60).replace("initial: -A + h*i", "initial: -1.3*A + h*i"), "system.yaml")
    values = resolve_values(spec, {})
    _, found, _ = consistent_values(spec, values, 0.0, (), forced=True)
    assert 0 < len(evaluated) < 600
    equations = equations_of(spec, values.parameters)
    assert equations is not None
    here = equations.at(0.0, found.q, found.v)
    assert max(map(abs, here.values)) < 1e-14
    way = np.subtract(found.q, values.q)
    assert np.abs(way).max() > 0.1
    across = np.array([*equations.masses(0.0, values.q, values.v).times(way, range(len(way))).values()])
    slopes = np.array([[row.get(k, 0.0) for k in range(len(way))] for row in here.rows])
    mu = np.linalg.lstsq(slopes.T, across, rcond=None)[0]
    assert np.abs(slopes.T @ mu - across).max() < 1e-7 * np.abs(across).max()


@pytest.mark.exhaustive(keep=0.3)
def test_the_time_left_of_a_search_is_of_the_right_size(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where each evaluation takes a second: from how much smaller the slope along the surface has become."""
    now, told = [0.0], []
    plain = WholeEquations.at

    def at(*given: Any) -> Any:
        now[0] += 1.0
        work = latest()
        told.append((now[0], None if work is None else work.left(now[0])))
        return plain(*given)

    monkeypatch.setattr(portions.time, "monotonic", lambda: now[0])
    monkeypatch.setattr(WholeEquations, "at", at)
    spec = read_spec(chain("pinned", 60).replace("initial: -A + h*i", "initial: -1.3*A + h*i"), "system.yaml")
    consistent_values(spec, resolve_values(spec, {}), 0.0, (), forced=True)
    known = [(left, now[0] - t) for t, left in told if left is not None and left > 3.0]
    assert len(known) > now[0] / 2
    assert 0.4 < np.median([left / true for left, true in known if true]) < 2.5
    assert latest() is None


TWICE = """
sizes: {N: 300}
coordinates:
  x[i in range(N)]: {initial: i}
  y[i in range(N)]: {initial: 0}
masses: {bob[i in range(N)]: 1}
positions: {"bob[i in range(N)]": "(x[i], y[i])"}
constraints:
  rod[i in range(N - 1)]: norm((x[i + 1] - x[i], y[i + 1] - y[i])) - 1
  held: x[0]
  twice: 2*norm((x[1] - x[0], y[1] - y[0])) - 2
"""


@pytest.mark.exhaustive(keep=0.35)
def test_states_near_a_long_chain_are_nearer_than_a_part_of_its_size() -> None:
    """Its links limit that: one was looked for in vain, and the start taken as a singular configuration."""
    spec = read_spec(TWICE, "system.yaml")
    found, _, begin = consistent_values(spec, resolve_values(spec, {}), 0.0, ())
    assert (found.left_out, begin.singular) == (("twice",), ())
    assert found.tied == (("rod[0]", "twice"),)


@pytest.mark.exhaustive(keep=0.75)
def test_what_members_are_written_out_for_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "chain.yaml").write_text(chain("pinned", 60), encoding="utf-8")
    monkeypatch.setenv("LAGRANGE_LIMITS", "work=60000")
    made = lagrange("solve", "chain.yaml", "--stop", "1", "--no-cache", "--proven", cwd=tmp_path)
    assert made.returncode == 3
    told = "written out for steps that have to be proven, on chains"
    assert told in " ".join(made.stderr.split()), made.stderr
    assert "Traceback" not in made.stderr
