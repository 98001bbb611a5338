"""M a = f and Hamilton's equations with indices, where M couples members: beside the file differentiated."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import numpy as np
import pytest

from lagrange_cli.errors import TooLargeSystem
from lagrange_cli.families import system as systems
from lagrange_cli.run.family_equations import DerivedFamilies, derive_printed, written
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_values
from lagrange_cli.symbolic.direct import directly
from lagrange_cli.symbolic.families import readback
from tests.families.test_bodies import KINDS, TOPS
from tests.families.test_bodies import drawn as drawn_bodies
from tests.families.test_chains import drawn, pendulum
from tests.families.test_closed_chains import CASES, chain
from tests.families.test_nonholonomic import drawn_on_trees
from tests.support.motion import SYSTEMS

N_PENDULUM = (SYSTEMS / "n_pendulum.yaml").read_text()
CHARGED = """
sizes: {N: 3}
parameters: {g: 9.81, B: 0.4}
coordinates: {"th[i in range(N)]": {initial: "0.3*i"}, s: {initial: 0.2}}
masses: {"bob[i in range(N)]": "1 + i", cart: 2}
embedding:
  cart: ["s + sin(t)", 0]
  bob[i in range(N)]:
  - s + sin(t) + sum(sin(th[j]) for j in range(i + 1))
  - -sum(cos(th[j]) for j in range(i + 1))
potential: sum(g*(1 + i)*bob[i].y for i in range(N))
dissipation: sum(bob[i].vx**2 for i in range(N))/7
"""


SHAKEN = """
sizes: {N: 3}
parameters: {k: 0.7}
coordinates: {"th[i in range(N)]": {initial: "0.3*i"}}
masses: {"bob[i in range(N)]": "1 + i/7"}
embedding:
  bob[i in range(N)]:
  - 0.1*sin(3*t) + sum(sin(th[j]) + 0.2*cos(2*th[j]) for j in range(i + 1))
  - 0.05*cos(2*t) + sum(0.1*th[j] - cos(th[j]) for j in range(i + 1))
potential: sum(k*th[i]**2/2 for i in range(N))
"""  # places are printed by name, and move with t alone, too


@pytest.fixture(autouse=True)
def however_small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Small systems are families, too."""
    for name in ("FEWEST", "FEWEST_JOINTED", "FEWEST_TURNING"):
        monkeypatch.setattr(systems, name, 0)


def printed(text: str, form: str, count: int | None = None) -> DerivedFamilies:
    """The equations with indices."""
    spec = read_spec(text, "system.yaml", None if count is None else {"N": str(count)})
    found = derive_printed(spec, form, indexed=True)
    assert isinstance(found, DerivedFamilies), text
    return found


def module_of(derived: DerivedFamilies, form: str) -> dict[str, Any]:
    """Its functions."""
    module: dict[str, Any] = {}
    exec(written(derived, "python", form, dict(resolve_values(derived.spec).parameters)), module)
    return module


def hold(text: str, count: int | None = None) -> None:
    """Compare M, f and Hamilton's equations with the file, at any multipliers."""
    of_matrix, of_hamilton = (printed(text, form, count) for form in ("matrix", "hamilton"))
    spec, t = of_matrix.spec, 0.3
    parameters, start = dict(resolve_values(spec).parameters), resolve_values(spec)
    n, bound = len(spec.coordinates), len(spec.all_constraints)
    chance = np.random.default_rng(n)
    q, v = (np.array(one) + 0.2 * chance.uniform(-1, 1, n) for one in (start.q, start.v))
    multipliers = chance.uniform(-1, 1, bound).tolist()

    def direct(s: float = 0.0, a: Any = (0.0,) * n, held: Any = (0.0,) * bound) -> Any:
        where, speed = q + v * s + np.array(a) * s**2 / 2, v + np.array(a) * s
        return directly(spec, parameters, t + s, where.tolist(), speed.tolist(), [*a], multipliers=[*held])

    rest = np.array(direct().residual, dtype=float)
    columns = [np.array(direct(a=row).residual, dtype=float) - rest for row in np.eye(n).tolist()]
    mass = np.array(columns).T
    module = module_of(of_matrix, "matrix")
    state = t, q.tolist(), v.tolist()
    own = np.diag(module["masses"](*state)) if "masses" in module else module["mass_matrix"](*state)
    close(own, mass, text)
    close(module["force"](*state), -rest, text)

    module = module_of(of_hamilton, "hamilton")
    p = [float(one) for one in direct().momenta]
    state = t, q.tolist(), p
    close(module["velocities"](*state), v, text)
    close(module["hamiltonian"](*state), float(direct().h), text)
    energy = printed_energy(of_hamilton, state, mass)
    close(module["hamiltonian"](*state) if math.isnan(energy) else energy, float(direct().h), text)
    ends = {k: np.array(direct(k * 1e-3).momenta, dtype=float) for k in (-2, -1, 1, 2)}
    faster = (8 * (ends[1] - ends[-1]) - (ends[2] - ends[-2])) / 0.012  # dp/dt where a = 0
    expected = faster - np.array(direct(held=multipliers).residual, dtype=float)
    rates = module["momentum_rates"](*state, *([multipliers] if bound else []))
    close(rates, expected, text, 1e-7)


