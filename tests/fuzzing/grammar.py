"""System files from a grammar: most are right or nearly so, some are hostile, and any of them may be damaged.

Every choice is made by the ``random.Random`` that is handed over: hypothesis and the fuzzer bring their own.
"""

from __future__ import annotations

from random import Random

NUMBERS = ("0", "1", "2.5", "-1", "0.1", "1e-3", "9.81", "pi", "1/3")
EXTREME = (
    "1e308", "-1e300", "1e-308", "4e-324", "1e999", ".inf", ".nan", "0x10", "1_000", "007", "true", "''",
    "10000000000", "-0.0", "1e200*1e200", "9**9**9", "(-1)**0.5", "1/0", "0**-1", "log(0)", "1e-300",
)  # fmt: skip
FUNCTIONS = (
    "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "exp", "log", "sqrt",
)  # fmt: skip
CASES = (
    "where({0} > {1}, {2}, 0)", "where({0} <= 1 and not {1} > 0, {1}, {2})", "where({1} < {0} < {2}, {0}, 1)",
)  # fmt: skip
HOSTILE = (
    "__import__('os').system('touch hacked')", "().__class__.__mro__", "lambda: 0", "x" * 300,
    "bead.__class__", "open('/etc/passwd')", "!!python/object/apply:os.system [touch hacked]", "*a",
    "&a [*a]", "<<", "\u202e", "(" * 150 + "1" + ")" * 150, "-" * 200 + "1", "x**64*y**64",
    "sum(1 for i in range(1000000000))", "sum(sum(x for i in range(9999)) for j in range(9999))",
    "(x + 1)**64*(y + 1)**64", "1/(x - x)", "x[10**9]", "'w[i in range(1000000)]': {initial: 0}",
    "{a: [b, {c: d}]}", "'", '"', "|", "\t", "---", "...", "\0", "\ufeff", "%YAML 9.9", "eval(x)",
)  # fmt: skip
PIECES = (
    *NUMBERS, *EXTREME, *(f"{name}(" for name in FUNCTIONS), *HOSTILE, "(", ")", "[", "]", "{", "}", ",", ":",
    "\n", "\n  ", " for i in range(N)", " if i != 0", "[i]", "[i + 1]", "[i in range(N)]", "N", "x", "y",
    "x_dot", "bead", "bead.x", "bead.vy", " + ", "-", "*", "**", "/", "%", "//", "t", "m", "sizes: {N: 3}\n",
    "solve: {stop: 1e300, step: 1e-300}\n", "samples: 1000000000000", "lagrangian: ", "null", "~", "#", "<",
    "dissipation: x_dot**2\n", "generalized_forces: {x: -x_dot}\n", "definitions: {u: x}\n", ">=", "sum(",
)  # fmt: skip
PLACES = ("x", "y", "u", "t")
VELOCITIES = ("x_dot", "y_dot")
PARAMETERS = ("m", "k", "c[0]", "c[1]")


def system(source: Random) -> str:
    """The text of a system file."""
    sections = [
        f"parameters: {{m: {number(source)}, k: {number(source)}, c: [1, {number(source)}]}}\n",
        f"coordinates:\n  x: {{initial: {number(source)}, velocity: {number(source)}}}\n"
        f"  y: {{initial: {number(source)}}}\n",
        f"definitions:\n  u: {expression(source, (*PARAMETERS, 'x', 'y', 't'))}\n",
    ]
    if source.random() < 0.3:
        kinetic = "m*x_dot**2 + y_dot**2" + source.choice(("", "/x**2", "*cosh(x)", " + x_dot*y_dot*u"))
        everything = (*PLACES, *VELOCITIES, *PARAMETERS)
        sections.append(f"lagrangian: {kinetic} - ({expression(source, everything)})\n")
    else:
        places = (*PLACES, *PARAMETERS)
        vector = ", ".join(f'"{expression(source, places)}"' for _ in range(source.choice((1, 2, 3, 3))))
        moving = (
            *places,
            *VELOCITIES,
            "bead.x",
            "other.y",
            "bead.vx",
            "norm(bead - bead/2)",
            "dot(other, other)",
        )
        sections[-1] += f"  w: {expression(source, moving)}\n  s: bead.vx*w\n"
        sections += [
            "masses: {bead: m, other: 1}\n",
            f"embedding:\n  bead: [{vector}]\n  other: [x, y]\n",
            f"potential: {expression(source, (*places, 'bead.x', 'other.y', 'w', 's', *VELOCITIES[:1]))}\n",
        ]
    sections += [
        text
        for text in (
            f"solve: {{stop: {number(source)}, samples: {source.choice((2, 5, 10**12))}}}\n",
            f"generalized_forces: {{x: {expression(source, (*PLACES, *VELOCITIES))}}}\n",
            f"dissipation: {expression(source, VELOCITIES)}\n",
            f"observables: {{o: {expression(source, (*PLACES, *VELOCITIES, *PARAMETERS))}}}\n",
        )
        if source.random() < 0.3
    ]
    if source.random() < 0.05:
        sections.pop(source.randrange(len(sections)))
    if source.random() < 0.3:
        source.shuffle(sections)
    text = "".join(sections)
    for _ in range(source.choice((0, 0, 0, 0, 1, 1, 2, 5))):
        text = damaged(source, text)
    return text


def damaged(source: Random, text: str) -> str:
    """The text with one stretch of it replaced by another piece, or by a piece of itself."""
    place, length = source.randrange(len(text) + 1), source.choice((0, 0, 1, 2, 5, 20))
    other, copied = source.randrange(len(text) + 1), source.choice((1, 8, 40))
    piece = source.choice((source.choice(PIECES), text[other : other + copied]))
    return text[:place] + piece + text[place + length :]


def number(source: Random) -> str:
    """Most are harmless."""
    return source.choice(EXTREME if source.random() < 0.02 else NUMBERS)


def expression(source: Random, names: tuple[str, ...], depth: int = 3) -> str:
    """An expression in these names."""
    if depth == 0 or source.random() < 0.2:
        if source.random() < 0.02:
            return source.choice(HOSTILE)
        return source.choice(names) if source.random() < 0.7 else number(source)
    kind = source.random()
    first = expression(source, names, depth - 1)
    if kind < 0.25:
        return f"{source.choice(FUNCTIONS)}({first})"
    if kind < 0.3:
        second, third = (expression(source, names, depth - 2 if depth > 1 else 0) for _ in range(2))
        call = source.choice(("abs({0})", "sign({0})", "min({0}, {1})", "max({0}, {1}, {2})", *CASES))
        return call.format(first, second, third)
    if kind < 0.45:
        return f"({first})**{source.choice(('2', '3', '-1', '0.5', '-2', '63', 'x', '1/3'))}"
    return f"({first}){source.choice('++--**/')}({expression(source, names, depth - 1)})"
