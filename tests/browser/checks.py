"""What pages do in a browser: numbers, sliders, the hand, time, links, files; and no error in the console."""

from __future__ import annotations

import csv
import io
from functools import cache
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import sync_playwright

import lagrange_cli as lagrange
from lagrange_cli.run import shipped
from tests.browser.chromium import chromium
from tests.cli.test_view import HOSTILE
from tests.page.test_engine import UNREADABLE, assert_same, family, page_of
from tests.support.command import SYSTEMS
from tests.support.command import lagrange as command

WIDE, PHONE = {"width": 1400, "height": 1000}, {"width": 390, "height": 844}
PIXELS = """const { canvas } = app.scene, copy = document.createElement("canvas");
  [copy.width, copy.height] = [canvas.width, canvas.height];
  const pen = copy.getContext("2d");
  pen.drawImage(canvas, 0, 0);"""
BLANK = (
    "() => {"
    + PIXELS
    + """
  const pixels = pen.getImageData(0, 0, copy.width, copy.height).data, seen = new Set();
  for (let i = 0; i < pixels.length; i += 4) seen.add(pixels.slice(i, i + 4).join());
  return seen.size;
}"""
)
DOT = (
    "() => { app.draw();"
    + PIXELS
    + """
  const { scene } = app, [x, y] = scene.onPaper(scene.at(scene.points, app.data.drawing.dots[0].point));
  return Array.from(pen.getImageData(x * scene.ratio, y * scene.ratio, 1, 1).data.slice(0, 3));
}"""
)
"""The colour at the place of the first dot."""
NO_WEBGL = """const { prototype } = HTMLCanvasElement, get = prototype.getContext;
prototype.getContext = function (kind, ...rest) {
  return kind === "webgl2" ? null : get.call(this, kind, ...rest);
};"""
STALL = "GPU stall due to ReadPixels"
"""What chromium says of pictures that are read back: it draws without a graphics card here."""
ENDS = """() => ({
  t: app.motion.last, reason: app.motion.reason,
  q: app.data.coordinates.map((_, k) => app.motion.q(k).at(-1)),
  v: app.data.coordinates.map((_, k) => app.motion.v(k).at(-1)),
})"""
INK = "getComputedStyle(document.documentElement).getPropertyValue('--ink').trim()"
DONE = "() => window.app && app.motion.ended"
FRAMES = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"


@pytest.fixture(scope="module")
def browser():
    with sync_playwright() as playwright:
        options = ["--no-sandbox", "--enable-unsafe-swiftshader"]  # WebGL without a graphics card
        browser = playwright.chromium.launch(executable_path=chromium(), args=options)
        yield browser
        browser.close()


@pytest.fixture
def opened(browser, tmp_path):
    """Opens a page, and fails where it has said anything in the console, or asked for anything but itself."""
    said, asked, pages = [], [], []

    def open_page(text, hash="", viewport=WIDE, before="", **options):
        path = tmp_path / f"{len(pages)}.html"
        path.write_text(text, encoding="utf-8")
        page = browser.new_page(viewport=viewport, reduced_motion="reduce", **options)
        pages.append(page)
        page.on("console", lambda message: STALL in message.text or said.append(message.text))
        page.on("pageerror", lambda error: said.append(str(error)))
        page.on("dialog", lambda dialog: said.append(dialog.message))
        page.on("request", lambda request: asked.append(request.url))
        page.add_init_script(before)
        page.goto(path.as_uri() + hash)
        page.wait_for_function(DONE, timeout=60_000)
        return page

    yield open_page
    for page in pages:
        page.close()
    assert said == []
    assert {urlsplit(url).scheme for url in asked} <= {"file", "data", "blob"}


def place_of(page, number=0):
    """Where a dot is in the window, once what has changed is drawn."""
    page.evaluate(FRAMES)
    point = page.evaluate("(k) => app.data.drawing.dots[k].point", number)
    x, y, _ = page.evaluate("(point) => app.scene.onPaper(app.scene.at(app.scene.points, point))", point)
    box = page.locator("#scene").bounding_box()
    return box["x"] + x, box["y"] + y


def give(page, name, value):
    """Type a number into a box."""
    box = page.get_by_label(f"{name}, as a number", exact=True)
    box.fill(str(value))
    box.press("Enter")
    page.wait_for_function(DONE)


