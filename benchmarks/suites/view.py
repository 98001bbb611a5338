"""Pages of `lagrange view` for all shipped systems, in a browser: their size, speed and numbers."""

from __future__ import annotations

import os
import shutil
import sys
import time
from argparse import Namespace
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from math import isnan, nan
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from benchmarks.harness.report import Report, Requirement, markdown_table
from benchmarks.harness.suite import NotInstalled, Suite
from lagrange_cli.integrate.run import integrate
from lagrange_cli.integrate.times import Times
from lagrange_cli.records import replace
from lagrange_cli.run import shipped
from lagrange_cli.run.motion import Motion
from lagrange_cli.run.prepare import prepare_run
from lagrange_cli.run.request import Request
from lagrange_cli.run.view.motion import OUTPUTS, read_shown, shown_settings
from lagrange_cli.run.view.page import view

SIZE, FRAME, AGREEMENT = 400.0, 16.0, 1e-9
"""Kilobytes of a page, milliseconds from a slider to the drawing, and what q may differ from native by."""
REGULAR = 1e-11
"""A motion is regular where changing all initial values by 1e-15 of them moves its end by less than this."""
SMALL = 4
"""Coordinates of a small system."""
TURNS = 0.2
"""Seconds for which a motion is repeated, to be timed."""
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")

OPENED = "() => window.app && app.motion.ended"
FOLLOWED = """(seconds) => {
  const { engine, start, data } = app, end = performance.now() + 1000 * seconds;
  let motion, took = [];
  do {
    const began = performance.now();
    motion = new Motion(engine, { ...start }, data.time.start, start.stop, data.time.count);
    while (!motion.ended) motion.compute(1000);
    took.push((performance.now() - began) / 1000);
  } while (performance.now() < end || took.length < 3);
  const q = data.coordinates.map((_, k) => motion.q(k).at(-1));
  return { took, steps: motion.steps, q, count: data.time.count };
}"""
MOVED = """async (most) => {
  const shown = () => new Promise((done) => requestAnimationFrame(() => {
    const { port1, port2 } = new MessageChannel();
    port1.onmessage = () => done(performance.now());
    port2.postMessage(null);
  }));
  const found = [];
  for (const one of [...app.controls.byName.values()].slice(0, most)) {
    const { slider } = one, range = slider.max - slider.min, was = one.value;
    await shown();
    const began = performance.now();
    slider.value = was + 0.02 * (was + 0.02 * range > slider.max ? -range : range);
    slider.dispatchEvent(new Event("input"));
    const drawn = performance.now() - began;
    found.push([drawn, await shown() - began]);
    app.reset();
  }
  return found;
}"""


@dataclass(frozen=True)
class Measured:
    """What was measured of one page; times in seconds, but those of sliders in milliseconds. A page
    that replays has a size only."""

    name: str
    coordinates: int
    size: int
    written: float
    drawn: float = nan
    shown: float = nan
    steps: float = nan
    native: float = nan
    difference: float = nan
    sensitivity: float = nan

    @property
    def regular(self) -> bool:
        """Whether rounding stays small."""
        return self.sensitivity < REGULAR

    @property
    def row(self) -> tuple[str, ...]:
        """Its line of the table."""
        begun = self.name, f"{self.size / 1000:.0f}", f"{self.written:.1f}"
        if isnan(self.steps):
            return (*begun, "replays", *6 * ("",))
        return (
            *begun,
            f"{self.drawn:.1f}",
            f"{self.shown:.0f}",
            f"{self.steps / 1000:.3g}",
            f"{self.native / 1000:.3g}",
            f"{self.native / self.steps:.1f}",
            f"{self.difference:.1e}",
            f"{self.sensitivity:.1e}",
        )


HEADER = (
    "page",
    "kB",
    "written, s",
    "slider, ms",
    "shown, ms",
    "1000 steps/s",
    "native",
    "ratio",
    "q differs",
    "1e-15",
)


