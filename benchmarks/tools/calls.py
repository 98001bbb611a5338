"""What a call of ``lagrange_cli.solve`` costs besides the integration, once a system is compiled.

    python -m benchmarks.tools.calls

Each call has another value of a parameter, so that nothing but what was read and compiled can be used again.
"""

from __future__ import annotations

import time
from statistics import median
from typing import Any
from unittest.mock import patch

import lagrange_cli as lagrange
from lagrange_cli.integrate import run
from lagrange_cli.integrate.run import integrate

CASES = {
    "pendulum": {"l": 1.0},
    "double_pendulum": {"l1": 1.0},
    "bouncing_ball": {"g": 9.81},
    "n_pendulum": {"l": 1.0},
    "incline": {"g": 9.81},
    "solar_system": {"k": 0.01720209895},
}
"""Systems, and the parameter of each that is changed from call to call."""
CALLS = 50


def measure(system: str, name: str, value: float, calls: int = CALLS) -> tuple[float, float]:
    """The median (ms) of the integration in a call, and of everything else."""
    inside, outside, spent = list[float](), list[float](), [0.0]

    def timed(*given: Any, **more: Any) -> Any:
        began = time.perf_counter()
        outcome = integrate(*given, **more)
        spent[0] = time.perf_counter() - began
        return outcome

    with patch.object(run, "integrate", timed):
        for call in range(calls + 1):
            began = time.perf_counter()
            lagrange.solve(system, set={name: value * (1 + 1e-9 * call)}, samples=2)
            whole = time.perf_counter() - began
            inside.append(1e3 * spent[0])
            outside.append(1e3 * (whole - spent[0]))
    return median(inside[1:]), median(outside[1:])


def main() -> None:
    """Print a table."""
    print(f"{'system':18} {'integration (ms)':>18} {'besides (ms)':>14}")
    for name, given in CASES.items():
        ((parameter, value),) = given.items()
        inside, outside = measure(lagrange.example(name), parameter, value)
        print(f"{name:18} {inside:18.3f} {outside:14.3f}")


if __name__ == "__main__":
    main()
