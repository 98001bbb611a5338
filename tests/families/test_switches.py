"""Families with switches that stay families, beside the same systems written out and a closed form."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from lagrange_cli.families import system as systems
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.families import family_run
from lagrange_cli.integrate.guards.modes import Modes
from lagrange_cli.integrate.precision import DOUBLE_DOUBLE, FULL_DOUBLE_DOUBLE
from lagrange_cli.integrate.prepare import prepare_system
from lagrange_cli.integrate.prepared import Prepared
from lagrange_cli.native.guards import EXPLICIT, PLACED, ROOTS, SIMPLE
from lagrange_cli.native.stepping import guard_search
from lagrange_cli.run.derive import derive_system
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_long_values, resolve_values
from tests.families.test_events import PENDULUM, keep_families
from tests.support.draws import examples
from tests.support.families import Samples, alike
from tests.support.motion import Motion, run

OUTPUTS = frozenset(["q", "v", "h"])
LEDGERS = frozenset([*OUTPUTS, "ledger", "action"])
BEADS = """
sizes: {{N: {count}}}
parameters: {{k: 1.5, c: 0.3, "gap[i in range(N)]": "0.2 + 0.1*cos(i)"}}
coordinates: {{"x[i in range(N)]": {{initial: "0.5*sin(i + 1)", velocity: "2*cos(i*i + 1)"}}}}
masses: {{"bead[i in range(N)]": 1 + i/7}}
embedding: {{"bead[i in range(N)]": "x[i]"}}
potential: sum(x[i]**2/2 for i in range(N)) + {potential}
"""
GRID = """
sizes: {{N: {count}, M: 2}}
coordinates:
  x[i in range(N), j in range(M)]: {{initial: "0.5*sin(i + 2*j + 1)", velocity: "2*cos(i*i + j + 1)"}}
masses: {{"bead[i in range(N), j in range(M)]": 1 + i/7 + j}}
embedding: {{"bead[i in range(N), j in range(M)]": "x[i, j]"}}
potential: sum(x[i, j]**2/2 for i in range(N) for j in range(M)) + {potential}
"""
CIRCLE = """
sizes: {{N: {count}}}
parameters: {{R: 0.7, g: 2}}
coordinates: {{"x[i in range(N)]": {{initial: "2*pi*(i + 0.1*sin(i))/N", velocity: "0.3*cos(i*i + 1)"}}}}
masses: {{"bead[i in range(N)]": 1 + i/7}}
embedding: {{"bead[i in range(N)]": ["R*sin(x[i])", "R*cos(x[i])"]}}
potential: sum(g*bead[i].y + max(0, bead[i].x)**2 for i in range(N)) + {potential}
"""
"""Each bead has one coordinate, and a constant mass."""
GRAINS = """
sizes: {{N: {count}}}
parameters: {{k: 30, c: 2, d: 0.9}}
coordinates:
  x[i in range(N)]: {{initial: "1.05*i + 0.1*sin(7*i)", velocity: "1.5*cos(3*i)"}}
  y[i in range(N)]: {{initial: "0.2*sin(5*i)", velocity: "0.5*cos(5*i)"}}
masses: {{"p[i in range(N)]": 1 + i/7}}
embedding: {{"p[i in range(N)]": ["x[i]", "y[i]"]}}
definitions:
  dx[i in range(N), j in range(N)]: x[i] - x[j]
  dy[i in range(N), j in range(N)]: y[i] - y[j]
  u[i in range(N), j in range(N)]: x_dot[i] - x_dot[j]
  w[i in range(N), j in range(N)]: y_dot[i] - y_dot[j]
potential: sum(k/2*max(0, d - norm(p[i] - p[j]))**2 for i in range(N) for j in range(i))
{potential}
"""
PAIRS = GRAINS.replace("\n{potential}", " + {potential}")
CHARGES = """
sizes: {{N: {count}}}
parameters: {{"B[i in range(N)]": 2 + i/9, s: 0.1}}
coordinates:
  x[i in range(N)]: {{initial: "0.4*sin(7*i + 1)", velocity: "1.5*cos(3*i)"}}
  y[i in range(N)]: {{initial: "i", velocity: "0.5*cos(5*i)"}}
