"""What agents and plants said of themselves in the trials on record, so that no other one goes by their name."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from lockprobe.agents.outside import SAME_IN_ALL_TRIALS
from lockprobe.foundation.spec import MCP, spec_kind
from lockprobe.trial.record import Fact, Trial

_PLANT_FACTS = ("engine", "renderer")
"""Facts about a plant that its pictures depend on and its spec does not hold."""


class KnownFacts:
    """What is known of agents (model, prompt, runtime) and of plants (engine, renderer) from these trials."""

    def __init__(self, trials: Iterable[Trial] = ()) -> None:
        self._known: dict[tuple[str, str], Fact] = {}
        for trial in trials:
            self.note(trial)

    def note(self, trial: Trial) -> dict[tuple[str, str], tuple[Fact, Fact]]:
        """Add what a trial says, and return what it says otherwise than before: whose fact, and its name -> both."""
        found, own, plant = dict[tuple[str, str], tuple[Fact, Fact]](), trial.facts, trial.plant
        if trial.player or spec_kind(trial.agent) == MCP:  # people's devices and clients' connections may differ
            own = {name: own[name] for name in SAME_IN_ALL_TRIALS if name in own and not trial.player}
        shown = {name: plant[name] for name in _PLANT_FACTS if name in plant}
        for who, facts in ((trial.agent, own), (f"the plant {plant.get('plant', '')}", shown)):
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
