"""One sentence for each section of a report, which stands in its heading."""

from __future__ import annotations

from collections.abc import Iterable

from lockprobe.foundation.formatting import first_three
from lockprobe.report.prose.subject import subject_of
from lockprobe.statistics.agent_summary import AgentSummary
from lockprobe.statistics.summary import StudySummary

NO_NUMBERS = "It cannot be computed from these trials."
"""The answer of a section without numbers."""


def section_answers(summary: StudySummary) -> dict[str, str]:
    """Section -> its answer in one sentence; sections without numbers are missing."""
    agents = summary.judged
    if not agents:
        return {}
    found = {
        "hypothesis_tests": _tests(agents),
    }
    return {section: said for section, said in found.items() if said}


def _tests(agents: Iterable[AgentSummary]) -> str:
    """How many tests of each agent reject."""
    done = {
        subject_of(agent).name: [t.rejects for t in agent.inference.tests if t.p_value is not None]
        for agent in agents
        if not agent.blind
    }
    parts = [f"{sum(tests)}/{len(tests)} for {name}" for name, tests in done.items() if tests]
    return f"Tests that reject: {first_three(parts)}." if parts else "Nothing could be tested."
