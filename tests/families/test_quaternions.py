"""Families of bodies turned by quaternions: beside the same systems written out, and closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from lagrange_cli.families import consistency
from lagrange_cli.families import system as systems
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.families import OUTPUTS
from lagrange_cli.integrate.family_program import compiled_accelerations, write_families
from lagrange_cli.native.families.coupling import of_families
from lagrange_cli.run.start import consistent_values
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_values
from tests.families.test_closed_chains import exactly_followed
from tests.support import families
from tests.support.motion import Motion

BODIES = """
sizes: {{N: {count}}}
parameters: {{I1: 0.3, I2: {middle}, I3: 0.2, d: 1.5}}
coordinates:
  a[i in range(N)]: {{initial: 1, velocity: 0}}
  b[i in range(N)]: {{initial: 0, velocity: 0.1 + 0.1*cos(i)}}
  c[i in range(N)]: {{initial: 0, velocity: 0.2*sin(i)}}
  e[i in range(N)]: {{initial: 0, velocity: 1 + 0.01*i}}
  x[i in range(N)]: {{initial: d*i}}
  y[i in range(N)]: {{initial: 0}}
  z[i in range(N)]: {{initial: 0}}
bodies:
  body[i in range(N)]:
    mass: 1
    inertia: [I1, I2, I3]
    position: [x[i], y[i], z[i]]
    orientation: {{quaternion: ["a[i]", "b[i]", "c[i]", "e[i]"]}}
potential: {potential}
{more}
solve: {{stop: 1, step: 0.25}}
"""
PARTS = frozenset(["angular_momenta", "orientations", "multipliers", "constraints", "conserved"])
ROD = "norm(body[i].at(0, 0.1, 0) - body[i - 1].at(0, 0.1, 0))"


def bodies(count: int, potential: str = "0", more: str = "", middle: str = "0.3") -> str:
    """The text of a system."""
    return BODIES.format(count=count, potential=potential, more=more, middle=middle)


def followed(text: str, *, loops: bool = True) -> Motion:
    """A motion of a system, in ``loops``."""
    ready, motion = families.followed(text, OUTPUTS | PARTS, 1.0, 5)
    assert ready.machine.program.loops == loops
    return motion


@pytest.mark.exhaustive(keep=0.2)
def test_axes_of_free_tops_turn_about_their_angular_momenta() -> None:
    """A symmetric body whose axis turns about L at the rate |L|/I1 (L. D. Landau, E. M. Lifshitz, Mechanics,
    3rd ed., sec. 33)."""
    data = followed(bodies(20)).data
    momenta, axes = data["angular_momenta/body"], data["orientations/body"][..., 2]
    assert np.max(np.abs(momenta - momenta[0])) < 1e-14
    assert np.max(np.abs(data["diagnostics/h"] - data["diagnostics/h"][0])) < 1e-12
    size = np.linalg.norm(momenta[0], axis=-1, keepdims=True)
    about, start = momenta[0] / size, axes[0]
    along = np.sum(about * start, axis=-1, keepdims=True) * about
    for t, axis in zip((0.0, 0.25, 0.5, 0.75, 1.0), axes):
        angle = size * t / 0.3
        turned = along + np.cos(angle) * (start - along) + np.sin(angle) * np.cross(about, start)
        assert np.max(np.abs(axis - turned)) < 1e-13


ROWS = ROD.replace("body[i]", "body[i + 1]").replace("body[i - 1]", "body[i]")
TIED = f'constraints: {{"rod[i in range(N - 1)]": {ROWS} - d}}'
CASES = {
    "springs between points": bodies(2, f"sum(3*({ROD} - 1)**2 for i in range(1, N))"),
    "tied in a row": bodies(3, "sum(body[i].y for i in range(N))", TIED),
}


@pytest.mark.exhaustive(keep=0.25)
def test_free_bodies_move_as_their_members_do_in_double_double(monkeypatch: pytest.MonkeyPatch) -> None:
    text, outputs = bodies(3, middle="0.25"), frozenset(["q", "v", "h", "multipliers", "constraints"])
    for name, count in (("FEWEST_TURNING", 0), ("FEWEST_JOINTED", 0)):
        monkeypatch.setattr(systems, name, count)
    monkeypatch.setattr(consistency, "FEWEST", 0)
    together, motion = exactly_followed(text, outputs)
    written_out(monkeypatch)
    apart, expected = exactly_followed(text, outputs)
    assert together.machine.program.loops and not apart.machine.program.loops
    families.alike(motion.data, expected.data, 2.0**-94)


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("case", CASES)
def test_coupled_bodies_move_as_their_members_do(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, count in (("FEWEST_TURNING", 0), ("FEWEST_JOINTED", 0)):
        monkeypatch.setattr(systems, name, count)
    found = followed(CASES[case]).data
    written_out(monkeypatch)
    expected = followed(CASES[case], loops=False).data
    for path, values in expected.items():
        if path in found:
            size = np.max(np.abs(values), initial=1.0)
            assert np.max(np.abs(found[path] - values)) <= 2.0**-40 * size, path


def written_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have systems written out member by member."""
    for name in ("FEWEST_TURNING", "FEWEST_JOINTED"):
        monkeypatch.setattr(systems, name, 10**9)
    monkeypatch.setattr(consistency, "FEWEST", 10**9)


