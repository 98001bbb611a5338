"""Families with dry friction between members, beside the same systems written out and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lagrange_cli.families.system import reason
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.families import family_run
from lagrange_cli.integrate.guards.pivoting import dip
from lagrange_cli.spec.read import read_spec
from tests.families.test_events import keep_families
from tests.families.test_friction import MOVING, blocks
from tests.families.test_switches import (
    BY_RATES,
    LEDGERS,
    OUTPUTS,
    compare,
    counted_series,
    followed,
    long_motions,
    ready,
)
from tests.support.draws import examples

CASES = {
    "neighbours": "sum(F*abs(x_dot[i] - x_dot[i - 1]) for i in range(1, N))",
    "in the opposite order": "sum(F*abs(x_dot[i - 1] - x_dot[i]) for i in range(1, N))",
    "that are damped": "sum(F*abs(x_dot[i] - x_dot[i - 1]) + c*x_dot[i]**2 for i in range(1, N))",
    "a stack on the floor": "sum(F*(N - i)*abs(x_dot[i] - where(i > 0, x_dot[i - 1], 0)) for i in range(N))",
    "all on the first": "sum(F*(1 + i/9)*abs(x_dot[i] - x_dot[0]) for i in range(1, N))",
    "pairs": "sum(F*abs(x_dot[i] - x_dot[i - 1]) for i in range(1, N, 2))",
    "gears": "sum(F*abs(x_dot[i] - 0.7*x_dot[i - 1]) for i in range(1, N))",
    "belts between them": "sum(F*abs(x_dot[i] - x_dot[i - 1] - w[i]) for i in range(1, N))",
    "differentials": "sum(F*abs(x_dot[i] - 0.4*x_dot[i - 1] - 0.5*x_dot[i - 2]) for i in range(2, N, 2))",
    "on each other and on wedges": "sum(F*abs(2*x_dot[i] - where(i > 0, x_dot[i - 1], 0)) for i in range(N))",
    "a limit that depends on places": "sum((F + x[i]**2)*abs(x_dot[i] - x_dot[i - 1]) for i in range(1, N))",
}
BY_HAND = (
    "where(i > 0, -F*sign(x_dot[i] - x_dot[i - 1]), 0) + where(i < N - 1, F*sign(x_dot[i + 1] - x_dot[i]), 0)"
)
"""The forces of the first case."""


def lossy(loss: str, count: int, start: str = MOVING[0], speed: str = MOVING[1]) -> str:
    """The text of a system file with a dissipation function."""
    return blocks(count, "0", start, speed).replace("(-1)**i", "cos(3*i)") + f'dissipation: "{loss}"\n'


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("count", [2, 3, 8, 9])
@pytest.mark.parametrize("case", CASES)
def test_friction_between_members(case: str, count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    compare(lossy(CASES[case], count), monkeypatch, stop=4.0)


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("case", CASES)
def test_members_may_begin_at_rest(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    compare(lossy(CASES[case], 9, "3*sin(5*i)", "0"), monkeypatch, stop=3.0)


@pytest.mark.exhaustive(keep=0.2)
@BY_RATES
@pytest.mark.parametrize("case", CASES)
def test_friction_between_members_in_steps_on_rates(
    case: str, method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    compare(lossy(CASES[case], 3), monkeypatch, stop=3.9, method=method)


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("method", ["taylor", "ias15"])
@pytest.mark.parametrize("case", ["neighbours", "a stack on the floor"])
def test_ledgers_have_the_forces_between_members(
    case: str, method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    compare(lossy(CASES[case], 3), monkeypatch, LEDGERS, stop=3.0, method=method)


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("count", [2, 3, 9])
def test_forces_that_are_written_for_each_member(count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each relative velocity is in the forces on two members, with either sign, and followed once."""
    text = blocks(count, BY_HAND)
    keep_families(monkeypatch, whole=True)
    assert len(ready(text).machine.program.guards) == count - 1
    compare(text, monkeypatch, stop=4.0)


@pytest.mark.exhaustive(keep=0.25)
@given(data=st.data())
@examples(2)
def test_random_stacks(data: st.DataObject) -> None:
    number = st.floats(0.1, 3.0).map(lambda x: round(x, 2))
    case, count = data.draw(st.sampled_from([*CASES])), data.draw(st.integers(2, 9))
    a, b, limit, spring = (data.draw(number) for _ in range(4))
    with pytest.MonkeyPatch.context() as monkeypatch:
        compare(stack(case, count, a, b, limit, spring), monkeypatch, stop=3.0)


def stack(case: str, count: int, a: float, b: float, limit: float, spring: float) -> str:
    """The text of the system file of a stack that is drawn at random."""
    text = lossy(CASES[case], count, f"0.5*sin({a}*i + 1)", f"cos({b}*i*i + 1)")
    return text.replace("F: 0.6", f"F: {limit}").replace("k: 2", f"k: {spring}")


