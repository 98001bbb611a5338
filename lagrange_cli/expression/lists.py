"""Expressions with commas between them: groups, vectors and arguments, and what closes them."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod

from lagrange_cli.expression.cursor import CONDITION_HINT, SUM_EXAMPLE, WHERE_EXAMPLE, Cursor
from lagrange_cli.expression.scan import Token
from lagrange_cli.expression.syntax import Number, Span, Tree, Vector
from lagrange_cli.expression.vocabulary import CALLABLE, OR, SUM

EXAMPLE = f"as in {SUM_EXAMPLE}"
_CLOSES = {"(": ")", "[": "]"}


class Lists(Cursor, ABC):
    """Reads groups and lists; the expressions in them are read by a subclass, so that imports go one way."""

    @abstractmethod
    def expression(self, least: int = SUM) -> Tree:
        """An expression of operators that bind at least so tightly."""

    @abstractmethod
    def operand(self) -> Tree:
        """A number, a name, a call, a group, or one of these with a sign before it."""

    def items(self, closing: str, first: bool = False) -> tuple[list[Tree], bool]:
        """Expressions with commas between them up to ``closing`` or the end, and whether there is a comma.

        With ``first``, only the first one may be a condition.
        """
        found: list[Tree] = []
        comma = False
        while self.next.kind != "end" and not (closing and self.sees(")", "]")):
            if self.sees(")", "]"):
                self.unopened(self.next)
                self.advance()
                continue
            found.append(self.expression(OR))
            if self.sees(","):
                comma = True
                self.advance()
                self.condition = self.condition and not first
                if self.sees(","):
                    self.missing()
                    self.advance()
            elif self.next.kind != "end" and not self.sees(")", "]"):
                self.unexpected(found)
        if not found and not closing:
            found.append(self.missing())
        return found, comma

    def enclosing(self, token: Token) -> int:
        """The place in the text of the innermost bracket that is open before a token; -1 if there is none."""
        before, depth = self.text[: token.span.start - self.offset], 0
        for place in range(len(before) - 1, -1, -1):
            depth += (before[place] in ")]") - (before[place] in "([")
            if depth < 0:
                return place
        return -1

    def closes(self, place: int) -> bool:
        """Whether the bracket at a place in the text has its counterpart."""
        depth = 0
        for character in self.text[place + 1 :]:
            depth += (character in "([") - (character in ")]")
            if depth < 0:
                return character == _CLOSES[self.text[place]]
        return False

    def loop_outside(self, token: Token) -> None:
        """Report a loop that no sum has: in the parentheses of something else, or in an open index."""
        place = self.enclosing(token)
        called = re.search(r"[^\W\d][\w.]*\s*$", self.text[: max(place, 0)])
        if called and self.text[place] == "[" and not self.closes(place):
            start = place + self.offset
            self.refuse(Span(start, start + 1), "unclosed '['", "add a ']'")
            return
        name = called.group().strip() if called else ""
        hint = EXAMPLE
        if name.lower() in ("prod", "product"):
            hint = "there are no products over an index: write the factors out, or exp(sum(log(...)))"
        elif name not in ("", *CALLABLE):
            hint = f"write sum(...) for {name}(...)"
        self.refuse(token.span, f"'{token.text}' outside a sum", hint)

    def comparison(self) -> str:
        """What to write in place of the sign ``=`` that is next: <= for =<, >= for =>."""
        end = self.next.span.stop - self.offset
        following = self.text[end : end + 1]
        return f"write {following}=" if following in ("<", ">") else "write =="

    def unexpected(self, found: list[Tree]) -> None:
        """Report a token that cannot stand after an expression, and skip it."""
        token = self.next
        if self.sees("="):
            if self.condition:
                self.structural(token.span, "'=' is not a comparison", self.comparison())
            else:
                left = self.text[: token.span.start - self.offset].strip()
                hint = f"leave out '{left} ='" if len(left) < 40 else "write only the right-hand side"
                self.structural(token.span, "'=' is not allowed", hint)
            del found[-1:]  # the left-hand side only names the quantity
        elif token.text == "else":
            self.refuse(token.span, "'else' is not allowed", f"write {WHERE_EXAMPLE}")
        elif token.kind == "word" and token.text in ("for", "in"):
            self.loop_outside(token)
        elif token.kind == "word":
            self.refuse(token.span, "condition outside 'where' and a sum", CONDITION_HINT)
        elif self.sees("["):
            after_index = self.last is not None and self.last.text == "]"
            hint = "an index follows the name of a family, as in theta[i]"
            if after_index:
                hint = "write both indices in one pair of brackets, as in u[i, j]"
            self.refuse(token.span, "misplaced index", hint)
        elif self.sees("."):
            self.refuse(token.span, "misplaced '.'", "it follows the name of a vector, as in bead.x")
        elif token.kind != "stranger":
            self.structural(
                token.span, f"unexpected '{token.text}'", "complete the expression, or leave it out"
            )
        self.advance()

    def missing(self) -> Tree:
        """Report that a value is missing, and go on as if there were one."""
        token, last = self.next, self.last
        if token.kind == "end" or token.text in (")", "]", ","):
            where = f"after '{last.text}'" if last else "here"
            span = last.span if token.kind == "end" and last else token.span
        else:
            where, span = f"before '{token.text}'", token.span
        hint = "write 5% as 0.05" if last and last.text == "%" else "complete the expression"
        self.structural(span, f"missing value {where}", hint)
        return Number("1", token.span)

    def unopened(self, token: Token) -> None:
        self.structural(token.span, f"unmatched '{token.text}'", "leave it out, or open it first")

    def close(self, opening: Token) -> None:
        """Take what closes ``opening``."""
        closing = _CLOSES[opening.text]
        if self.next.kind == "end":
            self.structural(opening.span, f"unclosed '{opening.text}'", f"add a '{closing}'")
            return
        if not self.sees(closing):
            self.unopened(self.next)
        self.advance()

    def enclosed(
        self, opening: Token, *, condition: bool = False, first: bool = False
    ) -> tuple[list[Tree], bool]:
        """The expressions in the parentheses or brackets that ``opening`` begins; all of them, or only the
        ``first`` one, may be a ``condition``."""
        self.deeper(opening)
        around, self.condition = self.condition, condition or first
        found = self.items(_CLOSES[opening.text], first)
        self.close(opening)
        self.condition = around
        self.depth -= 1
        return found

    def whole_numbers(self, opening: Token) -> tuple[Tree, ...]:
        """The expressions in brackets behind a name, or in those of a range."""
        around, self.whole = self.whole, True
        items, _ = self.enclosed(opening)
        self.whole = around
        return tuple(items)

    def group(self) -> Tree:
        """The content of parentheses, or a vector."""
        opening = self.advance()
        items, comma = self.enclosed(opening, condition=self.condition)
        if comma or opening.text == "[" or not items:
            return self.vector(items, Span(opening.span.start, self.stop))
        return items[0]

    def vector(self, items: list[Tree], span: Span) -> Tree:
        if not 1 <= len(items) <= 3:
            self.error(
                span, f"a vector of {len(items)} components", "vectors have one to three, as in (x, y, z)"
            )
        return Vector(tuple(items), span)
