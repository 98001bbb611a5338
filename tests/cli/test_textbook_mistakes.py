"""Mistakes made by people who wrote textbook systems: each message must lead to what was meant."""

from __future__ import annotations

import re
from itertools import combinations
from pathlib import Path

import hypothesis.strategies as st
import pytest
from hypothesis import given

from lagrange_cli.outputs.catalog import OUTPUTS
from tests.support.command import lagrange
from tests.support.draws import examples
from tests.support.files import PENDULUM

POTENTIAL = "m*g*bob.y"
LETTERS = "bcfhknruw"
"""Names of parameters: neither a coordinate nor a component of a particle."""


def hints(folder: Path, *changes: tuple[str, str]) -> list[str]:
    """What ``check`` says of the pendulum with these pieces replaced: each message with its hint."""
    text = PENDULUM
    for old, new in changes:
        assert text.count(old) == 1
        text = text.replace(old, new)
    (folder / "a.yaml").write_text(text, encoding="utf-8")
    run = lagrange("check", "a.yaml", cwd=folder)
    assert run.returncode == 3, run.stdout
    found = re.findall(r"^a\.yaml:\d+:\d+: (.*)\n.*\n +\| +\^+ ?(.*)$", run.stderr, re.MULTILINE)
    return [" | ".join(one) for one in found]


SAID = [
    # what to replace, by what, message, hint
    (POTENTIAL, "theta/2l", "missing operator between '2' and 'l'", "2*l, or (2*l) to divide by the whole"),
    (POTENTIAL, "1/2 m g l", "missing operator between '2' and 'm'", "write 2*m*g*l, or (2*m*g*l) to"),
    (POTENTIAL, "m*2l", "missing operator between '2' and 'l'", "write 2*l"),
    (POTENTIAL, "mgy", "unknown name 'mgy'", "write m*g*bob.y"),
    (POTENTIAL, "mgl*theta", "unknown name 'mgl'", "write m*g*l"),
    (POTENTIAL, "m*bob_dot", "unknown name 'bob_dot'", "write bob.vx, bob.vy, ... for the components of"),
    (POTENTIAL, "m*thta", "unknown name 'thta'", "did you mean 'theta'?"),
    ("  m: 1", "  m: -1.6*10^-19 C", "number with a unit", "write {value: -1.6e-19, unit: C}"),
    ("  m: 1", "  m: 3x10**8 m/s", "number with a unit", "write {value: 3e8, unit: m/s}"),
    ("  m: 1", "  m: 5 mT", "number with a unit", "write {value: 5, unit: mT}"),
    ("  m: 1", "  m: 2 \u00b5m", "number with a unit", "write {value: 2, unit: \u00b5m}"),
    ("bob: m", "bob: m\n  pulley: 0", "the value 0 is not positive", "leave out a particle without mass"),
    ("bob: m", "bob: m\n  pulley = m", "missing ': '", "write 'pulley: m', with a space after the colon"),
    (POTENTIAL, "m*g*bob.y;", "';' instead of ','", "at the end of an expression, leave it out"),
    (
        "potential:",
        "dissipation: {theta: 0.1}\npotential:",
        "dissipation must be an expression, not a mapping",
        "write 0.1*theta_dot**2/2",
    ),
    (
        "potential:",
        "forces: {bob: m*v x l}\npotential:",
        "between 'v' and 'x'",
        "or cross(v, l) for a vector",
    ),
]


@pytest.mark.parametrize(("old", "new", "message", "hint"), SAID)
def test_the_hint_leads_to_what_was_meant(tmp_path, old, new, message, hint):
    found = hints(tmp_path, (old, new))
    assert any(message in one.partition(" | ")[0] and hint in one.partition(" | ")[2] for one in found), found


@pytest.mark.exhaustive(keep=0.45)
@examples(20)
@given(st.lists(st.sampled_from(LETTERS), min_size=2, max_size=5, unique=True))
def test_any_product_without_operators_is_taken_apart(tmp_path_factory, factors):
    parameters = "".join(f"\n  {one}: 1.5" for one in sorted(set(factors)))
    written = "".join(factors)
    changes = ("  m: 1", f"  m: 1{parameters}"), (POTENTIAL, f"m*{written}")
    found = hints(tmp_path_factory.mktemp("product"), *changes)
    assert found == [f"unknown name '{written}' in potential | write {'*'.join(factors)}"]


@pytest.mark.exhaustive(keep=13)
@pytest.mark.parametrize("row", OUTPUTS.values(), ids=OUTPUTS)
def test_other_words_for_an_output_lead_to_its_name(tmp_path, row):
    for word in row.also.split():
        found = hints(tmp_path, ("potential:", f"solve: {{outputs: [{word}]}}\npotential:"))
        assert found == [f"unknown output '{word}' in solve | write {row.name}"]


def test_no_word_means_two_outputs():
    words = [{row.name, *row.also.split()} for row in OUTPUTS.values()]
    assert all(one.isdisjoint(other) for one, other in combinations(words, 2))
    assert sum(map(len, words)) > 3 * len(OUTPUTS)


OPTIONS = {
    "m=1kg": "number with a unit; write 1, or 1*kg for a product",
    "theta=30 deg": "angle in degrees; angles are in radians: write 30*pi/180",
    "theta'=1": "unknown name 'theta''; write theta_dot for the velocity of theta",
    "thetadot=1": "unknown name 'thetadot'; write theta_dot for the velocity of theta",
    "thta=1": "unknown name 'thta'; did you mean 'theta'?",
}


@pytest.mark.parametrize(("option", "message"), OPTIONS.items())
def test_set_leads_to_what_was_meant(tmp_path, option, message):
    (tmp_path / "a.yaml").write_text(PENDULUM)
    run = lagrange("solve", "a.yaml", "--stop", "1", "--set", option, cwd=tmp_path)
    assert (run.returncode, run.stderr) == (2, f"Error: --set {option}: {message}\n")
    run = lagrange("solve", "a.yaml", "--stop", "10 s", cwd=tmp_path)
    assert run.stderr == "Error: --stop 10 s: number with a unit; write 10, or 10*s for a product\n"
