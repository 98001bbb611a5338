"""Pages of plots: what the figures hold, and the files that they become."""

import numpy as np
import pytest

from lagrange_cli.figures.draw import FADED, draw, figure_of, rounded_middle
from lagrange_cli.figures.panels import Band, Curve, Histogram, Map, Page, Panel
from lagrange_cli.figures.terminal import as_text

X = np.linspace(0, 1, 11)
PAGE = Page(
    "title $x^2$ <b> \\frac",
    (
        Panel("a", "$t$ (s)", r"$\dot{\theta}$", (Curve(X, X**2, "one"), Curve(X, X**3, "two", 1, faded=6))),
        Panel("$b", "x", "y", (Band(X, X - 1, X + 1, label="band"), Curve(X, X, shade=0.5))),
        Panel("c", "x", "y", (Map(X, X[:3], np.outer(X[:3], X), "z"),)),
        Panel("d", "x", "y", (Histogram(X),)),
        Panel("e", "x", "y", (Curve(X, X, z=X**2),), z="z", equal=True),
    ),
    "a note with $ and \x1b[31m",
)


def test_a_figure_holds_the_curves():
    axes = figure_of(PAGE).axes
    first = axes[0].get_lines()
    np.testing.assert_array_equal(first[0].get_xydata(), np.stack([X, X**2], axis=1))
    np.testing.assert_array_equal(first[1].get_ydata(), X[:6] ** 3)
    np.testing.assert_array_equal(first[2].get_ydata(), X[5:] ** 3)
    assert first[2].get_alpha() == FADED
    assert [text.get_text() for text in axes[0].get_legend().get_texts()] == ["one", "two"]


def test_texts_of_files_are_no_formulas():
    figure = figure_of(PAGE)
    assert figure.get_suptitle() == PAGE.title
    assert not figure._suptitle.get_parse_math()
    assert not figure.axes[1]._left_title.get_parse_math()


@pytest.mark.parametrize(("suffix", "begins"), [(".png", b"\x89PNG"), (".svg", b"<?xml"), (".pdf", b"%PDF")])
def test_the_same_page_is_the_same_file(suffix, begins):
    page = Page(PAGE.title, PAGE.panels[:1])
    picture = draw(page, suffix, "lagrange-cli")
    assert picture.startswith(begins) and draw(page, suffix, "lagrange-cli") == picture


def test_a_page_as_text_has_no_commands_for_the_terminal():
    text = as_text(PAGE, 80, colored=False)
    assert "\x1b" not in text and "theta" in text and "one" in text
    assert max(map(len, text.splitlines())) <= 100


@pytest.mark.parametrize(
    ("low", "high", "middle"),
    [(-1.0, 1.0 + 1.3e-6, 0.0), (2.0, 2.0, 2.0), (1.234, 1.236, 1.235), (-31000.0, 9000.0, -11000.0)],
)
def test_the_middle_of_an_axis_is_a_number_with_few_digits(low, high, middle):
    """That of a helix from -1 to 1 had been 6.34e-07."""
    assert rounded_middle(low, high) == middle and rounded_middle(-high, -low) == -middle


@pytest.mark.parametrize(("height", "ticks"), [(0.0, 1), (1e-9, 1), (0.1, 1), (1.0, 3)])
def test_a_short_axis_in_space_has_one_tick_in_its_middle(height, ticks):
    path = Panel("path", "x", "y", (Curve(X, X, z=2 + height * X),), z="z", equal=True)
    (axes,) = figure_of(Page("", (path,))).axes
    low, high = axes.get_zlim()
    seen = [one for one in axes.get_zticks() if low <= one <= high]
    assert len(seen) == ticks and len([one for one in axes.get_xticks() if 0 <= one <= 1]) == 3
    assert ticks > 1 or seen == [pytest.approx(2 + height / 2)]
