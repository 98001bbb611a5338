"""Events of families that stay families, beside the same systems written out member by member."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import numpy as np
import pytest
from numpy.typing import NDArray

from lagrange_cli.families import system as systems
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.families import family_run
from lagrange_cli.integrate.prepare import prepare_system
from lagrange_cli.integrate.prepared import Prepared
from lagrange_cli.native.guards import Role
from lagrange_cli.run.check import classify
from lagrange_cli.run.derive import derive_system
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_values
from tests.support.motion import run

OUTPUTS = frozenset(["q", "v", "h"])
CHAIN = """
sizes: {{N: {count}}}
parameters: {{k: 1.5, L: 0.9, "at[i in range(N)]": "0.2 + 0.1*cos(i)"}}
coordinates: {{"x[i in range(N)]": {{initial: "0.5*sin(i + 1)", velocity: "2*cos(i*i + 1)"}}}}
masses: {{"bead[i in range(N)]": 1 + i/7}}
embedding: {{"bead[i in range(N)]": "x[i]"}}
potential: sum(k*(x[i] - x[i - 1])**2/2 + (x[i] - x[i - 1])**4/4 for i in range(1, N)) + x[0]**2/2
events: {events}
"""
PENDULUM = """
sizes: {{N: {count}}}
coordinates: {{"th[i in range(N)]": {{initial: "0.9 - 0.1*i", velocity: "0.1*i"}}}}
masses: {{"bob[i in range(N)]": 1}}
embedding:
  bob[i in range(N)]: ["sum(sin(th[j]) for j in range(i + 1))", "-sum(cos(th[j]) for j in range(i + 1))"]
potential: sum(bob[i].y for i in range(N))
events: {events}
"""
RING = """
sizes: {{N: {count}}}
coordinates:
  x[i in range(N)]: {{initial: cos(i), velocity: -sin(i)}}
  y[i in range(N)]: {{initial: sin(i), velocity: cos(i)}}
masses: {{"bead[i in range(N)]": 1 + i/7}}
embedding: {{"bead[i in range(N)]": ["x[i]", "y[i]"]}}
potential: sum(y[i]*(1 + i/3) for i in range(N))
constraints: {{"rod[i in range(N)]": "x[i]**2 + y[i]**2 - 1"}}
events: {events}
"""
CASES = {
    "one event": (CHAIN, '{last: {when: "x[N - 1] - 0.2"}}'),
    "an event of each member": (CHAIN, '{"hit[i in range(N)]": {when: "x[i] - at[i]", direction: rising}}'),
    "kinds of members": (
        CHAIN,
        '{"hit[0]": {when: "x[0]"}, "hit[i in range(1, N)]": {when: "x[i] - x[i - 1]"}}',
    ),
    "sums, velocities and time": (
        CHAIN,
        '{sum: {when: "sum(x[i] for i in range(N))"}, slow: {when: "x_dot[0]*t - 0.1"},'
        ' "fast[i in range(N)]": {when: "x_dot[i]**3", direction: falling}}',
    ),
    "walls": (
        CHAIN,
        '{"wall[i in range(N)]":'
        ' {when: "x[i] - L", direction: rising, action: {set: {"x_dot[i]": "-x_dot[i]"}}},'
        ' "zero[i in range(N)]": {when: "x[i]"}}',
    ),
    "kicks": (
        CHAIN,
        '{kick: {when: "t - 0.5", action: {set: {"x_dot[i in range(N)]": "x_dot[i] + 0.1*i + 1"}}},'
        ' "hit[i in range(N)]": {when: "x_dot[i] - L"}}',
    ),
    "a parameter": (CHAIN, '{stiffer: {when: "x[0]", action: {set: {k: "1.25*k", L: "L + x[N - 1]**2"}}}}'),
    "what ends the motion": (CHAIN, '{"end[i in range(N)]": {when: "x[i]", action: stop}}'),
    "rods": (
        PENDULUM,
        '{"middle[i in range(N)]": {when: "bob[i].x", direction: falling}, turn: {when: "th_dot[0]"},'
        ' tip: {when: "bob[N - 1].vx"}}',
    ),
    "constraints": (RING, '{"top[i in range(N)]": {when: "x[i]"}}'),
}


def keep_families(monkeypatch: pytest.MonkeyPatch, whole: bool) -> None:
    """Families stay families however few their members are; or none does."""
    names = "FEWEST", "FEWEST_SWITCHED", "FEWEST_JOINTED", "FEWEST_BOUND", "FEWEST_COUPLED", "FEWEST_HELD"
    for name in names:
        monkeypatch.setattr(systems, name, 0 if whole else 10**9)
    systems._LATEST.clear()


def ready(text: str, method: str = "taylor") -> Prepared:
    """A system that has been compiled."""
    asked = Compilation(method, 2.0**-52, OUTPUTS)
    return prepare_system(read_spec(text, "system.yaml"), partial(derive_system, resting=True), None, asked)


def followed(prepared: Prepared, text: str, stop: float = 1.5) -> Mapping[str, NDArray[np.float64]]:
    """The samples of a motion and its events."""
    return run(prepared, resolve_values(read_spec(text, "system.yaml"), {}), 0.0, stop, 7).data


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize("method", ["taylor", "ias15"])
@pytest.mark.parametrize("count", [1, 2, 3, 8, 9])
@pytest.mark.parametrize("case", CASES)
def test_events_are_those_of_the_members(
    case: str, count: int, method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    form, events = CASES[case]
    text = form.format(count=count, events=events)
    keep_families(monkeypatch, whole=True)
    assert family_run(read_spec(text, "system.yaml"), Compilation(method, 2.0**-52, OUTPUTS)) is not None
    stop = 1.5 if method == "taylor" else 1.6  # a sample at the time of a kick may have either side
    together = ready(text, method)
    found = followed(together, text, stop)
    keep_families(monkeypatch, whole=False)
    apart = ready(text, method)
    expected = followed(apart, text, stop)
    assert found.keys() == expected.keys()
    for path, values in expected.items():
        assert found[path].shape == values.shape, path
        assert np.max(np.abs(found[path] - values), initial=0.0) <= 2.0**-41, path
    one, other = together.recording, apart.recording
    assert (one.events, one.at_events) == (other.events, other.at_events)
    assert set(one.conserved) <= set(other.conserved)


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("case", ["walls", "kicks", "rods", "constraints"])
def test_what_is_said_of_events_does_not_grow_with_them(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    keep_families(monkeypatch, whole=True)

    def counted(count: int) -> tuple[int, int]:
        form, events = CASES[case]
        text = form.format(count=count, events=events)
        system = systems.family_system(read_spec(text, "system.yaml"))
        assert system is not None
        program = ready(text).machine.program
        return len(system.slots.graph.nodes), len(program.text.splitlines())

    assert counted(64) == counted(100)


def test_beads_between_walls_bounce_as_straight_lines_do(monkeypatch: pytest.MonkeyPatch) -> None:
    """Free beads, each with its own speed, between walls: the times are those of unfolded lines."""
    keep_families(monkeypatch, whole=True)
    text = """
