"""``Start``: whether a run starts at the beginning, continues an earlier one, or has nothing left to do."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from lagrange_cli.errors import FileError
from lagrange_cli.records import dataclass, replace
from lagrange_cli.run.request import HDF5

if TYPE_CHECKING:
    from lagrange_cli.run.monitor import Monitor
    from lagrange_cli.run.request import Request
    from lagrange_cli.store.checkpoint import Checkpoint
    from lagrange_cli.store.resume import Earlier, Finished
    from lagrange_cli.store.target import Target


@dataclass(frozen=True)
class Start:
    """The output of a run, the attributes that say what makes it, and how it starts.

    It continues the ``earlier`` run, or ``extends`` it to a later stop time. If there is a ``finished`` one,
    nothing is left to do.
    """

    target: Target
    made_by: Mapping[str, Any]
    earlier: Earlier | None = None
    finished: Finished | None = None
    extends: bool = False

    @property
    def replaced(self) -> bool:
        """Whether an earlier output of this system file is replaced, and not the one that is continued."""
        continued = self.earlier is not None and self.earlier.part < 0
        return self.target.replaced and not continued

    @property
    def reached(self) -> Any:
        """The time, or the number of members, that the earlier run reached; None if there is none."""
        return None if self.earlier is None else self.earlier.checkpoint.head["reached"]

    def checkpoint(
        self, content: Mapping[str, Any], arrays: Mapping[str, Any], *, inside: bool
    ) -> Checkpoint:
        """The checkpoint of this run, to stand ``inside`` the output or beside it."""
        from lagrange_cli.store.checkpoint import Checkpoint

        part, replacing = -1 if inside else self.target.part, self.target.force
        run = signature(self.made_by)
        return Checkpoint({"run": run, "part": part, "replace": replacing, **content}, arrays)


def signature(made_by: Mapping[str, Any]) -> dict[str, Any]:
    """All that the bytes of an output depend on: the attributes that say what made it, and the machine unless
    the run is portable."""
    from lagrange_cli.native.compilation.fingerprint import machine

    return {**made_by, **({} if "portable" in made_by else {"machine": machine()})}


def begun(target: Target, made_by: Mapping[str, Any], request: Request, monitor: Monitor) -> Start:
    """How a run starts that writes to a target, which must be claimed, or to a table: see ``take_up``."""
    with monitor.stage("import"):
        if request.format != HDF5:
            return Start(target, made_by)
        return take_up(target, made_by, resume=request.resume, tell=monitor.tell)


def take_up(
    target: Target, made_by: Mapping[str, Any], *, resume: bool, tell: Callable[[str], None]
) -> Start:
    """How the run starts. The target must be claimed.

    If the run is to ``resume`` an earlier one and there is none, ``tell`` is given the reason why it starts
    at the beginning.

    Raises ``FileError`` where there is an earlier run that would be lost, or one that cannot be continued.
    """
    if not resume:
        make_room(target)
        return Start(target, made_by)
    from lagrange_cli.run.extend import run_to_extend, to_extend
    from lagrange_cli.store.resume import Earlier, find_earlier

    run, before = signature(made_by), run_to_extend(target, made_by)
    if before is not None:
        run["run"] = before
    found, why = find_earlier(target, run), "there is nothing to resume"
    if before is not None:
        found, why = to_extend(found), "the earlier run cannot be extended"
        target = replace(target, force=True)
    if isinstance(found, Earlier):
        found.check(run)
        replacing = found.part < 0 or bool(found.checkpoint.head.get("replace"))
        if target.path.exists() and not replacing and target.replaces is None:
            raise FileError(f"{target.shown} is newer than the interrupted run: rename it, then --resume")
        target = replace(target, part=int(found.part == 0), force=replacing, origin=None)
        return Start(target, made_by, earlier=found, extends=before is not None)
    if found is not None and found.attributes.get("status") != "interrupted":
        return Start(target, made_by, finished=found)
    if found is not None:
        why, target = f"{found.attributes['method']} stores no checkpoints", replace(target, force=True)
    tell(f"{target.shown}: {why}; the run starts at the beginning")
    return Start(target, made_by)


def make_room(target: Target) -> None:
    """Remove unfinished files of earlier runs; raises ``FileError`` if one of them can be continued."""
    if not target.checkpoint.exists():
        return
    if not target.force:
        from lagrange_cli.store.resume import unfinished

        if unfinished(target) is not None:
            raise FileError(
                f"{target.shown}: an earlier run was interrupted: --resume continues it, --force starts again"
            )
    target.clear()
