"""Long chains and large lattices: forces on neighbours, coefficients of many orders, and waves' tails."""

from __future__ import annotations

import numpy as np
import pytest

from lagrange_cli.families import system as systems
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.family_program import compiled_accelerations
from lagrange_cli.integrate.methods import stepper
from lagrange_cli.integrate.prepare import prepare_system
from lagrange_cli.integrate.prepared import Prepared
from lagrange_cli.native.families import jets
from lagrange_cli.native.families.joints import articulated
from lagrange_cli.run.derive import derive_system
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_values
from tests.support.motion import Motion, run

SPRINGS = """
sizes: {{N: {count}}}
coordinates: {{"u[i in range(N)]": {{initial: "sin(i*i)", velocity: "cos(i)"}}}}
masses: {{"bead[i in range(N)]": 1 + i/7}}
embedding: {{"bead[i in range(N)]": "u[i]"}}
potential: {potential}
"""
PENDULUM = """
sizes: {N: 11}
coordinates: {"th[i in range(N)]": {initial: "0.2*sin(i*i)"}}
definitions: {"x[i in range(N)]": "sum(sin(th[j]) for j in range(i + 1))"}
masses: {"bob[i in range(N)]": 1}
embedding: {"bob[i in range(N)]": ["x[i]", "-sum(cos(th[j]) for j in range(i + 1))"]}
potential: sum(bob[i].y for i in range(N))
"""
SINE_GORDON = """
sizes: {{N: {count}, M: {count}}}
coordinates:
  u[i in range(N), j in range(M)]: {{initial: "2*exp(-((i - N//2)**2 + (j - M//2)**2)/2)"}}
lagrangian: >-
  sum(u_dot[i, j]**2/2 + cos(u[i, j]) - (u[(i + 1) % N, j] - u[i, j])**2
      - (u[i, (j + 1) % M] - u[i, j])**2 for i in range(N) for j in range(M))
"""


pytestmark = pytest.mark.usefixtures("however_small")


def ready(text: str, method: str = "taylor") -> Prepared:
    """A system that has been compiled."""
    asked = Compilation(method, 2.0**-52, frozenset(["q", "v", "h"]))
    return prepare_system(read_spec(text, "system.yaml"), derive_system, None, asked)


def moved(text: str, stop: float, prepared: Prepared) -> Motion:
    """A motion from the initial state of the text."""
    return run(prepared, resolve_values(read_spec(text, "system.yaml"), {}), 0.0, stop, 2)


