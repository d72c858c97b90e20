"""What agents and plants said of themselves in the trials on record, so that no other one goes by their name."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from lockprobe.agents.outside import SAME_IN_ALL_TRIALS
from lockprobe.foundation.spec import MCP, spec_kind
from lockprobe.trial.record import Fact, Trial

_PLANT_FACTS = ("engine", "renderer")
"""Facts about a plant that its pictures depend on and its spec does not hold."""


def lasting_facts(trial: Trial) -> Mapping[str, Fact]:
    """The facts of an agent that are the same in all its trials; people's devices and connections may differ."""
    if trial.player:
        return {}
    if spec_kind(trial.agent) == MCP:
        return {name: trial.facts[name] for name in SAME_IN_ALL_TRIALS if name in trial.facts}
    return trial.facts


class KnownFacts:
    """What is known of agents (model, prompt, runtime) and of plants (engine, renderer) from these trials."""

    def __init__(self, trials: Iterable[Trial] = ()) -> None:
        self._known: dict[tuple[str, str], Fact] = {}
        for trial in trials:
            self.note(trial)

    def note(self, trial: Trial) -> dict[tuple[str, str], tuple[Fact, Fact]]:
        """Add what a trial says, and return what it says otherwise than before: whose fact, and its name -> both."""
        plant = {name: trial.plant[name] for name in _PLANT_FACTS if name in trial.plant}
        found = dict[tuple[str, str], tuple[Fact, Fact]]()
        for who, facts in ((trial.agent, lasting_facts(trial)), (f"the plant {trial.plant.get('plant', '')}", plant)):
            found |= self.differences(who.rstrip(), facts) if facts else {}
            for name, value in facts.items():
                if value is not None:  # a renderer, for one, is known only after a picture
                    self._known.setdefault((who.rstrip(), name), value)
        return found

    def differences(self, who: str, facts: Mapping[str, Fact]) -> dict[tuple[str, str], tuple[Fact, Fact]]:
        """The facts of an agent, or of a plant, that are known with another value, with both."""
        known = {name: self._known.get((who, name)) for name in sorted(facts)}
        return {
            (who, name): (value, facts[name])
            for name, value in known.items()
            if value is not None and facts[name] is not None and value != facts[name]
        }
