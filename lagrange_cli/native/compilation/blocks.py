"""Long stretches of straight code, cut into basic blocks.

Series are unrolled into straight code, tens of thousands of instructions long. At its lowest level LLVM
takes a time that grows with the square of the length of a basic block: it asks of each value whether it is
used later in its block. A block that ends early costs a few loads and stores.
"""

from __future__ import annotations

import re

LONGEST = 1000
"""Lines of a basic block."""
_LABEL = re.compile(r"([\w.$]+):")
_INSTRUCTION = re.compile(r"  (?:%[\w.]+ = (?!phi )|store )")


def with_short_blocks(text: str) -> str:
    """The same program in LLVM IR, whose blocks end after ``LONGEST`` lines."""
    functions = text.split("\ndefine ")
    return "\ndefine ".join(_cut(one) if one.count("\n") > LONGEST else one for one in functions)


def _cut(function: str) -> str:
    """One function with short blocks. A phi that names a block as its predecessor names its last piece."""
    lines: list[str] = []
    last: dict[str, str] = {}
    label, length, pieces = "", 0, 0  # the first block may have no label
    for line in function.split("\n"):
        if found := _LABEL.match(line):
            label, length = found[1], 0
        elif length >= LONGEST and _INSTRUCTION.match(line):
            pieces += 1
            last[label] = f"piece.{pieces}"
            lines += [f"  br label %{last[label]}", f"{last[label]}:"]
            length = 0
        length += 1
        lines.append(line)
    predecessor = re.compile(rf", %({'|'.join(map(re.escape, filter(None, last)))})(?= \])")
    renamed = (
        predecessor.sub(lambda found: f", %{last[found[1]]}", line) if " = phi " in line else line
        for line in lines
    )
    return "\n".join(renamed)