def printed_energy(derived: DerivedFamilies, state: Any, mass: Any) -> float:
    """H as it is printed, of q, p and the inverse of M: its text is ours, made from a system of this file."""
    (t, q, p), equations, spec = state, derived.equations, derived.spec
    names: dict[str, Any] = {"t": t, **spec.sizes, **vars(math), "abs": abs}
    names |= {one.name: readback.matrix(one) for one in equations.paths}
    parameters = resolve_values(spec).parameters
    for one in equations.parameters:
        names[one.name] = np.reshape([parameters[name] for name in one.members], one.shape)
    inverse, first = np.linalg.inv(mass), 0
    still, none = [0.0] * len(q), [0.0] * len(spec.all_constraints)
    rest = [float(one) for one in directly(spec, parameters, t, q, still, still, multipliers=none).momenta]
    places = {}
    for one in equations.coordinates:
        places[one.name] = slice(first, first + len(one.members)), one.shape
        first += len(one.members)
        for letter, values in (("", q), ("p_", p), ("b_", rest)):
            names[letter + one.name] = np.reshape(values[places[one.name][0]], one.shape)
    for row, (rows, shape) in places.items():
        for column, (columns, more) in places.items():
            name = f"Minv_{row}" if row == column else f"Minv_{row}_{column}"
            names[name] = np.reshape(inverse[rows, columns], (*shape, *more))
    text = written(derived, "text", "hamilton", {}).partition("  H = ")[2].partition("\n\n")[0]
    places_by_name = any(one.symbol.name.partition("[")[0] in text for one in equations.places)
    return math.nan if places_by_name else float(eval(" ".join(text.split()), names))


def close(found: Any, expected: Any, text: str, tolerance: float = 1e-9) -> None:
    """Whether numbers agree, compared with the largest of them."""
    size = 1 + np.max(np.abs(expected), initial=0.0)
    assert np.max(np.abs(np.array(found) - expected), initial=0.0) <= tolerance * size, text


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize(
    "text", [N_PENDULUM, pendulum(4, "(i - 1)//2"), CHARGED, SHAKEN, TOPS.replace("COUNT", "2")]
)
def test_the_forms_are_those_of_the_file(text: str) -> None:
    hold(text, 3 if text is N_PENDULUM else None)


DRAWN: dict[str, Callable[[random.Random], str]] = {
    "chains and trees": lambda chance: drawn(chance, chance.choice([1, 2, 3, 4])),
    "closed chains": lambda chance: chain(chance.choice([*CASES]), 4),
    "wheels on trees": drawn_on_trees,
    "bodies": lambda chance: drawn_bodies(chance, chance.choice([*KINDS]), chance.choice([1, 2, 3])),
}


@pytest.mark.exhaustive(keep=0.15, most=6)
@pytest.mark.parametrize("case", range(20))
@pytest.mark.parametrize("kind", DRAWN)
def test_the_forms_of_drawn_systems_are_those_of_the_file(
    kind: str, case: int, pytestconfig: pytest.Config
) -> None:
    with suppress(TooLargeSystem):  # long springs between points of bodies are refused
        hold(DRAWN[kind](random.Random(f"{pytestconfig.option.seed} forms {kind} {case}")))
