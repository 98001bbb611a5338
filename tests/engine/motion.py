"""Solve a system within a test: from text or a shipped system to arrays."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from lagrange_cli import GraphAlgebra, Times, build_model, derive, prepare, read_spec, resolve_values
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.outcome import Outcome
from lagrange_cli.integrate.run import integrate

SYSTEMS = Path(__file__).parents[2] / "systems"
FULL = 2.0**-52


@dataclass(frozen=True)
class Motion:
    """Samples by path, how it ended, and the numbers it was run with."""

    series: dict[str, np.ndarray]
    outcome: Outcome
    parameters: dict[str, float]
    q: tuple[float, ...]
    v: tuple[float, ...]

    def __getitem__(self, path: str) -> np.ndarray:
        return self.series[path]


def text_of(system: str) -> str:
    """The text of a shipped system, or ``system`` itself where it is a text."""
    return system if "\n" in system else (SYSTEMS / f"{system}.yaml").read_text(encoding="utf-8")


@lru_cache(maxsize=64)
def residual_of(system: str):
    return derive(build_model(read_spec(text_of(system), "system.yaml"), GraphAlgebra()))


@lru_cache(maxsize=64)
def compiled(system: str, outputs: frozenset[str], method: str, tolerance: float):
    return prepare(residual_of(system), Compilation(method=method, tolerance=tolerance, outputs=outputs))


def solve(
    system: str,
    stop: float,
    samples: int = 101,
    *,
    start: float = 0.0,
    outputs: str = "q,v,p,h",
    method: str = "taylor",
    tolerance: float = FULL,
    interrupted=lambda: False,
    **overrides: float | str,
) -> Motion:
    """The motion of ``system`` with parameters or initial values replaced."""
    spec = read_spec(text_of(system), "system.yaml")
    values = resolve_values(spec, {name: str(value) for name, value in overrides.items()})
    prepared = compiled(system, frozenset(outputs.split(",")), method, tolerance)
    chunks: dict[str, list[np.ndarray]] = {}

    def emit(chunk):
        for path, samples_ in chunk.items():
            chunks.setdefault(path, []).append(np.array(samples_))

    times = Times(start, stop, samples, (stop - start) / (samples - 1))
    outcome = integrate(prepared, values, times, emit, interrupted)
    series = {path: np.concatenate(parts) for path, parts in chunks.items()}
    return Motion(series, outcome, dict(values.parameters), values.q, values.v)
