"""``@prepare`` of a companion's program (see ``numbers.beside``): constants with larger rounding errors."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from lagrange_cli.expression.node import Node
from lagrange_cli.native.functions.double_double import functions
from lagrange_cli.native.interface import CONSTANTS
from lagrange_cli.native.llvm.declarations import by_name, needed
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Integer, Real
from lagrange_cli.native.numbers.beside import BesideDoubleDouble
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.native.numbers.double_double import operations
from lagrange_cli.native.observation import write_prepare
from lagrange_cli.native.recurrences.evaluation import Constants

ONCE, LONG = "prepare_once", "prepare_long"
"""The functions that compute the constants: as in the run, and to many digits."""


def prepare_beside(constants: Constants, given: Mapping[str, Node], factor: int) -> tuple[str, int]:
    """``write_prepare`` for a companion; parameters are given in two parts."""
    once, size = write_prepare(Emitter, constants, given, f"internal void @{ONCE}")
    make = partial(BesideDoubleDouble, factor=factor)
    long, _ = write_prepare(make, constants, given, f"internal void @{LONG}")
    known = by_name([*operations(), *functions()])
    return "\n".join([*needed(long, known), once, long, _prepare(size)]), size


def _prepare(size: int) -> str:
    """``@prepare``: the constants, with rounding errors that are ``CONSTANTS`` times as large."""
    f = Function("define void @prepare(ptr noalias %parameters, ptr noalias %constants) nounwind")
    long = f.pointer(f.define(f"alloca [{max(1, 2 * size)} x double], align 64"))
    f.call(None, ONCE, f.pointer("%parameters"), f.pointer("%constants"))
    f.call(None, LONG, f.pointer("%parameters"), long)
    with f.loop(0, size, tested=True) as i:
        rounded = f.load("%constants", i)
        put_beside(f, i, rounded, f.load(long, i * 2), f.load(long, i * 2 + 1))
    f.give()
    return f.text()


def put_beside(f: Function, i: Integer, rounded: Real, high: Real, low: Real) -> None:
    """Constant number ``i``, which is ``rounded``, with a larger rounding error, if it is finite."""
    other = rounded + ((high - rounded) + low) * float(CONSTANTS)
    with f.when((other - other).equals(0.0)):
        f.store(other, "%constants", i)
