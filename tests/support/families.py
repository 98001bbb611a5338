"""Motions of systems of families from the texts of their files, as ``solve`` goes."""

from __future__ import annotations

from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.prepare import prepare_system
from lagrange_cli.integrate.prepared import Prepared
from lagrange_cli.run.derive import derive_system
from lagrange_cli.run.start import consistent_values
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.spec import Spec
from lagrange_cli.spec.values import Values, resolve_values
from tests.support.motion import FULL, Motion, run


def begun(text: str) -> tuple[Spec, Values]:
    """A system and its consistent start."""
    spec = read_spec(text, "system.yaml")
    spec, values, _ = consistent_values(spec, resolve_values(spec, {}), 0.0, ())
    return spec, values


def followed(
    text: str, outputs: frozenset[str], stop: float = 0.5, samples: int = 6, method: str = "taylor"
) -> tuple[Prepared, Motion]:
    """A motion of a system, and what it was followed by."""
    spec, values = begun(text)
    asked = Compilation(method, FULL, outputs, backward=stop < 0.0)
    ready = prepare_system(spec, derive_system, None, asked)
    return ready, run(ready, values, 0.0, stop, samples)
