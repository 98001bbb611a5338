"""Families with dry friction on coordinates in constraints, beside the same written out and closed forms."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from lagrange_cli.families.system import any_family_system, reason
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.prepare import prepare_system
from lagrange_cli.run.derive import derive_system
from lagrange_cli.spec.read import read_spec
from tests.families.test_events import keep_families
from tests.families.test_switches import (
    BY_RATES,
    CLOSE,
    LEDGERS,
    OUTPUTS,
    compare,
    compare_long,
    followed,
    ready,
)
from tests.support.draws import examples
from tests.support.families import alike

SYSTEM = """
sizes: {{N: {count}}}
parameters: {{k: 2, V: 0.7, F: 0.4, c: 0.2, "w[i in range(N)]": "0.3*(-1)**i"}}
coordinates:
  "x[i in range(N)]": {{initial: "{x}"}}
  "y[i in range(N)]": {{initial: "{y}"}}
masses: {{"p[i in range(N)]": 1 + i/7}}
embedding: {{"p[i in range(N)]": ["x[i]", "y[i]"]}}
potential: "{potential}"
{section}: {{{constraints}}}
generalized_forces: {{{forces}}}
"""
ZIGZAG, ROW = ("0.8*i", "0.6*(i % 2)"), ("i", "0")
DRIVEN = "sum(k*(x[i] - {x} - V*t*sin(i*i + 1))**2/2 + (y[i] - 0.6*sin(2*t + i))**2 for i in range(N))"
RODS = '"rod[i in range(1, N)]": "(x[i] - x[i - 1])**2 + (y[i] - y[i - 1])**2 - 1"'
PAIRS = '"rod[i in range(N//2)]": "(x[2*i + 1] - x[2*i])**2 + (y[2*i + 1] - y[2*i])**2 - 1"'
TRAIN = '"coupling[i in range(1, N)]": "x[i] - x[i - 1] - 1"'
LEVEL = '"level[i in range(1, N)]": "y[i] - y[i - 1]"'
WIRES = '"wire[i in range(N)]": "y[i] - sin(x[i]) + sin(i)"'
SLEDS = '"edge[i in range(N)]": "sin(0.3*i + 0.2)*x_dot[i] - cos(0.3*i + 0.2)*y_dot[i]"'
SUPPORT = '"rod[0]": "(x[0] + cos(3*t)/9 + 0.8 - 1/9)**2 + (y[0] + 0.6)**2 - 1", ' + RODS
X, Y = (f'"{q}[i in range(N)]": "-F*sign({q}_dot[i])"' for q in "xy")
BOTH = X + ", " + '"y[i in range(N)]": "-F*(1 + i/5)*sign(y_dot[i])"'
CASES = {
    "rods": (ZIGZAG, RODS, BOTH),
    "rods in a row": (ROW, RODS, BOTH),
    "rods, friction along y": (ZIGZAG, RODS, Y),
    "pairs": (ROW, PAIRS, BOTH),
    "a train": (ROW, TRAIN, X),
    "a train beside friction elsewhere": (ROW, TRAIN, BOTH),
    "friction on other coordinates": (ROW, TRAIN, Y),
    "a level": (ROW, LEVEL, BOTH),
    "wires": (("i", "0"), WIRES, X),
    "a driven support": (ZIGZAG, SUPPORT, BOTH),
    "on belts": (ZIGZAG, RODS, X.replace("x_dot[i])", "x_dot[i] - w[i])")),
    "on belts that swing": (ZIGZAG, RODS, X.replace("x_dot[i])", "x_dot[i] - w[i]*cos(t))")),
    "for some of them": (ZIGZAG, RODS, X.replace("-F", "where(i % 2 == 0, -F, 0)")),
    "with a limit that depends on places": (ZIGZAG, RODS, X.replace("F", "(F + c*y[i]**2)")),
    "unlike in both directions": (ZIGZAG, RODS, X.replace("-F*sign(", "-F*where(x_dot[i] > 0, 1, c)*sign(")),
    "that ends": (ZIGZAG, RODS, X.replace("-F", "-where(t < 1.1, F, 0)")),
    "beside stops": (ZIGZAG, RODS, X.replace("-F*sign(x_dot[i])", "-F*sign(x_dot[i]) - 9*max(0, x[i] - 1)")),
}  # fmt: skip


def system(case: str, count: int) -> str:
    """The text of a system file."""
    (x, y), constraints, forces = CASES[case]
    return text_of(count, (x, y), DRIVEN.format(x=x), constraints, forces)


def text_of(
    count: int,
    start: tuple[str, str],
    potential: str,
    constraints: str,
    forces: str,
    section: str = "constraints",
) -> str:
    """The same of other systems."""
    given = {"count": count, "x": start[0], "y": start[1], "potential": potential, "section": section}
    return SYSTEM.format(**given, constraints=constraints, forces=forces)


TOGETHER = "rods", "rods in a row", "pairs", "a driven support"
"""Those in which friction may hold more than constraints leave free: forces that hold are not determined.
What moves is."""
APART = [case for case in CASES if case not in TOGETHER]


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("count", [2, 3, 8, 9])
@pytest.mark.parametrize("case", APART)
def test_friction_is_that_of_the_members(case: str, count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    compare(system(case, count), monkeypatch, stop=3.0)


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("count", [2, 3, 8, 9])
@pytest.mark.parametrize("case", TOGETHER)
@pytest.mark.parametrize("whole", [True, False])
def test_friction_is_the_limit_of_smooth_forces(
    case: str, count: int, whole: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In loops and written out."""
    keep_families(monkeypatch, whole=whole)
    near_limit(system(case, count), 3.0)


