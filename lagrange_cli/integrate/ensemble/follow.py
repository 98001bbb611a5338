"""Every member of an ensemble followed, part by part."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.arrays import Array
from lagrange_cli.integrate.checkpoint import UNKEPT, Checkpointing
from lagrange_cli.integrate.ensemble.datasets import MEMORY, EnsembleDatasets, unexplained
from lagrange_cli.integrate.ensemble.method import EnsembleMethod, Section, Starts
from lagrange_cli.integrate.ensemble.outcome import EnsembleOutcome
from lagrange_cli.integrate.methods.table import METHODS
from lagrange_cli.integrate.prepared import Prepared
from lagrange_cli.integrate.times import Times

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.integrate.ensemble.datasets import Emit, Explain
    from lagrange_cli.integrate.ensemble.method import EnsembleMethod, Kept
    from lagrange_cli.integrate.method import Method
    from lagrange_cli.native.interface import Interface
    from lagrange_cli.spec.ensemble import EnsembleValues, Number
    from lagrange_cli.spec.spec import Family

FEWEST = 512
"""Members that are laid out at least, however large they are."""


def follow_ensemble(
    prepared: Prepared,
    method: EnsembleMethod,
    values: EnsembleValues,
    families: Sequence[Family],
    times: Times,
    emit: Emit,
    interrupt: Callable[[float], bool],
    *,
    sampled: bool,
    threads: int,
    checkpointing: Checkpointing[EnsembleOutcome] | None = None,
    section: Section | None = None,
    chosen: NDArray[np.bool_] | None = None,
    explain: Explain = unexplained,
) -> EnsembleOutcome:
    """Follow every member of ``values``; ``emit`` gets members (b,) and, by path, what they gave: (b, ...).

    Each member is given its start once, and once all the rest: of the outputs all samples (b, n, *shape) if
    ``sampled``, else their values at the end (b, *shape). A member that is interrupted gets nan. ``families``
    are those of the coordinates. ``interrupt`` gets the number of members that have ended, and the parts of
    those on their way, several times a second; True stops them all. The arrays are valid during the call
    only. Datasets of crossings of events have as many rows as there are, and say to which members they
    belong. With ``checkpointing``, members that an earlier run has followed to their end are not followed
    again; only their start is emitted. Samples are those of the ``section``, if there is one. If some members
    are ``chosen`` (members,), only these are followed. ``explain`` says what in the system ended the motion
    of a member that could not go on.
    """
    program = prepared.machine.program
    datasets = EnsembleDatasets(
        prepared, times, emit, sampled=sampled, members=values.members, section=section, chosen=chosen,
        explain=explain,
    )  # fmt: skip
    if checkpointing is not None and checkpointing.begin is not None:
        datasets.restore(checkpointing.begin)
    size = max(FEWEST, MEMORY // (8 * (len(program.parameters) + program.rows)))
    going = True
    for start in range(0, values.members, size):
        part = slice(start, min(start + size, values.members))
        emit(np.arange(part.start, part.stop, dtype=np.int64), start_of(values, families, part))
        parameters, states = starts_of(values, program, part)
        datasets.open(start, parameters, states)
        datasets.refuse([member for member in values.refused if part.start <= member < part.stop])
        missing = datasets.missing()
        if going and len(missing):

            def told(done: float, before: int = part.stop - len(missing)) -> bool:
                if checkpointing is not None and checkpointing.due(before + int(done)):
                    datasets.flush()
                    checkpointing.keep(datasets.outcome(), before + int(done))
                return interrupt(before + done)

            own = None if section is None else section.only(part)
            starts = Starts(parameters, states, times, sampled, own).only(missing)
            going = method.follow(starts, datasets.accept, told, threads)
        datasets.close()
    return datasets.outcome()


def starts_of(values: EnsembleValues, program: Interface, part: slice) -> tuple[Array, Array]:
    """The parameters of some members (b, P), and their states (b, rows)."""
    zeros = [0.0] * len(program.integrals)
    parameters = [one.parameters[name] for one in values.parts for name in program.parameters]
    return table(parameters, part), table([x for one in values.parts for x in (*one.q, *one.v, *zeros)], part)


def table(columns: Sequence[Number], part: slice) -> Array:
    """The rows ``part`` of columns that are one number, or one for each member: (b, columns)."""
    found = np.empty((part.stop - part.start, len(columns)))
    for i, column in enumerate(columns):
        found[:, i] = column[part] if isinstance(column, np.ndarray) else column
    return found


def start_of(values: EnsembleValues, families: Sequence[Family], part: slice) -> dict[str, Array]:
    """What differs between the parameters of the members ``part``, and their initial states."""
    found = {f"parameters/{name}": column[part] for name, column in values.differing.items()}
    for kind, state in (("q", values.q), ("v", values.v)):
        row = 0
        for family in families:
            columns = state[row : row + len(family.members)]
            found[f"initial/{kind}/{family.name}"] = table(columns, part).reshape(-1, *family.shape)
            row += len(family.members)
    return found


def ensemble_method(
    prepared: Prepared, alone: Callable[[], Method], checkpointing: Checkpointing[Kept] | None = None
) -> EnsembleMethod:
    """The method of ``prepared`` for many motions: eight at once, or each alone. ``alone`` makes that of
    single ones where it is needed. The only motion of a section may have checkpoints, by
    ``checkpointing``."""
    if prepared.machine.follow is not None:
        from lagrange_cli.integrate.ensemble.lanes import LanesMethod

        return LanesMethod(prepared.machine, alone, prepared.compilation.backward, checkpointing)
    from lagrange_cli.integrate.ensemble.one_by_one import OneByOne

    names = tuple(name for group in prepared.recording.events for name in group.members)
    parallel = METHODS[prepared.compilation.method].parallel
    return OneByOne(prepared.follower, parallel, names, checkpointing or UNKEPT)