def measure(options: Namespace) -> Report:
    """All pages, one after the other."""
    with opened() as (browser, folder):
        found = [measured(name, browser, folder, options.runs) for name in shipped.names()]
    small = [one for one in found if one.coordinates <= SMALL and not isnan(one.drawn)]
    regular = [one for one in found if one.regular]
    requirements = (
        Requirement("kB of the largest page", max(one.size for one in found) / 1000, "<=", SIZE),
        Requirement(
            f"ms from slider to drawing, systems with up to {SMALL} coordinates",
            max(one.drawn for one in small),
            "<=",
            FRAME,
        ),
        Requirement(
            f"q at the end against native, {len(regular)} regular motions",
            max(one.difference for one in regular),
            "<=",
            AGREEMENT,
        ),
    )
    return Report((markdown_table(HEADER, [one.row for one in found]),), requirements)


@contextmanager
def opened() -> Iterator[tuple[Any, Path]]:
    """A browser, and a folder for pages. Raises ``NotInstalled`` where there is no browser."""
    from playwright.sync_api import sync_playwright

    named = (os.environ.get("LAGRANGE_CHROMIUM", ""), *BROWSERS)
    path = next(filter(None, (shutil.which(one) for one in named if one)), None)
    if path is None:
        raise NotInstalled("view needs a browser: install chromium, or name one in LAGRANGE_CHROMIUM")
    with TemporaryDirectory() as folder, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
        try:
            yield browser, Path(folder)
        finally:
            browser.close()


def measured(name: str, browser: Any, folder: Path, runs: int) -> Measured:
    """Write the page of a shipped system, and try it."""
    motion = read_shown(shipped.text(name).encode(), f"{name}.yaml", Request())
    began = time.monotonic()
    written = view(motion)
    seconds = time.monotonic() - began
    (folder / f"{name}.html").write_text(written.text, encoding="utf-8")
    page = browser.new_page(viewport={"width": 1400, "height": 1000}, reduced_motion="reduce")
    try:
        page.goto((folder / f"{name}.html").as_uri())
        page.wait_for_function(OPENED, timeout=60_000)
        followed = page.evaluate(FOLLOWED, TURNS) if written.live else None
        sliders = page.evaluate(MOVED, runs) if written.live else []
    finally:
        page.close()
    size, coordinates = len(written.text.encode()), len(motion.spec.coordinates)
    if followed is None:
        return Measured(name, coordinates, size, seconds)
    ends, took, steps = ended(motion, followed["count"])
    scale = max(1.0, float(np.abs(ends).max()))
    perturbed = replace(motion.values, q=tuple(x * (1 + 1e-15) for x in motion.values.q))
    perturbed = replace(perturbed, v=tuple(x * (1 + 1e-15) for x in motion.values.v))
    others, *_ = ended(replace(motion, values=perturbed), followed["count"])
    return Measured(
        name,
        coordinates,
        size,
        seconds,
        median(one for one, _ in sliders),
        median(one for _, one in sliders),
        followed["steps"] / median(followed["took"]),
        steps / took,
        float(np.abs(ends - followed["q"]).max()) / scale,
        float(np.abs(ends - others).max()) / scale,
    )


def ended(motion: Motion, count: int) -> tuple[np.ndarray, float, int]:
    """q at the end of a motion that is followed natively, the seconds that this takes, and the steps."""
    settings = replace(shown_settings(motion.settings), outputs=OUTPUTS, optional=frozenset())
    prepared = prepare_run(motion.spec, settings, cached=True)
    paths = [one.path for one in prepared.recording.states if one.path[0] == "q"]
    times = Times(settings.start, settings.stop, count, (settings.stop - settings.start) / (count - 1))
    last: list[float] = []

    def emit(chunk: dict[str, np.ndarray]) -> None:
        last[:] = [x for path in paths for x in chunk[path][-1].ravel().tolist()]

    took: list[float] = []
    until = time.monotonic() + TURNS
    while len(took) < 3 or time.monotonic() < until:
        began = time.monotonic()
        outcome = integrate(prepared, motion.values, times, emit, lambda: False)
        took.append(time.monotonic() - began)
    return np.array(last), median(took), max(1, outcome.steps)


SUITE = Suite("view", measure, packages=("llvmlite", "numpy", "playwright"), runs=12)

if __name__ == "__main__":
    sys.exit(SUITE.main())
