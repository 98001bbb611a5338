"""How relative velocities follow from velocities, where bodies come to rest on each other."""

from __future__ import annotations

from functools import partial
from itertools import product

import numpy as np
import pytest

from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.guards.modes import Modes
from lagrange_cli.integrate.impacts.pushes import Pushes
from lagrange_cli.integrate.impacts.sides import Sides
from lagrange_cli.integrate.precision import DOUBLE, DOUBLE_DOUBLE, FULL_DOUBLE_DOUBLE, FULL_PRECISION
from lagrange_cli.integrate.prepare import prepare_system
from lagrange_cli.run.derive import derive_system
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_long_values, resolve_values
from tests.families.test_coupled_contacts import CASES
from tests.families.test_events import keep_families
from tests.families.test_switches import OUTPUTS, followed, ready
from tests.motions.test_piles import IMPULSE, PILE
from tests.support.motion import run

BALLS = PILE.replace("e: {e}", "e: 0.3").replace("{count}", "3")
BALLS = BALLS.format(width=2.5, xs=[0.6, 1.7, 1.2], ys=[0.6, 0.7, 1.8], us=[0.3, -0.2, 0.1], impulse=IMPULSE)
CHOICES = [("balls", DOUBLE), *product(("bobs on rods", "a pile"), (DOUBLE, DOUBLE_DOUBLE))]
SYSTEMS = {name: CASES[name].format(count=5, e=0.3) for name in ("bobs on rods", "a pile")} | {"balls": BALLS}


@pytest.mark.exhaustive(keep=0.3)
@pytest.mark.parametrize("whole", [True, False])
@pytest.mark.parametrize(("name", "precision"), CHOICES)
def test_rates_are_those_of_series(
    name: str, whole: bool, precision: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    own, differences = Pushes._relative, list[float]()

    def both(self: Pushes, changes: np.ndarray) -> np.ndarray:
        found = own(self, changes)
        with monkeypatch.context() as patch:
            patch.setattr(Sides, "speeds", lambda self, states: None)
            by_series = own(self, changes)
        differences.append(float(np.max(np.abs(found - by_series)) / (1.0 + np.max(np.abs(by_series)))))
        return found

    monkeypatch.setattr(Pushes, "_relative", both)
    keep_families(monkeypatch, whole=whole)
    long = precision == DOUBLE_DOUBLE
    tolerance = FULL_DOUBLE_DOUBLE if long else FULL_PRECISION
    asked, spec = (
        Compilation("taylor", tolerance, OUTPUTS, precision=precision),
        read_spec(SYSTEMS[name], "file"),
    )
    prepared = prepare_system(spec, partial(derive_system, resting=True, exact=long), None, asked)
    run(prepared, (resolve_long_values if long else resolve_values)(spec, {}), 0.0, 1.2, 7)
    assert len(differences) > 4 and max(differences) < 1e-13


@pytest.mark.exhaustive(keep=0.4)
def test_no_series_are_computed_for_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """As many as are computed of velocities, if they had to come from series."""
    counts: list[int] = []
    for by_series in (False, True):
        seen, asked = [0], [0]
        own, relative = Modes._see, Pushes._relative

        def counted(self: Modes, own=own, seen=seen) -> object:
            seen[0] += 1
            return own(self)

        def counted_rates(self: Pushes, changes: np.ndarray, own=relative, asked=asked) -> np.ndarray:
            asked[0] += int(np.count_nonzero(changes.any(axis=0)))
            return own(self, changes)

        with monkeypatch.context() as patch:
            patch.setattr(Modes, "_see", counted)
            patch.setattr(Pushes, "_relative", counted_rates)
            if by_series:
                patch.setattr(Sides, "speeds", lambda self, states: None)
            keep_families(patch, whole=True)
            text = CASES["a pile"].format(count=9, e=0.3)
            followed(ready(text), text, 1.6)
        counts += [seen[0], asked[0]]
    least, _, most, asked_for = counts
    assert asked_for > 50 and most - least > asked_for / 2
