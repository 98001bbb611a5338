"""What operators join: numbers, names with their indices and components, and calls of functions."""

from __future__ import annotations

import re

from lagrange_cli.expression.confusions import (
    DOTS,
    FUNCTIONS,
    NOT_SUPPORTED,
    PRIMES,
    VELOCITIES,
    WHOLE_PART,
    WHOLE_PARTS,
    spin_component,
)
from lagrange_cli.expression.cursor import SUM_EXAMPLE, WHERE_EXAMPLE
from lagrange_cli.expression.near import known_hint, near_hint, shown
from lagrange_cli.expression.quantities import decimal_comma
from lagrange_cli.expression.reals import SMALLEST, TOO_SMALL, underflows
from lagrange_cli.expression.scan import Token
from lagrange_cli.expression.sums import Sums
from lagrange_cli.expression.syntax import Binary, Call, Comparison, Logic, Name, Number, Span, Tree, Vector
from lagrange_cli.expression.vocabulary import (
    ANY_NUMBER,
    BODY_COMPONENTS,
    CALLABLE,
    COMPONENTS,
    CONSTANTS,
    FAMILY_WORDS,
    MULTIPLIER,
    POINT,
    POWER,
    SIGN,
    TIME,
    VELOCITY_COMPONENTS,
)

SCALARS = frozenset({*COMPONENTS, *VELOCITY_COMPONENTS, *BODY_COMPONENTS, MULTIPLIER})
"""What may follow a name and a dot."""


