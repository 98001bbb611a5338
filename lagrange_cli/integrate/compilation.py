"""``Compilation``: what the equations of motion of a system are compiled for."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lagrange_cli.integrate.precision import DOUBLE
from lagrange_cli.records import dataclass, replace

if TYPE_CHECKING:
    from lagrange_cli.native.program import Program


@dataclass(frozen=True)
class Compilation:
    """What a program is to do: all that compiled code depends on besides the system.

    ``method`` is ``taylor`` or one of scipy's, ``tolerance`` the relative error per step, and ``outputs`` the
    names of what is computed (``q``, ``h``, ``ledger``, ...). A program for an ``ensemble`` follows eight
    motions at once, where that suits the system, and none alone; if its motions are ``few`` or short, large
    families are not expanded for that, and motions followed alone. ``precision`` is that of the numbers. A
    ``portable`` program computes the same bits on every machine, if the numbers in the equations are such.
    ``order`` is that of the Taylor series, if it is not to follow from the tolerance. Motions that stop
    before they start need a program that is compiled ``backward``. Steps are ``proven`` for every system, not
    only where a force may hide; in an ``unproven`` program, which is shorter, none is. An ensemble's
    ``section`` is a kind of them (``native.interface``): what is kept of its motions are not samples at given
    times. With a ``factor``, the program is that of a companion (see ``native.numbers.beside``). Outputs that
    are ``optional`` are left out as far as they are not defined, or too large where others are not.
    Observables that are there ``by_default`` are left out where they are not defined.
    """

    method: str
    tolerance: float
    outputs: frozenset[str]
    ensemble: bool = False
    few: bool = False
    precision: str = DOUBLE
    portable: bool = False
    order: int | None = None
    backward: bool = False
    proven: bool = False
    unproven: bool = False
    section: str = ""
    factor: int | None = None
    optional: frozenset[str] = frozenset()
    by_default: bool = False

    @property
    def lenient(self) -> frozenset[str]:
        """The outputs that need not be defined."""
        return self.optional | {"observables"} if self.by_default else self.optional


def portable_if_asked(program: Program, compilation: Compilation) -> Program:
    """The program, with the same bits on every machine where that is asked for."""
    if not compilation.portable:
        return program
    from lagrange_cli.native.functions.portable import portable

    return replace(program, text=portable(program.text))
