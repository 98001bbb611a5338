"""The work of one step on every shipped system: ceilings, which a change should not raise."""

from __future__ import annotations

import pytest

from tests.support.motion import NAMES, program_of

CEILINGS = {
    # convolutions an order, floating-point operations that the series of a step take
    "atwood": (0, 10),
    "bouncing_ball": (0, 47),  # and the expressions of its events, and of its contact
    "central_force": (3, 2150),  # 1/r, its square and its cube
    "central_force_cartesian": (6, 3700),  # x^2, y^2, a power (two), and its products with x and y
    "charged_particle": (0, 390),
    "double_pendulum": (8, 7800),  # sines and cosines, and two products for each angle
    "driven_damped_pendulum": (2, 1450),
    "figure_eight": (18, 13_000),  # six for each of the three pairs
    "foucault_gyroscope": (3, 1850),
    "fpu_chain": (32, 26_500),  # a square for each spring
    "free_particles": (24, 17_500),  # eight for each of the three pairs
    "gauge_oscillator": (0, 200),  # it is the harmonic oscillator
    "gravity_gradient": (7, 3900),
    "harmonic_oscillator": (0, 195),
    "henon_heiles": (3, 2000),
    "incline": (0, 10),
    "kicked_rotor": (0, 200),
    "kovalevskaya_top": (13, 8600),  # sums with the masses of its rotation in twice the precision
    "lagrange_top": (6, 4400),
    "lattice": (40, 28_500),  # sine and cosine of each angle
    "n_pendulum": (20, 19_000),  # four for each bob
    "newtons_cradle": (70, 33_000),  # sine and cosine of each angle; distances, and powers of the depths
    "parabola_bead": (2, 1700),
    "pendulum": (2, 1250),
    "physical_pendulum": (2, 1050),
    "rotating_hoop": (3, 1800),
    "rotating_rod": (0, 195),
    "solar_system": (288, 170_000),  # eight for each of the 36 pairs
    "spherical_pendulum": (6, 4400),
}


def test_every_system_has_its_ceiling() -> None:
    assert sorted(CEILINGS) == NAMES


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("system", NAMES)
def test_the_work_of_a_step(system: str) -> None:
    program = program_of(system)
    convolutions, operations = CEILINGS[system]
    assert program.series.convolutions <= convolutions
    assert program.operations["jet"] <= operations