class Operands(Sums):
    """Reads numbers, names and calls."""

    def number(self) -> Tree:
        token = self.advance()
        if re.fullmatch("0+[1-9][0-9]*", token.text):
            self.error(
                token.span, f"the number {token.text} has a leading zero", f"write {token.text.lstrip('0')}"
            )
        elif float(token.text) == float("inf"):
            self.error(token.span, "number too large", "the largest is about 1.8e308")
            return Number("1", token.span)
        elif underflows(token.text):
            self.error(token.span, TOO_SMALL, SMALLEST)
        return Number(token.text, token.span)

    def name(self) -> Tree:
        token = self.advance()
        name = self.name_of(token)
        if name == "d" and self.sees("/") and self.tokens[self.place + 1].text == "dt":
            after = self.tokens[self.place + 2]
            if after.kind == "name" or after.text == "(":
                return self.differentiated(token)
        if self.sees("("):
            return self.sum(token) if name == "sum" else self.call(token, name)
        if name in CALLABLE or name == "sum":
            return self.function_without_parentheses(token, name)
        if (self.next.text in PRIMES or self.next.text in DOTS) and self.next.span.start == token.span.stop:
            return self.primed(token, name)
        indices: tuple[Tree, ...] = ()
        if self.sees("["):
            indices = self.indices()
        if not self.sees("."):
            return Name(name, Span(token.span.start, self.stop), indices)
        return self.component(token, name, indices)

    def component(self, token: Token, name: str, indices: tuple[Tree, ...]) -> Tree:
        """A name with a component; there is only one."""
        parts: list[str] = []
        while self.sees("."):
            dot = self.advance()
            if not parts and self.next.text == POINT and self.tokens[self.place + 1].text == "(":
                self.advance()
                return self.point(token, name, indices)
            if self.next.kind != "name":
                self.refuse(dot.span, "missing component after '.'", "as in bead.x")
            parts.append(self.name_of(self.advance()))
        span = Span(token.span.start, self.stop)
        if self.sees("("):
            known = parts[-1] in CALLABLE or parts[-1] in FAMILY_WORDS
            hint = f"write {parts[-1]}(...)" if known else "write * for a product"
            if parts[-1] == "diff":
                hint = _velocity_hint(name)
            self.error(span, f"'{name}.{parts[-1]}' is not a function", hint)
            return Vector(tuple(self.enclosed(self.advance())[0]), span)
        if self.sees("["):
            self.indices()
            span = Span(token.span.start, self.stop)
            hint = f"write {name}[i].{parts[0]}"
            if parts == [POINT]:
                hint = f"write {name}.{POINT}(a, b, c): coordinates along the body's axes"
                while self.sees("."):  # its component
                    self.advance()
                    self.name_of(self.advance())
            self.error(span, "index after the component", hint)
            return Number("0", span) if parts == [POINT] else Name(f"{name}.{parts[0]}", span, indices)
        if parts[0] in CONSTANTS:  # math.pi
            self.error(span, f"'{name}.{parts[0]}' is not a name", f"write {parts[0]}")
            return Number("1", span)
        if parts[0] == POINT:
            component = ".".join([f"{name}.{POINT}(a, b, c)", *parts[1:]])
            self.error(span, f"'{name}.{POINT}' without coordinates", f"write {component}")
            return Number("0", span)
        if len(parts) > 1:
            meant = parts[0]
            if meant in VELOCITIES and parts[1] in COMPONENTS:
                meant = f"v{parts[1]}"
            elif spin_component(meant) == "":
                meant = spin_component(f"w{parts[1]}") or meant
            one = f"write {name}.{meant}" if meant in SCALARS else f"write one component, as in {name}.x"
            self.error(span, f"'{name}.{parts[0]}' has no components", one)
            return Name(f"{name}.{meant}", span, indices)
        return Name(f"{name}.{parts[0]}", span, indices)

    def point(self, token: Token, name: str, indices: tuple[Tree, ...]) -> Tree:
        """``plate.at(a, b, c)``: r + a e1 + b e2 + c e3 with the axes e of the body, or a component of it.

        Its velocity is that of the point of the body that is there: v + a de1/dt + b de2/dt + c de3/dt.
        """
        was_lost = self.lost
        places, _ = self.enclosed(self.advance())
        span, component = Span(token.span.start, self.stop), ""
        if len(places) != 3:
            if self.lost == was_lost:
                message = f"wrong number of arguments for '{name}.{POINT}': {len(places)} instead of 3"
                self.error(span, message, f"write {name}.{POINT}(a, b, c): coordinates along the body's axes")
            places = [*places, *(Number("0", span) for _ in range(3))][:3]
        if self.sees("."):
            dot = self.advance()
            if self.next.kind != "name":
                self.refuse(dot.span, "missing component after '.'", "as in bead.x")
            component = self.name_of(self.advance())
        span = Span(token.span.start, self.stop)

        def along(i: int, moving: str) -> Tree:
            tree: Tree = Name(f"{name}.{moving}{COMPONENTS[i]}", span, indices)
            for j, place in enumerate(places):
                axis = Name(f"{name}.{moving}R{i + 1}{j + 1}", span, indices)
                tree = Binary("+", tree, Binary("*", place, axis, span), span)
            return tree

        if component in COMPONENTS:
            return along(COMPONENTS.index(component), "")
        if component in VELOCITY_COMPONENTS:
            return along(VELOCITY_COMPONENTS.index(component), "v")
        if component:
            known = ", ".join((*COMPONENTS, *VELOCITY_COMPONENTS))
            self.error(span, f"a point of a body has no component '{component}'", f"it has {known}")
        return Vector(tuple(along(i, "") for i in range(3)), span, tuple(places))

    def indices(self) -> tuple[Tree, ...]:
        """The content of the brackets behind a name."""
        opening = self.advance()
        if self.sees("]"):
            self.structural(self.next.span, "missing index", "as in theta[0] or theta[i]")
        return self.whole_numbers(opening)

    def primed(self, token: Token, name: str) -> Tree:
        """``x'`` or ``ẋ``, which is a velocity elsewhere."""
        count, what = 0, "a prime is not a derivative"
        while (self.next.text in PRIMES or self.next.text in DOTS) and self.next.span.start == self.stop:
            if self.next.text in DOTS:
                what = "a dot above a letter does not mean a derivative"
            count += DOTS.get(self.next.text, 2 if self.next.text in '"″' else 1)
            self.place += 1
        while self.next.kind in ("name", "number") and self.next.span.start == self.stop:
            name += self.name_of(self.advance())  # the index of a letter with a dot
        span = Span(token.span.start, self.stop)
        if count == 1:
            self.error(span, what, _velocity_hint(name))
        else:
            self.error(span, "accelerations cannot be used", "the equations of motion determine them")
        return Name(name, token.span)

    def differentiated(self, token: Token) -> Tree:
        """``d/dt(x)`` or ``d/dt x``."""
        self.place += 2
        opening = self.advance()
        if opening.kind == "name":
            argument: Tree = Name(self.name_of(opening), opening.span)
        else:
            argument = Vector(tuple(self.enclosed(opening)[0]), opening.span)
            argument = argument.items[0] if len(argument.items) == 1 else argument
        return self.derivative(Span(token.span.start, self.stop), argument)

    def derivative(self, span: Span, argument: Tree) -> Tree:
        """Note a derivative with respect to time; what it is of is read on with."""
        hint = _velocity_hint(argument.identifier if isinstance(argument, Name) else "x")
        self.error(span, "derivatives are not allowed", hint)
        return argument

    def function_without_parentheses(self, token: Token, name: str) -> Tree:
        """``sin x`` or ``sin^2(x)``."""
        message = f"missing parentheses after '{name}'"
        if self.sees("**") and name in CALLABLE:
            self.place += 1
            exponent, start = self.next.text, self.next.span.start
            self.expression(POWER + 1) if self.next.kind == "number" else self.operand()
            span = Span(token.span.start, self.stop)
            if name == "exp" and not self.sees("("):
                power = self.text[start - self.offset : self.stop - self.offset]
                power = power[1:-1] if power[:1] + power[-1:] == "()" else power
                is_whole = 0 < len(power) < 40 and power.count("(") == power.count(")")
                self.error(span, message, f"write exp({power if is_whole else '...'})")
                return Number("1", span)
            self.error(span, message, f"write {name}(x)**{exponent}")
        elif self.next.kind in ("number", "name"):
            argument, after = self.next, self.tokens[self.place + 1]
            written = argument.text
            if argument.kind == "number" and after.kind == "name" and after.span.start == argument.span.stop:
                written += f"*{after.text}"
            self.error(Span(token.span.start, argument.span.stop), message, f"write {name}({written})")
        else:
            self.error(token.span, message, f"write {name}(...)")
            return Number("1", token.span)
        return (
            Vector((self.expression(SIGN),), token.span)
            if self.next.kind != "end"
            else Number("1", token.span)
        )

    def call(self, token: Token, name: str) -> Tree:
        was_lost = self.lost
        meant = FUNCTIONS.get(name.lower(), name.lower()).partition("(")[0]  # piecewise(x > 0, 1, 2), too
        arguments, _ = self.enclosed(self.advance(), first=meant == "where")
        span = Span(token.span.start, self.stop)
        over_dt = self.sees("/") and self.tokens[self.place + 1].text == "dt"
        if name in ("d", "D") and len(arguments) == 1 and over_dt:
            self.place += 2
            return self.derivative(Span(token.span.start, self.stop), arguments[0])
        if name.lower() in NOT_SUPPORTED:
            whole = WHOLE_PART if self.whole and name.lower() in WHOLE_PARTS else ""
            self.error(token.span, f"'{name}' is not supported", whole or NOT_SUPPORTED[name.lower()])
        elif name == "range":
            self.error(token.span, "'range' outside a loop", f"as in {SUM_EXAMPLE}")
        elif name not in CALLABLE:
            one = arguments[0] if len(arguments) == 1 else None
            argument = (
                one.identifier if isinstance(one, Name) else one.text if isinstance(one, Number) else ""
            )
            if argument == TIME and name.lower() not in FUNCTIONS:
                self.error(
                    span, f"unknown function {shown(name)}", f"write {name}: coordinates have no '(t)'"
                )
                return Name(name, token.span)
            hint = _function_hint(name, argument, several=len(arguments) > 1)
            self.error(token.span, f"unknown function {shown(name)}", hint)
        elif self.lost == was_lost:
            due = CALLABLE[name]
            if not (len(arguments) == due or (len(arguments) > due and name in ANY_NUMBER)):
                self.error(span, *_wrong_count(name, arguments, self.text, self.offset))
            elif name == "where" and not isinstance(arguments[0], Comparison | Logic):
                self.error(arguments[0].span, "'where' needs a condition first", f"as in {WHERE_EXAMPLE}")
        return Call(name, tuple(arguments), span)


