"""The notations: plain text (which the file's grammar reads back), identifiers only (which sympy and Python
do too) and unicode. LaTeX has a module of its own."""

from __future__ import annotations

import keyword
import re
from collections.abc import Iterable, Mapping, Sequence

from lagrange_cli.expression.vocabulary import ACCELERATION_SUFFIX, VELOCITY_SUFFIX, dotted
from lagrange_cli.symbolic.indexed.conditions import Condition, Joined, Loop
from lagrange_cli.symbolic.indexed.whole import number
from lagrange_cli.symbolic.render import Level, Notation

GREEK = {
    "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "epsilon": "ε", "zeta": "ζ", "eta": "η",
    "theta": "θ", "iota": "ι", "kappa": "κ", "lambda": "λ", "mu": "μ", "nu": "ν", "xi": "ξ", "pi": "π",
    "rho": "ρ", "sigma": "σ", "tau": "τ", "upsilon": "υ", "phi": "φ", "chi": "χ", "psi": "ψ", "omega": "ω",
    "Gamma": "Γ", "Delta": "Δ", "Theta": "Θ", "Lambda": "Λ", "Xi": "Ξ", "Pi": "Π", "Sigma": "Σ",
    "Upsilon": "Υ", "Phi": "Φ", "Psi": "Ψ", "Omega": "Ω",
}  # fmt: skip
WITHIN = r"(?:[^\[\]]|\[(?:[^\[\]]|\[[^\[\]]*\])*\])*"
"""What may stand in brackets: an index, which may have indices, and these, too."""
MEMBER = rf"[^\W\d]\w*(?:\[{WITHIN}\])?"
"""A name, with indices if it has any."""
SUPERSCRIPTS = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
SUBSCRIPTS = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
DOTS = {0: "", 1: "\N{COMBINING DOT ABOVE}", 2: "\N{COMBINING DIAERESIS}"}


def component(name: str) -> str:
    """``bob[i].vx`` as ``x_bob_dot[i]``."""
    found = re.fullmatch(r"(\w+)(\[.*\])?\.([va]?)([xyz])", name)
    if found is None:
        return name
    family, index, rate, axis = found.groups(default="")
    return f"{axis}_{family}{RATES[rate]}{index}"


RATES = {"": "", "v": VELOCITY_SUFFIX, "a": ACCELERATION_SUFFIX}


def joined_component(name: str) -> str:
    """``bob[i].vx`` as ``bob_vx[i]``."""
    return re.sub(r"^(\w+)(\[.*\])?\.(\w+)$", r"\1_\3\2", name)


def split_index(name: str) -> tuple[str, list[str]]:
    """``theta1`` as theta and [1], ``u[1,2]`` as u and [1, 2]; ``p_theta1`` as p and [theta1]."""
    if re.match(r"p_[^\W\d]", name):
        return "p", [name.removeprefix("p_")]
    name, _, members = name.partition("[")
    stem, *indices = [part for part in name.split("_") if part] or [name]
    match = re.fullmatch(r"(\D+)(\d+)", stem)
    if match:
        stem, indices = match[1], [match[2], *indices]
    return stem, indices + (indices_in(members) if members else [])


def indices_in(text: str) -> list[str]:
    """The indices in ``a[n],min(j + 1, N - 1)]``: in calls a space follows the comma."""
    text = text[:-1] if text.count("]") > text.count("[") else text
    return re.split(rf",(?! )(?!{WITHIN}\])", text)


def identifiers(names: Iterable[str], taken: Iterable[str] = ()) -> dict[str, str]:
    """What each name is called where only letters, digits and underscores may stand: ``u_1_2`` for
    ``u[1,2]``; with underscores behind it where it is ``taken``, or another's or a word of Python."""
    found: dict[str, str] = {}
    used = set(taken)
    for name in sorted(names, key=lambda one: "[" in one):  # names that need no change come first
        own = name.replace("[", "_").replace(",", "_").rstrip("]")
        while own in used or keyword.iskeyword(own):
            own += "_"
        found[name] = own
        used.add(own)
    return found