lagrangian: sum((x_dot[i]**2 + y_dot[i]**2)/2 - x[i]**2/3 - y[i]**2/9 for i in range(N)) + {potential}
"""
RODS = PENDULUM.replace("\nevents: {events}", " + {potential}")
STOPS = "sum(k*max(0, x[i] - gap[i])**2 + k*max(0, -x[i] - gap[i])**2 for i in range(N))"
KINK = "sum(max(0, x[i])**2 for i in range(N))"
CASES = {
    "springs that only push": (BEADS, "sum(4*max(0, x[i - 1] - x[i] - 0.1)**2 for i in range(1, N))"),
    "stops on both sides": (BEADS, STOPS),
    "powers of absolute values": (BEADS, "sum(k*abs(x[i])**3 + x[i]*abs(x[i])/9 for i in range(N))"),
    "a ring": (BEADS, "sum(max(0, x[i] - x[(i + 1) % N] - gap[i])**2 for i in range(N))"),
    "all pairs": (
        BEADS,
        "sum(max(0, x[i] - x[j] - 0.2)**2 - min(0, x[i] - x[j])**3/9 for i in range(N) for j in range(i))",
    ),
    "conditions on members and places": (
        BEADS,
        "sum(where(i % 2 == 0 and x[i] > 0, x[i]**2, 2*x[i]**2) for i in range(N))",
    ),
    "two conditions": (
        BEADS,
        "sum(where(x[i] > 0 and x[i] < 0.7, 0, x[i]**2*(x[i] - 0.7)**2) for i in range(N))",
    ),
    "one inside another": (BEADS, "sum(where(x[i] > 0, max(0, x[i] - 0.3)**2, x[i]**2) for i in range(N))"),
    "walls for both sides": (BEADS, "sum(k*max(0, abs(x[i]) - 0.35)**2 for i in range(N))"),
    "arguments with several": (
        BEADS,
        "sum(max(0, abs(x[i])**3 + min(0, x[(i + 1) % N])**2 - 0.2)**2 for i in range(N))"
        " + max(0, sum(max(0, x[i])**2 for i in range(N)) - 0.3)**2",
    ),
    "a sum": (BEADS, "max(0, sum(x[i] for i in range(N)))**2"),
    "times": (BEADS, "sum(where(t < 0.4 + gap[i], x[i]**2, 2*x[i]**2) for i in range(N))"),
    "drag": (BEADS, '0\ngeneralized_forces: {{"x[i in range(N)]": "-c*x_dot[i]*abs(x_dot[i])"}}'),
    "damping on one side": (BEADS, "0\ndissipation: sum(c*max(0, x_dot[i])**2 for i in range(N))"),
    "a push for a time": (
        BEADS,
        '0\ngeneralized_forces: {{"x[i in range(N)]": "where(t < 0.3 + i/10, 1, c)"}}',
    ),
    "events": (BEADS, KINK + '\nevents: {{"hit[i in range(N)]": {{when: "abs(x[i]) - gap[i]"}}}}'),
    "walls": (
        BEADS,
        KINK + '\nevents: {{"wall[i in range(N)]": {{when: "x[i] - 0.6", direction: rising,'
        ' action: {{set: {{"x_dot[i]": "-x_dot[i]"}}}}}}}}',
    ),
    "beside narrow forces": (
        BEADS,
        "sum(max(0, x[i] - 0.3)**2*exp(-3*x[i]) for i in range(N))"
        " + sum(0.01/(x[i] - x[i - 1] + 5)**12 for i in range(1, N))",
    ),
    "powers without a series": (BEADS, "sum(max(0, x[i - 1] - x[i])**2.5 for i in range(1, N))"),
    "two indices": (
        GRID,
        "sum(max(0, x[i, j] - x[(i + 1) % N, j])**2 for i in range(N) for j in range(M)) + sum(where("
        "x[i, j] > x[i, j - 1], (x[i, j] - x[i, j - 1])**2, 2*(x[i, j] - x[i, j - 1])**2)"
        " for i in range(N) for j in range(1, M))",
    ),
    "by parameters": (
        BEADS,
        "sum(abs(c - k)*abs(x[i])**3 + where(gap[i] > 0.2 and x[i] > 0, x[i]**2, where(c > k, 5, 2)*x[i]**2)"
        " for i in range(N))",
    ),
    "jumps with places": (BEADS, "sum(k*abs(x[i]) for i in range(N))"),
    "distances on one axis": (BEADS, "sum(k*(abs(x[i] - x[i - 1]) - c)**2 for i in range(1, N))"),
    "backlash": (BEADS, "sum(k*max(0, abs(x[i] - x[i - 1]) - c)**2 for i in range(1, N))"),
    "walls at parameters": (BEADS, "sum(k*max(0, abs(x[i]) - gap[i])**2 for i in range(N))"),
    "jumps that bring to rest": (
        BEADS,
        "sum(3*abs(x[i]) for i in range(N))\ndissipation: sum(k*x_dot[i]**2 for i in range(N))",
    ),
    "dashpots": (
        GRAINS,
        "dissipation: sum(where(norm(p[i] - p[j]) < d, c*(u[i, j]**2 + w[i, j]**2), 0)"
        " for i in range(N) for j in range(i))",
    ),
    "dashpots along the normal": (
        GRAINS,
        "dissipation: sum(where(norm(p[i] - p[j]) < d, c/2*(dx[i, j]*u[i, j] + dy[i, j]*w[i, j])**2, 0)"
        " for i in range(N) for j in range(i))",
    ),
    "drag in a round region and behind a moving wall": (
        GRAINS,
        "dissipation: sum(where(norm(p[i]) < 1.3, c*(x_dot[i]**2 + y_dot[i]**2), 0)"
        " + where(x[i] > 2 - t/9, (x_dot[i] + 1/9)**4, 0) for i in range(N))",
    ),
    "dashpots of each particle": (
        GRAINS,
        'forces: {{"p[i in range(N)]": ["-c*x_dot[i]/9 - sum(where(norm(p[i] - p[j]) < d, c*u[i, j], 0)'
        ' for j in range(N) if j != i)", "sum(where(norm(p[i] - p[j]) < d, -c*w[i, j], 0)'
        ' for j in range(N) if j != i)"]}}',
    ),
    "fields that begin at a line": (
        CHARGES,
        "sum(where(x[i] > s, B[i], 0)*(x[i] - s)*y_dot[i] for i in range(N))",
    ),
    "fields in a strip, beside others": (
        CHARGES,
        "sum(x[i]*y_dot[i] + B[i]*min(max(x[i], -0.1), 0.1)*y_dot[i] for i in range(N))"
        " - sum((x[i] - x[i - 1])**2 for i in range(1, N))",
    ),
    "forces in strips": (
        BEADS,
        "sum(k*min(max(x[i], -0.1), 0.2) + c*where(x[i] > 0.5, x[i] - 0.5, 0) for i in range(N))",
    ),
    "brakes before the next one": (
        BEADS,
        '0\ngeneralized_forces: {{"x[i in range(N)]": '
        '"-where(x[(i + 1) % N] - x[i] < gap[i], k*max(0, x_dot[i] - x_dot[(i + 1) % N]), 0)"}}',
    ),
    "poles on a circle": (
        CIRCLE,
        "sum(1/norm(bead[i] - bead[i - 1])/9 - log(abs(x[i] - x[i - 1]))/5 for i in range(1, N))",
    ),
    "forces between two places": (BEADS, "sum(k*min(max(x[i], -c), c) for i in range(N))"),
    "attractions that are cut off": (
        PAIRS,
        "-sum(where(norm(p[i] - p[j]) < c, k/90*(1/norm(p[i] - p[j]) - 1/c), 0)"
        " for i in range(N) for j in range(i))",
    ),
    "attractions that fade at their end": (
        PAIRS,
        "-sum(where(norm(p[i] - p[j]) < c, k/30*(1/norm(p[i] - p[j]) - 2/c + norm(p[i] - p[j])/c**2), 0)"
        " for i in range(N) for j in range(i))",
    ),
    "forces of Lennard and Jones that are cut off": (
        PAIRS,
        "sum(where(norm(p[i] - p[j]) < c, norm(p[i] - p[j])**-12 - 2*norm(p[i] - p[j])**-6 - c**-12"
        " + 2*c**-6, 0) for i in range(N) for j in range(i))\n"
        'generalized_forces: {{"x[i in range(N)]": -0.3*x_dot[i]}}',
    ),
    "rods": (RODS, "sum(3*max(0, th[i] - 0.2)**2 + max(0, 0.5 - bob[i].x)**2 for i in range(N))"),
}


def written(case: str, count: int) -> str:
    """The text of a system file."""
    form, potential = CASES[case]
    return form.replace("{potential}", potential).format(count=count)


METHODS = {"taylor": 2.0**-52, "ias15": 2.0**-52, "DOP853": 1e-12}
"""Their tolerances."""
CLOSE = {"taylor": 2.0**-41, "ias15": 2.0**-41, "DOP853": 2.0**-30}
"""How near two motions are that have been followed by other steps."""
BY_RATES = pytest.mark.parametrize("method", ["ias15", "DOP853"])


def ready(
    text: str, outputs: frozenset[str] = OUTPUTS, *, backward: bool = False, method: str = "taylor"
) -> Prepared:
    """A system that has been compiled."""
    asked = Compilation(method, METHODS[method], outputs, backward=backward)
    return prepare_system(read_spec(text, "system.yaml"), partial(derive_system, resting=True), None, asked)


def followed(prepared: Prepared, text: str, stop: float = 1.5) -> Motion:
    """A motion and its events."""
    return run(prepared, resolve_values(read_spec(text, "system.yaml"), {}), 0.0, stop, 7)


def long_motions(
    text: str, monkeypatch: pytest.MonkeyPatch, stop: float, outputs: frozenset[str] = LEDGERS
) -> list[Samples]:
    """In double-double: what families compute, and what their members do."""
    asked = Compilation("taylor", FULL_DOUBLE_DOUBLE, outputs, precision=DOUBLE_DOUBLE)
    spec, found = read_spec(text, "system.yaml"), []
    for whole in (True, False):
        keep_families(monkeypatch, whole=whole)
        assert (family_run(spec, asked) is not None) == whole
        prepared = prepare_system(spec, partial(derive_system, resting=True, exact=True), None, asked)
        found.append(run(prepared, resolve_long_values(spec, {}), 0.0, stop, 4).data)
    return found


def compare_long(text: str, monkeypatch: pytest.MonkeyPatch, stop: float, most: float) -> None:
    """These are alike."""
    one, other = long_motions(text, monkeypatch, stop)
    assert one.keys() == other.keys()
    alike(one, other, most)


def ledgers_close(text: str, monkeypatch: pytest.MonkeyPatch, method: str) -> None:
    """What is unaccounted for in families is rounding."""
    keep_families(monkeypatch, whole=True)
    found = followed(ready(text, LEDGERS | {"p"}, method=method), text, 0.9)
    for path, values in found.data.items():
        if "ledger/" in path:
            size = np.max(np.abs(found[path.replace("ledger/", "")]), initial=1.0)
            assert np.max(np.abs(values)) <= 2.0**-42 * size, path


def compare(
    text: str,
    monkeypatch: pytest.MonkeyPatch,
    outputs: frozenset[str] = OUTPUTS,
    stop: float = 1.5,
    *,
    backward: bool = False,
    method: str = "taylor",
) -> None:
    """The families of a system move as their members do."""
    keep_families(monkeypatch, whole=True)
    asked = Compilation(method, METHODS[method], outputs, backward=backward)
    system = family_run(read_spec(text, "system.yaml"), asked)
    assert system is not None
    together = ready(text, outputs, backward=backward, method=method)
    assert set(together.machine.program.guards) <= {SIMPLE, EXPLICIT, PLACED, *ROOTS}
    found = followed(together, text, stop)
    keep_families(monkeypatch, whole=False)
    apart = ready(text, outputs, backward=backward, method=method)
    expected = followed(apart, text, stop)
    more, few = (1.1, 2) if method == "taylor" else (2.0, 10)
    guards, fewer = (len(one.machine.program.guards) for one in (together, apart))
    more *= max(guards / max(fewer, 1), 1.0)  # x - y and y - x are one argument, and one crossing, apart
    loud, silent = (len(one.machine.program.silent) for one in (together, apart))
    few += 2 * max(silent - loud, 0)  # in families a mode that several terms share is never silent
    assert found.outcome.steps <= more * expected.outcome.steps + few
    assert found.data.keys() == expected.data.keys()
    alike(found.data, expected.data, CLOSE[method])
    one, other = together.recording, apart.recording
    assert (one.events, one.at_events) == (other.events, other.at_events)
    assert one.conserved == other.conserved


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize("count", [1, 2, 3, 8, 9])
@pytest.mark.parametrize("case", CASES)
def test_switches_are_those_of_the_members(case: str, count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    compare(written(case, count), monkeypatch)


@pytest.mark.exhaustive(keep=0.35)
@BY_RATES
@pytest.mark.parametrize("count", [1, 2, 3, 8, 9])
@pytest.mark.parametrize("case", CASES)
def test_switches_in_steps_on_rates(
    case: str, count: int, method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    compare(written(case, count), monkeypatch, method=method)


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize(
    "case", ["stops on both sides", "drag", "dashpots", "jumps with places", "distances on one axis"]
)
def test_ledgers_have_switches_too(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    compare(written(case, 3), monkeypatch, LEDGERS)


@pytest.mark.exhaustive(keep=0.4)
@pytest.mark.parametrize("case", ["a ring", "drag", "times", "events", "dashpots", "rods"])
def test_switches_change_backward_as_well(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    compare(written(case, 3), monkeypatch, stop=-1.0, backward=True)


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize(
    "case", ["drag", "powers without a series", "walls", "events", "two indices", "rods", "backlash"]
)
def test_switches_in_double_double(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    compare_long(written(case, 3), monkeypatch, stop=1.5, most=2.0**-92)


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize("count", [1, 2, 3, 8, 9])
@pytest.mark.parametrize("outputs", [OUTPUTS, LEDGERS])
def test_forces_that_jump_hold_members_where_these_are(
    count: int, outputs: frozenset[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Beads on top of each other, which are pulled apart ever more strongly: some come loose, and meet."""
    pulls = 'generalized_forces: {{"x[i in range(N)]": "2*t*sin(5*i + 1)"}}'
    text = BEADS.replace("{potential}", f"sum(c*abs(x[i] - x[i - 1]) for i in range(1, N))\n{pulls}")
    text = text.replace("0.5*sin(i + 1)", "0").replace("2*cos(i*i + 1)", "0")
    compare(text.format(count=count), monkeypatch, outputs, stop=2.0)


