"""Pages in LaTeX and unicode have the values of the plain text, which ``--verify`` compares with the code."""

import random
import re
from unicodedata import normalize

import mpmath
import pytest

from lagrange_cli.errors import LagrangeError
from lagrange_cli.expression.build import build
from lagrange_cli.expression.parse import parse
from lagrange_cli.expression.syntax import ExpressionError
from lagrange_cli.expression.vocabulary import RESERVED, TIME
from lagrange_cli.run.equations import FORMS
from lagrange_cli.symbolic.latex import Latex, as_latex
from lagrange_cli.symbolic.layouts import as_text, as_unicode
from tests.support import latex, pages
from tests.support.motion import CONSTRAINED, NAMES, ManyDigits
from tests.support.systems import derived, equations_with, has_form

NAME = re.compile(r"(?<![\w.])[^\W\d]\w*(?:\[[^\[\]]*\])?(?:\.[va]?[xyz]\b)?")
TOO_LARGE = {"bicycle"}
"""What is not printed member by member."""


class Exact(ManyDigits):
    """Numbers as they are written."""

    def number(self, text):
        return mpmath.mpf(text)

    def pi(self):
        return +mpmath.pi


def compared(equations, form, chance):
    """How many sides of formulas have been compared."""
    plain, marked, lettered = (write(equations, form) for write in (as_text, as_latex, as_unicode))
    formulas = [
        pages.formulas_of_text(plain),
        pages.formulas_of_latex(marked),
        pages.formulas_of_text(lettered),
    ]
    parts = [[entry for pair in page for side in pair for entry in pages.entries(side)] for page in formulas]
    names = {name for part in parts[0] for name in NAME.findall(part)} - (RESERVED - {TIME})
    found = 0
    with mpmath.workdps(30):
        values = {name: mpmath.mpf(chance.uniform(0.4, 1.3)) for name in sorted(names)}
        readers = [
            (latex.value, pages.read_names(values, literal(names, latex.TOKEN.findall(marked), in_latex))),
            (
                pages.value,
                pages.read_names(
                    values,
                    literal(names, [one for _, one in pages.TOKEN.findall(lettered)], str),
                    pages.NO_DIGITS,
                ),
            ),
        ]
        for text, *others in zip(*parts, strict=True):
            if re.fullmatch("d.*/dt", text):
                continue
            try:
                expected, closer = (evaluated(text, values, digits) for digits in (30, 60))
            except (ExpressionError, ArithmeticError, ValueError, KeyError, TypeError):
                continue  # the name of a matrix, or no real number
            if abs(expected - closer) > 1e-14 * (1 + abs(closer)):
                continue  # what is left of large terms that cancel
            for (value, read), other in zip(readers, others, strict=True):
                assert abs(value(other, read) - expected) <= 1e-13 * (1 + abs(expected)), (text, other)
                found += 1
    return found


def evaluated(text, values, digits):
    with mpmath.workdps(digits):
        return build(parse(text), values.__getitem__, Exact(real=True))


def literal(names, tokens, form):
    """The names that are written out somewhere, such as those that would look like others."""
    return {name for name in names | {pages.undotted(one)[0] for one in names} if form(name) in tokens}


def in_latex(name):
    return r"\mathrm{" + name.replace("_", r"\_") + "}"


@pytest.mark.exhaustive(keep=3)
@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("name", sorted({*NAMES, *CONSTRAINED} - TOO_LARGE))
def test_the_pages_of_a_shipped_system(name, form, pytestconfig):
    equations = equations_with(name, form)
    if has_form(equations, form):
        chance = random.Random(f"{pytestconfig.option.seed} {name} {form}")
        assert compared(equations, form, chance) >= 2 * len(equations.coordinates)


LETTERS = (
    "x y z theta theta1 theta_1 x1 x_1 x12 x1_2 q_a qa alpha_beta e e_ I E N d lambda_ mu_k Omega omega0 l m "
    "m_1 sin_ exp_ t_ abs_ log_ xdot beta2a q1b2 pi_ pi2 psi1 Phi_a_b i j gamma_dotx A f b rho_0 t0 T_1"
)
NUMBERS = ("2", "3", "0.5", "1.25", "1.2e18", "2.5e-7", "1/3", "9.81", "123456.789", "pi")


def term(chance, names, depth):
    """A random expression of the language, real almost everywhere."""
    if depth == 0 or chance.random() < 0.1:
        return chance.choice([*names] * 4 + [*NUMBERS])
    a, b, c, d = (term(chance, names, depth - 1) for _ in range(4))
    sign, function = chance.choice("<>"), chance.choice(("sin", "cos", "tan", "atan", "tanh", "exp", "abs"))
    return chance.choice([
        f"({a} + {b})", f"({a} - {b})", f"({a}*{b})", f"({a}*{b})", f"({a}/{b})", f"{function}({a})",
        f"{function}({a})*{function}({b})", f"log(2 + cos({a}))", f"sqrt(2 + sin({a}))*{b}",
        f"({a})**{chance.choice(('2', '3', '-1', '0.5'))}", f"({a})**(-1.5)", f"(2 + sin({a}))**({b})",
        f"(2 + sin({a}))**{names[0]}**2", f"sign({a})*{b}", f"max({a}, {b})*min({c}, {d})", f"atan2({a}, 2)",
        f"where({a} {sign} {b}, {c}, {d})", f"where({a} {sign} {b} and {c} > 1, {c}, {d})*sin({a})",
    ])  # fmt: skip


