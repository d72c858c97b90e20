"""Whose trial a key names: calls are kept by key, and money is counted by agent."""

from __future__ import annotations

from lockprobe.interventions.condition import MODALITIES
from lockprobe.spec import spec_name
from lockprobe.studies.study import Study

__all__ = ["Owners"]


class Owners:
    """Whose trial a key names.

    Args:
        study: The study.
    """

    def __init__(self, study: Study) -> None:
        self._study = f"{study.name}/"
        self._of_flips = study.of_flips
        self._shows = study.names_modalities
        shown = [f"/{modality}" for modality in study.modalities] if self._shows else [""]
        self._agents = {f"{spec}{how}": spec for spec in study.agents for how in shown}

    def of(self, key: str) -> str:
        """The agent. Specs hold slashes; one of another study counts as what stands in its place."""
        if not self._of_flips:
            return key.removeprefix(self._study).rpartition("/rep=")[0].rpartition("/")[0] or key
        named = key.removeprefix(self._study).rpartition("/p=")[0]
        if named in self._agents:
            return self._agents[named]
        agent, _, how = named.rpartition("/")
        return (agent if self._shows and spec_name(how) in MODALITIES else named) or key