PLACES = "{x}", "{x} - {y}", "{y} - 0.3", "{x} + {y}/2 - t/5", "{x}*{y} + 0.1"
SHAPES = (
    "max(0, {u})**2", "abs({u})**3/9", "min({u}, 0)**4", "where({u} > 0, ({u})**2, 2*({u})**2)",
    "where({u} >= 0 or i == 1, 0, ({u})**2)", "where(not {u} > 0, -(({u})**3), 0)", "sin(max({u}, 0)**2)",
)  # fmt: skip
OTHERS = "x[(i + 1) % N, j]", "x[i, (j + 1) % M]", "x[i, j - 1]", "x[j, i % M]"


@pytest.mark.exhaustive(keep=0.2)
@given(data=st.data())
@examples(2)
def test_random_families_with_switches(data: st.DataObject) -> None:
    """Sums over rings, neighbours and two indices, with conditions."""
    terms = []
    for _ in range(data.draw(st.integers(1, 2))):
        y, u = data.draw(st.sampled_from(OTHERS)), data.draw(st.sampled_from(PLACES))
        shape = data.draw(st.sampled_from(SHAPES)).format(u=u.format(x="x[i, j]", y=y))
        first = 1 if "j - 1" in y else 0
        rows = "2" if "x[j" in y else "N"
        columns = "2" if "x[j" in y else "M"
        terms.append(f"sum({shape} for i in range({rows}) for j in range({first}, {columns}))")
    count = data.draw(st.integers(2, 3))
    with pytest.MonkeyPatch.context() as monkeypatch:
        compare(GRID.format(count=count, potential=" + ".join(terms)), monkeypatch, stop=1.0)


