"""Chains at rest that are pushed at one end: far from there, the motion begins as a high power of t."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from tests.support.motion import follow

LETTERS = "abcdefghijkl"


def chain(names: list[str], stiffness: list[float], force: str) -> str:
    springs = [
        f"{k}*({one} - {other})**2/2" for one, other, k in zip(names, names[1:], stiffness, strict=False)
    ]
    return f"""
    coordinates: {{{", ".join(f"{name}: {{initial: 0}}" for name in names)}}}
    masses: {{{", ".join(f"m_{name}: 1" for name in names)}}}
    embedding: {{{", ".join(f"m_{name}: {name}" for name in names)}}}
    potential: {" + ".join(springs)} - {force}*{names[0]}
    """


def modes_of(stiffness: list[float]) -> tuple[np.ndarray, np.ndarray]:
    """The frequencies of normal modes, and these in columns."""
    n = len(stiffness) + 1
    matrix = np.zeros((n, n))
    for i, k in enumerate(stiffness):
        matrix[i : i + 2, i : i + 2] += k * np.array([[1, -1], [-1, 1]])
    squares, modes = np.linalg.eigh(matrix)
    return np.sqrt(np.where(squares > 1e-12, squares, 0.0)), modes


def pushed_at_once(stiffness: list[float], t: float) -> np.ndarray:
    """The coordinates if the force is 1: each mode has an amplitude a with a'' = f - w^2 a."""
    w, modes = modes_of(stiffness)
    return np.asarray(modes @ (modes[0] * t * t / 2 * np.sinc(w * t / 2 / np.pi) ** 2))


def pushed_slowly(stiffness: list[float], t: float) -> np.ndarray:
    """If it is sin(3 t): a = f (sin(3 t) - 3 sin(w t)/w)/(w^2 - 9)."""
    w, modes = modes_of(stiffness)
    return np.asarray(modes @ (modes[0] * (np.sin(3 * t) - 3 * t * np.sinc(w * t / np.pi)) / (w * w - 9)))


FORCES = {"1": pushed_at_once, "sin(3*t)": pushed_slowly}
"""The second one is 0 at the start, as are all velocities."""


@pytest.mark.exhaustive(keep=0.2)
@settings(max_examples=6, deadline=None)
@given(
    st.lists(st.floats(0.1, 5).map(lambda x: round(x, 3)), min_size=1, max_size=11),
    st.sampled_from([*FORCES]),
    st.sampled_from(["taylor", "ias15"]),
)
def test_a_chain_is_where_its_normal_modes_are(stiffness: list[float], force: str, method: str) -> None:
    """ias15 came to no end where a member's motion begins as t^9 or a higher power."""
    assume(np.all(np.abs(modes_of(stiffness)[0] - 3) > 1e-2))
    names = [*LETTERS[: len(stiffness) + 1]]
    motion = follow(chain(names, stiffness, force), 5.0, 3, method=method)
    found = [motion.outcome.final.q[name] for name in names]
    assert found == pytest.approx(FORCES[force](stiffness, 5.0), rel=1e-11, abs=1e-11)
    assert motion.outcome.steps < 1000


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("force", FORCES)
@pytest.mark.parametrize("count", [8, 12, 40, 200])
def test_members_of_a_family_are_there_too(count: int, force: str) -> None:
    """12 and fewer are written out, more are followed as a family."""
    text = f"""
    sizes: {{N: {count}}}
    coordinates: {{"x[i in range(N)]": {{initial: 0}}}}
    masses: {{"m[i in range(N)]": 1}}
    embedding: {{"m[i in range(N)]": "x[i]"}}
    potential: sum((x[i] - x[i + 1])**2/2 for i in range(N - 1)) - x[0]*{force}
    """
    motion = follow(text, 5.0, 3, method="ias15")
    found = [motion.outcome.final.q[f"x[{i}]"] for i in range(count)]
    assert found == pytest.approx(FORCES[force]([1.0] * (count - 1), 5.0), abs=1e-12)
    assert motion.outcome.steps < 1000


@pytest.mark.exhaustive(keep=0.15)
def test_ledgers_of_a_hanging_chain_that_is_pushed_from_rest() -> None:
    text = """
    sizes: {N: 30}
    coordinates: {"th[i in range(N)]": {initial: 0}}
    masses: {"bob[i in range(N)]": 1}
    definitions:
      "x[i in range(N)]": sin(th[i]) + where(i > 0, x[i - 1], 0)
      "y[i in range(N)]": -cos(th[i]) + where(i > 0, y[i - 1], 0)
    embedding: {"bob[i in range(N)]": ["x[i]", "y[i]"]}
    potential: sum(9.81*bob[i].y for i in range(N)) - 3*bob[0].x*sin(t)
    """
    motion = follow(text, 0.5, 3, outputs=("q", "v", "ledger"))
    assert motion.outcome.t == 0.5
    ledgers = [path for path in motion.data if "ledger" in path]
    # energies are some thousands
    assert ledgers and all(np.max(np.abs(motion[path])) < 1e-11 for path in ledgers)