def random_system(chance):
    names = sorted(
        chance.sample(LETTERS.split(), 5), key=lambda one: one[-1] == "_" or one in ("theta_1", "x_1")
    )
    many = chance.choice((1, 1, 2))
    kinetic = " + ".join(f"(1 + {term(chance, names[many:], 1)}**2)*{q}_dot**2" for q in names[:many])
    given = ", ".join(f"{q}: {{initial: 1}}" for q in names[:many])
    return (
        f"coordinates: {{{given}}}\nparameters: {{{', '.join(f'{p}: 1' for p in names[many:])}}}\n"
        f'lagrangian: "{kinetic} - {term(chance, [*names, "t"], 3)}"\n'
    )


@pytest.mark.exhaustive(keep=3)
@pytest.mark.parametrize("case", range(40))
def test_the_pages_of_a_random_system(case, pytestconfig):
    chance = random.Random(f"{pytestconfig.option.seed} {case}")
    for _ in range(5):
        text = random_system(chance)
        try:
            equations = derived(text)
            for form in ("lagrange", "hamilton", "matrix"):
                if has_form(equations, form):
                    assert compared(equations, form, chance), text
        except (LagrangeError, ExpressionError):  # it is not real, or too long
            continue


@pytest.mark.parametrize(
    ("term", "shown", "lettered"),
    [
        ("sin(x)*abs(x + k)", r"\left|k + x\right| \sin x", "sin(x) |k + x|"),
        ("atan(x)*where(k > 1, 2, x)", r"\end{cases}} \arctan x", "atan(x) where(k > 1, 2, x)"),
        ("2**k**2*x", r"2^{k^{2}} x", "2^(k²) x"),
        ("sin_*x", r"\mathrm{sin\_} x", "sin_ x"),
        ("pi_*x", r"\mathrm{pi\_} x", "pi_ x"),
        ("e_*exp(x)", r"e \exp x", "e exp(x)"),
    ],
)
def test_what_would_be_read_otherwise(term, shown, lettered):
    text = (
        "coordinates: {x: {initial: 1}}\nparameters: {k: 1, sin_: 1, pi_: 1, e_: 1}\n"
        f'lagrangian: "x_dot**2/2 - {term}"\n'
    )
    assert shown in as_latex(derived(text), "lagrange")
    assert lettered in as_unicode(derived(text), "lagrange")


def test_rates_look_as_their_coordinates():
    text = "coordinates: {log_: {initial: 1}, x1: {initial: 1}, x_1: {initial: 1}}\n"
    equations = derived(text + "lagrangian: log__dot**2 + x1_dot**2 + x_1_dot**2 - log_*x1*x_1\n")
    for form in ("lagrange", "hamilton"):
        marked, lettered = as_latex(equations, form), normalize("NFC", as_unicode(equations, form))
        assert r"\dot{\mathrm{log\_}}" in marked and r"\dot{x}_{1}" in marked
        assert r"\dot{\mathrm{x\_1}}" in marked and r"\_dot" not in marked
        assert (
            "ẋ₁" in lettered
            and "ẋ_1" in lettered
            and normalize("NFC", "l̇og_") in lettered
            and "dot" not in lettered
        )


def test_what_looks_like_the_lagrangian_is_told_apart_from_it():
    text = "coordinates: {x: {initial: 1}}\nparameters: {L_: 1}\nlagrangian: x_dot**2/2 - L_*x\n"
    assert "L on the right is the parameter" in as_unicode(derived(text), "lagrange")
    assert "on the right" not in as_text(derived(text), "lagrange")


def test_no_line_of_a_matrix_begins_within_a_name():
    text = """\
coordinates: {"u[i in range(2), j in range(2)]": {initial: 1}}
lagrangian: >-
  sum(u_dot[i,j]**2 for i in range(2) for j in range(2))
  + (u_dot[0,0]*u[0,1]**2*sin(u[1,1])*cos(u[1,0]) + u_dot[1,1]*u[1,0]**2*sin(u[1,1]))**2
"""
    rows = as_unicode(derived(text), "matrix").splitlines()
    assert max(map(len, rows)) > 80
    assert not [row for row in rows if row.strip()[:1] in {*pages.SUBSCRIPTS, *pages.SUPERSCRIPTS}]


def test_momenta_have_the_names_of_their_coordinates():
    text = "coordinates: {x1: {initial: 1}, x_1: {initial: 1}, x1_2: {initial: 1}, x12: {initial: 1}}\n"
    equations = derived(text + "lagrangian: x1_dot**2 + x_1_dot**2 + x1_2_dot**2 + x12_dot**2\n")
    lettered = [line.split()[0] for line in as_unicode(equations, "lagrange").splitlines() if "p_" in line]
    assert lettered[:4] == ["p_x₁", "p_x_1", "p_x₁,₂", "p_x₁₂"]
    marked = re.findall("p_.* &=", as_latex(equations, "lagrange"))
    assert marked[:4] == [r"p_{x_{1}} &=", r"p_{\mathrm{x\_1}} &=", "p_{x_{1,2}} &=", "p_{x_{12}} &="]


def test_a_sum_does_not_belong_to_the_function_before_it():
    notation = Latex()
    sine, cosine = notation.call("sin", [r"\theta_{1}"], "2"), notation.call("cos", ["x"])
    assert notation.product([sine, cosine]) == r"\sin^{2} \theta_{1} \cos x"
    total = r"\sum_{i = 0}^{N - 1} y_{i}"
    assert notation.product([cosine, sine, total]) == rf"\cos x \sin^{{2}}(\theta_{{1}}) {total}"
