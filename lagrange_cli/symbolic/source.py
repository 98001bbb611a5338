"""The equations as a Python module of plain functions over ``math``."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import sympy

from lagrange_cli.expression.vocabulary import CONSTANTS, FUNCTIONS
from lagrange_cli.symbolic.equations import Equations
from lagrange_cli.symbolic.hamilton import hamilton_form
from lagrange_cli.symbolic.notations import Python, identifiers
from lagrange_cli.symbolic.order import Order
from lagrange_cli.symbolic.render import render

ARGUMENTS = frozenset({"q", "v", "p", "parameters"})
"""Names of the functions' arguments: symbols with these names are renamed."""

SIGN = '''
def sign(x):
    """-1, 0 or 1."""
    return (x > 0) - (x < 0)
'''.strip()

ELIMINATION = '''
def accelerations(t, q, v, parameters=PARAMETERS):
    """q_ddot(t, q, v), by Gaussian elimination with partial pivoting of M a = f."""
    rows = [[*row, f] for row, f in zip(mass_matrix(t, q, v, parameters), force(t, q, v, parameters))]
    n = len(rows)
    for i in range(n):
        pivot = max(range(i, n), key=lambda k: abs(rows[k][i]))
        rows[i], rows[pivot] = rows[pivot], rows[i]
        for k in range(i + 1, n):
            factor = rows[k][i] / rows[i][i]
            rows[k] = [x - factor * y for x, y in zip(rows[k], rows[i])]
    a = [0.0] * n
    for i in reversed(range(n)):
        a[i] = (rows[i][n] - sum(rows[i][k] * a[k] for k in range(i + 1, n))) / rows[i][i]
    return tuple(a)
'''


def as_python(equations: Equations, form: str, parameters: Mapping[str, float]) -> str:
    """The module's source: L, momenta, h, mass matrix, force and accelerations as functions of (t, q, v).

    With the form ``hamilton`` also H and the canonical equations as functions of (t, q, p).
    """
    writer = ModuleWriter(equations)
    functions = []
    if equations.T is not None and equations.U is not None:
        functions.append(writer.scalar("kinetic_energy", "T(t, q, v).", equations.T))
        functions.append(writer.scalar("potential_energy", "U(t, q, v).", equations.U))
    functions += [
        writer.scalar("lagrangian", "L(t, q, v).", equations.L),
        writer.vector("momenta", "p_k = dL/dq_dot_k.", equations.momenta),
        writer.scalar("energy_function", "h = sum_k p_k q_dot_k - L.", equations.h),
        writer.vector("generalized_forces", "Q_k(t, q, v).", equations.generalized_forces),
        writer.matrix("mass_matrix", "M of M a = f: its rows.", equations.mass_matrix),
        writer.vector("force", "f of M a = f.", equations.force),
    ]
    if equations.accelerations is None:
        functions.append(ELIMINATION.strip())
    else:
        functions.append(writer.vector("accelerations", "q_ddot(t, q, v).", equations.accelerations))
    if equations.events:
        functions += event_functions(equations, writer)
    if form == "hamilton":
        canonical = hamilton_form(equations)
        writer = ModuleWriter(equations, canonical.order, canonical.p)
        functions += [
            writer.scalar("hamiltonian", "H(t, q, p).", canonical.H),
            writer.vector("velocities", "q_dot_k = dH/dp_k.", canonical.velocities),
            writer.vector("momentum_rates", "p_dot_k = -dH/dq_k + Q_k.", canonical.rates),
        ]
    body = "\n\n\n".join(functions)
    used = sorted(name for name in {*FUNCTIONS, *CONSTANTS} if re.search(rf"\b{name}\b", body))
    if re.search(r"\bsign\(", body):
        body = f"{SIGN}\n\n\n{body}"
    head = [
        f'"""{plain(equations.name)}: equations of motion.',
        "",
        "t is the time; q, v and p are sequences in the order of COORDINATES; parameters is a mapping",
        'like PARAMETERS."""',
        "",
        *([f"from math import {', '.join(used)}", ""] if used else []),
        f"COORDINATES = {sequence([repr(name) for name in equations.coordinates])}",
        f"PARAMETERS = {dict(parameters)!r}",
    ]
    if equations.events:
        head.append(f"EVENTS = {sequence([repr(each.name) for each in equations.events])}")
        head.append(f"DIRECTIONS = {sequence([str(each.direction) for each in equations.events])}")
    return "\n".join(head) + "\n\n\n" + body