@pytest.mark.exhaustive(keep=8)
@pytest.mark.parametrize("name", shipped.names())
def test_the_page_of_a_shipped_system(opened, name):
    """The state at the end is that of ``solve``, something is drawn, and the equations are there."""
    page = opened(page_of(name).text)
    found = page.evaluate(ENDS)
    assert found["reason"] == ""
    assert_same(found, name)
    page.evaluate(
        "() => { app.seek(app.motion.first + 0.4 * (app.motion.last - app.motion.first)); app.draw(); }"
    )
    assert page.evaluate(BLANK) > 2
    page.locator("#equations summary").click()
    if name in UNREADABLE:
        assert "too large" in page.locator("#equations").inner_text()
    else:
        assert page.locator("#equations math").first.bounding_box()["width"] > 5
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")


def test_a_family_is_computed_in_the_browser(opened):
    page = opened(family("n_pendulum", 60, 0.5).text)
    assert_same(page.evaluate(ENDS), "n_pendulum", {"N": 60})
    give(page, "g", 5)
    assert_same(page.evaluate(ENDS), "n_pendulum", {"N": 60}, g=5)
    assert page.evaluate(BLANK) > 2


def test_a_number_and_a_slider_change_the_motion(opened):
    page = opened(page_of("pendulum").text)
    give(page, "l", 2)
    assert_same(page.evaluate(ENDS), "pendulum", l=2)
    slider = page.get_by_label("theta_dot", exact=True)
    slider.focus()
    slider.press("ArrowRight")
    page.wait_for_function(DONE)
    value = float(page.get_by_label("theta_dot, as a number", exact=True).input_value())
    assert value > 0
    assert_same(page.evaluate(ENDS), "pendulum", l=2, theta_dot=value)
    page.keyboard.press("r")
    page.wait_for_function(DONE)
    assert_same(page.evaluate(ENDS), "pendulum")


def test_a_slider_begins_the_motion_within_the_same_task(opened):
    """No frame passes until the first samples of the new motion are there."""
    page = opened(page_of("double_pendulum").text)
    assert page.evaluate("() => { app.change('l1', 1.5); return app.motion.begin.parameters.includes(1.5); }")
    assert page.evaluate("() => { app.change('l1', 2); return app.motion.observed; }") > 0


@pytest.mark.parametrize(("name", "dot"), [("double_pendulum", 1), ("spherical_pendulum", 0)])
def test_a_particle_is_dragged_to_another_start(opened, name, dot):
    page = opened(page_of(name).text)
    x, y = place_of(page, dot)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x - 25, y - 30, steps=5)
    page.mouse.up()
    page.wait_for_function(DONE)
    a, b = place_of(page, dot)
    assert abs(a - x + 25) < 3
    assert abs(b - y + 30) < 3
    start = page.evaluate("[app.start.q, app.start.v]")
    assert start[0] != page.evaluate("app.data.coordinates.map((one) => one.q)")
    assert start[1] == page.evaluate("app.data.coordinates.map((one) => one.v)")


def test_a_linkage_is_dragged_along_its_constraints(opened):
    page = opened(page_of("four_bar").text)
    x, y = place_of(page)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 30, y + 10, steps=6)
    page.mouse.up()
    xa, ya, xb, yb = page.evaluate("app.start.q")
    a, b, c, d = (page.evaluate(f"app.start.parameters[{k}]") for k in range(4))
    assert abs(xa**2 + ya**2 - a**2) < 1e-12
    assert abs((xb - xa) ** 2 + (yb - ya) ** 2 - b**2) < 1e-12
    assert abs((xb - d) ** 2 + yb**2 - c**2) < 1e-12
    assert page.locator("#status").inner_text() == ""


def test_time_plays_steps_and_is_scrubbed(opened):
    page = opened(page_of("pendulum").text)
    page.locator("#scene").focus()
    page.keyboard.press("ArrowRight")
    assert page.evaluate("app.t") == page.evaluate("app.motion.times[1]")
    page.keyboard.press("End")
    assert page.evaluate("app.t") == 20
    page.keyboard.press("Home")
    page.keyboard.press(" ")
    page.wait_for_function("() => app.t > 0.2")
    page.locator("#play").click()
    assert page.evaluate("app.player.playing") is False
    page.locator("#scrub").evaluate("(one) => { one.value = 7; one.dispatchEvent(new Event('input')); }")
    assert page.evaluate("app.t") == 7
    page.evaluate(FRAMES)
    assert "t = 7" in page.locator("#clock").inner_text()
    before = page.evaluate("app.player.speed")
    page.keyboard.press("+")
    assert page.evaluate("app.player.speed") > before


