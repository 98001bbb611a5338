"""Batches of members that have ended: several as one, and one of those that have not."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.ensemble.method import EndedMembers, Index


def joined(batches: Sequence[EndedMembers], interrupted: bool = False) -> EndedMembers:
    """One batch of several, without the members that were interrupted on the way, unless these are kept."""
    samples = [batch.samples for batch in batches if batch.samples is not None]
    times = [batch.times for batch in batches if batch.times is not None]
    endings = [ending for batch in batches for ending in batch.ending]
    ended = np.array([interrupted or ending is not Ending.INTERRUPTED for ending in endings])
    arrays = {
        name: np.concatenate([getattr(batch, name) for batch in batches])[ended]
        for name in ("index", "t", "state", "steps", "reached")
    }
    logs = [log for batch in batches for log in batch.logs]
    return EndedMembers(
        logs=[log for log, here in zip(logs, ended) if here],
        ending=[ending for ending, here in zip(endings, ended) if here],
        samples=np.concatenate(samples)[ended] if samples else None,
        times=np.concatenate(times)[ended] if times else None,
        **arrays,
    )


def unfinished(index: Index, width: int, samples: int | None, section: bool = False) -> EndedMembers:
    """Members that did not end: nan throughout."""
    count = len(index)
    return EndedMembers(
        index=index,
        ending=[Ending.INTERRUPTED] * count,
        t=np.full(count, np.nan),
        state=np.full((count, width), np.nan),
        steps=np.zeros(count, dtype=np.int64),
        samples=None if samples is None else np.full((count, width, samples), np.nan),
        reached=np.zeros(count, dtype=np.int64),
        times=np.full((count, samples), np.nan) if section and samples else None,
    )
