"""Families with dry friction that stay families, beside the same systems written out and closed forms."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from numpy.typing import NDArray

from lagrange_cli.families.system import any_family_system, reason
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.families import family_run
from lagrange_cli.integrate.guards.modes import Modes
from lagrange_cli.integrate.precision import DOUBLE_DOUBLE, FULL_DOUBLE_DOUBLE
from lagrange_cli.integrate.prepare import prepare_system
from lagrange_cli.integrate.written_out import unsuited
from lagrange_cli.native.guards import EXPLICIT
from lagrange_cli.run.derive import derive_system
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_long_values, resolve_values
from tests.families.test_events import keep_families
from tests.families.test_switches import BY_RATES, LEDGERS, OUTPUTS, compare, counted_series, followed, ready
from tests.support.motion import run

BLOCKS = """
sizes: {{N: {count}}}
parameters: {{k: 2, V: 0.7, F: 0.6, c: 0.2, "w[i in range(N)]": "0.3*(-1)**i"}}
coordinates: {{"x[i in range(N)]": {{initial: "{start}", velocity: "{speed}"}}}}
masses: {{"block[i in range(N)]": 1 + i/7}}
embedding: {{"block[i in range(N)]": "x[i]"}}
potential: sum((x[i] - V*t)**2/2 for i in range(N)) + sum(k*(x[i] - x[i - 1])**2/2 for i in range(1, N))
generalized_forces:
  "x[i in range(N)]": "{force}"