def _wrong_count(name: str, arguments: list[Tree], text: str, offset: int) -> tuple[str, str]:
    """The message for a function with too many or too few arguments."""
    due = CALLABLE[name]
    if name == "dot" and len(arguments) == 1 and isinstance(arguments[0], Name):
        return "derivatives are not allowed", _velocity_hint(arguments[0].identifier)
    needed = f"{due} or more" if name in ANY_NUMBER else str(due)
    message = f"wrong number of arguments for '{name}': {len(arguments)} instead of {needed}"
    if name == "where":
        return message, f"write a condition and two values, as in {WHERE_EXAMPLE}"
    if due == 1 and len(arguments) == 2 and all(isinstance(one, Number) for one in arguments):
        written = text[arguments[0].span.start - offset : arguments[1].span.stop - offset]
        if decimal_comma(written):
            return message, f"write {name}({decimal_comma(written)}), with a decimal point"
    return message, f"write {name}({', '.join('xyz'[:due])})"


def _velocity_hint(name: str) -> str:
    particle, _, component = name.rpartition(".")
    return f"write {f'{particle}.v{component}' if particle else f'{name}_dot'} for the velocity of {name}"


def _function_hint(function: str, argument: str = "", *, several: bool = False) -> str:
    meant = FUNCTIONS.get(function) or FUNCTIONS.get(function.lower())
    if meant:
        return f"write {meant}"
    if function.endswith("_"):  # as in x_{i}
        return f"write {function[:-1]}[{argument or '...'}] for a member of a family"
    otherwise = f"write {function}*{argument or '(...)'} for a product"
    if argument.isidentifier() or argument.isdigit():
        otherwise += f", or {function}[{argument}] for a member of a family"
    if several:
        otherwise = known_hint(CALLABLE, len(CALLABLE))
    return near_hint(function, CALLABLE) or otherwise
