"""Dry friction along vectors, u/|u|, of members of families, beside the same systems written out, and closed
forms."""

from __future__ import annotations

import numpy as np
import pytest

from lagrange_cli.families.system import any_family_system, reason
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.families import family_run
from lagrange_cli.native.guards import EXPLICIT
from lagrange_cli.spec.read import read_spec
from tests.families.test_events import keep_families
from tests.families.test_switches import (
    BY_RATES,
    CLOSE,
    METHODS,
    OUTPUTS,
    compare_long,
    followed,
    ledgers_close,
    ready,
)
from tests.motions.test_turning_under_friction import half_cycles
from tests.support.families import alike

HEAD = """
sizes: {{N: {count}}}
parameters: {{F: {F}, k: {k}, c: {c}, l: 1.0, w: {w}}}
coordinates:
  "x[i in range(N)]": {{initial: "1.05*i + 0.02*sin(5*i)", velocity: "{speed}*sin(3*i + 1)"}}
  "y[i in range(N)]": {{initial: "0.1*cos(2*i)", velocity: "{speed}*cos(5*i)"}}
masses: {{"p[i in range(N)]": 1 + i % 2}}
embedding: {{"p[i in range(N)]": ["x[i]", "y[i]"]}}
"""
SPACE = """
sizes: {{N: {count}}}
parameters: {{F: {F}, k: {k}, c: {c}, l: 1.0, w: {w}}}
coordinates:
  "x[i in range(N)]": {{initial: "1.05*i", velocity: "{speed}*sin(3*i + 1)"}}
  "y[i in range(N)]": {{initial: "0.1*cos(2*i)", velocity: "{speed}*cos(5*i)"}}
  "z[i in range(N)]": {{initial: "0.1*sin(3*i)", velocity: "{speed}*cos(7*i)"}}
masses: {{"p[i in range(N)]": 1 + i % 2}}
embedding: {{"p[i in range(N)]": ["x[i]", "y[i]", "z[i]"]}}
"""
SPRINGS = "sum(k*(norm(p[i + 1] - p[i]) - l)**2/2 for i in range(N - 1))"
PUSHED = "sum(k*(x[i]**2 + y[i]**2)/9 - w*t*(x[i] + 2*y[i]) for i in range(N))"
ALONG = 'forces: {{"p[i in range(N)]": "-F*(p[i].vx, p[i].vy)/norm((p[i].vx, p[i].vy))"}}\n'
POWER = 'dissipation: "sum({}*norm((p[i].vx, p[i].vy)) for i in range(N))"\n'
SPEED = "sqrt(p[i].vx**2 + p[i].vy**2 + p[i].vz**2)"
CASES = {
    "pucks": (HEAD, 'potential: "0"\n' + ALONG),
    "pucks on springs": (HEAD, f'potential: "{SPRINGS}"\n' + POWER.format("F")),
    "pushed from rest": (HEAD, f'potential: "{PUSHED}"\n' + POWER.format("F*(1 + i)")),
    "a limit by places": (HEAD, f'potential: "{PUSHED}"\n' + POWER.format("(F + c*(x[i] - i)**2)")),
    "with drag": (
        HEAD,
        f'potential: "{PUSHED}"\n'
        'forces: {{"p[i in range(N)]": "-(F/norm((p[i].vx, p[i].vy)) + c*norm((p[i].vx, p[i].vy)))'
        '*(p[i].vx, p[i].vy)"}}\n',
    ),
    "a direction that slides more easily": (
        HEAD,
        f'potential: "{PUSHED}"\ndissipation: "sum(F*sqrt(p[i].vx**2 + 3*p[i].vy**2) for i in range(N))"\n',
    ),
    "contacts": (
        HEAD,
        'potential: "sum(9*k*max(0, l - norm(p[i] - p[j]))**2 for i in range(N) for j in range(i))"\n'
        + POWER.format("F"),
    ),
    "in a box, some of them": (
        HEAD,
        'potential: "sum(k*max(0, abs(x[i] - N/2) - N/2)**2 + k*y[i]**2 for i in range(N))"\n'
        'dissipation: "sum(F*norm((p[i].vx, p[i].vy)) for i in range(N) if i % 3 != 1)'
        ' + sum(F*abs(x_dot[i]) for i in range(N) if i % 3 == 1)"\n',
    ),
    "in space": (
        SPACE,
        'potential: "sum(k*z[i]**2 + k*x[i]**2/9 for i in range(N))"\n'
        f'dissipation: "sum(F*{SPEED} for i in range(N))"\n',
    ),
    "on a floor that gives way": (
        SPACE,
        'potential: "sum(2*z[i] + 9*k*max(0, -z[i])**2 + k*x[i]**2/9 for i in range(N))"\n'
        'dissipation: "sum(3*F*k*max(0, -z[i])*norm((p[i].vx, p[i].vy)) for i in range(N))'
        ' + sum(c*z_dot[i]**2 for i in range(N))"\n',
    ),
    "events": (
        HEAD,
        f'potential: "{SPRINGS}"\n'
        + POWER.format("F")
        + 'events: {{"far[i in range(N)]": {{when: "y[i]"}}}}\n',
    ),
}


