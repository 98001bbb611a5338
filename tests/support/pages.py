"""Printed pages, taken apart: the formulas of a page in LaTeX or unicode, and values of those in unicode."""

from __future__ import annotations

import re
from collections.abc import Mapping, Set
from typing import Any

import mpmath

from tests.support.latex import FUNCTIONS as OF_LATEX

WORDS = (
    "alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi pi rho sigma tau upsilon phi "
    "chi psi omega Gamma Delta Theta Lambda Xi Pi Sigma Upsilon Phi Psi Omega"
)
GREEK = dict(zip("αβγδεζηθικλμνξπρστυφχψωΓΔΘΛΞΠΣΥΦΨΩ", WORDS.split(), strict=True))
DOT, DOTS = "\N{COMBINING DOT ABOVE}", "\N{COMBINING DIAERESIS}"
SUPERSCRIPTS = dict(zip("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-", strict=True))
SUBSCRIPTS = dict(zip("₀₁₂₃₄₅₆₇₈₉", "0123456789", strict=True))
NAME = rf"(?:(?![\d⁰¹²³⁴-⁹])\w)(?:[{DOT}{DOTS}]|,(?=[₀-₉])|(?![⁰¹²³⁴-⁹])\w)*"
TOKEN = re.compile(rf"( ?)({NAME}|\d+\.?\d*|⁻?[⁰¹²³⁴-⁹]+|\S)")
FUNCTIONS = {
    "asin": mpmath.asin, "acos": mpmath.acos, "atan": mpmath.atan, "log": mpmath.log,
    "atan2": mpmath.atan2, "sign": mpmath.sign,
    **{name.removeprefix("\\"): function for name, function in OF_LATEX.items() if name.isascii()},
}  # fmt: skip


def formulas_of_latex(page: str) -> list[tuple[str, str]]:
    """Both sides of each formula."""
    blocks = r"\\begin\{align\*\}\n(.*?)\n *\\end\{align\*\}|\\item \$(.*?)\$(?::|$)"
    found = []
    for rows, item in re.findall(blocks, page, re.DOTALL | re.MULTILINE):
        lines: list[str] = []
        for row in rows.split(" \\\\\n") if rows else [item]:
            row = re.sub(r"(?:&& |&\\quad )\\text\{.*\}$", "", row.strip())
            if row.startswith(r"&\quad"):
                lines[-1] += " " + row.removeprefix(r"&\quad").strip().removeprefix("{}")
            elif row:
                lines.append(row.removeprefix("& ").replace(" &= ", " = ", 1))
        found += lines
    return [(left, right) for left, sign, right in (line.partition(" = ") for line in found) if sign]


def formulas_of_text(page: str) -> list[tuple[str, str]]:
    """The same of a page in unicode or plain text."""
    page = re.sub(r"\n {6,}(?=[*/])", "", page)
    page = re.sub(r"\n {6,}", " ", page)
    lines = re.findall(r"^  (?! )(.*)$", page, re.MULTILINE)
    parts = (re.sub(r"   \[.*\]$", "", line).partition(" = ") for line in lines)
    return [(left, right) for left, sign, right in parts if sign and not re.search("[:;] ", left)]


def entries(matrix: str) -> list[str]:
    """The entries of a matrix in any notation, row by row; of what is none, it itself."""
    if matrix.startswith(r"\begin{pmatrix}"):
        inside = matrix.removeprefix(r"\begin{pmatrix}").removesuffix(r"\end{pmatrix}")
        return split(inside, " &", r" \\")
    if not matrix.startswith("["):
        return [matrix]
    return [entry for row in split(matrix[1:-1], ", ") for entry in entries(row)]


def split(text: str, *signs: str) -> list[str]:
    """The parts between signs that are outside of parentheses, braces and brackets."""
    depth, parts = 0, [""]
    for place, one in enumerate(text):
        depth += (one in "([{") - (one in ")]}")
        parts[-1] += one
        found = next((sign for sign in signs if text.startswith(sign, place)), "")
        if found and depth == 0:
            parts[-1] = parts[-1][:-1]
            parts.append("")
    return [re.sub(r"^(?:\\\\(?= )|[ &,])+", "", part).strip() for part in parts]


def indexed(name: str) -> str:
    """How a name is looked up: the letters, a line before the indices, a prime for each dot."""
    point = re.fullmatch(r"(\w+)(\[.*\])?\.([va]?)([xyz])", name)
    if point:
        rate = {"": "", "v": "_dot", "a": "_ddot"}[point[3]]
        name = f"{point[4]}_{point[1]}{rate}{point[2] or ''}"
    family, _, index = name.rstrip("]").partition("[")
    family, dots = undotted(family)
    if re.match(r"p_[^\W\d]", family):  # a momentum
        of = family.removeprefix("p_") + (f"[{index}]" if index else "")
        return f"p|{indexed(of)}{dots}"
    stem, *parts = [part for part in family.split("_") if part]
    ended = re.fullmatch(r"(\D+)(\d+)", stem)
    stem, parts = (ended[1], [ended[2], *parts]) if ended else (stem, parts)
    return "|".join(filter(None, (stem, ",".join([*parts, *filter(None, [index])])))) + dots


def undotted(name: str) -> tuple[str, str]:
    """A name without its ending, and a prime for each dot that this stands for."""
    base, rate, _ = re.fullmatch(r"(.*?)((_d+ot)?)", name).groups()
    return base, {"": "", "_dot": "'", "_ddot": "''"}[rate]


