"""The work of one step on every shipped system: ceilings, which a change should not raise."""

from __future__ import annotations

import pytest

from tests.motion import NAMES, program_of

CEILINGS = {
    # convolutions an order, floating-point operations in the code of a step
    "atwood": (0, 10),
    "central_force": (3, 390),  # 1/r, its square and its cube
    "central_force_cartesian": (6, 530),  # x^2, y^2, a power (two), and its products with x and y
    "charged_particle": (0, 85),
    "double_pendulum": (8, 1110),  # sines and cosines, and two products for each angle
    "driven_damped_pendulum": (2, 280),
    "figure_eight": (18, 1620),  # six for each of the three pairs
    "fpu_chain": (32, 1780),  # a square for each spring
    "free_particles": (24, 2200),  # eight for each of the three pairs
    "gauge_oscillator": (0, 45),  # it is the harmonic oscillator
    "harmonic_oscillator": (0, 40),
    "incline": (0, 10),
    "lattice": (40, 2760),  # sine and cosine of each angle
    "n_pendulum": (20, 1580),  # four for each bob
    "parabola_bead": (2, 290),
    "pendulum": (2, 220),
    "rotating_hoop": (3, 290),
    "rotating_rod": (0, 40),
    "solar_system": (288, 6310),  # eight for each of the 36 pairs
    "spherical_pendulum": (6, 625),
}


def test_every_system_has_its_ceiling() -> None:
    assert sorted(CEILINGS) == NAMES


@pytest.mark.parametrize("system", NAMES)
def test_the_work_of_a_step(system: str) -> None:
    program = program_of(system)
    convolutions, operations = CEILINGS[system]
    assert program.series.convolutions <= convolutions
    assert program.operations["jet"] <= operations
