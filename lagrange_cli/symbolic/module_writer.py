"""The functions of a Python module, written one by one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import sympy

from lagrange_cli.symbolic.equations import Equations
from lagrange_cli.symbolic.notations import Python, identifiers
from lagrange_cli.symbolic.order import Order
from lagrange_cli.symbolic.render import render

ARGUMENTS = frozenset({"q", "v", "p", "parameters", "multipliers", "velocities", "accelerations"})
"""Names of the functions' arguments, and of functions that they call: symbols of these names are renamed."""


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
        if not used.isdisjoint(self.equations.a):
            names = sequence([self.text(symbol) for symbol in self.equations.a])
            lines.append(f"    {names} = accelerations(t, q, v, parameters)")
        constraints = self.equations.constraints
        if not used.isdisjoint(each.multiplier for each in constraints):
            v = "v" if self.fast == "v" else "velocities(t, q, p, parameters)"
            call = f"multipliers(t, q, {v}, parameters)"
            bound = [self.text(each.multiplier) if each.acts else "_" for each in constraints]
            lines.append(f"    {sequence(bound)} = {call}")
        return "\n".join([*lines, f"    return {result}"])

    def text(self, expression: sympy.Expr) -> str:
        return render(expression, self.notation, self.order)