def test_norms_are_found_at_once_and_constraints_between_neighbours_in_few_colors() -> None:
    for text, colors in ((bodies(40), 1), (bodies(40, more=TIED), 9)):
        system = systems.family_system(read_spec(text, "system.yaml"))
        assert system is not None and system.bonds is not None and system.bonds.responses is not None
        assert system.bonds.responses.colors.max() < colors


@pytest.mark.exhaustive(keep=0.55)
@pytest.mark.parametrize(
    ("text", "reach"),
    [
        (bodies(12), 6),
        (bodies(12, f"sum(3*({ROD} - 1)**2 for i in range(1, N))"), 20),
        (bodies(6, more=TIED), 41),
    ],
    ids=["free", "springs", "tied"],
)
def test_implicit_steps_know_which_accelerations_depend_on_what(text: str, reach: int) -> None:
    """By changing coordinates and velocities one by one."""
    spec = read_spec(text, "system.yaml")
    system = systems.any_family_system(spec)
    assert system is not None
    values, count = resolve_values(spec, {}), system.q.count
    state, given = np.array([*values.q, *values.v]), np.array([*values.parameters.values()])
    accelerations = compiled_accelerations(system)
    here = accelerations(0.0, *np.split(state, 2), given)
    band, places = of_families(system).band, of_families(system).places or range(count)
    at = np.argsort(np.array(places))
    for k in range(2 * count):
        moved = state + 1e-3 * (np.arange(2 * count) == k)
        changed = np.flatnonzero(np.abs(accelerations(0.0, *np.split(moved, 2), given) - here) > 1e-9)
        assert np.all(np.abs(at[changed] - at[k % count]) <= band.reach)
    assert band.reach <= reach


@pytest.mark.exhaustive(keep=0.3)
def test_the_code_does_not_grow_with_the_bodies() -> None:
    def size(count: int) -> tuple[int, int]:
        system = systems.family_system(read_spec(bodies(count), "system.yaml"))
        assert system is not None
        program, _ = write_families(system, Compilation("taylor", 2.0**-52, frozenset("qp")))
        return len(system.slots.graph.nodes), len(program.text.splitlines())

    assert size(40) == size(24)


@pytest.mark.exhaustive(keep=0.6)
def test_quaternions_of_any_length_are_made_unit_quaternions_at_once() -> None:
    text = bodies(300).replace("initial: 1, velocity: 0", "initial: 2 + i, velocity: 0.3")
    spec = read_spec(text, "system.yaml")
    _, values, begun = consistent_values(spec, resolve_values(spec, {}), 0.0, ())
    assert len(begun.normalized) == 300
    q, v = (np.reshape(one[: 4 * 300], (4, 300)) for one in (values.q, values.v))
    assert np.max(np.abs(np.sum(q * q, axis=0) - 1)) < 1e-15
    assert np.max(np.abs(np.sum(q * v, axis=0))) < 1e-15
