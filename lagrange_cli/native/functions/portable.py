"""A program's text made the same on every machine: no function of the C library, every fma an explicit one.

All other operations are those of IEEE 754, in an order and in vectors of a width that the text fixes: they
have one result. The C library's functions differ in their last bits between releases and processors, and
``fmuladd`` is rounded once or twice, as the processor likes. Here it is always rounded once, by a call of C's
``fma`` where the processor has none.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence

from lagrange_cli.native.functions import elementary
from lagrange_cli.native.functions.double_double import functions
from lagrange_cli.native.functions.library import texts
from lagrange_cli.native.functions.payne_hanek import table, wide_functions
from lagrange_cli.native.llvm.declarations import LIBRARY, by_name, needed
from lagrange_cli.native.llvm.text import ZERO, fused
from lagrange_cli.native.numbers.double_double import TYPE as PAIR_TYPE
from lagrange_cli.native.numbers.double_double import operations

INTRINSICS = ("sin", "cos", "exp", "log", "pow", "log2", "exp2")
"""LLVM's functions that become calls of the C library."""
LIBM = re.compile(rf"@(?:llvm\.({'|'.join(INTRINSICS)})\.f64|({'|'.join(LIBRARY)}))\(")
TURNING = re.compile(r"  (%[\w.]+) = call double @llvm\.(sin|cos)\.f64\(double ([%\w.]+)\)")
ELEMENTARY = re.compile(r"^define [^@]*@(?:sin_cos|exp|log|pow)\.\d+\(.*?^}$", re.MULTILINE | re.DOTALL)
"""Functions of ``elementary``, which call the C library's beyond their range."""


def portable(text: str) -> str:
    """``text``, a program's, with functions of its own, so that every machine computes the same bits."""
    return self_contained(fused(text))


def self_contained(text: str) -> str:
    """``text``, a program's, without calls of the C library: the functions that it calls come with it."""
    known = library()
    text = ELEMENTARY.sub(lambda found: LIBM.sub(_beyond, found[0]), text)
    text = LIBM.sub(_own, "\n".join(together(text.split("\n"))))
    parts = [text, *needed(text, known)]
    if any("@two_over_pi" in part for part in parts):
        parts.insert(0, table())
    return "\n".join(parts)


def together(lines: Sequence[str]) -> Iterator[str]:
    """``lines``, but sine and cosine of one operand, where they are in one block, by one call."""
    made: dict[str, str] = {}
    for i, line in enumerate(lines):
        found = TURNING.fullmatch(line)
        if found is None:
            made = {} if line.endswith((":", "{")) else made
            yield line
            continue
        name, function, angle = found.groups()
        if angle not in made:
            made[angle] = f"%turned.{i}"
            yield f"  {made[angle]} = call {PAIR_TYPE} @sin_cos.1(double {angle}, double {ZERO})"
        yield f"  {name} = extractvalue {PAIR_TYPE} {made[angle]}, {int(function == 'cos')}"


def _own(call: re.Match[str]) -> str:
    return f"@portable.{call[1] or call[2]}("


def _beyond(call: re.Match[str]) -> str:
    return f"@beyond.{call[1] or call[2]}("


def library() -> Mapping[str, str]:
    """The text of every function that may be needed, by name."""
    made = [*texts(), *wide_functions()]
    for name in ("sin_cos", "exp", "log", "pow"):  # beyond their range these would call the C library
        made.append(LIBM.sub(_beyond, elementary.definition(name, 1)))
    made += [*operations(), *functions()]
    return by_name(LIBM.sub(_own, text) for text in made)
