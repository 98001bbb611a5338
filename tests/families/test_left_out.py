"""Outputs that take members written out, where these are too many."""

from __future__ import annotations

from pathlib import Path

import pytest

import lagrange_cli
from lagrange_cli.errors import LagrangeWarning, TooLargeSystem
from lagrange_cli.run.check import classify
from lagrange_cli.run.prepare import prepare_run
from lagrange_cli.run.settings.settings import Settings, resolve_settings
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.spec import SolveDefaults, Spec
from tests.families.test_bodies import bodies_from

SYSTEM = """
sizes: {N: 17}
parameters: {m: 0.3, g: 2.0, l: 0.4}
coordinates:
  a[i in range(N)]: {initial: 0.3*i, velocity: 1}
  b[i in range(N)]: {initial: 0.8, velocity: 0.5}
  c[i in range(N)]: {initial: 0.2, velocity: 3}
bodies:
  body[i in range(N)]:
    mass: m*(1 + i/9)
    inertia: [0.02, 0.02, 0.03]
    position: ["l*sin(b[i])*sin(a[i]) + 0.1*sin(t)", "-l*sin(b[i])*cos(a[i])", "l*cos(b[i])"]
    orientation: {euler: ["a[i]", "b[i]", "c[i]"], sequence: zxz}
potential: sum(m*g*body[i].z for i in range(N))
solve: {stop: 0.1, step: 0.1}
"""
LIMIT = "convolutions=100"
"""More than loops take, and less than members do."""


@pytest.fixture(autouse=True)
def small_limit(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Seventeen tops are too many for members to be written out."""
    bodies_from(monkeypatch, 0)
    monkeypatch.setenv("LAGRANGE_LIMITS", LIMIT)
    monkeypatch.setenv("LAGRANGE_CACHE_DIR", str(tmp_path / "cache"))


def asked(*outputs: str, method: str = "taylor") -> tuple[Spec, Settings]:
    """The system, and the settings of a short motion."""
    spec = read_spec(SYSTEM, "tops.yaml")
    return spec, resolve_settings(spec, SolveDefaults(stop=0.1, samples=2, method=method, outputs=outputs))


@pytest.mark.exhaustive(keep=0.15)
def test_all_is_what_can_be_computed_in_loops() -> None:
    """With what is left out, also where the program is that of an earlier run."""
    first, second = (prepare_run(*asked("all"), cached=True) for _ in range(2))
    assert (first.cached, second.cached) == (False, True)
    assert first.machine.program.loops
    assert first.recording == second.recording
    assert first.recording.left_out == ("action", "ledger")
    found = {one.path.split("/")[0] for one in first.datasets}
    assert {"q", "positions", "angular_momenta", "orientations", "diagnostics"} <= found
    assert not {"action", "ledger"} & found


@pytest.mark.exhaustive(keep=0.15)
def test_members_are_written_out_where_they_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("LAGRANGE_LIMITS")
    recording = prepare_run(*asked("q", "ledger", method="DOP853"), cached=False).recording
    assert not recording.left_out
    assert any("ledger" in one.path for one in recording.datasets)


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize("outputs", [("ledger",), ("all", "ledger")])
def test_what_is_named_is_refused(outputs: tuple[str, ...]) -> None:
    with pytest.raises(TooLargeSystem, match=r"members are written out for --outputs (action,)?ledger"):
        prepare_run(*asked(*outputs), cached=False)


@pytest.mark.exhaustive(keep=0.15)
def test_it_is_told(tmp_path: Path) -> None:
    """In the notes of a motion, as a warning, in the attributes of its file, and by check."""
    (tmp_path / "tops.yaml").write_text(SYSTEM, encoding="utf-8")
    with pytest.warns(LagrangeWarning, match="left out of outputs all: action, ledger, as members"):
        motion = lagrange_cli.solve(tmp_path / "tops.yaml", stop=0.1, samples=2, outputs=["all"])
    assert "--outputs action,ledger does that, or says which limit" in motion.attributes["warning"]
    assert "reactions" in dir(motion)
    assert "ledger" not in dir(motion)
    with pytest.raises(AttributeError, match="left out of 'all'"):
        motion.ledger  # noqa: B018
    with pytest.warns(LagrangeWarning, match="left out of outputs all: action, ledger"):
        swept = lagrange_cli.sweep(
            tmp_path / "tops.yaml", over={"m": [0.3, 0.4]}, stop=0.1, samples=2, outputs=["all"]
        )
    assert any("left out" in one for one in swept.notes)
    spec = read_spec(SYSTEM.replace("solve: {", "solve: {outputs: all, "), "tops.yaml")
    skipped = classify(spec).skipped
    assert "action, ledger: members of families would have to be written out, and are many" in skipped