sizes: {N: 9}
coordinates: {"x[i in range(N)]": {initial: "0.1 + 0.07*i", velocity: "1 + 0.13*i"}}
masses: {"bead[i in range(N)]": 1}
embedding: {"bead[i in range(N)]": "x[i]"}
potential: sum(0*x[i] for i in range(N))
events:
  right[i in range(N)]: {when: "x[i] - 1", direction: rising, action: {set: {"x_dot[i]": "-x_dot[i]"}}}
  left[i in range(N)]: {when: "x[i]", direction: falling, action: {set: {"x_dot[i]": "-x_dot[i]"}}}
"""
    prepared = ready(text)
    assert {one[1] for one in prepared.machine.program.events} == {int(Role.CHANGE)}
    found = followed(prepared, text, 3.0)
    for name, odd in (("right", 1), ("left", 0)):
        times = [((k - (0.1 + 0.07 * i)) / (1 + 0.13 * i), i) for i in range(9) for k in range(2 - odd, 9, 2)]
        expected = sorted(one for one in times if one[0] < 3.0)
        assert found[f"events/{name}/i"].tolist() == [i for _, i in expected]
        assert np.allclose(found[f"events/{name}/t"], [t for t, _ in expected], rtol=0.0, atol=2.0**-48)


def test_beads_that_collide_in_pairs_exchange_their_lines(monkeypatch: pytest.MonkeyPatch) -> None:
    """Equal beads on a line: together they are where free ones would be, which pass through each other."""
    keep_families(monkeypatch, whole=True)
    text = """
sizes: {N: 5}
coordinates: {"x[i in range(N)]": {initial: "0.3*i + 0.1*sin(i)", velocity: "2*cos(5*i)"}}
masses: {"bead[i in range(N)]": 1}
embedding: {"bead[i in range(N)]": "x[i]"}
potential: 0
events:
  hit[i in range(N), j in range(i)]:
    when: x[i] - x[j]
    direction: falling
    action: {set: {"x_dot[i]": "x_dot[j]", "x_dot[j]": "x_dot[i]"}}
