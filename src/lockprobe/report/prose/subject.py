"""Who a sentence is about: an agent by its spec, or people in the plural."""

from __future__ import annotations

from dataclasses import dataclass

from lockprobe.foundation.formatting import capital
from lockprobe.foundation.spec import PEOPLE
from lockprobe.statistics.conditions.modalities import spoken
from lockprobe.trial.record import PLAIN_WORDS


@dataclass(frozen=True, slots=True, kw_only=True)
class Subject:
    """The grammatical subject of a sentence.

    Attributes:
        name: What a sentence calls it: ``llm:local (RGB)`` or ``people``.
        plural: Whether its verbs are in the plural.
    """

    name: str
    plural: bool = False

    @classmethod
    def of(cls, agent: str, shown: str = "") -> Subject:
        """The subject that stands for an agent.

        Args:
            agent: Its name, or its spec if it has none.
            shown: How the box was shown, where that has to be said.
        """
        plural = agent == PEOPLE
        name = "people" if plural else agent
        return cls(name=f"{name} ({shown})" if shown else name, plural=plural)

    @classmethod
    def seeing(cls, agent: str, modality: str) -> Subject:
        """The subject that stands for an agent in a modality, which is said unless it is plain words."""
        return cls.of(agent, "" if modality in PLAIN_WORDS else spoken(modality))

    def form(self, one: str, many: str) -> str:
        """The form of a word that agrees with it."""
        return many if self.plural else one

    @property
    def first(self) -> str:
        """Its name at the beginning of a sentence; a spec stays as it is.

        >>> Subject.of("participant").first, Subject.of("random").first
        ('People', 'random')
        """
        return capital(self.name) if self.plural else self.name
