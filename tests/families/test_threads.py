"""Motions whose work several threads share: the same bits, however many there are."""

from __future__ import annotations

import threading
from collections.abc import Callable

import numpy as np
import pytest

import lagrange_cli
from lagrange_cli.errors import UsageError
from lagrange_cli.families import system as systems
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.method import End, Observer, Start
from lagrange_cli.integrate.methods import helping
from lagrange_cli.integrate.prepare import prepare_system
from lagrange_cli.integrate.prepared import Prepared
from lagrange_cli.integrate.times import Times
from lagrange_cli.native.families import strips
from lagrange_cli.run.derive import derive_system
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_values

BODIES = """
sizes: {{N: {0}}}
coordinates:
  "x[i in range(N)]": {{initial: "sin(i*i)*(1 + i)", velocity: "cos(i)/9"}}
  "y[i in range(N)]": {{initial: "cos(3*i*i)*(2 + i)", velocity: "sin(2*i)/7"}}
masses: {{"body[i in range(N)]": "1 + i/N"}}
embedding: {{"body[i in range(N)]": ["x[i]", "y[i]"]}}
potential: "{1}"
"""
PAIR = "-1/norm(body[i] - body[j])"
PAIRS = {
    "below": f"sum({PAIR} for i in range(N) for j in range(i))",
    "above": f"sum({PAIR} for i in range(N) for j in range(i + 1, N))",
    "all, in one direction": "sum(cos(x[i] - 2*y[j])*x[i] for i in range(N) for j in range(N))",
    "farther than three": f"sum({PAIR} for i in range(N) for j in range(i + 3, N)) + x[0]**2",
    "two sums": f"sum({PAIR} for i in range(N) for j in range(i)) + "
    "sum(sin(x[i]*x[j]) for i in range(N) for j in range(i + 1, N))",
}
NOT_SHARED = {
    "every pair twice": f"sum({PAIR} for i in range(N) for j in range(N) if i != j)",
    "near pairs": f"sum({PAIR} for i in range(N) for j in range(i) if i - j < 30)",
    "some pairs": "sum(cos(x[i] - x[j]) for i in range(N) for j in range(N) if i != j and (i + j) % 3)",
}
"""Later rows add to the columns of earlier ones before these end, or would between vectors; or members of a
row have no columns side by side."""


@pytest.fixture(autouse=True)
def of_any_size(monkeypatch: pytest.MonkeyPatch) -> None:
    """Families stay families, and are shared, however few their members are."""
    monkeypatch.setattr(systems, "FEWEST", 0)
    share(monkeypatch)


def share(monkeypatch: pytest.MonkeyPatch, height: int = 5, width: int = 16, worth: int = 0) -> None:
    """How evaluations are cut into parts, from here on."""
    for name, value in (("HEIGHT", height), ("WIDTH", width), ("WORTH", worth)):
        monkeypatch.setattr(strips, name, value)


def ready(text: str, method: str = "ias15", tolerance: float = 1e-9) -> Prepared:
    """A system that has been compiled."""
    asked = Compilation(method, tolerance, frozenset(["q", "v"]))
    return prepare_system(read_spec(text, "system.yaml"), derive_system, None, asked)


