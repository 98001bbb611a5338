"""One timed integration, for its samples of q."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.outcome import Outcome
from lagrange_cli.integrate.run import integrate
from lagrange_cli.integrate.times import Times
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.spec.values import Values

SAMPLES = 1001
"""Number of times at which motions are compared, evenly spaced from start to stop."""


@dataclass(frozen=True)
class Trajectory:
    """``q`` of shape (samples reached, coordinates), the outcome of the integration, and its time."""

    q: NDArray[np.float64]
    outcome: Outcome
    seconds: float


def evenly(start: float, stop: float) -> Times:
    """The times at which motions are compared."""
    return Times(start, stop, SAMPLES, (stop - start) / (SAMPLES - 1))


def follow(
    prepared: Prepared,
    values: Values,
    times: Times,
    budget: float,
    interrupted: Callable[[], bool],
    progress: Callable[[float], None] = lambda t: None,
) -> Trajectory:
    """Integrate a prepared motion, for ``budget`` seconds at most or until ``interrupted``; ``progress`` is
    told the time reached.

    ``seconds`` is the time of the integration. As in a run of ``solve`` it includes samples and diagnostics,
    but neither compilation nor output.
    """
    paths = [dataset.path for dataset in prepared.recording.states if dataset.path.startswith("q/")]
    chunks = [np.empty((0, len(prepared.recording.coordinates)))]
    began = time.perf_counter()

    def emit(chunk: dict[str, NDArray[np.float64]]) -> None:
        count = len(chunk["t"])
        chunks.append(np.concatenate([chunk[path].reshape(count, -1) for path in paths], axis=1))

    def late() -> bool:
        return time.perf_counter() - began > budget or interrupted()

    outcome = integrate(prepared, values, times, emit, late, progress=progress)
    seconds = time.perf_counter() - began
    return Trajectory(np.concatenate(chunks), outcome, seconds)
