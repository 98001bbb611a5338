"""Linear equations modulo a prime, and the fractions that residues stand for."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from math import isqrt


class Equations:
    """Independent homogeneous linear equations in ``count`` unknowns.

    A row is one long number, with room between its entries for sums of their products with residues: so the
    multiple of another row is added to it in one operation.
    """

    def __init__(self, count: int, prime: int) -> None:
        self.count, self.prime = count, prime
        self._width = (2 * prime.bit_length() + count.bit_length() + 7) // 8
        """Bytes of an entry."""
        self._rows: dict[int, list[int]] = {}
        """By the first unknown of each, whose coefficient is 1; those before it are 0."""
        self._after: dict[int, int] = {}
        """What follows the 1 of each row, as a long number."""

    def __len__(self) -> int:
        return len(self._rows)

    def add(self, row: Sequence[int]) -> bool:
        """Add an equation, and return whether it is independent of the previous ones."""
        p, width = self.prime, self._width
        bits = 8 * width
        last = (1 << bits) - 1
        rest = self._packed([x % p for x in row])
        for j in range(self.count):
            lead = (rest & last) % p
            rest >>= bits
            if not lead:
                continue
            known = self._after.get(j)
            if known is None:
                inverse = pow(lead, -1, p)
                entries = rest.to_bytes(width * (self.count - j - 1), "little")
                parts = (entries[i : i + width] for i in range(0, len(entries), width))
                after = [int.from_bytes(one, "little") * inverse % p for one in parts]
                self._rows[j], self._after[j] = [0] * j + [1, *after], self._packed(after)
                return True
            rest += (p - lead) * known
        return False

    def _packed(self, entries: Iterable[int]) -> int:
        """The entries as one number, the first of them last in it."""
        return int.from_bytes(b"".join([one.to_bytes(self._width, "little") for one in entries]), "little")

    @property
    def free(self) -> list[int]:
        """The free unknowns."""
        return [j for j in range(self.count) if j not in self._rows]

    def solutions(self) -> list[dict[int, int]]:
        """A basis of solutions: in each of them, one free unknown is 1 and the others are 0."""
        p, found = self.prime, []
        for chosen in self.free:
            vector = {chosen: 1}
            for j in sorted(self._rows, reverse=True):
                if j < chosen:
                    row = self._rows[j]
                    value = -sum(row[k] * x for k, x in vector.items()) % p
                    if value:
                        vector[j] = value
            found.append(dict(sorted(vector.items())))
        return found


def solved(matrix: Sequence[Sequence[int]], right: Sequence[int], prime: int) -> list[int] | None:
    """The solution of matrix * x = right modulo a prime; None where there is not exactly one."""
    size = len(right)
    equations = Equations(size + 1, prime)
    for row, x in zip(matrix, right):
        equations.add([*row, -x % prime])
    if equations.free != [size]:
        return None
    (solution,) = equations.solutions()
    return [solution.get(j, 0) for j in range(size)]


def fraction_of(value: int, prime: int) -> Fraction:
    """The fraction n/d with small n and d that is ``value`` modulo the prime (P. S. Wang, SYMSAC 1981)."""
    bound = isqrt(prime // 2)
    before, here, s, t = prime, value % prime, 0, 1
    while here > bound:
        quotient = before // here
        before, here, s, t = here, before - quotient * here, t, s - quotient * t
    return Fraction(here, t)