def test_unlike_springs_to_the_left_and_right(monkeypatch: pytest.MonkeyPatch) -> None:
    """x'' = -a^2 x to the right, -b^2 x to the left: half a period each, with the speed unchanged."""
    keep_families(monkeypatch, whole=True)
    text = """
sizes: {N: 9}
coordinates: {"x[i in range(N)]": {initial: 0, velocity: "where(i % 2 == 0, 1, -1)"}}
parameters: {"a[i in range(N)]": "1 + 0.1*i", b: 2}
masses: {"bead[i in range(N)]": 1}
embedding: {"bead[i in range(N)]": "x[i]"}
potential: sum(where(x[i] > 0, a[i], b)**2*x[i]**2/2 for i in range(N))
"""
    found, times = followed(ready(text), text, 6.0)["q/x"], np.linspace(0.0, 6.0, 7)
    for i in range(9):
        rates = (1 + 0.1 * i, 2.0) if i % 2 == 0 else (2.0, 1 + 0.1 * i)
        halves = np.pi / rates[0], np.pi / rates[1]
        side = -1.0 if i % 2 else 1.0
        since = times % sum(halves)
        first = side * np.sin(rates[0] * since) / rates[0]
        second = -side * np.sin(rates[1] * (since - halves[0])) / rates[1]
        assert np.allclose(found[:, i], np.where(since < halves[0], first, second), rtol=0.0, atol=1e-13)


