"""Chains at rest that are pushed at one end: far from there, the motion begins as a high power of t."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.motion import follow

LETTERS = "abcdefghijkl"


def chain(names: list[str], stiffness: list[float], force: float) -> str:
    springs = [
        f"{k}*({one} - {other})**2/2" for one, other, k in zip(names, names[1:], stiffness, strict=False)
    ]
    return f"""
    coordinates: {{{", ".join(f"{name}: {{initial: 0}}" for name in names)}}}
    masses: {{{", ".join(f"m_{name}: 1" for name in names)}}}
    embedding: {{{", ".join(f"m_{name}: {name}" for name in names)}}}
    potential: {" + ".join(springs)} - {force}*{names[0]}
    """


def exact(stiffness: list[float], force: float, t: float) -> np.ndarray:
    """The coordinates, by normal modes: each has an amplitude a with a'' = f - w^2 a."""
    n = len(stiffness) + 1
    matrix = np.zeros((n, n))
    for i, k in enumerate(stiffness):
        matrix[i : i + 2, i : i + 2] += k * np.array([[1, -1], [-1, 1]])
    squares, modes = np.linalg.eigh(matrix)
    pushed = force * modes[0]
    half = np.sqrt(np.abs(squares)) * t / 2
    amplitudes = pushed * t * t / 2 * np.sinc(half / np.pi) ** 2
    return np.asarray(modes @ amplitudes)


@settings(max_examples=6, deadline=None)
@given(
    st.lists(st.floats(0.1, 5).map(lambda x: round(x, 3)), min_size=1, max_size=11),
    st.sampled_from([0.1, -2.0]),
    st.sampled_from(["taylor", "ias15"]),
)
def test_a_chain_is_where_its_normal_modes_are(stiffness: list[float], force: float, method: str) -> None:
    """ias15 came to no end where a member's motion begins as t^9 or a higher power."""
    names = [*LETTERS[: len(stiffness) + 1]]
    motion = follow(chain(names, stiffness, force), 5.0, 3, method=method)
    found = [motion.outcome.final.q[name] for name in names]
    assert found == pytest.approx(exact(stiffness, force, 5.0), rel=1e-12, abs=1e-12 * abs(force))
    assert motion.outcome.steps < 1000


@pytest.mark.parametrize("count", [8, 12, 40, 200])
def test_members_of_a_family_are_there_too(count: int) -> None:
    """12 and fewer are written out, more are followed as a family."""
    text = f"""
    sizes: {{N: {count}}}
    coordinates: {{"x[i in range(N)]": {{initial: 0}}}}
    masses: {{"m[i in range(N)]": 1}}
    embedding: {{"m[i in range(N)]": "x[i]"}}
    potential: sum((x[i] - x[i + 1])**2/2 for i in range(N - 1)) - x[0]
    """
    motion = follow(text, 5.0, 3, method="ias15")
    found = [motion.outcome.final.q[f"x[{i}]"] for i in range(count)]
    assert found == pytest.approx(exact([1.0] * (count - 1), 1.0, 5.0), abs=1e-12)
    assert motion.outcome.steps < 1000
