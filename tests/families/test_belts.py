"""Dry friction relative to what moves as t and places say: belts and turntables, beside the same systems
written out, and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lagrange_cli.families.system import any_family_system
from lagrange_cli.native.guards import EXPLICIT
from lagrange_cli.spec.read import read_spec
from tests.families.test_events import keep_families
from tests.families.test_friction import MOVING, blocks
from tests.families.test_switches import (
    BY_RATES,
    LEDGERS,
    compare,
    compare_long,
    followed,
    ledgers_close,
    ready,
)
from tests.families.test_vector_friction import HEAD, PUSHED, SPRINGS, move_alike
from tests.support.draws import examples

STILL = "3*sin(5*i)", "0"
ALONG = {
    "a belt that swings": "-F*sign(x_dot[i] - V*cos(t))",
    "belts that swing apart": "-F*(1 + i)*sign(x_dot[i] - V*cos(3*t + i))",
    "faster with the place": "-F*sign(x_dot[i] - 0.4*x[i])",
    "carried by the place before": "-F*sign(x_dot[i] - where(i > 0, 0.4*x[i - 1], 0.1*t))",
    "a limit by places": "-F*(1 + x[i]**2)*sign(V*sin(2*t) - 2*x_dot[i])*-1",
    "a wall beside it": "-F*sign(x_dot[i] - V*cos(t)) - where(x[i] > 1, 4, 0)",
    "a belt that runs ever faster": "-F*sign(x_dot[i] - 2*t**2)",
}
"""Forces along one velocity each."""
BELTS = {
    "a belt": (PUSHED, "w/3", "0"),
    "belts of their own": ("0", "w/3", "0.1*i"),
    "springs on a belt": (SPRINGS, "w/3", "0"),
    "belts that swing": (SPRINGS, "w*cos(5*t)/4", "w*sin(3*t + i)/9"),
    "a turntable": (PUSHED, "(-w/3*y[i])", "(w/3*x[i])"),
    "a turntable alone": ("0", "(-w/3*y[i])", "(w/3*x[i])"),
}
"""A potential, and the two components of the velocity of what bodies rub on."""
FEATURES = {"count": 3, "F": 0.7, "k": 6.0, "c": 0.2, "w": 1.1, "speed": 0.6}


def on_belt(case: str, **changed: float) -> str:
    """The text of a system file with friction in the plane."""
    potential, u, w = BELTS[case]
    loss = f"sum(F*norm((p[i].vx - {u}, p[i].vy - {w})) for i in range(N))"
    return (HEAD + f'potential: "{potential}"\ndissipation: "{loss}"\n').format(**(FEATURES | changed))


@pytest.mark.exhaustive(keep=0.3)
@pytest.mark.parametrize("start", [MOVING, STILL])
@pytest.mark.parametrize("count", [1, 3, 8])
@pytest.mark.parametrize("case", ALONG)
def test_blocks_on_belts(
    case: str, count: int, start: tuple[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    compare(blocks(count, ALONG[case], *start), monkeypatch, stop=4.0)


@pytest.mark.exhaustive(keep=0.3)
@BY_RATES
@pytest.mark.parametrize("case", ALONG)
def test_blocks_on_belts_in_steps_on_rates(case: str, method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    compare(blocks(3, ALONG[case]), monkeypatch, stop=3.9, method=method)


@pytest.mark.exhaustive(keep=0.3)
@pytest.mark.parametrize("speed", [0.6, 0.0])
@pytest.mark.parametrize("count", [1, 3, 8])
@pytest.mark.parametrize("case", BELTS)
def test_bodies_on_belts(case: str, count: int, speed: float, monkeypatch: pytest.MonkeyPatch) -> None:
    move_alike(on_belt(case, count=count, speed=speed), monkeypatch, slack=50)


@pytest.mark.exhaustive(keep=0.3)
@BY_RATES
@pytest.mark.parametrize("case", BELTS)
def test_bodies_on_belts_in_steps_on_rates(case: str, method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    move_alike(on_belt(case), monkeypatch, method, slack=300)


@pytest.mark.exhaustive(keep=0.4)
@pytest.mark.parametrize("method", ["taylor", "ias15"])
@pytest.mark.parametrize("case", BELTS)
def test_ledgers_have_the_work_of_belts(case: str, method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    ledgers_close(on_belt(case), monkeypatch, method)


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize("method", ["taylor", "ias15"])
def test_ledgers_have_the_work_of_belts_along_one_velocity(
    method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    ledgers_close(blocks(3, ALONG["belts that swing apart"]), monkeypatch, method)


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.parametrize("text", [on_belt("belts that swing"), blocks(3, ALONG["a wall beside it"])])
def test_belts_in_double_double(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    compare_long(text, monkeypatch, stop=0.6, most=2.0**-70)


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize("case", ["carried by the place before", "a wall beside it"])
def test_belts_backward_in_time(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    compare(blocks(3, ALONG[case]), monkeypatch, stop=-0.5, backward=True)


@pytest.mark.exhaustive(keep=0.25)
def test_what_rests_on_a_belt_backward_in_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is pushed beyond the limit of friction, and begins to slide with t as without."""
    text = on_belt("a belt", F=0.05).replace('"0.6*sin(3*i + 1)"', '"w/3"').replace('"0.6*cos(5*i)"', "0")
    compare(text, monkeypatch, stop=-0.5, backward=True)


