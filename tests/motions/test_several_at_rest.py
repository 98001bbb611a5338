"""Several velocities with friction that are 0 at one time: which of them stay 0, and how the others begin."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import lagrange_cli as lagrange

Array = NDArray[np.float64]
METHODS = {"taylor": 1e-12, "ias15": 1e-12, "DOP853": 1e-9, "Radau": 1e-7}
PILE = """
parameters: {F0: 1, F1: 1, F2: 1, P: 1, al: 0}
coordinates:
  {x0: {initial: 0}, y0: {initial: 0}, x1: {initial: 0}, y1: {initial: 0}, x2: {initial: 0}, y2: {initial: 0}}
masses: {a: 1, b: 2, c: 1.5}
positions: {a: [x0, y0], b: [x1, y1], c: [x2, y2]}
potential: 0
dissipation: >-
  F0*norm((x0_dot, y0_dot)) + F1*norm((x1_dot - x0_dot, y1_dot - y0_dot))
  + F2*norm((x2_dot - x1_dot, y2_dot - y1_dot))
forces: {c: "(P*cos(al), P*sin(al))"}
"""


def pile(limits: tuple[float, float, float], pull: float) -> Array:
    """The accelerations of blocks on one another of which the top is pulled: by trial of all ways in which
    they may move as one with what is below them, or slide on it."""
    masses, best = (1.0, 2.0, 1.5), None
    for moves in np.ndindex(2, 2, 2):  # by trial: what slides on what lies below
        groups: list[list[int]] = []
        for k, slides in enumerate(moves):
            if slides:
                groups.append([k])
            elif groups:
                groups[-1].append(k)
        rates, above = np.zeros(3), pull
        forces = np.zeros(3)  # from each block on the one below
        for group in reversed(groups):
            mass = sum(masses[k] for k in group)
            rates[group] = (above - limits[group[0]]) / mass
            above = limits[group[0]]
        carried = pull
        for k in (2, 1, 0):
            carried -= masses[k] * rates[k]
            forces[k] = carried
        slips = np.diff(rates, prepend=0.0)
        good = all(
            slips[k] > 0.0 if slides else abs(forces[k]) <= limits[k] + 1e-12
            for k, slides in enumerate(moves)
        )
        if good:
            assert best is None or np.allclose(best, rates)
            best = rates
    assert best is not None
    return best


CASES = [
    ((1.0, 2.0, 1.5), 0.5),  # all stick
    ((1.0, 2.0, 1.5), 1.2),  # all as one
    ((1.0, 2.0, 1.5), 3.0),  # two as one, and the top
    ((3.0, 3.0, 1.5), 3.5),  # the top alone, though all others are at their limits if it sticks
    ((2.0, 1.0, 3.0), 2.5),  # two together on one at rest
    ((1.0, 1.4, 2.0), 9.0),  # each by itself
    ((1.0, 1.0, 1.0), 1.5),  # the others are pulled as far as they hold
]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("limits", "pull"), CASES)
def test_a_pile_that_is_pulled_at_the_top(
    limits: tuple[float, float, float], pull: float, method: str
) -> None:
    sets = dict(zip(("F0", "F1", "F2", "P", "al"), (*limits, pull, 0.7)))
    motion = lagrange.solve(PILE, set=sets, stop=1, samples=3, method=method)
    rates = pile(limits, pull)
    for k, rate in enumerate(rates.tolist()):
        expected = rate * motion.t**2 / 2
        assert motion.q[f"x{k}"] == pytest.approx(np.cos(0.7) * expected, abs=METHODS[method])
        assert motion.q[f"y{k}"] == pytest.approx(np.sin(0.7) * expected, abs=METHODS[method])


def test_what_holds_when_the_pull_grows_slides_later() -> None:
    """With a pull of 2 t, the top slides alone from t = 0.75 on, at the limit of what is below it no more."""
    text = PILE.replace("P*cos(al), P*sin(al)", "2*t*cos(al), 2*t*sin(al)")
    motion = lagrange.solve(text, set={"F0": 2, "F1": 2, "F2": 1.5, "al": 0.7}, stop=2, samples=21)
    past = np.fmax(motion.t - 0.75, 0.0)
    assert np.hypot(motion.q["x2"], motion.q["y2"]) == pytest.approx(past**3 / 4.5, abs=1e-13)
    assert np.abs(motion.q["x1"]).max() < 1e-30 and not motion.q["y0"].any()


def random_system(source: np.random.Generator, parts: list[int], digits: int | None) -> tuple[str, Array]:
    """A system at rest whose coordinates have any masses, are pulled by any forces, and rub on one another by
    any velocities; its accelerations, from a fixed point of the forces of friction. Coefficients have so many
    decimal digits, or else are quarters."""
    width, count = sum(parts), sum(parts) + 1
    factor = source.normal(size=(count, count))
    M = np.round(factor @ factor.T / count + 0.3 * np.eye(count), 3)
    while True:
        B = source.normal(size=(width, count))
        B = np.round(4 * B) / 4 if digits is None else np.round(B, digits)
        if np.linalg.matrix_rank(B) == width and np.linalg.cond(B) < 50:
            break
    Q, limits = np.round(2 * source.normal(size=count), 3), np.round(source.uniform(0.2, 1.5, len(parts)), 3)
    ends = np.cumsum(parts)
    terms, places = [], [slice(end - one, end) for end, one in zip(ends.tolist(), parts)]
    for place, limit in zip(places, limits):
        sums = [" + ".join(f"({b})*x{k}_dot" for k, b in enumerate(row)) for row in B[place]]
        terms.append(f"{limit}*" + (f"abs({sums[0]})" if len(sums) == 1 else f"norm(({', '.join(sums)}))"))
    kinetic = " + ".join(f"{M[i, j]}*x{i}_dot*x{j}_dot/2" for i, j in np.ndindex(count, count))
    text = (
        f"coordinates: {{{', '.join(f'x{k}: {{initial: 0}}' for k in range(count))}}}\n"
        f'lagrangian: "{kinetic} + {" + ".join(f"({c})*x{k}" for k, c in enumerate(Q))}"\n'
        f'dissipation: "{" + ".join(terms)}"\n'
    )
    inverse = np.linalg.inv(M)
    W, free = B @ inverse @ B.T, B @ inverse @ Q
    step, forces = 1.0 / np.linalg.eigvalsh(W)[-1], np.zeros(width)
    for _ in range(200000):
        moved = forces + step * (free - W @ forces)
        for place, limit in zip(places, limits):
            moved[place] *= min(1.0, limit / np.linalg.norm(moved[place]))
        done, forces = np.max(np.abs(moved - forces)) < 1e-15, moved
        if done:
            break
    return text, inverse @ (Q - B.T @ forces)


@pytest.mark.parametrize("digits", [None, 2])
@pytest.mark.parametrize("parts", [[1, 1, 1], [2, 2], [2, 1, 1], [2, 2, 2], [3, 2]])
def test_any_velocities_at_rest(parts: list[int], digits: int | None, request: pytest.FixtureRequest) -> None:
    source = np.random.default_rng([request.config.option.seed, *parts])
    text, rates = random_system(source, parts, digits)
    motion = lagrange.solve(text, stop=2.0**-10, samples=2)
    found = np.array([motion.v[f"x{k}"][-1] for k in range(len(rates))]) * 2.0**10
    np.testing.assert_allclose(found, rates, rtol=0, atol=1e-8 * (1 + np.abs(rates).max()), err_msg=text)


def test_after_a_stop_by_an_event_as_from_the_start() -> None:
    """A pile that slides as one into a stop, which takes all velocities away, goes on as from rest."""
    moving = PILE.replace("x0: {initial: 0}", "x0: {initial: -0.1, velocity: 3}")
    for k in (1, 2):
        moving = moving.replace(f"x{k}: {{initial: 0}}", f"x{k}: {{initial: 0, velocity: 3}}")
    stop = "events:\n  stop: {when: x0, action: {set: {" + ", ".join(
        f"{c}{k}_dot: 0" for c in "xy" for k in range(3)
    )
    sets = {"F0": 3, "F1": 3, "F2": 1.5, "P": 3.5, "al": 0.7}
    motion = lagrange.solve(moving + stop + "}}}\n", set=sets, stop=1, samples=2)
    happened = motion.events["stop"]["t"][0]
    rate = (3.5 - 1.5) / 1.5
    assert motion.v["x2"][-1] == pytest.approx(np.cos(0.7) * rate * (1 - happened), abs=1e-12)
    assert motion.v["y2"][-1] == pytest.approx(np.sin(0.7) * rate * (1 - happened), abs=1e-12)
    assert motion.v["x1"][-1] == motion.v["y0"][-1] == 0


WEIGHTS = """
parameters: {g: 9.81, low: 0.3, up: 0.2, P: 5}
coordinates:
  {x: {initial: 0}, y: {initial: 0}, z: {initial: 0}, a: {initial: 0}, b: {initial: 0}, c: {initial: 1}}
