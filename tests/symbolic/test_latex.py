"""Pages in LaTeX: every formula can be set, and none is wider than a line."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.mathtext import MathTextParser

from lagrange_cli.errors import UsageError
from lagrange_cli.limits import Work
from lagrange_cli.run.equations import FORMS
from lagrange_cli.symbolic.latex import as_latex
from lagrange_cli.symbolic.latex_lines import ROUNDING, WIDTH, breaks, broken, width
from lagrange_cli.symbolic.layouts import WIDTH as COLUMNS
from lagrange_cli.symbolic.layouts import wrap
from lagrange_cli.symbolic.work import counting
from tests.support.command import lagrange
from tests.support.draws import examples
from tests.support.systems import NAMES, derived, equations_of, equations_with, has_form

PARSER = MathTextParser("agg")
ROW = re.compile(r"\\\\$", re.MULTILINE)
ALIGN = re.compile(r"\\begin\{align\*\}\n(.*?)\n *\\end\{align\*\}", re.DOTALL)


def settable(formula):
    """Parse the formula; matplotlib raises ValueError where it cannot. It has no matrices."""
    text = re.sub(r"\\Big[lr]|\\left|\\right", "", formula)
    text = re.sub(r"\\text\{.*\}$", "", text.replace("&", "").replace(r"\quad", "").replace("{}", "").strip())
    if text.strip() and "pmatrix" not in text:
        PARSER.parse(f"${text.strip()}$")


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("name", NAMES)
def test_every_formula_can_be_set_and_fits_a_line(name, form):
    equations = equations_with(name, form)
    if not has_form(equations, form):
        with pytest.raises(UsageError):
            as_latex(equations, form)
        return
    text = as_latex(equations, form)
    assert r"\usepackage{amsmath}" in text.splitlines()[1]
    assert text.count("{") == text.count("}")
    assert text.count(r"\left") == text.count(r"\right")
    assert text.count(r"\Bigl") == text.count(r"\Bigr")
    assert "()" not in text
    for block in ALIGN.findall(text):
        for row in ROW.split(block):
            assert row.count(r"\left") == row.count(r"\right")
            settable(row)
            if "pmatrix" not in row:
                assert width(row.partition(r"\text")[0].replace("&", "")) <= WIDTH + 3, row
    for formula in re.findall(r"\$(.*?)\$", text):
        settable(formula)
    for environment in ("align*", "itemize"):
        assert text.count(rf"\begin{{{environment}}}") == text.count(rf"\end{{{environment}}}")


def test_latex_of_the_hoop():
    text = as_latex(equations_of("rotating_hoop"), "lagrange")
    assert r"p_{\theta} &= m a^{2} \dot{\theta}" in text
    assert r"a \ddot{\theta} + g \sin \theta - a \omega^{2} \sin \theta \cos \theta &= 0" in text
    assert r"&& \text{($\theta$, divided by $m a$)}" in text
    assert r"\item $\frac{d}{dt} (T + U) = 2 m a^{2} \omega^{2}" in text
    assert r"\item $h$: $L$ does not contain $t$ explicitly" in text


def test_long_accelerations_are_broken_and_no_bracket_is_superfluous():
    text = as_latex(equations_of("double_pendulum"), "explicit")
    assert len(ROW.split(text)) >= 5
    assert r"\left" not in text
    assert r"\frac{1}{l_{1} (m_{1} + m_{2} \sin^{2}(\theta_{1} - \theta_{2}))} (-m_{2}" in text


def test_parentheses_around_fractions_get_a_fixed_size_where_they_are_broken():
    term = r"\left(\frac{a}{b} + " + " + ".join(["x y z"] * 30) + r"\right)"
    first, *others, last = broken(f"u {term}", 60)
    assert first.startswith(r"u \Bigl(\frac{a}{b} + ") and last.endswith(r"\Bigr)")
    assert others and r"\left" not in first and r"\right" not in last


TERMS = st.sampled_from(["a b", r"\frac{a + b}{c}", "(x - y) z", r"\left(\frac{x}{2} + y\right) w"])


@examples(30)
@given(st.lists(TERMS), st.floats(5, 80))
def test_breaking_loses_nothing(terms, most):
    formula = " + ".join(["q", *terms])
    lines = broken(formula, most)
    joined = " ".join(lines).replace(r"\Bigl(", r"\left(").replace(r"\Bigr)", r"\right)")
    assert joined.split() == formula.split()
    for line in lines:
        inner = [place for place in breaks(line) if place.index] if line.count("(") == line.count(")") else []
        assert width(line) <= most + ROUNDING or not [place for place in inner if place.depth == 0]


def steps_of(function, *arguments):
    """The steps of work that a call counts."""
    work = Work()
    with counting(work):
        function(*arguments)
    return work.spent


SHAPES = {
    "a sum": " + ".join(["x y"] * 1000),
    "sums in brackets": r"\left(\frac{a}{b} + c\right) " * 300,
    "brackets in brackets": r"\left(a + " * 60 + "b" + r" + c\right)" * 60,
}


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
def test_long_formulas_are_read_once(shape):
    """A line for every few terms: reading the rest of the formula for each took minutes."""
    once, ten = steps_of(broken, shape, 60), steps_of(broken, " + ".join([shape] * 10), 60)
    assert len(shape) / 20 < once and ten < 15 * once


PLAIN = {
    "a sum": " + ".join(["x*y"] * 1000),
    "a product of sums": "*".join(["(a + b*c)"] * 300),
    "brackets in brackets": "(a + " * 60 + "b" + " + c)" * 60,
}


@pytest.mark.parametrize("shape", PLAIN.values(), ids=PLAIN)
def test_long_lines_of_text_are_broken_in_one_pass(shape):
    once, ten = steps_of(wrap, shape), steps_of(wrap, " + ".join([shape] * 10))
    assert len(shape) / 20 < once and ten < 15 * once
    assert "".join("".join(wrap(shape)).split()) == shape.replace(" ", "")


LONG = "*".join(f"q{i}_dot" for i in range(9))


@pytest.mark.parametrize(
    "lines",
    [
        (f"{LONG}*(a - b)*cos(a)", f"+ {LONG}*(a - b)"),  # not within the parentheses, which are short
        (f"x = (m1 + m2)*({LONG} - b)", f"/(a + {LONG})"),  # rather between factors than within one
        (f"x = m*g*({LONG} - b", f"+ {LONG})"),  # as there is nothing else
    ],
)
def test_lines_of_text_are_broken_where_they_are_read_best(lines):
    apart = " " if lines[1].startswith("+") else ""
    assert [one.strip() for one in wrap(apart.join(lines))] == [*lines]


SUM = " + ".join(f"a{i}*x{i}**2" for i in range(20))


@pytest.mark.parametrize(
    "text",
    [
        f"U = k*exp(-{SUM}) + b",
        f"U = b + k*(a - b)*sin({SUM})**2*cos({SUM})",
        f"U = sin(2*exp({SUM} + tan({SUM}))) - 2*√({SUM})",
    ],
)
def test_long_arguments_of_functions_are_broken_too(text):
    """They are continued further in than terms outside of them. Before, they made lines of any length."""
    lines = wrap(text)
    assert max(map(len, lines)) <= COLUMNS
    assert "".join("".join(lines).split()) == text.replace(" ", "")
    inside = [line for line in lines if line.lstrip().startswith("+ a")]
    assert inside and all(line.startswith(" " * 10) for line in inside)


def test_names_that_latex_reads_otherwise():
    equations = derived(
        """
        name: 50% of {a} \\\\line_break & more
        parameters: {m_tot: 1, "κ": 2}
        coordinates: {x_long_name: {initial: 1}}
        masses: {a: m_tot}
        embedding: {a: [x_long_name]}
        potential: κ*x_long_name**2
        """
    )
    text = as_latex(equations, "lagrange")
    assert r"\kappa" in text and text.isascii()
    assert r"x_{\mathrm{long},\mathrm{name}}" in text


def test_numbers_that_are_not_real_are_refused(tmp_path):
    from tests.support.command import lagrange

    file = tmp_path / "complex.yaml"
    file.write_text(
        "coordinates: {x: {initial: 1}}\nmasses: {a: 1}\nembedding: {a: [x]}\npotential: (-2)**x\n"
    )
    for form in ("json", "python", "latex"):
        run = lagrange("equations", file, "--format", form, cwd=tmp_path)
        assert run.returncode == 3
        assert "negative number" in run.stderr


def test_a_long_rate_of_change_in_a_list_has_lines_of_its_own():
    equations = derived(
        """
        coordinates: [x, y]
        masses: {a: 1}
        embedding: {a: [x*cos(t), y]}
        potential: 1/(1 + x**2*y**2)
        dissipation: (x_dot**2 + y_dot**2)**1.5
        """
    )
    text = as_latex(equations, "lagrange")
    _, item = text.split("\\item\n", 1)
    assert item.lstrip().startswith(r"\begin{align*}") and "constraint forces do work" in item


@pytest.mark.parametrize(
    "format, wanted, wrong", [("latex", r"3 \cdot 2^{-x}", "3 2^"), ("unicode", "3 · 2^(−x)", "3 2^")]
)
def test_a_number_before_a_power_of_a_number_is_kept_apart(tmp_path, format, wanted, wrong):
    (tmp_path / "a.yaml").write_text(
        "coordinates: {x: {initial: 1}}\nlagrangian: x_dot**2/2 - 2**(-x) - (2 + x)**(pi/3)\n"
    )
    shown = lagrange("equations", "a.yaml", "--format", format, cwd=tmp_path).stdout
    assert wanted in shown and wrong not in shown
    assert "multiplied by" in shown and "divided by" not in shown
