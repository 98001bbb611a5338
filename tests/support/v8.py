"""A page's engine in V8, the engine of Chromium and Node: its WebAssembly and the scripts that drive it."""

from __future__ import annotations

import base64
import json
import re
import zlib
from typing import Any

from py_mini_racer import MiniRacer

from lagrange_cli.page.document import TABLES, asset

SCRIPTS = ("engine", "motion", "recorded", "settling", "standstill", "happenings", "start", "player", "link")
DRIVER = """
var performance = { now: () => Date.now() };
const open = (data, hex) => {
  const bytes = Uint8Array.from(hex.match(/../g), (pair) => parseInt(pair, 16));
  const module = new WebAssembly.Module(bytes), engine = new Engine(data.engine, module);
  engine.call = new WebAssembly.Instance(module, engine.imports).exports;
  return { engine, module };
};
const STOP = "until t";
const follow = (data, engine, changes = {}) => {
  const start = new Start(data, engine);
  for (const [name, value] of Object.entries(changes)) start.set(name, value);
  const motion = new Motion(engine, { ...start }, data.time.start, start.stop, data.time.count);
  while (!motion.ended) motion.compute(1000);
  return { start, motion };
};
const ends = ({ start, motion }) => {
  const n = motion.engine.data.degrees, last = (row) => row[row.length - 1];
  const rows = (row) => Array.from({ length: n }, (_, k) => last(row(k)));
  return {
    t: motion.last, reason: motion.reason, steps: motion.steps, note: start.note,
    events: motion.events.length, q: rows((k) => motion.q(k)), v: rows((k) => motion.v(k)),
    observed: motion.engine.data.observed.map((_, k) => last(motion.quantity(k))),
    start: [start.q, start.v, start.parameters],
  };
};
"""


def data_of(page: str) -> dict[str, Any]:
    """What a page has as JSON."""
    found = re.search(r'<script id="data" type="application/json">(.*?)</script>', page, re.DOTALL)
    assert found is not None
    data: dict[str, Any] = json.loads(found[1])
    return data | {name: json.loads(unpacked(data[name])) for name in TABLES}


def unpacked(text: str) -> bytes:
    """What ``page.packed.packed`` has packed."""
    return zlib.decompress(base64.b64decode(text), -zlib.MAX_WBITS)


class Engine:
    """The engine of a page."""

    def __init__(self, page: str) -> None:
        self.data = data_of(page)
        self.v8 = MiniRacer()
        self.v8.eval("\n".join(["'use strict';", *(asset(f"{name}.js") for name in SCRIPTS), DRIVER]))
        code = unpacked(self.data["engine"]["code"]).hex()
        self.v8.eval(f"const data = {json.dumps(self.data)}, opened = open(data, '{code}');")

    def run(self, script: str) -> Any:
        """What an expression gives, in terms of JSON."""
        return json.loads(self.v8.eval(f"JSON.stringify({script})"))

    def end(self, **changes: float) -> dict[str, Any]:
        """How the motion ends with some values changed."""
        found: dict[str, Any] = self.run(f"ends(follow(data, opened.engine, {json.dumps(changes)}))")
        return found
