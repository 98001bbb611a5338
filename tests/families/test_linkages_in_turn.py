"""Families with constraints that follow from others in turn which are coupled, meet contacts, or stand beside
others: motions are those of members that are written out, and those of one member alone."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lagrange_cli as lagrange
from lagrange_cli.api import kept
from lagrange_cli.families import elimination
from lagrange_cli.families import system as systems
from lagrange_cli.native.families.constraints.in_turn import DependentTables
from tests.families.test_constraints_in_turn import CARRIAGES, NAMES, RINGS, SHAPES, solved
from tests.families.test_events import keep_families
from tests.support.draws import examples


def fleet(count: int, shape: str = "M is diagonal", first: int = 0, faster: float = 0.01) -> str:
    """Carriages side by side."""
    return CARRIAGES.format(count=count, first=first, faster=faster, **SHAPES[shape])


def train(count: int, shape: str, turned: float) -> str:
    """Carriages that rods connect, each with a heading of its own."""
    text = fleet(count, shape).replace("x[i in range(N)]: {initial: 0}", "x[i in range(N)]: {initial: i}")
    text = text.replace("initial: 0.3*(i + 0), velocity: 0.7 + 0.01*(i + 0)", f"initial: {turned}*i")
    text = text.replace("p[i in range(N)]: {initial: 0, velocity: 3}", "p[i in range(N)]: {initial: 0}")
    text = text.replace("0.1*sin(t)", "0.1*sin(t + i)")
    rods = "  rod[i in range(N - 1)]: norm((x[i + 1] - x[i], y[i + 1] - y[i])) - 1\n"
    return f"{text}constraints:\n{rods}"


WALLS = """
events:
  wall[i in range(N)]:
    {when: "x[i] - i - 0.07", direction: rising, action: {set: {"x_dot[i]": "-0.4*x_dot[i]"}}}
  floor[i in range(N)]:
    {when: "y[i] + 0.03", direction: falling, action: {set: {"y_dot[i]": "-0.4*y_dot[i]"}}}
"""
GEARS = "  gear[i in range(N - 1)]: sin(c[i + 1] - c[i]) + c[i + 1] - c[i]\n"


def counting(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """The numbers of unknowns of all equations that families solve in blocks of known rank."""
    tabled, make = list[int](), DependentTables.__init__

    def counted(self: DependentTables, count: int, *rest: object) -> None:
        tabled.append(count)
        make(self, count, *rest)  # type: ignore[arg-type]

    monkeypatch.setattr(DependentTables, "__init__", counted)
    monkeypatch.setenv("LAGRANGE_NO_CACHE", "1")
    return tabled


def both(text: str, monkeypatch: pytest.MonkeyPatch, **options: object) -> list[lagrange.Motion]:
    """The motion of families, whose equations are in blocks, and that of members that are written out."""
    tabled, found = counting(monkeypatch), list[lagrange.Motion]()
    monkeypatch.setattr(elimination, "TOGETHER", 0)
    for whole in (True, False):
        keep_families(monkeypatch, whole=whole)
        for name in ("FEWEST_TURNING", "FEWEST_NONHOLONOMIC"):
            monkeypatch.setattr(systems, name, 0 if whole else 10**9)
        kept.SYSTEMS.clear()
        found.append(solved(text, **options))
        assert bool(tabled) == whole
        tabled.clear()
    kept.SYSTEMS.clear()
    return found


def differ(found: list[lagrange.Motion], low: bool = False) -> float:
    """By how much two motions do at most."""
    one, other = found
    off = []
    for name, values in one.q.items():
        rest = values - other.q[name]
        if low:
            rest = rest + one.datasets[f"low/q/{name}"] - other.datasets[f"low/q/{name}"]
        off.append(float(np.abs(rest).max()))
    return max(off)


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("method", ["taylor", "ias15"])
@examples(1)
@given(turned=st.floats(0.1, 0.4), count=st.integers(3, 8))
def test_a_train_moves_as_written_out(shape: str, method: str, turned: float, count: int) -> None:
    with pytest.MonkeyPatch.context() as patch:
        found = both(train(count, shape, turned), patch, stop=3, method=method)
    assert differ(found) <= 1e-11
    more = 1.1 if method == "taylor" else 2
    assert found[0].attributes["steps"] <= more * found[1].attributes["steps"] + 3


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("shape", SHAPES)
def test_ledgers_of_a_train(shape: str) -> None:
    """80 constraints of 20 carriages and 19 rods: their forces are in the balances of momentum and energy."""
    motion = solved(train(20, shape, 0.2), stop=2, outputs=["p", "h", "ledger"])
    found = {name: values for name, values in motion.datasets.items() if "ledger" in name}
    assert len(found) == 6
    assert max(np.abs(values).max() for values in found.values()) <= 2.0**-44


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("shape", SHAPES)
def test_a_train_in_double_double(shape: str, monkeypatch: pytest.MonkeyPatch) -> None:
    options = {"stop": 1, "precision": "double-double", "outputs": ["q"]}
    assert differ(both(train(4, shape, 0.2), monkeypatch, **options), low=True) <= 1e-27


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("rods", [False, True], ids=["alone", "as a train"])
@pytest.mark.parametrize("method", ["taylor", "ias15"])
def test_carriages_hit_walls(rods: bool, method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Impacts set velocities that constraints contain."""
    text = train(4, "M is diagonal", 0.3) if rods else fleet(4)
    walls = WALLS if rods else WALLS.replace("x[i] - i", "x[i]")
    found = both(text + walls, monkeypatch, stop=4, method=method)
    assert differ(found) <= 1e-9
    assert found[0].attributes["steps"] <= 1.2 * found[1].attributes["steps"] + 5
    assert rods or len(found[0].events["wall/t"]) >= 4


