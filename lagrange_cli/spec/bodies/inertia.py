"""Whether moments of inertia are possible for a body."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

from lagrange_cli.decimals import decimal

ROUNDING = 1e-9
"""A relative difference between moments that rounding may cause."""
Flaw = tuple[int, str, str]
"""The place of a wrong entry, what is wrong, and a way out."""
TRIANGLE = "no moment of inertia of a body exceeds the sum of the other two"


def flaw(entries: Sequence[float]) -> Flaw | None:
    """The mistake in three principal moments, or in the nine entries of a matrix, if there is one.

    The second moments of mass J = tr(I)/2 - I must not be negative along any axis, or I_1 > I_2 + I_3.
    """
    if len(entries) == 3:
        if min(entries) <= 0:
            return not_positive(entries)
        largest = max(entries)
        if 2 * largest > sum(entries) + ROUNDING * largest:
            least, middle, most = apart(*sorted(entries))
            return entries.index(largest), f"the value {most} exceeds {least} + {middle}", TRIANGLE
        return None
    return tensor_flaw(entries)


def not_positive(moments: Sequence[float]) -> Flaw:
    """The mistake in three principal moments that are not all greater than 0."""
    least, middle, most = sorted(moments)
    if least < 0:
        hint = "moments of inertia are greater than 0"
    elif most == 0:
        hint = "what has a mass and no size is a particle: write it under 'masses' and 'positions'"
    elif middle == 0:
        hint = "where it turns about one axis only, the moment J about that alone counts: write [J, J, J]"
    elif most - middle > ROUNDING * most:
        hint = "only a thin rod has none about one axis, and those about the other two are equal then"
    else:
        hint = "a thin rod with the moments J, J, 0 is 'solid: {rod: l}' with l = sqrt(12*J/m)"
        hint += "" if moments[2] == 0 else "; it lies along the third axis, so turn the orientation"
    first = next(i for i, one in enumerate(moments) if one <= 0)
    return first, f"the value {decimal(moments[first], 15)} is not positive", hint


def apart(*numbers: float) -> list[str]:
    """The numbers with so many digits, six or more, that each one is within a thousandth of how far they are
    from being as they should: from each other, or the last one from the sum of the others."""
    *others, last = numbers
    off = abs(last - sum(others)) or abs(last)
    digits = next((n for n in range(6, 17) if 10.0 ** (1 - n) * max(map(abs, numbers)) <= 1e-3 * off), 17)
    return [decimal(one, digits) for one in numbers]


def tensor_flaw(entries: Sequence[float]) -> Flaw | None:
    """The same of a matrix."""
    scale = max(map(abs, entries))
    for i, j in combinations(range(3), 2):
        upper, lower = entries[3 * i + j], entries[3 * j + i]
        if abs(upper - lower) > ROUNDING * scale:
            row, column = f"{i + 1}{j + 1}", f"{j + 1}{i + 1}"
            above, below = apart(upper, lower)
            message = f"not symmetric: I{row} = {above}, but I{column} = {below}"
            return 3 * j + i, message, "moments of inertia are a symmetric matrix"
    if not any(one for k, one in enumerate(entries) if k % 4) and min(entries[::4]) <= 0:
        first, message, hint = not_positive(entries[::4])
        return 4 * first, message, hint
    half = sum(entries[::4]) / 2
    second = [(half if k % 4 == 0 else 0.0) - one for k, one in enumerate(entries)]
    if scale == 0 or not is_positive(entries, 0.0):
        return 0, "not positive definite", "every axis has a positive moment of inertia"
    if not is_positive(second, ROUNDING * scale):
        return 0, f"no body has the principal moments {', '.join(principal(entries))}", TRIANGLE
    return None


def principal(entries: Sequence[float]) -> list[str]:
    """The principal moments of a matrix that no body has, so that they can be compared."""
    import numpy as np

    return apart(*sorted(map(float, np.linalg.eigvalsh(np.reshape(entries, (3, 3))))))


def is_positive(entries: Sequence[float], margin: float) -> bool:
    """Whether a symmetric matrix, with ``margin`` added to its diagonal, is positive definite."""
    a, b, c, _, d, e, _, _, f = entries
    a, d, f = a + margin, d + margin, f + margin
    first, second = a * d - b * b, a * (d * f - e * e) - b * (b * f - c * e) + c * (b * e - c * d)
    return a > 0 and first > 0 and second > 0


def size_flaw(sizes: Sequence[float]) -> Flaw | None:
    """The mistake in the sizes of a solid, if there is one."""
    for i, one in enumerate(sizes):
        if one <= 0:
            return i, f"the value {decimal(one, 15)} is not positive", "sizes are greater than 0"
    return None
