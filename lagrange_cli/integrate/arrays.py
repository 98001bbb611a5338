"""The arrays that compiled code works on."""

from __future__ import annotations

from collections.abc import Callable
from itertools import accumulate
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.native.interface import Interface

Array: TypeAlias = "NDArray[np.float64]"
LINE, HUGE = 8, 2**18
"""Doubles of a vector, and of a huge page."""


def chunk_size(width: int) -> int:
    """Samples a chunk, for ``width`` numbers a sample: some megabytes, whatever the system."""
    return max(256, min(65536, 4 * 2**20 // (8 * max(1, width))))


def aligned(doubles: int) -> Array:
    """Zeros on a boundary of 64 bytes, as the vector loads of compiled code need them."""
    return beside_one_another(doubles)[0]


def beside_one_another(*sizes: int) -> list[Array]:
    """Arrays of so many zeros, each on a boundary of 64 bytes. Together they are in huge pages if they fill
    one, as numpy asks for these for arrays of 4 MB. (To get small ones took up to a third of a motion's
    time.)"""
    *places, count = accumulate((LINE * (-(-size // LINE)) for size in sizes), initial=0)
    boundary = HUGE if count >= HUGE else LINE
    buffer = np.zeros(count + (2 * HUGE if count >= HUGE else LINE))
    first = (-buffer.ctypes.data % (8 * boundary)) // 8
    return [buffer[first + place : first + place + size] for place, size in zip(places, sizes)]


def largest_of(numbers: Array) -> float:
    """The largest magnitude of some numbers; 0 if there are none."""
    return float(np.abs(numbers).max(initial=0.0))


def at_one_state(
    function: Callable[..., None], constants: Array, times: Array, state: Array, count: int
) -> Array:
    """So many numbers that a function of compiled code (``native.observation``) computes at one state."""
    found = np.empty(count)
    places = (one.ctypes.data for one in (constants, times, state, found))
    function(*places, 1, 1)
    return found


def at_states(
    function: Callable[..., None], constants: Array, time: float, states: Array, count: int
) -> Array:
    """The same at several states (rows, n) of one time: so many numbers of each (count, n)."""
    states, n = np.ascontiguousarray(states), states.shape[1]
    times, found = np.full(n, time), np.empty((count, n))
    function(*(one.ctypes.data for one in (constants, times, states, found)), n, n)
    return found


def with_modes(program: Interface, parameters: Array) -> Array:
    """Parameters (..., parts * P) as ``@prepare`` takes them: where there are guards, with room for their
    modes, which what is observed does not depend on."""
    shape, room = parameters.shape[:-1], program.rows_of_guards.count if program.guarded else 0
    padded = np.zeros((*shape, program.given, len(program.parameters) + room))
    padded[..., : len(program.parameters)] = parameters.reshape(*shape, program.given, -1)
    return padded.reshape(*shape, -1)
