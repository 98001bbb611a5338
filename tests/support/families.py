"""Motions of systems of families from the texts of their files, as ``solve`` goes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.prepare import prepare_system
from lagrange_cli.integrate.prepared import Prepared
from lagrange_cli.run.derive import derive_system
from lagrange_cli.run.family_equations import DerivedFamilies, derive_printed, families_as_written
from lagrange_cli.run.settings.outputs import resolve_outputs
from lagrange_cli.run.start import consistent_values
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.spec import Spec
from lagrange_cli.spec.values import Values, resolve_values
from tests.support.motion import FULL, Motion, run

Samples: TypeAlias = "Mapping[str, NDArray[np.float64]]"


def begun(text: str) -> tuple[Spec, Values]:
    """A system and its consistent start."""
    spec = read_spec(text, "system.yaml")
    spec, values, _ = consistent_values(spec, resolve_values(spec, {}), 0.0, ())
    return spec, values


def followed(
    text: str,
    outputs: frozenset[str],
    stop: float = 0.5,
    samples: int = 6,
    method: str = "taylor",
    tolerance: float = FULL,
) -> tuple[Prepared, Motion]:
    """A motion of a system, and what it was followed by."""
    spec, values = begun(text)
    outputs = resolve_outputs(outputs, has_particles=True)  # refuses unknown ones
    asked = Compilation(method, tolerance, outputs, backward=stop < 0.0)
    ready = prepare_system(spec, derive_system, None, asked)
    return ready, run(ready, values, 0.0, stop, samples)


def both_in_loops(text: str, other: str, outputs: frozenset[str], most: float) -> None:
    """Two systems, both followed in loops, move alike but for rounding, up to ``most``."""
    (one, motion), (two, expected) = (followed(each, outputs) for each in (text, other))
    assert one.machine.program.loops and two.machine.program.loops
    alike(motion.data, expected.data, most)


def with_indices(text: str) -> DerivedFamilies:
    """The equations of a system, to be printed with indices."""
    found = derive_printed(read_spec(text, "system.yaml"), "lagrange", indexed=True)
    assert isinstance(found, DerivedFamilies)
    return found


def printed_alike(one: DerivedFamilies, other: DerivedFamilies) -> bool:
    """Whether the equations of two systems are printed in the same way."""
    first, second = (families_as_written(each, "text", "lagrange", {}) for each in (one, other))
    return first == second


def alike(found: Samples, expected: Samples, most: float, *said: object) -> None:
    """Samples are the same but for rounding, up to ``most``, with the low parts of double-double numbers."""
    for path, values in expected.items():
        if not path.startswith("low/"):
            low, size = f"low/{path}", np.max(np.abs(values), initial=1.0)
            assert found[path].shape == values.shape, (path, *said)
            off = (found[path] - values) + (found.get(low, 0.0) - expected.get(low, 0.0))
            assert np.max(np.abs(off), initial=0.0) <= most * size, (path, *said)
