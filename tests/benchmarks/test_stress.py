"""The stress suite: the fast scenes that need no other program, and that a wrong motion is called wrong."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from benchmarks.stress.judge import Kept, Known, judge, judged
from benchmarks.stress.page import DOCUMENT, PAGE, page
from benchmarks.stress.scene import QUADRUPLE, Scene, particle
from benchmarks.stress.scenes import SCENES

RIGHT = ("balanced", "rod", "huge", "late", "far_away", "dense_samples", "polar_through")
REFUSED = ("head_on", "overflow", "mass_crossed", "blow_up", "edge_of_domain")
TIMES = np.linspace(0.0, 10.0, 101)
CIRCLE = Known(np.arange(101), np.cos(TIMES)[None], np.full((1, 101), 2.0**-52))
OSCILLATOR = Scene("oscillator", "an oscillator", particle("x**2/2"), 10.0)


@pytest.mark.exhaustive(keep=0)
@pytest.mark.parametrize(
    ("name", "verdict"), [*((name, "right") for name in RIGHT), *((name, "refused") for name in REFUSED)]
)
def test_the_fast_scenes_are_right_or_refused(name: str, verdict: str, tmp_path: Path) -> None:
    scene = next(each for each in SCENES if each.name == name)
    found = judge(scene, tmp_path, peers=False)
    assert (found.verdict, found.because) == (verdict, "")
    if scene.reference is not None:
        assert found.error <= scene.error


def kept(q: np.ndarray, h: np.ndarray) -> Kept:
    """What a run of the oscillator would have written."""
    count = len(q)
    none = np.zeros(count)
    return Kept(TIMES[:count], q[None], -np.sin(TIMES[:count])[None], h, 0.5, none, none[None])


def told(status: str = "complete", message: str = "reached the end") -> dict:
    """What ``lagrange solve --json`` would have said."""
    return {"status": status, "message": message, "t": 10.0, "steps": 20, "h_drift": 0.0, "p_drift": {}}


@pytest.mark.exhaustive(keep=0)
def test_what_is_off_is_wrong() -> None:
    q, h = np.cos(TIMES), np.full(101, 0.5)
    assert judged(OSCILLATOR, told(), kept(q, h), CIRCLE).verdict == "right"
    assert judged(OSCILLATOR, told(), kept(q + 1e-9, h), CIRCLE).because.startswith("error of q 1.0e-09")
    assert judged(OSCILLATOR, told(), kept(q, h * (1 + 1e-9 * TIMES)), CIRCLE).because.startswith(
        "drift of h"
    )
    assert judged(OSCILLATOR, told(), kept(q * np.nan, h), CIRCLE).because.endswith("q is not finite")


def test_a_refusal_must_be_right_up_to_where_it_ends_and_say_what_to_do() -> None:
    q, h = np.cos(TIMES[:50]), np.full(50, 0.5)
    said = told("failed", "a collision at t = 5; end the run before it with --stop")
    assert judged(OSCILLATOR, said, kept(q, h), CIRCLE).verdict == "refused"
    assert judged(OSCILLATOR, said, kept(q + 1e-9, h), CIRCLE).verdict == "wrong"
    assert judged(OSCILLATOR, told("failed", "a collision"), kept(q, h), CIRCLE).verdict == "wrong"


def test_the_table_is_large_enough_and_its_names_differ() -> None:
    assert len({scene.name for scene in SCENES}) == len(SCENES) >= 30
    assert {scene.reference for scene in SCENES} >= {QUADRUPLE, None}


def test_the_page_counts_and_lists_verdicts() -> None:
    q, h = np.cos(TIMES), np.full(101, 0.5)
    found = [judged(OSCILLATOR, told(), kept(q + shift, h), CIRCLE) for shift in (0.0, 1e-3)]
    text = page(found)
    assert "**2 scenes: 1 right, 0 refused, 1 wrong.**" in text
    assert "- *oscillator*: error of q 1.0e-03 > 1.0e-11" in text


def test_the_document_is_made_of_the_page() -> None:
    """Its text, between the results, is that of the script, and its table has every scene's present name."""
    document = DOCUMENT.read_text(encoding="utf-8")
    pattern = "(.*)".join(re.escape(part) for part in re.split(r"{\w+}", PAGE))
    assert re.fullmatch(pattern, document, re.DOTALL)
    listed = re.findall(r"^\| (\w+) +\| (.*?) +\| (?:right|refused|wrong) ", document, re.MULTILINE)
    assert listed == [(scene.name, scene.what) for scene in SCENES]
