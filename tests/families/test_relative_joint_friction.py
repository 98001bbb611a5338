"""Friction between links of chains and trees that stay families, beside the same systems written out, closed
forms and conservation."""

from __future__ import annotations

import numpy as np
import pytest

from lagrange_cli.families import system as systems
from lagrange_cli.spec.read import read_spec
from tests.families.test_events import keep_families
from tests.families.test_locked import ALONE, CART, CHAIN, HEAD, MOVING, POWER, SPACE, TOPS, TREE
from tests.families.test_switches import (
    BY_RATES,
    LEDGERS,
    compare,
    compare_long,
    followed,
    ledgers_close,
    ready,
)

HINGES = "sum(F*abs(a_dot[i] - a_dot[i - 1]) for i in range(1, N))"
RODS = TREE.replace("bob", "mid").replace(
    '["x[i]", "y[i]"]', '["x[i] - 0.6*l[i]*sin(a[i])", "y[i] + 0.6*l[i]*cos(a[i])"]'
)
DETENT = "where(i > 0, 4*abs(a[i] - a[i - 1] - 0.1), 0)"
DETENTS = CHAIN.replace("bob[i].y for", f"bob[i].y + {DETENT} for")
CASES = {
    "a chain": (CHAIN, POWER, HINGES),
    "a chain from the ground": (CHAIN, POWER, "F*abs(a_dot[0]) + " + HINGES),
    "some hinges": (CHAIN, POWER, "sum(2*F*abs(a_dot[i] - a_dot[i - 1]) for i in range(1, N) if i % 3 > 0)"),
    "every second link": (CHAIN, POWER, "sum(F*abs(a_dot[i] - a_dot[i - 2]) for i in range(2, N))"),
    "gears": (CHAIN, POWER, "sum(F*abs(2*a_dot[i] + 3*a_dot[i - 1] - w) for i in range(1, N))"),
    "a limit by places": (
        CHAIN, POWER, "sum((F + c*a[i]**2)*abs(a_dot[i] - a_dot[i - 1]) for i in range(1, N))",
    ),
    "drag and springs besides": (
        CHAIN, POWER,
        HINGES + " + sum(c*(a_dot[i] - a_dot[i - 1])**2 for i in range(1, N))\"\ngeneralized_forces: {"
        '"a[i in range(N)]": "sum(-3*(a[i] - a[j]) for j in range(N) if abs(i - j) == 1) + 7*sin(5*t)"'
        '}\nobservables: {all: "sum(a[i] for i in range(N))"}\nname: "c',
    ),
    "a force of each": (
        CHAIN, ALONE,
        "where(i > 0, -F*sign(a_dot[i] - a_dot[i - 1]), 0)"
        " + where(i < N - 1, F*sign(a_dot[i + 1] - a_dot[i]), 0)",
    ),
    "motors": (CHAIN, POWER, HINGES.replace("a_dot[i] - ", "a_dot[i] - w*(-1)**i - ")),
    "detents": (DETENTS, POWER, "sum(c*a_dot[i]**2 for i in range(N))"),
    "a tree": (TREE, POWER, "sum(F*abs(a_dot[i] - a_dot[(i - 1)//2]) for i in range(1, N))"),
    "a chain in space": (SPACE, POWER, HINGES + " + sum(F*abs(b_dot[i])/2 for i in range(N))"),
    "a chain in space, both ways": (
        SPACE, POWER, HINGES + " + sum(F*abs(b_dot[i] - b_dot[i - 1])/3 for i in range(1, N))",
    ),
    "rods": (RODS, POWER, "sum(F*abs(a_dot[i] - a_dot[(i - 1)//2]) for i in range(1, N))"),
    "tops": (TOPS, POWER, "sum(F*abs(s_dot[i] - b_dot[i])/9 for i in range(N))"),
    "a cart that rubs": (CART, POWER, "9*abs(x_dot) + " + HINGES),
}  # fmt: skip


@pytest.fixture(autouse=True)
def no_body_is_written_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """Bodies stay families, however few they are, where others do."""
    monkeypatch.setattr(systems, "FEWEST_TURNING", 0)