@pytest.mark.exhaustive(keep=0.2)
def test_a_stack_that_has_come_to_rest_takes_no_short_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is left of velocities does not change any more."""
    text = stack("a stack on the floor", 8, 1.0, 0.5, 2.75, 1.0)
    compare(text, monkeypatch, stop=3.0)
    keep_families(monkeypatch, whole=True)
    speeds = followed(ready(text), text, 3.0)["v/x"]
    assert np.max(np.abs(speeds[-1])) <= 2.0**-50
    assert np.array_equal(speeds[-2], speeds[-1])


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.parametrize("method", ["taylor", "ias15"])
def test_members_that_come_to_stick_move_as_one(method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """From t = 0.93 on. Before, what is behind the digits of their velocities has nothing in common. (Steps
    on rates would follow differences of one digit, and be half as long.)"""
    keep_families(monkeypatch, whole=True)
    text = stack("that are damped", 6, 0.42, 2.71, 1.58, 0.71)
    motion = followed(ready(text, method=method), text, 3.0)
    speeds = motion["v/x"]
    assert np.ptp(speeds[1]) > 0.1
    assert np.array_equal(speeds[2:], np.repeat(speeds[2:, :1], 6, axis=1))
    assert motion.outcome.steps <= 30


@pytest.mark.exhaustive(keep=0.65)
@pytest.mark.parametrize("method", ["taylor", "ias15", "DOP853"])
def test_members_that_stick_move_as_one(method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Equal velocities stay so to the last bit, however unlike masses and forces are. A light block that a
    large force pulls takes a heavy one along: m a = F/M in total, far more precise than F/M less what the
    light one is held by."""
    keep_families(monkeypatch, whole=True)
    text = lossy("sum(9*abs(x_dot[i] - x_dot[i - 1]) for i in range(1, N))", 5, "0", "0")
    text = text.replace("1 + i/7", "where(i % 2 == 0, 1e-9, 1)").replace("(x[i] - V*t)**2/2", "0*x[i]")
    text = text.replace('"0"\ndiss', '"where(i == 0, 3 + sin(t), 0)"\ndiss')
    motion = followed(ready(text, method=method), text, 3.0)
    speeds, times = motion["v/x"], np.linspace(0.0, 3.0, 7)
    assert np.array_equal(speeds, np.repeat(speeds[:, :1], 5, axis=1))
    expected = (3.0 * times + 1.0 - np.cos(times)) / (2.0 + 3e-9)
    assert np.allclose(speeds[:, 0], expected, rtol=1e-15 if method != "DOP853" else 1e-11, atol=1e-15)