@pytest.mark.exhaustive(keep=0.5)
def test_balls_bounce_on_a_floor_that_has_no_series_at_its_surface() -> None:
    """A force of depth^(3/2): each ball keeps its energy, wherever it is put as it touches the floor."""
    text = """
    sizes: {N: 30}
    coordinates: {"y[i in range(N)]": {initial: "1 + i/60"}}
    lagrangian: sum(y_dot[i]**2/2 - 9.81*y[i] - 1e4*max(0, -y[i])**2.5 for i in range(N))
    """
    prepared = ready(text, method="ias15")
    motion = followed(prepared, text, 1.0)
    assert prepared.machine.program.loops and motion.outcome.ending is Ending.COMPLETE
    y, v = motion["q/y"], motion["v/y"]
    energies = v**2 / 2 + 9.81 * y + 1e4 * np.maximum(0.0, -y) ** 2.5
    assert np.allclose(energies, energies[0], rtol=1e-13, atol=0.0) and np.any(v[-1] > 0.0)


@pytest.mark.exhaustive(keep=0.45)
def test_what_is_said_of_switches_does_not_grow_with_them(monkeypatch: pytest.MonkeyPatch) -> None:
    keep_families(monkeypatch, whole=True)

    def counted(count: int) -> tuple[int, int]:
        text = written("stops on both sides", count)
        system = systems.family_system(read_spec(text, "system.yaml"))
        assert system is not None
        program = ready(text).machine.program
        assert len(program.guards) == 2 * count
        return len(system.slots.graph.nodes), len(program.text.splitlines())

    assert counted(64) == counted(100)


