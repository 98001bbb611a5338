"""The declarations that a program's text needs to be compiled: functions that it calls, and their
attributes."""

from __future__ import annotations

import re

INTRINSICS = "sin", "cos", "exp", "log", "pow", "sqrt", "fabs", "floor"
"""Functions of the expression language, and parts of them, that LLVM has as its own."""
LIBRARY = {
    "tan": 1, "asin": 1, "acos": 1, "atan": 1, "sinh": 1, "cosh": 1, "tanh": 1, "atan2": 2,
}  # fmt: skip
"""Functions of the C library, and the numbers of their arguments."""

ATTRIBUTES = 'attributes #0 = { nounwind "min-legal-vector-width"="512" "prefer-vector-width"="512" }'

TYPE = r"(?:<\d+ x \w+>|\w+)"
CALL = re.compile(rf"call (?:nnan )?({TYPE}) @(llvm\.[\w.]+|{'|'.join(LIBRARY)})\((.*)\)$", re.MULTILINE)
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
