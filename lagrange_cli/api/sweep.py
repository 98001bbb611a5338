"""``sweep``: many motions of a system."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from lagrange_cli.api.ensembles import ended, noted, watching
from lagrange_cli.api.folder import Folder
from lagrange_cli.api.given import Value, Values, check_lengths, request_of
from lagrange_cli.api.kept import WORKING
from lagrange_cli.api.members import Over, Random, Table, draws_of, threads_of
from lagrange_cli.api.stored import Stored, stored
from lagrange_cli.api.system import System, content_of
from lagrange_cli.api.words import in_python, python_words
from lagrange_cli.errors import UsageError
from lagrange_cli.run.derive import read_run
from lagrange_cli.run.ensembles.contents import how_they_ended
from lagrange_cli.run.ensembles.draws import draw_members
from lagrange_cli.run.ensembles.ensemble import make_ensemble
from lagrange_cli.run.ensembles.sweep import Swept
from lagrange_cli.run.ensembles.sweep import sweep as sweep_ensemble
from lagrange_cli.run.events import notes_of_members
from lagrange_cli.run.source import count_of


class Sweep(Stored):
    """Many motions, as the command writes them to a file.

    Arrays begin with the dimensions of the members, ``dims``, and are read when they are asked for; they
    cannot be written to.

    Attributes
    ----------
    q, v, p : Group
        Coordinates, velocities and momenta by name: ``swept.q["theta"]``, at the end of each motion, or at
        all sample times ``t`` if outputs were named.
    h : ndarray
        The energy function.
    status, message : str
        How it ended, as the command says it.
    notes : tuple of str
        The other messages of the command.
    """

    def __init__(self, folder: Folder, swept: Swept, notes: tuple[str, ...]) -> None:
        super().__init__(folder, notes)
        self._ensemble = swept.ensemble

    @property
    def dims(self) -> dict[str, Any]:
        """What the members span: the swept names with their values, or with a count (``draw``, ``row``)."""
        axes = self._ensemble.members.axes
        return dict(axes) if axes else {"member": self._ensemble.values.members}

    @property
    def members(self) -> int:
        """The number of members."""
        return self._ensemble.values.members

    @property
    def statuses(self) -> Any:
        """The status of each member: ``complete``, ``stopped``, ``failed`` or ``interrupted``."""
        return self["status"]

    def __repr__(self) -> str:
        shape = python_words(self._ensemble.members.in_words)
        return f"<sweep of {self.name}: {count_of(self.members, 'member')} ({shape}), {self.message}>"


@in_python
def sweep(
    system: System,
    *,
    over: Over | None = None,
    random: Random | None = None,
    table: Table | None = None,
    members: int | None = None,
    seed: int = 0,
    set: Values | None = None,
    size: Mapping[str, int | str] | None = None,
    start: Value | None = None,
    stop: Value | None = None,
    samples: int | None = None,
    step: Value | None = None,
    tolerance: float | None = None,
    method: str | None = None,
    outputs: str | Iterable[str] | None = None,
    proven: bool = False,
    project_initial: bool = False,
    jobs: int | None = None,
    cache: bool = True,
) -> Sweep:
    """Follow many motions of a system, which differ in parameters or initial values.

    Parameters
    ----------
    system : str, path or mapping
        The name of a system file, its content as text, or its content as a mapping.
    over : mapping, optional
        Values by name, to be combined with each other: a sequence, or a text such as ``"0:3:31"`` or
        ``"log:0.1:10:5"``.
    random : mapping, optional
        Distributions by name: ``("normal", 0, 0.1)`` or ``"normal(0,0.1)"``; also ``uniform``, ``lognormal``
        and ``loguniform``.
    table : mapping, data frame, structured array or path, optional
        Columns by name, or the name of a CSV file: a motion for each row.
    members : int, optional
        The number of random draws, at each point of the grid.
    seed : int
        The seed of the random numbers.
    outputs : sequence of str, optional
        The outputs that are sampled. Without it there is only the final state of each motion.
    jobs : int, optional
        The number of processors; the results do not depend on it.
    set, size, start, stop, samples, step, tolerance, method, proven, project_initial, cache
        As for ``solve``.

    Returns
    -------
    Sweep
        Members that failed have the status ``failed`` in ``statuses``, and there is a warning.

    Raises
    ------
    SpecError, UsageError, FileError
        As for ``solve``.
    Interrupted
        Ctrl-C was pressed. Its attribute ``result`` has the members that have ended.

    Warns
    -----
    LagrangeWarning
        The warnings that the command prints; also if members have failed.
    """
    request = request_of(
        set=set,
        size=size,
        times={"start": start, "stop": stop, "step": step},
        samples=samples,
        tolerance=tolerance,
        method=method,
        outputs=outputs,
        proven=proven,
        project_initial=project_initial,
        cache=cache,
    )
    if outputs is None and (samples is not None or step is not None):
        raise UsageError("without outputs there is only the end of each motion: add outputs=['q', 'v']")
    if not over and not random and table is None:
        raise UsageError(
            "no members given: add over={'theta': [0.1, 0.2]}, random=... with members, or table=..."
        )
    draws = draws_of(over, random, table, members, seed)
    content, filename = content_of(system)
    with WORKING:
        spec, _ = read_run(content, filename, request.sizes, lambda spec, problems: None)
        check_lengths(spec, set)
        ensemble = make_ensemble(spec, draw_members(spec, draws, request.overrides), request)
    told: list[str] = []
    monitor, threads = watching(told), threads_of(jobs)
    folder, swept = stored(lambda target: sweep_ensemble(ensemble, target, request, monitor, threads=threads))
    assert swept.outcome is not None
    silent = [name for name, count in swept.events.items() if not count]
    told += [f"{spec.name}: event '{name}' did not occur in any member" for name in silent]
    told += [f"{spec.name}: {note}" for note in notes_of_members(swept.outcome.doubtful)]
    found = Sweep(folder, swept, noted(told, ensemble, swept.outcome))
    return ended(found, swept.outcome, how_they_ended(ensemble, swept.outcome))
