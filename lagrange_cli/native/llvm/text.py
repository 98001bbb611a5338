"""Operands of LLVM IR as text.

A value is the text of an operand (``%12`` or a hexadecimal constant), or None for a number known to be 0.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from fractions import Fraction
from typing import TypeAlias

from lagrange_cli.errors import BeyondDoubles

Operand: TypeAlias = str
Value: TypeAlias = str | None

ZERO: Operand = "0x0000000000000000"
ONE: Operand = "0x3FF0000000000000"


def literal(value: float | Fraction) -> Value:
    """A floating-point constant in LLVM's exact notation; None for 0. Raises ``BeyondDoubles``."""
    if value == 0.0:
        return None
    try:
        return "0x" + struct.pack(">d", value).hex().upper()
    except struct.error as error:  # a fraction that is no double
        raise BeyondDoubles from error


def opposite(constant: Operand) -> Operand:
    """A constant with the other sign."""
    return f"0x{int(constant, 16) ^ 1 << 63:016X}"


def operand(value: Value) -> Operand:
    """A value as an instruction needs it: 0 written out."""
    return ZERO if value is None else value


def kind(type: str, lanes: int) -> str:
    """The type of ``lanes`` of these."""
    return type if lanes == 1 else f"<{lanes} x {type}>"


def constant(type: str, lanes: int, value: object) -> str:
    """A constant in every lane."""
    one = operand(literal(value)) if isinstance(value, (int, float)) and type == "double" else str(value)
    return one if lanes == 1 else f"<{', '.join([f'{type} {one}'] * lanes)}>"


def suffix(lanes: int) -> str:
    """The suffix of LLVM's names for functions of them."""
    return "f64" if lanes == 1 else f"v{lanes}f64"


def fused(text: str) -> str:
    """``text`` with every ``fmuladd`` an ``fma``, which is rounded once."""
    return text.replace("@llvm.fmuladd.", "@llvm.fma.")


def table(name: str, row: Sequence[float], type: str = "i64") -> str:
    """Constant integers, or ones of type ``double``, of that name."""
    listed = (operand(literal(x)) if type == "double" else str(x) for x in row)
    return f"@{name} = private constant [{len(row)} x {type}] [{', '.join(f'{type} {x}' for x in listed)}]\n"


def tables(prefix: str, size: int) -> list[str]:
    """The numbers that stages of a loop need."""
    reciprocals = [0.0, *(1.0 / m for m in range(1, size))]
    return [
        table(f"{prefix}numbers", range(size), "double"),
        table(f"{prefix}reciprocals", reciprocals, "double"),
    ]
