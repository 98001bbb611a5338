"""What contradicts itself in the units of a file."""

from __future__ import annotations

from collections import Counter

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lagrange_cli.errors import SpecError
from lagrange_cli.expression.algebra import Value
from lagrange_cli.expression.syntax import Tree
from lagrange_cli.model.dimensions import Walk
from lagrange_cli.outputs.units import find_units
from lagrange_cli.spec.read import read_spec
from tests.fuzzing.grammar import system
from tests.support.motion import SYSTEMS
from tests.support.units import ENERGY, LINEAR, conflicts, one


def test_times_of_solve_agree_with_t():
    text = "parameters: {k: {value: 1, unit: 1/s}, l: {value: 2, unit: m}}\ncoordinates: {x: {initial: 0}}\n"
    text += "lagrangian: x_dot**2/2 - k**2*x**2/2\nsolve: {start: 1, stop: %s, step: 0.1/k}\n"
    assert conflicts(text % "10*pi/k") == []
    assert conflicts(text % "l/2") == ["the stop of solve is in m, and t is in s"]
    assert conflicts(text % "1/k + l") == ["s and m are added in stop of solve"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (one("k*x**2/2 + k*x"), "N*m and N are added in potential"),
        (one("k*x", k="{value: 1, unit: N/m}"), f"the potential is in N, other energies in {ENERGY}"),
        (one("{a: k*x**2, b: k*x}"), f"the potential 'b' is in N, other energies in {ENERGY}"),
        (one(position="[x, x**2]"), "the position of 'bead' has components in m and m^2"),
        (one(position="[sin(x)]"), "sin is taken of a quantity in m in the position of 'bead'"),
        (one("k*x**(x)"), "an exponent is in m in potential"),
        (one(more="definitions: {d: x + x_dot}"), "m and m/s are added in definition 'd'"),
        (one(more="observables: {o: 'where(x > x_dot, 1, 2)'}"), "m and m/s are compared in observable 'o'"),
        (one(more="observables: {o: 'max(0, x, k)'}"), "m and N/m are compared in observable 'o'"),
        (
            one(more="observables: {o: 'where(0 < x and x > 5, x, x_dot)'}"),
            "m and m/s are branches of one 'where' in observable 'o'",
        ),
        (
            one(more="observables: {o: 'sign(x) + abs(x)'}"),
            "a plain number and m are added in observable 'o'",
        ),
        (one(more="observables: {o: x + cos(x/x)}"), "m and a plain number are added in observable 'o'"),
        (one(more="forces: {bead: [-k*x_dot]}"), "the force on 'bead' is in N/s, and should be in"),
        (one(more="generalized_forces: {x: -m}"), "the generalized force 'x' is in kg, and should be in"),
        (one(more="dissipation: k*x_dot**2"), "the dissipation is in"),
        (one(k="{value: m*2, unit: N/m}"), "the value of parameter 'k' is in kg, and its unit is N/m"),
        (one(x="{initial: m, unit: m}"), "the initial value of coordinate 'x' is in kg, and its unit is m"),
        (one(x="{initial: 1, velocity: m, unit: m}"), "the initial velocity of coordinate 'x' is in kg"),
        (one(more="events: {e: x + x_dot}"), "m and m/s are added in event 'e'"),
        (
            one(more="events: {e: {when: x_dot, action: {set: {x: -x, x_dot: x}}}}"),
            "the new x_dot of event 'e' is in m, and should be in m/s",
        ),
        (
            one(more="events: {e: {when: x_dot, action: {set: {k: m, m: 2*m}}}}"),
            "the new k of event 'e' is in kg, and should be in N/m",
        ),
        (one("m*k", k="{value: 1, unit: m*cm/s^2}"), "the potential is in kg*m*cm/s^2, other energies in"),
        (one(more="time: d"), "the potential is in N*m, other energies in kg*m^2/d^2"),
    ],
)
def test_contradictions_are_told(text, message):
    (found,) = conflicts(text)
    assert message in found
    texts = find_units(read_spec(text, "a.yaml")).texts
    if "potential" in message or "position" in message:
        assert not texts.keys() & {"diagnostics/h", "diagnostics/p/x", "diagnostics/U"}


def test_what_contradicts_has_no_unit_and_all_else_has():
    found = find_units(read_spec(one(more="observables: {o: x + x_dot, p: m*(x + x_dot), r: x}"), "a.yaml"))
    assert len(found.conflicts) == 2
    assert found.texts["observables/r"] == "m" and found.texts["diagnostics/h"] == ENERGY
    assert not found.texts.keys() & {"observables/o", "observables/p"}


@pytest.mark.parametrize(
    "force",
    [
        "forces: {bead: [-k*x_dot]}",
        "generalized_forces: {x: -m}",
        "dissipation: k*x_dot**2",
        "forces: {bead: [x + m]}",
    ],
)
def test_forces_that_contradict_leave_the_ledgers_without_units(force):
    found = find_units(read_spec(one(more=force), "a.yaml")).texts
    assert found["diagnostics/h"] == ENERGY and found["diagnostics/p/x"] == LINEAR
    assert not found.keys() & {"diagnostics/ledger/h", "diagnostics/ledger/p/x"}


def test_a_unit_that_is_not_known_may_be_another_name():
    found = find_units(read_spec(one(k="{value: 1, unit: Foo/m^2}", more="time: s"), "a.yaml"))
    (conflict,) = found.conflicts
    assert conflict.message == f"the potential is in Foo, other energies in {ENERGY}"
    assert conflict.hint == "unknown unit 'Foo': write it in terms of others"


@pytest.mark.exhaustive(keep=0.75)
@settings(max_examples=30, deadline=None)
@given(
    st.randoms(use_true_random=False), st.lists(st.sampled_from(["m", "s", "N/mm", "deg", "?", "rad", "1"]))
)
def test_any_file_has_units_or_none(source, some):
    text = system(source)
    for unit in some:
        text = text.replace("{initial:", f"{{unit: '{unit}', initial :", 1)
    try:
        spec = read_spec(f"{text}\ntime: s\n", "a.yaml")
    except SpecError:
        return
    find_units(spec)


def test_a_contradiction_of_a_family_is_told_once():
    text = "sizes: {N: 30}\nparameters: {m: {value: 1, unit: kg}}\ntime: s\n"
    text += "coordinates: {'u[i in range(N)]': {initial: 1, unit: m}}\nmasses: {'b[i in range(N)]': m}\n"
    text += "embedding: {'b[i in range(N)]': 'u[i] + u_dot[i]*t'}\n"
    text += "observables: {'o[i in range(N)]': 'u[i] + u_dot[i]'}\n"
    text = text.replace(" + u_dot[i]*t", "")
    assert conflicts(text) == ["m and m/s are added in observable 'o'"]


def test_families_are_gone_through_once(monkeypatch):
    """However many members: the work is counted in trees."""
    plain, counts = Walk.value, Counter[int]()

    def counted(self: Walk, tree: Tree) -> Value:
        counts[size] += 1
        return plain(self, tree)

    monkeypatch.setattr(Walk, "value", counted)
    for size in (5, 300):
        find_units(read_spec((SYSTEMS / "n_pendulum.yaml").read_bytes(), "a.yaml", {"N": str(size)}))
    assert counts[5] == counts[300] < 100