@pytest.mark.exhaustive(keep=0.15)
@given(data=st.data())
@examples(3)
def test_random_belts(data: st.DataObject) -> None:
    number = st.floats(0.1, 2.0).map(lambda x: round(x, 2))
    a, b, limit, spring, rate = (data.draw(number) for _ in range(5))
    count = data.draw(st.integers(1, 9))
    belt = data.draw(st.sampled_from([f"{a}*sin({rate}*t + i)", f"{a}*x[i]/3 + {b}*t", f"{a} - {b}*t"]))
    force = f"-F*sign(x_dot[i] - {belt})"
    text = blocks(count, force, f"{a}*sin({b}*i + 1)", f"cos({a}*i*i)").replace("F: 0.6", f"F: {limit}")
    with pytest.MonkeyPatch.context() as monkeypatch:
        compare(text.replace("k: 2", f"k: {spring}"), monkeypatch, stop=3.0)


@pytest.mark.exhaustive(keep=0.25)
@given(data=st.data())
@examples(3)
def test_random_bodies_on_belts(data: st.DataObject) -> None:
    number = st.floats(0.2, 1.5).map(lambda x: round(x, 2))
    case, count = data.draw(st.sampled_from([*BELTS])), data.draw(st.integers(1, 6))
    limit, spring, rate, speed = (data.draw(number) for _ in range(4))
    text = on_belt(case, count=count, F=limit, k=spring, w=rate, speed=speed)
    with pytest.MonkeyPatch.context() as monkeypatch:
        move_alike(text, monkeypatch, slack=400)


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize("method", ["taylor", "ias15", "DOP853"])
def test_blocks_stick_to_a_belt_until_it_is_too_fast(method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A belt with the velocity t^2/2 takes 400 blocks along while their m t is less than friction. They slide
    from t = F/m on, with the acceleration F/m."""
    keep_families(monkeypatch, whole=True)
    text = blocks(400, "-F*sign(x_dot[i] - t**2/2)", "0", "0").replace("k: 2, V: 0.7", "k: 0, V: 0")
    text = text.replace("(x[i] - V*t)**2/2", "0*x[i]")
    prepared = ready(text, frozenset({"q", "v"}), method=method)
    assert prepared.machine.program.guards == (EXPLICIT,) * 400
    found = followed(prepared, text, 0.6)["v/x"]
    limit, t = 0.6 / (1.0 + np.arange(400) / 7.0), np.linspace(0.0, 0.6, 7)[:, None]
    expected = np.where(t < limit, t**2 / 2.0, limit**2 / 2.0 + limit * (t - limit))
    assert np.allclose(found, expected, rtol=0.0, atol=1e-9 if method == "DOP853" else 1e-14)


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize("method", ["taylor", "ias15", "DOP853"])
def test_pucks_come_to_rest_on_a_belt(method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Relative to it they slide along straight lines, v^2/(2a) far; then they have its velocity to the last
    bit."""
    keep_families(monkeypatch, whole=True)
    text = on_belt("springs on a belt", count=80, k=0.0)
    found = followed(ready(text, frozenset({"q", "v"}), method=method), text, 4.0).data
    belt, slow = np.array([1.1 / 3.0, 0.0]), 0.7 / (1.0 + np.arange(80) % 2)
    start, speed = (np.stack([found[f"{k}/x"][0], found[f"{k}/y"][0]]).T for k in "qv")
    relative = speed - belt
    ways = relative * np.linalg.norm(relative, axis=1)[:, None] / (2.0 * slow)[:, None]
    end = np.stack([found["q/x"][-1], found["q/y"][-1]]).T
    most = 1e-8 if method == "DOP853" else 1e-13
    assert np.allclose(end, start + ways + 4.0 * belt, rtol=0.0, atol=most)
    assert np.all(found["v/x"][-1] == belt[0]) and not found["v/y"][-1].any()


@pytest.mark.exhaustive(keep=0.15)
def test_the_code_does_not_grow_with_the_members(monkeypatch: pytest.MonkeyPatch) -> None:
    keep_families(monkeypatch, whole=True)
    counts = [
        len(ready(on_belt("a turntable", count=n)).machine.program.text.splitlines()) for n in (200, 300)
    ]
    assert counts[0] == counts[1]


def test_belts_that_jump_are_written_out() -> None:
    """Nothing says what holds at the edge between two of them."""
    text = blocks(20, "-F*sign(x_dot[i] - where(x[i] > 0, V, 0))")
    assert any_family_system(read_spec(text, "system.yaml")) is None


SWINGING = """
sizes: {{N: 12}}
parameters: {{F: {F}, V: {V}, k: {k}}}
coordinates:
  "x[i in range(N)]": {{initial: 0.1*i, velocity: 0.5}}
  "y[i in range(N)]": {{initial: 0.05*i, velocity: -0.3 + 0.05*i}}
masses: {{"p[i in range(N)]": 1}}
positions: {{"p[i in range(N)]": ["x[i]", "y[i]"]}}
potential: sum(k*(x[i]**2 + y[i]**2)/2 for i in range(N))
forces: {{"p[i in range(N)]": "-F/norm((p[i].vx - V*cos(3*t), p[i].vy))*(p[i].vx - V*cos(3*t), p[i].vy)"}}
"""


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(
    ("limit", "speed", "spring"), [(2.4945825, 0.5216515, 16.1547598), (2.0, 0.8, 20.0), (2.42, 0.904, 15.5)]
)
def test_ledgers_close_where_pucks_stop_again_and_again(
    limit: float, speed: float, spring: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In the last step before a puck stops, the direction of friction is hardly known. The impulse of all
    forces is the change of momentum nevertheless."""
    keep_families(monkeypatch, whole=True)
    text = SWINGING.format(F=limit, V=speed, k=spring)
    found = followed(ready(text, LEDGERS | {"p"}), text, 3.0)
    for path in ("h", "p/x", "p/y"):
        assert np.max(np.abs(found[f"diagnostics/ledger/{path}"])) < 1e-10, path