def blue(color):
    red, green, blue = color
    return blue > green > red


def turn(page):
    """Turn what is in space by 40 and 12 degrees, and zoom in; what the view was before."""
    box, before = page.locator("#scene").bounding_box(), page.evaluate("({ ...app.scene.view })")
    page.mouse.move(box["x"] + 30, box["y"] + 30)
    page.mouse.down()
    page.mouse.move(box["x"] + 130, box["y"] + 60, steps=4)
    page.mouse.up()
    page.mouse.move(*place_of(page))
    page.mouse.wheel(0, -300)
    page.wait_for_function("() => app.scene.view.zoom > 1")
    return before


def test_space_is_turned_and_seen_from_near(opened):
    """The camera sees a particle where the hand takes hold of it, from everywhere."""
    page = opened(page_of("spherical_pendulum").text)
    assert page.evaluate("app.scene instanceof Space")
    assert blue(page.evaluate(DOT))
    before = turn(page)
    after = page.evaluate("({ ...app.scene.view })")
    assert after["azimuth"] == pytest.approx(before["azimuth"] - 40)
    assert after["elevation"] == pytest.approx(before["elevation"] + 12)
    assert blue(page.evaluate(DOT))
    page.evaluate("() => { app.scene.reset(); app.scene.include(app.motion); }")
    page.set_viewport_size(PHONE)
    page.wait_for_function("() => app.scene.width < 390 && app.scene.canvas.width === app.scene.width")
    assert blue(page.evaluate(DOT))
    with page.expect_download() as download:
        page.locator("#png").click()
    assert len(download.value.path().read_bytes()) > 5000


def test_what_is_in_front_hides_what_is_behind(opened):
    """Two particles on a line of sight, in either order."""
    page = opened(page_of("free_particles").text)
    page.evaluate(
        """() => {
          const { dots } = app.data.drawing, { scene } = app, place = app.engine.place.bind(app.engine);
          window.order = (front) => {
            app.engine.place = (t, q) => {
              const points = Array.from(place(t, q));
              const middle = scene.middle(), toward = scene.axes[2];
              dots.forEach((dot, i) => middle.forEach((one, k) => {
                points[3 * dot.point + k] = one + (i === front) * toward[k];
              }));
              return points;
            };
            scene.trails = false;
          };
        }"""
    )
    found = []
    for front in (1, 0):
        page.evaluate("(front) => order(front)", front)
        found.append(page.evaluate(DOT))
    assert not blue(found[0]) and blue(found[1])


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_space_has_the_colours_of_the_theme(opened, scheme):
    page = opened(page_of("lattice").text, viewport=PHONE, color_scheme=scheme)
    corner = "() => {" + PIXELS + "return Array.from(pen.getImageData(2, 2, 1, 1).data); }"
    light, dark = [255, 255, 255, 255], [20, 23, 28, 255]
    assert page.evaluate(corner) == (dark if scheme == "dark" else light)
    page.locator("#theme").click()
    assert page.evaluate(corner) == (light if scheme == "dark" else dark)
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")


def test_without_webgl_space_is_painted(opened):
    page = opened(page_of("spherical_pendulum").text, before=NO_WEBGL)
    assert "no WebGL" in page.locator("#notice").inner_text()
    assert page.evaluate("typeof THREE") == "undefined"
    assert page.evaluate(BLANK) > 10
    before = turn(page)
    assert page.evaluate("app.scene.view.azimuth") == pytest.approx(before["azimuth"] - 40)
    assert page.evaluate(BLANK) > 10


def test_time_has_its_unit_and_does_not_begin_before_its_start(opened):
    """The first frame may have begun before the page did."""
    page = opened(page_of("solar_system").text)
    assert page.evaluate("app.data.time.unit") == "d"
    assert page.locator("#clock").inner_text() == "t = 0 d"
    first, next, speed, clock = page.evaluate(
        """() => {
          app.player.playing = true;
          app.frame(app.before - 50);
          const first = app.t;
          app.frame(app.before + 50);
          app.player.playing = false;
          return [first, app.t, app.player.speed, app.element("clock").textContent];
        }"""
    )
    assert first == 0
    assert next == pytest.approx(0.05 * speed)
    assert clock == f"t = {next:g} d"