LANE = """
events:
  meet[i in range(N - 1)]:
    when: x[i + 1] - x[i] - 0.6
    direction: falling
    action:
      set:
        x_dot[i]: x_dot[i] + 0.65*(x_dot[i + 1] - x_dot[i])
        x_dot[i + 1]: x_dot[i + 1] - 0.65*(x_dot[i + 1] - x_dot[i])
"""


@pytest.mark.exhaustive(keep=0.5)
def test_carriages_meet_in_a_lane(monkeypatch: pytest.MonkeyPatch) -> None:
    """Contacts couple what follows from others; in the end, carriages push each other."""
    text = fleet(3).replace("x[i in range(N)]: {initial: 0}", "x[i in range(N)]: {initial: i}")
    text = text.replace("initial: 0.3*(i + 0), velocity: 0.7 + 0.01*(i + 0)", "initial: 0")
    text = text.replace("p[i in range(N)]: {initial: 0, velocity: 3}", "p[i in range(N)]: {initial: 0}")
    text = text.replace("0.1*sin(t)", "0.1*cos(i)").replace("-0.05*s_dot[i]", "0.1*cos(i)")
    found = both(text + LANE, monkeypatch, stop=7)
    assert differ(found) <= 1e-10
    assert np.diff(found[0].q["x"][-1]) == pytest.approx(0.6, abs=1e-12)
    assert found[0].attributes["steps"] <= 1.3 * found[1].attributes["steps"] + 10


def test_rings_with_gears_move_as_written_out(monkeypatch: pytest.MonkeyPatch) -> None:
    found = both(RINGS.format(count=4, first=0) + GEARS, monkeypatch, stop=1)
    assert differ(found) <= 1e-12


def test_many_rings_with_gears_keep_their_energy(monkeypatch: pytest.MonkeyPatch) -> None:
    """319 constraints that are all coupled, 40 of which follow from others."""
    tabled = counting(monkeypatch)
    motion = solved(RINGS.format(count=40, first=0) + GEARS, stop=1, outputs=["q", "h"])
    assert 40 * 7 + 39 in tabled
    assert np.ptp(motion.h) <= 2.0**-40 * 40
    assert motion.attributes["steps"] <= 25
    assert np.ptp(motion.q["c"], axis=1).max() <= 1e-12


STOP = """
events:
  stop[i in range(N)]:
    when: th[i] - 2 - 0.3*(i + {first})
    direction: rising
    action: {{set: {{"th_dot[i]": "-0.4*th_dot[i]"}}}}
"""


def pushed(count: int, shape: str, first: int = 0) -> str:
    """Carriages that turn to a stop, and rest there."""
    text = fleet(count, shape, first).replace("-0.01*th_dot[i]", "4 - 0.01*th_dot[i]")
    return text + STOP.format(first=first)


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize(("method", "off"), [("taylor", 1e-12), ("ias15", 1e-12), ("DOP853", 1e-6)])
def test_carriages_turn_to_a_stop(shape: str, method: str, off: float) -> None:
    """Each as it does alone, until it rests there, at an angle that is known."""
    count = 8
    many = solved(pushed(count, shape), stop=8, method=method)
    for member in (0, 7):
        alone = solved(pushed(1, shape, member), stop=8, method=method)
        for name in NAMES:
            assert many.q[name][:, member] == pytest.approx(alone.q[name][:, 0], abs=off)
    assert many.q["th"][-1] == pytest.approx(2 + 0.3 * np.arange(count), abs=1e-10)
    impacts = len(many.events["stop/t"])
    assert impacts >= 10 * count
    for_each = 1.1 if method == "taylor" else 4
    assert many.attributes["steps"] <= for_each * impacts + 3 * alone.attributes["steps"]