@pytest.mark.exhaustive(keep=0.7)
@pytest.mark.parametrize(
    ("energy", "guards"),
    [
        ("1/norm(bead[i] - bead[j])", 0),
        ("1/abs(sin((x[i] - x[j])/2))", 0),
        ("-log(abs(x[i] - x[j])) + 1/sqrt(abs(x[i] - x[j]))", 0),
        ("1/abs(x[i] - x[j]) + abs(x[i] - x[j])**3", 36),  # which a strength of 0 would leave
        ("sqrt(abs(x[i] - x[j]))**3", 36),
    ],
)
def test_poles_are_not_followed(energy: str, guards: int, monkeypatch: pytest.MonkeyPatch) -> None:
    keep_families(monkeypatch, whole=True)
    potential = f"sum(k[i]*k[j]*({energy}) for i in range(N) for j in range(i))"
    text = CIRCLE.replace("{potential}", potential).replace("R: 0.7", '"k[i in range(N)]": i, R: 0.7')
    program = ready(text.replace("max(0, bead[i].x)**2", "0").format(count=9)).machine.program
    assert len(program.guards) == guards


def counted_series(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """How many series are computed to settle modes, as the only entry."""
    own, calls = Modes._series, [0]

    def counting(modes: Modes) -> NDArray[np.float64]:
        calls[0] += 1
        return own(modes)

    monkeypatch.setattr(Modes, "_series", counting)
    return calls


@pytest.mark.exhaustive(keep=0.25)
def test_series_to_settle_do_not_grow_with_the_switches(monkeypatch: pytest.MonkeyPatch) -> None:
    """All members begin where their forces have kinks, half of them to either side. (Three of the series tell
    whether nothing but rounding moves them.)"""
    keep_families(monkeypatch, whole=True)
    form = BEADS.replace("0.5*sin(i + 1)", "0").replace("2*cos(i*i + 1)", "0")
    calls = counted_series(monkeypatch)

    def series(count: int) -> int:
        text = form.format(
            count=count, potential="sum(max(0, x[i])**2 + x[i]*where(i % 2 == 0, 1, -1) for i in range(N))"
        )
        calls[0] = 0
        found = followed(ready(text), text, 0.1)
        signs = np.sign(found["q/x"][-1])
        assert np.array_equal(signs, np.where(np.arange(count) % 2 == 0, -1.0, 1.0))
        return calls[0]

    assert series(200) == series(50) <= 15


@pytest.mark.exhaustive(keep=0.3)
@pytest.mark.parametrize(
    ("case", "method"),
    [
        ("stops on both sides", "taylor"),
        ("powers without a series", "taylor"),
        ("walls", "taylor"),
        ("one inside another", "ias15"),
    ],
)
def test_switches_that_are_passed_over_together_are_not_due(
    case: str, method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The motion is the same, to the last bit, where every argument is looked at by itself. (There are
    guards behind the last whole vector, too.)"""
    keep_families(monkeypatch, whole=True)
    text = written(case, 35)
    together = ready(text, method=method)
    monkeypatch.setattr(guard_search, "MANY", 10**9)
    apart = ready(text, method=method)
    assert together.machine.program.text != apart.machine.program.text
    found, expected = (followed(one, text, 0.4) for one in (together, apart))
    assert found.outcome.steps == expected.outcome.steps > 10
    for path, values in expected.data.items():
        assert np.array_equal(found[path], values), path


@pytest.mark.exhaustive(keep=5)
@pytest.mark.parametrize(
    "potential",
    [
        '0\ngeneralized_forces: {{"x[i in range(N)]": "-c*sign(x_dot[i] - x_dot[0])"}}',
        "sum(max(0, sqrt(0.1 + abs(x[i])**3) - 0.4)**2 for i in range(N))",
        "sum(abs(x[i] - 0.3) + max(0, x[i] - 0.1 - 0.2) for i in range(N))",
        '0\ngeneralized_forces: {{"x[i in range(N)]": "-sign(x_dot[i]) - where(x_dot[i] > c, 1, 0)"}}',
        "sum((atan2(x[i], x[0] - 3) - 1)**2 for i in range(N))",
        "sum(max(0, atan2(x[i], x[0] - 3))**2 for i in range(N))",
        '0\ndissipation: "sum(atan2(x_dot[i], x[0] - 3)**2 for i in range(N))"',
        '0\ngeneralized_forces: {{"x[i in range(N)]": "-sign(x_dot[i])*sqrt(abs(x_dot[i]))"}}',
        '0\ngeneralized_forces: {{"x[i in range(N)]": "where(exp(-9*(t - 1)**2) > 0.5, c, 0)"}}',
    ],
)
def test_other_switches_go_through_the_members(potential: str, monkeypatch: pytest.MonkeyPatch) -> None:
    keep_families(monkeypatch, whole=True)
    text = BEADS.replace("{potential}", potential).format(count=3)
    assert family_run(read_spec(text, "system.yaml"), Compilation("taylor", 2.0**-52, OUTPUTS)) is None


AT_ZERO = """
sizes: {N: 20}
coordinates: {"x[i in range(N)]": {initial: 0}, "y[i in range(N)]": {initial: 0}}
masses: {"p[i in range(N)]": 1, "q[i in range(N)]": 1 + i}
positions: {"p[i in range(N)]": ["x[i]"], "q[i in range(N)]": ["y[i]"]}
potential: sum(x[i]**2/2 for i in range(N))
generalized_forces: {"y[i in range(N)]": "FORCE"}
"""


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(
    ("force", "value"), [("sign(x[i])", 0), ("2 + sign(x_dot[i])", 2), ("where(x[i] > 0, 1, 3)", 3),
                         ("where(x[i] >= 0, 1, 3)", 1), ("where(x_dot[i] < 0, 1, 3)", 3)],
)  # fmt: skip
def test_switches_whose_arguments_stay_0_have_their_values_there(
    force: str, value: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    keep_families(monkeypatch, whole=True)
    text = AT_ZERO.replace("FORCE", force)
    found = followed(ready(text), text, 2.0)
    assert found["v/y"][-1] == pytest.approx(2.0 * value / (1.0 + np.arange(20)), rel=1e-14, abs=1e-300)