def written_out(name: str, literal: Set[str]) -> str:
    """How a rate or the momentum of a name that is written out is looked up; nothing for others."""
    momentum, of = ("p|", name.removeprefix("p_")) if name.startswith("p_") else ("", name)
    base, dots = undotted(of)
    return momentum + base + dots if base in literal else ""


def read_names(values: Mapping[str, Any], literal: Set[str], between: str = "$^") -> dict[str, Any]:
    """Values by what is read, without the commas between indices that match ``between``; those of names
    that are written out by the names."""
    found = {name: values[name] for name in literal & values.keys()}
    for name in values.keys() - found.keys():
        key = written_out(name, literal) or re.sub(between, "", indexed(name))
        assert key not in found, f"{name} looks like another name"
        found[key] = values[name]
    return found


NO_DIGITS = r"(?<!\d),|,(?!\d)"
"""In unicode, there are commas only between digits."""


def value(text: str, names: Mapping[str, Any]) -> Any:
    """The value of a formula in unicode."""
    reader = Reader(text, names)
    found = reader.sum()
    assert reader.following == "", (text, reader.tokens)
    return found


class Reader:
    """A parser by recursive descent: factors have spaces between them, functions are next to parentheses."""

    def __init__(self, text: str, names: Mapping[str, Any]) -> None:
        self.tokens = [(bool(space), token) for space, token in TOKEN.findall(text)]
        self.names = names

    @property
    def following(self) -> str:
        return self.tokens[0][1] if self.tokens else ""

    @property
    def spaced(self) -> bool:
        """Whether there is a space before what follows."""
        return bool(self.tokens) and self.tokens[0][0]

    def next(self) -> str:
        return self.tokens.pop(0)[1] if self.tokens else ""

    def take(self, token: str) -> None:
        assert self.following == token, (token, self.tokens[:9])
        self.next()

    def sum(self) -> Any:
        total = mpmath.mpf(0)
        sign = self.next() if self.following == "−" else "+"
        while sign:
            term = self.product()
            total = total + term if sign == "+" else total - term
            sign = self.next() if self.following in ("+", "−") and self.spaced else ""
        return total

    def product(self) -> Any:
        found = self.power()
        while True:
            if self.following == "·":
                self.next()
                assert self.following[0].isdigit(), self.tokens[:9]
                found *= self.power()
            elif self.spaced and self.begins():
                assert not self.following[0].isdigit(), ("a digit without a dot", self.tokens[:9])
                found *= self.power()
            elif self.following == "/":
                self.next()
                return found / self.power()
            else:
                return found

    def begins(self) -> bool:
        """Whether a factor begins here."""
        return self.following in ("(", "|", "√") or (
            self.following not in ("and", "or") and re.match(r"\w", self.following) is not None
        )

    def raised(self, base: Any) -> Any:
        exponent = self.exponent()
        return base if exponent is None else base**exponent

    def exponent(self) -> Any:
        token = self.following
        if not self.spaced and token and all(one in SUPERSCRIPTS for one in token):
            return mpmath.mpf("".join(SUPERSCRIPTS[one] for one in self.next()))
        if token == "^":
            self.next()
            return self.factor()
        return None

    def power(self) -> Any:
        return self.raised(self.factor())

    def factor(self) -> Any:
        token = self.next()
        if token[:1].isdigit():
            return mpmath.mpf(token)
        if token == "(":
            found = self.sum()
            self.take(")")
            return found
        if token == "|":
            found = abs(self.sum())
            assert not self.spaced
            self.take("|")
            return found
        if token == "√":
            return mpmath.sqrt(self.factor())
        if token in FUNCTIONS or token == "where":
            return self.call(token)
        assert self.following != "(" or self.spaced, (token, "is not a function")
        if token in self.names:
            return self.names[token]
        dots = "''" if DOTS in token else "'" if DOT in token else ""
        plain = re.sub(f"[{DOT}{DOTS}]", "", token)
        momentum = "p|" if plain.startswith("p_") else ""
        plain = plain.removeprefix("p_") if momentum else plain
        if momentum + plain + dots in self.names:
            return self.names[momentum + plain + dots]
        stem = re.split("[_₀-₉]", plain)[0]
        name = momentum + "|".join(filter(None, (stem, plain[len(stem) :].replace("_", ""))))
        name = "".join(GREEK.get(one, SUBSCRIPTS.get(one, one)) for one in name)
        return +mpmath.pi if token == "π" else self.names[name + dots]

    def call(self, function: str) -> Any:
        exponent = self.exponent()
        assert not self.spaced
        self.take("(")
        arguments = [self.condition() if function == "where" else self.sum()]
        while self.following == ",":
            self.next()
            arguments.append(self.sum())
        self.take(")")
        if function == "where":
            return arguments[1] if arguments[0] else arguments[2]
        found = FUNCTIONS[function](*arguments)
        return found if exponent is None else found**exponent

    def condition(self) -> bool:
        found = self.relation()
        while self.following in ("and", "or"):
            both = self.next() == "and"
            other = self.relation()
            found = found and other if both else found or other
        return found

    def relation(self) -> bool:
        left, sign, right = self.sum(), self.next(), self.sum()
        if any(isinstance(one, mpmath.mpc) for one in (left, right)):
            return False  # it is not reached
        return bool({"<": left < right, ">": left > right, "≥": left >= right, "≤": left <= right}[sign])
