"""The arms of the study of controls, which a study plays and its analysis finds."""

from __future__ import annotations

from collections.abc import Mapping

__all__ = ["ARMS", "ON_REQUEST"]

ARMS: Mapping[str, str] = {
    "truth": "truth",
    "lie": "flip?p={p:g}",
    "retracted": "correction?p={p:g}",
    "confirmed": "correction?p={p:g}&of=truth",
    "remark": "distract?p={p:g}&luck=flip",
    "lie + remark": "flip?p={p:g} + distract?p={p:g}&luck=flip",
    "withheld": "drop?p={p:g}&luck=flip",
    "tremble": "tremble?p={p:g}&luck=flip",
    "nudge": "nudge",
}
"""Arm -> its condition at the rate p: a report is inverted; inverted and corrected; told twice, truly; followed by an
irrelevant sentence; missing; another joint is attempted than chosen; a sentence names an action loop."""

ON_REQUEST: Mapping[str, str] = {
    "lie in loops": "flip?p={p:g}&while=looping",
    "self-yoked": "yoked?p={p:g}&how=looping",
}
"""Two more arms, which are named as conditions: a report is inverted only where the agent is in an action loop; as many
reports of the same agent are inverted at random steps. They tell the least of all arms (``docs/why.md``)."""
