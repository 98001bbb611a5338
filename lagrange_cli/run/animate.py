"""``animate``: the drawing of a motion as a film."""

from __future__ import annotations

import math
import shutil
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.decimals import decimal
from lagrange_cli.errors import FileError, UsageError
from lagrange_cli.figures.film import FORMATS, FRAMES, GIF_PIXELS, film
from lagrange_cli.records import dataclass, replace
from lagrange_cli.run.plot import PlotRequest, drawn, outputs_for
from lagrange_cli.run.reel import FilmRequest, Reel, finer_than, usual_speed
from lagrange_cli.store.find_target import check_folder
from lagrange_cli.store.target import Target, unwritable

if TYPE_CHECKING:
    from collections.abc import Callable

    from lagrange_cli.run.monitor import Interrupted, Progress
    from lagrange_cli.run.motion import Motion
    from lagrange_cli.run.request import Request
    from lagrange_cli.store.notes import Origin, Stamp

SAMPLED = 4
"""Pictures of a film by which its size and the colours of a GIF are known."""


@dataclass(frozen=True)
class Made:
    """A film that was written: how many pictures it has, of how many, and how long it lasts in seconds."""

    pictures: int
    count: int
    seconds: float

    @property
    def whole(self) -> bool:
        """Whether it was not interrupted."""
        return self.pictures == self.count


def format_of(name: str) -> str:
    """The format of a film, which the ending of its name says; a folder has none.

    Raises ``UsageError`` for any other ending.
    """
    suffix = Path(name).suffix.lower()
    if name.endswith(("/", "\\")) or suffix == "":
        return FRAMES
    if suffix not in FORMATS:
        listed = ", ".join(FORMATS)
        raise UsageError(f"--output {name}: the name must end in {listed}, or in / for a folder of pictures")
    return suffix


def request_for(motion: Motion, request: Request, asked: FilmRequest) -> Request:
    """The request of a motion whose samples and outputs are those of a film."""
    settings = motion.settings
    begin = settings.start if asked.begin is None else asked.begin
    end = settings.stop if asked.end is None else asked.end
    speed = asked.speed or usual_speed(abs(end - begin))
    lasts = abs(settings.stop - settings.start)
    spacing = settings.step or lasts / max(1, settings.count - 1)
    finer = finer_than(speed / asked.fps, spacing, math.ceil(abs(end - begin) * asked.fps / speed) + 1)
    step = min(speed / asked.fps / finer, lasts)
    has_particles = not motion.spec.lagrangian
    panels = PlotRequest(asked.panels or ("q", "v"))
    outputs = outputs_for(panels, has_particles=has_particles)
    options = replace(request.options, outputs=outputs, samples=None)
    return drawn(replace(request, options=options, times={**request.times, "step": repr(step)}), panels)


def write(reel: Reel, target: Target, kind: str, progress: Progress, interrupted: Interrupted) -> Made:
    """Write a film to its file, or its pictures into its folder. One that is interrupted ends there.

    Raises ``FileError`` where it cannot be written, and ``UsageError`` where it is too large for its format.
    """
    scene = reel.scene()
    numbers = np.unique(np.linspace(0, reel.count - 1, SAMPLED).round().astype(int))
    sample = np.stack([reel.picture(scene, int(number)) for number in numbers])
    if kind == ".gif" and reel.count * sample[0, ..., 0].size > GIF_PIXELS:
        raise UsageError(
            f"a GIF of {reel.count} pictures is too large: a greater --speed, a lower --fps or a smaller "
            "--size makes it smaller; .mp4 has no such limit"
        )
    done = 0

    def fill(path: Path) -> None:
        nonlocal done
        with film(path, kind, reel.fps, sample) as add:
            for number in range(reel.count):
                add(reel.picture(scene, number))
                done += 1
                progress.show(done)
                if interrupted():
                    break

    try:
        if kind == FRAMES:
            into_folder(target, fill)
        else:
            with target.filled() as path:
                fill(path)
    finally:
        progress.clear()
    return Made(done, reel.count, done / reel.fps)


def into_folder(target: Target, fill: Callable[[Path], None]) -> None:
    """Fill a folder that gets its name when it is complete.

    Raises ``FileError``. Pictures that another process has put there, or changed, in the meantime are kept;
    the message says where the new ones are.
    """
    unfinished = target.temporary
    try:
        shutil.rmtree(unfinished, ignore_errors=True)
        unfinished.mkdir()
        fill(unfinished)
        if target.path.is_dir() and any(target.path.iterdir()) and not target.force:
            refuse_changed(target)
        if target.path.exists():
            shutil.rmtree(target.path)
        unfinished.rename(target.path)
        if target.origin is not None:
            target.origin.note(target.path)
    except FileError:
        raise
    except OSError as error:
        shutil.rmtree(unfinished, ignore_errors=True)
        raise unwritable(target.shown, error) from error
    except BaseException:
        shutil.rmtree(unfinished, ignore_errors=True)
        raise


def refuse_changed(target: Target) -> None:
    """Raise ``FileError`` unless the folder is still the earlier film that this one replaces."""
    if not target.replaceable():
        how = "appeared" if target.replaces is None else "was changed"
        raise FileError(
            f"{target.shown} {how} during this run and was not replaced; "
            f"the new pictures are in {target.temporary}"
        )


def find_folder(name: str, *, force: bool, origin: Origin | None = None) -> Target:
    """The folder for single pictures: a new or an empty one, that of an earlier film of this ``origin`` which
    nobody has changed, or with ``force`` any that holds nothing but such pictures.

    Raises ``FileError`` where it cannot be made.
    """
    import os

    path = Path(os.path.realpath(name))
    replaces: Stamp | None = None
    if path.is_dir():
        others = [one.name for one in path.iterdir() if not (one.suffix == ".png" and one.stem.isdigit())]
        if others:
            raise FileError(f"{name} contains other files ({sorted(others)[0]}): name a new folder")
        if any(path.iterdir()):
            found = "" if origin is None else origin.judge(path)
            if not isinstance(found, str):
                replaces = found
            elif not force:
                raise FileError(f"{name} already exists{found}: --force replaces its pictures")
    elif path.exists():
        raise FileError(f"{name} is a file: a film's name ends in {', '.join(FORMATS)}")
    check_folder(name, path)
    return Target(name, path, force, origin=origin, replaces=replaces)


def told(reel: Reel, made: Made) -> str:
    """The description of a film: ``600 pictures, 20 s, t goes at 3 d a second``."""
    unit = f" {reel.unit}" if reel.unit else ""
    real = reel.speed == 1 and reel.unit in ("", "s")
    pace = "in real time" if real else f"t advances by {decimal(reel.speed)}{unit} a second"
    many = f"{made.pictures} picture{'s' * (made.pictures != 1)}"
    return f"{many}, {decimal(made.seconds, 3)} s, {pace}"