masses: {one: 2, other: 1}
positions: {one: [x, y, z], other: [a, b, c]}
potential: g*(2*z + c)
constraints: {table: SIGNz, top: SIGN(c - z - 1)}
definitions: {v: "(x_dot, y_dot, z_dot)", w: "(a_dot - x_dot, b_dot - y_dot, c_dot - z_dot)"}
forces:
  one: -SIGN1*low*table.multiplier*v/norm(v) + SIGN1*up*top.multiplier*w/norm(w)
  other: "(0.6*P, 0.8*P, 0) - SIGN1*up*top.multiplier*w/norm(w)"
"""


@pytest.mark.parametrize("sign", ["", "-"])
@pytest.mark.parametrize(
    ("low", "up", "pull"), [(0.3, 0.2, 1.5), (0.3, 0.2, 5), (0.03, 0.25, 2.9), (0.03, 0.2, 5)]
)
def test_limits_by_forces_of_constraint(low: float, up: float, pull: float, sign: str) -> None:
    """One block on another one on a table, with their weights as multipliers of either sign."""
    text = WEIGHTS.replace("SIGN1*", "-1*" if sign else "").replace("SIGN", sign)
    motion = lagrange.solve(text, set={"low": low, "up": up, "P": pull}, stop=1, samples=2)
    of_table, of_top = low * 3 * 9.81, up * 9.81
    together = max(pull - of_table, 0.0) / 3
    rates = (together, together)
    if pull - together > of_top:
        rates = max(of_top - of_table, 0.0) / 2, pull - of_top
    for names, rate in zip(("xy", "ab"), rates):
        for name, part in zip(names, (0.6, 0.8)):
            assert motion.v[name][-1] == pytest.approx(part * rate, abs=1e-12)


@pytest.mark.parametrize("belt", [0, 0.5])
def test_a_small_term_under_the_root_lets_a_body_creep(belt: float) -> None:
    """Friction 2 u/sqrt(u^2 + e^2) balances a force of 1 at u = e/sqrt(3): e^2 = 1e-12 is not rounding."""
    text = f"""
coordinates: {{x: {{initial: 0, velocity: {belt}}}, y: {{initial: 0}}}}
masses: {{puck: 1}}
positions: {{puck: [x, y]}}
potential: 0
definitions: {{u: "(0.3*x_dot - {0.3 * belt}, 0.3*y_dot)"}}
forces: {{puck: "(0.6, 0.8) - 2*u/sqrt(dot(u, u) + 1e-12)"}}
"""
    motion = lagrange.solve(text, stop=1e-4, samples=3)
    slip = np.hypot(motion.v["x"][-1] - belt, motion.v["y"][-1])
    assert slip == pytest.approx(1e-6 / 0.3 / np.sqrt(3), rel=1e-6)
