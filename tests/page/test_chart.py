"""Graphs on pages, painted with a pen that notes what it writes."""

import json

import pytest
from py_mini_racer import MiniRacer

from lagrange_cli.page.document import asset

PEN = """
var written = [], window = { devicePixelRatio: 1 };
var pen = new Proxy({}, {
  get: (known, name) => {
    if (name === "measureText") return (text) => ({ width: 6 * text.length });
    if (name === "fillText") return (text, x) => written.push([text, x, known.textAlign]);
    return known[name] ?? (() => {});
  },
  set: (known, name, value) => { known[name] = value; return true; },
});
var colour = () => "";
function painted(lines) {
  written = [];
  const chart = Object.assign(Object.create(Chart.prototype), {
    lines: () => ({ lines, across: "t", upward: "x" }), width: 200, height: 120, ratio: 1, choices: [],
    back: { getContext: () => pen }, title: {},
  });
  chart.paint();
  return [written, chart.range];
}
"""


@pytest.fixture(scope="module")
def run():
    v8 = MiniRacer()
    v8.eval(asset("format.js").replace("function colour", "function colour_of"))
    v8.eval(asset("chart.js") + PEN)
    return lambda code: json.loads(v8.eval(f"JSON.stringify({code})"))


def test_numbers_at_the_end_of_an_axis_are_not_cut_off(run):
    written, _ = run("painted([{ x: [0, 1e-11], y: [0, 1] }])")
    ends = [x + 3 * len(text) for text, x, align in written if align == "center"]
    assert any(text == "1e-11" for text, *_ in written) and max(ends) <= 200


@pytest.mark.parametrize("place", [0, 3.5, -1e-9, 1e200])
def test_what_rests_is_in_the_middle_of_its_graph(run, place):
    _, found = run(f"painted([{{ x: [{place}, {place}], y: [0, 0] }}])")
    assert (place - found["left"]) * found["perX"] == pytest.approx((200 - 54 - 10) / 2)


def test_what_has_no_numbers_has_no_axes(run):
    assert run("painted([{ x: [0, 1], y: [NaN, NaN] }])")[1] is None
