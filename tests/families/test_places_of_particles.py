"""Positions that contain other particles: systems move and are printed as without them."""

from __future__ import annotations

import re

import pytest
import yaml

from lagrange_cli.families import system as systems
from lagrange_cli.run.family_equations import families_as_written
from lagrange_cli.run.verification import verify_families
from lagrange_cli.spec.read import read_spec
from tests.families.test_missing_members import in_loops
from tests.support.families import alike, both_in_loops, followed, printed_alike, with_indices

OUTPUTS = frozenset(["q", "v", "h", "p", "positions"])
CHAIN = """
sizes: {N: 13}
parameters: {l: 0.3, g: 9.81}
coordinates: {"th[i in range(N)]": {initial: "0.2 + 0.1*i", velocity: "0.1*(i % 3)"}}
masses: {"p[i in range(N)]": "1 + i/7"}
positions:
  "p[0]": "l*[sin(th[0]), -cos(th[0])]"
  "p[i in range(1, N)]": "p[i - 1] + l*[sin(th[i]), -cos(th[i])]"
potential: sum((1 + i/7)*g*p[i].y for i in range(N))
"""
SYSTEMS = {
    "a chain": CHAIN,
    "a chain from its end": CHAIN.replace("th[0]", "th[N - 1]")
    .replace("p[0]", "p[N - 1]")
    .replace("range(1, N)", "range(N - 1)")
    .replace("p[i - 1]", "p[i + 1]"),
    "a tree": CHAIN.replace("p[i - 1]", "p[(i - 1)//2]"),
    "a chain that moves": CHAIN.replace('"p[0]": "l', 'cart: "[x, 0]"\n  "p[0]": "cart + l')
    .replace("masses: {", "masses: {cart: 2, ")
    .replace("coordinates: {", "coordinates: {x: {initial: 0, velocity: 0.3}, "),
    "legs, each of which stands on the one before": """
sizes: {N: 12}
parameters: {l: 0.3, g: 9.81}
coordinates:
  "a[i in range(N)]": {initial: "0.2 + 0.1*i", velocity: "0.1*(i % 3)"}
  "b[i in range(N)]": {initial: "-0.1*i"}
masses: {"knee[i in range(N)]": "1 + i/7", "foot[i in range(N)]": 0.5}
positions:
  "foot[i in range(N)]": "knee[i] + l*[sin(b[i]), -cos(b[i])]"
  "knee[0]": "l*[sin(a[0]), -cos(a[0])]"
  "knee[i in range(1, N)]": "foot[i - 1] + l*[sin(a[i]), -cos(a[i])]"
potential: sum(g*((1 + i/7)*knee[i].y + foot[i].y/2) for i in range(N))
""",
    "points on springs": """
sizes: {N: 12}
coordinates:
  "x[i in range(N)]": {initial: "i"}
  "u[i in range(N)]": {initial: "0.3 + i/20"}
masses: {"a[i in range(N)]": "1 + i/7", "b[i in range(N)]": 0.5}
positions:
  "b[i in range(N)]": "a[i] + (u[i], 0)"
  "a[i in range(N)]": ["x[i]", "x[i]**2/20"]
potential:
  within: sum((b[i].x - a[i].x - 0.3)**2 for i in range(N))
  between: sum(norm(a[i] - a[i - 1])**2 for i in range(1, N))
""",
    "sums of a definition": """
sizes: {N: 12}
parameters: {l: 0.4}
coordinates: {"th[i in range(N)]": {initial: "0.1*i"}}
definitions: {"mid[i in range(N)]": "p[i] - l/2*[sin(th[i]), -cos(th[i])]"}
masses: {"p[i in range(N)]": 1, "c[i in range(N)]": 2}
positions:
  "c[i in range(N)]": "mid[i]"
  "p[i in range(N)]": "(sum(l*sin(th[j]) for j in range(i + 1)), -sum(l*cos(th[j]) for j in range(i + 1)))"
potential: sum(p[i].y + 2*c[i].y for i in range(N))
generalized_forces: {"th[i in range(N)]": "-0.1*mid[i].vx"}
""",
}


LEGS = "legs, each of which stands on the one before"


