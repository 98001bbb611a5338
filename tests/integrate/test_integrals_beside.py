"""Integrals stand beside a motion: the bytes of q and v do not depend on which of them are followed."""

from typing import Any

import numpy as np
import pytest

import lagrange_cli as lagrange
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.stepping import division
from tests.support.command import SYSTEMS
from tests.support.motion import follow, prepared, spec_of

LATEST = {"four_bar": 20.0, "fpu_chain": 20.0, "solar_system": 200.0, "foucault_gyroscope": 0.01}
CHOICES = (("action",), ("ledger",), ("action", "ledger", "p", "h"))


def motions(name: str, **more: Any) -> list[tuple[int, bytes]]:
    """Steps and bytes of q and v, without integrals and with some."""
    system = SYSTEMS / f"{name}.yaml"
    usual = spec_of(name).solve.stop or 10.0
    found = []
    for outputs in ((), *CHOICES):
        motion = lagrange.solve(
            system, stop=min(usual, LATEST.get(name, 10.0)), samples=41, outputs=["q", "v", *outputs], **more
        )
        state = (motion.datasets[path] for path in motion.datasets if path.startswith(("q/", "v/")))
        found.append((motion.attributes["steps"], b"".join(one.tobytes() for one in state)))
    return found


@pytest.mark.exhaustive(keep=0.2, most=12)
@pytest.mark.parametrize(
    "name", sorted(path.stem for path in SYSTEMS.glob("*.yaml") if path.stem != "bicycle")
)
def test_of_shipped_systems(name: str) -> None:
    plain, *others = motions(name)
    assert others == [plain] * len(others)


@pytest.mark.exhaustive(keep=0.2, most=4)
@pytest.mark.parametrize("name", ["double_pendulum", "spherical_pendulum", "henon_heiles", "gyroscope"])
def test_in_double_double(name: str) -> None:
    plain, *others = motions(name, precision="double-double")
    assert others == [plain] * len(others)


HELD_BESIDE = """
coordinates: {s: {initial: 0.1}, x: {initial: 1}}
masses: {block: 1, bob: 1}
embedding: {block: [s], bob: [x]}
potential: 2*s**2 + x**2/2 - 0.1/(0.02 + (x - s)**2)
generalized_forces: {s: -9*sign(s_dot)}
"""


def test_proofs_of_integrands_know_the_force_of_friction_that_holds_something(monkeypatch):
    """Its extent is computed: whatever memory held before, the proof is the same."""
    alone = follow(HELD_BESIDE, 3.0, 31, outputs=("q", "v", "ledger"))

    def line(f: Function, text: str) -> None:
        written(f, text)
        if "%extents = alloca" in text:
            places = int(text.partition("i64 ")[2].partition(",")[0])
            with f.loop(0, places) as i:
                f.store_row(f.splat(f.constant(1e300), LANES), "%extents", i * LANES, aligned=True)

    written = Function.line
    monkeypatch.setenv("LAGRANGE_NO_CACHE", "1")
    monkeypatch.setattr(Function, "line", line)
    monkeypatch.setattr(division, "MOST", 2**10)
    prepared.cache_clear()
    found = follow(HELD_BESIDE, 3.0, 31, outputs=("q", "v", "ledger"))
    prepared.cache_clear()
    for name in alone.data:
        assert np.array_equal(found[name], alone[name]), name
    assert np.max(np.abs(found["diagnostics/ledger/h"])) < 1e-13