def event_functions(equations: Equations, writer: ModuleWriter) -> list[str]:
    """What becomes 0 at the events, and for each that sets something the state after it."""
    arguments = [each.when for each in equations.events]
    found = [writer.vector("events", "What becomes 0 at each of EVENTS, in one of DIRECTIONS.", arguments)]
    names = identifiers(each.name for each in equations.events)
    for each in equations.events:
        if each.changes:
            purpose = f"q, v and parameters after the event {each.name!r}, of those before."
            found.append(writer.after(f"after_{names[each.name]}", purpose, each.changes))
    return found


def plain(name: str) -> str:
    """The name, made safe for a docstring."""
    return " ".join(name.replace("\\", "/").replace('"', "'").split())


def sequence(items: Sequence[str]) -> str:
    """The source of a tuple."""
    return f"({', '.join(items)}{',' if len(items) == 1 else ''})"


class ModuleWriter:
    """Writes functions of (t, q, v), or of (t, q, p) with momenta given."""

    def __init__(
        self, equations: Equations, order: Order | None = None, p: Sequence[sympy.Expr] | None = None
    ) -> None:
        self.equations = equations
        self.order = order or equations.order
        self.fast = "v" if p is None else "p"
        self.fast_symbols = equations.v if p is None else tuple(p)
        self.notation = Python(identifiers(map(str, self.order.ranks), ARGUMENTS))

    def scalar(self, name: str, purpose: str, expression: sympy.Expr) -> str:
        """A function that returns one number."""
        return self.function(name, purpose, self.text(expression), [expression])

    def vector(self, name: str, purpose: str, expressions: Sequence[sympy.Expr]) -> str:
        """A function that returns a tuple, one entry for each coordinate."""
        result = "(\n" + "".join(f"        {self.text(each)},\n" for each in expressions) + "    )"
        return self.function(name, purpose, result, expressions)

    def matrix(self, name: str, purpose: str, rows: Sequence[Sequence[sympy.Expr]]) -> str:
        """A function that returns a tuple of rows."""
        lines = "".join(f"        {sequence([self.text(entry) for entry in row])},\n" for row in rows)
        return self.function(name, purpose, f"(\n{lines}    )", [entry for row in rows for entry in row])

    def after(self, name: str, purpose: str, changes: Mapping[str, sympy.Expr]) -> str:
        """A function that returns q, v and parameters after some of them have changed."""
        rows = [
            [changes.get(str(symbol), symbol) for symbol in row]
            for row in (self.equations.q, self.equations.v)
        ]
        set_ = {key: value for key, value in changes.items() if key in self.equations.parameters}
        texts = [sequence([self.text(entry) for entry in row]) for row in rows]
        own = "".join(f", {key!r}: {self.text(value)}" for key, value in set_.items())
        result = f"{texts[0]}, {texts[1]}, {{**parameters{own}}}"
        return self.function(name, purpose, result, [*rows[0], *rows[1], *set_.values()])

    def function(self, name: str, purpose: str, result: str, expressions: Sequence[sympy.Expr]) -> str:
        """``def name(t, q, v, parameters=PARAMETERS)``, which names what it uses and nothing else."""
        used = set().union(*(expression.free_symbols for expression in expressions))
        lines = [f"def {name}(t, q, {self.fast}, parameters=PARAMETERS):", f'    """{purpose}"""']
        for source, symbols in (("q", self.equations.q), (self.fast, self.fast_symbols)):
            for index, symbol in enumerate(symbols):
                if symbol in used:
                    lines.append(f"    {self.text(symbol)} = {source}[{index}]")
        for key, symbol in self.equations.parameters.items():
            if symbol in used:
                lines.append(f"    {self.text(symbol)} = parameters[{key!r}]")
        return "\n".join([*lines, f"    return {result}"])

    def text(self, expression: sympy.Expr) -> str:
        return render(expression, self.notation, self.order)
