"""What implicit steps take besides the rates: their derivatives, and the matrices of Newton's method.

For increments that grow at a rate s, of velocities dv and coordinates dq = dv/s, the equations are

    (s - B - A/s) dv = given,    A = da/dq, B = da/dv,

so that matrices have one row for each coordinate. A and B are differences of the rates: of columns that have
no row in common together (A. Curtis, M. Powell and J. Reid, J. Inst. Maths Applics 13, 1974). If M is banded,
and its inverse is not, A and B are M times these, and so are both sides of the equations. They are kept
for many steps. The state at which they belong is carried with the motion, so that they can be computed once
more where it is resumed. A ``version`` tells which ones are in ``%work``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from lagrange_cli.errors import TooManyNumbers
from lagrange_cli.limits import way_out, whole
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import table
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.native.rates.places import HEAD, HEADER, span_of, wide_of
from lagrange_cli.native.rates.steps import RateSteps
from lagrange_cli.native.state import LANES, whole_vectors
from lagrange_cli.native.stepping.coupling import Coupling
from lagrange_cli.native.stepping.given import Given

VERSION, WHEN, RENEW, ERROR, CHOSEN = range(5)
"""What is carried as it is (``notes``): the version of the derivatives and the time they belong to; whether
the next step takes new ones; the square of the last error, and the length of its step."""
KNOWN, FACTORED, LENGTH_FACTORED, CURRENT, TRIED, THETA, FASTEST = range(7)
"""What describes ``%work`` (``cache``): the version of its derivatives; version and length of step of its
matrices; whether its derivatives are those where the step begins; whether the step is tried again; by what
Newton's steps became shorter; the square of the largest rate (of an oscillation, or a decay) that the
derivatives tell of."""
CYCLE = 0.25
"""The first trial is not longer than this over the largest rate. Of far longer ones the error is unknown:
they end where an oscillation would be if it had come to rest."""
MOST_NUMBERS = whole("numbers")
DIFFERENCE, SMALL = 2.0**-52, 1e-5
"""A difference is the root of this times a coordinate, or times what it is at least (Hairer and Wanner)."""
BEYOND = HEADER + LANES
"""Where the state at which derivatives belong is among what is carried."""


def areas(given: Given) -> dict[str, int]:
    """The doubles of each area of ``%work`` that implicit steps have for themselves, in their order.

    Raises ``TooManyNumbers`` where they take too much memory.
    """
    layout, coupling = given.state, given.coupling
    assert coupling is not None
    band, wide = coupling.band, wide_of(layout)
    found = {
        "notes": LANES,
        "cache": LANES,
        "point": wide,
        "base": span_of(layout),
        "differences": whole_vectors(band.size, 1),
        "by_q": band.doubles,
        "by_v": band.doubles,
        "real": band.room(1),
        "complex": band.room(2),
        "x": 3 * band.length,
        **({} if coupling.masses is None else {"changes": band.length, "pushed": band.length}),
        **{f"rows{k}": wide for k in range(3)},
    }
    total = sum(found.values())
    if total > MOST_NUMBERS:
        raise TooManyNumbers(
            f"the matrices of implicit steps of this system are {total} numbers, more than {MOST_NUMBERS}",
            f"choose --method taylor or DOP853, make the system smaller, {way_out('numbers')}",
        )
    return found


class ImplicitSteps(RateSteps):
    """Steps that solve equations by Newton's method; the increments of stages grow at the rates ``real``/h
    and ``complex``/h."""

    implicit = True
    growth: tuple[float, complex]

    def __init__(self, given: Given) -> None:
        super().__init__(given)
        assert given.coupling is not None
        self.coupling: Coupling = given.coupling
        self.band = given.coupling.band
        self.size = self.band.size
        self.areas: dict[str, int] = {}
        at = self._places.own
        for name, doubles in self.own_areas(given).items():
            self.areas[name] = at
            at += doubles

    @staticmethod
    def own_areas(given: Given) -> dict[str, int]:
        """What a method has for itself, all areas."""
        return areas(given)

    def functions(self) -> list[str]:
        return [table("coupled", self.coupling.places or (0,)), *super().functions()]

    def helpers(self) -> list[Function]:
        masses = self.coupling.masses
        own = [] if masses is None else [masses.function()]
        return [*own, *self.band.functions(1), *self.band.functions(2), self._slopes(), self._matrices()]

    # numbers

    def noted(self, f: Function, number: int, area: str = "notes") -> Real:
        """One of the numbers of ``notes`` or ``cache``."""
        return f.load("%work", self.areas[area] + number)

    def note(self, f: Function, value: Real, number: int, area: str = "notes") -> None:
        f.store(value, "%work", self.areas[area] + number)

    def row(self, f: Function, area: str, i: Integer) -> Real:
        """Some rows of an area."""
        return f.load_row("%work", i + self.areas[area], self.lengths.lanes)

    def put_row(self, f: Function, value: Real, area: str, i: Integer) -> None:
        f.store_row(value, "%work", i + self.areas[area])

    def area(self, f: Function, name: str) -> Pointer:
        """Where an area begins."""
        return f.place("%work", self.areas[name], "double")

    # the order of coordinates

    def coordinate(self, f: Function, p: Integer) -> Integer:
        """The coordinate in a row of the matrices."""
        return f.load_integer("@coupled", p) if self.coupling.places else p

    @contextmanager
    def in_band(self, f: Function) -> Iterator[tuple[Integer, Integer]]:
        """Every row of the matrices with its coordinate."""
        with f.loop(0, self.size, tested=False) as p:
            yield p, self.coordinate(f, p)

    def solve(self, f: Function, matrix: str, parts: int, x: int) -> None:
        """Solve for the right-hand side at number ``x`` of the area of these."""
        right = f.place("%work", self.areas["x"] + x * self.band.length, "double")
        f.call(None, f"solve_{parts}", self.area(f, matrix), right)

    def push(self, f: Function, count: int) -> None:
        """Multiply the first right-hand sides by M, if the matrices are."""
        masses, band = self.coupling.masses, self.band
        for k in range(count if masses is not None else 0):
            assert masses is not None
            x = f.place("%work", self.areas["x"] + k * band.length, "double")
            pushed = self.area(f, "pushed")
            masses.push(f, x, pushed)
            with f.loop(0, self.size, tested=False) as p:
                f.store(f.load(pushed, p), x, p)

    # derivatives

    @property
    def evaluations(self) -> float:
        """How often rates are computed for them."""
        return 2.0 * self.coupling.colours + 1.0

    def begin(self, f: Function, first: Bit, h: Real) -> Real:
        """The derivatives that the step begins with. The first trial is shorter than all oscillations."""
        layout, lanes = self.state, self.lengths.lanes
        for number in range(LANES):
            self.note(f, f.load("%state", layout.carried_at + HEADER + number), number)
        renewed = f.select(first, f.constant(1.0), self.noted(f, RENEW))
        version, now = self.noted(f, VERSION) + renewed, renewed > 0.0
        self.note(f, version, VERSION)
        self.note(f, renewed, CURRENT, "cache")
        self.note(f, first.to_real(), TRIED, "cache")
        with f.loop(0, layout.width, lanes, tested=False) as i:
            before = f.load_row("%state", i + (layout.carried_at + BEYOND), lanes)
            self.put_row(f, f.select(now, f.load_row("%state", i, lanes), before), "point", i)
        self.note(f, f.select(now, self.now(f), self.noted(f, WHEN)), WHEN)
        self.spend(f, renewed * self.evaluations)  # where old ones are computed once more does not count
        with f.when(~self.noted(f, KNOWN, "cache").equals(version)):
            self.called(f, "slopes")
        cycle = f.constant(CYCLE) / f.function("sqrt", self.noted(f, FASTEST, "cache"))
        return f.select(first, f.smaller(h, cycle), h)

    def renew(self, f: Function) -> None:
        """Compute the derivatives where the step begins."""
        f.copy_rows(("%state", 0), ("%work", self.areas["point"]), self.state.width, self.lengths.lanes)
        self.note(f, self.now(f), WHEN)
        self.note(f, self.noted(f, VERSION) + 1.0, VERSION)
        self.note(f, f.constant(1.0), CURRENT, "cache")
        self.spend(f, f.constant(self.evaluations))
        self.called(f, "slopes")

    def _slopes(self) -> Function:
        """``@slopes``: A and B at the point that is noted. A difference that is not finite counts as 0."""
        f = Function(f"define internal void @slopes{HEAD}) #0")
        at, lanes, width, band = self._places, self.lengths.lanes, self.state.width, self.band
        colours, work = self.coupling.colours, f.pointer("%work")
        fastest = f.variable(f.constant(0.0))
        state = f.place(work, at.state, "double")
        t = self.noted(f, WHEN)
        with f.loop(0, width, lanes, tested=False) as i:
            f.store_row(self.row(f, "point", i), "%work", i + at.state)
            f.store_row(f.zero(lanes), "%work", i + (at.state + width))
        rates, _ = self._evaluate(f, t, state, work)
        f.copy_rows((rates, 0), ("%work", self.areas["base"]), self._count, lanes)
        for area, shift in (("by_q", 0), ("by_v", self.lengths.degrees)):
            with f.loop(0, colours, tested=False) as colour:
                with f.loop(colour, self.size, colours, tested=False) as p:
                    row = self.coordinate(f, p) + shift
                    x = f.load("%work", row + self.areas["point"])
                    least = f.larger(f.magnitude(x), f.constant(SMALL))
                    moved = x + f.function("sqrt", least * DIFFERENCE)
                    f.store(moved, "%work", row + at.state)
                    f.store(moved - x, "%work", p + self.areas["differences"])
                rates, _ = self._evaluate(f, t, state, work)
                change = self._changes(f, rates)
                with f.loop(colour, self.size, colours, tested=False) as p:
                    row = self.coordinate(f, p) + shift
                    f.store(f.load("%work", row + self.areas["point"]), "%work", row + at.state)
                    share = f.constant(1.0) / f.load("%work", p + self.areas["differences"])
                    first, last = band.within(f, p)
                    with f.loop(first, last, tested=False) as r:
                        k = self.coordinate(f, r)
                        slope = change(k, r) * share
                        slope = f.select(f.magnitude(slope) < math.inf, slope, f.constant(0.0))
                        f.store(slope, "%work", band.at(r, p) + self.areas[area])
                        if self.coupling.masses is not None:
                            slope = slope * self.coupling.masses.inverse(f, k)
                        square = slope * slope if area == "by_v" else f.magnitude(slope)
                        fastest.set(f.larger(square, fastest.get()))
        self.note(f, fastest.get(), FASTEST, "cache")
        self.note(f, self.noted(f, VERSION), KNOWN, "cache")
        f.give()
        return f

    def _changes(self, f: Function, rates: Pointer) -> Callable[[Integer, Integer], Real]:
        """What gives the change of the rate of a coordinate, or of the force at its row."""

        def change(k: Integer) -> Real:
            return f.load(rates, k) - f.load("%work", k + self.areas["base"])

        masses = self.coupling.masses
        if masses is None:
            return lambda k, row: change(k)
        changes, pushed = self.area(f, "changes"), self.area(f, "pushed")
        with self.in_band(f) as (p, k):
            f.store(change(k), changes, p)
        masses.push(f, changes, pushed)
        return lambda k, row: f.load(pushed, row)

    def factored(self, f: Function, h: Real) -> None:
        """The matrices for steps of ``h``, unless they are there."""
        there = self.noted(f, LENGTH_FACTORED, "cache").equals(h)
        same = self.noted(f, FACTORED, "cache").equals(self.noted(f, VERSION))
        with f.when(~(there & same)):
            self.called(f, "matrices", h)

    def _matrices(self) -> Function:
        """``@matrices(.., h)``: s - B - A/s for both s."""
        f = Function(f"define internal void @matrices{HEAD}, double %h) #0")
        h, band, (real, other) = Real(f, "%h"), self.band, self.growth
        inverse = 1 / other
        shares = [f.splat(h * -share, LANES) for share in (1 / real, inverse.real, inverse.imag)]
        places = self.areas["real"], self.areas["complex"], self.areas["complex"] + band.doubles
        with f.loop(0, band.doubles, LANES, tested=False) as i:
            a, b = (f.load_row("%work", i + self.areas[name], LANES) for name in ("by_q", "by_v"))
            for share, place, rest in zip(shares, places, (True, True, False)):
                value = f.fused(a, share, -b) if rest else a * share
                f.store_row(value, "%work", i + place)
        inverse_h, rates = f.constant(1.0) / h, (real, other.real, other.imag)
        if self.coupling.masses is not None:
            terms = [(f.place("%work", at, "double"), inverse_h * rate) for rate, at in zip(rates, places)]
            self.coupling.masses.add(f, band, terms)
        else:
            with f.loop(0, self.size, tested=False) as p:
                for rate, place in zip(rates, places):
                    index = band.at(p, p) + place
                    f.store(f.fused(inverse_h, rate, f.load("%work", index)), "%work", index)
        f.call(None, "factor_1", self.area(f, "real"))
        f.call(None, "factor_2", self.area(f, "complex"))
        self.note(f, h, LENGTH_FACTORED, "cache")
        self.note(f, self.noted(f, VERSION), FACTORED, "cache")
        f.give()
        return f

    def hand_over(self, f: Function, h: Real, length: Real) -> None:
        layout, point = self.state, self.areas["point"]
        for number in range(LANES):
            f.store(self.noted(f, number), "%state", layout.carried_at + HEADER + number)
        carried = layout.carried_at + BEYOND
        f.copy_rows(("%work", point), ("%state", carried), layout.width, self.lengths.lanes)