@pytest.mark.exhaustive(keep=1)
def test_a_stop_in_double_double() -> None:
    options = {"stop": 2, "precision": "double-double", "outputs": ["q"]}
    many, alone = (solved(pushed(n, "M is diagonal", k), **options) for n, k in ((8, 0), (1, 5)))
    for name in NAMES:
        low = many.datasets[f"low/q/{name}"][:, 5] - alone.datasets[f"low/q/{name}"][:, 0]
        assert many.q[name][:, 5] - alone.q[name][:, 0] + low == pytest.approx(0, abs=1e-26)


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("shape", SHAPES)
def test_springs_that_begin_to_act(shape: str) -> None:
    """A force with a kink; 60 carriages take as many steps as these have kinks."""
    spring = "potential: sum(max(0, x[i] - 0.2)**2 for i in range(N))\n"
    many = solved(fleet(60, shape) + spring, stop=8)
    for member in (0, 47):
        alone = solved(fleet(1, shape, member) + spring, stop=8)
        for name in NAMES:
            assert many.q[name][:, member] == pytest.approx(alone.q[name][:, 0], abs=1e-12)
    assert many.attributes["steps"] <= 150


PENDULUMS = """
  u[i in range(N)]: {initial: 0.6}
  k[i in range(N)]: {initial: -0.8}
"""


def test_beside_constraints_that_are_independent() -> None:
    """Pendulums, which have equations of their own (these gave no number)."""
    text = fleet(30).replace("definitions:", PENDULUMS.lstrip("\n") + "definitions:")
    text = text.replace("masses:\n", "masses:\n  bob[i in range(N)]: 1\n")
    text = text.replace("positions:\n", "positions:\n  bob[i in range(N)]: (u[i], k[i])\n")
    text += "constraints:\n  rod[i in range(N)]: u[i]**2 + k[i]**2 - 1\n"
    text += "potential: sum(9.8*k[i] for i in range(N))\n"
    motion = solved(text, stop=2)
    velocity = motion.v["u"] ** 2 + motion.v["k"] ** 2
    assert velocity / 2 + 9.8 * (motion.q["k"] + 0.8) == pytest.approx(0.0, abs=1e-12)


TWICE = """
sizes: {N: 20}
coordinates:
  x[i in range(N)]: {initial: 0.6 + 2*i}
  y[i in range(N)]: {initial: -0.8}
constraints:
  rod[i in range(N)]: ((x[i] - 2*i)**2 + y[i]**2 - 1)/2
  twice[i in range(N)]: (x[i] - 2*i)**2 + y[i]**2 - 1
"""
BOBS = """
masses: {bob[i in range(N)]: 1 + i/10}
positions: {"bob[i in range(N)]": "(x[i], y[i])"}
potential: sum(9.8*(1 + i/10)*y[i] for i in range(N))
"""
MASSES = {
    "M is diagonal": (BOBS, 40),
    "on joints": (
        BOBS.replace("1 + i/10}", "1 + i/10, all[i in range(N)]: 1e-9}").replace(
            '"(x[i], y[i])"', '"(x[i], y[i])", "all[i in range(N)]": "[x[i] + y[i]]"'
        ),
        40,
    ),
    "M is constant": (
        "lagrangian: sum((1 + i/10)*(x_dot[i]**2/2 + y_dot[i]**2/2 - 9.8*y[i]) + 1e-9*x_dot[i]*y_dot[i]"
        " for i in range(N))\n",
        80,
    ),
}
"""What gives the masses, some of which are so small that they change nothing; and how many unknowns are found
together."""


@pytest.mark.parametrize("kind", MASSES)
def test_multipliers_of_least_norm_where_one_is_left_out(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Pendulums whose rods are given twice: the first constraint has a fifth of the force."""
    tabled, (masses, unknowns) = counting(monkeypatch), MASSES[kind]
    motion = solved(TWICE + masses, stop=2, outputs=["q", "v", "multipliers", "constraints"])
    assert unknowns in tabled
    u, y = motion.q["x"] - 2 * np.arange(20), motion.q["y"]
    force = -(1 + np.arange(20) / 10) * (motion.v["x"] ** 2 + motion.v["y"] ** 2 - 9.8 * y)
    off = 1e-11 if kind == "M is diagonal" else 1e-6
    assert motion.multipliers["rod"] == pytest.approx(force / 5, abs=off)
    assert motion.multipliers["twice"] == pytest.approx(2 * motion.multipliers["rod"], abs=1e-12)
    assert np.abs(u**2 + y**2 - 1).max() <= 1e-14
    for name in ("rod", "twice"):
        assert np.abs(motion.constraints[name]).max() <= 1e-14


@pytest.mark.parametrize("shape", SHAPES)
def test_multipliers_of_carriages(shape: str) -> None:
    """Those of a family are those of one carriage alone."""
    outputs = ["q", "multipliers", "constraints"]
    many, alone = (solved(fleet(n, shape, k), stop=4, outputs=outputs) for n, k in ((30, 0), (1, 11)))
    for name, values in alone.multipliers.items():
        assert many.multipliers[name][:, 11] == pytest.approx(values[:, 0], abs=1e-12)
        assert np.abs(many.constraints[name]).max() <= 1e-14
