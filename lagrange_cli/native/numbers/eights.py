"""Words of LLVM IR for vectors of eight doubles."""

from __future__ import annotations

from lagrange_cli.native.interface import LANES

VECTOR = f"<{LANES} x double>"


def splat(source: str, lane: int) -> str:
    """One lane of a vector, in all lanes."""
    return shuffle(source, "poison", [lane] * LANES)


def shuffle(a: str, b: str, lanes: list[int]) -> str:
    """Lanes of two vectors, those of the second one from 8 on."""
    listed = ", ".join(f"i32 {lane}" for lane in lanes)
    return f"shufflevector {VECTOR} {a}, {VECTOR} {b}, <{LANES} x i32> <{listed}>"


def fma(a: str, b: str, c: str) -> str:
    """``a * b + c``, lane by lane."""
    return f"call {VECTOR} @llvm.fmuladd.v8f64({VECTOR} {a}, {VECTOR} {b}, {VECTOR} {c})"
