"""Integrals stand beside a motion: the bytes of q and v do not depend on which of them are followed."""

from typing import Any

import pytest

import lagrange_cli as lagrange
from tests.support.command import SYSTEMS
from tests.support.motion import spec_of

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
