"""Checkpoints of many motions: members that have ended are in the file, and are not followed again."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    import numpy as np

    from lagrange_cli.integrate.ensemble.outcome import EnsembleOutcome
    from lagrange_cli.run.resume import Start
    from lagrange_cli.store.checkpoint import Checkpoint
    from lagrange_cli.store.ensemble import EnsembleWriter


@dataclass(frozen=True)
class MembersKept:
    """The checkpoints of a run of so many ``members`` to a file."""

    start: Start
    writer: EnsembleWriter
    members: int

    def checkpoint(
        self, outcome: EnsembleOutcome, further: Mapping[str, np.ndarray], *, inside: bool = False
    ) -> Checkpoint:
        """That of members that have ended so, with ``further`` arrays."""
        from lagrange_cli.integrate.ensemble.outcome import UNFINISHED

        ended = outcome.endings != UNFINISHED
        content = {"outcome": outcome.as_data(), "regions": self.writer.regions(ended)}
        reached = self.members - outcome.count("interrupted")
        arrays = {"endings": outcome.endings, **further}
        return self.start.checkpoint({"reached": reached, **content}, arrays, inside=inside)

    def restored(self) -> EnsembleOutcome | None:
        """How members had ended in the run that this one continues, if there is one; their numbers are put
        into the file. Raises ``Unusable``."""
        from lagrange_cli.integrate.ensemble.outcome import UNFINISHED, EnsembleOutcome
        from lagrange_cli.store.checkpoint import damaged

        earlier = self.start.earlier
        if earlier is None:
            return None
        head, endings = earlier.checkpoint.head, earlier.checkpoint.arrays.get("endings")
        try:
            begin = EnsembleOutcome.from_data(head.get("outcome"), endings, self.members)
        except ValueError as error:
            raise damaged(earlier.shown) from error
        self.writer.restore(earlier, begin.endings != UNFINISHED)
        return begin