def by_definitions(text: str) -> str:
    """The same file, in which places have names under ``definitions`` and positions are these."""
    file = yaml.safe_load(text)
    names = {key.partition("[")[0] for key in file["positions"]}
    known = re.compile(rf"\b({'|'.join(names)})\b")

    def named(written: object) -> object:
        if isinstance(written, list):
            return [named(one) for one in written]
        return known.sub(r"place_\1", written) if isinstance(written, str) else written

    definitions = {key: named(one) for key, one in file.get("definitions", {}).items()}
    definitions |= {named(key): named(one) for key, one in file["positions"].items()}
    members = {key: re.sub(r"(\w+) in range\([^)]*\)", r"\1", key) for key in file["masses"]}
    positions = {key: named(one) for key, one in members.items()}
    return yaml.safe_dump({**file, "definitions": definitions, "positions": positions}, sort_keys=False)


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("name", SYSTEMS)
def test_systems_in_loops_move_as_with_definitions(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    in_loops(monkeypatch, True)
    monkeypatch.setattr(systems, "FEWEST_JOINTED", 0)
    both_in_loops(SYSTEMS[name], by_definitions(SYSTEMS[name]), OUTPUTS, 2.0**-44)


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("name", SYSTEMS)
def test_systems_in_loops_move_as_their_members_do(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    text = SYSTEMS[name]
    in_loops(monkeypatch, False)
    for least in ("FEWEST_JOINTED", "FEWEST_CURVED"):
        monkeypatch.setattr(systems, least, 10**6)
    written, expected = followed(text, OUTPUTS)
    in_loops(monkeypatch, True)
    monkeypatch.setattr(systems, "FEWEST_JOINTED", 0)
    found, motion = followed(text, OUTPUTS)
    assert found.machine.program.loops and not written.machine.program.loops
    alike(motion.data, expected.data, 2.0**-36)


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.parametrize("name", SYSTEMS)
def test_equations_in_loops_are_printed_as_with_definitions(name: str) -> None:
    derived = with_indices(SYSTEMS[name])
    if name != LEGS and "definitions" not in SYSTEMS[name]:  # else places are printed by the names of others
        assert printed_alike(derived, with_indices(by_definitions(SYSTEMS[name])))
    assert verify_families(derived, {}).difference < 1e-12


@pytest.mark.exhaustive(keep=0.3)
def test_no_printed_member_comes_before_the_first() -> None:
    """That of a leg without a leg before it."""
    printed = families_as_written(with_indices(SYSTEMS[LEGS]), "text", "lagrange", {})
    assert "b[j - 1]" in str(printed) and "b[-1]" not in str(printed)


LINKS = """
sizes: {{N: 10}}
parameters: {{m: 1, J: 0.1, l: 0.5, g: 9.81}}
coordinates: {{"f[i in range(N)]": {{initial: 1 + 0.1*i}}}}
bodies:
  "link[0]":
    {{mass: m, inertia: [J, J, J], position: "l*[cos(f[0]), sin(f[0]), 0]",
     orientation: {{euler: ["f[0]", 0, 0], sequence: zxz}}}}
  "link[i in range(1, N)]":
    {{mass: m, inertia: [J, J, J], position: "{place} + l*[cos(f[i]), sin(f[i]), 0]",
     orientation: {{euler: ["f[i]", 0, 0], sequence: zxz}}}}
potential: sum(m*g*link[i].y for i in range(N))
"""


@pytest.mark.exhaustive(keep=0.5)
def test_a_body_hangs_at_a_point_of_another() -> None:
    at_a_point = LINKS.format(place="link[i - 1].at(l, 0, 0)")
    by_hand = LINKS.format(place="link[i - 1] + l*[cos(f[i - 1]), sin(f[i - 1]), 0]")
    (_, motion), (_, expected) = (followed(text, OUTPUTS) for text in (at_a_point, by_hand))
    alike(motion.data, expected.data, 2.0**-40)


@pytest.mark.exhaustive(keep=0.5)
def test_bodies_and_the_ends_of_others_take_turns(monkeypatch: pytest.MonkeyPatch) -> None:
    in_loops(monkeypatch, True)
    monkeypatch.setattr(systems, "FEWEST_JOINTED", 0)
    at_ends = (
        LINKS.format(place="end[i - 1]") + 'definitions: {"end[i in range(N)]": "link[i].at(l, 0, 0)"}\n'
    )
    at_a_point = LINKS.format(place="link[i - 1].at(l, 0, 0)")
    both_in_loops(at_ends, at_a_point, OUTPUTS, 2.0**-44)


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.parametrize("last", ["N - 1", "0"])
def test_a_place_that_follows_from_all_others_is_bound(last: str) -> None:
    """A constraint that is a vector: which of its components are 0 in every state is found out."""
    text = SYSTEMS["a chain" if last == "N - 1" else "a chain from its end"]
    spec = read_spec(f'{text}constraints: {{end: "p[{last}] - (1, 0.5)"}}\n', "system.yaml")
    assert [*spec.constraints] == ["end.x", "end.y"]
    flat = text.replace(", -cos(th", ", 0*cos(th") + f'constraints: {{end: "p[{last}] - (1, 0)"}}\n'
    assert [*read_spec(flat, "system.yaml").constraints] == ["end.x"]
