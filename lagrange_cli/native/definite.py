"""Loops that solve with a large definite block of the mass matrix, eight rows at a time.

``@factor_definite`` (``linear.ll``) leaves D L^T in the upper triangle. ``@arrange_definite`` makes of it
what the solution reads in whole vectors: -L^T in the upper triangle, without its diagonal; -L in the blocks
of eight below; and the -L of the diagonal blocks behind the matrix. ``@solve_definite`` then needs no sum
across a vector, and a vector that it has written it reads as a whole.
"""

from __future__ import annotations

from collections.abc import Iterable

from lagrange_cli.native.interface import LANES
from lagrange_cli.native.template import fill_in

VECTOR = f"<{LANES} x double>"


def definite() -> str:
    """IR of ``@arrange_definite`` and ``@solve_definite``."""
    return fill_in(
        "definite",
        {
            "forward": _block("r", "%jp", "%stride", range(LANES)),
            "forward_trail": _trail("r", "%jp", "%stride"),
            "backward": _block("x", "%dp", str(LANES), reversed(range(LANES))),
            "backward_trail": _trail("x", "%mp", "%stride"),
        },
    )


def _splat(source: str, lane: int) -> str:
    lanes = ", ".join([f"i32 {lane}"] * LANES)
    return f"shufflevector {VECTOR} {source}, {VECTOR} poison, <{LANES} x i32> <{lanes}>"


def _fma(a: str, b: str, c: str) -> str:
    return f"call {VECTOR} @llvm.fmuladd.v8f64({VECTOR} {a}, {VECTOR} {b}, {VECTOR} {c})"


def _block(name: str, rows: str, stride: str, order: Iterable[int]) -> str:
    """``%NAME.end``: the triangular system of one block, from ``%NAME``; ``%NAME.T`` are its unknowns, each
    in all lanes."""
    lines, current = [], f"%{name}"
    for lane in order:
        here = f"%{name}.{lane}"
        lines += [
            f"  {here} = {_splat(current, lane)}",
            f"  {here}.o = mul i64 {stride}, {lane}",
            f"  {here}.p = getelementptr inbounds double, ptr {rows}, i64 {here}.o",
            f"  {here}.l = load {VECTOR}, ptr {here}.p, align 64",
            f"  {here}.n = {_fma(here, here + '.l', current)}",
        ]
        current = f"{here}.n"
    lines.append(f"  %{name}.end = fadd {VECTOR} {current}, zeroinitializer")
    return "\n".join(lines)


def _trail(name: str, rows: str, stride: str) -> str:
    """``%NAME.sum``: ``%NAME.old`` less what the block's unknowns add, from ``%NAME.column`` of its rows."""
    lines, totals = [], [f"%{name}.old", "zeroinitializer"]
    for lane in range(LANES):
        here = f"%{name}.t{lane}"
        lines += [
            f"  {here}.o = mul i64 {stride}, {lane}",
            f"  {here}.c = add i64 {here}.o, %{name}.column",
            f"  {here}.p = getelementptr inbounds double, ptr {rows}, i64 {here}.c",
            f"  {here}.l = load {VECTOR}, ptr {here}.p, align 64",
            f"  {here} = {_fma(f'%{name}.{lane}', here + '.l', totals[lane % 2])}",
        ]
        totals[lane % 2] = here
    lines.append(f"  %{name}.sum = fadd {VECTOR} {totals[0]}, {totals[1]}")
    return "\n".join(lines)
