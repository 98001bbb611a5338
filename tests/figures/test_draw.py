"""Pages of plots: what the figures hold, and the files that they become."""

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from lagrange_cli.figures.draw import FADED, draw, figure_of
from lagrange_cli.figures.panels import Band, Curve, Histogram, Map, Page, Panel
from lagrange_cli.figures.style import formula
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
    assert figure.axes[1]._left_title.get_text() == r"\$b"


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize(("suffix", "begins"), [(".png", b"\x89PNG"), (".svg", b"<?xml"), (".pdf", b"%PDF")])
def test_the_same_page_is_the_same_file(suffix, begins):
    page = Page(PAGE.title, PAGE.panels[:1])
    picture = draw(page, suffix, "lagrange-cli")
    assert picture.startswith(begins) and draw(page, suffix, "lagrange-cli") == picture


def test_a_page_as_text_has_no_commands_for_the_terminal():
    text = as_text(PAGE, 80, colored=False)
    assert "\x1b" not in text and "theta" in text and "one" in text
    assert max(map(len, text.splitlines())) <= 100
    swing = Panel("", "t", "x", (Curve(X, np.cos(np.pi * X) * np.linspace(1, 1 + 1e-7, 11)),))
    assert "e-0" not in as_text(Page("", (swing,)), 80, colored=False)


def only(*curves, **more):
    """The axes of a figure with one panel."""
    return figure_of(Page("page", (Panel("panel", "x", "y", curves, **more),))).axes[0]


@pytest.mark.parametrize("slender", ["x", "y", "z"])
def test_the_frame_of_a_slender_path_has_room_for_its_labels(slender):
    """A length is the same along all axes, and none of them is short; one may not vary at all."""
    path = {axis: 1e3 * X if axis == slender else 1 + 0 * X for axis in "xyz"}
    axes = only(Curve(path["x"], path["y"], z=path["z"]), z="z", equal=True)
    spans = [high - low for low, high in (axes.get_xlim(), axes.get_ylim(), axes.get_zlim())]
    assert min(spans) >= 0.49 * max(spans) >= 490
    aspect = axes.get_box_aspect()
    np.testing.assert_allclose(aspect / max(aspect), np.array(spans) / max(spans), rtol=1e-9)
    ticks = [axis.get_major_locator()() for axis in (axes.xaxis, axes.yaxis, axes.zaxis)]
    assert all(1 <= len(one) <= 7 for one in ticks)
    axes.figure.draw_without_rendering()
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        box, page = axis.label.get_window_extent(), axes.figure.bbox
        assert page.x0 <= box.x0 and box.x1 <= page.x1 and page.y0 <= box.y0 and box.y1 <= page.y1


def test_a_power_of_ten_in_space_is_in_the_name_of_the_axis():
    """Beside the axis it would be written over that name."""
    axes = only(Curve(7e6 * X, 7e6 * X, z=2e-7 * X), z="z (m)", equal=False)
    axes.figure.draw_without_rendering()
    assert [axis.get_label_text() for axis in (axes.xaxis, axes.zaxis)] == ["x ($10^{6}$)", "z ($10^{-7}$ m)"]
    assert [one.get_text() for one in axes.xaxis.get_ticklabels()] == ["0", "2", "4", "6"]
    assert [one.get_text() for one in axes.zaxis.get_ticklabels()][-1] == "2.0"


def test_what_is_constant_but_for_rounding_is_a_straight_line():
    """In a range about it, without an offset; what varies has its own."""
    noise = np.array([0.0, 1, -1, 2, 0, 1, 0, -2, 1, 0, 1]) * 2.0**-52
    low, high = only(Curve(X, 9.81 + 9.81 * noise)).get_ylim()
    assert low < 9 and high > 10
    low, high = only(Curve(9.81 + 9.81 * noise, X)).get_xlim()
    assert low < 9 and high > 10
    low, high = only(Curve(X, 1 + 1e-9 * X)).get_ylim()
    assert high - low < 2e-9
    low, high = only(Curve(X, noise)).get_ylim()
    assert high - low < 1e-15
    low, high = only(Curve(X, 0 * X)).get_ylim()
    assert low < 0 < high


@pytest.mark.exhaustive(keep=0.4)
def test_a_legend_is_beside_the_title_where_it_has_room():
    """There it hides no curve."""
    few = only(*(Curve(X, X * k, f"$q_{k}$", k) for k in range(4)))
    many = only(*(Curve(X, X * k, f"a_long_name_of_a_curve_{k}", k) for k in range(4)))
    for axes, above in ((few, True), (many, False)):
        axes.figure.canvas.draw()
        box = axes.get_legend().get_window_extent()
        assert (box.y0 >= axes.bbox.y1 - 1) == above
        assert box.x1 <= axes.bbox.x1 + 1
    space = only(*(Curve(X, X * k, f"$q_{k}$", k, z=X) for k in range(4)), z="z")
    space.figure.draw_without_rendering()
    assert space.get_legend().get_window_extent().x1 <= space.bbox.x0 + 1


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(
    "text", ["$%$", "$^$", "a $", "$\\frac{$", "$x_$", "#", "'", "\\x", "$\\theta_{1}$", "$x$ (m)"]
)
def test_every_text_can_be_drawn(text):
    """What is no formula is drawn as it is."""
    panel = Panel(text, text, text, (Curve(X, X, text), Curve(X, X, text)))
    assert draw(Page(text, (panel,), text), ".svg").startswith(b"<?xml")
    assert formula(text) == text or text.replace("$", r"\$") == formula(text)


HUGE = np.array([1e308, -1.7e308, 1e306, 1.0, np.inf, np.nan])
SIX = np.arange(6.0)
ITEMS = {
    "y": Curve(SIX, HUGE),
    "x": Curve(HUGE, SIX),
    "z": Curve(SIX, SIX, z=HUGE),
    "band": Band(SIX, HUGE, HUGE),
    "histogram": Histogram(HUGE),
    "map": Map(SIX[:3], SIX[:2], HUGE.reshape(2, 3), "z"),
}


@pytest.mark.exhaustive(keep=1)
@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("item", ITEMS.values(), ids=ITEMS)
def test_numbers_that_leave_no_range_are_not_drawn(item):
    panel = Panel("a", "x", "y", (item,), z="z" if getattr(item, "z", None) is not None else "")
    assert draw(Page("huge", (panel,)), ".png").startswith(b"\x89PNG")
    if not panel.z:
        assert as_text(Page("huge", (panel,)), 80, colored=False)


@pytest.mark.exhaustive(keep=0.3)
def test_a_long_title_has_several_lines():
    one, long = (figure_of(Page(name, PAGE.panels[:2])) for name in ("name", "a long name " * 20))
    for figure in (one, long):
        FigureCanvasAgg(figure).draw()
    box = long._suptitle.get_window_extent()
    assert box.x0 >= 0 and box.x1 <= long.bbox.x1 and "\n" in long.get_suptitle()
    assert long.axes[0].get_window_extent().y1 < box.y0
    assert "\n" not in one.get_suptitle()