"""
    prepared = ready(text)
    assert prepared.recording.conserved == ("h",)
    found = followed(prepared, text, 3.0)
    i = np.arange(5)
    free = 0.3 * i + 0.1 * np.sin(i) + 2.0 * np.cos(5 * i) * np.linspace(0.0, 3.0, 7)[:, None]
    assert np.any(np.diff(free) < 0.0)
    assert np.allclose(found["q/x"], np.sort(free), rtol=0.0, atol=2.0**-46)


@pytest.mark.parametrize(
    "events", ['{angle: {when: "atan2(x[0], x[1]) - 1"}}', '{narrow: {when: "exp(-1000*x[0]**2) - 0.5"}}']
)
def test_other_events_go_through_the_members(events: str, monkeypatch: pytest.MonkeyPatch) -> None:
    keep_families(monkeypatch, whole=True)
    assert systems.family_system(read_spec(CHAIN.format(count=3, events=events), "system.yaml")) is None


@pytest.mark.exhaustive(keep=0.55)
def test_an_elastic_wall_keeps_the_energy_and_no_momentum(monkeypatch: pytest.MonkeyPatch) -> None:
    keep_families(monkeypatch, whole=True)
    text = CHAIN.format(count=3, events=CASES["walls"][1])
    assert ready(text).recording.conserved == ("h",)
    assert ready(text.replace('-x_dot[i]"', '-x_dot[i] + 1"')).recording.conserved == ()


FREE = """
sizes: {N: COUNT}
parameters: {k: 1.5, r: 0.1}
coordinates: {"x[i in range(N)]": {initial: "0.5*sin(i + 1)", velocity: 1}, y: {initial: 0.2, velocity: 0.3}}
masses: {"bead[i in range(N)]": 1 + i/7, cart: 2}
embedding: {"bead[i in range(N)]": "x[i]", cart: y}
potential: sum(k*(x[i] - x[(i + 1) % N])**2/2 for i in range(N))
events:
  EVENTS
"""
ACTIONS = {
    "exchanged": '"x_dot[i]": "x_dot[j]", "x_dot[j]": "x_dot[i]"',
    "kept momenta": '"x_dot[i]": "x_dot[i] + 1/(1 + i/7)", "x_dot[j]": "x_dot[j] - 1/(1 + j/7)"',
    "places": '"x[i]": "x[j] + r"',
    "a parameter": "k: 2*k",
    "one that nothing uses": "r: 2*r",
    "all": '"x_dot[l in range(N)]": "-x_dot[l]"',
    "a shift of all": '"x[l in range(N)]": "x[l] + r"',
    "another": 'y_dot: "-y_dot"',
}


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("count", [2, 8])
@pytest.mark.parametrize("action", ACTIONS)
def test_what_events_may_change_is_what_members_say(
    action: str, count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    hit = '"hit[i in range(N), j in range(i)]": {when: "x[i] - x[j]", action: {set: {ACTION}}}'
    text = FREE.replace("EVENTS", hit.replace("ACTION", ACTIONS[action])).replace("COUNT", str(count))
    spec, said = read_spec(text, "system.yaml"), []
    for whole in (True, False):
        keep_families(monkeypatch, whole=whole)
        found = classify(spec).mechanics.conserved
        said.append({one.quantity: (one.because, one.breaks) for one in found})
    assert {"h", "p_y", "P_x"} <= said[0].keys()
    if (action, count) == ("a parameter", 2):  # where two beads meet there is no spring: members see that
        assert said[0]["h"][1] == ("hit[1,0]",) and said[1].pop("h")[1] == ()
    for quantity, what in said[0].items():
        assert said[1].get(quantity, what) == what, quantity


@pytest.mark.exhaustive(keep=0.8)
@pytest.mark.parametrize(("method", "tolerance", "off"), [("ias15", 2.0**-52, 1e-15), ("DOP853", 1e-5, 1e-4)])
def test_steps_on_rates_return_to_the_constraints(
    method: str, tolerance: float, off: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Beads on circles; samples are off by what polynomials within steps are."""
    keep_families(monkeypatch, whole=True)
    spec = read_spec(RING.format(count=3, events="{}"), "system.yaml")
    asked = Compilation(method, tolerance, frozenset(["q"]))
    assert family_run(spec, asked) is not None
    motion = run(prepare_system(spec, derive_system, None, asked), resolve_values(spec, {}), 0.0, 60.0, 5)
    assert motion.outcome.projections > 100
    assert np.allclose(motion["q/x"] ** 2 + motion["q/y"] ** 2, 1.0, rtol=0.0, atol=off)


@pytest.mark.exhaustive(keep=0.55)
@pytest.mark.parametrize("when", ["x[i] - 0.2*(-1)**i", "x[i] - 0.2*(-1.5)**i", "x[i]**(i + 1) - 0.05"])
def test_powers_of_negative_numbers_by_indices(when: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """They have no slope by their exponents: rounding errors were no numbers, and events at the start."""
    text = f"""
sizes: {{N: 9}}
coordinates: {{"x[i in range(N)]": {{initial: "0.5*sin(2 + i)", velocity: "cos(i)"}}}}
masses: {{"b[i in range(N)]": 1}}
positions: {{"b[i in range(N)]": "x[i]"}}
potential: "sum(x[i]**2 for i in range(N))"
events:
  "hit[i in range(N)]": {{when: "{when}", direction: falling, action: {{set: {{"x_dot[i]": "-x_dot[i]"}}}}}}
"""
    found = []
    for whole in (True, False):
        keep_families(monkeypatch, whole=whole)
        found.append(followed(ready(text), text))
    assert found[0].keys() == found[1].keys()
    for path, values in found[1].items():
        assert found[0][path].shape == values.shape
        assert np.max(np.abs(found[0][path] - values), initial=0.0) <= 2.0**-41, path
