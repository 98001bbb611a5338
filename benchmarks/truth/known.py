"""``Known``: the truth of a case at the times of its samples, and how large an error may be."""

from __future__ import annotations

from functools import cached_property

from benchmarks.truth.case import MP, Case, Number, Truth

DIFFERENCE, ROUGHLY = "1e-13", 28
"""By which part of itself each number is changed to find out what comes of it, and the digits for that."""


class Known:
    """The truth of a case at the times of its samples, and how large an error may be.

    For a member of a sweep that is little different from another, ``near``, twice of what is allowed there.
    """

    def __init__(self, case: Case, near: Known | None = None) -> None:
        self.case, self.near = case, near

    @cached_property
    def times(self) -> list[Number]:
        """The times of the samples; doubles, where ``stop`` and the number of samples are chosen well."""
        count = self.case.samples - 1
        return [MP.mpf(float(self.case.stop)) * k / count for k in range(count + 1)]

    @cached_property
    def truth(self) -> Truth:
        """With the numbers of the case."""
        return self.case.truth(self.times)

    @cached_property
    def changes(self) -> list[tuple[Truth, Truth]]:
        """With its numbers, and with one of them changed a little: a pair for each number."""
        with MP.workdps(ROUGHLY):
            part = MP.mpf(DIFFERENCE)
            as_given = self.case.truth(self.times)
            return [
                (as_given, self.case.truth(self.times, {name: MP.mpf(value) * (1 + part)}))
                for name, value in self.case.numbers.items()
            ]

    def size(self, path: str) -> Number:
        """That of the values of this path, at events and elsewhere: at a wall, x may be 0 each time."""
        elsewhere = path.split("/", 2)[2] if path.startswith("events/") else path
        values = [*self.truth.values.get(elsewhere, ()), *self.truth.events.get(path, ())]
        return max([MP.mpf(self.truth.sizes.get(path, 0)), *(abs(x) for x in values if x is not None)])

    def allowed(self, path: str, k: int) -> Number:
        """What an error of one part in 1 may be, for the value number k of this path: its size and what comes
        of changes of the numbers by one part in 1; of q also what it does in a time as long as t."""
        if self.near is not None:
            return 2 * self.near.allowed(path, k)
        found = self.size(path)
        for pair in self.changes:
            x, y = (value_of(each, path, k) for each in pair)
            if x is not None and y is not None:
                found += abs(y - x) / MP.mpf(DIFFERENCE)
        speed = value_of(self.truth, path.replace("q/", "v/", 1), k) if path.startswith("q/") else None
        return found if speed is None else found + abs(speed) * self.times[k]

    @cached_property
    def allowed_end(self) -> Number:
        """The same for the time at which the motion ends."""
        if self.near is not None:
            return 2 * self.near.allowed_end
        ends = [(x.ends, y.ends) for x, y in self.changes if x.ends is not None and y.ends is not None]
        assert self.truth.ends is not None
        return abs(self.truth.ends) + sum(abs(y - x) for x, y in ends) / MP.mpf(DIFFERENCE)


def value_of(truth: Truth, path: str, k: int) -> Number | None:
    """The value number k of a path, or of a list of events; None where there is none."""
    values = truth.values.get(path, truth.events.get(path, ()))
    return values[k] if k < len(values) else None
