"""The nodes of Gauss-Radau quadrature with eight points, and the polynomials through values at them.

Accelerations within a step are a(s) = a(0) + sum_k b[k] s^(k+1) = a(0) + sum_n g[n] s (s - s_1) .. (s - s_n),
with s from 0 to 1 (E. Everhart, in: Dynamics of Comets: Their Origin and Evolution, 1985). All numbers
follow from the nodes as they are rounded: so the polynomial passes through the values where these belong.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from lagrange_cli.native.llvm.text import table

NODES = (
    0.05626256053692215, 0.18024069173689236, 0.3526247171131696, 0.5471536263305554,
    0.7342101772154105, 0.8853209468390958, 0.9775206135612875,
)  # fmt: skip
"""The zeros of (P_7 + P_8)(2 s - 1) except s = 0 (P: Legendre polynomials)."""
TERMS = len(NODES)
STRIDE = TERMS + 1
"""How far tables for one node are behind those for the node before."""


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


def tables() -> list[str]:
    """Numbers for each node, for loops over nodes: s; what b[k] adds to the mean of the rates until s, and to
    that of their integrals; 1 / s and 1 / (s - s_j); and what g[n] adds to b[k]."""
    rows = products()
    integrated = [[s ** (k + 1) / (k + 2) for k in range(TERMS)] for s in NODES]
    twice = [[s ** (k + 1) / ((k + 2) * (k + 3)) for k in range(TERMS)] for s in NODES]
    apart = [[1.0 / s, *(1.0 / (s - other) for other in NODES[:n])] for n, s in enumerate(NODES)]
    return [
        table("nodes", NODES, "double"),
        _table("integrated", integrated),
        _table("twice_integrated", twice),
        _table("apart", apart),
        _table("products", [[float(one) for one in row] for row in rows]),
    ]


def _table(name: str, rows: Sequence[Sequence[float]]) -> str:
    filled = [x for row in rows for x in (*row, *[0.0] * (STRIDE - len(row)))]
    return table(name, filled, "double")
