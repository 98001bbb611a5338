"""``section``: where motions cross a surface."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from lagrange_cli.api.ensembles import ended, noted, watching
from lagrange_cli.api.folder import Folder
from lagrange_cli.api.given import Value, Values, check_lengths, count_of, request_of, text_of
from lagrange_cli.api.kept import WORKING
from lagrange_cli.api.members import Over, Random, Table, draws_of, threads_of
from lagrange_cli.api.solve import check_precision
from lagrange_cli.api.stored import Stored, stored
from lagrange_cli.api.system import System, content_of
from lagrange_cli.api.words import in_python
from lagrange_cli.errors import UsageError
from lagrange_cli.integrate.precision import DOUBLE
from lagrange_cli.run.derive import read_run
from lagrange_cli.run.ensembles.draws import draw_members
from lagrange_cli.run.sections.request import CROSSINGS, DIRECTIONS, SectionRequest, make_section
from lagrange_cli.run.sections.section import Crossed, take_section


class Section(Stored):
    """The crossings of a surface by one motion or many, as the command writes them to a file.

    Arrays have the crossings along their last axis, after the dimensions of the members if there are many
    motions; they are read when they are asked for, and cannot be written to.

    Attributes
    ----------
    t : ndarray
        The times of the crossings.
    q, v, p : Group
        Coordinates, velocities and momenta there, by name.
    status, message : str
        How it ended, as the command says it.
    notes : tuple of str
        The other messages of the command.
    """

    def __init__(self, folder: Folder, crossed: Crossed, notes: tuple[str, ...]) -> None:
        super().__init__(folder, notes)
        self._crossed = crossed

    @property
    def crossings(self) -> int:
        """The number of crossings of all motions."""
        return self._crossed.crossings

    def __repr__(self) -> str:
        return f"<section of {self.name}: {self.message}>"


@in_python
def section(
    system: System,
    *,
    where: str | None = None,
    every: Value | None = None,
    direction: str | None = None,
    crossings: int = CROSSINGS,
    over: Over | None = None,
    random: Random | None = None,
    table: Table | None = None,
    members: int | None = None,
    seed: int = 0,
    set: Values | None = None,
    size: Mapping[str, int | str] | None = None,
    start: Value | None = None,
    stop: Value | None = None,
    tolerance: float | None = None,
    method: str | None = None,
    outputs: str | Iterable[str] | None = None,
    precision: str = DOUBLE,
    project_initial: bool = False,
    jobs: int | None = None,
    cache: bool = True,
) -> Section:
    """Find where motions cross a surface: Poincare and stroboscopic sections.

    Parameters
    ----------
    system : str, path or mapping
        The name of a system file, its content as text, or its content as a mapping.
    where : str, optional
        The surface: where this expression in coordinates, velocities, t and parameters is 0.
    every : float or str, optional
        In place of ``where``: the states at multiples of this time.
    direction : {"rising", "falling", "either"}, optional
        Which crossings count; by default ``rising``.
    crossings : int
        The number of crossings of each motion.
    over, random, table, members, seed, jobs
        As for ``sweep``; without them the motion is that of the file.
    set, size, start, stop, tolerance, method, outputs, precision, project_initial, cache
        As for ``solve``.

    Returns
    -------
    Section
        Arrays of shape (crossings,), or (..., crossings) after the dimensions of the members.

    Raises
    ------
    SpecError, UsageError, FileError
        As for ``solve``.
    Interrupted
        Ctrl-C was pressed. Its attribute ``result`` has the motions that have ended.
    """
    if (where is None) == (every is None):
        raise UsageError("give either where, as in where='x', or every")
    if every is not None and direction is not None:
        raise UsageError("direction belongs to where: leave it out with every")
    if direction is not None and direction not in DIRECTIONS:
        raise UsageError(f"direction must be one of {', '.join(DIRECTIONS)}, not {direction!r:.60}")
    if where is not None and not (isinstance(where, str) and where.strip()):
        raise UsageError(f"where must be an expression, as in where='x', not {where!r:.60}")
    request = request_of(
        set=set,
        size=size,
        times={"start": start, "stop": stop},
        tolerance=tolerance,
        method=method,
        outputs=outputs,
        precision=precision,
        project_initial=project_initial,
        cache=cache,
    )
    check_precision(request, None)
    period = "" if every is None else text_of("every", every)
    crossings = count_of("crossings", crossings)
    asked = SectionRequest(where or "", period, direction or next(iter(DIRECTIONS)), crossings)
    draws = draws_of(over, random, table, members, seed)
    content, filename = content_of(system)
    with WORKING:
        spec, _ = read_run(content, filename, request.sizes, lambda spec, problems: None)
        check_lengths(spec, set)
        chosen = draw_members(spec, draws, request.overrides) if draws.any else None
        ensemble = make_section(spec, chosen, request, asked)
    told: list[str] = []
    monitor, threads = watching(told), threads_of(jobs)
    folder, crossed = stored(lambda target: take_section(ensemble, target, request, monitor, threads=threads))
    found = Section(folder, crossed, noted(told, ensemble, crossed.outcome))
    return ended(found, crossed.outcome, crossed.message)
