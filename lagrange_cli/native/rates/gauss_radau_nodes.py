"""The nodes of Gauss-Radau quadrature with eight points, and the polynomials through values at them.

Accelerations within a step are a(s) = a(0) + sum_k b[k] s^(k+1) = a(0) + sum_n g[n] s (s - s_1) .. (s - s_n),
with s from 0 to 1 (E. Everhart, in: Dynamics of Comets: Their Origin and Evolution, 1985). All numbers
follow from the nodes as they are rounded: so the polynomial passes through the values where these belong.
"""

from __future__ import annotations

from fractions import Fraction

NODES = (
    0.05626256053692215, 0.18024069173689236, 0.3526247171131696, 0.5471536263305554,
    0.7342101772154105, 0.8853209468390958, 0.9775206135612875,
)  # fmt: skip
"""The zeros of (P_7 + P_8)(2 s - 1) except s = 0 (P: Legendre polynomials)."""
TERMS = len(NODES)


def products() -> tuple[tuple[Fraction, ...], ...]:
    """Row n: the coefficients of s (s - s_1) .. (s - s_n), from s on."""
    rows: list[tuple[Fraction, ...]] = [(Fraction(1),)]
    for node in NODES[:-1]:
        last = rows[-1]
        shifted, scaled = (Fraction(0), *last), [Fraction(node) * one for one in last]
        rows.append(tuple(a - b for a, b in zip(shifted, (*scaled, Fraction(0)))))
    return tuple(rows)


def inverse(rows: tuple[tuple[Fraction, ...], ...]) -> tuple[tuple[Fraction, ...], ...]:
    """Row n: what each b[k], k >= n, adds to g[n]."""
    # the k-th power is the k-th product, less the lower powers in it
    solved = [[Fraction(0)] * TERMS for _ in range(TERMS)]
    for k in range(TERMS):
        rest = [Fraction(int(m == k)) for m in range(TERMS)]
        for n in reversed(range(k + 1)):
            solved[n][k] = rest[n]
            for m in range(n + 1):
                rest[m] -= solved[n][k] * rows[n][m]
    return tuple(map(tuple, solved))
