"""Sums over the members of a family, with their loops and conditions."""

from __future__ import annotations

from lagrange_cli.expression.cursor import MAX_LOOPS, PARTS_HINT, SUM_EXAMPLE
from lagrange_cli.expression.lists import Lists
from lagrange_cli.expression.scan import Token
from lagrange_cli.expression.syntax import Loop, Name, Span, Sum, Tree
from lagrange_cli.expression.vocabulary import OR, RESERVED

_LOOP = "write 'for j in range(N)'"


class Sums(Lists):
    """Reads sums, the ranges of their indices, and their conditions."""

    def sum(self, token: Token) -> Tree:
        """``sum(body for i in range(N) if ... for ...)``."""
        opening = self.advance()
        self.deeper(opening)
        around, self.condition = (self.condition, self.loops), False
        self.another_loop(opening)
        body = self.expression(OR)
        loops = self.several_loops()
        if self.sees(","):
            self.refuse(self.next.span, "unexpected ',' in a sum", f"as in {SUM_EXAMPLE}")
        if loops and self.next.kind != "end" and not self.sees(")", "]"):
            self.unexpected([body])
        while self.next.kind != "end" and not self.sees(")", "]"):
            self.unexpected([body])
        self.close(opening)
        self.condition, self.loops = around
        self.depth -= 1
        span = Span(token.span.start, self.stop)
        if not loops:
            self.structural(span, "sum without a loop", "write sum(m[j]*x[j] for j in range(N))")
            return body
        for loop in reversed(loops):
            body = Sum(body, loop.index, loop.bounds, loop.conditions, span, loop.span)
        return body

    def several_loops(self, example: str = SUM_EXAMPLE) -> list[Loop]:
        """``for i in range(N) if ... for ...``, as far as there are any."""
        loops: list[Loop] = []
        while self.sees("for"):
            word = self.advance()
            if loops:
                self.another_loop(word)
            index, place = self.index()
            if self.sees("in"):
                self.advance()
            else:
                self.refuse(self.next.span, f"missing 'in' before '{self.next.text}'", f"as in {example}")
            loops.append(Loop(index, self.range(), self.conditions(), place))
        return loops

    def another_loop(self, token: Token) -> None:
        self.loops += 1
        if self.loops > MAX_LOOPS:
            self.refuse(token.span, f"sums are nested more than {MAX_LOOPS} deep", PARTS_HINT)

    def conditions(self) -> tuple[Tree, ...]:
        found = []
        while self.sees("if"):
            self.advance()
            self.condition = True
            found.append(self.expression(OR))
            if self.sees("="):
                self.refuse(self.next.span, "'=' is not a comparison", self.comparison())
            self.condition = False
        return tuple(found)

    def index(self) -> tuple[str, Span]:
        """The index of a loop."""
        token = self.next
        if self.sees("in") or token.kind == "end":
            self.refuse(token.span, f"missing name of the index before '{token.text}'", _LOOP)
        tree = self.operand()
        if not isinstance(tree, Name) or tree.indices or "." in tree.identifier:
            self.refuse(tree.span, "an index must be a name", _LOOP)
            raise AssertionError("unreachable")
        if tree.identifier in RESERVED:
            name = tree.identifier
            self.error(tree.span, f"the name '{name}' is reserved", f"call the index {name}_ or another name")
        return tree.identifier, tree.span

    def range(self) -> tuple[Tree, ...]:
        """The arguments of the range that an index runs through."""
        start = self.next
        if start.text != "range" or self.tokens[self.place + 1].text != "(":
            known = len(self.errors)
            tree = self.expression()
            del self.errors[known:]  # of what is no range, as in 1..3
            self.refuse(tree.span, "an index needs a range", _LOOP)
        self.advance()
        arguments = self.whole_numbers(self.advance())
        if not 1 <= len(arguments) <= 3:
            self.error(
                Span(start.span.start, self.stop),
                f"wrong number of arguments for 'range': {len(arguments)} instead of 1 to 3",
                "write range(N), or range(start, stop, step); stop itself is left out",
            )
        return arguments