def followed(
    text: str,
    prepared: Prepared,
    threads: int,
    interrupt: Callable[[float], bool] = lambda t: False,
    stop: float = 0.4,
) -> End:
    """The end of its motion."""
    values, times = resolve_values(read_spec(text, "system.yaml"), {}), Times(0.0, stop, 3, stop / 2)
    start = Start.of(prepared.machine.program, values, times)
    return prepared.follower.follow(start, Observer(interrupt=interrupt), threads)


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("name", PAIRS)
@pytest.mark.parametrize("method", ["ias15", "DOP853"])
@pytest.mark.parametrize("count", [40, 41, 47])
@pytest.mark.parametrize(("height", "width"), [(5, 16), (3, 8), (16, 64)])
def test_threads_give_the_same_bits(
    name: str, method: str, count: int, height: int, width: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Those of one thread without strips, however work is cut, and however many threads there are."""
    text = BODIES.format(count, PAIRS[name])
    share(monkeypatch, worth=2**40)
    alone = ready(text, method)
    share(monkeypatch, height, width)
    together = ready(text, method)
    assert alone.machine.program.strips == 0
    assert together.machine.program.strips >= 2
    plain = followed(text, alone, 3)
    assert plain.ending is Ending.COMPLETE
    for threads in (1, 2, 3):
        end = followed(text, together, threads)
        assert (end.steps, end.evaluations) == (plain.steps, plain.evaluations)
        assert end.state.tobytes() == plain.state.tobytes(), threads


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("name", NOT_SHARED)
def test_sums_whose_order_would_change_are_not_shared(name: str) -> None:
    """One thread computes them."""
    assert ready(BODIES.format(40, NOT_SHARED[name])).machine.program.strips == 0


def started(monkeypatch: pytest.MonkeyPatch) -> list[threading.Thread]:
    """Threads that help, from here on."""
    found: list[threading.Thread] = []

    class Thread(threading.Thread):
        def start(self) -> None:
            found.append(self)
            super().start()

    monkeypatch.setattr(helping.threading, "Thread", Thread)
    return found


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize(("threads", "helpers"), [(1, 0), (2, 1), (3, 2), (100, 7)])
def test_threads_are_started_where_there_is_work(
    threads: int, helpers: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As many as there are, but no more than strips, of which this system has eight; they end with the
    motion."""
    text, found = BODIES.format(40, PAIRS["above"]), started(monkeypatch)
    prepared = ready(text)
    assert prepared.machine.program.strips == 8
    followed(text, prepared, threads)
    assert len(found) == helpers
    assert not any(one.is_alive() for one in found)


def test_small_systems_have_no_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    """Their code has nothing of the kind."""
    monkeypatch.undo()
    monkeypatch.setattr(systems, "FEWEST", 0)
    text, found = BODIES.format(40, PAIRS["above"]), started(monkeypatch)
    prepared = ready(text)
    assert prepared.machine.program.strips == 0
    assert prepared.machine.help is None
    followed(text, prepared, 2)
    assert found == []


def test_helpers_rest_while_they_are_of_no_use() -> None:
    """They do where it is faster without them, and are tried again after a while."""
    prepared = ready(BODIES.format(40, PAIRS["above"]))
    constants = np.zeros(prepared.machine.program.constants)
    helpers = helping.Helpers(prepared.machine, constants, 2)
    helpers.active = True

    def after(*evaluations: int, computed: float = 1.0) -> list[bool]:
        """Whether they take part after each of these spans of a second, for a part of which there was a
        processor."""
        found = []
        for one in evaluations:
            helpers.judge(one, 1.0, computed)
            found.append(helpers.active)
        return found

    assert after(100, 60, 100, 90, 70) == [False, True, True, True, False]
    assert after(*[90] * 16) == [False] * 15 + [True]
    assert after(80) == [False]
    assert after(*[90] * 20, computed=0.6) == [False] * 20
    assert after(90) == [True]
    assert after(110, computed=0.6) == [False]
    assert prepared.machine.help is not None
    assert prepared.machine.help(constants.ctypes.data) == 1, "they would not sleep while they rest"


class Stopped(Exception):
    """Raised in the middle of a motion."""


def test_threads_end_where_a_motion_is_interrupted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whether it ends between two steps, or by an exception."""
    text, found = BODIES.format(40, PAIRS["above"]), started(monkeypatch)
    prepared = ready(text)

    def fail(t: float) -> bool:
        assert sum(one.is_alive() for one in found) == 2
        raise Stopped

    end = followed(text, prepared, 2, lambda t: True, 1e6)
    assert end.ending is Ending.INTERRUPTED
    assert len(found) == 1
    found.clear()
    with pytest.raises(Stopped):
        followed(text, prepared, 3, fail, 1e6)
    assert len(found) == 2
    assert not any(one.is_alive() for one in found)


@pytest.mark.exhaustive(keep=0.2)
def test_a_singular_start_ends_alike() -> None:
    """Two bodies are at one place."""
    text = BODIES.format(40, PAIRS["below"]).replace("sin(i*i)*(1 + i)", "i//2")
    text = text.replace("cos(3*i*i)*(2 + i)", "0")
    prepared = ready(text)
    ends = [followed(text, prepared, threads) for threads in (1, 2, 3)]
    assert ends[0].ending is Ending.NOT_A_NUMBER
    for end in ends[1:]:
        assert (end.ending, end.t, end.steps) == (ends[0].ending, ends[0].t, ends[0].steps)
        assert end.state.tobytes() == ends[0].state.tobytes()


@pytest.mark.exhaustive(keep=0.35)
def test_solve_takes_a_number_of_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    """In Python as on the command line; it is a whole number."""
    text, found = BODIES.format(40, PAIRS["below"]), started(monkeypatch)
    options = {"stop": 0.1, "samples": 3, "method": "ias15", "cache": False}
    one, two = (lagrange_cli.solve(text, threads=threads, **options) for threads in (1, 2))  # type: ignore[arg-type]
    assert len(found) == 1
    assert np.array_equal(one.q["x"], two.q["x"])
    for wrong in (0, 1.5, True):
        with pytest.raises(UsageError, match="threads must be a whole number greater than 0"):
            lagrange_cli.solve(text, threads=wrong)  # type: ignore[arg-type]
