"""An impact takes work in proportion to what it changes: who carries it out, and how much it takes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from lagrange_cli.families.events import Events
from lagrange_cli.families.impacts import actions
from lagrange_cli.integrate.impacts.happenings import Happenings
from lagrange_cli.integrate.impacts.impulses import Impulses
from lagrange_cli.integrate.samples import Samples
from lagrange_cli.integrate.workspace import Accelerated
from tests.families import test_contacts as contacts
from tests.families import test_gases as gases
from tests.families.test_actions import BOBS
from tests.families.test_coupled_contacts import FLOOR
from tests.families.test_events import keep_families
from tests.families.test_switches import followed, ready


def counted(owner: object, name: str, patch: pytest.MonkeyPatch) -> list[object]:
    """The calls of a function, one entry each, from now on."""
    calls, function = list[object](), getattr(owner, name)

    def counting(*given: object, **more: object) -> object:
        calls.append(None)
        return function(*given, **more)

    patch.setattr(owner, name, counting)
    return calls


def inelastic(count: int, e: float, **given: float) -> str:
    """A gas whose impacts with walls and of discs reduce the speed."""
    text = gases.GAS.format(
        count=count, across=6, cell=0.5, radius=0.15, loose=0.08, a=7.3, b=3.1, slow=1.0, length=3.0,
        **{"gravity": 0.0, **given},
    )  # fmt: skip
    text = text.replace("    2*((x_dot", f"    (1 + {e})*((x_dot")
    return text.replace('"-x_dot[i]"', f'"-{e}*x_dot[i]"').replace('"-y_dot[i]"', f'"-{e}*y_dot[i]"')


def by_caller(patch: pytest.MonkeyPatch) -> None:
    """Leave all impacts to the callers of compiled code."""
    simple_in = actions.simple_in

    def none_of(events: Events, read: actions.Reading) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
        simple, pairs = simple_in(events, read)
        return np.zeros_like(simple), pairs

    patch.setattr(actions, "simple_in", none_of)
    keep_families(patch, whole=True)


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize("gravity", [0.0, 3.0])
def test_compiled_code_does_impacts_of_discs_that_touch_nothing_else(
    gravity: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Motions and times are those of impacts done one by one, to the last bit, while bodies fly."""
    keep_families(monkeypatch, whole=True)
    text = inelastic(12, 0.9, gravity=gravity)
    happened = counted(Happenings, "happen", monkeypatch)
    found = followed(ready(text), text, 1.0)
    count = sum(len(found[f"events/{name}/t"]) for name in ("hit", "left", "right", "bottom"))
    assert count > 20 and len(happened) < count / 10
    with monkeypatch.context() as patch:
        by_caller(patch)
        expected = followed(ready(text), text, 1.0)
    assert len(happened) >= count
    for path in expected.data:
        assert np.array_equal(found[path], expected[path]), path


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize("e", [0.3, 0.6])
@pytest.mark.parametrize("count", [6, 9])
def test_discs_fall_on_each_other_as_impacts_one_by_one(
    count: int, e: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where some rest on others, and on the floor, all the same."""
    keep_families(monkeypatch, whole=True)
    text = inelastic(count, e, gravity=9.8)
    found = followed(ready(text), text, 0.4)
    by_caller(monkeypatch)
    expected = followed(ready(text), text, 0.4)
    for path in ("q/x", "q/y", "v/x", "v/y"):
        assert np.max(np.abs(found[path] - expected[path])) <= 2.0**-40, path


@pytest.mark.exhaustive(keep=0.25)
def test_balls_that_touch_one_another_are_hit_together(monkeypatch: pytest.MonkeyPatch) -> None:
    """A disc hits two others at one time, which touch: the caller follows these impacts."""
    text = inelastic(3, 0.5).replace(
        "0.5*(i % 6 + 0.5) + 0.08*sin(7.3*i)", "1 + where(i > 0, 0.3*cos(pi/6), 0)"
    )
    text = text.replace("0.5*(i // 6 + 0.5) + 0.08*cos(7.3*i)", "1 + where(i > 0, (i - 1.5)*0.3, 0)")
    text = text.replace("cos(3.1*i*i + 1)", "where(i > 0, 0, 1)").replace("1.0*sin(3.1*i + 2)", "0")
    text = text.replace("1 + where(i > 0, 0.3*cos(pi/6)", "0.8 + where(i > 0, 0.2 + 0.3*cos(pi/6)")
    text = text.replace("1 + 0.5*cos(7.3*i)", "1")
    keep_families(monkeypatch, whole=True)
    happened = counted(Happenings, "happen", monkeypatch)
    found = followed(ready(text), text, 0.3)
    assert happened and np.ptp(found["events/hit/t"][:2]) <= 2.0**-45
    assert abs(found["v/x"][-1].sum() - 1.0) <= 2.0**-40 and abs(found["v/y"][-1].sum()) <= 2.0**-40
    by_caller(monkeypatch)
    expected = followed(ready(text), text, 0.3)
    assert len(expected["events/hit/t"]) == len(found["events/hit/t"])
    for path in ("q/x", "q/y", "v/x", "v/y"):
        assert np.max(np.abs(found[path] - expected[path])) <= 2.0**-45, path


@pytest.mark.exhaustive(keep=0.25)
def test_pairs_that_do_not_touch_take_no_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    """The arrays that are cleared for each state do not contain a matrix of all contacts."""
    keep_families(monkeypatch, whole=True)
    program = ready(inelastic(24, 0.9)).machine.program
    assert program.work < len(program.events) ** 2 == 372**2


def per_impact(text: str, stop: float, owner: object, name: str, patch: pytest.MonkeyPatch) -> float:
    """How often a function is called for each impact that the caller carries out."""
    acted, calls = counted(Happenings, "_act", patch), counted(owner, name, patch)
    followed(ready(text), text, stop)
    assert len(acted) > 5
    return len(calls) / len(acted)


def series(patch: pytest.MonkeyPatch) -> tuple[object, str]:
    """What computes the series of a state."""
    return Accelerated, "rates"


def stops(patch: pytest.MonkeyPatch) -> tuple[object, str]:
    """What moves a state to the constraints."""
    return Impulses, "close"


@pytest.mark.exhaustive(keep=0.6)
@pytest.mark.parametrize(("what", "most"), [(series, 3.0), (stops, 1.1)])
@pytest.mark.parametrize("count", [6, 12])
def test_an_impact_of_a_rope_looks_at_few_states(
    what: Callable[[pytest.MonkeyPatch], tuple[object, str]],
    most: float,
    count: int,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The one before and the one after, as long as bobs do not rest, however many there are, where the caller
    carries it out."""
    by_caller(monkeypatch)
    text = (BOBS + FLOOR).format(count=count, e=0.8)
    assert per_impact(text, 0.7, *what(monkeypatch), monkeypatch) <= most


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(("e", "stop", "share"), [(0.8, 0.7, 0.0), (0.4, 1.0, 0.6), (0.0, 0.7, 0.7)])
def test_compiled_code_does_impacts_of_ropes(
    e: float, stop: float, share: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With the impulses of rods: all of them until bobs rest, and then many of those at one time (how many
    depends on rounding). Motions are
    those of impacts done one by one."""
    keep_families(monkeypatch, whole=True)
    text = (BOBS + FLOOR).format(count=12, e=e)
    acted = counted(Happenings, "_act", monkeypatch)
    found = followed(ready(text), text, stop)
    count, left = len(found["events/hit/t"]), len(acted)
    assert count > 10 and left <= share * count
    by_caller(monkeypatch)
    expected = followed(ready(text), text, stop)
    assert len(acted) - left == len(expected["events/hit/t"])
    for path in ("q/x", "q/y", "v/x", "v/y"):
        assert np.max(np.abs(found[path] - expected[path])) <= 2.0**-33, path


EDGE = """
nonholonomic: {"edge[i in range(2)]": "x_dot[3*i]*sin(0.3 + x[3*i]/5) - y_dot[3*i]/10 + y_dot[3*i + 1]/5"}
constraints:"""
WALL = """
  "wall[i in range(N)]":
    {when: "x[i] - N - 0.3", direction: rising, action: {set: {"x_dot[i]": "-x_dot[i]/3"}}}
"""
JOINED: dict[str, Callable[[str], str]] = {
    "rods that grow": lambda text: text.replace("- 1 - r*", "- 1 - 0.2*sin(3*t) - r*"),
    "a moving floor": lambda text: text.replace('"y[i]", dir', '"y[i] - 0.1*sin(5*t)", dir').replace(
        '"-0.3*y_dot[i]"', '"-0.3*y_dot[i] + 0.65*cos(5*t)"'
    ),
    "a wall": lambda text: text + WALL,
    "edges": lambda text: text.replace("constraints:", EDGE),
}


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.parametrize("case", JOINED)
def test_impulses_of_compiled_code_are_those_of_the_caller(
    case: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two routes: elimination in compiled code, and least squares of the whole matrix."""
    keep_families(monkeypatch, whole=True)
    text = JOINED[case]((BOBS + FLOOR).format(count=9, e=0.3))
    acted = counted(Happenings, "_act", monkeypatch)
    found = followed(ready(text), text, 0.6)
    left = len(acted)
    by_caller(monkeypatch)
    expected = followed(ready(text), text, 0.6)
    assert left < 0.8 * (len(acted) - left)
    for path in ("q/x", "q/y", "v/x", "v/y"):
        assert np.max(np.abs(found[path] - expected[path])) <= 2.0**-33, path


@pytest.mark.exhaustive(keep=0.5)
def test_ropes_that_are_not_joined_do_not_wait_for_each_other(monkeypatch: pytest.MonkeyPatch) -> None:
    """Bobs of a rope may rest while another one falls, whose impacts are done by compiled code."""
    keep_families(monkeypatch, whole=True)
    rods = "i in range(1, N)"
    text = (BOBS + FLOOR).format(count=12, e=0.5).replace(rods, f"{rods} if i != 6")
    text = text.replace('"1 + 0.3*sin(i)"', '"where(i < 6, 0, 0.4 + 0.03*sin(i))"')
    text = text.replace("r*(sin(i)", "where(i < 6, 0, 0.0009)*(sin(i)")  # so long are the rods then
    acted = counted(Happenings, "_act", monkeypatch)
    found = followed(ready(text), text, 0.4)
    assert len(found["events/hit/t"]) > 3 and not acted
    assert np.all(found["q/y"][-1][:6] == 0.0)


@pytest.mark.exhaustive(keep=0.25)
def test_motions_with_contacts_under_constant_forces_are_polynomials(monkeypatch: pytest.MonkeyPatch) -> None:
    across, up, events = contacts.CASES["a floor"]
    text = contacts.BALLS.format(count=9, across=across, up=up, events=events)
    keep_families(monkeypatch, whole=True)
    assert ready(text).machine.program.order > 20  # there are springs
    text = text.replace(" + x[i]**2 + 0.1*y[i]*x[i]", "")
    prepared = ready(text)
    assert prepared.machine.program.order == 8
    found = followed(prepared, text, 3.1)
    keep_families(monkeypatch, whole=False)
    expected = followed(ready(text), text, 3.1)
    for path in ("q/x", "q/y", "v/x", "v/y"):
        assert np.max(np.abs(found[path] - expected[path])) <= 2.0**-36, path


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize(("outputs", "any_of_them"), [({"q", "v"}, False), ({"q", "v", "ledger"}, True)])
def test_changes_by_compiled_code_are_handed_over_where_something_needs_them(
    outputs: set[str], any_of_them: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    keep_families(monkeypatch, whole=True)
    text = contacts.discs(4, "1", contacts.DISTANCE)
    changes = counted(Samples, "change", monkeypatch)
    found = followed(ready(text, outputs=frozenset(outputs)), text, 0.9)
    assert len(found["events/hit/t"]) > 0
    assert bool(changes) == any_of_them