@pytest.mark.exhaustive(keep=0.3)
@pytest.mark.parametrize("method", ["taylor", "ias15"])
def test_blocks_on_a_board_that_is_stopped(method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A board with speed V takes blocks along: these slide until they have its speed. With the mass M of the
    board and m of N blocks: v' = F/m of each, V' = -N F/M, so all have MV/(M + N m) from t = V/(F/m + N F/M)
    on."""
    keep_families(monkeypatch, whole=True)
    text = """
sizes: {N: 8}
parameters: {F: 0.3, m: 0.5, M: 2}
coordinates: {"x[i in range(N + 1)]": {initial: 0, velocity: "where(i == 0, 1, 0)"}}
masses: {"block[i in range(N + 1)]": "where(i == 0, M, m)"}
embedding: {"block[i in range(N + 1)]": "x[i]"}
potential: 0
dissipation: sum(F*abs(x_dot[i] - x_dot[0]) for i in range(1, N + 1))
"""
    motion = followed(ready(text, LEDGERS, method=method), text, 3.0)
    times, both = np.linspace(0.0, 3.0, 7), 1.0 / (0.3 / 0.5 + 8 * 0.3 / 2.0)
    since = np.minimum(times, both)
    speed = 2.0 / (2.0 + 8 * 0.5)
    assert np.allclose(motion["v/x"][:, 1:], 0.3 / 0.5 * since[:, None], rtol=0.0, atol=1e-15)
    assert np.allclose(motion["v/x"][-1], speed, rtol=0.0, atol=1e-15)
    assert np.all(np.abs(motion["diagnostics/ledger/h"]) <= 1e-14)


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("count", [2, 9])
def test_a_chain_that_is_pulled_sticks_until_the_pull_exceeds_its_limit(
    count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A force t pulls the last of N equal blocks. They move together, v = t^2/(2 N), until the force on the
    others, t (N - 1)/N, is F: then these have a = F/(N - 1), and the last one a = t - F."""
    keep_families(monkeypatch, whole=True)
    text = lossy(CASES["neighbours"], count, "0", "0").replace("1 + i/7", "1")
    text = text.replace("k: 2, V: 0.7", "k: 0, V: 0").replace("(x[i] - V*t)**2/2", "0*x[i]")
    text = text.replace('"0"\ndiss', '"where(i == N - 1, t, 0)"\ndiss')
    motion, times = followed(ready(text), text, 3.0), np.linspace(0.0, 3.0, 7)
    slips = 0.6 * count / (count - 1)
    since, together = np.maximum(0.0, times - slips), np.minimum(times, slips) ** 2 / (2 * count)
    others = together + 0.6 * since / (count - 1)
    last = together + (times**2 - slips**2) * (times > slips) / 2 - 0.6 * since
    assert np.allclose(motion["v/x"][:, :-1], others[:, None], rtol=0.0, atol=1e-14)
    assert np.allclose(motion["v/x"][:, -1], last, rtol=0.0, atol=1e-14)


@pytest.mark.exhaustive(keep=0.25)
def test_series_to_settle_do_not_grow_with_the_members(monkeypatch: pytest.MonkeyPatch) -> None:
    """All begin at rest, and springs pull many of them apart."""
    keep_families(monkeypatch, whole=True)
    calls = counted_series(monkeypatch)

    def series(count: int) -> int:
        text = lossy(CASES["neighbours"], count, "where(i % 3 == 0, -2*cos(i), 0.1)", "0")
        calls[0] = 0
        followed(ready(text.replace("k: 2", "k: 0")), text.replace("k: 2", "k: 0"), 0.01)
        return calls[0]

    assert series(200) <= 2 * series(50) <= 100


@pytest.mark.exhaustive(keep=0.35)
def test_what_is_said_of_members_does_not_grow_with_them(monkeypatch: pytest.MonkeyPatch) -> None:
    keep_families(monkeypatch, whole=True)
    found = [
        ready(lossy(CASES["neighbours"], count)).machine.program.text for count in (120, 248)
    ]  # both states are copied in parts
    one, other = (len(text.splitlines()) for text in found)
    assert one == other


@pytest.mark.exhaustive(keep=0.35)
def test_friction_between_members_in_double_double(monkeypatch: pytest.MonkeyPatch) -> None:
    one, other = long_motions(lossy(CASES["neighbours"], 3), monkeypatch, 3.0, OUTPUTS)
    for path in ("q/x", "v/x"):
        change = one[path] - other[path] + one[f"low/{path}"] - other[f"low/{path}"]
        assert np.max(np.abs(change)) <= 2.0**-90, path


@pytest.mark.parametrize(
    "loss, why",
    [
        (
            "sum(F*abs(x_dot[i] - x_dot[i - 1]) for i in range(1, N)) + F*abs(x_dot[0] - x_dot[N - 1])",
            "circle",
        ),
        (
            "sum(F*abs(x_dot[i] - x_dot[i - 1]) for i in range(1, N)) + sum(abs(x_dot[i]) for i in range(N))",
            "circle",
        ),
        ("sum(F*abs(x_dot[i]*(1 + x[i]**2) - 1) for i in range(N))", "jump"),
    ],
)
def test_other_friction_goes_through_the_members(
    loss: str, why: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    keep_families(monkeypatch, whole=True)
    spec = read_spec(lossy(loss, 4), "system.yaml")
    assert family_run(spec, Compilation("taylor", 2.0**-52, OUTPUTS)) is None
    assert why in "".join(reason(spec))


def test_forces_without_a_counterforce_go_through_the_members(monkeypatch: pytest.MonkeyPatch) -> None:
    keep_families(monkeypatch, whole=True)
    spec = read_spec(blocks(4, "where(i > 0, -F*sign(x_dot[i] - x_dot[i - 1]), 0)"), "system.yaml")
    assert family_run(spec, Compilation("taylor", 2.0**-52, OUTPUTS)) is None


def test_a_parameter_that_may_be_1_gives_no_counterforce(monkeypatch: pytest.MonkeyPatch) -> None:
    """The numbers that forces are compared with are no special ones, such as 1."""
    keep_families(monkeypatch, whole=True)
    force = BY_HAND.replace("F*sign(x_dot[i + 1]", "w[2]*F*sign(x_dot[i + 1]")
    spec = read_spec(blocks(5, force), "system.yaml")
    assert family_run(spec, Compilation("taylor", 2.0**-52, OUTPUTS)) is None


@pytest.mark.parametrize(
    "series, least",
    [([0.0, 1.0, -2.0], 0.0), ([-1.0, -1.0], 0.0), ([-1e-8, 1.0], 2.5e-17), ([-1e-8, -1e-8, 1.0], 3e-13)],
)
def test_how_far_a_series_dips(series: list[float], least: float) -> None:
    """-a t + t^2 falls to -a^2/4."""
    found = dip(np.array(series))
    assert least <= found <= 10 * least
