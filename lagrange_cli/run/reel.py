"""``Reel``: the samples of a motion at the times of a film's pictures, and what is drawn of them."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.drawing.draw import draw
from lagrange_cli.drawing.evaluate import extent, fitted
from lagrange_cli.errors import FileError, UsageError
from lagrange_cli.figures.panels import Curve, Panel
from lagrange_cli.figures.scene import Scene, Side
from lagrange_cli.records import dataclass
from lagrange_cli.run.derive import read_run
from lagrange_cli.run.plot import worded
from lagrange_cli.run.plots.motions import Run, opened
from lagrange_cli.run.plots.quantities import with_unit
from lagrange_cli.run.plots.reading import together
from lagrange_cli.run.sampling import read_samples
from lagrange_cli.run.set_parameters import of_output, parameters_along
from lagrange_cli.spec.spec import Spec
from lagrange_cli.spec.values import Values
from lagrange_cli.store.result import Result

if TYPE_CHECKING:
    from lagrange_cli.drawing.along import Along
    from lagrange_cli.drawing.drawing import Drawing

Array = np.ndarray
FINER, FINEST = 4, 64
"""Samples of a trail from one picture to the next: at least, and at most."""
TRAIL = 2.0
"""Seconds of a film that a trail lasts."""
SHORTEST, LONGEST, USUAL = 0.2, 60.0, 20.0
"""A film of so many seconds is in real time; any other one lasts about ``USUAL``."""
MOST_FRAMES = 100_000
MOST_SIDES = 4
PANELS = (
    "q", "v", "p", "phase", "energy", "drift", "action", "ledger", "observables", "reactions", "multipliers",
    "conserved",
)  # fmt: skip
"""Words of ``plot --what`` that are for side panels, too."""
PIECE = 4096
"""Samples whose places are found together."""
FPS = {".gif": 25.0}
"""Pictures a second, where it is not ``USUAL_FPS``; a GIF counts in hundredths of a second."""
USUAL_FPS = 30.0


@dataclass(frozen=True)
class FilmRequest:
    """The request for a film.

    ``speed`` is in units of t a second, ``fps`` are the pictures a second. The film goes from t = ``begin``
    to ``end``, a trail lasts for the time ``trail``. ``panels`` are words for panels beside the drawing,
    ``size`` is in pixels. None stands for the default.
    """

    fps: float
    speed: float | None = None
    begin: float | None = None
    end: float | None = None
    trail: float | None = None
    panels: tuple[str, ...] = ()
    size: tuple[int, int] | None = None


@dataclass(frozen=True)
class Reel:
    """What a film shows: a drawing with its bounds, and the motion q (n, degrees) at the times t (n,).

    From one picture to the next there are ``finer`` samples; ``trail`` is the number of samples in a trail.
    """

    name: str
    unit: str
    speed: float
    fps: float
    drawing: Drawing
    parameters: Along
    t: Array
    q: Array
    trail: int
    finer: int
    sides: tuple[Side, ...]
    size: tuple[int, int]

    @property
    def count(self) -> int:
        """The number of pictures."""
        return (len(self.t) - 1) // self.finer + 1

    def scene(self) -> Scene:
        """What draws the pictures."""
        return Scene(self.drawing, self.parameters, self.name, *self.size, self.sides, self.unit)

    def picture(self, scene: Scene, number: int) -> Array:
        """The picture (height, width, 3) of that number."""
        last = number * self.finer
        part = slice(max(0, last - self.trail), last + 1)
        return np.ascontiguousarray(scene.frame(self.t[part], self.q[part])[:, :, :3])


def usual_speed(duration: float) -> float:
    """Units of t a second: 1, unless the film would be too short or too long; then 1, 2 or 5 times a power of
    ten, so that it lasts about ``USUAL`` seconds."""
    if SHORTEST <= duration <= LONGEST or duration == 0:
        return 1.0
    wanted = duration / USUAL
    power = 10.0 ** math.floor(math.log10(wanted))
    return min((1.0, 2.0, 5.0, 10.0), key=lambda one: abs(math.log(one * power / wanted))) * power


def finer_than(step: float, spacing: float, count: int) -> int:
    """Samples of a trail from one of ``count`` pictures to the next: with the time ``step`` between these, as
    many as the motion has at distances of ``spacing``, so that trails of fast films are curves."""
    wanted = math.ceil(step / spacing * (1 - 1e-9)) if spacing > step / FINEST else FINEST
    return max(FINER, min(wanted, MOST_FRAMES * FINER // count))


def read_system(result: Result) -> tuple[Spec, dict[str, float]]:
    """The system of an output, and its parameters.

    Raises ``UsageError`` where the output is not that of one motion.
    """
    if result.kind != "motion":
        what = "the motions of a sweep" if result.kind == "sweep" else "a section"
        way = "; --member of 'lagrange animate' chooses one" if result.kind == "sweep" else ""
        raise UsageError(f"{result.name} contains {what}: animate shows one motion{way}")
    told = result.attributes
    try:
        sizes = {name: str(int(n)) for name, n in json.loads(str(told.get("sizes", "{}"))).items()}
        parameters = {name: float(x) for name, x in json.loads(str(told["parameters"])).items()}
        text = str(told["spec"]).encode()
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise FileError(f"{result.name} is damaged: what made it cannot be read") from error
    spec, _ = read_run(text, result.name, sizes, lambda spec, problems: None)
    return spec, parameters


def reel_of(result: Result, asked: FilmRequest) -> Reel:
    """The reel of an output.

    Raises ``UsageError`` for what cannot be shown, and ``FileError`` for what cannot be read.
    """
    spec, given = read_system(result)
    parameters = parameters_along(of_output(result), spec, given)
    samples, (begin, end) = read_samples(result, spec, asked.begin, asked.end)
    duration = abs(end - begin)
    speed = asked.speed or usual_speed(duration)
    step = speed / asked.fps
    count = math.floor(duration / step * (1 + 1e-12)) + 1
    if count > MOST_FRAMES:
        raise UsageError(
            f"{count} pictures are too many (up to {MOST_FRAMES}): a greater --speed or a lower --fps "
            "makes fewer, --from and --to choose a part"
        )
    direction = -1.0 if end < begin else 1.0
    spacing = abs(float(samples.t[-1] - samples.t[0])) / max(1, len(samples.t) - 1)
    finer = finer_than(step, spacing, count)
    t: Array = begin + direction * step / finer * np.arange((count - 1) * finer + 1)
    q = samples.at(t)
    values = Values(given, tuple(q[0].tolist()), tuple(samples.v[0].tolist()))
    drawing = draw(spec, values, float(t[0]))
    seen = None
    for first in range(0, len(t), PIECE):
        part = slice(first, first + PIECE)
        found = extent(drawing, t[part], q[part], parameters)
        seen = found if seen is None else seen.joined(found)
    assert seen is not None
    sides = side_panels(opened(result), asked.panels)
    lasts = TRAIL * speed if asked.trail is None else asked.trail
    size = asked.size or ((1200, 600) if sides else (800, 600))
    trail = min(round(lasts / step * finer), len(t))
    unit, drawing = result.held["t"].unit, fitted(drawing, seen, parameters)
    return Reel(spec.name, unit, speed, asked.fps, drawing, parameters, t, q, trail, finer, sides, size)


def side_panels(run: Run, words: Sequence[str]) -> tuple[Side, ...]:
    """The panels of these words, with the whole motion of the output."""
    found: list[Side] = []
    for word in words:
        if word not in PANELS:
            raise UsageError(f"--panels {word}: there is no such panel; known: {', '.join(PANELS)}")
        found += [side(run, panel) for panel in worded([run], (word,), "--panels")]
    if len(found) > MOST_SIDES:
        raise UsageError(f"--panels: {len(found)} panels are too many beside a drawing (up to {MOST_SIDES})")
    return tuple(found)


def side(run: Run, panel: Panel) -> Side:
    """A panel of a plot beside a drawing."""
    over_time = panel.x == with_unit("$t$", run.time.unit)
    times = None if over_time else together(run.result, [run.time])[0][0]
    curves = [one for one in panel.items if isinstance(one, Curve)]
    return Side(
        panel.title, panel.x, panel.y,
        tuple((one.x if times is None else times, one.x, one.y, one.label) for one in curves),
    )  # fmt: skip
