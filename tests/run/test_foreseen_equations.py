"""Equations that are too large are refused before anything is derived: by counts that are lower bounds."""

from __future__ import annotations

import pytest

from lagrange_cli.errors import SpecError
from lagrange_cli.run.equations import STEPS_A_MEETING, derive, meetings
from lagrange_cli.spec.read import read_spec
from tests.support.motion import SYSTEMS

CHAIN = (SYSTEMS / "n_pendulum.yaml").read_text()
STRAIGHT = """
sizes: {N: 8}
coordinates: {"u[i in range(N)]": {initial: 0}}
masses: {"b[i in range(N)]": 1}
embedding: {"b[i in range(N)]": "sum(u[j] for j in range(i + 1))"}
potential: sum(u[i]**2 for i in range(N))
"""


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("text", [CHAIN, STRAIGHT])
def test_what_is_foreseen_is_less_than_what_is_done(text: str) -> None:
    """Bead i has i + 1 coordinates in each of its components."""
    spec = read_spec(text, "chain.yaml", {"N": "6"})
    components = 2 if text is CHAIN else 1
    assert meetings(spec) == components * sum(k**2 for k in range(1, 7))
    assert STEPS_A_MEETING * meetings(spec) < derive(spec).work.spent


def test_equations_of_members_that_are_too_large_are_refused_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("lagrange_cli.model.build.build_model", None)
    with pytest.raises(SpecError, match=r"takes more than 20000000 steps of work"):
        derive(read_spec(CHAIN, "chain.yaml", {"N": "100"}))
