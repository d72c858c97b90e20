"""What an agent is asked and told in a step besides the report."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

Ask = Literal["before", "after", "off"]
"""When an agent is asked how the box works: before it chooses, after it has chosen, or never."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Briefing:
    """The requests and remarks of one step, in addition to the report. Agents that read no words ignore them.

    ``remark`` comes with the report of this step, ``warning`` stands in the instruction. ``instruction`` is a template
    (:data:`lockprobe.agents.prompt.FIELDS`), and the default one if it is empty.
    """

    remark: str = ""
    warning: str = ""
    instruction: str = ""
    hypothesis: Ask = "before"

    def remarking(self, text: str) -> Briefing:
        """The briefing with one more remark."""
        return replace(self, remark=f"{self.remark} {text}".lstrip())

    def warning_of(self, text: str) -> Briefing:
        """The briefing with one more warning."""
        return replace(self, warning=f"{self.warning} {text}".lstrip())