def test_a_link_holds_the_state_of_the_sliders(opened):
    page = opened(page_of("pendulum").text)
    give(page, "theta", 0.75)
    page.evaluate("app.seek(3)")
    page.locator("#share").click()
    page.wait_for_function("() => location.hash.length > 1")
    other = opened(page_of("pendulum").text, page.evaluate("location.hash"))
    assert other.evaluate("[app.start.q[0], app.t]") == [0.75, 3]
    assert_same(other.evaluate(ENDS), "pendulum", theta=0.75)


def test_files_of_what_is_shown(opened):
    page = opened(page_of("double_pendulum").text)
    with page.expect_download() as download:
        page.locator("#csv").click()
    rows = list(csv.reader(io.StringIO(download.value.path().read_text())))
    assert rows[0] == ["t", "theta1", "theta2", "theta1_dot", "theta2_dot", "p_theta1", "p_theta2", "h"]
    expected = lagrange.solve(SYSTEMS / "double_pendulum.yaml", stop=5)
    assert abs(float(rows[-1][-1]) - expected.h[-1]) < 1e-9
    with page.expect_download() as download:
        page.locator("#png").click()
    assert download.value.path().read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_phone_in_light_and_dark(opened, scheme):
    page = opened(page_of("double_pendulum").text, viewport=PHONE, color_scheme=scheme)
    assert page.evaluate("document.documentElement.dataset.theme") == scheme
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert page.evaluate(INK) == page.evaluate("colour('ink')")
    page.locator("#theme").click()
    assert page.evaluate("document.documentElement.dataset.theme") != scheme
    assert page.evaluate(INK) == page.evaluate("colour('ink')")
    other = "dark" if scheme == "light" else "light"
    page.emulate_media(color_scheme=other)  # the system's choice, which the reader has made before
    page.evaluate(FRAMES)
    page.emulate_media(color_scheme=scheme)
    page.wait_for_function("(scheme) => document.documentElement.dataset.theme === scheme", arg=scheme)
    assert page.evaluate(INK) == page.evaluate("colour('ink')")


def test_what_cannot_go_on_says_so(opened):
    """A planet without angular momentum falls into the centre."""
    page = opened(page_of("central_force").text)
    give(page, "theta_dot", 0)
    assert "cannot go on at t = " in page.locator("#status").inner_text()
    give(page, "theta_dot", 1)
    assert page.locator("#status").inner_text() == ""


def test_what_a_file_contains_is_text(opened, tmp_path):
    (tmp_path / "x.yaml").write_text(HOSTILE.replace("\\e", "\\\\e"), encoding="utf-8")
    page = opened(command("view", "x.yaml", "-o", "-", cwd=tmp_path).stdout)
    assert page.locator("#name").inner_text().startswith("</script><script>alert(1)")
    assert page.locator("b, i").count() == 0
    assert page.evaluate("document.scripts.length") == 3


@cache
def outputs(folder):
    command("solve", SYSTEMS / "pendulum.yaml", "-o", "run.h5", cwd=folder)
    command("sweep", SYSTEMS / "pendulum.yaml", "--over", "l=1:2:5", "-o", "sweep.h5", cwd=folder)
    return [command("view", name, "-o", "-", cwd=folder).stdout for name in ("run.h5", "sweep.h5")]


def test_an_output_is_replayed(opened, tmp_path):
    page = opened(outputs(tmp_path)[0])
    assert_same(page.evaluate(ENDS), "pendulum")
    assert page.get_by_label("l", exact=True).is_disabled()
    page.evaluate("() => { app.seek(3); app.draw(); }")
    assert page.evaluate(BLANK) > 2


def test_members_of_a_sweep_are_on_a_slider(opened, tmp_path):
    page = opened(outputs(tmp_path)[1])
    slider = page.get_by_label("member", exact=True)
    slider.focus()
    slider.press("End")
    page.wait_for_function(DONE)
    assert_same(page.evaluate(ENDS), "pendulum", l=2)
    assert "5 of 5: l = 2" in page.locator("#controls").inner_text()
