"""Energies that jump have no motion; those with kinks have one."""

from __future__ import annotations

import pytest

from lagrange_cli.errors import InfiniteForce
from lagrange_cli.mechanics.derive import derive
from lagrange_cli.mechanics.jumps import refuse_jumps
from tests.support.command import lagrange
from tests.support.motion import model_of

SYSTEM = """
parameters: {{k: 2, m: 2}}
coordinates: {{x: {{initial: 0.3}}, y: {{initial: 1}}}}
masses: {{b: 1}}
embedding: {{b: [x, y]}}
potential: "{potential}"
dissipation: "{dissipation}"
"""


@pytest.mark.parametrize(
    "potential",
    [
        "sign(x)",
        "k*sign(x - y)*y",
        "where(x > 1, k, 0)",
        "where(x > 1, x**2, 2)",
        "where(x > y, x, 2*y)",
        "where(x > k, x, 2*k)",
        "where(x > 0 and y > 0, x, 0)",
        "where(x**2 + y**2 < 1, 0, 5)",
        "y*where(x_dot > 0, 1, 2)",
        "sqrt(x**2)/x",
    ],
)
def test_a_jump_is_refused(potential: str) -> None:
    with pytest.raises(InfiniteForce, match="'potential' has a jump"):
        derive(model_of(SYSTEM.format(potential=potential, dissipation="0")))


@pytest.mark.parametrize(
    "potential",
    [
        "x*sign(x)",
        "abs(x - y)*y",
        "k/abs(x - y) + 1/sqrt(x**2) + abs(y)**-0.5*m",
        "log(abs(x))",
        "(y/max(k + cosh(x), 6*k, 0.2**x))**3",
        "where(x > 0, 0.1 + 0.2, 0.3)",
        "max(0, x - k)**2 + min(x, y, 1)",
        "where(x > 1, x**2, 1)",
        "where(x > 1, x**2, 2*x - 1)",
        "where(x < 0.1, x**2*y, 0.01*y)",  # the last bits differ
        "where(x > k, x**2/2, m)",  # with these parameters
        "where(x > y, x, y)",
        "where(x > 0 and y > 0, x*y, 0)",
        "where(t > 1, x, 2*x + 5)",
        "where(k > 1, x, 5)",
    ],
)
def test_a_kink_is_not(potential: str) -> None:
    refuse_jumps(model_of(SYSTEM.format(potential=potential, dissipation="abs(x_dot) + max(0, y_dot)**3")))


def test_friction_that_has_an_energy_which_jumps_is_refused() -> None:
    with pytest.raises(InfiniteForce, match="'dissipation' has a jump"):
        derive(model_of(SYSTEM.format(potential="where(t > 1, x, 5)", dissipation="where(x_dot > 0, 1, 2)")))


@pytest.mark.parametrize("command", ["equations", "check"])
def test_where_it_stands_is_shown(tmp_path, command) -> None:
    text = SYSTEM.format(potential="{a: x**2, b: 'where(x > 1, k, 0)'}", dissipation="0")
    (tmp_path / "wall.yaml").write_text(text.replace('"{a', "{a").replace('}"', "}"), encoding="utf-8")
    run = lagrange(command, "wall.yaml", cwd=tmp_path)
    assert run.returncode == 3
    assert "wall.yaml:6:26: 'potential' has a jump, where the force is infinite" in run.stderr
