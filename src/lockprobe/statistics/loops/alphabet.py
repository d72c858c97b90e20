"""What has to come back for a trial to loop."""

from __future__ import annotations

from collections.abc import Hashable
from typing import TYPE_CHECKING, Literal, get_args

from lockprobe.foundation.errors import BadValue

if TYPE_CHECKING:
    from lockprobe.trial.record import Trial

__all__ = ["Symbol", "symbols"]

Symbol = Literal["action", "action-outcome", "state-action"]
"""What has to come back for a trial to loop.

* ``action``: the joint. The paper's choice.
* ``action-outcome``: the joint, and whether it truly moved. What the agent was told may differ.
* ``state-action``: the true configuration before the step, and the joint. Such a loop has truly led nowhere.
"""


def symbols(trial: Trial, symbol: Symbol) -> tuple[Hashable, ...]:
    """One symbol per step of a trial. Outcome and state are the true ones, never what the agent was told."""
    if symbol == "action":
        return tuple(step.joint for step in trial.steps)
    if symbol == "action-outcome":
        return tuple((step.joint, step.moved) for step in trial.steps)
    if symbol == "state-action":
        return tuple((step.state, step.joint) for step in trial.steps)
    raise BadValue("symbol", symbol, f"one of {', '.join(get_args(Symbol))}")