@pytest.mark.exhaustive(keep=4)
@pytest.mark.parametrize("count", [1, 2, 7, 8, 9, 16, 17, 40])
@pytest.mark.parametrize("apart", [1, 2, 7, 8, 9])
@pytest.mark.parametrize("ring", [True, False])
def test_a_force_on_two_neighbours(count: int, apart: int, ring: bool) -> None:
    """Springs between members that are ``apart``, along a line and around a ring, beside numpy."""
    if count <= apart:
        return
    other, last = (f"(i + {apart}) % N", "N") if ring else (f"i + {apart}", f"N - {apart}")
    potential = f'"sum((u[{other}] - u[i])**2/2 + u[i]**4 for i in range({last}))"'
    system = systems.family_system(read_spec(SPRINGS.format(count=count, potential=potential), "s.yaml"))
    assert system is not None
    i = np.arange(count if ring else count - apart)
    q, j = np.sin(np.arange(count) ** 2), (i + apart) % count
    force = np.zeros(count)
    np.add.at(force, i, q[j] - q[i] - 4 * q[i] ** 3)
    np.add.at(force, j, q[i] - q[j])
    found = compiled_accelerations(system)(0.0, q, np.zeros(count), np.zeros(0))
    assert np.allclose(found, force / (1 + np.arange(count) / 7), rtol=0, atol=1e-14)


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize("power", ["(u[i] - u[i - 1])**3", "sin(u[i])*u[i - 1]", ""])
def test_dot_products_begun_for_several_orders(power: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where coefficients are many, the same sums are added in another order; those of a pendulum, too."""
    potential = f'"sum((u[i] - u[i - 1])**2 + {power}/9 for i in range(1, N))"'
    text = SPRINGS.format(count=11, potential=potential) if power else PENDULUM
    usual = ready(text)
    for kind in (jets.SeriesJet, articulated.ArticulatedJet):
        monkeypatch.setattr(kind, "many", 0)
    other = ready(text)
    lengths = [len(one.machine.program.text) for one in (usual, other)]
    assert lengths[1] > 1.3 * lengths[0]
    plain, begun = (moved(text, 2.0, one) for one in (usual, other))
    assert plain.outcome.steps == begun.outcome.steps
    for path, values in plain.data.items():
        assert np.max(np.abs(begun[path] - values)) < 1e-14 * max(1.0, np.max(np.abs(values))), path


@pytest.mark.exhaustive(keep=0.55)
@pytest.mark.parametrize("method", ["taylor", "ias15"])
def test_steps_do_not_follow_the_tail_of_a_wave(method: str) -> None:
    """Velocities in the corners are 1e-20 of those in the middle, and smaller ones in a larger lattice."""
    texts = [SINE_GORDON.format(count=count) for count in (9, 31)]
    few, many = (moved(text, 3.0, ready(text, method)) for text in texts)
    assert many.outcome.steps <= 1.3 * few.outcome.steps
    energies = many["diagnostics/h"]
    assert abs(energies[1] / energies[0] - 1) < 1e-15


def test_a_heavy_member_is_followed_to_its_own_digits() -> None:
    """It moves 1e12 times as slowly as a light one, with the same momentum."""
    text = """
sizes: {N: 2}
coordinates: {"x[i in range(N)]": {initial: "i"}}
masses: {"body[i in range(N)]": "where(i == 0, 1e12, 1)"}
embedding: {"body[i in range(N)]": "x[i]"}
potential: sum((x[1] - x[0] - 1.2)**4 + (x[1] - x[0] - 1.2)**2/2 for i in range(1))
"""
    heavy, light = moved(text, 5.0, ready(text))["v/x"][-1]
    assert abs(light) > 0.01
    assert abs(1e12 * heavy + light) < 1e-13 * abs(light)


@pytest.mark.exhaustive(keep=1.5)
@pytest.mark.parametrize("count", [1, 7, 8, 9, 17])
def test_samples_are_what_they_are_alone(count: int) -> None:
    """However many others there are, for any number of members: to the bit; and the last one is the state
    that a run to this time ends with."""
    text = SPRINGS.format(count=count, potential='"sum(u[i]**4 - cos(u[i]) for i in range(N))"')
    prepared, values = ready(text), resolve_values(read_spec(text, "system.yaml"), {})
    many, few = (run(prepared, values, 0.0, 1.0, samples) for samples in (33, 5))
    assert many.outcome.steps == few.outcome.steps
    for path, found in few.data.items():
        assert np.array_equal(many[path][::8], found), path
    sooner = run(prepared, values, 0.0, 0.75, 2)
    for path, found in few.data.items():
        assert np.allclose(sooner[path][-1], found[3], rtol=0, atol=1e-14), path


def test_looks_at_the_world_outside_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Between any two steps, where the series of the next one are left for later."""
    text = SPRINGS.format(count=17, potential='"sum(u[i]**4 - cos(u[i]) for i in range(N))"')
    prepared, values = ready(text), resolve_values(read_spec(text, "system.yaml"), {})
    seldom = run(prepared, values, 0.0, 3.0, 5)
    monkeypatch.setattr(stepper, "FIRST", 1)
    monkeypatch.setattr(stepper, "POLL_SECONDS", 0.0)
    often = run(prepared, values, 0.0, 3.0, 5)
    assert often.outcome.steps == seldom.outcome.steps > 8
    for path, found in seldom.data.items():
        assert np.array_equal(often[path], found), path


@pytest.mark.parametrize("width", [1e-3, 1e-5])
def test_a_last_step_into_a_narrow_force_is_taken_again(width: float) -> None:
    """Beads fly freely, and at the end the first of them is on the slope of a hill that no series showed."""
    potential = f'"sum(exp(-(u[i]/{width!r})**2)/3 for i in range(N))"'
    text = SPRINGS.format(count=9, potential=potential)
    text = text.replace('"sin(i*i)"', '"-1/2 - i/9"').replace('"cos(i)"', "1").replace("1 + i/7", "1")
    prepared, values = ready(text), resolve_values(read_spec(text, "system.yaml"), {})
    motion = run(prepared, values, 0.0, 0.5 - 0.3 * width, 2)
    place, speed = (motion[f"{which}/u[0]"][-1] for which in ("q", "v"))
    hill = np.exp(-((place / width) ** 2)) / 3
    assert hill > 0.01
    assert abs(speed**2 / 2 + hill - 0.5) < 1e-11


def test_coefficients_that_are_not_needed_again_are_not_kept() -> None:
    """A pendulum's series are its velocity's and three more: the slope's, the sine's and the cosine's."""
    potential = '"-sum(cos(u[i]) for i in range(N))"'
    few, more = (
        ready(SPRINGS.format(count=count, potential=potential)).machine.program for count in (80, 160)
    )
    others = 24
    assert more.work - few.work <= 80 * (4 * (few.order + 1) + others)


def test_constants_of_quantities_that_no_output_has_are_not_computed() -> None:
    plain = ready(SPRINGS.format(count=40, potential="sum(u[i]**2 for i in range(N))"))
    modes = '\nobservables: {"a[j in range(9)]": "sum(u[i]*sin(i*j) for i in range(N))"}\n'
    observed = ready(SPRINGS.format(count=40, potential="sum(u[i]**2 for i in range(N))") + modes)
    assert observed.machine.program.constants == plain.machine.program.constants
