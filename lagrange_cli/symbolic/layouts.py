"""Pages for people: plain text and unicode."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from textwrap import wrap as wrapped

from lagrange_cli.spec.spec import freedom
from lagrange_cli.symbolic.equations import Equations
from lagrange_cli.symbolic.notations import Text, Unicode
from lagrange_cli.symbolic.report import sections
from lagrange_cli.symbolic.statements import Section, Statement
from lagrange_cli.symbolic.work import charge

WIDTH = 100
"""The column at which a sum is continued on the next line."""
FAR = 1000
"""The number of characters that are searched for a sign of the outermost sum."""
SHORT = 30
"""The number of characters in parentheses that are rather not broken."""
FACTOR = re.compile(r"[*/]\w*\(")
ARROW = re.compile(r" (?:->|→) ")
SETS = re.compile(r"(?<=,) (?=\S+ (?:->|→) )")
"""Between what an event sets."""
CHARACTERS_A_STEP = 5
OPENING = re.compile(r"(?:\w+ = )? ?\[+")
"""What is before the first entry of a row."""


def as_text(equations: Equations, form: str) -> str:
    """Plain ASCII; system files and sympy accept every expression."""
    return page(equations, sections(equations, form, Text()))


def as_unicode(equations: Equations, form: str) -> str:
    """Greek letters, dots and superscripts."""
    return page(equations, sections(equations, form, Unicode()))


def page(equations: Equations, content: Iterable[Section]) -> str:
    """The sections in sequence."""
    free = freedom(equations.degrees_of_freedom, equations.first_order)
    return lines_of(equations.name, free, content)


def lines_of(name: str, free: str, content: Iterable[Section]) -> str:
    """The sections in sequence, below a title: a name, and the degrees of freedom in words."""
    lines = [f"{name}: {free}"]
    for section in content:
        lines += ["", section.title]
        for statement in section.statements:
            lines += sentence(statement) if section.verbal else formula(statement)
    return "\n".join(lines)


def formula(statement: Statement) -> list[str]:
    """``left = right``, followed by the remark."""
    remark = f"   [{statement.remark}]" if statement.remark else ""
    return wrap(f"{statement.left} = {statement.right}{remark}")


def sentence(statement: Statement) -> list[str]:
    """``left: remark``, or ``left = right`` with the remark below it."""
    if not statement.right:
        return said(": ".join(filter(None, (statement.left, statement.remark))))
    below = ["  " + line for line in said(statement.remark, WIDTH - 2)]
    return [*wrap(f"{statement.left} = {statement.right}"), *below]


def said(text: str, width: int = WIDTH) -> list[str]:
    """Words, indented; what an event sets is broken where it is long, between its values first of all."""
    if len(text) + 2 <= width:
        return ["  " + text]
    if not ARROW.search(text):
        return wrapped(
            text, width, initial_indent="  ", subsequent_indent="    ",
            break_long_words=False, break_on_hyphens=False,
        )  # fmt: skip
    parts = enumerate(SETS.split(text))
    return ["  " * (i > 0) + line for i, one in parts for line in wrap(one)]


def wrap(text: str) -> list[str]:
    """The text, indented; a long sum is broken before the signs between its terms."""
    if "\n" in text:  # a matrix
        first, *others = text.split("\n")
        margin = " " * (first.index("[") + 2)
        rows = [("  ", first), *((margin, line) for line in others)]
        return [indent + line for one in rows for indent, line in row_lines(*one)]
    lines = [*broken(text, "  ", " " * 6)]
    for deeper in (10, 14) if " for " in text else ():  # sums over indices, and what is in parentheses there
        lines = [
            part
            for indent, line in lines
            for part in broken(line, indent, " " * max(deeper, len(indent)), within_sums=True)
        ]
    return [indent + line for one in lines for indent, line in shortened(*one)]


def shortened(indent: str, line: str) -> Iterator[tuple[str, str]]:
    """The same, broken in arguments of functions where it is too long still."""
    yield from broken(line, indent, " " * max(10, len(indent) + 4), within_functions=True)


def row_lines(indent: str, row: str) -> Iterator[tuple[str, str]]:
    """The lines of a row of a matrix, each with its indentation: broken between entries first of all."""
    opening = OPENING.match(row)
    begin = 0 if opening is None else opening.end()
    depth, start, place, further = 0, 0, 0, indent + " " * max(begin, 1)
    parts = list[tuple[str, str]]()
    for index, character in enumerate(row[begin:], begin):
        depth += (character in "([") - (character in ")]")
        last = index + 1 == len(row)
        if last or (depth == 0 and row.startswith(", ", index)):  # no comma of u₁,₂
            if place > start and len(indent) + index + 1 - start > WIDTH:
                parts.append((indent, row[start:place].rstrip()))
                indent, start = further, place
            place = index + 2
    parts.append((indent, row[start:]))
    for margin, part in parts:
        for one in broken(part, margin, further + "    "):
            yield from shortened(*one)


def broken(
    text: str, indent: str, further: str, *, within_sums: bool = False, within_functions: bool = False
) -> Iterator[tuple[str, str]]:
    """The lines of a text, each with its indentation."""
    start = 0
    within = {"within_sums": within_sums, "within_functions": within_functions}
    while len(indent) + len(text) - start > WIDTH and (
        place := break_place(text, start, WIDTH - len(indent), **within)
    ):
        yield indent, text[start:place].rstrip()
        indent, start = further, place
    yield indent, text[start:]


def break_place(
    text: str, start: int, width: int, *, within_sums: bool = False, within_functions: bool = False
) -> int:
    """Where to break what follows ``start``: before the last sign of the outermost sum within ``width``, or
    else the first one beyond it; 0 where there is none. If ``within_functions``, arguments of functions are
    broken, and signs that are further in, rather than beyond ``width``; those of sums over indices are if
    ``within_sums``, also before their loops.

    Signs within ``width`` are the outermost if there are none further out in the next ``FAR`` characters.
    Those in short parentheses count as further in, and where there are none outside of parentheses, a break
    between factors in these goes before.
    """
    opened: list[tuple[bool, int]] = []
    places: list[tuple[int, int]] = []
    factors: list[int] = []
    index, outermost = start, len(text)
    for index in range(start, len(text)):
        if places and (index > start + FAR or (index > start + width and outermost == 0)):
            break
        character = text[index]
        if character in "([":
            of_function = index > start and (text[index - 1].isalnum() or text[index - 1] == "√")
            kept = of_function and not within_functions
            kept = kept and not (within_sums and text.endswith("sum", start, index))
            opened.append((kept, index))
        elif character in ")]" and opened:
            _, begun = opened.pop()
            if index - begun < SHORT:
                places = [(depth + len(text) * (place > begun), place) for depth, place in places]
        elif character in ")]":  # opened on an earlier line: what was before it is further in than the rest
            places = [(depth + 1, place) for depth, place in places]
            outermost += 1
        elif character in "*/" and not opened and text[index - 1] == ")" and FACTOR.match(text, index):
            factors.append(index)
        elif (
            (character in "+-−" or (within_sums and text.startswith("for ", index)))
            and index > start + 3
            and text[index - 1] == " "
            and (text[index + 1] == " " or character == "f")
            and not any(kept for kept, _ in opened)
        ):
            places.append((len(opened), index))
            outermost = min(outermost, len(opened))
    charge(1 + (index - start) // CHARACTERS_A_STEP)
    outermost = min((depth for depth, _ in places), default=0)
    before = [place for place in factors if width // 3 < place - start <= width]
    if outermost > 0 and before:
        return before[-1]
    fitting = [(depth, place) for depth, place in places if place <= start + width]
    if within_functions and fitting:
        outermost = min(fitting)[0]
    candidates = [place for depth, place in places if depth == outermost]
    return max((place for place in candidates if place <= start + width), default=min(candidates, default=0))
