"""The sentence on an agent's action loops against chance."""

from __future__ import annotations

from collections.abc import Mapping

from lockprobe.foundation.formatting import percent
from lockprobe.report.prose.doses import at_dose
from lockprobe.report.prose.success import of_trials
from lockprobe.statistics.agent_summary import AgentSummary
from lockprobe.statistics.behaviour import Behaviour
from lockprobe.statistics.loops.against_chance import ChanceVerdict, against_chance, chance_range

LOOP_DEFINITION = "Action loop: three or more attempts in a row that occur twice without overlap."
"""What the word means, for readers."""


def loop_finding(agent: AgentSummary) -> str:
    """An agent's loop rate against chance, at its lowest dose and at the dose of its contrast."""
    counted = [condition for condition in agent.conditions if condition.success.n]
    shown = [agent.contrast.baseline, agent.contrast.other] if agent.contrast else counted[:1]
    said = "; ".join(
        f"{of_trials(condition.behaviour.loops)} {at_dose(condition.dose, agent.axis)} "
        f"({_against_chance(condition.behaviour)})"
        for condition in shown
    )
    return f"Action loops occur in {said}." if said else ""


_VERDICTS: Mapping[ChanceVerdict, str] = {
    "more": "more than by chance",
    "less": "less than by chance",
    "not detected": "no difference from chance detected",
}


def _against_chance(found: Behaviour) -> str:
    low, high = chance_range(found)
    between = f"random actions in trials of the same lengths: {percent(low)} to {percent(high)}"
    return f"{_VERDICTS[against_chance(found)]}; {between}"
