"""Sections and sweeps of families that stay families, beside the same systems written out."""

from __future__ import annotations

import numpy as np
import pytest

import lagrange_cli as lagrange
from lagrange_cli.families import system as systems
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.families import family_run
from lagrange_cli.native.members import SECTION, STROBE
from lagrange_cli.run.ensembles import ensemble
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.surface import with_surface
from tests.families.test_events import keep_families

CHAIN = """
sizes: {N: 9}
coordinates: {"x[i in range(N)]": {initial: "sin(3*i)", velocity: "cos(i)"}}
masses: {"bead[i in range(N)]": 1 + i/7}
embedding: {"bead[i in range(N)]": "x[i]"}
potential: sum((x[(i + 1) % N] - x[i])**2/2 + (x[(i + 1) % N] - x[i])**4/9 for i in range(N))
solve: {stop: 20}
"""
HELD = CHAIN.replace("+ (x[(i + 1) % N] - x[i])**4/9", "+ x[i]**2/2 + (x[(i + 1) % N] - x[i])**4/9")


def family_of(where: str, text: str = CHAIN) -> bool:
    """Whether the system with a surface stays a family."""
    asked = Compilation("taylor", 2.0**-52, frozenset("qv"), ensemble=True, few=True, section=SECTION)
    return family_run(with_surface(read_spec(text, "system.yaml"), where), asked) is not None


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("direction", ["rising", "falling"])
@pytest.mark.parametrize("where", ["x[0]", "x[1] - x_dot[4]", "sum(x[i]**3 for i in range(N))"])
def test_sections_are_those_of_the_members(
    where: str, direction: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = []
    for whole in (True, False):
        keep_families(monkeypatch, whole=whole)
        assert family_of(where, HELD) == whole
        found.append(lagrange.section(HELD, where=where, direction=direction, crossings=4, cache=False))
    one, other = found
    assert np.allclose(one.t, other.t, rtol=0.0, atol=1e-11)
    assert np.allclose(one.q["x"], other.q["x"], rtol=0.0, atol=1e-11)


@pytest.mark.exhaustive(keep=0.35)
def test_states_after_periods_are_those_of_the_members(monkeypatch: pytest.MonkeyPatch) -> None:
    found = []
    for whole in (True, False):
        keep_families(monkeypatch, whole=whole)
        found.append(lagrange.section(CHAIN, every=1.5, crossings=4, cache=False))
    one, other = found
    assert np.array_equal(one.t, other.t)
    assert np.allclose(one.q["x"], other.q["x"], rtol=0.0, atol=1e-11)


def test_beads_that_do_not_touch_cross_after_whole_periods(monkeypatch: pytest.MonkeyPatch) -> None:
    """x'' = -(1 + i)^2 x, where the last one is looked at."""
    keep_families(monkeypatch, whole=True)
    text = CHAIN.replace("sin(3*i)", "0").replace("cos(i)", "1").replace("1 + i/7", "1")
    text = text.split("potential")[0] + "potential: sum((1 + i)**2*x[i]**2/2 for i in range(N))\n"
    found = lagrange.section(text, where="x[N - 1]", crossings=5, stop=20, cache=False)
    assert np.allclose(found.t, 2.0 * np.pi / 9.0 * np.arange(1, 6), rtol=0.0, atol=1e-14)


def test_surfaces_that_may_be_conserved_go_through_the_members(monkeypatch: pytest.MonkeyPatch) -> None:
    """The whole momentum is conserved, that of some beads is not."""
    keep_families(monkeypatch, whole=True)
    assert not family_of("sum((1 + i/7)*x_dot[i] for i in range(N))")
    assert family_of("sum((1 + i/7)*x_dot[i] for i in range(N - 1))")


@pytest.mark.exhaustive(keep=0.25)
def test_many_long_motions_are_followed_eight_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """The way is chosen by the number of steps; states at the end are the same."""
    keep_families(monkeypatch, whole=True)
    chosen, found = [], []
    own = ensemble.prepare_run

    def counting(*given, **named):
        chosen.append(named["few"])
        return own(*given, **named)

    monkeypatch.setattr(ensemble, "prepare_run", counting)
    for members, most in ((3, 0), (20, 2**19), (20, 0)):
        monkeypatch.setattr(ensemble, "MOST_STEPS", most)
        systems._LATEST.clear()
        made = lagrange.sweep(CHAIN, random={"x[0]": "normal(0, 0.1)"}, members=members, stop=2, cache=False)
        found.append(made.q["x"][:3])
    assert chosen == [True, True, True, False]
    assert np.allclose(found[0], found[1], rtol=0.0, atol=1e-11)
    assert np.allclose(found[1], found[2], rtol=0.0, atol=1e-11)


def test_strobes_of_large_families_stay_in_loops() -> None:
    asked = Compilation("taylor", 2.0**-52, frozenset("qv"), ensemble=True, few=True, section=STROBE)
    assert family_run(read_spec(CHAIN.replace("N: 9", "N: 200"), "system.yaml"), asked) is not None