"""
MOVING = "0.5*sin(i + 1)", "cos(i*i + 1)"
CASES = {
    "blocks that are driven": "-F*sign(x_dot[i])",
    "and damped": "-F*sign(x_dot[i]) - c*x_dot[i]",
    "with a limit that depends on places": "-(F + c*x[i]**2 + c*x[(i + 1) % N]**2)*sign(x_dot[i])",
    "with less friction in motion": "-F*sign(x_dot[i])/(1 + c*abs(x_dot[i]))",
    "unlike in both directions": "where(x_dot[i] > 0, -F, F/2)",
    "on belts": "-F*sign(x_dot[i] - w[i])",
    "for some of them": "where(i % 2 == 0, -F*sign(x_dot[i]), -c*x_dot[i])",
    "in two parts": "-F*sign(x_dot[i])/2 - F*sign(2*x_dot[i])/3",
    "that grows at a time": "-where(t < 1.1, F, 2*F)*sign(x_dot[i])",
    "beside a push that begins at a time": "-F*sign(x_dot[i]) + where(t < 2.1, 0, 1)",
    "beside stops": "-F*sign(x_dot[i]) - 9*max(0, x[i] - 1)",
    "beside walls that push": "-F*sign(x_dot[i]) - where(x[i] > 0.3, 5, 0)",
    "beside walls that pull": "-F*sign(x_dot[i]) + where(0.3 - x[i] > 0, 0, 1)",
    "that is larger beyond a place": "-F*where(x[i] < 0.3, 1, 2)*sign(x_dot[i])",
    "that is less where it is fast": "-F*where(abs(x_dot[i]) > 0.4, 1, 2)*sign(x_dot[i])",
    "with a brake": "-F*sign(x_dot[i]) - where(x_dot[i] > 0.4, 3*x_dot[i], 0)",
    "beside places that attract": "-F*sign(x_dot[i])/9 - where(x_dot[i] > 0.4, 1, 0) - sign(x[i] - 0.2)/3",
}


def blocks(count: int, force: str, start: str = MOVING[0], speed: str = MOVING[1]) -> str:
    """The text of a system file."""
    return BLOCKS.format(count=count, force=force, start=start, speed=speed)


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("count", [1, 2, 3, 8, 9])
@pytest.mark.parametrize("case", CASES)
def test_friction_is_that_of_the_members(case: str, count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    compare(blocks(count, CASES[case]), monkeypatch, stop=4.0)


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize("case", CASES)
def test_blocks_may_begin_at_rest(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    compare(blocks(9, CASES[case], speed="0"), monkeypatch, stop=3.0)


@pytest.mark.exhaustive(keep=0.35)
@BY_RATES
@pytest.mark.parametrize("count", [1, 2, 3, 8, 9])
@pytest.mark.parametrize("case", CASES)
def test_friction_in_steps_on_rates(
    case: str, count: int, method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    compare(blocks(count, CASES[case]), monkeypatch, stop=3.9, method=method)


@pytest.mark.exhaustive(keep=0.4)
@BY_RATES
def test_what_is_let_go_from_rest_does_not_stop_again(method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Springs that are drawn let one block after the other go, whose velocity rises from 0 as t^2."""
    keep_families(monkeypatch, whole=True)
    own, calls = Modes.coefficients_of, [0]

    def counting(modes: Modes, *rows: int) -> list[NDArray[np.float64]]:
        calls[0] += 1
        return own(modes, *rows)

    monkeypatch.setattr(Modes, "coefficients_of", counting)
    text = blocks(50, "-F*sign(x_dot[i])", "0.1*sin(7*i)", "0").replace("V: 0.7", "V: 0.1")
    motion = followed(ready(text, method=method), text, 8.0)
    assert np.all(motion["v/x"][-1] > 0.0)
    assert 50 <= calls[0] <= 60


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("case", ["blocks that are driven", "on belts"])
def test_friction_backward_in_time(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    compare(blocks(3, CASES[case]), monkeypatch, LEDGERS, stop=-1.0, backward=True)


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("method", ["taylor", "ias15", "DOP853"])
@pytest.mark.parametrize("speed", ["0", MOVING[1]])
@pytest.mark.parametrize("case", ["blocks that are driven", "on belts"])
def test_ledgers_have_the_forces_that_hold_blocks(
    case: str, speed: str, method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    compare(blocks(3, CASES[case], speed=speed), monkeypatch, LEDGERS, stop=3.0, method=method)


@pytest.mark.exhaustive(keep=0.55)
@pytest.mark.parametrize("method", ["taylor", "ias15"])
def test_ledgers_where_the_force_that_holds_a_block_cancels_all_others(method: str) -> None:
    """Written out, the sum of forces is nothing but rounding while the block sticks: until t = F/V, and again
    after it has slipped for 2 pi."""
    text = blocks(1, "-F*sign(x_dot[i])", "0", "0")
    motion = run(
        ready(text, LEDGERS, method=method), resolve_values(read_spec(text, "system.yaml"), {}), 0.0, 8.0, 17
    )
    for path in ("diagnostics/ledger/h", "diagnostics/ledger/p/x"):
        assert np.all(np.abs(motion[path]) <= 1e-14)


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.parametrize("method", ["taylor", "ias15"])
def test_a_block_that_a_spring_pulls_sticks_and_slips(method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """x'' = V t - x - F from t = F/V on: x = V (s - sin s), with s = t - F/V, until s = 2 pi, where the
    velocity is 0 and the spring as long as at s = 0: so this is repeated."""
    keep_families(monkeypatch, whole=True)
    text = blocks(3, "-F*sign(x_dot[i])", "0", "0").replace("1 + i/7", "1").replace("k: 2", "k: 0")
    motion = followed(ready(text, method=method), text, 6.0)
    since = np.maximum(0.0, np.linspace(0.0, 6.0, 7) - 0.6 / 0.7)
    expected = 0.7 * (since - np.sin(since))
    assert np.allclose(motion["q/x"], expected[:, None], rtol=0.0, atol=1e-14)


@pytest.mark.exhaustive(keep=0.25)
def test_swings_with_friction_end_at_rest(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each half of a swing of x'' = -x - F sign(x') ends 2 F nearer to 0, until |x| <= F."""
    keep_families(monkeypatch, whole=True)
    starts = "4.1 - 0.7*i"
    text = blocks(5, "-0.3*sign(x_dot[i])", starts, "0").replace("1 + i/7", "1")
    text = text.replace("k: 2, V: 0.7", "k: 0, V: 0")
    prepared = ready(text, LEDGERS)
    assert prepared.machine.program.guards == (EXPLICIT,) * 5
    motion = followed(prepared, text, 24.0)
    for i in range(5):
        x, side = 4.1 - 0.7 * i, 1.0
        while x > 0.3:
            x, side = x - 0.6, -side
        assert motion["q/x"][-1, i] == pytest.approx(side * x, abs=1e-13)
        assert abs(motion["v/x"][-1, i]) <= 1e-14


@pytest.mark.exhaustive(keep=0.65)
def test_swings_about_a_place_with_friction(monkeypatch: pytest.MonkeyPatch) -> None:
    """x'' = -K sign(x) - F sign(x') with K > F: each half of a swing is (K - F)/(K + F) as far as the last
    one."""
    keep_families(monkeypatch, whole=True)
    text = blocks(5, "-F*sign(x_dot[i]) - 1.4*sign(x[i])", "0.5 + 0.1*i", "0").replace("1 + i/7", "1")
    text = text.replace("k: 2, V: 0.7", "k: 0, V: 0").replace("(x[i] - V*t)**2/2", "0*x[i]")
    motion = followed(ready(text), text, 3.6)
    back, on, times = 1.4 - 0.6, 1.4 + 0.6, np.linspace(0.0, 3.6, 7)
    for i in range(5):
        x, side, t, expected = 0.5 + 0.1 * i, 1.0, 0.0, np.zeros(7)
        while t <= times[-1]:
            fall, rise = np.sqrt(2.0 * x / back), np.sqrt(2.0 * x * back) / on
            falling = (t <= times) & (times < t + fall)
            expected[falling] = side * (x - back * (times[falling] - t) ** 2 / 2.0)
            t, x, side = t + fall, x * back / on, -side
            rising = (t <= times) & (times < t + rise)
            expected[rising] = side * (x - on * (t + rise - times[rising]) ** 2 / 2.0)
            t += rise
        assert np.allclose(motion["q/x"][:, i], expected, rtol=0.0, atol=1e-13)


@pytest.mark.exhaustive(keep=0.55)
@pytest.mark.parametrize("push", [-1.3, -0.7, 0.7, 1.3, 4.7, 5.3])
def test_what_a_wall_and_friction_hold_together(push: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """A wall that pushes by 4 beyond x = 1 holds a block there up to 4 + F in one direction, and F in the
    other, as friction does."""
    keep_families(monkeypatch, whole=True)
    force = f"-sign(x_dot[i]) - where(x[i] > 1, 4, 0) + {push}"
    text = blocks(9, force, "1", "0").replace("k: 2, V: 0.7", "k: 0, V: 0").replace("1 + i/7", "1")
    text = text.replace("(x[i] - V*t)**2/2", "0*x[i]")
    found = followed(ready(text), text, 0.5)["q/x"][-1]
    moves = push + 1.0 if push < -1.0 else max(0.0, push - 5.0)
    assert np.allclose(found, 1.0 + moves * 0.5**2 / 2.0, rtol=0.0, atol=1e-15)


@pytest.mark.exhaustive(keep=0.25)
def test_series_to_settle_do_not_grow_with_the_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    """All begin at rest; springs pull every third one too much."""
    keep_families(monkeypatch, whole=True)
    calls = counted_series(monkeypatch)

    def series(count: int) -> int:
        text = blocks(count, "-F*sign(x_dot[i])", "where(i % 3 == 0, -2*cos(i), 0.1)", "0")
        text = text.replace("k: 2", "k: 0").replace("(-1)**i", "cos(i)")
        calls[0] = 0
        found = followed(ready(text), text, 0.01)
        moves = np.abs(found["v/x"][-1]) > 0.0
        pulled = np.where(np.arange(count) % 3 == 0, np.abs(2.0 * np.cos(np.arange(count))) > 0.6, False)
        assert np.array_equal(moves, pulled)
        return calls[0]

    assert series(200) == series(50) <= 16


@pytest.mark.exhaustive(keep=0.65)
def test_modes_that_were_tried_have_their_series_no_more_than_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Asked for again with the state and the modes as they were before, or as they were tried before that, a
    series is not computed again."""
    keep_families(monkeypatch, whole=True)
    own, asked = Modes._series, list[tuple[bytes, NDArray[np.float64]]]()

    def noting(modes: Modes) -> NDArray[np.float64]:
        rates = own(modes)
        asked.append((modes.memory.tobytes(), rates))
        return rates

    text = blocks(3, "-F*sign(x_dot[i])", "0.1*i", "0")
    prepared = ready(text)
    monkeypatch.setattr(Modes, "_series", noting)
    followed(prepared, text, 6.0)
    made = len({id(rates.base) for _, rates in asked})
    assert len({memory for memory, _ in asked}) == made < 0.6 * len(asked)


@pytest.mark.exhaustive(keep=0.35)
def test_walls_beside_friction(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a wall sends back slides at once."""
    wall = """
events:
  "wall[i in range(N)]": {when: "x[i] - 0.8", direction: rising, action: {set: {"x_dot[i]": "-x_dot[i]"}}}
"""
    compare(blocks(3, CASES["blocks that are driven"]) + wall, monkeypatch, stop=2.5)


@pytest.mark.exhaustive(keep=0.7)
def test_friction_in_double_double(monkeypatch: pytest.MonkeyPatch) -> None:
    """Half a swing ends 2 F nearer to 0."""
    keep_families(monkeypatch, whole=True)
    text = blocks(2, "-0.25*sign(x_dot[i])", "2 - i/2", "0").replace("1 + i/7", "1")
    text = text.replace("k: 2, V: 0.7", "k: 0, V: 0")
    spec = read_spec(text, "system.yaml")
    asked = Compilation("taylor", FULL_DOUBLE_DOUBLE, OUTPUTS, precision=DOUBLE_DOUBLE)
    assert family_run(spec, asked) is not None
    prepared = prepare_system(spec, partial(derive_system, resting=True, exact=True), None, asked)
    found = run(prepared, resolve_long_values(spec, {}), 0.0, 13.0, 3).data
    assert np.allclose(found["q/x"][-1], [0.0, 0.0], rtol=0.0, atol=1e-14)
    assert np.allclose(found["v/x"][-1], [0.0, 0.0], rtol=0.0, atol=1e-14)


def test_friction_of_one_coordinate_on_another_goes_through_the_members(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Nothing holds y where x' is 0."""
    keep_families(monkeypatch, whole=True)
    text = """
sizes: {N: 3}
coordinates: {"x[i in range(N)]": {initial: 0, velocity: 1}, "y[i in range(N)]": {initial: 0, velocity: 1}}
masses: {"block[i in range(N)]": 1}
embedding: {"block[i in range(N)]": ["x[i]", "y[i]"]}
potential: sum(x[i]**2 + y[i]**2 for i in range(N))
forces: {"block[i in range(N)]": ["-sign(x_dot[i])", FORCE]}
"""
    found = []
    for force in ('"-sign(y_dot[i])"', '"-sign(x_dot[i])"'):
        spec = read_spec(text.replace("FORCE", force), "system.yaml")
        found.append(family_run(spec, Compilation("taylor", 2.0**-52, OUTPUTS)))
        assert ("jump" in "".join(reason(spec))) == (found[-1] is None)
    assert found[0] is not None and found[1] is None


@pytest.mark.parametrize(
    ("length", "whole"),
    [("norm((x_dot[i] - 1, y_dot[i]))", False), ("sqrt(block[i].vx**2 + block[i].vy**2 + 0.01)", True)],
)
def test_friction_along_relative_velocities_is_followed_member_by_member(length: str, whole: bool) -> None:
    """It may hold them at rest; softened friction does not."""
    text = "sizes: {N: 9}\ncoordinates: {'x[i in range(N)]': {velocity: 1}, 'y[i in range(N)]': {}}\n"
    text += "masses: {'block[i in range(N)]': 1}\nembedding: {'block[i in range(N)]': ['x[i]', 'y[i]']}\n"
    text += "potential: sum((x[i] - x[i - 1])**2/2 for i in range(1, N))\n"
    text += f"forces: {{'block[i in range(N)]': '-(x_dot[i], y_dot[i])/{length}'}}\n"
    spec = read_spec(text, "system.yaml")
    assert (any_family_system(spec) is not None) is whole
    assert whole or "along a vector" in reason(spec)[0]
    if not whole:
        found = unsuited(spec)
        assert "along a vector" in found.what and found.place is not None