@pytest.mark.parametrize("count", [3, 8])
def test_few_members_move_as_many_do(count: int) -> None:
    near_limit(system("rods", count), 3.0)


def near_limit(text: str, stop: float) -> None:
    """A motion is that under tanh(v/w) in place of sign(v), where w is small."""
    smooth = re.sub(r"sign\((._dot\[i\])\)", r"tanh(\1/1e-5)", text)
    asked = Compilation("Radau", 1e-8, OUTPUTS)
    near = prepare_system(read_spec(smooth, "system.yaml"), derive_system, None, asked)
    found, expected = followed(ready(text), text, stop), followed(near, smooth, stop)
    for path in ("q/x", "q/y"):
        assert np.max(np.abs(found[path] - expected[path])) <= 1e-3, path


@pytest.mark.exhaustive(keep=0.2)
@BY_RATES
@pytest.mark.parametrize("case", ["rods, friction along y", "a level", "wires", "on belts that swing"])
def test_friction_in_steps_on_rates(case: str, method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    compare(system(case, 3), monkeypatch, stop=3.0, method=method)


@pytest.mark.exhaustive(keep=0.4)
@BY_RATES
def test_steps_on_rates_hold_as_much_as_series_do(method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    keep_families(monkeypatch, whole=True)
    text = system("rods", 9)
    found, expected = (followed(ready(text, method=one), text, 3.0) for one in (method, "taylor"))
    alike(found.data, expected.data, CLOSE[method])


@pytest.mark.exhaustive(keep=0.3)
@pytest.mark.parametrize("method", ["taylor", "ias15"])
@pytest.mark.parametrize("case", ["rods, friction along y", "on belts", "on belts that swing"])
def test_ledgers_have_what_holds_coordinates(case: str, method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    compare(system(case, 3), monkeypatch, LEDGERS | {"p"}, stop=3.0, method=method)


@pytest.mark.exhaustive(keep=0.4)
@pytest.mark.parametrize("case", ["rods, friction along y", "a level", "wires"])
def test_friction_in_double_double(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    compare_long(system(case, 2), monkeypatch, stop=1.5, most=2.0**-80)


@pytest.mark.exhaustive(keep=0.5)
def test_friction_backward_in_time(monkeypatch: pytest.MonkeyPatch) -> None:
    compare(system("rods, friction along y", 3), monkeypatch, LEDGERS, stop=-1.0, backward=True)


@pytest.mark.exhaustive(keep=0.25)
@given(data=st.data())
@examples(2)
def test_random_rods(data: st.DataObject) -> None:
    number = st.floats(0.1, 1.5).map(lambda x: round(x, 2))
    limit, speed, spring = (data.draw(number) for _ in range(3))
    case, count = data.draw(st.sampled_from(["rods", "pairs"])), data.draw(st.integers(2, 6))
    text = system(case, count).replace("F: 0.4", f"F: {limit}")
    text = text.replace("V: 0.7", f"V: {speed}").replace("k: 2", f"k: {spring}")
    with pytest.MonkeyPatch.context() as monkeypatch:
        keep_families(monkeypatch, whole=True)
        near_limit(text, 2.0)


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.parametrize("method", ["taylor", "ias15", "DOP853"])
@pytest.mark.parametrize("count", [2, 9, 60])
def test_blocks_that_rods_join_are_one(count: int, method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """M x'' = k (V t - x) - N F from t = N F/(k V) on: x = V (s - sin(w s)/w), w^2 = k/M. Until then, one
    block after the other is at its limit, while all of them rest."""
    keep_families(monkeypatch, whole=True)
    text = text_of(count, ROW, "k*(x[0] - V*t)**2/2 + sum(y[i]**2 for i in range(N))", TRAIN, X)
    text = text.replace("F: 0.4", f"F: {1.0 / count}").replace("1 + i/7", f"{2.0 / count}")
    motion = followed(ready(text, method=method), text, 3.0)
    since = np.maximum(0.0, np.linspace(0.0, 3.0, 7) - 1.0 / 1.4)
    expected = 0.7 * (since - np.sin(since))
    found = motion["q/x"] - np.arange(count)
    assert motion.outcome.ending is Ending.COMPLETE
    assert np.allclose(found, expected[:, None], rtol=0.0, atol=1e-13 if method != "DOP853" else 1e-11)
    assert np.all(motion["v/x"][:2] == 0.0)


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.parametrize("count", [9, 60])
def test_a_train_stops_and_starts_as_one_block(count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Springs on all cars that are unlike, and pull to and fro: the train rests wherever their sum is no more
    than that of all limits, though single cars are pulled by more than theirs."""
    keep_families(monkeypatch, whole=True)
    pull = f"sum(-x[i]*({1.5 / count}*sin(2*t) + {6.0 / count}*sin(7*i + 1) - MEAN) for i in range(N))"
    mean = float(np.mean(6.0 / count * np.sin(7.0 * np.arange(count) + 1.0)))
    text = text_of(count, ROW, pull.replace("MEAN", repr(mean)), TRAIN, X)
    text = text.replace("F: 0.4", f"F: {1.0 / count}").replace("1 + i/7", f"{1.0 / count}")
    one = text_of(1, ROW, "-x[0]*1.5*sin(2*t)", '"level": "y[0]"', X)
    one = one.replace("F: 0.4", "F: 1").replace("1 + i/7", "1")
    found, expected = (followed(ready(each), each, 6.0) for each in (text, one))
    for path in ("q/x", "v/x"):
        assert np.allclose(
            found[path] - found[path][0], expected[path] - expected[path][0], rtol=0.0, atol=1e-12
        )
    assert np.ptp(expected["q/x"]) > 0.1


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.parametrize("whole", [True, False])
def test_sleds_on_edges(whole: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Along its edge, a sled is a block under the friction of both components."""
    keep_families(monkeypatch, whole=whole)
    pull = "-sum(x[i]*1.5*sin(2*t) for i in range(N))"
    text = text_of(9, ROW, pull, SLEDS, BOTH, section="nonholonomic")
    found = followed(ready(text), text, 5.0)
    for i in range(9):
        angle = 0.3 * i + 0.2
        along, limit = float(np.cos(angle)), 0.4 * abs(np.cos(angle)) + 0.4 * (1 + i / 5) * abs(np.sin(angle))
        alone = text_of(1, ROW, f"-x[0]*{1.5 * along!r}*sin(2*t)", '"level": "y[0]"', X)
        alone = alone.replace("F: 0.4", f"F: {float(limit)!r}").replace("1 + i/7", f"{1 + i / 7!r}")
        expected = followed(ready(alone), alone, 5.0)["q/x"][:, 0]
        moved: NDArray[np.float64] = found["q/x"][:, i] - i
        assert np.allclose(moved, expected * along, rtol=0.0, atol=1e-12), i


@pytest.mark.exhaustive(keep=0.5)
def test_work_does_not_grow_faster_than_the_system(monkeypatch: pytest.MonkeyPatch) -> None:
    """The energy that friction takes is accounted for, in a chain of 200 rods on a floor."""
    keep_families(monkeypatch, whole=True)
    text = system("rods", 200)
    motion = followed(ready(text, LEDGERS), text, 0.5)
    assert motion.outcome.ending is Ending.COMPLETE and motion.outcome.steps < 200
    assert np.all(np.abs(motion["diagnostics/ledger/h"]) <= 1e-12 * np.max(np.abs(motion["diagnostics/h"])))


@pytest.mark.parametrize(
    "force",
    ["-F*sign(x_dot[i] - x_dot[(i + 1) % N])", "-F*sign(x[i])", "-F*x_dot[i]/norm((x_dot[i], y_dot[i]))"],
)
def test_other_friction_beside_constraints_is_written_out(force: str) -> None:
    text = text_of(13, ZIGZAG, DRIVEN.format(x="0.8*i"), RODS, f'"x[i in range(N)]": "{force}"')
    spec = read_spec(text, "system.yaml")
    assert any_family_system(spec) is None
    assert reason(spec)
