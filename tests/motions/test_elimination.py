"""Motions whose linear constraints are solved for coordinates, against the same with multipliers."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lagrange_cli.api.motion import Motion
from lagrange_cli.api.sweep import sweep
from lagrange_cli.errors import LagrangeWarning
from lagrange_cli.native.elimination import reduced
from tests.support.draws import examples
from tests.support.elimination import CART, DISC, GEARS, MIXED, PUSHED, SHAKEN, SYSTEMS, TRAIN, motion_of
from tests.support.motion import residual_of


def difference(one: Motion, other: Motion) -> float:
    """The largest one of any dataset but the ledgers, which are 0, relative to the size of that."""
    assert set(one.datasets) == set(other.datasets)
    found = 0.0
    for path in one.datasets:
        x, y = np.asarray(one.datasets[path]), np.asarray(other.datasets[path])
        assert x.shape == y.shape
        assert x.dtype.kind != "f" or (np.isfinite(x).all() and np.isfinite(y).all())
        if x.dtype.kind == "f" and x.size and "ledger" not in path:
            found = max(found, float(np.abs(x - y).max() / (1 + np.abs(y).max())))
    return found


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("stop", [4.0, -4.0])
@pytest.mark.parametrize("name", SYSTEMS)
def test_motions_multipliers_and_ledgers_are_the_same(name, stop):
    if name in ("struck", "landing"):  # impacts cannot be undone
        stop = abs(stop)
    asked = {"stop": stop, "samples": 9, "outputs": "all"}
    one, other = (motion_of(SYSTEMS[name], eliminated=yes, **asked) for yes in (True, False))
    assert reduced(residual_of(SYSTEMS[name])) is not None
    assert one.status == other.status == "complete"
    assert difference(one, other) < 1e-13
    for ledger in ("h", *(f"p/{family}" for family in one.p)):
        assert np.abs(one.datasets[f"diagnostics/ledger/{ledger}"]).max() < 3e-12


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("name", SYSTEMS)
def test_the_same_in_double_double(name):
    asked = {"stop": 1.0, "samples": 5, "outputs": "q,v,h,constraints", "precision": "double-double"}
    one, other = (motion_of(SYSTEMS[name], eliminated=yes, **asked) for yes in (True, False))
    for path in one.datasets:
        x, y = one.datasets[path], other.datasets[path]
        if not path.startswith("low") and np.asarray(x).dtype.kind == "f":
            size = np.abs(y).max(initial=0.0)  # an event that has not happened has no numbers
            assert np.abs(np.asarray(x) - y).max(initial=0.0) <= 2e-16 * (1 + size)
    low = [path for path in one.datasets if "low/q" in path]
    assert max(np.abs(np.asarray(one.datasets[p]) - other.datasets[p]).max() for p in low) < 1e-29


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize(
    "name", [name for name in SYSTEMS if name not in ("struck", "landing", "mixed", "train")]
)
def test_members_in_lanes_are_followed_as_alone(name):
    """The sixth of nine members has the numbers of the file."""
    coordinate = {"shaken": "th", "pushed": "th", "disc": "x", "cart": "th", "steep": "x"}.get(name, "a")
    alone = motion_of(SYSTEMS[name], stop=2.0, samples=5, outputs="q,v")
    begin = float(np.asarray(alone.q[coordinate])[0])
    swept = sweep(
        SYSTEMS[name],
        over={coordinate: [begin + 0.01 * (k - 5) for k in range(9)]},
        stop=2.0,
        samples=5,
        outputs="q,v",
        cache=False,
    )
    for group in "qv":
        for key in getattr(alone, group):
            x, y = getattr(swept, group)[key][5], getattr(alone, group)[key]
            assert np.abs(x - np.asarray(y)).max() < 2e-14 * (1 + np.abs(y).max())


@st.composite
def constrained(draw: st.DrawFn) -> str:
    """Oscillators with up to four linear constraints: holonomic ones that may depend on t, then ones on
    velocities; and perhaps a rod."""
    count = draw(st.integers(2, 5))
    names = [f"q{k}" for k in range(count)]
    bound = draw(st.integers(1, count - 1))
    fast = draw(st.integers(0, bound))
    sizes = st.sampled_from(["1", "-1", "2", "a", "-b", "a*b", "a/b", "0.5"])
    drifts = st.sampled_from(["0", "1", "a*t", "sin(w*t)/4", "-b*t**2/20"])

    def row(k: int, suffix: str) -> str:
        """One that coordinate k follows from, since only earlier ones have none of their own in it."""
        own = f"{draw(sizes)}*{names[k]}{suffix}"
        others = [names[i] for i in range(count) if i < k and draw(st.booleans())]
        return " + ".join([own, *(f"({draw(sizes)})*{name}{suffix}" for name in others)])

    lines = ["parameters: {a: 1.3, b: 0.8, w: 2.1}", "coordinates:"]
    first = count - bound
    for k, name in enumerate(names):
        free = k < first
        fixed = free or k >= count - fast
        given = [f"initial: {0.1 + 0.2 * k}"] * fixed + [f"velocity: {0.3 - 0.2 * k}"] * free
        lines.append(f"  {name}: {{{', '.join(given)}}}")
    masses = " + ".join(f"{1 + k % 3}*{name}_dot**2/2" for k, name in enumerate(names))
    coupling = draw(st.sampled_from(["q0_dot*q1_dot*cos(q0 - q1)/3", "q1**2*q0_dot**2/5", "0"]))
    forces = " + ".join(f"{draw(st.sampled_from(['cos', 'sin']))}({name})" for name in names)
    last = draw(st.sampled_from(["q0*q1", "q0**2*q1", "0"]))
    lines.append(f"lagrangian: {masses} + {coupling} + {forces} - ({last})")
    places = [f"  f{k}: {row(k, '')} + {draw(drifts)}" for k in range(first, count - fast)]
    speeds = [
        f"  g{k}: {row(k, '_dot')} + {draw(st.sampled_from(['0', 'b/9']))}"
        for k in range(count - fast, count)
    ]
    lines += ["constraints:", *places] * bool(places) + ["nonholonomic:", *speeds] * bool(speeds)
    lines.append(f"generalized_forces: {{{names[-1]}: a*sin(t) - b*{names[-1]}_dot*q0**2}}")
    return "\n".join(lines)


@pytest.mark.exhaustive(keep=0.2)
@given(constrained())
@examples(2)
def test_any_linear_constraints(text):
    asked = {"stop": 1.0, "samples": 5, "outputs": "all"}
    one, other = (motion_of(text, eliminated=yes, **asked) for yes in (True, False))
    assert difference(one, other) < 1e-11


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize(("text", "stop"), [(GEARS, 20_000.0), (TRAIN, 20_000.0), (MIXED, 500.0)])
def test_constraints_hold_to_rounding_for_ever(text, stop):
    motion = motion_of(text, stop=stop, samples=101, outputs="h,constraints")
    assert motion.attributes["steps"] > 9_000
    assert max(np.abs(motion.constraints[name]).max() for name in motion.constraints) <= 2e-15
    assert np.abs(motion.h - motion.h[0]).max() < 3e-13


def test_what_a_rolling_constraint_keeps_does_not_drift():
    motion = motion_of(DISC, stop=2000.0, samples=101, outputs="q")
    slip = np.asarray(motion.q["x"]) - 0.4 * np.asarray(motion.q["phi"])
    assert np.abs(slip - slip[0]).max() < 2e-14


@pytest.mark.exhaustive(keep=0.35)
def test_a_driven_coordinate_is_where_it_is_driven():
    motion = motion_of(SHAKEN, stop=20.0, samples=201, outputs="q,v,ledger")
    assert np.abs(motion.q["x"] - 0.3 * np.cos(3 * motion.t)).max() < 3e-15
    assert np.abs(motion.v["x"] + 0.9 * np.sin(3 * motion.t)).max() < 1e-14


@pytest.mark.exhaustive(keep=0.6)
def test_a_drive_that_sets_in_ends_a_step():
    """The coordinate is not among the unknowns, but has a kink where a step is to end."""
    motion = motion_of(PUSHED, stop=2.0, samples=5, outputs="q,v")
    moved = np.maximum(0, motion.t - 0.7)
    assert np.abs(np.asarray(motion.q["x"]) - moved**2).max() < 1e-15
    assert np.abs(np.asarray(motion.v["x"]) - 2 * moved).max() < 1e-15
    assert motion.attributes["steps"] < 20


@pytest.mark.exhaustive(keep=0.7)
def test_a_hidden_force_is_seen_through_a_constraint():
    """A narrow potential of a coordinate that follows from the one that moves."""
    alone = motion_of(
        "coordinates: {x: {initial: -2, velocity: 1}}\n"
        "lagrangian: 3*x_dot**2/4 - 0.3*exp(-(20*(-x/2 - 1))**2) - x**2/9",
        stop=20.0,
        samples=41,
        outputs="q",
    )
    motion = motion_of(SYSTEMS["steep"], stop=20.0, samples=41, outputs="q")
    assert np.abs(np.asarray(motion.q["x"]) - alone.q["x"]).max() < 1e-12


@pytest.mark.exhaustive(keep=0.75)
def test_of_constraints_that_say_the_same_multipliers_have_the_least_norm():
    text = GEARS.replace("R1*a + R2*b}", "R1*a + R2*b, again: 2*R1*a + 2*R2*b}")
    asked = {"stop": 2.0, "samples": 5, "outputs": "q,multipliers"}
    with pytest.warns(LagrangeWarning, match="not unique"):
        one, other = (motion_of(text, eliminated=yes, **asked) for yes in (True, False))
    assert difference(one, other) < 1e-14
    assert np.abs(one.multipliers["again"] - 2 * np.asarray(one.multipliers["mesh"])).max() < 1e-14


@pytest.mark.exhaustive(keep=0.25)
def test_a_certificate_covers_coordinates_that_follow():
    asked = {"stop": 10.0, "samples": 21, "outputs": "q,v,multipliers"}
    found = motion_of(CART, certify=True, **asked)
    true = motion_of(CART, precision="double-double", **asked)
    for path in ("q/x", "q/phi", "v/x", "multipliers/roll"):
        off = np.abs(np.asarray(found.datasets[path]) - true.datasets[path])
        assert (off <= 3 * found.error[path] + 1e-15).all()


@pytest.mark.exhaustive(keep=0.8)
def test_a_coefficient_that_is_0_is_not_divided_by():
    """With R2 = 0 the first wheel is held, and the other one is free."""
    text = GEARS.replace("b: {}", "b: {initial: 0.3, velocity: 0.5}")
    swept = sweep(text, over={"R2": [0.0, 0.8]}, set={"a": 0, "b": 0, "b_dot": 0.5, "a_dot": 0}, stop=2.0,
                  project_initial=True, cache=False)  # fmt: skip
    assert list(swept.statuses) == ["complete"] * 2
    assert swept.q["a"][0] == 0.0 and abs(swept.q["b"][0] - 1.0) < 1e-15
