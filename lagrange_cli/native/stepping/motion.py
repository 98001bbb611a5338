"""``Steps``: the parts of a step in one kind of numbers, for the loop of ``@advance``.

Guards, proofs, acceptance, and integrals are the same in all kinds.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from contextlib import nullcontext

from lagrange_cli.native.interface import Stop, records_at
from lagrange_cli.native.llvm.flow import Variable
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.native.state import Clock, whole_vectors
from lagrange_cli.native.stepping.acceptance import Allowance, PredictionBounds, accepted
from lagrange_cli.native.stepping.division import Division
from lagrange_cli.native.stepping.given import Given
from lagrange_cli.native.stepping.guards import GuardCode
from lagrange_cli.native.stepping.lengths import Lengths
from lagrange_cli.native.stepping.noise import Noise
from lagrange_cli.native.stepping.passing import Passing
from lagrange_cli.native.stepping.proof import Margins, Proof, Proving
from lagrange_cli.native.stepping.quadratures import Quadratures
from lagrange_cli.native.stepping.related import allow_rounding, write_floors
from lagrange_cli.native.stepping.static_forces import creeping
from lagrange_cli.native.stepping.step_size import StepSize
from lagrange_cli.native.stepping.steps import Now, clear_function
from lagrange_cli.native.stepping.sums import HighLow, Sums
from lagrange_cli.records import replace

AT_REST = 2.0**-900
"""Where steps are proven, velocities below this do not limit them."""


def again(f: Function, good: Bit, accept: Callable[[], Bit], allow: str, *given: Pointer) -> Bit:
    """Whether a step is ``good``, or one to ``accept`` once more is allowed."""
    found = f.variable(good)
    with f.when(~good):
        f.call(None, allow, *given)
        found.set(accept())
    return found.get()


class Steps(ABC):
    """Steps of numbers of so many ``parts``. A defect up to the part ``small`` of what moves is not told from
    rounding (see ``Proof``); velocities of a size up to ``rest`` do not limit steps. Where numbers are
    ``refined``, more precise than the roots, a step to a root is followed by a much shorter one."""

    parts: int
    small: float
    refined: bool
    division: type[Division] = Division

    def __init__(
        self, given: Given, lengths: Lengths, bounds: PredictionBounds, sums: Sums, rest: float
    ) -> None:
        self.given, self.state, self.sums = given, given.state, sums
        self.constrained = bool(given.project)
        self.mutual = self.constrained or given.jointed
        """Whether the accelerations of what rests may be rounding errors of other ones."""
        self.in_two, self.bounds = given.in_two, bounds.coarser(given.tolerance).timed(given.timed)
        arguments, first = given.guards.arguments if given.guards else 0, given.state.integrals.start
        silent = arguments + sum(given.shown)  # these integrals have no say
        rows = first + silent, given.state.quadratures - silent
        self._multipliers = first + arguments, given.shown[0]
        self.lengths = lengths = replace(lengths, apart=rows[1] > 0)
        self.related: Sequence[tuple[int, int]] = [
            one for one in given.related if one[0] < given.state.degrees
        ]
        self.alike = [one for one in given.related if one[0] >= given.state.degrees]
        """Velocities and integrals that are measured by the largest one of their family, too."""
        self.noise = self._noise()
        self.sizes = StepSize(
            lengths, given.tolerance, rest, fades=self.parts == 1,
            uncertain=(self.noise.place, 1.0) if self.noise and not self.noise_is_floor else None,
        )  # fmt: skip
        self.quadratures = None
        if rows[1]:
            self.quadratures = Quadratures(
                lengths, *rows, given.tolerance, self.bounds, beyond=sums.beyond,
                rest=AT_REST if given.proving[1] else 0.0, known=self.state.errors,
                related=self.alike,
            )  # fmt: skip
        records = records_at(given.state, given.work, self.parts)
        self.guards = None
        if given.guards:
            places = given.guards, given.state, lengths, records
            self.guards = GuardCode(*places, near=given.near, alone=given.alone, idle=given.idle)
        self.proof = self._proof("proven", given.proving[0])
        self.integrands = self._proof("integrands_proven", given.proving[1], rows)
        self.arguments = self._proof("arguments_proven", given.proving[2], (first, arguments))

    def _noise(self) -> Noise | None:
        """What finds velocities that are rounding: where there are several coordinates that are measured each
        by itself."""
        if self.state.degrees < 2 or self.given.floors:
            return None
        width = self.state.width
        first, last = whole_vectors(self.state.memory + 3 * width), width if self.parts > 1 else 0
        size = 0.5 * self.bounds.rounding
        given = self.lengths, width, self.state.errors, first, size, last, self.computed
        return Noise(*given, asked=True, beyond=self.sums.beyond)

    def computed(self, f: Function, time: HighLow, unit: Real) -> Bit:
        """Compute the series of the state where they belong."""
        return self.compute(f, time, unit, *self.places(f))

    @property
    def proofs(self) -> Sequence[Proof]:
        """The proof of steps."""
        return [one for one in (self.proof, self.arguments) if one]

    def _proof(self, name: str, proving: Proving | None, integrals: tuple[int, int] = (0, 0)) -> Proof | None:
        if proving is None:
            return None
        small = self.small * max(1.0, self.given.tolerance / self.bounds.precision)
        nothing, low = self.bounds.nothing_much, self.lengths.width
        return proving(
            Margins(self.lengths, low, nothing, small, self.parts, integrals, self._multipliers, name)
        )

    # what differs between kinds of numbers

    @abstractmethod
    def own(self) -> list[Function]:
        """Functions of this kind of numbers."""

    @abstractmethod
    def compute(self, f: Function, time: HighLow, unit: Real, state: Pointer, series: Pointer) -> Bit:
        """Compute the series of a state where others may be; whether the mass matrix is regular."""

    @abstractmethod
    def forget(self, f: Function) -> None:
        """Remove the rest of other series: done first, and after a step that was not accepted."""

    @abstractmethod
    def expand(self, f: Function, now: Now, brief: Callable[[], Bit] | None = None) -> tuple[Now, Bit]:
        """Compute the series, perhaps in a unit of its own; whether the mass matrix is regular. If they are
        ``brief``, nothing but accelerations is needed."""

    @abstractmethod
    def choose(self, f: Function, now: Now, fail: Callable[[Stop], None]) -> tuple[Now, Real, Bit]:
        """The step by its series, perhaps in another unit, and whether all coefficients are finite; ``fail``
        if so many are not that there is none, or if steps lead no further."""

    @abstractmethod
    def vet(self, f: Function, now: Now, h: Real, left: Real, free: Bit) -> Real:
        """The step, or a shorter one, where what its series may not show has been looked for; ``free``: no
        critical point is near."""

    @abstractmethod
    def first_guard(self, f: Function, now: Now, h: Real) -> tuple[Real, Integer, Real]:
        """When a guard is due in a step of ``h``, which one, and how much of the step is known
        (``guards.GuardCode``)."""

    def watch(self, f: Function, now: Now, h: Real) -> None:  # noqa: B027 - most have nothing to do
        """Compute the series of guards' arguments that may be needed in a step of ``h``, where ``expand``
        does not."""

    def arrive(self, f: Function, now: Now, since: Real) -> None:
        """The same where a mode changes. The polynomials of steps that do not expand where they are began so
        long ``since``."""
        self.watch(f, now, f.constant(0.0))

    @abstractmethod
    def straighten(self, f: Function) -> None:
        """Set the coefficients from ``STRAIGHT`` on to 0."""

    @abstractmethod
    def sample(self, f: Function, now: Now, index: Integer, h: Real) -> Integer:
        """Write the samples from ``index`` on that lie within ``h``: the index of the first one beyond."""

    @abstractmethod
    def move(self, f: Function, now: Now, h: Real, final: Bit, allowed: Allowance) -> Real:
        """Go to the end of the step, and write down what is expected there: the place farthest from 0."""

    def sudden(self, f: Function, h: Real) -> Bit | None:
        """Whether a step of ``h`` is far shorter than the one before it let expect; None where none is."""
        return None

    @abstractmethod
    def divide(self, quadratures: Quadratures) -> Function:
        """``@divide``: the integrals of a step by parts (``divided``)."""

    # what does not

    def functions(self) -> list[str]:
        """The functions that its instructions call."""
        made = [*self.sizes.functions(), *self.acceptance(), *self.own()]
        made += [one.function() for one in (*self.proofs, self.integrands) if one]
        if self.quadratures:
            made += [*self.quadratures.functions(), self.divide(self.quadratures)]
        guards = self.guards.functions() if self.guards else []
        made += [self.noise.function()] if self.noise else []
        made += self.passing()
        return [clear_function(), *self.given.texts, *guards, *(f.text() for f in made)]

    def passing(self) -> list[Function]:
        """What ``@flip`` calls where compiled code finds out whether the motion passes."""
        guards = self.guards
        if not guards or not guards.passing:
            return []

        def compute(f: Function) -> Bit:
            return self.compute(f, self.time(f), f.constant(1.0), *self.places(f))

        return [Passing(guards.rows, self.state, self.lengths, compute, guards.prepare).function()]

    def acceptance(self) -> list[Function]:
        """What ``agree`` calls."""
        coupled = allow_rounding(self.lengths, self.given.coupled, self.bounds.rounding)
        slow = [creeping(self.lengths, self.bounds.nothing_much)] if self.given.static else []
        return [accepted(self.lengths, self.sums.beyond), *coupled, *slow]

    def project(self, f: Function, due: Variable[Integer] | None) -> None:
        """Move the state back to the constraints, if there are any and it is not there; but not where they
        may have jumped with the guard that is ``due``."""
        if not self.given.project:
            return
        broken = self.guards.before_break(f, due.get()) if self.guards and due else None
        with nullcontext() if broken is None else f.when(~broken):
            f.call(None, "project", f.pointer("%constants"), f.pointer("%state"))

    @property
    def noise_at(self) -> int:
        """How far behind velocities it is written how much of their rates is rounding; 0 if that is not."""
        return self.noise.place if self.noise else 0

    @property
    def noise_is_floor(self) -> bool:
        """Whether velocities are measured by at least what rounding changes them, as if they were as fast."""
        return self.parts > 1 and bool(self.lengths.floor)

    def measure(self, f: Function, now: Now) -> None:
        """Compute the least sizes that velocities are measured by, where there are any."""
        if self.noise:
            places = f.pointer("%constants"), *self.places(f), f.pointer("%trial")
            times, always = (now.t, now.low, now.unit), Bit(f, "true")
            with f.when(self.noise.due(f)), f.when(self.noise.call(f, places, times, always)):
                self.forget(f)
            if self.noise_is_floor:
                self.noise.floors(f, now.previous)
            elif self.lengths.floor:
                write_floors(f, self.lengths, self.related)
        else:
            self.floors(f)
        if self.quadratures:
            self.quadratures.measure(f, *self.places(f))

    @property
    def remeasures(self) -> bool:
        """Whether it can be measured how much of the accelerations is rounding where a step ends."""
        return self.noise is not None

    def remeasure(self, f: Function, now: Now) -> Bit:
        """Measure how much of the accelerations is rounding where a step ends, allow it, and compute the
        series there again: whether the mass matrix is regular."""
        assert self.noise
        self.noise.ask(f)
        self.forget(f)
        _, regular = self.expand(f, now)
        self.noise.allow(f, self.expected(f)[1], f.pointer("%trial"))
        return regular

    def floors(self, f: Function) -> None:
        """The same where they are computed by ``Given.floors``."""
        if self.given.floors:
            place = f.place("%work", self.lengths.floor, "double")
            f.call(None, "floors", f.pointer("%constants"), f.pointer("%state"), place)

    def places(self, f: Function) -> tuple[Pointer, Pointer]:
        """The state, and the series."""
        return f.pointer("%state"), f.pointer("%work")

    def expected(self, f: Function) -> tuple[Pointer, Pointer, Pointer]:
        """Where the accelerations are that are expected, how far off they may be, and their low parts."""
        first, width = self.state.memory, self.state.width
        rates, allowed, low = (f.place("%trial", first + i * width) for i in range(3))
        return rates, allowed, low

    def scaled(self, f: Function, unit: Real, *times: Real) -> list[Real]:
        """Times in the unit of the series."""
        inverse = 1.0 / unit
        return [one * inverse for one in times]

    def time(self, f: Function) -> HighLow:
        """The time of the state."""
        t, low = (f.load("%state", self.state.at(one)) for one in (Clock.TIME, Clock.TIME_LOW))
        return t, low

    def agree(self, f: Function, now: Now, uneven: Real, slack: Real, unexplained: Bit, floor: Real) -> Bit:
        """Whether the accelerations are those expected (``acceptance.accepted``), at least to the rounding
        errors of those that are found together with them, of forces that cancel, and of their directions."""
        rates, allowed, low = self.expected(f)
        given = rates, allowed, uneven, slack, unexplained, floor
        more = (low, 1.0 / now.unit) if self.parts > 1 else ()

        def accept() -> Bit:
            return f.call(Bit, "accepted", f.pointer("%work"), *given, *more)

        good = accept()
        if self.given.coupled:
            good = again(f, good, accept, "allow_rounding", rates, allowed)
        if self.given.static:
            good = again(f, good, accept, "allow_static", *f.pointers("constants", "state"), allowed)
        if self.given.directions:
            good = again(f, good, accept, "allow_directions", *f.pointers("constants", "state"), allowed)
        return good
