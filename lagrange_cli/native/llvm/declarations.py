"""What a program's text needs to be compiled: the functions that it calls, declared or with their texts."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

INTRINSICS = "sin", "cos", "exp", "log", "pow", "sqrt", "fabs", "floor"
"""Functions of the expression language, and parts of them, that LLVM has as its own."""
LIBRARY = {
    "tan": 1, "asin": 1, "acos": 1, "atan": 1, "sinh": 1, "cosh": 1, "tanh": 1, "atan2": 2,
}  # fmt: skip
"""Functions of the C library, and the numbers of their arguments."""

ATTRIBUTES = 'attributes #0 = { nounwind "min-legal-vector-width"="512" "prefer-vector-width"="512" }'

TYPE = r"(?:<\d+ x \w+>|\w+)"
CALL = re.compile(rf"call (?:nnan )?({TYPE}) @(llvm\.[\w.]+|{'|'.join(LIBRARY)})\((.*)\)$", re.MULTILINE)
DEFINED = re.compile(r"^define [^@]*@([\w.]+)\(", re.MULTILINE)
CALLED = re.compile(r"@([\w.]+)\(")
ARGUMENT = re.compile(rf"({TYPE}) (?:<[^>]*>|[^,]*)")


def complete(text: str) -> str:
    """A program's text with declarations of the functions of LLVM and of the C library that it calls."""
    called = {name: (result, given) for result, name, given in CALL.findall(text)}
    heads = [
        f"declare {result} @{name}({', '.join(ARGUMENT.findall(given))})"
        + ("" if name.startswith("llvm.") else " memory(none)")
        for name, (result, given) in called.items()
    ]
    return "\n".join([*heads, text, ATTRIBUTES])


def by_name(texts: Iterable[str]) -> dict[str, str]:
    """The texts of functions by their names."""
    return {DEFINED.findall(text)[0]: text for text in texts}


def needed(text: str, known: Mapping[str, str]) -> list[str]:
    """The texts of those ``known`` functions that ``text`` calls and lacks, and of those that these call."""
    parts, found, pending = list[str](), set(DEFINED.findall(text)), [text]
    while pending:
        for name in sorted(set(CALLED.findall(pending.pop())) & known.keys() - found):
            found.add(name)
            parts.append(known[name])
            pending.append(known[name])
    return parts