class Text(Notation):
    """Plain ASCII in the grammar of the system file."""

    pi = "pi"

    def symbol(self, name: str) -> str:
        return name

    def decimal(self, digits: str) -> str:
        return digits

    def product(self, factors: Sequence[str]) -> str:
        return "*".join(factors)

    def fraction(self, numerator: Sequence[str], denominator: Sequence[str]) -> tuple[str, Level]:
        below = denominator[0] if len(denominator) == 1 else f"({self.product(denominator)})"
        return f"{self.product(numerator) or '1'}/{below}", Level.PRODUCT

    def power(self, base: str, exponent: str) -> str:
        return f"{base}**{self.enclosed(exponent)}"

    def enclosed(self, exponent: str) -> str:
        """An exponent in parentheses unless it is a name or a number."""
        return exponent if re.fullmatch(r"[\w.]+", exponent) else self.parentheses(exponent)

    def root(self, text: str) -> str:
        return self.call("sqrt", [text])

    def call(self, function: str, arguments: Sequence[str], exponent: str = "") -> str:
        return f"{function}({', '.join(arguments)})"

    def cases(self, pieces: Sequence[tuple[str, str]], otherwise: str) -> str:
        for value, condition in reversed(pieces):
            otherwise = f"where({condition}, {value}, {otherwise})"
        return otherwise

    def parentheses(self, text: str) -> str:
        return f"({text})"

    def rate(self, text: str) -> str:
        return f"d{text}/dt"

    def transposed(self, text: str) -> str:
        return f"{text}^T"

    def matrix(self, rows: Sequence[Sequence[str]]) -> str:
        if all(len(row) == 1 for row in rows):
            return "[" + ",\n ".join(row[0] for row in rows) + "]"
        return "[" + ",\n ".join(f"[{', '.join(row)}]" for row in rows) + "]"


class Identifiers(Text):
    """Plain text in which every symbol is an identifier, given by ``names``."""

    def __init__(self, names: Mapping[str, str]) -> None:
        self.names = names

    def symbol(self, name: str) -> str:
        return self.names[name]


class OfSympy(Text):
    """What sympy reads back."""

    def joined(self, conditions: Sequence[str], word: str) -> str:
        return f"{word.capitalize()}({', '.join(conditions)})" if word else conditions[0]

    def call(self, function: str, arguments: Sequence[str], exponent: str = "") -> str:
        return super().call(SYMPY.get(function, function), arguments)

    def cases(self, pieces: Sequence[tuple[str, str]], otherwise: str) -> str:
        listed = "".join(f"({value}, {condition}), " for value, condition in pieces)
        return f"Piecewise({listed}({otherwise}, True))"


class Sympy(Identifiers, OfSympy):
    """The notation of sympy."""


SYMPY = {"abs": "Abs", "min": "Min", "max": "Max"}


class IndexedSympy(OfSympy):
    """The same, where names of families stand for ``IndexedBase``, and indices for integers."""

    def symbol(self, name: str) -> str:
        base, bracket, index = joined_component(name).partition("[")
        return base + "_" * keyword.iskeyword(base) + bracket + index

    def summed(self, body: str, loops: Sequence[Loop]) -> str:
        for loop in reversed(loops):
            conditions = [self.condition(one) for one in loop.conditions]
            low, high = loop.start.text, (loop.stop + number(-1)).text
            if loop.step != 1:
                conditions.append(f"Eq(({loop.index} - ({low})) % {loop.step}, 0)")
            if conditions:
                body = f"Piecewise(({body}, And({', '.join(conditions)})), (0, True))"
            body = f"Sum({body}, ({loop.index}, {low}, {high}))"
        return body

    def condition(self, condition: Condition) -> str:
        """A condition on indices."""
        if isinstance(condition, Joined):
            word = condition.operator.capitalize()
            return f"{word}({', '.join(map(self.condition, condition.parts))})"
        pairs = zip(condition.operators, condition.operands, condition.operands[1:])
        listed = [f"{RELATIONS[operator]}({one.text}, {other.text})" for operator, one, other in pairs]
        return listed[0] if len(listed) == 1 else f"And({', '.join(listed)})"


RELATIONS = {"==": "Eq", "!=": "Ne", "<": "Lt", "<=": "Le", ">": "Gt", ">=": "Ge"}


_OF_MODULES = (
    "q v a p parameters multipliers values rows place paths sum len tuple zip map print float solution "
    "kinetic_energy potential_energy lagrangian momenta energy_function generalized_forces equations "
    "accelerations unknowns constraints constraint_rates masses mass_matrix force torques velocities "
    "momentum_rates hamiltonian events COORDINATES PARAMETERS CONSTRAINTS EVENTS DIRECTIONS PLACES "
    "EVENT_PLACES"
)
RESERVED = frozenset(_OF_MODULES.split())
"""Names that a Python module uses itself: those of its functions, and those in them."""
OF_LOOPS = frozenset({"for", "in", "range", "if", "and", "or", "not", "min", "max", "abs"})
"""Words of loops and indices that mean in Python what they mean here."""


