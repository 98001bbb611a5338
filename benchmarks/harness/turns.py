"""Measurements in turns: all programs run once, then again, so that a busy machine affects all alike."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from statistics import median
from typing import TypeVar

K = TypeVar("K")
T = TypeVar("T")
SHORTEST = 0.05
"""The least duration of a measurement by ``processor_seconds``, in seconds."""


def in_turns(tasks: Mapping[K, Callable[[], T]], turns: int) -> dict[K, list[T]]:
    """Run every task once, then every one again, ``turns`` times; the results by task, in order."""
    results: dict[K, list[T]] = {name: [] for name in tasks}
    for _ in range(turns):
        for name, task in tasks.items():
            results[name].append(task())
    return results


def medians_in_turns(tasks: Mapping[K, Callable[[], float]], turns: int) -> dict[K, float]:
    """The median by task."""
    return {name: median(values) for name, values in in_turns(tasks, turns).items()}


def in_own_process(function: Callable[..., T], *arguments: object) -> T:
    """``function(*arguments)`` in a process of its own, where nothing is warm and nothing is cached."""
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        return pool.submit(function, *arguments).result()


def timed(function: Callable[[], T]) -> tuple[float, T]:
    """The seconds it takes, and what it returns."""
    began = time.perf_counter()
    result = function()
    return time.perf_counter() - began, result


def timed_by_both(function: Callable[[], T]) -> tuple[float, float, T]:
    """The seconds of the wall's clock and of all processors that it takes, and what it returns."""
    began = time.process_time()
    wall, result = timed(function)
    return wall, time.process_time() - began, result


def processor_seconds(function: Callable[[], object]) -> float:
    """The processor time of a call, the mean of many where one is short."""
    began, count = time.process_time(), 0
    while (spent := time.process_time() - began) < SHORTEST:
        function()
        count += 1
    return spent / count
