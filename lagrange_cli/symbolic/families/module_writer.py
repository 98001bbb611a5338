"""The functions of a Python module with loops over members, written one by one."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import prod

import sympy

from lagrange_cli.expression.vocabulary import acceleration_name, velocity_name
from lagrange_cli.spec.spec import Family
from lagrange_cli.symbolic.families.equations import FamilyEquations
from lagrange_cli.symbolic.families.event_source import placed
from lagrange_cli.symbolic.families.given import multiplier_name
from lagrange_cli.symbolic.families.hamilton import momentum_name
from lagrange_cli.symbolic.families.linear import pairs_of
from lagrange_cli.symbolic.families.lines import Line
from lagrange_cli.symbolic.indexed.conditions import Loop, written
from lagrange_cli.symbolic.notations import IndexedPython, python_index, python_name
from lagrange_cli.symbolic.render import render

SIGNATURE = "t, {}, parameters=PARAMETERS"
RATES: Mapping[str, Callable[[str], str]] = {
    "q": str,
    "v": velocity_name,
    "a": acceleration_name,
    "p": momentum_name,
}
"""The arguments of functions, and the names of their members in terms of coordinates."""
MULTIPLIERS = "multipliers"
"""The argument with those of constraints."""
PLACES = "PLACES"
"""The places of the constraints, where members of their families are missing."""


class ModuleWriter:
    """Writes functions of (t, q, v), with loops over members."""

    def __init__(self, equations: FamilyEquations) -> None:
        self.equations = equations
        shapes: dict[str, Sequence[str]] = {}
        self.parameters = [one for one in equations.parameters if one.name not in equations.tables]
        for family in (*equations.coordinates, *self.parameters):
            shapes[family.name] = [str(size) for size in family.shape]
            for rate in RATES.values():
                shapes[rate(family.name)] = shapes[family.name]
        for family in equations.bound:
            shapes[multiplier_name(family.name)] = [str(size) for size in family.shape]
        shapes |= {one.name: [str(len(one.table))] * 2 for one in equations.paths}
        shapes |= {one.base: [str(size) for size in one.shape] for one in equations.places}
        self.shapes, self.notation = shapes, IndexedPython(shapes)
        self.used: set[str] = set()
        self.order = equations.order

    def text(self, expression: sympy.Expr) -> str:
        """An expression of Python."""
        made = render(expression, self.notation, self.order)
        self.used |= {one.func.__name__ for one in expression.atoms(sympy.Function)}
        self.used |= {"sqrt"} if "sqrt(" in made else set()
        self.used |= {"pi"} if expression.has(sympy.pi) else set()
        self.used |= {"exp"} if "exp(" in made else set()
        return made

    def names(self, text: str, rates: Sequence[str] = ("q", "v")) -> list[str]:
        """The lines in which what ``text`` uses gets its name; ``rates`` are coordinates, velocities and so
        on."""
        places = []
        for one in self.equations.places:
            if self.has(text, one.base):
                loops = " ".join(f"for {self.head(loop)}" for loop in one.loops)
                places.append(f"    {one.base} = [{self.text(one.expression)} {loops}]")
        text = "\n".join([text, *places])
        found = []
        for family in self.parameters:
            if family.shape:
                listed = f"[parameters[f'{family.name}[{{k}}]'] for k in range({family.shape[0]})]"
                if len(family.shape) > 1:
                    listed = f"[parameters[k] for k in {family.members!r}]"
            else:
                listed = f"parameters[{family.name!r}]"
            found.append((family.name, listed))
        first = 0
        for family in self.equations.coordinates:
            stop = first + prod(family.shape)
            for array in (one for one in rates if one in RATES):
                place = f"{array}[{first}:{stop}]" if family.shape else f"{array}[{first}]"
                found.append((RATES[array](family.name), place))
            first = stop
        first = grid = 0
        for family in self.equations.bound if MULTIPLIERS in rates else ():
            stop = first + len(family.members)
            place = f"[{first}:{stop}]" if family.shape else f"[{first}]"
            listed = MULTIPLIERS + place
            if not family.complete:
                listed = f"{{k - {grid}: x for k, x in zip({PLACES}{place}, {listed})}}"
            found.append((multiplier_name(family.name), listed))
            first, grid = stop, grid + prod(family.shape)
        shown = [(self.notation.symbol(name), value) for name, value in found]
        return [f"    {name} = {value}" for name, value in shown if self.has(text, name)] + places

    @staticmethod
    def has(text: str, name: str) -> bool:
        """Whether a name stands in a text."""
        import re

        return re.search(rf"\b{name}\b", text) is not None

    def scalar(
        self, name: str, purpose: str, expression: sympy.Expr, rates: Sequence[str] = ("q", "v")
    ) -> str:
        """A function with one value."""
        text = self.text(expression)
        body = [*self.names(text, rates), f"    return {text}"]
        return "\n".join(
            [f"def {name}({SIGNATURE.format(', '.join(rates))}):", f'    """{purpose}"""', *body]
        )

    def vector(
        self, name: str, purpose: str, lines: Sequence[Line], rates: Sequence[str] = ("q", "v"),
        among: Sequence[Family] = (), places: str = PLACES,
    ) -> str:  # fmt: skip
        """A function with a value for each coordinate, or each member of other families."""
        body: list[str] = []
        first = 0
        for family in among or self.equations.coordinates:
            for line in (one for one in lines if one.family.name == family.name):
                body += self.assigned(line, first, family)
            first += prod(family.shape)
        names = self.names("\n".join(body), rates)
        head = [f"def {name}({SIGNATURE.format(', '.join(rates))}):", f'    """{purpose}"""', *names]
        whole = all(one.complete for one in among)
        made = "tuple(values)" if whole else f"tuple(values[k] for k in {places})"
        return "\n".join([*head, f"    values = [0.0] * {first}", *body, f"    return {made}"])

    def matrix(self) -> str:
        """A function with the rows of M."""
        firsts, first = {}, 0
        for family in self.equations.coordinates:
            firsts[family.name] = first, family
            first += prod(family.shape)
        body = list[str]()
        pairs = pairs_of(self.equations.coordinates)
        for line in self.equations.masses or ():
            (row, one), (column, other) = (firsts[family.name] for family in pairs[line.family.name])
            indices = line.indices[: len(one.shape)], line.indices[len(one.shape) :]
            i, k = placed(row, one, indices[0]), placed(column, other, indices[1])
            head, indent = self.loops(line.loops)
            body += [*head, f"{indent}rows[{i}][{k}] = rows[{k}][{i}] = {self.text(line.expression)}"]
        names = self.names("\n".join(body))
        head = [
            f"def mass_matrix({SIGNATURE.format('q, v')}):",
            '    """M in M a = f, row by row."""',
            *names,
        ]
        head.append(f"    rows = [[0.0] * {first} for _ in range({first})]")
        return "\n".join([*head, *body, "    return tuple(map(tuple, rows))"])

    def assigned(self, line: Line, first: int, family: Family) -> list[str]:
        """What sets the values of some members."""
        head, indent = self.loops(line.loops)
        return [
            *head,
            f"{indent}values[{placed(first, family, line.indices)}] = {self.text(line.expression)}",
        ]

    def loops(self, loops: Sequence[Loop], indent: str = "    ") -> tuple[list[str], str]:
        """Loops through members, and the indent of what is in them."""
        found = []
        for loop in loops:
            found.append(f"{indent}for {self.head(loop)}:")
            indent += "    "
            for one in loop.conditions:
                found += [f"{indent}if not ({python_index(written(one))}):", f"{indent}    continue"]
        return found, indent

    @staticmethod
    def head(loop: Loop) -> str:
        """``i in range(N)``."""
        return f"{python_name(loop.index)} in range({python_index(loop.bounds)})"