def python_name(name: str) -> str:
    """What a name is called in a Python module."""
    return name + "_" * (keyword.iskeyword(name) or name in RESERVED)


def python_index(text: str) -> str:
    """An index, a loop, or a condition on indices: what occurs in it has its name in a Python module."""
    return re.sub(
        r"\b[^\W\d]\w*", lambda found: found[0] if found[0] in OF_LOOPS else python_name(found[0]), text
    )


class OfPython(Text):
    """An expression of Python."""

    def cases(self, pieces: Sequence[tuple[str, str]], otherwise: str) -> str:
        return f"({''.join(f'{value} if {condition} else ' for value, condition in pieces)}{otherwise})"


class IndexedPython(OfPython):
    """An expression of Python, where families are lists; those of several indices one list of all members."""

    def __init__(self, shapes: Mapping[str, Sequence[str]]) -> None:
        self.shapes = shapes
        """How many members there are along each index of a family, by its name; others have all indices as
        a key."""

    def symbol(self, name: str) -> str:
        if name.startswith("("):  # a whole number
            return self.words(name)
        base, bracket, inside = joined_component(name).partition("[")
        own = python_name(base)
        if not bracket:
            return own
        if base not in self.shapes:
            return own + bracket + python_index(inside)
        indices = indices_in(python_index(inside))
        place = indices[0]
        for size, index in zip(self.shapes[base][1:], indices[1:]):
            place = f"({place})*{size} + {index}"
        return f"{own}[{place}]"

    def words(self, text: str) -> str:
        return python_index(text)


class Python(Identifiers, OfPython):
    """The same, where every symbol is an identifier."""


class Unicode(Text):
    """Greek letters, superscripts and dots."""

    plus, minus, negative, becomes = " + ", " − ", "−", " → "
    pi = "π"
    powers_of_functions = powers_of_ten = True

    def symbol(self, name: str) -> str:
        if name.startswith("("):  # a whole number
            return self.whole(name)
        bare, dots = dotted(component(name))
        stem, indices = split_index(bare)
        text = with_dots(GREEK.get(stem, stem), dots)
        if any(re.search(r"\W", one) and (stem != "p" or "[" not in one) for one in indices):
            return f"{text}_[{', '.join(self.whole(one) for one in indices)}]"
        for last, index in zip(["", *indices], indices):
            comma = "," if last.isdigit() and index.isdigit() else ""
            text += comma + index.translate(SUBSCRIPTS) if index.isdigit() else f"_{self.name(index)}"
        return text

    def verbatim(self, name: str) -> str:
        return with_dots(*dotted(name))

    def whole(self, text: str) -> str:
        """An index that is computed."""
        return text.replace("-", "−")

    def decimal(self, digits: str) -> str:
        mantissa, _, exponent = digits.partition("e")
        return f"{mantissa}·10{str(int(exponent)).translate(SUPERSCRIPTS)}" if exponent else digits

    def product(self, factors: Sequence[str]) -> str:
        return multiplied(factors, " · ")

    def power(self, base: str, exponent: str) -> str:
        if exponent.isdigit():
            return base + exponent.translate(SUPERSCRIPTS)
        return f"{base}^{self.enclosed(exponent)}"

    def enclosed(self, exponent: str) -> str:
        """In parentheses also if it is a power: x^t² would be the square of x^t as well."""
        raised = ord(exponent[-1]) in SUPERSCRIPTS.values()
        return self.parentheses(exponent) if raised else super().enclosed(exponent)

    def transposed(self, text: str) -> str:
        return f"{text}ᵀ"

    def relation(self, left: str, sign: str, right: str) -> str:
        return super().relation(left, {">=": "≥", "<=": "≤"}.get(sign, sign), right)

    def root(self, text: str) -> str:
        return f"√{text}" if len(text) == 1 else f"√({text})"

    def call(self, function: str, arguments: Sequence[str], exponent: str = "") -> str:
        if function == "abs":
            return self.power(f"|{arguments[0]}|", exponent) if exponent else f"|{arguments[0]}|"
        return f"{self.power(function, exponent) if exponent else function}({', '.join(arguments)})"


def with_dots(name: str, dots: int) -> str:
    """A name with dots above its first letter."""
    return name[0] + DOTS[dots] + name[1:]


def multiplied(factors: Sequence[str], dot: str) -> str:
    """A product without signs, except a ``dot`` before a digit: 3 2^x would look like 32^x."""
    return "".join(
        (dot if one[:1].isdigit() else " ") * bool(number) + one for number, one in enumerate(factors)
    )
