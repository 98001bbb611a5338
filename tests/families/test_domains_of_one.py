"""What is written singly is a domain of one: the loops of families follow it, too, along the same motion.
(Members are unrolled otherwise, since loops over one of them save nothing.)"""

from __future__ import annotations

import random

import numpy as np
import pytest

from lagrange_cli.families import system as systems
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.families import looped
from lagrange_cli.integrate.family_program import write_families
from lagrange_cli.integrate.methods.selection import follower
from lagrange_cli.integrate.prepared import Prepared
from lagrange_cli.integrate.written_out import WrittenOut
from lagrange_cli.native.compilation.machine import QUICK, compile_program
from tests.motions.test_random_systems import random_system
from tests.support.motion import DEFAULT, FULL, SYSTEMS, consistent, prepared, run, spec_of

SHIPPED = sorted(path.stem for path in SYSTEMS.glob("*.yaml"))
PROVEN = {"bicycle"}
"""Those whose steps by series have to be proven, which loops with constraints do not do."""
CLOSE = 1e-8
"""How far motions are apart where they amplify rounding errors."""


@pytest.fixture(autouse=True)
def joints_of_few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Chains are chains however few their members are."""
    monkeypatch.setattr(systems, "FEWEST_JOINTED", 0)
    systems._LATEST.clear()


def as_loops(text: str, method: str = "taylor", tolerance: float = FULL) -> Prepared | WrittenOut:
    """The compiled loops of a system; or why there are none."""
    compilation = Compilation(method, tolerance, frozenset(DEFAULT))
    system = systems.any_family_system(spec_of(text))
    assert system is not None, text
    found = looped(system, compilation)
    if isinstance(found, WrittenOut):
        return found
    program, recording = write_families(found, compilation)
    machine = compile_program(program, QUICK)
    return Prepared(recording, machine, compilation, follower(machine, compilation))


def moves_alike(text: str, stop: float, method: str = "taylor", tolerance: float = FULL) -> None:
    """Loops follow a system along the motion of its unrolled members, to its end and through its events."""
    loops = as_loops(text, method, tolerance)
    assert isinstance(loops, Prepared), (loops, text)
    assert loops.machine.program.loops
    values = consistent(text)
    found = run(loops, values, 0.0, stop, 21)
    known = run(prepared(text, method, tolerance), values, 0.0, stop, 21)
    assert found.outcome.ending is known.outcome.ending is Ending.COMPLETE, (
        found.outcome,
        known.outcome,
        text,
    )
    for path, expected in known.data.items():
        size = max(1.0, float(np.max(np.abs(expected), initial=0.0)))
        assert found[path] == pytest.approx(expected, rel=0, abs=CLOSE * size), (path, text)


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.parametrize("name", SHIPPED)
def test_loops_follow_the_shipped_systems(name: str) -> None:
    stop = spec_of(name).solve.stop
    assert stop is not None
    moves_alike(name, stop / 20, "ias15" if name in PROVEN else "taylor")


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("method", ["taylor", "ias15"])
@pytest.mark.parametrize("number", range(20))
def test_loops_follow_random_systems(number: int, method: str) -> None:
    moves_alike(random_system(random.Random(f"{number} {method}")), 3.0, method)
