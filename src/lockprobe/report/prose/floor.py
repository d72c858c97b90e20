"""What the scripted viewer misreads of pictures, beside which the misreading of other agents stands."""

from __future__ import annotations

from lockprobe.foundation.formatting import share
from lockprobe.report.rows import Estimate

NO_FLOOR = (
    "How hard these pictures are to read is not known: --agent viewer adds a scripted reader, whose misreading is the "
    "floor."
)


def floor_said(row: Estimate) -> str:
    """How much the viewer misread, over all pictures of a study."""
    return (
        f"The floor of these pictures: the scripted {row.agent} misread {share(row.value, row.low, row.high)} of "
        f"outcomes ({row.count} of {row.n}) at the acuity that the pictures need. It knows where handles can be, "
        "so the floor leaves out errors of finding them."
    )