def written(case: str, count: int, speed: float | None = None) -> str:
    """The text of a system file, with numbers drawn for it."""
    form, rest = CASES[case]
    chance = np.random.default_rng([count, len(case)])
    F, k, c, w, v = chance.uniform([0.4, 4.0, 0.1, 0.5, 0.4], [0.9, 9.0, 0.4, 1.5, 0.9])
    return (form + rest).format(count=count, F=F, k=k, c=c, w=w, speed=v if speed is None else speed)


def move_alike(
    text: str, monkeypatch: pytest.MonkeyPatch, method: str = "taylor", *, slack: int = 20
) -> None:
    """Families move as their members do, in about as many steps."""
    found = []
    for whole in (True, False):
        keep_families(monkeypatch, whole=whole)
        spec, asked = read_spec(text, "system.yaml"), Compilation(method, METHODS[method], OUTPUTS)
        assert (family_run(spec, asked) is not None) == whole
        found.append(followed(ready(text, method=method), text, 0.9))
    one, other = found
    assert one.outcome.steps <= 2 * other.outcome.steps + slack
    assert one.data.keys() == other.data.keys()
    alike(one.data, other.data, CLOSE[method])


@pytest.mark.exhaustive(keep=0.4)
@pytest.mark.parametrize("count", [1, 2, 3, 8, 9])
@pytest.mark.parametrize("case", CASES)
def test_vectors_rub_as_written_out(case: str, count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    move_alike(written(case, count), monkeypatch)


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize("case", CASES)
def test_members_may_begin_at_rest(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    move_alike(written(case, 3, speed=0.0), monkeypatch)


@pytest.mark.exhaustive(keep=0.4)
@BY_RATES
@pytest.mark.parametrize("case", [one for one in CASES if one != "contacts"])
def test_vectors_in_steps_on_rates(case: str, method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    move_alike(written(case, 3), monkeypatch, method)


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("case", CASES)
def test_ledgers_have_the_forces_that_hold_vectors(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    ledgers_close(written(case, 8), monkeypatch, "taylor")


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize("case", ["pucks", "pushed from rest"])
def test_vectors_in_double_double(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    compare_long(written(case, 2), monkeypatch, stop=0.6, most=2.0**-70)


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize(("count", "method"), [(40, "taylor"), (80, "taylor"), (80, "ias15")])
def test_many_pucks_stop_where_they_must(count: int, method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each slides v^2/(2a) far along its velocity, and rests there to the last bit."""
    keep_families(monkeypatch, whole=True)
    text = written("pucks", count)
    prepared = ready(text, frozenset({"q", "v"}), method=method)
    assert prepared.machine.program.guards == (EXPLICIT,) * count
    found = followed(prepared, text, 4.0).data
    start = [found[f"q/{one}"][0] for one in "xy"]
    speeds = [found[f"v/{one}"][0] for one in "xy"]
    chance = np.random.default_rng([count, len("pucks")])
    deceleration = chance.uniform(0.4, 0.9) / (1 + np.arange(count) % 2)
    assert np.all(np.hypot(*speeds) < 4.0 * deceleration)
    for one, q, v in zip("xy", start, speeds):
        ways = v * np.hypot(*speeds) / (2.0 * deceleration)
        np.testing.assert_allclose(found[f"q/{one}"][-1], q + ways, rtol=2.0**-46, atol=2.0**-48)
        assert not found[f"v/{one}"][-1].any()


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("factor", [1.0 - 1e-9, 1.0 + 1e-2])
def test_a_tilted_table_holds_up_to_its_limit(factor: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """All of 20 bodies rest, or begin to slide at once: g sin(a) against mu g cos(a), in any direction."""
    keep_families(monkeypatch, whole=True)
    text = f"""
sizes: {{N: 20}}
parameters: {{mu: 0.3, g: 9.81, a: atan(mu)*{factor!r}}}
coordinates: {{"x[i in range(N)]": {{initial: 0}}, "y[i in range(N)]": {{initial: 0}}}}
masses: {{"p[i in range(N)]": 1}}
embedding: {{"p[i in range(N)]": ["x[i]", "y[i]"]}}
potential: "-sum(g*sin(a)*(x[i]*cos(i) + y[i]*sin(i)) for i in range(N))"
dissipation: "sum(mu*g*cos(a)*norm((p[i].vx, p[i].vy)) for i in range(N))"
"""
    found = followed(ready(text, frozenset({"q", "v"})), text, 2.0).data
    ways = np.hypot(found["q/x"][-1], found["q/y"][-1])
    if factor < 1.0:
        assert not ways.any()
        return
    angle = np.arctan(0.3) * factor
    expected = 2.0 * 9.81 * (np.sin(angle) - 0.3 * np.cos(angle))
    np.testing.assert_allclose(ways, expected, rtol=1e-12)


@pytest.mark.parametrize(
    "force",
    [
        "-F*(p[i].vx - p[0].vx, p[i].vy)/norm((p[i].vx - p[0].vx, p[i].vy))",
        "-F*(p[i].vy, -p[i].vx)/norm((p[i].vx, p[i].vy))",
        "-F*(p[i].vx, p[i].vy)/norm((p[i].vx, p[i].vy)) - (sign(x_dot[i]), 0)",
    ],
)
def test_what_acts_in_other_ways_is_written_out(force: str) -> None:
    text = (HEAD + 'potential: "0"\nforces: {{"p[i in range(N)]": "' + force + '"}}\n').format(
        count=20, F=1, k=1, c=1, w=1, speed=1
    )
    spec = read_spec(text, "system.yaml")
    assert any_family_system(spec) is None
    assert "friction along a vector" in reason(spec)[0]


OWN_TIMES = """
sizes: {{N: {count}}}
parameters: {{k: 30, limit: 2.943}}
coordinates: {{"x[i in range(N)]": {{initial: 0.8 + 0.08*i}}, "y[i in range(N)]": {{initial: 0.6 + 0.06*i}}}}
masses: {{"p[i in range(N)]": 1}}
positions: {{"p[i in range(N)]": ["x[i]", "y[i]"]}}
potential: sum(k*(1 + {apart}*i)*(x[i]**2 + y[i]**2)/2 for i in range(N))
dissipation: sum(limit*norm((p[i].vx, p[i].vy)) for i in range(N))
"""


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(("count", "apart"), [(1, 0.0), (6, 0.0), (6, 0.037), (30, 0.037)])
def test_bodies_turn_round_in_few_steps(count: int, apart: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """At the same time, or each at its own, with the closed form of friction on a spring along a line. (They
    took 40 to 150 steps for each time that one turns.)"""
    keep_families(monkeypatch, whole=True)
    text = OWN_TIMES.format(count=count, apart=apart)
    motion = followed(ready(text, frozenset({"q", "v"})), text, 2.0)
    turns = 0
    for i in range(count):
        k, amplitude = 30.0 * (1.0 + apart * i), 1.0 + 0.1 * i
        turns += int(2.0 * np.sqrt(k) / np.pi)
        line = half_cycles(motion.t, amplitude, k, 2.943)
        for name, part in (("q/x", 0.8), ("q/y", 0.6)):
            assert np.max(np.abs(motion[name][:, i] - part * line)) < 2e-13
    assert motion.outcome.steps < 60 + 6 * turns