def written(case: str, count: int, start: str = MOVING[0], speed: str = MOVING[1]) -> str:
    """The text of a system file."""
    form, key, force = CASES[case]
    return (HEAD + form + key).format(count=count, start=start, speed=speed, force=force)


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize("count", [1, 2, 3, 8, 9, 17])
@pytest.mark.parametrize("case", CASES)
def test_hinges_rub_as_written_out(case: str, count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    compare(written(case, count), monkeypatch, stop=0.9)


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("case", CASES)
def test_hinges_may_begin_at_rest(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    compare(written(case, 9, speed="0"), monkeypatch, stop=0.25)


@pytest.mark.exhaustive(keep=0.35)
@BY_RATES
@pytest.mark.parametrize("case", CASES)
def test_hinges_in_steps_on_rates(case: str, method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    compare(written(case, 3), monkeypatch, stop=0.9, method=method)


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("method", ["taylor", "ias15"])
@pytest.mark.parametrize("case", CASES)
def test_ledgers_have_the_forces_that_hold_links(
    case: str, method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    ledgers_close(written(case, 9), monkeypatch, method)


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize("case", ["a chain", "motors", "a tree", "a cart that rubs"])
def test_hinges_backward_in_time(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    compare(written(case, 3), monkeypatch, LEDGERS, stop=-0.5, backward=True)


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize("case", ["a chain", "a tree", "detents"])
def test_hinges_in_double_double(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    compare_long(written(case, 3), monkeypatch, stop=0.6, most=2.0**-88)


@pytest.mark.exhaustive(keep=0.3)
@pytest.mark.parametrize("limit", [1.0 - 1e-9, 1.0 + 1e-9])
def test_a_chain_that_sticks_is_one_body_until_a_hinge_lets_go(
    limit: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A level chain: hinge i carries g times the sum of m (x - x of the hinge) of all masses beyond. Where
    that of the ground lets go, the whole chain turns about it, as a body does."""
    keep_families(monkeypatch, whole=True)
    torque = "g*sum(m[j]*sum(l[k] for k in range(i, j + 1)) for j in range(i, N))"
    loss = f"sum(2*{torque}*abs(a_dot[i] - a_dot[i - 1]) for i in range(1, N))"
    first = torque.replace("range(i, ", "range(")
    text = (HEAD + CHAIN + POWER).format(
        count=60, start="pi/2", speed="0", force=f"{limit}*{first}*abs(a_dot[0]) + {loss}"
    )
    found = followed(ready(text), text, 0.3)["v/a"]
    assert np.array_equal(found, np.repeat(found[:, :1], 60, axis=1))
    lengths = np.cumsum(1.0 + np.arange(60) / 9.0)
    masses = 1.0 - 0.6 * np.sin(np.arange(60)) ** 2
    lost = 9.8 * np.sum(masses * lengths) / np.sum(masses * lengths**2)
    expected = -lost * max(0.0, 1.0 - limit) * np.linspace(0.0, 0.3, 7)
    assert np.allclose(found[:, 0], expected, rtol=1e-5, atol=0.0)


@pytest.mark.exhaustive(keep=0.5)
def test_links_that_stick_swing_as_one_body(monkeypatch: pytest.MonkeyPatch) -> None:
    """All of them together are a compound pendulum, which keeps its energy."""
    keep_families(monkeypatch, whole=True)
    text = (HEAD + CHAIN + POWER).format(
        count=40, start="0.8", speed="0.1", force=HINGES.replace("F*", "1e7*")
    )
    found = followed(ready(text), text, 2.0)
    assert np.array_equal(found["v/a"], np.repeat(found["v/a"][:, :1], 40, axis=1))
    h = found["diagnostics/h"]
    assert np.all(np.abs(h - h[0]) <= 1e-13 * abs(h[0]))


@pytest.mark.exhaustive(keep=0.3)
def test_the_code_does_not_grow_with_the_links(monkeypatch: pytest.MonkeyPatch) -> None:
    keep_families(monkeypatch, whole=True)
    counts = [len(ready(written("a chain", n)).machine.program.text.splitlines()) for n in (72, 200)]
    assert counts[0] == counts[1]


def test_links_that_may_hold_each_other_in_a_circle_are_written_out() -> None:
    text = (
        written("a chain", 12)
        .replace("a_dot[i - 1]", "a_dot[(i + 1) % N]")
        .replace("range(1, N)", "range(N)")
    )
    spec = read_spec(text, "system.yaml")
    assert systems.any_family_system(spec) is None
    assert "circle" in systems.reason(spec)[0]
