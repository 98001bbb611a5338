"""The coefficients of the elementary functions' polynomials (lagrange_cli/native/functions/elementary.py).

Each is the polynomial whose largest weighted error is smallest (E. Ya. Remez, C. R. Acad. Sci. Paris 199,
1934), with its lowest coefficients rounded to doubles one after the other, each time with the
others fitted anew (N. Brisebarre and S. Chevillard, ARITH 18, 2007, say why and do it even better).

    python -m benchmarks.tools.minimax
"""

from __future__ import annotations

import sys
from collections.abc import Callable

import mpmath
from mpmath import mpf

DIGITS = 60
SAMPLES = 401
EXCHANGES = 12
Function = Callable[[mpf], mpf]


def minimax(f: Function, weight: Function, low: mpf, high: mpf, count: int) -> tuple[list[float], mpf]:
    """``count`` coefficients of a polynomial near ``f`` in [low, high], lowest first, and log2 of its error.

    The error is the largest of |P - f| weight.
    """
    fixed: list[mpf] = []
    while len(fixed) < count:
        fitted = exchange(f, weight, low, high, fixed, count - len(fixed))
        fixed.append(mpf(float(fitted[0])))
    points = [low + (high - low) * k / SAMPLES for k in range(SAMPLES + 1)]
    error = max(abs(mpmath.polyval(fixed[::-1], x) - f(x)) * weight(x) for x in points)
    return [float(c) for c in fixed], mpmath.log(error, 2)


def exchange(f: Function, weight: Function, low: mpf, high: mpf, fixed: list[mpf], count: int) -> list[mpf]:
    """The ``count`` best coefficients above ``fixed`` ones, by Remez's exchange algorithm."""
    skip = len(fixed)
    points = [
        (low + high) / 2 - (high - low) / 2 * mpmath.cos(mpmath.pi * k / count) for k in range(count + 1)
    ]
    grid = [
        (low + high) / 2 - (high - low) / 2 * mpmath.cos(mpmath.pi * k / SAMPLES) for k in range(SAMPLES + 1)
    ]
    wanted = [f(x) - mpmath.polyval(fixed[::-1] or [0], x) for x in grid]
    for _ in range(EXCHANGES):
        rows = [
            [x ** (skip + j) for j in range(count)] + [(-1) ** k * mpmath.sign(x) ** skip / weight(x)]
            for k, x in enumerate(points)
        ]
        right = [f(x) - mpmath.polyval(fixed[::-1] or [0], x) for x in points]
        found = list(mpmath.lu_solve(mpmath.matrix(rows), mpmath.matrix(right)))[:count]
        errors = [
            (x**skip * mpmath.polyval(found[::-1], x) - y) * weight(x) * mpmath.sign(x) ** skip
            for x, y in zip(grid, wanted)
        ]
        points = extrema(grid, errors, count + 1)
    return found


def extrema(grid: list[mpf], errors: list[mpf], count: int) -> list[mpf]:
    """Where ``errors`` is largest between its changes of sign; the ``count`` neighbours that matter most."""
    runs: list[list[int]] = [[0]]
    for i in range(1, len(grid)):
        if mpmath.sign(errors[i]) == mpmath.sign(errors[i - 1]):
            runs[-1].append(i)
        else:
            runs.append([i])
    best = [max(run, key=lambda i: abs(errors[i])) for run in runs]
    while len(best) > count:
        best.pop(0 if abs(errors[best[0]]) < abs(errors[best[-1]]) else -1)
    return [grid[i] for i in best]


def parts(value: mpf, bits: list[int]) -> list[float]:
    """``value`` as a sum of doubles, the first ones with as many leading bits as given."""
    result = []
    for width in bits:
        with mpmath.workprec(width):
            part = float(+value)
        result.append(part)
        value -= part
    return result


def tables() -> dict[str, list[float]]:
    """Every table of the module, by its name there."""
    tiny = mpf(10) ** -12
    quarter = (mpmath.pi / 4 * (1 + mpf(2) ** -20)) ** 2
    half = mpmath.log(2) / 2
    steep = ((mpmath.sqrt(2) - 1) / (mpmath.sqrt(2) + 1)) ** 2
    fits: dict[str, tuple[list[float], mpf]] = {
        "SINE": minimax(
            lambda z: (mpmath.sin(mpmath.sqrt(z)) / mpmath.sqrt(z) - 1) / z,
            lambda z: z, tiny, quarter, 6,
        ),
        "COSINE": minimax(
            lambda z: (mpmath.cos(mpmath.sqrt(z)) - 1 + z / 2) / z**2, lambda z: z**2, tiny, quarter, 6
        ),
        "EXPONENTIAL": minimax(
            lambda r: (mpmath.exp(r) - 1 - r) / r**2 if abs(r) > tiny else mpf(1) / 2,
            lambda r: r**2 * mpmath.exp(-r) + tiny**2, -half, half * mpf("1.001"), 11,
        ),
        "LOGARITHM": minimax(
            lambda z: (2 * mpmath.atanh(mpmath.sqrt(z)) / mpmath.sqrt(z) - 2 - 2 * z / 3) / z**2,
            lambda z: z**2 / 2 + tiny**2, tiny, steep, 9,
        ),
    }  # fmt: skip
    for name, (_, error) in fits.items():
        print(f"# {name}: error 2^{float(error):.1f}", file=sys.stderr)
    made = {name: table for name, (table, _) in fits.items()}
    made["HALF_PI"] = parts(mpmath.pi / 2, [53, 33, 53])
    made["LN_2"] = parts(mpmath.log(2), [42, 53])
    return made


def main() -> None:
    """Print them as the module has them."""
    with mpmath.workdps(DIGITS):
        for name, table in tables().items():
            print(f"{name} = {tuple(table)}")


if __name__ == "__main__":
    main()
